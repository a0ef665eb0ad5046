//! The patient's pupil as it looks from the side, by real rays through the cornea
//! ([`crate::optics::pupil`]).
//!
//! In: an eye. Leaves: one row an angle and direction: width and height, their ratio, the shift by
//! refraction, and beside it what was measured on living eyes.
//!
//! Mathur, Gehrmann & Atchison 2013 (J. Vision 13(6):3) photographed the dilated right pupils of 30
//! people along the horizontal field; least over greatest diameter of the fitted ellipses is
//! `0.99 cos((φ + 5.3°)/1.121)` on average, φ the angle in the visual field, negative on the temporal
//! side. The peak at −5.3° is where the pupil's axis points, and angles here count from the corneal
//! axis: the fit is centred.

use super::{MeasuredEye, NullReasons, known};
use crate::optics::pupil::{AnteriorSegment, Viewer, entrance_pupil};
use glam::DVec2;
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "Mathur, Gehrmann & Atchison 2013, J. Vision 13(6):3 (mathur_2013_ratio)",
    "François, Gautron, Breton & Bouatouch 2007, section 3 (the two-point problem that is solved \
     for each point of the outline)",
    "the patient's cornea, by exact rays through both surfaces",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "angle_deg counts from the corneal axis to a distant viewer: horizontally positive to the \
     patient's right, vertically positive up. side says on which side of the eye the viewer \
     stands.",
    "apparent_width_mm and apparent_height_mm are extents across the line of sight, level and \
     upright; ratio is the extent in the direction of foreshortening over the extent across it; \
     ellipse_ratio is least over greatest diameter of the least-squares ellipse.",
    "shift_right_mm and shift_up_mm: from where the centre of the pupil would be without a cornea \
     to where it looks to be, in the same plane, to the patient's right and up.",
    "flat_disc_ratio is a round hole without a cornea, the cosine of the angle.",
    "mathur_2013_ratio is 0.99 cos(angle/1.121), the mean of 30 dilated eyes to about 80 degrees, \
     centred on the pupil's axis (5.3 degrees temporal of the line of sight).",
    "visible_share is the part of the edge that is seen through the clear cornea; extents are \
     those of the whole outline, the rest as if the cornea went on.",
];

/// Steps of the angle (degrees), and how many to each side.
const STEP_DEG: f64 = 5.0;
const STEPS: i32 = 16;

/// The pupil from one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PupilRow {
    /// `horizontal` or `vertical`.
    pub direction: &'static str,
    /// Angle of the viewer from the corneal axis (degrees).
    pub angle_deg: f64,
    /// On which side of the eye the viewer stands.
    pub side: &'static str,
    /// Extent along the level (mm).
    pub apparent_width_mm: Option<f64>,
    /// Extent upright (mm).
    pub apparent_height_mm: Option<f64>,
    /// Extent in the direction of foreshortening over the extent across it.
    pub ratio: Option<f64>,
    /// Least over greatest diameter of the nearest ellipse.
    pub ellipse_ratio: Option<f64>,
    /// Root mean square distance of the outline from that ellipse (mm).
    pub ellipse_misfit_mm: Option<f64>,
    /// The same for a hole without a cornea.
    pub flat_disc_ratio: f64,
    /// The same in living eyes.
    pub mathur_2013_ratio: Option<f64>,
    /// Shift of the pupil's centre by refraction to the patient's right (mm).
    pub shift_right_mm: Option<f64>,
    /// Shift upwards (mm).
    pub shift_up_mm: Option<f64>,
    /// Share of the edge that is seen through the clear cornea.
    pub visible_share: Option<f64>,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "NullReasons::is_empty")]
    pub null_reasons: NullReasons,
}

/// The patient's anterior segment.
pub fn segment(eye: &MeasuredEye) -> AnteriorSegment {
    AnteriorSegment {
        anterior: eye.anterior(),
        posterior: Some(eye.posterior()),
        thickness_mm: eye.corneal_thickness_mm,
        cornea_index: eye.cornea_index,
        aqueous_index: eye.aqueous_index,
        clear_radius_mm: eye.limbus_radius_mm,
        iris_depth_mm: eye.iris_depth_mm,
        pupil_diameters_mm: DVec2::splat(eye.pupil_diameter_mm),
        pupil_axis_rad: 0.0,
        pupil_centre_mm: eye.pupil_centre_mm(),
    }
}

/// All angles, horizontal first.
pub fn rows(eye: &MeasuredEye) -> Vec<PupilRow> {
    let segment = segment(eye);
    let mut rows = Vec::with_capacity(2 * (2 * STEPS as usize + 1));
    for vertical in [false, true] {
        for step in -STEPS..=STEPS {
            let angle_deg = STEP_DEG * f64::from(step);
            rows.push(row(eye, &segment, vertical, angle_deg));
        }
    }
    rows
}

fn row(eye: &MeasuredEye, segment: &AnteriorSegment, vertical: bool, angle_deg: f64) -> PupilRow {
    let angle = angle_deg.to_radians();
    let (azimuth, elevation) = if vertical { (0.0, angle) } else { (angle, 0.0) };
    let view = entrance_pupil(segment, Viewer::Direction { azimuth, elevation });
    let reason = match &view {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let view = view.ok();
    let mut null_reasons = NullReasons::new();
    let mut seen = |key, value: Option<f64>| known(&mut null_reasons, key, value, &reason);
    let ellipse = view.as_ref().map(|view| view.ellipse());
    let ratio = ellipse.map(|ellipse| ellipse.minor_mm / ellipse.major_mm);
    PupilRow {
        direction: if vertical { "vertical" } else { "horizontal" },
        angle_deg,
        side: side(eye, vertical, angle_deg),
        apparent_width_mm: seen(
            "apparent_width_mm",
            view.as_ref().map(|view| view.width_mm()),
        ),
        apparent_height_mm: seen(
            "apparent_height_mm",
            view.as_ref().map(|view| view.height_mm()),
        ),
        ratio: seen("ratio", view.as_ref().map(|view| view.ratio())),
        ellipse_ratio: seen("ellipse_ratio", ratio),
        ellipse_misfit_mm: seen(
            "ellipse_misfit_mm",
            ellipse.map(|ellipse| ellipse.misfit_mm),
        ),
        shift_right_mm: seen(
            "shift_right_mm",
            view.as_ref().map(|view| view.stop_centre_mm.x),
        ),
        shift_up_mm: seen(
            "shift_up_mm",
            view.as_ref().map(|view| view.stop_centre_mm.y),
        ),
        visible_share: seen(
            "visible_share",
            view.as_ref().map(|view| view.visible_share()),
        ),
        flat_disc_ratio: angle.cos(),
        mathur_2013_ratio: known(
            &mut null_reasons,
            "mathur_2013_ratio",
            (!vertical).then(|| mathur_2013_ratio(angle_deg)),
            "measured along the horizontal only",
        ),
        null_reasons,
    }
}

/// The fit of Mathur et al. about the pupil's axis.
pub fn mathur_2013_ratio(angle_deg: f64) -> f64 {
    0.99 * (angle_deg / 1.121).to_radians().cos()
}

fn side(eye: &MeasuredEye, vertical: bool, angle_deg: f64) -> &'static str {
    // The temporal side of a right eye is the patient's right.
    let temporal = (angle_deg > 0.0) == eye.right_eye;
    match (vertical, angle_deg == 0.0) {
        (_, true) => "straight ahead",
        (true, _) if angle_deg > 0.0 => "superior",
        (true, _) => "inferior",
        (false, _) if temporal => "temporal",
        (false, _) => "nasal",
    }
}
