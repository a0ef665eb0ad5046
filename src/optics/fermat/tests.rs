use super::*;
use crate::optics::cornea::{ANTERIOR_CORNEA, AQUEOUS_INDEX};
use crate::optics::reference::descent::{DescentSettings, fermat_gradient_descent};
use crate::optics::refraction_function::domain::RefractionEye;
use crate::optics::snell::snell_refract;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const LIMBUS: f64 = 5.85;

pub(super) struct Pair {
    pub(super) entry: DVec3,
    pub(super) source: FermatSource,
    pub(super) point: DVec3,
    pub(super) incidence_deg: f64,
}

/// A cornea that a patient file may hold, with its iris plane and limbus.
fn some_eye(rng: &mut Pcg64) -> RefractionEye {
    loop {
        let surface = DVec2::new(
            6.0 + 4.0 * rng.random::<f64>(),
            0.2 + 1.3 * rng.random::<f64>(),
        );
        let limbus_mm = 5.0 + 1.5 * rng.random::<f64>();
        let iris_z_mm = 2.5 + 2.0 * rng.random::<f64>();
        let steepest = surface.x * surface.x - surface.y * limbus_mm * limbus_mm;
        // As the patient file asks: the limbus well short of the equator, the iris behind it.
        if steepest > 0.1 * surface.x * surface.x
            && conicoid_sag(limbus_mm, surface.x, surface.y) < iris_z_mm
        {
            return RefractionEye {
                surface,
                index: 1.3 + 0.1 * rng.random::<f64>(),
                iris_z_mm,
                limbus_mm,
            };
        }
    }
}

/// Legal pairs of an eye, traced forward: entry points within the limbus, sources of the hemisphere
/// in front of the eye, at a distance or not, up to the given exit incidence, iris points within
/// the limbus.
pub(super) fn legal_pairs(
    eye: &RefractionEye,
    count: usize,
    most_deg: f64,
    near: bool,
    rng: &mut Pcg64,
) -> Vec<Pair> {
    let (surface, n) = (eye.surface, eye.index);
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let radius = eye.limbus_mm * rng.random::<f64>().sqrt();
        let (sin, cos) = (rng.random::<f64>() * core::f64::consts::TAU).sin_cos();
        let sag = conicoid_sag(radius, surface.x, surface.y);
        let entry = DVec3::new(radius * cos, radius * sin, sag);
        let normal = conicoid_normal(entry, surface.x, surface.y);
        let incidence = (most_deg * rng.random::<f64>()).to_radians();
        let (sin, cos) = (rng.random::<f64>() * core::f64::consts::TAU).sin_cos();
        let side = normal.any_orthonormal_vector();
        let light =
            incidence.cos() * normal + incidence.sin() * (cos * side + sin * normal.cross(side));
        let ray = snell_refract(-light, normal, 1.0 / n);
        if light.z >= 0.0 || ray.z <= 1e-3 || sag >= eye.iris_z_mm - 0.05 {
            continue;
        }
        let point = entry + (eye.iris_z_mm - entry.z) / ray.z * ray.truncate();
        if point.truncate().length() > eye.limbus_mm {
            continue;
        }
        let source = if near {
            FermatSource::at(entry + 10.0_f64.powf(1.3 + 2.0 * rng.random::<f64>()) * light)
        } else {
            FermatSource::distant(light)
        };
        pairs.push(Pair {
            entry,
            source,
            point,
            incidence_deg: incidence.to_degrees(),
        });
    }
    pairs
}

/// Determinant of the path's second derivatives at the known entry.
fn curvature_at(pair: &Pair, eye: &RefractionEye) -> f64 {
    fermat_residual(
        pair.entry.truncate(),
        pair.point,
        &pair.source,
        eye.surface,
        eye.index,
    )
    .curvature()
}

#[test]
fn six_steps_solve_every_legal_pair_to_1e_10() {
    let mut rng = Pcg64::seed_from_u64(3);
    for near in [false, true] {
        let eye = RefractionEye::default();
        let (mut total, mut most, mut worst) = (0, 0, 0.0_f64);
        let pairs = legal_pairs(&eye, 100_000, 80.0, near, &mut rng);
        for pair in &pairs {
            let found =
                fermat_solve_from(pair.point, &pair.source, eye.surface, eye.index, 6, 1e-26);
            total += found.iterations;
            most = most.max(found.iterations);
            worst = worst.max(found.entry.distance(pair.entry));
            assert!(found.faces_light);
        }
        println!(
            "near {near}: mean {:.2} steps, most {most}, worst {worst:.1e} mm",
            f64::from(total) / pairs.len() as f64
        );
        assert!(most <= 6 && worst < 1e-10);
    }
}

#[test]
fn every_patients_cornea_is_solved() {
    let mut rng = Pcg64::seed_from_u64(5);
    let (mut worst, mut most, mut other, mut all, mut folded) = (0.0_f64, 0, 0, 0, 0);
    for _ in 0..400 {
        let eye = some_eye(&mut rng);
        for pair in legal_pairs(&eye, 200, 80.0, false, &mut rng) {
            if curvature_at(&pair, &eye) <= 2e-5 {
                // Behind a fold: a saddle of the path, as light may take it, but no minimum.
                folded += 1;
                continue;
            }
            all += 1;
            let found = fermat_solve_surely(pair.point, &pair.source, eye.surface, eye.index)
                .unwrap_or_else(|| {
                    panic!(
                        "{eye:?} {:?} {:?} {:?} {}",
                        pair.entry, pair.point, pair.source, pair.incidence_deg
                    )
                });
            let error = found.entry.distance(pair.entry);
            if error > 1e-6 {
                // Another path reaches the same place: both obey Snell's law, and the one found is
                // no maximum or saddle.
                assert!(
                    found.residual < 1e-9 && found.curvature > 0.0,
                    "{eye:?} {:?} {:?} {found:?}",
                    pair.point,
                    pair.source
                );
                other += 1;
            } else {
                worst = worst.max(error * curvature_at(&pair, &eye));
                most = most.max(found.iterations);
            }
        }
    }
    println!(
        "{all} pairs, most {most} steps, error × curvature {worst:.1e}, {other} reached by another path, {folded} behind a fold"
    );
    // A residual of 1e-15 is divided by the smaller curvature of the path, which beside a fold changes
    // within the error.
    assert!(worst < 1e-11);
    assert!(other * 50 < all);
}

#[test]
fn grazing_light_is_solved_as_far_as_it_is_conditioned() {
    let mut rng = Pcg64::seed_from_u64(7);
    let eye = RefractionEye::default();
    let (mut folded, mut worst) = (0, 0.0_f64);
    let pairs = legal_pairs(&eye, 100_000, 89.9, false, &mut rng);
    for pair in &pairs {
        let curvature = curvature_at(pair, &eye);
        // On a fold the entry is known to the root of the residual only.
        if curvature <= 2e-5 {
            folded += 1;
            continue;
        }
        let found = fermat_solve_surely(pair.point, &pair.source, eye.surface, eye.index).unwrap();
        let error = found.entry.distance(pair.entry);
        // Close to a fold the other side of it is as near as this one.
        if error > 1e-4 {
            assert!(found.curvature > 0.0 && found.residual < 1e-9);
        } else {
            worst = worst.max(error * curvature);
        }
    }
    println!(
        "to 89.9°: {folded} of {} behind a fold, error × curvature {worst:.1e}",
        pairs.len()
    );
    assert!(
        folded > 0 && folded * 500 < pairs.len(),
        "the fold is in the sample, and small"
    );
    assert!(worst < 1e-12);
}

#[test]
fn a_far_camera_is_a_distant_light_and_distance_matters_nearby() {
    let (eye, point) = (RefractionEye::default(), DVec3::new(2.0, -1.0, 3.6));
    let direction = DVec3::new(0.6, 0.2, -0.77).normalize();
    let solve = |source: &FermatSource| {
        fermat_solve_from(point, source, eye.surface, eye.index, 6, 1e-28).entry
    };
    let distant = solve(&FermatSource::distant(direction));
    let mut last = f64::INFINITY;
    for distance in [30.0, 300.0, 3e4, 3e6, 3e9] {
        let off = solve(&FermatSource::at(distance * direction)).distance(distant);
        // First order in 1/distance.
        assert!(off < last && off < 40.0 / distance);
        last = off;
    }
    assert_eq!(
        FermatSource::at(DVec3::new(0.0, 0.0, f64::NEG_INFINITY)),
        FermatSource::distant(DVec3::NEG_Z)
    );
}

#[test]
fn the_papers_descent_agrees_within_its_last_step() {
    let mut rng = Pcg64::seed_from_u64(5);
    let eye = RefractionEye::default();
    let (mut evaluations, mut sum) = (0, 0.0);
    let pairs = legal_pairs(&eye, 2000, 70.0, false, &mut rng);
    for pair in &pairs {
        let (k, count) = fermat_gradient_descent(
            pair.point,
            &pair.source,
            eye.surface,
            eye.index,
            DescentSettings::default(),
        );
        evaluations += count;
        sum += k.distance(pair.entry);
    }
    let mean = sum / pairs.len() as f64;
    println!(
        "Algorithm 1: mean {:.0} gradients, mean error {mean:.4} mm",
        f64::from(evaluations) / pairs.len() as f64
    );
    // α/N = 0.005 mm is the descent's own resolution; refraction at the rim stretches it.
    assert!((1e-4..0.02).contains(&mean), "{mean}");
}

#[test]
fn light_that_cannot_arrive_is_reported() {
    let p = DVec3::new(0.0, 0.0, 3.6);
    for light in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
        assert_eq!(
            fermat_entry(p, light, ANTERIOR_CORNEA, AQUEOUS_INDEX, 12).w,
            0.0
        );
    }
    let nothing = fermat_entry(DVec3::NAN, DVec3::NEG_Z, ANTERIOR_CORNEA, AQUEOUS_INDEX, 12);
    assert_eq!(nothing.w, 0.0);
}

#[test]
fn the_axis_is_its_own_path() {
    let k = fermat_entry(
        DVec3::new(0.0, 0.0, 3.6),
        DVec3::NEG_Z,
        ANTERIOR_CORNEA,
        AQUEOUS_INDEX,
        6,
    );
    assert!(k.truncate().length() < 1e-14 && k.w == 1.0);
}

/// A place within the iris, and a source in front of the eye.
fn some_pair() -> impl Strategy<Value = (DVec3, FermatSource)> {
    let angle = 0.0..core::f64::consts::TAU;
    (
        0.0..LIMBUS,
        angle.clone(),
        0.0..75.0_f64,
        angle,
        0.0..0.05_f64,
    )
        .prop_map(|(r, turn, polar, azimuth, inverse_distance)| {
            let (s, c) = polar.to_radians().sin_cos();
            let direction = DVec3::new(s * azimuth.cos(), s * azimuth.sin(), -c);
            let point = DVec3::new(r * turn.cos(), r * turn.sin(), 3.6);
            (
                point,
                FermatSource {
                    direction,
                    inverse_distance,
                },
            )
        })
}

fn solved(point: DVec3, source: &FermatSource) -> FermatSolution {
    fermat_solve_from(point, source, ANTERIOR_CORNEA, AQUEOUS_INDEX, 6, 1e-28)
}

proptest! {
    #[test]
    fn any_displaced_entry_has_a_longer_path((point, source) in some_pair(), turn in 0.0..core::f64::consts::TAU, size in 0.01..0.5_f64) {
        let found = solved(point, &source);
        prop_assume!(found.residual < 1e-9 && found.curvature > 1e-3);
        let k = found.entry.truncate();
        let path = |k: DVec2| fermat_path(k, point, &source, ANTERIOR_CORNEA, AQUEOUS_INDEX);
        let moved = path(k + size * DVec2::from_angle(turn));
        // The path grows by half the least curvature (over 1e-4) times the square of the step.
        prop_assert!(moved > path(k), "{moved} {}", path(k));
    }

    #[test]
    fn turning_or_mirroring_everything_turns_or_mirrors_the_entry((point, source) in some_pair(), turn in 0.0..core::f64::consts::TAU) {
        let found = solved(point, &source);
        prop_assume!(found.residual < 1e-9 && found.curvature > 1e-3);
        let spin = glam::DMat3::from_rotation_z(turn);
        let turned = solved(spin * point, &FermatSource { direction: spin * source.direction, ..source });
        prop_assert!(turned.entry.distance(spin * found.entry) < 1e-10);
        let flip = DVec3::new(1.0, -1.0, 1.0);
        let mirrored = solved(flip * point, &FermatSource { direction: flip * source.direction, ..source });
        prop_assert!(mirrored.entry.distance(flip * found.entry) < 1e-10);
    }

    #[test]
    fn snells_law_holds_at_the_entry_and_back_again((point, source) in some_pair()) {
        let found = solved(point, &source);
        prop_assume!(found.residual < 1e-9 && found.faces_light);
        let normal = conicoid_normal(found.entry, ANTERIOR_CORNEA.x, ANTERIOR_CORNEA.y);
        let inside = snell_refract(-source.from(found.entry), normal, 1.0 / AQUEOUS_INDEX).truncate();
        prop_assert!(inside.distance((point - found.entry).normalize()) < 1e-9);
        let outside = snell_refract(-inside, normal, AQUEOUS_INDEX);
        prop_assert!(outside.w == 1.0 && outside.truncate().distance(source.from(found.entry)) < 1e-7);
    }

    #[test]
    fn nothing_is_ever_not_a_number(x in -20.0..20.0_f64, y in -20.0..20.0_f64, z in -5.0..20.0_f64, a in -1.0..1.0_f64, b in -1.0..1.0_f64, c in -1.0..1.0_f64, q in 0.0..1e3_f64, r in 6.0..10.0_f64, p in -0.5..1.5_f64, n in 1.0..1.6_f64) {
        let source = FermatSource { direction: DVec3::new(a, b, c).normalize_or(DVec3::NEG_Z), inverse_distance: q };
        let found = fermat_solve_from(DVec3::new(x, y, z), &source, DVec2::new(r, p), n, 6, 1e-26);
        prop_assert!(found.entry.is_finite() && found.residual.is_finite() && found.curvature.is_finite());
    }
}
