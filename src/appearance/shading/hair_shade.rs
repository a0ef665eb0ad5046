//! Lashes and brow hairs: dark fibres with two highlights (Kajiya and Kay 1989).
//! Twin: `shaders/lib/hair_shade.wgsl`.

use super::studio::studio_ambient;
use crate::appearance::materials::Studio;
use glam::DVec3;

/// Radiance of a fibre of this colour along the unit direction `along`, seen from `v`.
pub fn hair_radiance(studio: &Studio, color: DVec3, along: DVec3, v: DVec3) -> DVec3 {
    let (key, light) = (studio.key_direction.as_dvec3(), studio.key_color.as_dvec3());
    let sine_to = |d: DVec3| (1.0 - along.dot(d) * along.dot(d)).max(0.0).sqrt();
    let s = sine_to((key + v).normalize());
    let ambient = studio_ambient(studio, DVec3::new(0.0, 0.3, -0.9));
    let body = light * (0.20 + 0.55 * sine_to(key)) + 0.8 * ambient;
    let highlights = 0.035 * s.powi(60) + color * (0.35 * s.powi(14));
    color * body + light * highlights
}
