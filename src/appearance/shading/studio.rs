//! The studio that lights the eye: a four-paned window (the key light), a smaller lamp (the fill) and
//! soft surroundings. Head frame. Twin: `shaders/lib/studio.wgsl`.

use super::mix;
use crate::appearance::materials::Studio;
use crate::optics::smoothstep::smoothstep;
use core::f64::consts::PI;
use glam::{DVec2, DVec3};

/// Radiance that arrives from the unit direction `d`; `blur` (rad) is the width of the edges.
pub fn studio_radiance(studio: &Studio, d: DVec3, blur: f64) -> DVec3 {
    let up = smoothstep(0.15, 0.85, 0.5 + 0.5 * d.y);
    let surroundings = studio
        .ambient_down
        .as_dvec3()
        .lerp(studio.ambient_up.as_dvec3(), up);
    let fill = round_lamp(
        d,
        studio.fill_direction.as_dvec3(),
        studio.fill_radius.into(),
        blur,
    );
    let key = if studio.is_window < 0.5 {
        let radius = studio.key_radius.into();
        studio.key_color.as_dvec3() * round_lamp(d, studio.key_direction.as_dvec3(), radius, blur)
    } else {
        window(studio, d, blur)
    };
    surroundings + key + studio.fill_color.as_dvec3() * fill
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

fn window(studio: &Studio, d: DVec3, blur: f64) -> DVec3 {
    let key = studio.key_direction.as_dvec3();
    let right = DVec3::Y.cross(key).normalize();
    let above = key.cross(right);
    let along = d.dot(key);
    if along <= 0.05 {
        return DVec3::ZERO;
    }
    let p = DVec2::new(d.dot(right), d.dot(above)) / along;
    let half_size = DVec2::new(0.72, 1.0) * f64::from(studio.key_radius);
    let edge = blur.max(0.008);
    let inside = |off: f64| smoothstep(edge, -edge, off);
    let within = inside(p.x.abs() - half_size.x) * inside(p.y.abs() - half_size.y);
    let bar = (0.07 * half_size.x).max(0.02);
    let panes = |off: f64| smoothstep(-edge, edge, off.abs() - bar);
    let coverage = within * mix(1.0, panes(p.x) * panes(p.y), (-blur * 12.0).exp());
    // The radiance of a window of this solid angle that gives the key's irradiance.
    let solid_angle = 4.0 * half_size.x * half_size.y;
    let sky = 0.75 + 0.25 * (p.y / half_size.y).clamp(-1.0, 1.0);
    studio.key_color.as_dvec3() * (PI / solid_angle * coverage * sky)
}

/// Irradiance / π from the surroundings without the two lamps on a surface of normal `n`.
pub fn studio_ambient(studio: &Studio, n: DVec3) -> DVec3 {
    studio
        .ambient_down
        .as_dvec3()
        .lerp(studio.ambient_up.as_dvec3(), 0.5 + 0.5 * n.y)
}

/// Mean cosine of a lamp over a surface that bends light around its terminator by `wrap` (0:
/// Lambert), never negative.
pub fn wrapped_cosine(cosine: f64, wrap: f64) -> f64 {
    let c = ((cosine + wrap) / (1.0 + wrap)).max(0.0);
    c * c * 0.35 + c * 0.65
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;

    #[test]
    fn the_window_gives_about_the_irradiance_that_it_is_given() {
        // Sum of radiance times solid angle over the window's plane, black surroundings and no fill.
        let studio = Studio {
            fill_color: Vec3::ZERO,
            ambient_up: Vec3::ZERO,
            ambient_down: Vec3::ZERO,
            ..Studio::default()
        };
        let key = studio.key_direction.as_dvec3();
        let right = DVec3::Y.cross(key).normalize();
        let above = key.cross(right);
        let (step, mut sum) = (0.002, 0.0);
        for i in -150..150 {
            for j in -150..150 {
                let (x, y) = (step * (f64::from(i) + 0.5), step * (f64::from(j) + 0.5));
                let d = key + x * right + y * above;
                let cosine = 1.0 / d.length();
                let radiance = studio_radiance(&studio, d.normalize(), 0.0).x;
                // Solid angle of the cell, and the cosine of a surface across the window's axis.
                sum += radiance * step * step * cosine.powi(4);
            }
        }
        let irradiance = sum / (PI * f64::from(studio.key_color.x));
        // Bars of 0.02 across panes of 0.108 and 0.15 leave 0.81 · 0.87, and the sky's fall to the
        // window's foot a quarter less: 0.53; a window without bars would give 0.75.
        assert!((0.5..0.56).contains(&irradiance), "{irradiance}");
    }

    /// A round lamp's light is what it is given, however soft its edge is.
    #[test]
    fn a_round_lamp_gives_the_irradiance_that_it_is_given() {
        for (radius, blur) in [(0.00465, 0.01), (0.07, 0.0), (0.07, 0.16), (0.2, 0.05)] {
            let (step, mut sum) = (0.0005, 0.0);
            for i in 0..1000 {
                let angle = step * (f64::from(i) + 0.5);
                let d = DVec3::new(angle.sin(), 0.0, angle.cos());
                sum += round_lamp(d, DVec3::Z, radius, blur) * 2.0 * angle.sin() * step;
            }
            // Up to the sine of the angle for the angle, at most (0.25 + 0.16)²/6.
            assert!((sum - 1.0).abs() < 0.02, "{radius} {blur}: {sum}");
        }
    }
}
