//! First-order optics of an eye: powers, cardinal points, pupils, refractive error.
//!
//! In: a [`SchematicEye`] (which carries its wavelength in its indices) and a meridian. Out: a
//! [`Paraxial`], positions in mm along the axis from the corneal apex (+z into the eye).
//!
//! Ray transfer matrices on (height y, reduced angle ν = n u): a surface of curvature c adds
//! `−(n′ − n) c y` to ν, a gap t adds `t ν/n` to y. A gradient-index lens, `n₀(z) + n_r r²`, obeys
//! `y′ = ν/n₀, ν′ = 2 n_r y` and is integrated by Runge–Kutta. Tilts and decentrations are left out.

use crate::optics::ray_trace::{IndexField, Interface};
use crate::optics::schematic_eye::SchematicEye;
use glam::{DMat2, DVec2, DVec3};

/// Runge–Kutta steps through one gradient: relative error of the power 1e-13.
const GRADIENT_STEPS: u32 = 64;

/// A plane that holds the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meridian {
    /// The x–z plane (horizontal).
    Horizontal,
    /// The y–z plane.
    Vertical,
}

/// A pupil seen through what lies before or behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParaxialPupil {
    /// Its depth (mm).
    pub z_mm: f64,
    /// Its size over that of the stop.
    pub magnification: f64,
}

/// The first-order constants of an eye, light going from air to the retina.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraxial {
    /// Equivalent power (D).
    pub power_d: f64,
    /// Front focal point F (mm).
    pub front_focus_z_mm: f64,
    /// Back focal point F′ (mm).
    pub back_focus_z_mm: f64,
    /// Principal points P and P′ (mm).
    pub principal_z_mm: [f64; 2],
    /// Nodal points N and N′ (mm).
    pub nodal_z_mm: [f64; 2],
    /// The stop seen from the front.
    pub entrance_pupil: ParaxialPupil,
    /// The stop seen from the retina.
    pub exit_pupil: ParaxialPupil,
    /// Corneal apex to retina (mm).
    pub axial_length_mm: f64,
    /// Refractive error at the corneal apex (D): the vergence of the light that comes to a focus on
    /// the retina. Negative in myopia and in an accommodated eye.
    pub refraction_d: f64,
    /// Millimetres of retina per radian of a distant object's direction: `N′` to the focus over the
    /// index ratio for an eye in focus, and the chief ray's landing place out of focus.
    pub retina_mm_per_radian: f64,
}

impl Paraxial {
    /// Depth of the far point (mm), negative in front of the eye: infinite in emmetropia.
    pub fn far_point_z_mm(&self) -> f64 {
        1000.0 / self.refraction_d
    }

    /// Vergence at the entrance pupil (D) of the light that comes to a focus on the retina: 0 in
    /// emmetropia, negative in myopia. What defocus at the pupil is measured from.
    pub fn refraction_at_entrance_pupil_d(&self) -> f64 {
        // F/(1 − z F) with z from the apex to the pupil, in metres.
        self.refraction_d / (1.0 - 1e-3 * self.entrance_pupil.z_mm * self.refraction_d)
    }
}

/// The constants of `eye` in one meridian.
pub fn paraxial(eye: &SchematicEye, meridian: Meridian) -> Paraxial {
    let first = &eye.interfaces[0];
    let last = &eye.interfaces[eye.interfaces.len() - 1];
    let (z_first, z_last) = (first.placed.vertex.z, last.placed.vertex.z);
    let n_in = first.front.at(first.placed.vertex);
    let n_out = last.back.at(last.placed.vertex);
    let stop = eye.stop_z_mm();

    let front = system(eye.front(), z_first, stop, meridian);
    let rear = system(&eye.interfaces[eye.stop..], stop, z_last, meridian);
    let whole = rear * front;
    // Column-major: x_axis is what (1, 0) becomes.
    let (a, c) = (whole.x_axis.x, whole.x_axis.y);
    let d = whole.y_axis.y;
    let power = -c;
    let front_focus = z_first - n_in * d / power;
    let back_focus = z_last + n_out * a / power;

    let to_retina = gap(&last.back, z_last, eye.axial_length_mm()) * whole;
    let entrance = n_in * front.y_axis.x / front.x_axis.x;
    // A chief ray: through the centre of the entrance pupil at unit angle.
    let chief = to_retina * DVec2::new(-entrance, n_in);
    Paraxial {
        power_d: 1000.0 * power,
        front_focus_z_mm: front_focus,
        back_focus_z_mm: back_focus,
        principal_z_mm: [front_focus + n_in / power, back_focus - n_out / power],
        nodal_z_mm: [front_focus + n_out / power, back_focus - n_in / power],
        entrance_pupil: ParaxialPupil {
            z_mm: z_first + entrance,
            magnification: 1.0 / front.x_axis.x,
        },
        exit_pupil: ParaxialPupil {
            z_mm: z_last - n_out * rear.y_axis.x / rear.y_axis.y,
            magnification: 1.0 / rear.y_axis.y,
        },
        axial_length_mm: eye.axial_length_mm(),
        refraction_d: 1000.0 * n_in * to_retina.x_axis.x / to_retina.y_axis.x,
        retina_mm_per_radian: chief.x,
    }
}

/// The matrix of `interfaces` from depth `from_z` to depth `to_z`.
fn system(interfaces: &[Interface], from_z: f64, to_z: f64, meridian: Meridian) -> DMat2 {
    let mut matrix = DMat2::IDENTITY;
    let mut z = from_z;
    let mut medium = interfaces.first().map(|interface| interface.front);
    for interface in interfaces {
        let vertex = interface.placed.vertex;
        matrix = gap(&interface.front, z, vertex.z) * matrix;
        let curvature = match meridian {
            Meridian::Horizontal => interface.placed.surface.curvature.x,
            Meridian::Vertical => interface.placed.surface.curvature.y,
        };
        let on_axis = DVec3::new(0.0, 0.0, vertex.z);
        let power = (interface.back.at(on_axis) - interface.front.at(on_axis)) * curvature;
        matrix = DMat2::from_cols(DVec2::new(1.0, -power), DVec2::Y) * matrix;
        z = vertex.z;
        medium = Some(interface.back);
    }
    medium.map_or(matrix, |medium| gap(&medium, z, to_z) * matrix)
}

/// The matrix of a stretch of the axis.
fn gap(medium: &IndexField, from_z: f64, to_z: f64) -> DMat2 {
    let length = to_z - from_z;
    match medium {
        IndexField::Uniform(n) => DMat2::from_cols(DVec2::X, DVec2::new(length / n, 1.0)),
        IndexField::Gradient(lens) => {
            let slope = |z: f64, state: DMat2| {
                let n = lens.index(DVec3::new(0.0, 0.0, z));
                DMat2::from_cols(DVec2::new(0.0, 2.0 * lens.radial), DVec2::new(1.0 / n, 0.0))
                    * state
            };
            let h = length / f64::from(GRADIENT_STEPS);
            let mut state = DMat2::IDENTITY;
            for i in 0..GRADIENT_STEPS {
                let z = from_z + h * f64::from(i);
                let k1 = slope(z, state);
                let k2 = slope(z + 0.5 * h, state + k1 * (0.5 * h));
                let k3 = slope(z + 0.5 * h, state + k2 * (0.5 * h));
                let k4 = slope(z + h, state + k3 * h);
                state += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            }
            state
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::ray_trace::Ray;
    use crate::optics::schematic_eye::{GREEN_NM, PHOTOPIC_NM, SODIUM_NM};

    fn constants(eye: &SchematicEye) -> Paraxial {
        paraxial(eye, Meridian::Horizontal)
    }

    #[test]
    fn eyes_have_their_published_constants() {
        let nan = f64::NAN;
        // Power, F, F′, P, P′, N, N′, entrance and exit pupil, refraction; NaN where not published.
        // Atchison & Smith 2000 (Optics of the Human Eye, appendix 3) for Le Grand and Gullstrand;
        // Gullstrand himself for his refractions (+1 D, and a near point 102.3 mm away); the
        // papers' abstracts for Navarro and for Liou & Brennan.
        let table = [
            (
                "Navarro",
                SchematicEye::navarro(0.0, SODIUM_NM),
                [60.416, nan, 24.004, nan, nan, nan, nan, 3.042, 3.682, 0.0],
            ),
            (
                "Le Grand",
                SchematicEye::le_grand(SODIUM_NM),
                [
                    59.940, -15.089, 24.197, 1.595, 1.908, 7.200, 7.513, 3.038, 3.682, 0.0,
                ],
            ),
            (
                "Le Grand, accommodated",
                SchematicEye::le_grand_accommodated(SODIUM_NM),
                [67.677, nan, 21.932, nan, nan, nan, nan, nan, nan, nan],
            ),
            (
                "Gullstrand",
                SchematicEye::gullstrand(SODIUM_NM),
                [
                    58.636, -15.706, 24.385, 1.348, 1.601, 7.078, 7.331, 3.047, 3.665, 1.0,
                ],
            ),
            (
                "Gullstrand, accommodated",
                SchematicEye::gullstrand_accommodated(SODIUM_NM),
                [
                    70.576, nan, nan, 1.772, 2.086, nan, nan, 2.668, 3.212, -9.775,
                ],
            ),
            (
                "Liou & Brennan",
                SchematicEye::liou_brennan(PHOTOPIC_NM),
                [60.35, nan, 23.95, nan, nan, nan, nan, nan, nan, 0.0],
            ),
        ];
        for (name, eye, published) in table {
            let got = constants(&eye);
            let ours = [
                got.power_d,
                got.front_focus_z_mm,
                got.back_focus_z_mm,
                got.principal_z_mm[0],
                got.principal_z_mm[1],
                got.nodal_z_mm[0],
                got.nodal_z_mm[1],
                got.entrance_pupil.z_mm,
                got.exit_pupil.z_mm,
                got.refraction_d,
            ];
            println!(
                "{name}: {:.4} D, {:+.1e} of the published; refraction {:+.5} D",
                ours[0],
                ours[0] / published[0] - 1.0,
                got.refraction_d
            );
            for (i, (ours, published)) in ours.into_iter().zip(published).enumerate() {
                // Three decimals, last one rounded; 60.35 and +1.0 are printed with fewer.
                let room = match (name, i) {
                    ("Liou & Brennan", 0) => 0.01,
                    ("Gullstrand", 9) => 0.05,
                    ("Gullstrand, accommodated", 9) => 0.005,
                    _ => 6e-4,
                };
                assert!(
                    published.is_nan() || (ours - published).abs() < room,
                    "{name}, {i}: {ours} for {published}"
                );
            }
        }
    }

    #[test]
    fn cardinal_points_are_those_of_opticstudio() {
        // Escudero-Sanz & Navarro's eye at 543 nm in Ansys OpticStudio, six decimals, from the tests
        // of visisipy (MREYE-LUMC); image-side places count from the retina there.
        let got = constants(&SchematicEye::escudero_navarro(GREEN_NM));
        let retina = got.axial_length_mm;
        for (ours, theirs) in [
            (got.front_focus_z_mm, -14.885414),
            (got.back_focus_z_mm - retina, 0.000014),
            (got.principal_z_mm[0], 1.582490),
            (got.principal_z_mm[1] - retina, -22.029102),
            (got.nodal_z_mm[0], 7.143701),
            (got.nodal_z_mm[1] - retina, -16.467890),
            (1000.0 * 1.3377 / got.power_d, 22.029115),
        ] {
            assert!((ours - theirs).abs() < 6e-7, "{ours} {theirs}");
        }
    }

    #[test]
    fn narrow_real_rays_agree() {
        for eye in [
            SchematicEye::navarro(5.0, 480.0),
            SchematicEye::gullstrand(SODIUM_NM),
            SchematicEye::liou_brennan(PHOTOPIC_NM),
            SchematicEye::atchison(-6.0, PHOTOPIC_NM),
            SchematicEye::francois(1.376),
        ] {
            let got = constants(&eye);
            let h = 1e-3;
            let ray = Ray::new(DVec3::new(h, 0.0, -1.0), DVec3::Z).unwrap();
            let out = crate::optics::ray_trace::trace_into(&eye.interfaces, ray)
                .ray()
                .unwrap();
            let crossing = out.origin.z - out.origin.x * out.direction.z / out.direction.x;
            // Aberration is of order h² (1e-6), the gradient's step 1e-10 over 1e-3 of height.
            assert!(
                (crossing - got.back_focus_z_mm).abs() < 3e-6,
                "{crossing} {got:?}"
            );
            // The chief ray through the centre of the entrance pupil meets the centre of the stop
            // and lands where its direction says.
            let pupil = DVec3::new(0.0, 0.0, got.entrance_pupil.z_mm);
            let dir = DVec3::new(h, 0.0, 1.0).normalize();
            let chief = Ray::new(pupil - 9.0 * dir, dir).unwrap();
            let stop = eye.trace_to_stop(chief).unwrap();
            assert!(stop.x.abs() < 1e-8, "{stop}");
            let retina = eye.trace_to_retina(chief).ray().unwrap().origin;
            assert!(
                (retina.x / h - got.retina_mm_per_radian).abs() < 1e-4,
                "{retina} {got:?}"
            );
            // A ray at the edge of a pupil of h is at h over the magnification on the stop.
            let edge = Ray::new(DVec3::new(h, 0.0, -1.0), DVec3::Z).unwrap();
            let stop = eye.trace_to_stop(edge).unwrap();
            assert!((h / stop.x - got.entrance_pupil.magnification).abs() < 1e-6);
        }
    }

    #[test]
    fn a_toric_cornea_has_two_powers() {
        let mut eye = SchematicEye::le_grand(SODIUM_NM);
        eye.interfaces[0].placed.surface = crate::optics::surface::Quadric::toric(7.6, 8.0, 0.8);
        let horizontal = paraxial(&eye, Meridian::Horizontal).refraction_d;
        let vertical = paraxial(&eye, Meridian::Vertical).refraction_d;
        // The cornea's own powers: 0.3771 (1/7.6 − 1/8.0), 2.481 D, at its very place.
        assert!((vertical - horizontal - 377.1 * (1.0 / 7.6 - 1.0 / 8.0)).abs() < 1e-9);
    }

    #[test]
    fn refraction_moves_to_the_entrance_pupil_as_vergence_does() {
        let got = constants(&SchematicEye::navarro(7.0, SODIUM_NM));
        let distance = got.far_point_z_mm() - got.entrance_pupil.z_mm;
        assert!((1000.0 / distance - got.refraction_at_entrance_pupil_d()).abs() < 1e-12);
    }
}
