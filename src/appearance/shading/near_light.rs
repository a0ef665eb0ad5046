//! Light of a lamp that is near, on the iris: its rays are those of distant lamps, each of its own
//! direction, and spread from a point. Optics frame, mm. Twin: `shaders/lib/near_light.wgsl`.

use super::surroundings::lamp_from;
use crate::appearance::illumination::Lamp;
use crate::appearance::images::MapView;
use crate::appearance::light_table::iris_light;
use crate::optics::conicoid::{conicoid_intersect, conicoid_normal};
use crate::optics::fresnel::fresnel_dielectric;
use glam::{DVec2, DVec3};

/// Where light that arrives at `point` from the unit direction `towards` entered the cornea.
pub fn light_entry(point: DVec3, towards: DVec3, surface: DVec2) -> DVec3 {
    point + conicoid_intersect(point, towards, surface.x, surface.y).max(0.0) * towards
}

/// Irradiance by a lamp that is 1/`vergence` mm from where its light enters, over that by a distant one
/// from the same side (`light`, unit), which is `concentrated` times its own across the beam; `n` is the
/// index behind the surface. The beam of the distant one is taken to be narrowed alike in both of its
/// principal sections.
pub fn near_concentration(
    concentrated: f64,
    entry: DVec3,
    point: DVec3,
    light: DVec3,
    surface: DVec2,
    n: f64,
    vergence: f64,
) -> f64 {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let path = entry.distance(point);
    let towards = (entry - point) / path.max(1e-6);
    let outside = light.dot(normal).clamp(0.05, 1.0);
    let inside = towards.dot(normal).clamp(0.05, 1.0);
    let passed = 1.0 - fresnel_dielectric(outside, 1.0, n);
    // What is left of the beam's width along a principal section.
    let left = outside * passed * (-towards.z).max(0.0) / (inside * concentrated.max(1e-3));
    let narrowed = left.sqrt().clamp(0.2, 1.0);
    let spread = path * vergence / n;
    let slant = outside / inside;
    narrowed * narrowed / ((narrowed + spread) * (narrowed + spread * slant * slant))
}

/// Where light from the unit direction `light` before the cornea that reaches a place `height` mm before the plane of the table would
/// cross that, mm; about, as a level cornea would turn it.
pub fn crosses_plane(at: DVec2, height: f64, light: DVec3, n: f64) -> DVec2 {
    let slant = light.truncate() / n;
    at - slant * (height / (1.0 - slant.length_squared()).max(0.1).sqrt())
}

/// How a beam that has entered at `entry` converges at `point`, 1/mm, across the meridian and along it: the cornea focuses it
/// (Coddington's equations, the plane of incidence taken for the meridian's). `vergence` (1/mm) is that of a near lamp.
pub fn beam_gathers(
    entry: DVec3,
    point: DVec3,
    light: DVec3,
    surface: DVec2,
    n: f64,
    vergence: f64,
) -> DVec2 {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let path = entry.distance(point);
    let towards = (entry - point) / path.max(1e-6);
    let outside = light.dot(normal).clamp(0.05, 1.0);
    let inside = towards.dot(normal).clamp(0.05, 1.0);
    // Radii of curvature across the meridian and along it.
    let aside = entry.truncate().length_squared();
    let across = (surface.x * surface.x + (1.0 - surface.y) * aside).sqrt();
    let along = across.powi(3) / (surface.x * surface.x);
    let power = n * inside - outside;
    let sagittal = (power / across - vergence) / n;
    let tangential = (power / along - vergence * outside * outside) / (n * inside * inside);
    // Light that found no entry has no way of its own.
    if path <= 1e-6 {
        return DVec2::ZERO;
    }
    let there = |focus: f64| focus / (1.0 - focus * path).max(0.2);
    DVec2::new(there(sagittal), there(tangential))
}

/// How many times as strong a beam that converges so (1/mm, [`beam_gathers`]) is `way` mm on, and by which share of itself (1/mm) it grows
/// there.
pub fn beam_on(converges: DVec2, way: f64) -> DVec2 {
    let left = (DVec2::ONE - converges * way).max(DVec2::splat(0.3));
    DVec2::new(
        1.0 / (left.x * left.y),
        converges.x / left.x + converges.y / left.y,
    )
}

/// A lamp (its direction in the eye frame) as it is where its light to `point` of the iris enters the cornea,
/// with the light that its own beam brings there instead of a distant one's: its direction, and by how much its
/// colour is more. `apex` is the corneal one's place from the globe's centre; `n`, `surface` are the cornea's,
/// the rest is the table's ([`crate::appearance::light_table`]).
#[expect(clippy::too_many_arguments, reason = "the shader twin's argument list")]
pub fn iris_near_lamp(
    table: &MapView,
    own: &Lamp,
    apex: DVec3,
    point: DVec3,
    surface: DVec2,
    n: f64,
    root_mm: f64,
    limbus_mm: f64,
) -> (DVec3, f64) {
    let mut lamp = lamp_from(own, apex);
    let (mut entry, mut light, mut concentrated) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for _ in 0..2 {
        light = lamp.0;
        let arrives = iris_light(table, light, point.truncate(), root_mm, limbus_mm);
        entry = light_entry(point, arrives.truncate(), surface);
        concentrated = arrives.w;
        lamp = lamp_from(own, apex + entry);
    }
    let (direction, nearer) = lamp;
    let vergence = f64::from(own.vergence) * nearer;
    let near = near_concentration(concentrated, entry, point, light, surface, n, vergence);
    (direction, nearer * nearer * near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::light_table::LightTableSettings;
    use crate::optics::caustic::near_irradiance;

    const EYE: LightTableSettings = LightTableSettings {
        surface: DVec2::new(7.8, 0.75),
        index: 1.336,
        iris_z: 3.6,
        root_mm: 6.05,
        limbus_mm: 5.85,
    };

    /// Where light from `lamp` to `point` enters, by as many steps as the picture takes, or until nothing changes.
    fn entry(lamp: DVec3, point: DVec3, steps: usize) -> (DVec3, DVec3, f64) {
        let mut from = DVec3::ZERO;
        let mut found = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for _ in 0..=steps {
            let light = (lamp - from).normalize();
            let exact = EYE.exact(light, point.truncate());
            let aside = exact.towards;
            let towards = aside.extend(-(1.0 - aside.length_squared()).max(0.0).sqrt());
            from = light_entry(point, towards, EYE.surface);
            found = (from, light, exact.unbounded_irradiance);
        }
        found
    }

    #[test]
    fn a_beam_gathers_as_its_rays_do_further_in() {
        let (mut worst, mut least, mut largest) = (0.0_f64, f64::MAX, 0.0_f64);
        for degrees in [0.0_f64, 20.0, 40.0, 60.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let light = DVec3::new(sin, 0.0, -cos);
            for i in -4..=4 {
                for j in -4..=4 {
                    let place = DVec2::new(f64::from(i), f64::from(j));
                    let exact = EYE.exact(light, place);
                    if place.length() > 4.5 || exact.entry_radius_mm > 5.0 {
                        continue;
                    }
                    let aside = exact.towards;
                    let towards = aside.extend(-(1.0 - aside.length_squared()).sqrt());
                    let point = place.extend(EYE.iris_z);
                    let entry = light_entry(point, towards, EYE.surface);
                    let gathers = beam_gathers(entry, point, light, EYE.surface, EYE.index, 0.0);
                    let across = exact.unbounded_irradiance / -towards.z;
                    for further in [-0.6, -0.2, 0.3, 0.6] {
                        let on = point - towards * further;
                        let there = LightTableSettings {
                            iris_z: on.z,
                            ..EYE
                        };
                        let there = there.exact(light, on.truncate());
                        assert!(there.towards.distance(exact.towards) < 1e-9);
                        let change = there.unbounded_irradiance / -towards.z / across - 1.0;
                        let grown = beam_on(gathers, further).x - 1.0;
                        worst = worst.max((grown - change).abs());
                        least = least.min((change / further).abs());
                        largest = largest.max(change.abs());
                    }
                }
            }
        }
        println!(
            "irradiance of a beam up to 0.6 mm back and on: off by {worst:.1e}, changes by {least:.1e} a mm and more, {largest:.1e} at most"
        );
        // As if it did not, it would be off by all of its change.
        assert!(worst < 0.013 && largest > 3.0 * worst, "{worst} {largest}");
    }

    /// A ring flash at its nearest, a penlight, a lamp on a table.
    #[test]
    fn a_near_lamp_lights_the_iris_as_its_rays_do() {
        for distance in [45.0, 100.0, 300.0] {
            let (mut astray, mut off, mut ignored) = (0.0_f64, 0.0_f64, 0.0_f64);
            let mut squares = [0.0_f64; 2];
            for degrees in [0.0_f64, 20.0, 40.0, 55.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let lamp = DVec3::new(sin, 0.3 * sin, -cos).normalize() * distance;
                for i in -4..=4 {
                    for j in -4..=4 {
                        let place = DVec2::new(f64::from(i), f64::from(j)) * 1.25;
                        if place.length() > 5.3 {
                            continue;
                        }
                        let point = place.extend(EYE.iris_z);
                        let (truth, _, lit) = entry(lamp, point, 20);
                        // What limbus and critical angle keep away is not lit.
                        if truth.truncate().length() > 5.85 || lit <= 0.0 {
                            continue;
                        }
                        let (enters, light, concentrated) = entry(lamp, point, 2);
                        astray = astray.max(enters.distance(truth));
                        let away = lamp.distance(enters);
                        let near = near_concentration(
                            concentrated,
                            enters,
                            point,
                            light,
                            EYE.surface,
                            EYE.index,
                            1.0 / away,
                        );
                        let across = (distance / away).powi(2) * concentrated;
                        let (surface, n, depth) = (EYE.surface, EYE.index, EYE.iris_z);
                        let wanted = near_irradiance(lamp, truth, distance, surface, n, depth);
                        let errors = [across * near, across].map(|found| found / wanted - 1.0);
                        off = off.max(errors[0].abs());
                        ignored = ignored.max(errors[1].abs());
                        squares[0] += errors[0] * errors[0];
                        squares[1] += errors[1] * errors[1];
                    }
                }
            }
            println!(
                "{distance} mm: entry {astray:.1e} mm, irradiance {off:.4}, as if its beam were parallel {ignored:.4}"
            );
            assert!(astray < 2e-3, "{astray}");
            assert!(off < 0.02, "{distance}: {off}");
            // Where grazing light is narrowed most, its two sections differ; elsewhere next to nothing is left.
            let [ours, parallel] = squares.map(f64::sqrt);
            assert!(parallel > 5.0 * ours, "{distance}: {ours} {parallel}");
        }
    }
}
