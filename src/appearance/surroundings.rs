//! What surrounds an eye: a map of all that its cornea may mirror, and the light of it.
//!
//! Enters: the radiance from each direction of the head's frame, and lamps. Leaves: the map with its
//! levels, the lamps, and the irradiance of the rest as nine factors (spherical harmonics to the
//! second degree hold 99 % of what a Lambertian surface takes up: Ramamoorthi and Hanrahan 2001).

use super::illumination::{Illumination, Lamp, MOST_LAMPS};
use super::images::{Level, map_image};
use super::shading::surroundings::{ambient_basis, ambient_light, surroundings_direction};
use crate::frame::mips::chain;
use bevy::image::Image;
use bevy::math::{DVec2, DVec3, Vec3};
use core::f64::consts::PI;

/// Texels along a side of the map of a studio: 0.45° each.
pub const STUDIO_SIDE: usize = 512;
/// Samples along each axis of a texel.
const SAMPLES: usize = 2;

/// What surrounds an eye.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// Radiance by direction (`surroundings_uv`), linear sRGB, the finest level first.
    pub levels: Vec<Level>,
    /// The lamps, those in the map too.
    pub lamps: Vec<Lamp>,
    /// Irradiance / π from the map without its lamps: factors of [`ambient_basis`].
    pub ambient: [Vec3; 9],
    /// Factor on all of it before the output transform.
    pub exposure: f32,
    /// Is all of this in cd/m², and the camera's exposure still to come?
    pub is_luminance: bool,
}

impl Surroundings {
    /// The same radiance from everywhere.
    pub fn even(radiance: Vec3) -> Self {
        let [r, g, b] = radiance.to_array();
        let mut ambient = [Vec3::ZERO; 9];
        ambient[0] = radiance;
        Self {
            levels: vec![(1, 1, vec![[r, g, b, 1.0]])],
            lamps: Vec::new(),
            ambient,
            exposure: 1.0,
            is_luminance: false,
        }
    }

    /// The same light without what is mirrored.
    pub fn without_map(&self) -> Self {
        Self {
            levels: Vec::new(),
            lamps: self.lamps.clone(),
            ..*self
        }
    }

    /// A map of `side` texels of what `around` and the lamps' own `shining` say for each unit direction;
    /// the light of the lamps is left out of the irradiance, as lamps give it by themselves.
    pub fn new(
        side: usize,
        around: impl Fn(DVec3) -> DVec3,
        shining: impl Fn(DVec3) -> DVec3,
        lamps: Vec<Lamp>,
    ) -> Self {
        let side = side.max(1);
        let mut texels = Vec::with_capacity(side * side);
        let mut rest = Vec::new();
        for row in 0..side {
            for column in 0..side {
                let (mut both, mut apart) = (DVec3::ZERO, DVec3::ZERO);
                let mut direction = DVec3::ZERO;
                for k in 0..SAMPLES * SAMPLES {
                    let part = DVec2::new((k % SAMPLES) as f64, (k / SAMPLES) as f64) + 0.5;
                    let at = DVec2::new(column as f64, row as f64) + part / SAMPLES as f64;
                    let d = surroundings_direction(at / side as f64);
                    let own = around(d);
                    both += own + shining(d);
                    apart += own;
                    direction += d;
                }
                let count = (SAMPLES * SAMPLES) as f64;
                let [r, g, b] = (both / count).as_vec3().to_array();
                texels.push([r, g, b, 1.0]);
                let from_middle =
                    DVec2::new(column as f64 + 0.5, row as f64 + 0.5) / side as f64 - 0.5;
                if from_middle.length() <= 0.5 {
                    rest.push((direction.normalize_or(DVec3::Z), apart / count));
                }
            }
        }
        Self {
            levels: chain((side, side), texels),
            ambient: irradiance(&rest),
            lamps,
            exposure: 1.0,
            is_luminance: false,
        }
    }

    /// Adds light from a unit direction, of this irradiance / π across it, to what is no lamp: a quarter of it from everywhere and
    /// more from its own side.
    pub fn spread(&mut self, direction: Vec3, color: Vec3) {
        let [x, y, z] = direction.to_array();
        for (factor, share) in self
            .ambient
            .iter_mut()
            .zip([1.0, 2.0 * y, 2.0 * z, 2.0 * x])
        {
            *factor += color * (0.25 * share);
        }
    }

    /// Irradiance / π on a surface of this unit normal, lamps and all.
    pub fn irradiance(&self, n: DVec3) -> DVec3 {
        let lamps: DVec3 = self
            .lamps
            .iter()
            .map(|lamp| lamp.color.as_dvec3() * lamp.direction.as_dvec3().dot(n).max(0.0))
            .sum();
        lamps + ambient_light(&self.ambient.map(|factor| factor.extend(0.0)), n)
    }

    /// As a shader reads it.
    pub fn illumination(&self) -> Illumination {
        let mut lamps = [Lamp::default(); MOST_LAMPS];
        for (to, lamp) in lamps.iter_mut().zip(&self.lamps) {
            *to = *lamp;
        }
        Illumination {
            lamps,
            ambient: self.ambient.map(|factor| factor.extend(0.0)),
            exposure: self.exposure,
            is_luminance: if self.is_luminance { 1.0 } else { 0.0 },
            ..Illumination::default()
        }
        .lighting_lids()
    }

    /// The map as a texture.
    pub fn image(&self) -> Image {
        map_image(&self.levels, false)
    }
}

/// Irradiance / π of radiances from directions that share the sphere evenly.
fn irradiance(radiances: &[(DVec3, DVec3)]) -> [Vec3; 9] {
    // Radiance projected on the harmonics and convolved with the cosine: of degree 0 all is kept, of 1 two
    // thirds, of 2 a quarter; with the squares of the harmonics' own norms, over π.
    let factors = {
        let first = 3.0 * 2.0 / 3.0;
        let (mixed, axial, planar) = (15.0, 1.25, 3.75);
        let second = 0.25;
        [
            1.0,
            first,
            first,
            first,
            second * mixed,
            second * mixed,
            second * axial,
            second * mixed,
            second * planar,
        ]
    };
    let mut sums = [DVec3::ZERO; 9];
    for (direction, radiance) in radiances {
        for (sum, value) in sums.iter_mut().zip(ambient_basis(*direction)) {
            *sum += *radiance * value;
        }
    }
    let count = radiances.len().max(1) as f64;
    core::array::from_fn(|i| (sums[i] * (factors[i] / count)).as_vec3())
}

/// Irradiance / π of a lamp's radiance over a grid about its direction.
pub fn lamp_color(direction: DVec3, reach_rad: f64, radiance: impl Fn(DVec3) -> DVec3) -> Vec3 {
    const STEPS: i32 = 96;
    let right = direction.any_orthonormal_vector();
    let above = direction.cross(right);
    let step = 2.0 * reach_rad.tan() / f64::from(STEPS);
    let mut sum = DVec3::ZERO;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) * step - reach_rad.tan());
            let d = direction + x * right + y * above;
            let cosine = 1.0 / d.length();
            sum += radiance(d.normalize()) * (step * step * cosine.powi(4));
        }
    }
    (sum / PI).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lids_are_lit_by_all_of_it_and_by_a_lamp_that_moved() {
        use crate::appearance::shading::lid_shade::LIDS_FACE;
        let lamp = |y: f32| Lamp {
            direction: Vec3::new(0.2, y, -1.0).normalize(),
            color: Vec3::new(0.5, 0.4, 0.3),
            ..Lamp::default()
        };
        let lit_by = |y: f32| {
            let mut around = Surroundings::even(Vec3::new(0.2, 0.3, 0.4));
            around.lamps = vec![lamp(y), lamp(3.0)];
            around
        };
        let low = lit_by(-0.4);
        let wanted = low.irradiance(LIDS_FACE).as_vec3();
        assert!(low.illumination().lids_lit.distance(wanted) < 1e-6);
        let mut moved = lit_by(1.0).illumination();
        assert!(moved.lids_lit.distance(wanted) > 0.1);
        moved.lamps[0] = lamp(-0.4);
        assert!(moved.lighting_lids().lids_lit.distance(wanted) < 1e-6);
    }

    /// Irradiance / π by the integral itself.
    fn integral(n: DVec3, radiance: impl Fn(DVec3) -> DVec3) -> DVec3 {
        let side = 400;
        let mut sum = DVec3::ZERO;
        for row in 0..side {
            for column in 0..side {
                let uv = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / f64::from(side);
                if uv.distance(DVec2::splat(0.5)) > 0.5 {
                    continue;
                }
                let d = surroundings_direction(uv);
                sum += radiance(d) * d.dot(n).max(0.0) * 16.0 / f64::from(side * side);
            }
        }
        sum / PI
    }

    #[test]
    fn nine_factors_hold_the_irradiance() {
        // Linear in the direction: exact but for the map's texels; a half of the sphere: within 1 %.
        let linear = |d: DVec3| DVec3::new(1.0 + d.y, 1.0 - 0.5 * d.x, 2.0 + d.z);
        let half = |d: DVec3| if d.x > 0.0 { DVec3::ONE } else { DVec3::ZERO };
        let of = |f: &dyn Fn(DVec3) -> DVec3| {
            Surroundings::new(128, f, |_| DVec3::ZERO, Vec::new())
                .ambient
                .map(|factor| factor.extend(0.0))
        };
        let (smooth, sharp) = (of(&linear), of(&half));
        for n in [
            DVec3::X,
            DVec3::Y,
            DVec3::NEG_Z,
            DVec3::new(0.5, -0.3, -0.8),
        ] {
            let n = n.normalize();
            let exact = integral(n, linear);
            let found = ambient_light(&smooth, n);
            // Texels that the rim of the map cuts count whole.
            assert!(found.distance(exact) < 4e-3, "{n}: {found} for {exact}");
            let (exact, found) = (integral(n, half), ambient_light(&sharp, n));
            assert!(found.distance(exact) < 0.06, "{n}: {found} for {exact}");
        }
        // Second degree, as it is known in closed form: d.x d.y keeps a quarter.
        let mixed = of(&|d: DVec3| DVec3::splat(1.0 + d.x * d.y));
        let n = DVec3::new(1.0, 1.0, 0.0).normalize();
        assert!((ambient_light(&mixed, n).x - (1.0 + 0.25 * 0.5)).abs() < 2e-3);
    }

    #[test]
    fn the_levels_keep_what_is_mirrored() {
        let around = Surroundings::new(
            64,
            |_| DVec3::splat(0.2),
            |d| if d.z < -0.9 { DVec3::ONE } else { DVec3::ZERO },
            vec![Lamp::default(); MOST_LAMPS + 4],
        );
        assert_eq!(around.levels.len(), 7);
        // The lamp is in the map and not in the light of the rest.
        assert!((around.ambient[0].x - 0.2).abs() < 1e-6);
        let middle = around.levels[0].2[32 * 64 + 32];
        assert!((middle[0] - 1.2).abs() < 1e-6);
    }

    #[test]
    fn even_light_is_the_same_on_every_surface() {
        let even = Surroundings::even(Vec3::new(0.1, 0.2, 0.3));
        let ambient = even.ambient.map(|factor| factor.extend(0.0));
        for n in [DVec3::X, DVec3::NEG_Z] {
            assert!(ambient_light(&ambient, n).distance(DVec3::new(0.1, 0.2, 0.3)) < 1e-7);
        }
    }
}
