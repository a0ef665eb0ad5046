//! Lashes and brow hairs: dark fibres with two highlights (Kajiya and Kay 1989).
//! Twin: `shaders/lib/hair_shade.wgsl`.

use glam::DVec3;

/// Radiance of a fibre of this colour along the unit direction `along`, seen from `v`, under a lamp from
/// the unit direction `light` with an irradiance / π of one.
pub fn hair_lamp(color: DVec3, along: DVec3, v: DVec3, light: DVec3) -> DVec3 {
    let sine_to = |d: DVec3| (1.0 - along.dot(d) * along.dot(d)).max(0.0).sqrt();
    let s = sine_to((light + v).normalize());
    color * (0.20 + 0.55 * sine_to(light) + 0.35 * s.powi(14)) + 0.035 * s.powi(60)
}

/// The same under surroundings that send this irradiance / π to a face.
pub fn hair_ambient(color: DVec3, ambient: DVec3) -> DVec3 {
    0.8 * color * ambient
}

/// An edge of the ribbon that draws a hair, this half width (of either sign) aside of its centre line as it is seen from `camera`;
/// `along` and `chord` (from root to tip) are unit vectors. The chord tells which side is which where the hair bends towards the
/// camera and away again.
pub fn hair_ribbon(
    center: DVec3,
    along: DVec3,
    chord: DVec3,
    camera: DVec3,
    half_width: f64,
) -> DVec3 {
    let v = (camera - center).normalize();
    let aside = along.cross(v);
    let turned = if aside.dot(chord.cross(v)) >= 0.0 {
        1.0
    } else {
        -1.0
    };
    center + aside * (turned * half_width / aside.length().max(1e-4))
}
