//! Cataract: clouding of the lens, in its nucleus, its cortex, or before its posterior capsule.
//!
//! Enters: grades of the Lens Opacities Classification System III (Chylack et al. 1993). Leaves: what
//! the clouding scatters forwards over the retina, what it sends back out of the pupil, and how yellow
//! it makes the light.
//!
//! No paper gives straylight, colour or backscatter per grade. The laws here are model choices that
//! keep to published means: clinical log s of 1.22 ± 0.20 (nuclear), 1.26 ± 0.23 (cortical) and
//! 1.48 ± 0.34 (subcapsular) from a review of five studies (J. Ophthalmol. 2017, 5649532); lens
//! densities that rise by 0.12 and 0.165 decades a grade; areas of 10 and 90 % of the lens at the
//! second and the last cortical class, 3 and 50 % of the capsule. One grader's own tolerance is ±0.7
//! grades (±1 subcapsular).

use super::{Affected, Condition, Control, short};
use crate::anatomy::{CAPSULE_BEAM, LENS_DISC_MM};
use crate::optics::root::illinois;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::Component;
use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

/// Highest grades of LOCS III: nuclear, cortical, posterior subcapsular.
const HIGHEST: [f64; 3] = [6.9, 5.9, 5.9];
/// Grade from which a nucleus makes an eye short-sighted, and by how much a grade, D: 21 eyes with nuclear
/// cataract shifted by −0.40 ± 0.6 D against clear ones (Pesudovs & Elliott 2003), here a grade 3;
/// below, nuclei do not (Samarawickrama et al. 2007).
const SHORT_SIGHTED_FROM: f64 = 2.0;
const SHIFT_D: f64 = -0.40;
/// Grade of nuclear colour up to which a lens is as yellow as a healthy one of its age.
const YELLOW_FROM: f64 = 1.5;

/// Cataract of an eye, or of both eyes of a person. Without it there is no pass, key or texture of it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
#[serde(deny_unknown_fields, default)]
pub struct Cataract {
    /// Nuclear opalescence and colour, LOCS III, 0 to 6.9.
    pub nuclear: f64,
    /// Cortical opacity, LOCS III, 0 to 5.9.
    pub cortical: f64,
    /// Posterior subcapsular opacity, LOCS III, 0 to 5.9.
    pub subcapsular: f64,
    /// Straylight of the whole eye as a straylight meter finds it, log s, 0.5 to 2.5. Where it is given the
    /// eye has it, and the grades only say in which proportion the three places are clouded (the
    /// nucleus alone, where all are 0): they become those that give this eye this straylight, or the
    /// highest. An eye that has more without a cataract has a clear lens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log_s: Option<f64>,
}

impl Cataract {
    /// A clouded, yellowed nucleus of this LOCS III grade (0 to 6.9).
    pub fn nuclear(grade: f64) -> Self {
        Self {
            nuclear: grade,
            ..Self::default()
        }
    }

    /// Wedges in the cortex of this LOCS III grade (0 to 5.9).
    pub fn cortical(grade: f64) -> Self {
        Self {
            cortical: grade,
            ..Self::default()
        }
    }

    /// A cloud before the posterior capsule of this LOCS III grade (0 to 5.9).
    pub fn posterior_subcapsular(grade: f64) -> Self {
        Self {
            subcapsular: grade,
            ..Self::default()
        }
    }

    fn grades(&self) -> [f64; 3] {
        let within = |grade: f64, most: f64| if grade > 0.0 { grade.min(most) } else { 0.0 };
        [
            within(self.nuclear, HIGHEST[0]),
            within(self.cortical, HIGHEST[1]),
            within(self.subcapsular, HIGHEST[2]),
        ]
    }

    /// A cataract by the straylight of the whole eye, log s; `self` says where it is clouded.
    pub fn with_log_s(self, log_s: f64) -> Self {
        Self {
            log_s: Some(log_s),
            ..self
        }
    }

    /// What a measured straylight leaves to the cataract of an eye that has `healthy` without it, deg² sr⁻¹
    /// at 7°; `None` where none was measured.
    fn measured(&self, healthy: f64) -> Option<f64> {
        let log_s = self.log_s.filter(|log_s| log_s.is_finite())?;
        Some((10f64.powf(log_s) - healthy).max(0.0))
    }

    /// The same by its grades, for an eye that has this straylight (deg² sr⁻¹ at 7°) without it.
    fn graded(&self, healthy: f64) -> Self {
        let Some(wanted) = self.measured(healthy) else {
            return *self;
        };
        if wanted == 0.0 {
            return Self::default();
        }
        let mix = match self.grades() {
            [0.0, 0.0, 0.0] => [1.0, 0.0, 0.0],
            grades => grades,
        };
        let scaled = |scale: f64| Self {
            nuclear: scale * mix[0],
            cortical: scale * mix[1],
            subcapsular: scale * mix[2],
            log_s: None,
        };
        // At the largest every grade that is not 0 is the highest.
        let least = mix
            .into_iter()
            .filter(|grade| *grade > 0.0)
            .fold(f64::INFINITY, f64::min);
        let most = HIGHEST[0] / least;
        let off = |scale: f64| scaled(scale).straylight() - wanted;
        if off(most) <= 0.0 {
            return scaled(most);
        }
        scaled(illinois((0.0, off(0.0)), (most, off(most)), 1e-9, off))
    }

    /// Straylight at 7° that it adds by its grades, deg² sr⁻¹. Scatterers add in intensity.
    pub fn straylight(&self) -> f64 {
        self.straylight_by_place().iter().sum()
    }

    /// The same of nucleus, cortex and a cloud before the capsule.
    fn straylight_by_place(&self) -> [f64; 3] {
        let [nuclear, cortical, subcapsular] = self.grades();
        [
            1.2 * (nuclear - 1.0).max(0.0).powi(2),
            1.2 * cortical.powi(2),
            3.0 * subcapsular.powi(2),
        ]
    }
}

impl Condition for Cataract {
    const TITLE: &'static str = "Cataract";

    fn onset() -> Self {
        Self::nuclear(2.5)
    }

    fn controls() -> &'static [Control<Self>] {
        &[
            Control {
                name: "nuclear",
                range: (0.0, HIGHEST[0]),
                meaning: "clouding and yellowing of the nucleus (LOCS III)",
                get: |own| Some(own.nuclear),
                set: |own, value| own.nuclear = value,
            },
            Control {
                name: "cortical",
                range: (0.0, HIGHEST[1]),
                meaning: "wedges in the cortex (LOCS III)",
                get: |own| Some(own.cortical),
                set: |own, value| own.cortical = value,
            },
            Control {
                name: "subcapsular",
                range: (0.0, HIGHEST[2]),
                meaning: "cloud before the posterior capsule (LOCS III)",
                get: |own| Some(own.subcapsular),
                set: |own, value| own.subcapsular = value,
            },
            Control {
                name: "log_s",
                range: (0.5, 2.5),
                meaning: "straylight of the whole eye (log s); the grades then only say where it is clouded",
                get: |own| own.log_s,
                set: |own, value| own.log_s = Some(value),
            },
        ]
    }

    fn write(&self, affected: &mut Affected) {
        let healthy = 10f64.powf(affected.media.log_straylight());
        let graded = self.graded(healthy);
        let [nuclear, cortical, subcapsular] = graded.grades();
        affected.refraction.sphere_d += SHIFT_D * (nuclear - SHORT_SIGHTED_FROM).max(0.0);
        let media = &mut affected.media;
        let by_grades = graded.straylight();
        let added = self.measured(healthy).unwrap_or(by_grades);
        // Each place has the share of it that its grade has.
        let share = if by_grades > 0.0 {
            added / by_grades
        } else {
            0.0
        };
        let of = graded.straylight_by_place().map(|own| share * own);
        media.nuclear_straylight += of[0];
        media.cortical_straylight += of[1];
        media.subcapsular_straylight += of[2];
        media.nuclear_density += 0.10 * (nuclear - YELLOW_FROM).max(0.0).powf(1.5);
        if nuclear > 0.0 {
            // Over what a clear nucleus, grade 1, sends back.
            let of = |grade: f64| 0.015 * 10f64.powf(0.145 * (grade - 1.0));
            media.nuclear_backscatter += (of(nuclear) - of(1.0)).max(0.0);
        }
        let share = media.cortical_share + 0.9 * (cortical / 5.0).powf(1.5);
        media.cortical_share = share.min(1.0);
        // Shares of the capsule as photographs in retroillumination show it.
        let seen_mm = LENS_DISC_MM * (0.5 * (subcapsular / 5.0).powf(1.75)).sqrt();
        let cloud_mm = CAPSULE_BEAM * seen_mm;
        media.subcapsular_mm = media.subcapsular_mm.max(cloud_mm);
    }

    fn remark(&self, without: &Affected) -> Option<String> {
        let own = without.media.log_straylight();
        let log_s = self.log_s.filter(|log_s| *log_s < own)?;
        Some(format!(
            "a straylight of {log_s:.2} log s is less than the eye has without a cataract ({own:.2}), so its lens is clear"
        ))
    }

    fn caption(&self) -> String {
        let [nuclear, cortical, subcapsular] = self.grades();
        let parts: Vec<String> = [
            ("nuclear", nuclear),
            ("cortical", cortical),
            ("posterior subcapsular", subcapsular),
        ]
        .into_iter()
        .filter(|(_, grade)| *grade > 0.0)
        .map(|(place, grade)| format!("{place} {}", short(grade)))
        .collect();
        match (self.log_s, parts.as_slice()) {
            (Some(log_s), []) => format!("Cataract by its straylight, {} log s.", short(log_s)),
            (Some(log_s), _) => format!(
                "Cataract by its straylight, {} log s, in the proportion of {}.",
                short(log_s),
                parts.join(", ")
            ),
            (None, []) => "A clear lens.".into(),
            (None, _) => format!("Cataract, LOCS III: {}.", parts.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::{Laterality, OcularMedia};

    fn media(cataract: Cataract) -> OcularMedia {
        let mut affected = Affected::healthy(Laterality::OD, 70.0);
        cataract.write(&mut affected);
        affected.media
    }

    #[test]
    fn straylight_keeps_to_the_clinical_means() {
        assert!(media(Cataract::default()).is_clear());
        // Mean and standard deviation of log s of groups with mild to moderate cataract.
        for (cataract, mean, deviation) in [
            (Cataract::nuclear(2.5), 1.22, 0.20),
            (Cataract::cortical(2.0), 1.26, 0.23),
            (Cataract::posterior_subcapsular(2.5), 1.48, 0.34),
        ] {
            let log_s = media(cataract).log_straylight();
            println!("{cataract:?}: log s {log_s:.2}");
            assert!((log_s - mean).abs() < deviation, "{cataract:?}: {log_s}");
        }
        let both = Cataract {
            cortical: 2.0,
            ..Cataract::posterior_subcapsular(2.5)
        };
        assert!(both.straylight() > Cataract::posterior_subcapsular(2.5).straylight());
    }

    #[test]
    fn an_eye_has_the_straylight_that_was_measured() {
        for mix in [
            Cataract::default(),
            Cataract::cortical(2.0),
            Cataract {
                nuclear: 3.0,
                subcapsular: 1.5,
                ..Cataract::default()
            },
        ] {
            for log_s in [1.2, 1.5, 1.7, 2.2] {
                let found = media(mix.with_log_s(log_s)).log_straylight();
                assert!((found - log_s).abs() < 1e-6, "{mix:?}: {found} for {log_s}");
            }
            // Less than the eye has without it, which is said, and more than there are grades for.
            assert!(media(mix.with_log_s(0.5)).is_clear());
            let most = media(mix.with_log_s(2.5));
            assert!((most.log_straylight() - 2.5).abs() < 1e-6);
            let healthy = Affected::healthy(Laterality::OD, 70.0);
            let remark = mix.with_log_s(0.5).remark(&healthy).expect("said");
            assert!(
                remark.contains("0.50") && remark.contains("clear"),
                "{remark}"
            );
            assert_eq!(mix.with_log_s(2.5).remark(&healthy), None);
            assert_eq!(mix.remark(&healthy), None);
            assert!(media(mix.with_log_s(f64::NAN)).straylight.is_finite());
        }
    }

    #[test]
    fn clouds_dazzle_by_the_pupil_and_where_they_lie() {
        let change = |cataract: Cataract| {
            let media = media(cataract);
            media.straylight_through(2.0) / media.straylight_through(6.0)
        };
        assert!(change(Cataract::posterior_subcapsular(1.5)) > 2.0);
        // Through 6 mm a little of the light passes beside the nucleus, and more meets the rim.
        let nuclear = change(Cataract::nuclear(3.0));
        assert!((1.0..1.1).contains(&nuclear), "{nuclear}");
        let cortical = change(Cataract::cortical(3.0));
        assert!((0.5..0.7).contains(&cortical), "{cortical}");
        // Before and after dilation, log s of whole eyes (see `CORTEX_RIM`): cortical 1.38 and 1.51, or 1.45 and 1.63;
        // nuclear 1.71 and 1.66.
        let dilated = |cataract: Cataract| {
            let media = media(cataract);
            let healthy = 10f64.powf(OcularMedia::healthy(70.0, 0.5).log_straylight());
            (healthy + media.straylight_through(6.9)).log10() - media.log_straylight()
        };
        let cortical = dilated(Cataract::cortical(3.0).with_log_s(1.38));
        assert!((0.09..0.18).contains(&cortical), "{cortical}");
        let nuclear = dilated(Cataract::nuclear(3.0).with_log_s(1.71));
        assert!((-0.08..-0.01).contains(&nuclear), "{nuclear}");
        // A measured straylight is shared out as the grades are.
        let measured = Cataract {
            nuclear: 3.0,
            subcapsular: 2.0,
            ..Cataract::default()
        }
        .with_log_s(1.6);
        let of_both = change(measured);
        assert!(of_both > 1.05 && of_both < change(Cataract::posterior_subcapsular(2.0)));
    }

    #[test]
    fn density_rises_as_cameras_find_it() {
        let back = |grade: f64| media(Cataract::nuclear(grade)).nuclear_backscatter + 0.015;
        // Scheimpflug density of NO3 over NO1: 167.3 over 96.7; of three Emery grades: 3.1 times.
        let ratio = back(3.0) / back(1.0);
        assert!((1.73..=3.1).contains(&ratio), "{ratio}");
        let shares = [2.0, 5.0].map(|grade| media(Cataract::cortical(grade)).cortical_share);
        assert!((shares[0] - 0.23).abs() < 0.01 && (shares[1] - 0.9).abs() < 1e-9);
        let cloud = media(Cataract::posterior_subcapsular(3.0)).subcapsular_mm;
        // A fifth of the disc as it is seen through the cornea and the lens.
        let seen = (cloud / CAPSULE_BEAM / LENS_DISC_MM).powi(2);
        assert!((0.18..0.23).contains(&seen), "{seen}");
    }

    #[test]
    fn nonsense_is_no_cataract() {
        for grade in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            assert!(media(Cataract::nuclear(grade)).is_clear());
        }
        let most = media(Cataract::nuclear(1e9));
        assert_eq!(most, media(Cataract::nuclear(6.9)));
    }
}
