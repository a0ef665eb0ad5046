//! How good is the blur disc? The geometric blur of a point on the retina of a schematic eye, by real
//! rays, beside the simple angle `A |1/D − 1/P|` of [`crate::optics::defocus`].
//!
//! In: an eye, the diameter of its entrance pupil, the distance of a point on the axis. Out: a
//! [`TracedBlur`]: the extent and the RMS width of the spot as visual angles, and the simple formula in
//! two readings.
//!
//! Visual angle is retinal distance over the chief ray's millimetres per radian
//! ([`Paraxial::retina_mm_per_radian`](super::paraxial::Paraxial)), the scale on which the simple
//! formula is exact to first order when its three numbers are the right ones: A the diameter of the
//! *entrance pupil* (the stop is 13 % smaller), D and P counted from the *entrance pupil* (3 mm behind
//! the cornea), and P the eye's *paraxial* focus.
//!
//! What the formula leaves out is aberration. For Navarro's eye, relaxed (RMS width of the spot over
//! the simple angle; [`blur_table`] for any other case):
//!
//! | pupil (mm) | 10 cm | 25 cm | 50 cm | 1 m | 2 m | 5 m |
//! |---|---|---|---|---|---|---|
//! | 1 | 1.00 | 0.99 | 0.99 | 0.98 | 0.96 | 0.89 |
//! | 2 | 0.99 | 0.98 | 0.96 | 0.91 | 0.83 | 0.59 |
//! | 3 | 0.98 | 0.95 | 0.90 | 0.80 | 0.62 | 0.36 |
//! | 4 | 0.96 | 0.90 | 0.81 | 0.64 | 0.38 | 1.08 |
//! | 6 | 0.90 | 0.77 | 0.57 | 0.36 | 1.08 | 3.94 |
//!
//! The ratio is about `1 − 0.027 A²/defocus` (A in mm, defocus in D): spherical aberration makes the
//! outer zones of the eye myopic, by 0.96 D of shift and 7 arcmin of width that no focus removes at
//! 6 mm, so that near points are sharper and far points more blurred than the disc says. It is right to
//! 5 % beyond half a dioptre per mm² of A², to 20 % beyond an eighth, and wrong altogether near focus
//! through wide pupils. With P taken where the eye would be refracted (least RMS of the wavefront) the
//! error halves. Accommodated by 5 D the eye has little spherical aberration, and the disc is right to
//! 5 % from 0.8 D of defocus on, up to 5 mm.
//!
//! [`aberrated_blur_disc`] adds spherical aberration in closed form: within 1.5 % of the traced width
//! everywhere in that range.

use super::paraxial::{Meridian, Paraxial, paraxial};
use super::wavefront::{ObjectPoint, stop_radius_for, trace_wavefront};
use crate::optics::defocus::{defocus_blur_angle, vergence_of_distance};
use crate::optics::ray_trace::Ray;
use crate::optics::schematic_eye::{SODIUM_NM, SchematicEye};
use glam::DVec3;

/// Rays along a radius of the pupil, without the one in the middle. Even, for Simpson's rule.
const RAYS: usize = 48;

/// The blur of a point on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedBlur {
    /// Diameter of the smallest circle about the chief ray that holds every ray (rad).
    pub extent_rad: f64,
    /// Diameter of the uniform disc with the same RMS radius (rad): √8 times that radius. For a disc of
    /// pure defocus it is the extent.
    pub rms_disc_rad: f64,
    /// The simple formula with the entrance pupil's diameter, vergences at the entrance pupil and the
    /// eye's paraxial focus (rad).
    pub simple_rad: f64,
    /// The simple formula with vergences at the cornea, as from a distance measured to the eye (rad).
    pub simple_at_cornea_rad: f64,
    /// The simple formula as [`Self::simple_rad`], but with the focus that leaves the least RMS
    /// aberration over this pupil, which is how eyes with aberrations are refracted (rad); NaN-free, 0
    /// where that wavefront cannot be traced.
    pub simple_best_focus_rad: f64,
}

/// One line of [`blur_table`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurRow {
    /// Distance of the point from the cornea (m).
    pub distance_m: f64,
    /// Diameter of the entrance pupil (mm).
    pub pupil_diameter_mm: f64,
    /// Accommodation asked of Navarro's eye (D).
    pub accommodation_d: f64,
    /// The blur; `None` where rays of the pupil do not reach the retina.
    pub blur: Option<TracedBlur>,
}

impl BlurRow {
    /// Traced over simple, by RMS width; `None` where there is no blur to speak of (below a quarter of
    /// an arc minute by the simple formula) or no trace.
    pub fn ratio(&self) -> Option<f64> {
        let blur = self.blur?;
        let least = 0.25_f64.to_radians() / 60.0;
        (blur.simple_rad > least).then(|| blur.rms_disc_rad / blur.simple_rad)
    }
}

/// The blur of a point on the axis, `distance_m` in front of the cornea (1 mm to infinity; nearer
/// counts as 1 mm), through an entrance pupil of `pupil_diameter_mm` (as a distant observer on the axis
/// sees it). `None` for a pupil that is not between 0.01 and 10 mm, and where a ray of the pupil does
/// not reach the retina.
pub fn traced_blur(
    eye: &SchematicEye,
    pupil_diameter_mm: f64,
    distance_m: f64,
) -> Option<TracedBlur> {
    if !(0.01..=10.0).contains(&pupil_diameter_mm) {
        return None;
    }
    let open = eye.clone().with_stop_radius(f64::INFINITY);
    let constants = paraxial(&open, Meridian::Vertical);
    let entrance = constants.entrance_pupil;
    let at_cornea = vergence_of_distance(distance_m);
    // The pupil is deeper than the cornea: V/(1 + z V).
    let at_pupil = at_cornea / (1.0 + 1e-3 * entrance.z_mm * at_cornea);
    let stop_radius = stop_radius_for(&open, 0.5 * pupil_diameter_mm)?;

    let fan = Fan {
        eye: &open,
        constants: &constants,
        vergence: 1e-3 * at_pupil,
    };
    let mut height = 0.0;
    let (mut extent, mut second_moment) = (0.0_f64, 0.0);
    for i in 1..=RAYS {
        let fraction = i as f64 / RAYS as f64;
        height = fan.height_through(fraction * stop_radius, height)?;
        let landing = fan.landing(height)?;
        extent = extent.max(landing.abs());
        // ∫ y² 2ρ dρ over the stop by Simpson; nothing at ρ = 0.
        let weight = match i {
            RAYS => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        second_moment += weight * landing * landing * 2.0 * fraction;
    }
    second_moment /= 3.0 * RAYS as f64;

    let pupil_m = 1e-3 * pupil_diameter_mm;
    let scale = 1.0 / constants.retina_mm_per_radian.abs();
    let focus = -constants.refraction_at_entrance_pupil_d();
    let object = ObjectPoint::default();
    let best = trace_wavefront(&open, pupil_diameter_mm, object)
        .map_or(at_pupil, |wave| -wave.power_vector().m_d);
    Some(TracedBlur {
        extent_rad: 2.0 * extent * scale,
        rms_disc_rad: (8.0 * second_moment).sqrt() * scale,
        simple_rad: defocus_blur_angle(pupil_m, at_pupil, focus, 0.0),
        simple_at_cornea_rad: defocus_blur_angle(pupil_m, at_cornea, -constants.refraction_d, 0.0),
        simple_best_focus_rad: defocus_blur_angle(pupil_m, at_pupil, best, 0.0),
    })
}

/// The blur disc of a round eye with spherical aberration (rad): diameter of the uniform disc with the
/// RMS radius of the geometric spot. `defocus_d` is the vergence at the entrance pupil minus the one in
/// paraxial focus (D; positive for a point that is too near), `c40_um` and `c60_um` the eye's Zernike
/// coefficients over the pupil of `pupil_radius_mm`.
///
/// Rays stand square to the wave, so the spot is the distribution of its slopes, and the mean square
/// slope is a quadratic form of the coefficients: `24 c20² + 120 c40² + 336 c60² + 16√15 c20 c40 +
/// 16√21 c20 c60 + 48√35 c40 c60` per squared radius. Without aberration it is `2 r |defocus|`, the
/// simple formula. A radius that is not positive gives 0.
pub fn aberrated_blur_disc(pupil_radius_mm: f64, defocus_d: f64, c40_um: f64, c60_um: f64) -> f64 {
    if pupil_radius_mm.is_nan() || pupil_radius_mm <= 0.0 {
        return 0.0;
    }
    let (c40, c60) = (c40_um, c60_um);
    // Defocus in the middle of the pupil, as c20 (the inverse of the Seidel refraction).
    let c20 = (12.0 * 5_f64.sqrt() * c40
        - 24.0 * 7_f64.sqrt() * c60
        - defocus_d * pupil_radius_mm * pupil_radius_mm)
        / (4.0 * 3_f64.sqrt());
    let mean_square = 24.0 * c20 * c20
        + 120.0 * c40 * c40
        + 336.0 * c60 * c60
        + 16.0 * c20 * (15_f64.sqrt() * c40 + 21_f64.sqrt() * c60)
        + 48.0 * 35_f64.sqrt() * c40 * c60;
    1e-3 / pupil_radius_mm * (8.0 * mean_square.max(0.0)).sqrt()
}

/// The blur of Navarro's eye at every combination, accommodations outermost, then pupils, then
/// distances.
pub fn blur_table(
    distances_m: &[f64],
    pupil_diameters_mm: &[f64],
    accommodations_d: &[f64],
) -> Vec<BlurRow> {
    let mut rows =
        Vec::with_capacity(distances_m.len() * pupil_diameters_mm.len() * accommodations_d.len());
    for &accommodation_d in accommodations_d {
        let eye = SchematicEye::navarro(accommodation_d, SODIUM_NM);
        for &pupil_diameter_mm in pupil_diameters_mm {
            for &distance_m in distances_m {
                rows.push(BlurRow {
                    distance_m,
                    pupil_diameter_mm,
                    accommodation_d,
                    blur: traced_blur(&eye, pupil_diameter_mm, distance_m),
                });
            }
        }
    }
    rows
}

/// Rays of one meridian from a point on the axis.
struct Fan<'a> {
    eye: &'a SchematicEye,
    constants: &'a Paraxial,
    /// Of the object at the entrance pupil (1/mm).
    vergence: f64,
}

impl Fan<'_> {
    /// The ray that is aimed at `height` (mm) in the plane of the entrance pupil.
    fn ray(&self, height: f64) -> Option<Ray> {
        let direction = DVec3::new(self.vergence * height, 0.0, 1.0).try_normalize()?;
        let pupil = DVec3::new(height, 0.0, self.constants.entrance_pupil.z_mm);
        // From in front of the cornea, but not from behind the object.
        let back = 12.0_f64.min(0.9999 / self.vergence.max(1e-9)) / direction.z;
        Ray::new(pupil - back * direction, direction)
    }

    /// The height at which the ray through `on_stop` (mm from the axis on the stop) is aimed, by secants
    /// from a neighbour's height.
    fn height_through(&self, on_stop: f64, neighbour: f64) -> Option<f64> {
        let miss = |height: f64| Some(self.eye.trace_to_stop(self.ray(height)?)?.x - on_stop);
        let magnification = self.constants.entrance_pupil.magnification;
        let mut height = neighbour - magnification * miss(neighbour)?;
        let (mut last, mut last_miss) = (neighbour, miss(neighbour)?);
        for _ in 0..20 {
            let now = miss(height)?;
            if now.abs() < 1e-12 || now == last_miss {
                break;
            }
            let next = height - now * (height - last) / (now - last_miss);
            (last, last_miss, height) = (height, now, next);
        }
        height.is_finite().then_some(height)
    }

    /// Where the ray lands, from the axis (mm).
    fn landing(&self, height: f64) -> Option<f64> {
        let at = self.eye.trace_to_retina(self.ray(height)?).ray()?.origin;
        Some(at.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn arcmin(angle: f64) -> f64 {
        angle.to_degrees() * 60.0
    }

    fn relaxed() -> SchematicEye {
        SchematicEye::navarro(0.0, SODIUM_NM)
    }

    #[test]
    fn tiny_pupils_make_the_simple_formula_exact() {
        for accommodation in [0.0, 3.0, 8.0] {
            let eye = SchematicEye::navarro(accommodation, SODIUM_NM);
            for distance in [0.01, 0.1, 0.7, 3.0] {
                let blur = traced_blur(&eye, 0.05, distance).unwrap();
                // Spherical aberration: 0.11 D per mm² of radius, 7e-5 D here, times the pupil; and
                // third-order terms of rays that steep.
                let room = 1e-4 * blur.simple_rad + 0.05e-3 * 8e-5;
                assert!((blur.extent_rad - blur.simple_rad).abs() < room, "{blur:?}");
                assert!(
                    (blur.rms_disc_rad - blur.simple_rad).abs() < room,
                    "{blur:?}"
                );
            }
        }
    }

    #[test]
    fn the_table_is_the_one_in_the_documentation() {
        let documented = [
            (1.0, [1.00, 0.99, 0.99, 0.98, 0.96, 0.89]),
            (2.0, [0.99, 0.98, 0.96, 0.91, 0.83, 0.59]),
            (3.0, [0.98, 0.95, 0.90, 0.80, 0.62, 0.36]),
            (4.0, [0.96, 0.90, 0.81, 0.64, 0.38, 1.08]),
            (6.0, [0.90, 0.77, 0.57, 0.36, 1.08, 3.94]),
        ];
        let distances = [0.1, 0.25, 0.5, 1.0, 2.0, 5.0];
        let table = blur_table(&distances, &documented.map(|(pupil, _)| pupil), &[0.0]);
        let expected = documented.iter().flat_map(|(_, ratios)| ratios);
        for (row, expected) in table.iter().zip(expected) {
            let ratio = row.ratio().unwrap();
            // Two decimals.
            assert!((ratio - expected).abs() < 0.006, "{row:?} {ratio}");
        }
    }

    #[test]
    fn where_the_simple_formula_fails() {
        for row in blur_table(
            &[0.25, 0.5, 1.0, 2.0, f64::INFINITY],
            &[2.0, 4.0, 6.0, 8.0],
            &[0.0, 2.0, 5.0],
        ) {
            let blur = row.blur.unwrap();
            println!(
                "accommodated {} D, pupil {} mm, {} m: traced {:.1} (RMS disc {:.1}), simple {:.1}, best focus {:.1} arcmin",
                row.accommodation_d,
                row.pupil_diameter_mm,
                row.distance_m,
                arcmin(blur.extent_rad),
                arcmin(blur.rms_disc_rad),
                arcmin(blur.simple_rad),
                arcmin(blur.simple_best_focus_rad),
            );
        }
        // A far point through 6 mm: no blur by the formula, 20 arcmin by rays.
        let far = traced_blur(&relaxed(), 6.0, f64::INFINITY).unwrap();
        assert!(far.simple_rad < 1e-6 && (arcmin(far.rms_disc_rad) - 20.0).abs() < 0.2);
        // The stop in place of the entrance pupil would be 13 % off at once.
        let constants = paraxial(&relaxed(), Meridian::Vertical);
        let stop = 1.0 / constants.entrance_pupil.magnification;
        assert!((stop - 0.883).abs() < 1e-3);
        // Vergences at the cornea are 3 % off at 10 cm and four times too large at 1 mm.
        let near = traced_blur(&relaxed(), 1.0, 0.1).unwrap();
        assert!((near.simple_at_cornea_rad / near.simple_rad - 1.03).abs() < 0.005);
        let touching = traced_blur(&relaxed(), 1.0, 0.001).unwrap();
        assert!((touching.simple_at_cornea_rad / touching.simple_rad - 4.04).abs() < 0.01);
        assert!((touching.rms_disc_rad / touching.simple_rad - 1.0).abs() < 0.01);
    }

    #[test]
    fn spherical_aberration_is_what_is_missing() {
        let mut worst = 0.0_f64;
        for accommodation in [0.0, 2.0, 5.0] {
            let eye = SchematicEye::navarro(accommodation, SODIUM_NM);
            let constants = paraxial(&eye, Meridian::Vertical);
            let focus = -constants.refraction_at_entrance_pupil_d();
            for pupil in [2.0, 3.0, 4.0, 5.0, 6.0] {
                let wave = trace_wavefront(&eye, pupil, ObjectPoint::default()).unwrap();
                let [c40, c60] = [12, 24].map(|j: usize| wave.coefficients_um[j]);
                for distance in [0.25, 0.5, 1.0, 3.0, f64::INFINITY] {
                    let blur = traced_blur(&eye, pupil, distance).unwrap();
                    let v = vergence_of_distance(distance);
                    let at_pupil = v / (1.0 + 1e-3 * constants.entrance_pupil.z_mm * v);
                    let disc = aberrated_blur_disc(0.5 * pupil, at_pupil - focus, c40, c60);
                    let off = (disc - blur.rms_disc_rad).abs();
                    // Where there is blur to speak of: a tenth of the pupil's dioptre.
                    worst = worst.max(off / blur.rms_disc_rad.max(1e-4 * pupil));
                }
            }
        }
        println!(
            "with spherical aberration the blur disc is off by {:.1} % at most",
            100.0 * worst
        );
        assert!(worst < 0.02, "{worst}");
        // Without it, it is the simple formula.
        assert!((aberrated_blur_disc(2.0, -1.5, 0.0, 0.0) - 0.006).abs() < 1e-15);
        assert_eq!(aberrated_blur_disc(f64::NAN, 1.0, 0.1, 0.0), 0.0);
    }

    #[test]
    fn impossible_pupils_have_no_blur() {
        for pupil in [0.0, -1.0, f64::NAN, 30.0] {
            assert_eq!(traced_blur(&relaxed(), pupil, 1.0), None);
        }
        let rows = blur_table(&[1.0], &[f64::NAN], &[0.0]);
        assert_eq!(rows[0].ratio(), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_legal_case_is_finite(
            pupil in 1.0..9.0_f64,
            log_distance in -3.0..6.0_f64,
            accommodation in 0.0..10.0_f64,
            refraction in -20.0..20.0_f64,
        ) {
            for eye in [
                SchematicEye::navarro(accommodation, 555.0),
                SchematicEye::atchison(refraction, 555.0),
            ] {
                if let Some(blur) = traced_blur(&eye, pupil, 10f64.powf(log_distance)) {
                    for angle in [
                        blur.extent_rad,
                        blur.rms_disc_rad,
                        blur.simple_rad,
                        blur.simple_at_cornea_rad,
                        blur.simple_best_focus_rad,
                    ] {
                        prop_assert!(angle.is_finite() && angle >= 0.0);
                    }
                    // A disc's extent is its RMS disc; anything else is wider than 0.7 of it.
                    prop_assert!(blur.extent_rad > 0.7 * blur.rms_disc_rad);
                }
            }
        }
    }
}
