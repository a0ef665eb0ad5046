//! The light that falls on an eye: lamps, and what surrounds it. Head frame. Twin:
//! `shaders/lib/surroundings.wgsl`.

use super::mix;
use crate::appearance::illumination::Lamp;
use crate::appearance::images::MapView;
use crate::optics::smoothstep::smoothstep;
use bevy::math::Vec4;
use glam::{DVec2, DVec3};

/// Place in the map of the surroundings, the equal-area azimuthal projection about the direction of the
/// face: what is straight behind lies all around its rim.
pub fn surroundings_uv(d: DVec3) -> DVec2 {
    let half_cosine = (0.5 * (1.0 - d.z)).max(1e-4).sqrt();
    0.5 + DVec2::new(0.25, -0.25) * d.truncate() / half_cosine
}

/// The unit direction of a place in that map; beyond its rim straight behind.
pub fn surroundings_direction(uv: DVec2) -> DVec3 {
    let p = (uv - 0.5) * DVec2::new(2.0, -2.0);
    // The sine of half the angle from the face's direction.
    let s2 = p.length_squared().min(1.0);
    let across = p * (2.0 * (1.0 - s2).sqrt());
    across.extend(2.0 * s2 - 1.0).normalize_or(DVec3::Z)
}

/// Radiance from the unit direction `d`; `blur` (rad) is what the mirror's roughness spreads it over.
pub fn surroundings_radiance(map: &MapView, d: DVec3, blur: f64) -> DVec3 {
    // A texel of the map is 4 rad over its side wide.
    let level = (0.5 * blur * map.size().x).max(1.0).log2();
    let below = level.floor();
    let uv = surroundings_uv(d);
    let of = |level: f64| {
        let [r, g, b, _] = map.sample(uv, level);
        DVec3::new(r, g, b)
    };
    of(below).lerp(of(below + 1.0), level - below)
}

/// Radiance over irradiance / π of a round lamp of angular radius `radius` (rad) about `direction`.
pub fn round_lamp(d: DVec3, direction: DVec3, radius: f64, blur: f64) -> f64 {
    let edge = blur.max(0.02);
    // The chord for the angle: an arc cosine is coarse where lamps are small.
    let angle = d.distance(direction);
    // A lamp is at least as wide as its edge, and the edge adds a fifth of its square: the light stays
    // what it was.
    let wide = radius.max(edge);
    smoothstep(wide + edge, wide - edge, angle) / (wide * wide + 0.2 * edge * edge)
}

/// The lamp as it is from the place `p` (mm) of the frame of its direction: nearer to it, brighter and wider.
/// Its direction, and how many times as near it is: so many times are its radius and its vergence more, and its
/// colour the square of that.
pub fn lamp_from(lamp: &Lamp, p: DVec3) -> (DVec3, f64) {
    let towards = lamp.direction.as_dvec3() - f64::from(lamp.vergence) * p;
    // Nothing comes nearer to a lamp than to a hundredth of its distance.
    let nearer = 1.0 / towards.length_squared().max(1e-4).sqrt();
    (towards * nearer, nearer)
}

/// Share of the unit direction `d` that does not lead back into the head itself.
pub fn past_head(d: DVec3) -> f64 {
    smoothstep(-0.05, 0.25, 0.25 - d.z)
}

/// Radiance of a lamp by itself from the unit direction `d`.
pub fn lamp_radiance(lamp: &Lamp, d: DVec3, blur: f64) -> DVec3 {
    let (hole, radius) = (f64::from(lamp.hole), f64::from(lamp.radius));
    if hole < -0.5 {
        return DVec3::ZERO;
    }
    let hole = hole.clamp(0.0, 0.95);
    let direction = lamp.direction.as_dvec3();
    let whole = round_lamp(d, direction, radius, blur);
    // Blurred more than it is wide, a hole is no more.
    let has_hole = if hole * radius >= blur { 1.0 } else { 0.0 };
    let inner = round_lamp(d, direction, hole * radius, blur) * (hole * hole);
    let seen = (whole - inner * has_hole).max(0.0) / mix(1.0, 1.0 - hole * hole, has_hole);
    lamp.color.as_dvec3() * seen
}

/// The functions of a normal over whose factors the surroundings' irradiance is a sum.
pub fn ambient_basis(n: DVec3) -> [f64; 9] {
    let DVec3 { x, y, z } = n;
    [
        1.0,
        y,
        z,
        x,
        x * y,
        y * z,
        3.0 * z * z - 1.0,
        x * z,
        x * x - y * y,
    ]
}

/// Irradiance / π from the surroundings on a surface of normal `n`, never negative.
pub fn ambient_light(ambient: &[Vec4; 9], n: DVec3) -> DVec3 {
    let sum: DVec3 = ambient
        .iter()
        .zip(ambient_basis(n))
        .map(|(factor, value)| factor.truncate().as_dvec3() * value)
        .sum();
    sum.max(DVec3::ZERO)
}

/// Mean cosine of a lamp over a surface that bends light around its terminator by `wrap` (0:
/// Lambert), never negative.
pub fn wrapped_cosine(cosine: f64, wrap: f64) -> f64 {
    let c = ((cosine + wrap) / (1.0 + wrap)).max(0.0);
    c * c * 0.35 + c * 0.65
}

/// The same by channel: light that travels under the surface, red furthest.
pub fn wrapped_cosines(cosine: f64, wrap: DVec3) -> DVec3 {
    wrap.map(|wrap| wrapped_cosine(cosine, wrap))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;

    /// A lamp's light is what it is given, however soft its edge is and whatever its hole.
    #[test]
    fn a_lamp_gives_the_irradiance_that_it_is_given() {
        for (radius, blur, hole) in [
            (0.00465, 0.01, 0.0),
            (0.07, 0.0, 0.0),
            (0.07, 0.16, 0.0),
            (0.2, 0.05, 0.0),
            (0.3, 0.01, 0.6),
            (0.3, 0.25, 0.6),
        ] {
            let lamp = Lamp {
                direction: Vec3::Z,
                radius,
                color: Vec3::ONE,
                hole,
                vergence: 0.0,
            };
            let (step, mut sum) = (0.0005, 0.0);
            for i in 0..2000 {
                let angle = step * (f64::from(i) + 0.5);
                let d = DVec3::new(angle.sin(), 0.0, angle.cos());
                sum += lamp_radiance(&lamp, d, blur).x * 2.0 * angle.sin() * step;
            }
            // Up to the sine of the angle for the angle, at most (0.3 + 0.25)²/6, and the edge of a hole.
            assert!((sum - 1.0).abs() < 0.06, "{radius} {blur} {hole}: {sum}");
        }
    }

    #[test]
    fn a_direction_has_its_place_and_every_texel_its_share_of_the_sphere() {
        for d in [
            DVec3::NEG_Z,
            DVec3::new(0.3, -0.5, -0.8),
            DVec3::new(-0.9, 0.1, 0.4),
            DVec3::Y,
        ] {
            let d = d.normalize();
            let back = surroundings_direction(surroundings_uv(d));
            assert!(d.distance(back) < 1e-12, "{d} {back}");
        }
        assert_eq!(surroundings_uv(DVec3::NEG_Z), DVec2::splat(0.5));
        // A step either way spans the same solid angle everywhere.
        let solid = |uv: DVec2| {
            let h = 1e-5;
            let across = surroundings_direction(uv + DVec2::X * h) - surroundings_direction(uv);
            let down = surroundings_direction(uv + DVec2::Y * h) - surroundings_direction(uv);
            across.cross(down).length() / (h * h)
        };
        for uv in [
            DVec2::new(0.51, 0.52),
            DVec2::new(0.2, 0.6),
            DVec2::new(0.5, 0.95),
        ] {
            assert!((solid(uv) / 16.0 - 1.0).abs() < 1e-3, "{uv}: {}", solid(uv));
        }
        for d in [DVec3::Z, DVec3::ZERO] {
            assert!(surroundings_uv(d).is_finite());
        }
    }
}
