//! Errors of the precomputed refraction function through a patient's cornea, and the caustic's peak.
//!
//! In: an eye, how many random pairs. Leaves: bytes and errors of each size, before and after one
//! polishing step, in the domain, near folds and in the rim of grazing light; the brightest place of
//! the iris by the angle of the light.
//!
//! **Pairs.** A place `P` uniform over the disc of the limbus in the iris plane and a direction
//! uniform over the hemisphere in front of the eye, from a seeded stream. The two-point solver
//! ([`crate::optics::fermat`]) finds `K`, to rounding; pairs without a path, or whose `K` lies beyond
//! the limbus, are drawn again. The error is the distance (mm) of the function's entry point from
//! `K`, in x and y as the function gives it.
//!
//! **The reference itself** is measured on pairs of the domain that need no solver: `K` uniform over
//! the disc of the limbus, `P` where Snell's law sends the light. A pair that the solver would miss is
//! missing from the first kind, and stands here as its largest error. Beyond the domain several `K` may
//! lead to one `P`, and the solver's is one of them.

use super::{MeasuredEye, NullReasons, known};
use crate::optics::caustic::{caustic_irradiance_at, caustic_jacobian};
use crate::optics::conicoid::conicoid_sag;
use crate::optics::fermat::fermat_solve;
use crate::optics::refraction_function::domain::{
    EXIT_INCIDENCE_DEG, GREATEST_STRETCH, RefractionEye,
};
use crate::optics::refraction_function::{RefractionFunction, RefractionSize};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "François, Gautron, Breton & Bouatouch 2007, section 5.1 (the function, and \
     francois_2007_error_mm: 10 × 100 samples in 12 KB, 100 × 2,500 in 300 KB)",
    "optics::fermat, the two-point solver against which errors are measured",
    "optics::caustic, the Jacobian of the refraction function",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "Pairs: P uniform over the disc of the limbus in the iris plane, light uniform over the \
     hemisphere, seeded; kept where light arrives through a K within the limbus.",
    "zone domain: exit incidence at K of 0 to 80 degrees, in front of folds (|dK/dP| at most 50, \
     light at most domain_greatest_light_deg from the axis). zone near-fold: the same exit \
     incidence, but nearer to a fold. zone rim: exit incidence of 80 to 90 degrees.",
    "Errors are distances at K in the plane across the axis (mm). Those of small and large are from \
     the two-point solver; those of size solver are the solver's own, on pairs traced forward (K \
     uniform over the disc of the limbus, P where Snell's law sends the light). Near folds several K \
     may lead to one P, and the solver's is one of them.",
    "polishing_steps: Newton steps on Snell's law after the look-up.",
    "caustic: brightest place of the iris for a distant light, relative to the same light on the \
     bare iris plane (peak_of_bare_plane) and to a plane across the beam (peak_of_beam), Fresnel \
     losses included; at_mm is its place on the iris, negative on the side away from the light.",
];

/// Seed of the pairs.
const SEED: u64 = 20_070_501;
/// Pairs drawn for each one wanted before giving up, so that a cornea that keeps few takes no longer.
const DRAWS_PER_PAIR: usize = 4;
/// Steps of the solver and its squared residual.
const SOLVER_STEPS: u32 = 40;
const SOLVER_ENOUGH: f64 = 1e-26;

/// Where pairs belong.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Zone {
    Domain,
    NearFold,
    Rim,
}

impl Zone {
    const ALL: [Self; 3] = [Self::Domain, Self::NearFold, Self::Rim];

    fn name(self) -> &'static str {
        match self {
            Self::Domain => "domain",
            Self::NearFold => "near-fold",
            Self::Rim => "rim",
        }
    }
}

/// Error of one size in one zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefractionRow {
    /// `small` or `large`, or `solver`: the two-point solver.
    pub size: &'static str,
    /// Bytes of its tables.
    pub bytes: usize,
    /// `domain`, `near-fold` or `rim`.
    pub zone: &'static str,
    /// Newton steps after the look-up.
    pub polishing_steps: u32,
    /// Pairs that were measured.
    pub pairs: usize,
    /// Largest error (mm).
    pub error_max_mm: Option<f64>,
    /// The error that 999 of 1000 pairs do not exceed (mm).
    pub error_p999_mm: Option<f64>,
    /// Root mean square error (mm).
    pub error_rms_mm: Option<f64>,
    /// The error that François et al. state for a table of these bytes (mm).
    pub francois_2007_error_mm: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// The brightest place of the iris under one light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CausticRow {
    /// Angle of the light from the axis (degrees).
    pub light_deg: f64,
    /// Irradiance there over that of the bare plane.
    pub peak_of_bare_plane: Option<f64>,
    /// Irradiance there over that of a plane across the beam.
    pub peak_of_beam: Option<f64>,
    /// Its place on the iris (mm), negative on the side away from the light.
    pub at_mm: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefractionTable {
    /// Greatest angle of a light from the axis in the domain (degrees).
    pub domain_greatest_light_deg: f64,
    /// Greatest exit incidence in the domain (degrees).
    pub domain_greatest_exit_incidence_deg: f64,
    /// Seed of the pairs.
    pub seed: u64,
    /// Errors.
    pub rows: Vec<RefractionRow>,
    /// The caustic.
    pub caustic: Vec<CausticRow>,
}

/// What the refraction function depends on.
pub fn refraction_eye(eye: &MeasuredEye) -> RefractionEye {
    RefractionEye {
        surface: eye.anterior(),
        index: eye.aqueous_index,
        iris_z_mm: eye.iris_depth_mm,
        limbus_mm: eye.limbus_radius_mm,
    }
}

/// Errors (mm) of one zone: small and large, each before and after polishing.
type Errors = [Vec<f64>; 4];

/// Measures both sizes on `pairs` pairs of the domain, with what falls into the other zones on the way,
/// the solver on a quarter as many, and the caustic. Fewer where the eye keeps next to none.
pub fn measure_pairs(eye: &MeasuredEye, pairs: usize) -> RefractionTable {
    let eye = refraction_eye(eye);
    let greatest = eye.greatest_half_tangent();
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut rows = measure_functions(&eye, greatest, pairs, &mut random);
    rows.push(measure_solver(&eye, greatest, pairs / 4, &mut random));
    RefractionTable {
        domain_greatest_light_deg: 2.0 * greatest.atan().to_degrees(),
        domain_greatest_exit_incidence_deg: EXIT_INCIDENCE_DEG,
        seed: SEED,
        rows,
        caustic: caustic(&eye),
    }
}

fn measure_functions(
    eye: &RefractionEye,
    greatest: f64,
    pairs: usize,
    random: &mut Pcg64,
) -> Vec<RefractionRow> {
    let functions = [RefractionSize::SMALL, RefractionSize::LARGE]
        .map(|size| RefractionFunction::new(*eye, size));
    let mut zones: [Errors; 3] = Default::default();
    for _ in 0..pairs.saturating_mul(DRAWS_PER_PAIR) {
        if zones[0][0].len() >= pairs {
            break;
        }
        let (place, light) = (anywhere(eye, random), light(random));
        let Some(entry) = solve(eye, place, light) else {
            continue;
        };
        let errors = &mut zones[zone(eye, greatest, entry, light) as usize];
        for (function, errors) in functions.iter().zip(errors.chunks_exact_mut(2)) {
            let raw = function.entry(place, light);
            errors[0].push(raw.distance(entry));
            errors[1].push(function.polish(raw, place, light).distance(entry));
        }
    }
    let mut rows = Vec::new();
    for (which, (size, paper_mm)) in [("small", 0.4), ("large", 0.08)].into_iter().enumerate() {
        for zone in Zone::ALL {
            for steps in 0..2 {
                let errors = &mut zones[zone as usize][2 * which + steps];
                let table = (size, functions[which].bytes());
                rows.push(row(table, zone, steps as u32, errors, Some(paper_mm)));
            }
        }
    }
    rows
}

/// The solver's own error, on pairs that Snell's law makes.
fn measure_solver(
    eye: &RefractionEye,
    greatest: f64,
    pairs: usize,
    random: &mut Pcg64,
) -> RefractionRow {
    let mut errors = Vec::with_capacity(pairs);
    for _ in 0..pairs.saturating_mul(DRAWS_PER_PAIR) {
        if errors.len() >= pairs {
            break;
        }
        let (entry, light) = (anywhere(eye, random), light(random));
        let place = eye.land(entry, light).point;
        let inside = place.length() <= eye.limbus_mm;
        if inside && zone(eye, greatest, entry, light) == Zone::Domain {
            // A miss counts as the width of the cornea.
            let missed = 2.0 * eye.limbus_mm;
            errors.push(solve(eye, place, light).map_or(missed, |k| k.distance(entry)));
        }
    }
    row(("solver", 0), Zone::Domain, 0, &mut errors, None)
}

/// A place uniform over the disc of the limbus.
fn anywhere(eye: &RefractionEye, random: &mut Pcg64) -> DVec2 {
    eye.limbus_mm * random.random::<f64>().sqrt() * turned(random)
}

/// A direction uniform over the hemisphere in front of the eye.
fn light(random: &mut Pcg64) -> DVec3 {
    // The cosine to the axis is uniform.
    let cos = 1.0 - random.random::<f64>();
    ((1.0 - cos * cos).sqrt() * turned(random)).extend(-cos)
}

fn turned(random: &mut Pcg64) -> DVec2 {
    DVec2::from_angle(random.random_range(0.0..core::f64::consts::TAU))
}

/// The entry point; none where no light arrives through the cornea.
fn solve(eye: &RefractionEye, place: DVec2, light: DVec3) -> Option<DVec2> {
    let point = place.extend(eye.iris_z_mm);
    let (steps, enough) = (SOLVER_STEPS, SOLVER_ENOUGH);
    let found = fermat_solve(point, light, eye.surface, eye.index, steps, enough);
    let entry = found.entry.truncate();
    let arrives = found.faces_light
        && found.residual < 1e-9
        && found.curvature > 0.0
        && found.entry.z < eye.iris_z_mm
        && entry.length() <= eye.limbus_mm + 1e-9;
    arrives.then_some(entry)
}

fn zone(eye: &RefractionEye, greatest: f64, entry: DVec2, light: DVec3) -> Zone {
    if eye.land(entry, light).cos_incidence < EXIT_INCIDENCE_DEG.to_radians().cos() {
        Zone::Rim
    } else if half_tangent(light) <= greatest && eye.is_in_domain(entry, light) {
        Zone::Domain
    } else {
        Zone::NearFold
    }
}

fn half_tangent(light: DVec3) -> f64 {
    light.truncate().length() / (1.0 - light.z)
}

fn row(
    (size, bytes): (&'static str, usize),
    zone: Zone,
    polishing_steps: u32,
    errors: &mut [f64],
    paper_mm: Option<f64>,
) -> RefractionRow {
    let mut null_reasons = NullReasons::new();
    let count = errors.len();
    let mut measured = |key, value: f64| {
        let value = (count > 0).then_some(value);
        known(
            &mut null_reasons,
            key,
            value,
            "no pair of this eye falls here",
        )
    };
    let largest = errors.iter().copied().fold(0.0, f64::max);
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    let p999 = match count {
        0 => 0.0,
        _ => {
            let rank = (count - 1) * 999 / 1000;
            *errors.select_nth_unstable_by(rank, f64::total_cmp).1
        }
    };
    RefractionRow {
        size,
        bytes,
        zone: zone.name(),
        polishing_steps,
        pairs: count,
        error_max_mm: measured("error_max_mm", largest),
        error_p999_mm: measured("error_p999_mm", p999),
        error_rms_mm: measured("error_rms_mm", (squares / count.max(1) as f64).sqrt()),
        francois_2007_error_mm: known(
            &mut null_reasons,
            "francois_2007_error_mm",
            paper_mm,
            "no table",
        ),
        null_reasons,
    }
}

/// Places of the cornea along the light's meridian at which the caustic is computed, each 1 µm apart
/// from the next at most 6.5 mm.
const CAUSTIC_PLACES: i32 = 13_000;

fn caustic(eye: &RefractionEye) -> Vec<CausticRow> {
    (0..=17)
        .map(|i| caustic_row(eye, 5.0 * f64::from(i)))
        .collect()
}

/// The brightest place lies on the light's meridian, by symmetry.
fn caustic_row(eye: &RefractionEye, light_deg: f64) -> CausticRow {
    let light = RefractionEye::light((0.5 * light_deg.to_radians()).tan());
    let (surface, index, iris_z) = (eye.surface, eye.index, eye.iris_z_mm);
    let (mut brightest, mut at, mut folded) = (0.0, 0.0, false);
    for i in 0..=CAUSTIC_PLACES {
        let x = eye.limbus_mm * (2.0 * f64::from(i) / f64::from(CAUSTIC_PLACES) - 1.0);
        let place = eye.land(DVec2::new(x, 0.0), light);
        let entry = DVec3::new(x, 0.0, conicoid_sag(x.abs(), surface.x, surface.y));
        let reaches =
            place.cos_incidence > 0.0 && entry.z < iris_z && place.point.length() <= eye.limbus_mm;
        if !reaches {
            continue;
        }
        folded |= caustic_jacobian(entry, light, surface, index, iris_z) < 0.0;
        let irradiance = caustic_irradiance_at(entry, light, surface, index, iris_z);
        if irradiance > brightest {
            (brightest, at) = (irradiance, place.point.x);
        }
    }
    let mut null_reasons = NullReasons::new();
    let mut peak = |key, value: f64| {
        let reason = if folded {
            "two paths merge on the iris: a point source is unboundedly bright there"
        } else {
            "no light reaches the iris"
        };
        let value = (!folded && brightest > 0.0).then_some(value);
        known(&mut null_reasons, key, value, reason)
    };
    CausticRow {
        light_deg,
        peak_of_bare_plane: peak("peak_of_bare_plane", brightest / -light.z),
        peak_of_beam: peak("peak_of_beam", brightest),
        at_mm: peak("at_mm", at),
        null_reasons,
    }
}

/// The limit that the notes state.
const _: () = assert!(GREATEST_STRETCH == 50.0);
