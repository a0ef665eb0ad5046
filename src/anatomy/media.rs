//! What the light passes on its way to the retina: cornea, aqueous, lens and vitreous, clear or clouded.
//!
//! Enters: the age of the eye and the pigment of its iris; conditions add to it. Leaves: how much light
//! is scattered forwards over the retina and backwards out of the pupil, and what colour it takes.

use crate::optics::glare::Glare;
use crate::tissue::media::lens_backscatter;
use crate::tissue::spectrum::{spectrum_from, spectrum_to_linear_srgb};
use bevy::ecs::reflect::ReflectComponent;
use bevy::math::{DVec3, Vec3};
use bevy::prelude::Component;
use bevy::reflect::Reflect;

/// Diameter of the lens's disc as it is seen in retroillumination through a wide pupil, mm: what shares of
/// its area are shares of.
pub const LENS_DISC_MM: f64 = 7.5;
/// Entrance pupil through which straylight is taken to have been measured, mm (a choice: the natural pupil
/// of an old eye before a meter's grey screen; published means say no more than "undilated").
pub const MEASURED_PUPIL_MM: f64 = 3.5;
/// Diameter of the beam from far away at the posterior capsule, in that of the entrance pupil, and so of
/// anything at the capsule in that of what is seen of it from far away: the paraxial eye of the tests.
pub const CAPSULE_BEAM: f64 = 0.75;
/// Clouded cortex behind the plane of the iris, mm.
pub const CORTEX_DEPTH_MM: f64 = 0.6;
/// The middle of the nucleus behind it, mm.
pub const NUCLEUS_DEPTH_MM: f64 = 1.8;
/// The posterior capsule behind it, mm.
pub const CAPSULE_DEPTH_MM: f64 = 3.8;
/// Diameter of that beam at the hole in the iris, and between it and the capsule, where it narrows evenly.
const STOP_BEAM: f64 = 0.886;
const NUCLEUS_BEAM: f64 = beam_at(NUCLEUS_DEPTH_MM);
const CORTEX_BEAM: f64 = beam_at(CORTEX_DEPTH_MM);

const fn beam_at(depth_mm: f64) -> f64 {
    STOP_BEAM + depth_mm / CAPSULE_DEPTH_MM * (CAPSULE_BEAM - STOP_BEAM)
}

/// Radius of the nucleus of an old lens, mm.
pub const NUCLEUS_RADIUS_MM: f64 = 2.75;
/// How much more strongly clouded cortex scatters at the rim of the lens's disc than in its middle, beyond once,
/// growing as the square of the distance: fitted to the straylight of cortical cataracts before and after
/// dilation (1.38 and 1.51 log s, Netherlands Institute for Neuroscience, 85 eyes with all kinds of cataract; 1.45
/// and 1.63 through 3.3 and 6.9 mm, de Jong, van der Meulen & van den Berg, ESCRS 2020).
const CORTEX_RIM: f64 = 4.0;
/// What a cloud at the posterior capsule sends back of the irradiance / π before a clear nucleus, linear
/// sRGB (a choice: photographs show it paler than the nucleus and darker than cortex).
const CAPSULE_CLOUD: Vec3 = Vec3::new(0.075, 0.072, 0.065);
/// Wavelength at which the added density of a yellowed nucleus is given, and over how many nm it falls
/// by a factor e, nm.
const DENSITY_AT_NM: f64 = 450.0;
const DENSITY_FALL_NM: f64 = 75.0;

/// The media of an eye. What a healthy eye of its age has is not counted: zero is healthy.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct OcularMedia {
    /// Age of the eye, years.
    pub age_years: f64,
    /// Pigmentation factor of CIE 135/1-1999: 0 very dark, 0.5 brown, 1.2 light blue.
    pub pigment: f64,
    /// Straylight parameter at 7° beyond the healthy eye's, deg² sr⁻¹, of what clouds the whole pupil.
    pub straylight: f64,
    /// The same of a clouded nucleus, through the pupil of [`MEASURED_PUPIL_MM`].
    pub nuclear_straylight: f64,
    /// Of clouded cortex, likewise.
    pub cortical_straylight: f64,
    /// Of a cloud before the posterior capsule, likewise.
    pub subcapsular_straylight: f64,
    /// Optical density of the nucleus at 450 nm beyond the healthy lens's.
    pub nuclear_density: f64,
    /// What the nucleus sends back of the irradiance over π, at 550 nm, before its own colour.
    pub nuclear_backscatter: f64,
    /// Share of the lens's disc that clouded cortex covers, 0–1, in wedges from its rim.
    pub cortical_share: f64,
    /// Diameter of a cloud before the posterior capsule, mm.
    pub subcapsular_mm: f64,
}

impl OcularMedia {
    /// Clear media.
    pub fn healthy(age_years: f64, pigment: f64) -> Self {
        Self {
            age_years,
            pigment,
            straylight: 0.0,
            nuclear_straylight: 0.0,
            cortical_straylight: 0.0,
            subcapsular_straylight: 0.0,
            nuclear_density: 0.0,
            nuclear_backscatter: 0.0,
            cortical_share: 0.0,
            subcapsular_mm: 0.0,
        }
    }

    /// Is nothing clouded?
    pub fn is_clear(&self) -> bool {
        *self == Self::healthy(self.age_years, self.pigment)
    }

    /// Share of the light through an entrance pupil of this diameter (mm) that meets the cloud before the
    /// posterior capsule: that of the beam's circle there which the cloud's covers.
    pub fn subcapsular_share(&self, entrance_pupil_mm: f64) -> f64 {
        share_of_beam(self.subcapsular_mm, CAPSULE_BEAM * entrance_pupil_mm)
    }

    /// Straylight parameter at 7° beyond the healthy eye's through an entrance pupil of this diameter (mm),
    /// deg² sr⁻¹. A small pupil leaves light no way beside a cloud in the middle, so such an eye is
    /// dazzled most where it is bright; clouds in the rim meet light only through a wide one.
    pub fn straylight_through(&self, entrance_pupil_mm: f64) -> f64 {
        // What a place scatters, by how much of the beam meets it, against the beam that was measured.
        let of = |straylight: f64, met: &dyn Fn(f64) -> f64| {
            let measured = met(MEASURED_PUPIL_MM);
            if straylight > 0.0 && measured > 0.0 {
                straylight * met(entrance_pupil_mm) / measured
            } else {
                0.0
            }
        };
        self.straylight
            + of(self.nuclear_straylight, &nuclear_share)
            + of(self.cortical_straylight, &cortical_weight)
            + of(self.subcapsular_straylight, &|pupil_mm| {
                self.subcapsular_share(pupil_mm)
            })
    }

    /// Straylight parameter of the whole eye at 7°, as its decimal logarithm, as it is measured: through a
    /// pupil of [`MEASURED_PUPIL_MM`].
    pub fn log_straylight(&self) -> f64 {
        let seven = 7f64.to_radians();
        let healthy = Glare::new(self.age_years, self.pigment).straylight(seven);
        (healthy + self.straylight_through(MEASURED_PUPIL_MM)).log10()
    }

    /// Transmittance beyond the healthy lens's, for white light, linear sRGB.
    pub fn transmittance(&self) -> Vec3 {
        if self.nuclear_density <= 0.0 {
            return Vec3::ONE;
        }
        let density =
            |nm: f64| self.nuclear_density * (-(nm - DENSITY_AT_NM) / DENSITY_FALL_NM).exp();
        let through = spectrum_to_linear_srgb(&spectrum_from(|nm| 10f64.powf(-density(nm))));
        DVec3::from(through)
            .clamp(DVec3::ZERO, DVec3::ONE)
            .as_vec3()
    }

    /// What a healthy lens of this age sends back of the lamps' irradiance over π, linear sRGB.
    pub fn healthy_backscatter(&self) -> Vec3 {
        DVec3::from(lens_backscatter(self.age_years)).as_vec3()
    }

    /// What a cloud at the posterior capsule sends back: light that has passed the nucleus twice.
    pub fn capsule_color(&self) -> Vec3 {
        let through = self.transmittance();
        CAPSULE_CLOUD * through * through
    }

    /// What a clouded nucleus sends back beyond that: light that has passed half of it twice.
    pub fn nucleus_color(&self) -> Vec3 {
        // Particles about as large as a wavelength scatter by about its inverse; blue is absorbed most.
        let scattered = Vec3::new(0.91, 1.0, 1.21) * self.nuclear_backscatter as f32;
        scattered * self.transmittance()
    }
}

/// Share of a beam that meets a disc in its middle, both diameters in mm: all of it where there is no beam.
fn share_of_beam(disc_mm: f64, beam_mm: f64) -> f64 {
    let share = disc_mm / beam_mm;
    if disc_mm.is_nan() || disc_mm <= 0.0 {
        0.0
    } else if share > 0.0 && share < 1.0 {
        share * share
    } else {
        // It covers all of the beam, or there is none.
        1.0
    }
}

/// Share of the light through an entrance pupil of this diameter (mm) that meets the nucleus.
fn nuclear_share(entrance_pupil_mm: f64) -> f64 {
    share_of_beam(2.0 * NUCLEUS_RADIUS_MM, NUCLEUS_BEAM * entrance_pupil_mm)
}

/// How strongly clouded cortex scatters the light through an entrance pupil of this diameter (mm), in its middle 1.
fn cortical_weight(entrance_pupil_mm: f64) -> f64 {
    let beam = (CORTEX_BEAM * entrance_pupil_mm / LENS_DISC_MM).clamp(0.0, 1.0);
    // The mean of the square over a disc is half of that at its rim.
    let rim = if beam.is_nan() { 0.0 } else { beam * beam };
    1.0 + 0.5 * CORTEX_RIM * rim
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_media_change_nothing_and_yellow_ones_take_blue() {
        let clear = OcularMedia::healthy(70.0, 0.5);
        assert!(clear.is_clear());
        assert_eq!(clear.transmittance(), Vec3::ONE);
        assert_eq!(clear.nucleus_color(), Vec3::ZERO);
        let yellow = OcularMedia {
            nuclear_density: 0.4,
            ..clear
        };
        let t = yellow.transmittance();
        assert!(!yellow.is_clear() && t.x > t.y && t.y > t.z, "{t}");
        // Against the spectrum itself: 10^-0.4 at 450 nm, 10^-0.105 at 550.
        assert!(t.z < 0.5 && (0.7..0.85).contains(&t.y) && t.x > 0.85, "{t}");
        let brown = OcularMedia {
            nuclear_density: 50.0,
            ..clear
        };
        assert!(brown.transmittance().is_finite() && brown.transmittance().min_element() >= 0.0);
    }

    #[test]
    fn straylight_adds_to_the_eyes_own() {
        let clear = OcularMedia::healthy(70.0, 0.5);
        // The complete CIE function at 70 years, brown: 1.125.
        assert!((clear.log_straylight() - 1.125).abs() < 2e-3);
        let clouded = OcularMedia {
            straylight: 10.8,
            ..clear
        };
        assert!((clouded.log_straylight() - (10f64.powf(1.125) + 10.8).log10()).abs() < 2e-3);
    }

    #[test]
    fn a_beam_from_far_away_is_three_quarters_as_wide_at_the_capsule() {
        // Le Grand's eye: cornea of 42.36 D, the stop 3.6 mm behind it in 1.3374, the lens's front of
        // 10.2 mm and 1.42, and the capsule 4 mm behind that.
        let (cornea_d, front_d) = (42.36, (1.42 - 1.3374) / 0.0102);
        let at_stop = 1.0 - 0.0036 * cornea_d / 1.3374;
        let converges = cornea_d + front_d * at_stop;
        let at_capsule = at_stop - 0.004 * converges / 1.42;
        assert!((at_capsule - CAPSULE_BEAM).abs() < 0.01, "{at_capsule}");
        assert!((at_stop - STOP_BEAM).abs() < 0.001, "{at_stop}");
    }

    #[test]
    fn a_cloud_in_the_middle_dazzles_most_through_a_small_pupil() {
        let clouded = OcularMedia {
            straylight: 2.0,
            subcapsular_straylight: 10.0,
            subcapsular_mm: 2.0,
            ..OcularMedia::healthy(70.0, 0.5)
        };
        // As measured; a beam of 2 mm and less meets nothing else; one twice as wide as that a quarter.
        let through = |mm: f64| clouded.straylight_through(mm);
        assert!((through(MEASURED_PUPIL_MM) - 12.0).abs() < 1e-12);
        let whole = 2.0 + 10.0 * (CAPSULE_BEAM * MEASURED_PUPIL_MM / 2.0).powi(2);
        assert!((through(1.0) - whole).abs() < 1e-12 && (through(2.6) - whole).abs() < 1e-12);
        let quarter = 2.0 + 0.25 * (whole - 2.0);
        assert!((through(4.0 / CAPSULE_BEAM) - quarter).abs() < 1e-12);
        // Nonsense is no cloud.
        for (mm, straylight) in [(0.0, 5.0), (f64::NAN, 5.0), (2.0, f64::NAN)] {
            let odd = OcularMedia {
                subcapsular_mm: mm,
                subcapsular_straylight: straylight,
                ..clouded
            };
            assert_eq!(odd.straylight_through(3.0), 2.0);
        }
        for pupil in [0.0, f64::NAN, f64::INFINITY, -1.0] {
            assert!(clouded.straylight_through(pupil).is_finite(), "{pupil}");
        }
    }
}
