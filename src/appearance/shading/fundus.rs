//! The red reflex: a lamp's light that the fundus sends back through the pupil. Twin: `shaders/lib/fundus.wgsl`.
//!
//! A place of the pupil sends a view to one point of the retina, and a lamp lights a disc of it as wide as the eye is out of
//! focus for it. Where both meet the pupil shines: for a lamp beside the lens as the crescents of eccentric photorefraction
//! (Bobier and Braddick 1985).

use crate::optics::smoothstep::smoothstep;
use core::f64::consts::PI;
use glam::{DVec2, DVec3};

/// From the eye's second nodal point to its retina (Gullstrand), mm.
pub const FUNDUS_DISTANCE_MM: f64 = 16.7;
/// Index of the vitreous: radiance is less by its square outside.
const FUNDUS_INDEX: f64 = 1.336;
/// How far light spreads in the fundus, rad in front of the eye (a choice: the half-width of what a double pass finds of a point).
pub const FUNDUS_SPREAD: f64 = 0.005;

/// A power vector (M, J0, J45) times a place.
pub fn power_times(power: DVec3, place: DVec2) -> DVec2 {
    DVec2::new(
        (power.x + power.y) * place.x + power.z * place.y,
        power.z * place.x + (power.x - power.y) * place.y,
    )
}

/// Light on the fundus `off` (rad) from the middle of a lamp of angular radius `radius` (rad) for which the eye is `blur` (1/mm,
/// a power vector) out of focus, over all of it, per steradian before the eye; `pupil` is the entrance pupil's radius (mm).
pub fn fundus_lit(off: DVec2, radius: f64, blur: DVec3, pupil: f64) -> f64 {
    let x = power_times(blur, DVec2::new(pupil, 0.0));
    let y = power_times(blur, DVec2::new(0.0, pupil));
    let soft = radius * radius + FUNDUS_SPREAD * FUNDUS_SPREAD;
    let (xx, yy, xy) = (x.dot(x) + soft, y.dot(y) + soft, x.dot(y));
    let area = (xx * yy - xy * xy).max(1e-12);
    let across = yy * off.x * off.x - 2.0 * xy * off.x * off.y + xx * off.y * off.y;
    let from_middle = (across.max(0.0) / area).sqrt();
    let edge = (2.0 * FUNDUS_SPREAD / area.sqrt().sqrt()).clamp(0.02, 0.9);
    let lit = smoothstep(1.0 + edge, 1.0 - edge, from_middle) / (1.0 + 0.2 * edge * edge);
    lit / (PI * area.sqrt())
}

/// Radiance through a place (mm, from its middle) of an entrance pupil of radius `pupil` (mm), towards the unit direction
/// `towards`, of light from `light` (unit): over its irradiance / π, for a fundus that sends back all. `radius` is the lamp's
/// (rad), `hole` the share of it that is dark, `vergence` one over its distance (1/mm), `focus` the vergence for which the eye
/// is in focus now (1/mm, a power vector: negative for the short-sighted). Eye frame: x to the patient's right, y up.
#[expect(clippy::too_many_arguments, reason = "the shader twin's argument list")]
pub fn fundus_reflex(
    light: DVec3,
    radius: f64,
    hole: f64,
    vergence: f64,
    towards: DVec3,
    place: DVec2,
    focus: DVec3,
    pupil: f64,
) -> f64 {
    // Where on the retina the view ends, as a direction before the eye.
    let off = light.truncate() - (towards.truncate() - power_times(focus, place));
    let blur = focus + DVec3::new(vergence, 0.0, 0.0);
    let dark = hole.clamp(0.0, 0.95);
    let inner = dark * dark * fundus_lit(off, dark * radius, blur, pupil);
    let lit = (fundus_lit(off, radius, blur, pupil) - inner).max(0.0) / (1.0 - dark * dark);
    let share = pupil / (FUNDUS_DISTANCE_MM * FUNDUS_INDEX);
    PI * share * share * lit * (-light.z).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light seen in an entrance pupil of 7 mm at `y` mm, of a lamp `aside` mm above a camera 1 m away, in an eye in focus for
    /// `focus_d`.
    fn seen(y: f64, aside: f64, focus_d: f64) -> f64 {
        let camera = DVec3::new(0.0, 0.0, -1000.0);
        let place = DVec2::new(0.0, y);
        fundus_reflex(
            (camera + DVec3::Y * aside).normalize(),
            1e-4,
            0.0,
            1e-3,
            (camera - place.extend(0.0)).normalize(),
            place,
            DVec3::new(1e-3 * focus_d, 0.0, 0.0),
            3.5,
        )
    }

    /// Height of the crescent, mm: from the pupil's edge to where half of its light is left.
    fn crescent(aside: f64, focus_d: f64) -> f64 {
        let heights = (-3500..=3500).map(|i| 1e-3 * f64::from(i));
        let most = heights
            .clone()
            .map(|y| seen(y, aside, focus_d))
            .fold(0.0, f64::max);
        heights
            .filter(|y| seen(*y, aside, focus_d) > 0.5 * most)
            .count() as f64
            * 1e-3
    }

    /// Bobier and Braddick 1985: the crescent of a lamp E aside at a distance d, in a pupil of radius r that is A dioptres out of
    /// focus for the camera, is 2 r − E/(d A) high, and stands on the lamp's side in an eye that is short-sighted for the camera.
    #[test]
    fn crescents_are_those_of_photorefraction() {
        for (focus_d, aside) in [(-6.0, 20.0), (-8.0, 30.0), (4.0, 20.0)] {
            let off_d: f64 = focus_d + 1.0;
            let wanted = 7.0 - aside / off_d.abs();
            let found = crescent(aside, focus_d);
            println!("{focus_d} D, {aside} mm aside: {found:.2} of {wanted:.2} mm");
            // The lit disc's soft edge adds its square.
            assert!((found - wanted).abs() < 0.15, "{focus_d}: {found} {wanted}");
            let above = seen(3.2, aside, focus_d) > seen(-3.2, aside, focus_d);
            assert_eq!(above, off_d < 0.0, "{focus_d}");
        }
        // In focus for the camera there is none.
        assert_eq!(seen(3.4, 20.0, -1.0), 0.0);
    }

    /// All of the light that enters is on the retina: seen from everywhere it is the lamp's, but for the cone of the eye.
    #[test]
    fn what_enters_is_what_is_lit() {
        let light = DVec3::NEG_Z;
        for focus in [
            DVec3::ZERO,
            DVec3::new(-6e-3, 0.0, 0.0),
            DVec3::new(-3e-3, 1e-3, -2e-3),
        ] {
            let (mut sum, step) = (0.0, 2e-4);
            for i in -300..=300 {
                for j in -300..=300 {
                    let towards = DVec2::new(f64::from(i), f64::from(j)) * step;
                    sum += fundus_reflex(
                        light,
                        0.01,
                        0.5,
                        2e-3,
                        towards.extend(-1.0),
                        DVec2::ZERO,
                        focus,
                        2.0,
                    ) * step
                        * step;
                }
            }
            // Irradiance / π of one over the pupil's π r² is π² r² of light. Over f² for each steradian before the eye it is the
            // retina's irradiance, of which a fundus of one sends back 1/π, and of that radiance 1/n² is left outside.
            let wanted = PI * (2.0 / (FUNDUS_DISTANCE_MM * 1.336)).powi(2);
            assert!((sum / wanted - 1.0).abs() < 3e-3, "{focus}: {sum} {wanted}");
        }
    }

    /// What leaves is what a retina of Lambert sends into the exit pupil: in the paraxial eye it is 0.91 of the stop's image in
    /// front and 20.5 mm from the retina, so 0.55 of the radiance inside.
    #[test]
    fn radiance_outside_is_what_the_exit_pupil_catches() {
        let caught = (0.91_f64 * FUNDUS_DISTANCE_MM / 20.5).powi(2);
        assert!(
            (caught - 1.0 / (FUNDUS_INDEX * FUNDUS_INDEX)).abs() < 0.02,
            "{caught}"
        );
    }

    #[test]
    fn an_astigmats_crescent_is_another_along_another_meridian() {
        let astigmat = DVec3::new(-4e-3, 3e-3, 0.0);
        let at = |place: DVec2, light: DVec2| {
            fundus_reflex(
                light.extend(-1.0).normalize(),
                1e-3,
                0.0,
                1e-3,
                DVec3::NEG_Z,
                place,
                astigmat,
                3.0,
            )
        };
        // 0 D out of focus but for the camera's along x, 6 D along y: a lamp above lights, one beside does not.
        assert!(at(DVec2::new(0.0, 2.5), DVec2::new(0.0, 0.02)) > 0.0);
        assert_eq!(at(DVec2::new(2.5, 0.0), DVec2::new(0.02, 0.0)), 0.0);
    }
}
