//! The caustic that the cornea throws on the iris.
//!
//! In: a point of the iris plane (or the entry point of its light), the direction towards a distant
//! light, a surface, the index behind it. Out: the irradiance of the iris plane relative to `E₀`,
//! the irradiance of a plane across the beam.
//!
//! For a distant light
//! `E(P) = E₀ cos θ_K T(θ_K) / (|N_z| |J|)`, `J = det ∂(P_x, P_y)/∂(K_x, K_y)`,
//! with `K` the entry point of the light ([`super::fermat`]), `N` the corneal normal there and `T`
//! the Fresnel transmittance. `J` is the Jacobian of François' refraction function, which the paper
//! leaves out; it comes from differentiating Snell's law.

use super::conicoid::conicoid_normal;
use super::cornea::cornea_trace_single;
use super::fermat::{FERMAT_STEPS, fermat_entry};
use super::fresnel::fresnel_dielectric;
use glam::{DMat2, DVec2, DVec3};

/// Where `|J|` vanishes a point source focuses to a point; a real one, like the sun or a window, is
/// wider than this floor.
const CAUSTIC_SMALLEST_JACOBIAN: f64 = 1e-3;

/// `det ∂(P_x, P_y)/∂(K_x, K_y)`: the area on the plane `z = iris_z` lit through a unit of
/// cross-section of the cornea at the surface point `entry`. Negative past a focus; 0 where the
/// light does not enter or its ray misses the plane.
pub fn caustic_jacobian(
    entry: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    iris_z: f64,
) -> f64 {
    let gradient = DVec3::new(entry.x, entry.y, surface.y * entry.z - surface.x);
    let inverse_length = 1.0 / gradient.length_squared().max(1e-12).sqrt();
    let normal = gradient * inverse_length;
    let cos_in = light_dir.dot(normal);
    let eta = 1.0 / n;
    let cos_out = (1.0 - eta * eta * (1.0 - cos_in * cos_in))
        .max(1e-12)
        .sqrt();
    let gain = eta * cos_in - cos_out;
    let ray = gain * normal - eta * light_dir;
    if cos_in <= 0.0 || ray.z <= 0.0 || gradient.z >= 0.0 {
        return 0.0;
    }
    // d(gain)/d(cos_in): the refracted ray is γ N − η L with γ = η cos_in − cos_out.
    let gain_slope = eta - eta * eta * cos_in / cos_out;
    let height = iris_z - entry.z;
    let per_z = 1.0 / ray.z;
    let surface_slope = -entry.truncate() / gradient.z;

    // How the gradient, the normal, the ray and its landing point move with K along one axis.
    let column = |axis: DVec2, slope: f64| {
        let d_gradient = axis.extend(surface.y * slope);
        let d_normal = (d_gradient - normal * normal.dot(d_gradient)) * inverse_length;
        let d_ray = gain_slope * light_dir.dot(d_normal) * normal + gain * d_normal;
        let d_tangent = (d_ray.truncate() - ray.truncate() * (d_ray.z * per_z)) * per_z;
        axis + height * d_tangent - slope * ray.truncate() * per_z
    };
    DMat2::from_cols(
        column(DVec2::X, surface_slope.x),
        column(DVec2::Y, surface_slope.y),
    )
    .determinant()
}

/// Irradiance at the iris point whose light enters at `entry`, relative to `E₀`.
pub fn caustic_irradiance_at(
    entry: DVec3,
    light_dir: DVec3,
    surface: DVec2,
    n: f64,
    iris_z: f64,
) -> f64 {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let cos_in = light_dir.dot(normal);
    let jacobian = caustic_jacobian(entry, light_dir, surface, n, iris_z).abs();
    if cos_in <= 0.0 || jacobian == 0.0 {
        return 0.0;
    }
    let transmitted = 1.0 - fresnel_dielectric(cos_in, 1.0, n);
    cos_in * transmitted / (normal.z.abs() * jacobian.max(CAUSTIC_SMALLEST_JACOBIAN))
}

/// Irradiance of the iris plane at `iris_point`, relative to `E₀`; 0 where no light arrives. The
/// limbus is not considered: to stop light there, solve [`fermat_entry`], test its radius and call
/// [`caustic_irradiance_at`].
pub fn caustic_irradiance(iris_point: DVec3, light_dir: DVec3, surface: DVec2, n: f64) -> f64 {
    let entry = fermat_entry(iris_point, light_dir, surface, n, FERMAT_STEPS);
    if entry.w == 0.0 {
        return 0.0;
    }
    caustic_irradiance_at(entry.truncate(), light_dir, surface, n, iris_point.z)
}

/// Irradiance of the plane at depth `iris_z` where light of a lamp at `lamp` that enters at `entry` arrives, the lamp having an
/// irradiance of one at a distance of `unit` mm: rays about that one, by their solid angle and where they land. A reference, not
/// for pictures.
pub fn near_irradiance(
    lamp: DVec3,
    entry: DVec3,
    unit: f64,
    surface: DVec2,
    n: f64,
    iris_z: f64,
) -> f64 {
    const STEP: f64 = 1e-5;
    let middle = (entry - lamp).normalize_or(DVec3::Z);
    let (u, v) = middle.any_orthonormal_pair();
    let lands = |a: f64, b: f64| {
        let dir = (middle + STEP * (a * u + b * v)).normalize();
        let trace = cornea_trace_single(lamp, dir, surface, n, iris_z);
        (trace.point, trace.transmittance)
    };
    let along = (lands(1.0, 0.0).0 - lands(-1.0, 0.0).0) / (2.0 * STEP);
    let across = (lands(0.0, 1.0).0 - lands(0.0, -1.0).0) / (2.0 * STEP);
    // unit² sr of intensity make an irradiance of one at that distance.
    unit * unit * lands(0.0, 0.0).1 / along.cross(across).length().max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::conicoid::conicoid_sag;
    use crate::optics::cornea::{ANTERIOR_CORNEA, AQUEOUS_INDEX};
    use crate::optics::refraction_function::domain::RefractionEye;
    use crate::optics::refraction_function::{RefractionFunction, RefractionSize};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    const IRIS_Z: f64 = 3.6;
    const LIMBUS: f64 = 5.85;

    fn light(degrees: f64) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(sin, 0.0, -cos)
    }

    fn surface_point(x: f64, y: f64) -> DVec3 {
        DVec3::new(
            x,
            y,
            conicoid_sag(x.hypot(y), ANTERIOR_CORNEA.x, ANTERIOR_CORNEA.y),
        )
    }

    fn land(entry: DVec3, light_dir: DVec3) -> Option<DVec3> {
        let trace = cornea_trace_single(
            entry + 20.0 * light_dir,
            -light_dir,
            ANTERIOR_CORNEA,
            AQUEOUS_INDEX,
            IRIS_Z,
        );
        (trace.valid == 1.0 && trace.entry.distance(entry) < 1e-9).then_some(trace.point)
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_landing_point() {
        let h = 1e-5;
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            for (x, y) in [(0.0, 0.0), (2.0, 1.0), (5.0, -2.0), (1.0, 5.0)] {
                let l = light(degrees);
                let at = |x: f64, y: f64| land(surface_point(x, y), l).unwrap();
                let d_x = (at(x + h, y) - at(x - h, y)) / (2.0 * h);
                let d_y = (at(x, y + h) - at(x, y - h)) / (2.0 * h);
                let expected = d_x.x * d_y.y - d_x.y * d_y.x;
                let got = caustic_jacobian(
                    surface_point(x, y),
                    l,
                    ANTERIOR_CORNEA,
                    AQUEOUS_INDEX,
                    IRIS_Z,
                );
                // h² times third derivatives, and 1e-14/h of rounding.
                assert!(
                    (got - expected).abs() < 1e-8,
                    "{degrees}° ({x}, {y}): {got} {expected}"
                );
            }
        }
    }

    #[test]
    fn the_brightest_place_is_as_bright_as_computed_before() {
        // DESIGN, "The caustic is the refraction function's Jacobian": brightest irradiance against
        // the same light on the bare plane, for R 7.8, p 0.75, n 1.336, plane 3.6 mm deep, and its
        // distance from the axis where one is given.
        let table = [
            (0.0, 1.25, None),
            (30.0, 1.36, Some(1.6)),
            (60.0, 2.1, Some(2.9)),
            (75.0, 4.2, None),
            (80.0, 7.0, Some(3.7)),
            (85.0, 19.0, None),
        ];
        for (degrees, expected, place) in table {
            let l = light(degrees);
            let (mut best, mut where_x) = (0.0, 0.0);
            for i in -5850..=5850 {
                let entry = surface_point(f64::from(i) * 1e-3, 0.0);
                let Some(point) = land(entry, l) else {
                    continue;
                };
                let bare = -l.z;
                let e =
                    caustic_irradiance_at(entry, l, ANTERIOR_CORNEA, AQUEOUS_INDEX, IRIS_Z) / bare;
                if e > best && point.x.abs() < LIMBUS {
                    (best, where_x) = (e, point.x);
                }
            }
            println!("{degrees}°: {best:.3} at x = {where_x:.2} mm");
            // Two or three digits are given: 3 %.
            assert!(
                (best / expected - 1.0).abs() < 0.03,
                "{degrees}°: {best}, expected {expected}"
            );
            if let Some(place) = place {
                // The light comes from +x: the far side is −x.
                assert!((where_x + place).abs() < 0.06, "{degrees}°: at {where_x}");
            }
        }
    }

    /// Flux through one cell of the cornea's cross-section where its light enters, per `E₀`, and
    /// where it lands.
    fn photon(x: f64, y: f64, l: DVec3) -> Option<(DVec3, f64)> {
        if x.hypot(y) > LIMBUS {
            return None;
        }
        let entry = surface_point(x, y);
        let normal = conicoid_normal(entry, ANTERIOR_CORNEA.x, ANTERIOR_CORNEA.y);
        let cos = l.dot(normal);
        if cos <= 0.0 {
            return None;
        }
        let passed = 1.0 - fresnel_dielectric(cos, 1.0, AQUEOUS_INDEX);
        Some((land(entry, l)?, cos / -normal.z * passed))
    }

    #[test]
    fn ten_million_photons_pile_up_as_predicted_and_keep_their_energy() {
        // Independent oracle: photons of a parallel beam, one in each cell of a jittered grid over
        // the cornea's cross-section, counted in bins of the iris plane; the closed form, by the
        // two-point solver from the other side, integrated over the same plane.
        let mut rng = Pcg64::seed_from_u64(11);
        let eye = RefractionEye::default();
        let function = RefractionFunction::new(eye, RefractionSize::SMALL);
        for degrees in [0.0, 40.0, 70.0] {
            let l = light(degrees);
            let cells = 1826; // squared, 3.3 million; three lights make ten.
            let cell = 2.0 * LIMBUS / f64::from(cells);
            let (bins, bin) = (48, 0.25);
            let mut counted = vec![0.0; bins * bins];
            let mut sent = 0.0;
            let at = |v: f64| ((v + 6.0) / bin) as usize;
            for i in 0..cells {
                for j in 0..cells {
                    let x = (f64::from(i) + rng.random::<f64>()) * cell - LIMBUS;
                    let y = (f64::from(j) + rng.random::<f64>()) * cell - LIMBUS;
                    if let Some((point, flux)) = photon(x, y, l) {
                        sent += flux * cell * cell;
                        if point.x.abs().max(point.y.abs()) < 6.0 {
                            counted[at(point.y) * bins + at(point.x)] += flux * cell * cell;
                        }
                    }
                }
            }
            // 25 × 25 places a bin, 1.4 million in all.
            let fine = 25;
            let step = bin / f64::from(fine);
            let (mut received, mut compared, mut worst) = (0.0, 0, 0.0_f64);
            for row in 0..bins {
                for column in 0..bins {
                    let (mut sum, mut whole) = (0.0, true);
                    for k in 0..fine * fine {
                        let place = DVec2::new(
                            column as f64 * bin - 6.0 + (f64::from(k % fine) + 0.5) * step,
                            row as f64 * bin - 6.0 + (f64::from(k / fine) + 0.5) * step,
                        );
                        let (e, inside) = predicted(&function, place, l);
                        sum += e * step * step;
                        whole &= inside;
                    }
                    received += sum;
                    if whole {
                        compared += 1;
                        worst = worst.max((counted[row * bins + column] / sum - 1.0).abs());
                    }
                }
            }
            println!(
                "{degrees}°: energy {:.2e}, worst of {compared} bins {worst:.2e}",
                received / sent - 1.0
            );
            // The limbus' edge on the finer grid: its length times half a step, by chance in or out.
            assert!(
                (received / sent - 1.0).abs() < 1e-3,
                "{degrees}°: {received} of {sent}"
            );
            // A bin holds some 1500 photons, of which the 150 about its edge come by chance: five sigma.
            assert!(
                compared > 400 && worst < 0.04,
                "{degrees}°: {worst} of {compared} bins"
            );
        }
    }

    /// The closed form at a place, 0 where its light would have to enter outside the limbus, and
    /// whether that is well inside.
    fn predicted(function: &RefractionFunction, place: DVec2, l: DVec3) -> (f64, bool) {
        let mut k = function.entry(place, l);
        for _ in 0..2 {
            k = function.polish(k, place, l);
        }
        // Outside of its domain the function need not be near anything.
        if function.eye().land(k, l).point.distance(place) > 1e-6 {
            let solved = fermat_entry(place.extend(IRIS_Z), l, ANTERIOR_CORNEA, AQUEOUS_INDEX, 12);
            if solved.w == 0.0 {
                return (0.0, false);
            }
            k = solved.truncate().truncate();
        }
        if k.length() > LIMBUS {
            return (0.0, false);
        }
        let e = caustic_irradiance_at(
            surface_point(k.x, k.y),
            l,
            ANTERIOR_CORNEA,
            AQUEOUS_INDEX,
            IRIS_Z,
        );
        (e, k.length() < LIMBUS - 0.1)
    }

    #[test]
    fn light_from_behind_is_dark_and_every_result_finite() {
        let p = DVec3::new(1.0, 2.0, IRIS_Z);
        assert_eq!(
            caustic_irradiance(p, DVec3::Z, ANTERIOR_CORNEA, AQUEOUS_INDEX),
            0.0
        );
        for degrees in 0..=180 {
            for i in -58..=58 {
                let p = DVec3::new(f64::from(i) * 0.1, 0.3, IRIS_Z);
                let e = caustic_irradiance(
                    p,
                    light(f64::from(degrees)),
                    ANTERIOR_CORNEA,
                    AQUEOUS_INDEX,
                );
                assert!(
                    e.is_finite() && (0.0..1e4).contains(&e),
                    "{degrees} {i} {e}"
                );
            }
        }
    }
}
