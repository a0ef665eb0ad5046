//! Where light enters the cornea, and how strongly it arrives, for every place of the iris and every
//! obliquity of the light.
//!
//! Enters: the cornea and the iris plane. Leaves: a table for the shader, the refraction function of
//! François et al. 2007 (section 5.1) sampled on a grid, with the caustic's irradiance beside the
//! entry. About its axis the eye is symmetric, so a light and a place are three numbers: the light's
//! obliquity, and the place along the light's azimuth and across it. The table therefore outlasts every
//! turn of the eye and every move of a lamp: it is made once for each cornea, each place solved to
//! rounding error, and a picture pays for two bilinear look-ups a lamp.

use super::images::{Level, MapView};
use super::shading::knots::{Knot, knot_at};
use crate::optics::caustic::caustic_irradiance_at;
use crate::optics::fermat::{FERMAT_STEPS, fermat_entry};
use crate::optics::smoothstep::smoothstep;
use glam::{DVec2, DVec3, DVec4};

/// The table reaches this far beyond the iris root, as a share of its radius.
pub const REACH: f64 = 1.04;
/// Cosine to the axis down to which a lamp behind the plane of the iris still lights it: it fades out
/// until there. Light from further behind does reach the nasal rim of some irides; no lamp of a picture
/// of an eye stands there.
pub const FADE: f64 = 0.06;

/// Places at which [`LightTableSettings::sky`] is known.
pub const SKY_RADII: usize = 32;

/// Between which places of [`LightTableSettings::sky`] `radius` mm from the axis lies. Twin: `shaders/lib/iris_light.wgsl`.
pub fn iris_sky_knot(radius: f64, root_mm: f64) -> Knot {
    knot_at(radius / (root_mm * REACH), SKY_RADII)
}

/// By how much light on the iris changes where the cornea's concentration of it, `own` times, is taken to this
/// power and its excess over an even light is scaled.
pub fn caustic_change(own: f64, scale: f64, power: f64) -> f64 {
    let wanted = 1.0 + (own.max(0.0).powf(power) - 1.0) * scale;
    wanted.max(0.0) / own.max(1e-2)
}

/// Texels of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightTableSize {
    /// Places along the azimuth of the light, from one side of the iris to the other.
    pub along: usize,
    /// Obliquities, evenly in tan(θ/2) from 0° to 90°.
    pub obliquities: usize,
}

impl LightTableSize {
    /// What pictures read.
    pub const PICTURE: Self = Self {
        along: 56,
        obliquities: 32,
    };

    /// Places across the azimuth, from the axis outwards: half as many as along it.
    pub fn across(&self) -> usize {
        self.along / 2
    }

    /// Bytes of the half floats.
    pub fn bytes(&self) -> usize {
        self.along * self.across() * self.obliquities * 8
    }
}

/// What the table is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTableSettings {
    /// Anterior cornea (R, p), mm.
    pub surface: DVec2,
    /// Index behind it.
    pub index: f64,
    /// Depth of a plane through the iris, mm.
    pub iris_z: f64,
    /// Radius of the iris root, mm.
    pub root_mm: f64,
    /// Radius of the limbus, mm.
    pub limbus_mm: f64,
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
    /// Share of it that a limbus of this radius lets in: light that would have to enter outside it meets the sclera. The edge is soft, as
    /// light goes sideways in the lamellae (a choice; they send on what is seen beyond it).
    pub fn passes_limbus(&self, limbus_mm: f64) -> f64 {
        smoothstep(limbus_mm + 0.5, limbus_mm - 0.3, self.entry_radius_mm)
    }

    /// Irradiance of the iris plane behind a limbus of this radius.
    pub fn irradiance(&self, limbus_mm: f64) -> f64 {
        self.unbounded_irradiance * self.passes_limbus(limbus_mm)
    }
}

/// The direction towards a light of this tan(θ/2), with its azimuth along +x.
fn light_at(half_tangent: f64) -> DVec3 {
    let squared = half_tangent * half_tangent;
    DVec3::new(2.0 * half_tangent, 0.0, squared - 1.0) / (1.0 + squared)
}

impl LightTableSettings {
    /// The light of a lamp in the unit direction `light` at a place of the iris plane, mm, exactly.
    pub fn exact(&self, light: DVec3, place: DVec2) -> IrisLight {
        if light.z > 0.0 {
            return IrisLight::default();
        }
        let point = place.extend(self.iris_z);
        let solved = fermat_entry(point, light, self.surface, self.index, 2 * FERMAT_STEPS);
        if solved.w < 0.5 {
            return IrisLight::default();
        }
        let entry = solved.truncate();
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
    fn continued(&self, light: DVec3, place: DVec2) -> IrisLight {
        let mut nearer = place;
        for _ in 0..48 {
            let light = self.exact(light, nearer);
            if light != IrisLight::default() {
                return light;
            }
            nearer *= 0.97;
        }
        IrisLight::default()
    }

    /// Irradiance of an iris, which lies so deep (mm) and falls back so fast this far (mm) from the axis (`iris`), under an even sky of radiance
    /// 1/π (an irradiance of one in front of the eye), at [`SKY_RADII`] places evenly from the axis to the table's reach. What limbus and
    /// critical angle keep away is missing in it.
    pub fn sky(&self, iris: impl Fn(f64) -> DVec2) -> [f64; SKY_RADII] {
        const RINGS: usize = 20;
        const TURNS: usize = 24;
        core::array::from_fn(|i| {
            let radius = self.root_mm * REACH * i as f64 / (SKY_RADII - 1) as f64;
            let DVec2 { x: depth, y: slope } = iris(radius);
            let there = Self {
                iris_z: depth,
                ..*self
            };
            let mut sum = 0.0;
            for ring in 0..RINGS {
                // Even steps of the cosine are even steps of solid angle.
                let cosine = (ring as f64 + 0.5) / RINGS as f64;
                let sine = (1.0 - cosine * cosine).sqrt();
                for turn in 0..TURNS {
                    // Each ring is turned by the golden angle, so that no border of shade falls between the same turns.
                    let angle = turn as f64 * core::f64::consts::TAU / TURNS as f64
                        + ring as f64 * 2.399_963;
                    let light = DVec3::new(sine * angle.cos(), sine * angle.sin(), -cosine);
                    let place = DVec2::new(radius, 0.0);
                    let found = there.exact(light, place);
                    // From the plane to what leans against it.
                    let up = (1.0 - found.towards.length_squared()).max(0.04).sqrt();
                    let leans = (slope * found.towards.x + up) / (1.0 + slope * slope).sqrt();
                    sum += found.irradiance(self.limbus_mm) * leans.max(0.0) / up;
                }
            }
            // 2π of solid angle, of radiance 1/π.
            2.0 * sum / (RINGS * TURNS) as f64
        })
    }

    /// The table as one level of a map: obliquity over obliquity, each `along` wide and `across` high:
    /// towards x, towards y, unbounded irradiance, radius of entry in mm. The limbus' cut is left to
    /// the look-up: it is the one thing here that changes within a cell.
    pub fn table(&self, size: LightTableSize) -> Level {
        let reach = self.root_mm * REACH;
        let share = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let cell = 2.0 * reach / (size.along - 1) as f64;
        let farthest = self.root_mm + core::f64::consts::SQRT_2 * cell;
        let mut texels = Vec::with_capacity(size.along * size.across() * size.obliquities);
        for obliquity in 0..size.obliquities {
            let light = light_at(share(obliquity, size.obliquities));
            for across in 0..size.across() {
                for along in 0..size.along {
                    let place = DVec2::new(
                        share(along, size.along) * 2.0 - 1.0,
                        share(across, size.across()),
                    ) * reach;
                    // No look-up within the iris reads further out than this.
                    let light = self.continued(light, place.clamp_length_max(farthest));
                    texels.push([
                        light.towards.x as f32,
                        light.towards.y as f32,
                        light.unbounded_irradiance as f32,
                        light.entry_radius_mm as f32,
                    ]);
                }
            }
        }
        let height = size.across() * size.obliquities;
        (size.along as u32, height as u32, texels)
    }
}

/// Light of a lamp in the unit direction `light` at a place of the iris plane: xyz towards where it
/// enters the cornea, w irradiance relative to the lamp's. Twin: `shaders/lib/iris_light.wgsl`.
pub fn iris_light(
    table: &MapView,
    light: DVec3,
    place: DVec2,
    root_mm: f64,
    limbus_mm: f64,
) -> DVec4 {
    let size = table.size();
    let across = 0.5 * size.x;
    let obliquities = (size.y / across).round();
    let azimuth = if light.truncate().length_squared() < 1e-12 {
        DVec2::X
    } else {
        light.truncate().normalize()
    };
    let side = DVec2::new(-azimuth.y, azimuth.x);
    let at = DVec2::new(place.dot(azimuth), place.dot(side)) / (root_mm * REACH);
    let u = ((at.x * 0.5 + 0.5).clamp(0.0, 1.0) * (size.x - 1.0) + 0.5) / size.x;
    let v = at.y.abs().clamp(0.0, 1.0) * (across - 1.0) + 0.5;
    let half_tangent = (light.truncate().length() / (1.0 - light.z).max(1e-6)).clamp(0.0, 1.0);
    let level = half_tangent * (obliquities - 1.0);
    let below = level.floor().min(obliquities - 2.0);
    let of = |level: f64| table.sample(DVec2::new(u, (v + level * across) / size.y), 0.0);
    let (low, high) = (of(below), of(below + 1.0));
    let f = level - below;
    let [x, y, unbounded_irradiance, entry_radius_mm] =
        core::array::from_fn(|i| low[i] + (high[i] - low[i]) * f);
    let sign = if at.y < 0.0 { -1.0 } else { 1.0 };
    let found = IrisLight {
        towards: azimuth * x + side * (sign * y),
        unbounded_irradiance,
        entry_radius_mm,
    };
    let fade = (1.0 - light.z / FADE).clamp(0.0, 1.0);
    found
        .towards
        .extend(-(1.0 - found.towards.length_squared()).max(0.04).sqrt())
        .extend(found.irradiance(limbus_mm) * fade)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> LightTableSettings {
        LightTableSettings {
            surface: DVec2::new(7.8, 0.75),
            index: 1.336,
            iris_z: 3.6,
            root_mm: 6.05,
            limbus_mm: 5.85,
        }
    }

    fn light(angle_deg: f64, turn: f64) -> DVec3 {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        DVec3::new(sin * turn.cos(), sin * turn.sin(), -cos)
    }

    #[test]
    fn the_sky_is_that_of_its_integral() {
        let settings = settings();
        let iris = |r: f64| DVec2::new(3.4 + 0.1 * r, 0.1);
        let sky = settings.sky(iris);
        // Twice as fine, and turned.
        let exact = |r: f64| {
            let there = LightTableSettings {
                iris_z: iris(r).x,
                ..settings
            };
            let normal = DVec3::new(0.0, iris(r).y, -1.0).normalize();
            let mut sum = 0.0;
            for ring in 0..24 {
                let cosine: f64 = (f64::from(ring) + 0.5) / 24.0;
                for turn in 0..50 {
                    let turn = f64::from(turn) * 0.125_664 + f64::from(ring) * 2.399_963;
                    let light = light(cosine.acos().to_degrees(), turn);
                    let found = there.exact(light, DVec2::new(0.0, r));
                    let up = (1.0 - found.towards.length_squared()).sqrt();
                    let across = found.irradiance(settings.limbus_mm) / up.max(1e-6);
                    sum += across * found.towards.extend(-up).dot(normal).max(0.0);
                }
            }
            2.0 * sum / (24.0 * 50.0)
        };
        for r in [0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 5.9] {
            // It is straight between places 0.2 mm apart, and bends where the limbus' shade begins.
            let error = iris_sky_knot(r, settings.root_mm).read(&sky) - exact(r);
            assert!(error.abs() < 0.03, "{r}: {error}");
        }
        // Radiance grows by n² where light enters, and comes from everywhere within 48 degrees.
        assert!((1.5..1.336 * 1.336).contains(&sky[0]), "{}", sky[0]);
    }

    /// Largest and root-mean-square error of direction and irradiance within the visible iris.
    fn errors(table: &MapView, angle_deg: f64) -> [f64; 4] {
        let settings = settings();
        let mut sums = [0.0f64; 4];
        let mut count = 0.0;
        let light = light(angle_deg, 0.7);
        for i in 0..61 {
            for j in 0..61 {
                let place = DVec2::new(f64::from(i) - 30.0, f64::from(j) - 30.0) * (5.5 / 30.0);
                if place.length() > 5.5 {
                    continue;
                }
                let exact = settings.exact(light, place);
                let limbus = settings.limbus_mm;
                let found = iris_light(table, light, place, settings.root_mm, limbus);
                // Where it is dark no direction is asked for.
                let lit = exact.irradiance(limbus) > 0.0;
                let direction = if lit {
                    (exact.towards - found.truncate().truncate()).length()
                } else {
                    0.0
                };
                let irradiance = (exact.irradiance(limbus) - found.w).abs();
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
        let view = MapView::new(&[settings().table(LightTableSize::PICTURE)], false);
        for angle_deg in [0.0, 7.0, 20.0, 33.0, 40.0, 60.0, 70.0] {
            let [direction_max, direction_rms, irradiance_max, irradiance_rms] =
                errors(&view, angle_deg);
            println!(
                "{angle_deg}°: direction {direction_max:.2e} (rms {direction_rms:.2e}), irradiance {irradiance_max:.2e} (rms {irradiance_rms:.2e})"
            );
            // Bilinear over cells of h = 0.23 mm errs by h²/8 of the second derivative, linear over 0.065
            // of θ by 0.065²/8 of another, up to 40° 1e-3 together; from 60° on the caustic itself is 2
            // and steep on the far side, and the edge of what light can reach crosses cells.
            let [direction, irradiance] = match angle_deg {
                ..50.0 => [5e-4, 1e-3],
                ..65.0 => [2e-3, 4e-3],
                _ => [2.5e-3, 1.2e-2],
            };
            assert!(
                direction_rms < direction && irradiance_rms < irradiance,
                "{angle_deg}°"
            );
        }
    }

    #[test]
    fn light_is_the_same_however_eye_and_lamp_are_turned_together() {
        let settings = settings();
        let view = MapView::new(&[settings.table(LightTableSize::PICTURE)], false);
        let at = |turn: f64, mirror: f64| {
            let place = DVec2::from_angle(turn).rotate(DVec2::new(2.1, mirror * 1.3));
            let found = iris_light(&view, light(35.0, turn), place, 6.05, 5.85);
            let back = DVec2::from_angle(-turn).rotate(found.truncate().truncate());
            (back * DVec2::new(1.0, mirror)).extend(found.w)
        };
        for turn in [0.4, 1.9, 3.3, 5.9] {
            for mirror in [1.0, -1.0] {
                // The same numbers, but for rounding.
                assert!((at(turn, mirror) - at(0.0, 1.0)).length() < 1e-12);
            }
        }
    }

    #[test]
    fn a_lamp_behind_the_eye_lights_nothing_and_comes_round_without_a_jump() {
        let settings = settings();
        let (level, place) = (
            settings.table(LightTableSize::PICTURE),
            DVec2::new(-2.0, 1.0),
        );
        assert!(level.2.iter().flatten().all(|v| v.is_finite()));
        let view = MapView::new(&[level], false);
        let found = |angle: f64| iris_light(&view, light(angle, 0.3), place, 6.05, 5.85);
        assert_eq!(found(94.0).w, 0.0);
        let angles: Vec<f64> = (0..200).map(|i| 70.0 + 0.125 * f64::from(i)).collect();
        let largest = angles
            .windows(2)
            .map(|pair| (found(pair[0]).w - found(pair[1]).w).abs())
            .fold(0.0, f64::max);
        // It fades over 3.4°, an eighth of a degree at a time.
        assert!(largest < 0.06, "{largest}");
        for light in [DVec3::NEG_Z, DVec3::Z, DVec3::X] {
            for place in [DVec2::ZERO, DVec2::splat(9.0)] {
                assert!(iris_light(&view, light, place, 6.05, 5.85).is_finite());
            }
        }
    }
}
