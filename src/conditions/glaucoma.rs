//! Glaucoma: loss of nerve fibres, and with them of the visual field.
//!
//! Enters: a mean deviation in dB, or a stage after Hodapp, Parrish and Anderson (1993), which is one
//! in the middle of its class. Leaves: what it takes of a [`VisualField`]: glaucoma kills bundles of
//! fibres, not places.

use super::{Affected, Condition, Control, short};
use crate::anatomy::visual_field::{BundleLoss, VisualField};
use crate::optics::root::illinois;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::Component;
use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

/// Stage of glaucoma after Hodapp, Parrish and Anderson, by mean deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Reflect)]
pub enum GlaucomaStage {
    /// Mean deviation better than −6 dB.
    Early,
    /// −6 to −12 dB.
    Moderate,
    /// Worse than −12 dB.
    Severe,
}

impl GlaucomaStage {
    /// All of them, in their order.
    pub const ALL: [Self; 3] = [Self::Early, Self::Moderate, Self::Severe];

    /// The mean deviation that stands for this stage, dB.
    #[must_use]
    pub fn mean_deviation_db(self) -> f64 {
        COURSE[self as usize + 1].mean_deviation_db
    }

    /// The stage of a mean deviation in dB.
    #[must_use]
    pub fn of(mean_deviation_db: f64) -> Self {
        if mean_deviation_db > -6.0 {
            Self::Early
        } else if mean_deviation_db >= -12.0 {
            Self::Moderate
        } else {
            Self::Severe
        }
    }
}

/// Least mean deviation, dB: the normal field of 50 years has a mean of 30.6 dB, and none can be lost
/// that was not there.
pub const LEAST_MEAN_DEVIATION_DB: f64 = -30.0;

/// Glaucoma of an eye, or of both eyes of a person. Without it there is no pass, key or texture of it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
#[serde(from = "Written", into = "Written")]
pub struct Glaucoma {
    /// Mean deviation of the field from that of healthy people of the same age over the places of
    /// the 24-2, dB, unweighted: 0 to [`LEAST_MEAN_DEVIATION_DB`].
    pub mean_deviation_db: f64,
}

/// As it stands in files and links.
#[derive(Serialize, Deserialize)]
#[serde(rename = "glaucoma")]
enum Written {
    Early,
    Moderate,
    Severe,
    MeanDeviation(f64),
}

impl From<Written> for Glaucoma {
    fn from(written: Written) -> Self {
        match written {
            Written::Early => GlaucomaStage::Early.into(),
            Written::Moderate => GlaucomaStage::Moderate.into(),
            Written::Severe => GlaucomaStage::Severe.into(),
            Written::MeanDeviation(mean_deviation_db) => Self { mean_deviation_db },
        }
    }
}

impl From<Glaucoma> for Written {
    fn from(glaucoma: Glaucoma) -> Self {
        let is = |stage: GlaucomaStage| glaucoma == stage.into();
        if is(GlaucomaStage::Early) {
            Self::Early
        } else if is(GlaucomaStage::Moderate) {
            Self::Moderate
        } else if is(GlaucomaStage::Severe) {
            Self::Severe
        } else {
            Self::MeanDeviation(glaucoma.mean_deviation_db)
        }
    }
}

impl From<GlaucomaStage> for Glaucoma {
    fn from(stage: GlaucomaStage) -> Self {
        Self::mean_deviation(stage.mean_deviation_db())
    }
}

/// What has been lost at one point of the course.
#[derive(Clone, Copy)]
struct Loss {
    /// Its mean deviation at 50 years, dB: where along the course it stands.
    mean_deviation_db: f64,
    /// Loss everywhere, dB.
    even_db: f64,
    /// The bundles that enter the disc above its middle in the field's lower half, then the others.
    groups: [BundleLoss; 2],
    /// How much faster than in a healthy eye blur grows with eccentricity.
    blur_factor: f64,
}

const fn group(centre_deg: f64, spread_deg: f64, depth_db: f64, near_share: f64) -> BundleLoss {
    BundleLoss {
        centre_deg,
        spread_deg,
        depth_db,
        near_share,
    }
}

/// Both arcuate bundles as the disease leaves them at last.
const LAST_GROUPS: [BundleLoss; 2] = [
    group(-112.0, 36.0, 34.0, 1.0),
    group(116.0, 34.0, 34.0, 1.0),
];

/// The course: from the whole field by way of the three stages to the blind one. Depths are chosen so
/// that mean deviations fall into the classes of Hodapp, Parrish and Anderson (1993); places are the
/// usual ones, the arcuate bundles about 7 and 11 o'clock of the disc, the lower first. What is left
/// last lies temporally and about the middle. The factor of eccentricity is a model choice for
/// Nießner's "significantly larger" (2013, section 3).
const COURSE: [Loss; 6] = [
    Loss {
        mean_deviation_db: 0.0,
        even_db: 0.0,
        groups: [group(-135.0, 18.0, 0.0, 0.2), group(130.0, 12.0, 0.0, 0.0)],
        blur_factor: 1.0,
    },
    Loss {
        mean_deviation_db: -3.02,
        even_db: 1.0,
        groups: [group(-135.0, 18.0, 20.0, 0.2), group(130.0, 12.0, 4.0, 0.0)],
        blur_factor: 1.5,
    },
    Loss {
        mean_deviation_db: -9.55,
        even_db: 2.0,
        groups: [
            group(-120.0, 21.0, 28.0, 0.8),
            group(130.0, 15.0, 11.0, 0.2),
        ],
        blur_factor: 3.0,
    },
    Loss {
        mean_deviation_db: -19.41,
        even_db: 4.0,
        groups: [
            group(-116.0, 27.0, 30.0, 1.0),
            group(122.0, 19.0, 26.0, 0.8),
        ],
        blur_factor: 5.0,
    },
    Loss {
        mean_deviation_db: -28.19,
        even_db: 10.0,
        groups: LAST_GROUPS,
        blur_factor: 6.0,
    },
    Loss {
        mean_deviation_db: -30.6,
        even_db: 36.0,
        groups: LAST_GROUPS,
        blur_factor: 6.0,
    },
];

impl Loss {
    /// Between two points of the course, `share` of the way.
    fn between(a: &Self, b: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let group = |i: usize| {
            let (a, b): (&BundleLoss, &BundleLoss) = (&a.groups[i], &b.groups[i]);
            BundleLoss {
                centre_deg: mix(a.centre_deg, b.centre_deg),
                spread_deg: mix(a.spread_deg, b.spread_deg),
                depth_db: mix(a.depth_db, b.depth_db),
                near_share: mix(a.near_share, b.near_share),
            }
        };
        Self {
            mean_deviation_db: mix(a.mean_deviation_db, b.mean_deviation_db),
            even_db: mix(a.even_db, b.even_db),
            groups: [group(0), group(1)],
            blur_factor: mix(a.blur_factor, b.blur_factor),
        }
    }

    /// At `way` along the course, 0 to 5.
    fn at(way: f64) -> Self {
        let last = (way as usize).min(COURSE.len() - 2);
        Self::between(&COURSE[last], &COURSE[last + 1], way - last as f64)
    }

    fn take_from(&self, field: &mut VisualField) {
        field.lose(self.even_db, &self.groups, self.blur_factor);
    }
}

impl Glaucoma {
    /// Glaucoma of this mean deviation in dB, 0 to [`LEAST_MEAN_DEVIATION_DB`]; what is out of range
    /// counts as the nearer end, and what is no number as none.
    #[must_use]
    pub fn mean_deviation(mean_deviation_db: f64) -> Self {
        Self { mean_deviation_db }
    }

    /// Its stage.
    #[must_use]
    pub fn stage(&self) -> GlaucomaStage {
        GlaucomaStage::of(self.mean_deviation_db)
    }

    fn within_range(&self) -> f64 {
        if self.mean_deviation_db.is_nan() {
            0.0
        } else {
            self.mean_deviation_db.clamp(LEAST_MEAN_DEVIATION_DB, 0.0)
        }
    }

    /// How far along the course a field like `whole` has this mean deviation, to 0.001 dB. The deviation
    /// falls along the course, so it stands between two of its points.
    fn way(&self, whole: &VisualField) -> f64 {
        let wanted = self.within_range();
        let excess = |way: f64| {
            let mut field = whole.clone();
            Loss::at(way).take_from(&mut field);
            field.mean_deviation_db() - whole.mean_deviation_db() - wanted
        };
        let mut before = (0.0, -wanted);
        if before.1 == 0.0 {
            return 0.0;
        }
        for point in 1..COURSE.len() {
            let here = (point as f64, excess(point as f64));
            if here.1 <= 0.0 {
                return illinois(before, here, 1e-3, excess);
            }
            before = here;
        }
        before.0
    }

    fn take_from(&self, field: &mut VisualField) {
        let way = self.way(field);
        if way > 0.0 {
            Loss::at(way).take_from(field);
        }
    }
}

impl Condition for Glaucoma {
    const TITLE: &'static str = "Glaucoma";

    fn onset() -> Self {
        GlaucomaStage::Early.into()
    }

    fn controls() -> &'static [Control<Self>] {
        &[Control {
            name: "mean_deviation_db",
            range: (LEAST_MEAN_DEVIATION_DB, 0.0),
            meaning: "mean deviation of the field, dB: early to -6, moderate to -12, then severe",
            get: |own| Some(own.mean_deviation_db),
            set: |own, value| own.mean_deviation_db = value,
        }]
    }

    fn write(&self, affected: &mut Affected) {
        self.take_from(&mut affected.field);
    }

    fn caption(&self) -> String {
        if self.within_range() == 0.0 {
            return "Glaucoma without a loss of the field.".into();
        }
        let stage = match self.stage() {
            GlaucomaStage::Early => "Early",
            GlaucomaStage::Moderate => "Moderate",
            GlaucomaStage::Severe => "Severe",
        };
        let deviation = short(self.within_range());
        format!("{stage} glaucoma: a mean deviation of {deviation} dB.")
    }
}

/// The field of an eye of this side and age (years) with this glaucoma.
pub fn glaucoma_field(
    glaucoma: impl Into<Glaucoma>,
    eye: crate::anatomy::Laterality,
    age_years: f64,
) -> VisualField {
    let mut field = VisualField::normal(eye, age_years);
    glaucoma.into().take_from(&mut field);
    field
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::Laterality;

    #[test]
    fn the_course_falls_and_its_points_are_where_they_say() {
        let mut last = 0.1;
        for step in 0..=200 {
            let way = f64::from(step) / 40.0;
            let mut field = VisualField::normal(Laterality::OD, 50.0);
            Loss::at(way).take_from(&mut field);
            let deviation = field.mean_deviation_db();
            // Blind is blind.
            let is_blind = deviation < -30.6;
            assert!(
                deviation < last || is_blind,
                "{deviation} after {last} at {way}"
            );
            last = deviation;
            if step % 40 == 0 {
                println!("{way}: {deviation:.3} dB");
                let said = COURSE[step as usize / 40].mean_deviation_db;
                assert!(
                    (deviation - said).abs() < 0.01,
                    "{deviation}, not {said}, at {way}"
                );
            }
        }
    }

    #[test]
    fn a_field_has_the_mean_deviation_that_was_asked_for() {
        for eye in [Laterality::OD, Laterality::OS] {
            for age_years in [20.0, 50.0, 66.0, 85.0] {
                let mut last = 0.0;
                for wanted in [-0.5, -2.0, -5.9, -8.0, -14.0, -22.0, -27.0] {
                    let field = glaucoma_field(Glaucoma::mean_deviation(wanted), eye, age_years);
                    let found = field.mean_deviation_db();
                    assert!((found - wanted).abs() < 2e-3, "{found}, not {wanted}");
                    assert!(field.eccentricity_factor() >= last);
                    last = field.eccentricity_factor();
                }
            }
        }
    }

    #[test]
    fn it_progresses_without_a_jump() {
        let at = |deviation: f64| {
            let field = glaucoma_field(Glaucoma::mean_deviation(deviation), Laterality::OD, 60.0);
            let mut places = Vec::new();
            for x in -9..=9 {
                for y in -9..=9 {
                    let place = |i: i32| (3.0 * f64::from(i)).to_radians();
                    places.push(field.sensitivity_db(place(x), place(y)));
                }
            }
            places
        };
        let mut before = at(0.0);
        for step in 1..=290 {
            let after = at(-0.1 * f64::from(step));
            for (a, b) in before.iter().zip(&after) {
                // A tenth of a decibel of the mean moves no place by more than two.
                assert!((a - b).abs() < 2.0, "{a} to {b} at step {step}");
            }
            before = after;
        }
    }

    #[test]
    fn nonsense_is_the_nearer_end() {
        let normal = VisualField::normal(Laterality::OD, 40.0);
        for none in [f64::NAN, 0.0, 3.0, f64::INFINITY] {
            assert_eq!(
                glaucoma_field(Glaucoma::mean_deviation(none), Laterality::OD, 40.0),
                normal
            );
        }
        let least = glaucoma_field(
            Glaucoma::mean_deviation(LEAST_MEAN_DEVIATION_DB),
            Laterality::OD,
            40.0,
        );
        let beyond = Glaucoma::mean_deviation(f64::NEG_INFINITY);
        assert_eq!(glaucoma_field(beyond, Laterality::OD, 40.0), least);
    }

    #[test]
    fn stages_are_written_by_name_and_others_by_number() {
        for stage in GlaucomaStage::ALL {
            let glaucoma = Glaucoma::from(stage);
            assert_eq!(glaucoma.stage(), stage);
            let text = ron::to_string(&glaucoma).expect("it can be written");
            assert_eq!(text, format!("{stage:?}"));
            assert_eq!(ron::from_str::<Glaucoma>(&text).expect("read"), glaucoma);
        }
        let text = ron::to_string(&Glaucoma::mean_deviation(-7.5)).expect("written");
        assert_eq!(text, "MeanDeviation(-7.5)");
        let read: Glaucoma = ron::from_str("MeanDeviation(-7.5)").expect("read");
        assert_eq!(read, Glaucoma::mean_deviation(-7.5));
    }
}
