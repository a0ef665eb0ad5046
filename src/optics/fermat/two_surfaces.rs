//! The two-point problem through both surfaces of the cornea.
//!
//! In: a point of the iris, a source, the two surfaces and indices. Out: where the light passes
//! either surface. The optical path
//!
//! `Φ = |C − K₁| + n₁ |K₁ − K₂| + n₂ |K₂ − P|`
//!
//! is stationary in `K₁` and `K₂`: four equations, solved by Newton's method with the analytic
//! Hessian in 2×2 blocks, from the solution for one surface with the aqueous behind it, which is
//! within a few hundredths of a millimetre ([`crate::optics::cornea`]).

use super::{FermatSource, fermat_solve_from, fermat_widest};
use crate::optics::conicoid::{conicoid_intersect, conicoid_normal, conicoid_sag};
use crate::optics::snell::snell_refract;
use glam::{DMat2, DVec2, DVec3};

/// A cornea of two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSurfaces {
    /// Anterior surface: apical radius (mm) and shape factor.
    pub anterior: DVec2,
    /// Posterior surface, likewise.
    pub posterior: DVec2,
    /// Central thickness (mm).
    pub thickness_mm: f64,
    /// Index of the cornea.
    pub cornea_index: f64,
    /// Index of the aqueous.
    pub aqueous_index: f64,
}

impl Default for TwoSurfaces {
    /// François' anterior surface, Escudero-Sanz & Navarro's posterior one.
    fn default() -> Self {
        use crate::optics::cornea as c;
        Self {
            anterior: c::ANTERIOR_CORNEA,
            posterior: c::POSTERIOR_CORNEA,
            thickness_mm: c::CORNEAL_THICKNESS_MM,
            cornea_index: c::CORNEA_INDEX,
            aqueous_index: c::AQUEOUS_INDEX,
        }
    }
}

/// Where light passes the two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSurfaceSolution {
    /// On the anterior surface (mm).
    pub entry: DVec3,
    /// On the posterior surface (mm).
    pub back: DVec3,
    /// Length of the remaining Snell residual over both surfaces (unitless).
    pub residual: f64,
    /// Newton steps after the single surface's solution.
    pub iterations: u32,
    /// Whether `entry` faces the source.
    pub faces_light: bool,
}

/// A place on a surface: the point, the slopes `∂z/∂(x, y)`, the second derivatives.
struct Place {
    point: DVec3,
    slope: DVec2,
    bend: DMat2,
}

impl Place {
    fn on(surface: DVec2, depth: f64, k: DVec2) -> Self {
        let squared = k.length_squared();
        let s = (surface.x * surface.x - surface.y * squared)
            .max(1e-6)
            .sqrt();
        let slope = k / s;
        Self {
            point: k.extend(depth + squared / (surface.x + s)),
            slope,
            bend: (DMat2::IDENTITY + surface.y * outer(slope, slope)) * (1.0 / s),
        }
    }

    /// Components of a vector along the surface's tangents (1, 0, z_x) and (0, 1, z_y).
    fn tangential(&self, v: DVec3) -> DVec2 {
        v.truncate() + self.slope * v.z
    }
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

/// `t_aᵀ (I − u uᵀ) t_b` for the tangents at two places.
fn between(a: &Place, b: &Place, u: DVec3) -> DMat2 {
    DMat2::IDENTITY + outer(a.slope, b.slope) - outer(a.tangential(u), b.tangential(u))
}

struct Stationarity {
    gradient: [DVec2; 2],
    /// Blocks 11, 12, 22.
    hessian: [DMat2; 3],
}

impl Stationarity {
    fn new(cornea: &TwoSurfaces, k: [DVec2; 2], iris_point: DVec3, source: &FermatSource) -> Self {
        let front = Place::on(cornea.anterior, 0.0, k[0]);
        let back = Place::on(cornea.posterior, cornea.thickness_mm, k[1]);
        let (inside, outside_back) = (front.point - back.point, back.point - iris_point);
        let (l1, l2) = (inside.length().max(1e-6), outside_back.length().max(1e-6));
        let (u1, u2) = (inside / l1, outside_back / l2);
        let (n1, n2) = (cornea.cornea_index, cornea.aqueous_index);
        let to = source.direction - source.inverse_distance * front.point;
        let inverse = 1.0 / to.length().max(1e-9);
        let outside = to * inverse;
        let (g1, g2) = (n1 * u1 - outside, n2 * u2 - n1 * u1);
        Self {
            gradient: [front.tangential(g1), back.tangential(g2)],
            hessian: [
                between(&front, &front, u1) * (n1 / l1)
                    + between(&front, &front, outside) * (source.inverse_distance * inverse)
                    + front.bend * g1.z,
                between(&front, &back, u1) * (-n1 / l1),
                between(&back, &back, u1) * (n1 / l1)
                    + between(&back, &back, u2) * (n2 / l2)
                    + back.bend * g2.z,
            ],
        }
    }

    fn error(&self) -> f64 {
        self.gradient[0].length_squared() + self.gradient[1].length_squared()
    }

    /// Newton's step of both places, by eliminating the second.
    fn step(&self) -> [DVec2; 2] {
        let [h11, h12, h22] = self.hessian;
        let inverse = invert(h22);
        let across = h12 * inverse;
        let first =
            invert(h11 - across * h12.transpose()) * (across * self.gradient[1] - self.gradient[0]);
        let second = -(inverse * (self.gradient[1] + h12.transpose() * first));
        [first, second].map(|step| step.clamp_length_max(2.0))
    }
}

fn invert(m: DMat2) -> DMat2 {
    let determinant = m.determinant();
    let safe = determinant.abs().max(1e-9).copysign(determinant);
    DMat2::from_cols(
        DVec2::new(m.y_axis.y, -m.x_axis.y),
        DVec2::new(-m.y_axis.x, m.x_axis.x),
    ) * (1.0 / safe)
}

/// Solves the two-point problem through both surfaces with at most `steps` Newton steps; it ends
/// early when the squared residual is below `enough`. Finite for every finite argument; where there
/// is no path, `residual` stays large or `faces_light` is false.
pub fn fermat_solve_two_surfaces(
    iris_point: DVec3,
    source: &FermatSource,
    cornea: &TwoSurfaces,
    steps: u32,
    enough: f64,
) -> TwoSurfaceSolution {
    let single = fermat_solve_from(
        iris_point,
        source,
        cornea.anterior,
        cornea.aqueous_index,
        6,
        1e-6,
    );
    let depth = DVec3::new(0.0, 0.0, cornea.thickness_mm);
    let widest = [cornea.anterior, cornea.posterior].map(fermat_widest);
    // Where the ray into the cornea meets the back.
    let entry = single.entry;
    let normal = conicoid_normal(entry, cornea.anterior.x, cornea.anterior.y);
    let ray = snell_refract(-source.from(entry), normal, 1.0 / cornea.cornea_index).truncate();
    let reach =
        conicoid_intersect(entry - depth, ray, cornea.posterior.x, cornea.posterior.y).max(0.0);
    let start = [entry.truncate(), (entry + reach * ray).truncate()];
    let limit = |k: [DVec2; 2]| {
        [
            k[0].clamp_length_max(widest[0]),
            k[1].clamp_length_max(widest[1]),
        ]
    };
    let mut k = limit(start);
    let mut state = Stationarity::new(cornea, k, iris_point, source);
    let (mut iterations, mut share) = (0, 1.0);
    while iterations < steps && state.error() >= enough {
        iterations += 1;
        let step = state.step();
        let candidate = limit([k[0] + share * step[0], k[1] + share * step[1]]);
        let attempt = Stationarity::new(cornea, candidate, iris_point, source);
        if attempt.error() < state.error() {
            (k, state, share) = (candidate, attempt, 1.0);
        } else {
            share *= 0.5;
        }
    }
    let sag = |surface: DVec2, k: DVec2| k.extend(conicoid_sag(k.length(), surface.x, surface.y));
    let entry = sag(cornea.anterior, k[0]);
    TwoSurfaceSolution {
        entry,
        back: sag(cornea.posterior, k[1]) + depth,
        residual: state.error().sqrt(),
        iterations,
        faces_light: conicoid_normal(entry, cornea.anterior.x, cornea.anterior.y)
            .dot(source.from(entry))
            > 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::cornea::cornea_trace;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    const IRIS_Z: f64 = 3.6;

    #[test]
    fn it_finds_the_entries_of_rays_traced_forward() {
        let mut rng = Pcg64::seed_from_u64(9);
        let c = TwoSurfaces::default();
        let (mut worst, mut most, mut off_single, mut count) = (0.0_f64, 0, 0.0_f64, 0);
        while count < 50_000 {
            let radius = 5.5 * rng.random::<f64>().sqrt();
            let turn = rng.random::<f64>() * core::f64::consts::TAU;
            let k = radius * DVec2::from_angle(turn);
            let entry = k.extend(conicoid_sag(radius, c.anterior.x, c.anterior.y));
            let polar = (80.0 * rng.random::<f64>()).to_radians();
            let light = DVec3::new(polar.sin(), 0.0, -polar.cos());
            let incidence = conicoid_normal(entry, c.anterior.x, c.anterior.y).dot(light);
            let trace = cornea_trace(
                entry + 20.0 * light,
                -light,
                c.anterior,
                c.posterior,
                c.thickness_mm,
                c.cornea_index,
                c.aqueous_index,
                IRIS_Z,
            );
            // The thick edge of the cornea may reach the iris plane: then there is no second surface.
            let inside = trace.point - trace.direction;
            if trace.valid == 0.0
                || incidence < 75_f64.to_radians().cos()
                || trace.point.truncate().length() > 5.2
                || trace.entry.distance(entry) > 1e-9
                || inside.z > IRIS_Z
            {
                continue;
            }
            count += 1;
            let source = FermatSource::distant(light);
            let found = fermat_solve_two_surfaces(trace.point, &source, &c, 6, 1e-26);
            worst = worst.max(found.entry.distance(entry));
            most = most.max(found.iterations);
            let single =
                fermat_solve_from(trace.point, &source, c.anterior, c.aqueous_index, 6, 1e-26);
            off_single = off_single.max(single.entry.distance(entry));
        }
        println!(
            "two surfaces: worst {worst:.1e} mm in at most {most} steps; one surface off by {off_single:.3} mm"
        );
        assert!(worst < 1e-10 && most <= 6);
        assert!(off_single > 1e-3, "one surface is an approximation");
    }

    #[test]
    fn equal_indices_are_one_surface() {
        let c = TwoSurfaces {
            cornea_index: 1.336,
            ..TwoSurfaces::default()
        };
        let point = DVec3::new(1.0, -2.0, IRIS_Z);
        for source in [
            FermatSource::distant(DVec3::new(0.5, 0.1, -0.86)),
            FermatSource::at(DVec3::new(20.0, 5.0, -40.0)),
        ] {
            let two = fermat_solve_two_surfaces(point, &source, &c, 8, 1e-28);
            let one = fermat_solve_from(point, &source, c.anterior, 1.336, 8, 1e-28);
            assert!(two.entry.distance(one.entry) < 1e-12 && two.faces_light);
            // The posterior place lies on the straight line between.
            let (a, b) = (
                (two.back - point).normalize(),
                (one.entry - point).normalize(),
            );
            assert!(a.distance(b) < 1e-12);
        }
    }

    #[test]
    fn what_cannot_arrive_is_reported_and_finite() {
        let c = TwoSurfaces::default();
        for direction in [DVec3::Z, DVec3::X, DVec3::new(0.0, 0.6, 0.8)] {
            let found = fermat_solve_two_surfaces(
                DVec3::new(5.0, 0.0, IRIS_Z),
                &FermatSource::distant(direction),
                &c,
                20,
                1e-26,
            );
            assert!(found.entry.is_finite() && found.back.is_finite());
            assert!(!(found.faces_light && found.residual < 1e-9) || direction.z <= 0.0);
        }
    }
}
