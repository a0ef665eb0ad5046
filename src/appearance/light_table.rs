//! Where light enters the cornea, and how strongly it arrives, for every place of the iris.
//!
//! Enters: the cornea, the iris plane, the studio's lamps in the optics frame. Leaves: a small
//! table for the shader, made anew when the eye has turned: at each texel the refraction function
//! (François et al. 2007, section 5.1) gives the entry point, one Newton step on Snell's law polishes
//! it, and the caustic's Jacobian is taken exactly in f64. Of the measured front of error against
//! time (`ocularium bench`) that is the cheapest way to rounding error, and the picture pays for
//! two look-ups where it would pay for Newton's method twice a pixel.

use super::images::MapView;
use super::shading::smoothstep;
use crate::optics::caustic::caustic_irradiance_at;
use crate::optics::conicoid::conicoid_sag;
use crate::optics::fermat::{FERMAT_STEPS, fermat_entry};
use crate::optics::refraction_function::domain::RefractionEye;
use crate::optics::refraction_function::{RefractionFunction, RefractionSize, RefractionSlice};
use glam::{DVec2, DVec3, DVec4};

/// Texels along each side of one lamp's part of the table.
pub const SIDE: usize = 48;
/// How far from its place (mm) a polished entry may send the light before it is solved anew: outside of
/// its domain the refraction function need not be near anything.
const FARTHEST_LANDING_MM: f64 = 2e-5;
/// Lamps in the table, side by side along u.
pub const LAMPS: usize = 2;
/// The table reaches this far beyond the iris root, as a share of its radius.
pub const REACH: f64 = 1.04;
/// Cosine to the axis below which a lamp is behind the eye's equator and lights no iris.
const LEAST_FACING: f64 = 0.06;

/// What the table is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTableSettings {
    /// Anterior cornea (R, p), mm.
    pub surface: DVec2,
    /// Index behind it.
    pub index: f64,
    /// Depth of the iris plane, mm.
    pub iris_z: f64,
    /// Radius of the iris root, mm.
    pub root_mm: f64,
    /// Radius of the limbus, mm.
    pub limbus_mm: f64,
    /// Unit directions towards the lamps, optics frame.
    pub lamps: [DVec3; LAMPS],
}

/// The light that reaches one place of the iris.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IrisLight {
    /// Unit direction from the iris towards where the light enters, x and y; z is negative.
    pub towards: DVec2,
    /// Irradiance of the iris plane, relative to the lamp's on a plane across its beam, as if the
    /// cornea went on beyond the limbus.
    pub unbounded_irradiance: f64,
    /// Distance from the axis at which the light enters, mm.
    pub entry_radius_mm: f64,
}

impl IrisLight {
    /// Irradiance of the iris plane behind a limbus of this radius: light that would have to enter
    /// outside it meets the sclera. The edge is as soft as the limbus itself.
    pub fn irradiance(&self, limbus_mm: f64) -> f64 {
        let share = smoothstep(limbus_mm + 0.5, limbus_mm - 0.3, self.entry_radius_mm);
        self.unbounded_irradiance * share
    }
}

impl LightTableSettings {
    /// The light of one lamp at a place of the iris plane, mm, exactly.
    pub fn exact(&self, lamp: usize, place: DVec2) -> IrisLight {
        let light = self.lamps[lamp];
        if light.z > -LEAST_FACING {
            return IrisLight::default();
        }
        let point = place.extend(self.iris_z);
        let solved = fermat_entry(point, light, self.surface, self.index, 2 * FERMAT_STEPS);
        if solved.w < 0.5 {
            return IrisLight::default();
        }
        self.light_through(solved.truncate(), point, light)
    }

    fn light_through(&self, entry: DVec3, point: DVec3, light: DVec3) -> IrisLight {
        IrisLight {
            towards: (entry - point).normalize_or(DVec3::NEG_Z).truncate(),
            unbounded_irradiance: caustic_irradiance_at(
                entry,
                light,
                self.surface,
                self.index,
                self.iris_z,
            ),
            entry_radius_mm: entry.truncate().length(),
        }
    }

    /// The light at a place, and past the border of what light can reach (its entry lies far outside
    /// the limbus there, so it is dark) the value of the last place that it reaches, so that no
    /// look-up mixes light with nothing.
    fn continued(place: DVec2, at: impl Fn(DVec2) -> IrisLight) -> IrisLight {
        let mut nearer = place;
        for _ in 0..48 {
            let light = at(nearer);
            if light != IrisLight::default() {
                return light;
            }
            nearer *= 0.97;
        }
        IrisLight::default()
    }

    /// The table with `side` texels along each side, every one solved exactly: the reference, and the
    /// measure of what another size costs and gains.
    pub fn texels_of(&self, side: usize) -> Vec<[f32; 4]> {
        self.fill(side, |lamp, place| self.exact(lamp, place))
    }

    /// Row by row, `LAMPS · side` wide and `side` high: towards x, towards y, unbounded irradiance,
    /// radius of entry in mm. The limbus' cut is left to the look-up: it is the one thing here that
    /// changes within a cell.
    fn fill(&self, side: usize, at: impl Fn(usize, DVec2) -> IrisLight) -> Vec<[f32; 4]> {
        let place = |i: usize| (i as f64 / (side - 1) as f64 * 2.0 - 1.0) * self.root_mm * REACH;
        let cell = 2.0 * self.root_mm * REACH / (side - 1) as f64;
        let farthest = self.root_mm + core::f64::consts::SQRT_2 * cell;
        let mut out = Vec::with_capacity(side * side * LAMPS);
        for row in 0..side {
            for lamp in 0..LAMPS {
                for column in 0..side {
                    // No look-up within the iris reads further out than this.
                    let place = DVec2::new(place(column), place(row)).clamp_length_max(farthest);
                    let light = Self::continued(place, |place| at(lamp, place));
                    out.push([
                        light.towards.x as f32,
                        light.towards.y as f32,
                        light.unbounded_irradiance as f32,
                        light.entry_radius_mm as f32,
                    ]);
                }
            }
        }
        out
    }
}

/// The settings with the refraction function of their eye.
#[derive(Clone, Debug)]
pub struct LightTable {
    /// What the table is made of; the lamps may be turned at any time.
    pub settings: LightTableSettings,
    function: RefractionFunction,
}

impl LightTable {
    /// Computes the refraction function of the eye.
    pub fn new(settings: LightTableSettings) -> Self {
        let eye = RefractionEye {
            surface: settings.surface,
            index: settings.index,
            iris_z_mm: settings.iris_z,
            limbus_mm: settings.limbus_mm,
        };
        Self {
            settings,
            function: RefractionFunction::new(eye, RefractionSize::SMALL),
        }
    }

    /// The table for the lamps where they stand now.
    pub fn texels(&self) -> Vec<[f32; 4]> {
        let slices = self.settings.lamps.map(|lamp| self.function.towards(lamp));
        self.settings
            .fill(SIDE, |lamp, place| self.light(&slices[lamp], lamp, place))
    }

    /// [`LightTableSettings::exact`] through the refraction function; solved where that does not hold.
    fn light(&self, slice: &RefractionSlice, lamp: usize, place: DVec2) -> IrisLight {
        let (settings, light) = (&self.settings, self.settings.lamps[lamp]);
        if light.z > -LEAST_FACING {
            return IrisLight::default();
        }
        let k = self.function.polish(slice.entry(place), place, light);
        let radius = k.length();
        let landing = self.function.eye().land(k, light).point;
        if landing.distance(place) > FARTHEST_LANDING_MM || radius > settings.limbus_mm {
            return settings.exact(lamp, place);
        }
        let entry = k.extend(conicoid_sag(radius, settings.surface.x, settings.surface.y));
        settings.light_through(entry, place.extend(settings.iris_z), light)
    }
}

/// Bilinear look-up as the shader does it, in a table of any size.
pub fn look_up(
    texels: &[[f32; 4]],
    settings: &LightTableSettings,
    lamp: usize,
    place: DVec2,
) -> IrisLight {
    let reach = settings.root_mm * REACH;
    let side = (texels.len() / LAMPS).isqrt();
    let last = (side - 1) as f64;
    let at = ((place / reach) * 0.5 + 0.5).clamp(DVec2::ZERO, DVec2::ONE) * last;
    let corner = at.floor().min(DVec2::splat(last - 1.0));
    let f = at - corner;
    let texel = |dx: usize, dy: usize| {
        let column = lamp * side + corner.x as usize + dx;
        texels[(corner.y as usize + dy) * side * LAMPS + column].map(f64::from)
    };
    let mix = |channel: usize| {
        let top = texel(0, 0)[channel] * (1.0 - f.x) + texel(1, 0)[channel] * f.x;
        let bottom = texel(0, 1)[channel] * (1.0 - f.x) + texel(1, 1)[channel] * f.x;
        top * (1.0 - f.y) + bottom * f.y
    };
    IrisLight {
        towards: DVec2::new(mix(0), mix(1)),
        unbounded_irradiance: mix(2),
        entry_radius_mm: mix(3),
    }
}

/// Light of a lamp at a place of the iris plane: xyz towards where it enters the cornea, w irradiance
/// relative to the lamp's. `table` holds the lamps side by side. Twin: `shaders/lib/iris_light.wgsl`.
pub fn iris_light(
    table: &MapView,
    lamp: usize,
    place: DVec2,
    root_mm: f64,
    limbus_mm: f64,
) -> DVec4 {
    let size = table.size() * DVec2::new(1.0 / LAMPS as f64, 1.0);
    let at =
        (place / (root_mm * REACH) * 0.5 + 0.5).clamp(DVec2::ZERO, DVec2::ONE) * (size - 1.0) + 0.5;
    let beside = DVec2::new(lamp as f64 * size.x, 0.0);
    let [x, y, unbounded_irradiance, entry_radius_mm] =
        table.sample((at + beside) / table.size(), 0.0);
    let light = IrisLight {
        towards: DVec2::new(x, y),
        unbounded_irradiance,
        entry_radius_mm,
    };
    light
        .towards
        .extend(-(1.0 - light.towards.length_squared()).max(0.04).sqrt())
        .extend(light.irradiance(limbus_mm))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(angle_deg: f64) -> LightTableSettings {
        let angle = angle_deg.to_radians();
        let lamp = DVec3::new(angle.sin(), 0.0, -angle.cos());
        LightTableSettings {
            surface: DVec2::new(7.8, 0.75),
            index: 1.336,
            iris_z: 3.6,
            root_mm: 6.05,
            limbus_mm: 5.85,
            lamps: [lamp, -lamp],
        }
    }

    /// Largest and root-mean-square error of direction and irradiance within the visible iris.
    fn errors(angle_deg: f64) -> [f64; 4] {
        let settings = settings(angle_deg);
        let texels = LightTable::new(settings).texels();
        let mut sums = [0.0f64; 4];
        let mut count = 0.0;
        for i in 0..61 {
            for j in 0..61 {
                let place = DVec2::new(f64::from(i) - 30.0, f64::from(j) - 30.0) * (5.5 / 30.0);
                if place.length() > 5.5 {
                    continue;
                }
                let exact = settings.exact(0, place);
                let found = look_up(&texels, &settings, 0, place);
                // Where it is dark no direction is asked for.
                let lit = exact.irradiance(settings.limbus_mm) > 0.0;
                let direction = if lit {
                    (exact.towards - found.towards).length()
                } else {
                    0.0
                };
                let limbus = settings.limbus_mm;
                let irradiance = (exact.irradiance(limbus) - found.irradiance(limbus)).abs();
                sums[0] = sums[0].max(direction);
                sums[1] += direction * direction;
                sums[2] = sums[2].max(irradiance);
                sums[3] += irradiance * irradiance;
                count += 1.0;
            }
        }
        [
            sums[0],
            (sums[1] / count).sqrt(),
            sums[2],
            (sums[3] / count).sqrt(),
        ]
    }

    #[test]
    fn the_table_is_close_to_the_solution() {
        for angle_deg in [0.0, 20.0, 40.0, 60.0] {
            let [direction_max, direction_rms, irradiance_max, irradiance_rms] = errors(angle_deg);
            println!(
                "{angle_deg}°: direction {direction_max:.2e} (rms {direction_rms:.2e}), irradiance {irradiance_max:.2e} (rms {irradiance_rms:.2e})"
            );
            // Bilinear over cells of h = 0.27 mm errs by h²/8 of the second derivative, up to 40° 8e-4;
            // at 60° the caustic itself is 2 and steep on the far side, and a shadow's edge is there.
            assert!(
                direction_rms < 2e-3 && irradiance_rms < 4e-3,
                "{angle_deg}°"
            );
        }
    }

    #[test]
    fn a_lamp_behind_the_eye_lights_nothing() {
        let settings = settings(0.0);
        assert_eq!(settings.exact(1, DVec2::ZERO), IrisLight::default());
        let texels = LightTable::new(settings).texels();
        assert!(texels.iter().flatten().all(|v| v.is_finite()));
    }

    #[test]
    fn the_refraction_function_fills_the_table_that_solving_fills() {
        for angle_deg in [0.0, 30.0, 60.0, 80.0] {
            let settings = settings(angle_deg);
            let (filled, solved) = (LightTable::new(settings).texels(), settings.texels_of(SIDE));
            let mut worst = [0.0_f32; 4];
            for (a, b) in filled.iter().zip(&solved) {
                for i in 0..4 {
                    worst[i] = worst[i].max((a[i] - b[i]).abs() / b[2].max(1.0));
                }
            }
            println!("{angle_deg}°: table off by {worst:?}");
            // What lands within 2e-5 mm enters within fifty times that where the map is steepest.
            assert!(
                worst.iter().all(|off| *off < 1e-3),
                "{angle_deg}°: {worst:?}"
            );
        }
    }
}
