//! Glaucoma: loss of nerve fibres, and with them of the visual field.
//!
//! Enters: a stage after Hodapp, Parrish and Anderson (1993). Leaves: what it takes of a
//! [`VisualField`]: glaucoma kills bundles of fibres, not places.

use super::{Affected, Condition, Control};
use crate::anatomy::visual_field::{BundleLoss, VisualField};
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

/// Glaucoma of an eye, or of both eyes of a person. Without it there is no pass, key or texture of it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
#[serde(transparent)]
pub struct Glaucoma {
    /// Hodapp–Parrish–Anderson stage.
    pub stage: GlaucomaStage,
}

impl Glaucoma {
    /// Takes of a field what this stage takes. Depths are chosen so that the mean deviations fall
    /// into the classes of Hodapp, Parrish and Anderson (1993); places are the usual ones, the
    /// arcuate bundles about 7 and 11 o'clock of the disc, the lower first. The factor of
    /// eccentricity is a model choice for Nießner's "significantly larger" (2013, section 3).
    fn take_from(&self, field: &mut VisualField) {
        let group = |centre_deg, spread_deg, depth_db, near_share| BundleLoss {
            centre_deg,
            spread_deg,
            depth_db,
            near_share,
        };
        let (even_db, groups, factor) = match self.stage {
            GlaucomaStage::Early => (
                1.0,
                [group(-135.0, 18.0, 20.0, 0.2), group(130.0, 12.0, 4.0, 0.0)],
                1.5,
            ),
            GlaucomaStage::Moderate => (
                2.0,
                [
                    group(-120.0, 21.0, 28.0, 0.8),
                    group(130.0, 15.0, 11.0, 0.2),
                ],
                3.0,
            ),
            GlaucomaStage::Severe => (
                4.0,
                [
                    group(-116.0, 27.0, 30.0, 1.0),
                    group(122.0, 19.0, 26.0, 0.8),
                ],
                5.0,
            ),
        };
        field.lose(even_db, &groups, factor);
    }
}

/// The stages, in their order.
const STAGES: [GlaucomaStage; 3] = [
    GlaucomaStage::Early,
    GlaucomaStage::Moderate,
    GlaucomaStage::Severe,
];

impl Condition for Glaucoma {
    const TITLE: &'static str = "Glaucoma";

    fn onset() -> Self {
        Self {
            stage: GlaucomaStage::Early,
        }
    }

    fn controls() -> &'static [Control<Self>] {
        &[Control {
            name: "stage",
            range: (1.0, 3.0),
            meaning: "early, moderate, severe (Hodapp, Parrish and Anderson)",
            get: |own| own.stage as u8 as f64 + 1.0,
            set: |own, value| own.stage = STAGES[(value.round() as usize).clamp(1, 3) - 1],
        }]
    }

    fn write(&self, affected: &mut Affected) {
        self.take_from(&mut affected.field);
    }

    fn caption(&self) -> String {
        match self.stage {
            GlaucomaStage::Early => "Early glaucoma: a mean deviation better than −6 dB.".into(),
            GlaucomaStage::Moderate => {
                "Moderate glaucoma: a mean deviation of −6 to −12 dB.".into()
            }
            GlaucomaStage::Severe => "Severe glaucoma: a mean deviation worse than −12 dB.".into(),
        }
    }
}

/// The field of an eye of this side and age (years) with glaucoma of this stage.
pub fn glaucoma_field(
    stage: GlaucomaStage,
    eye: crate::anatomy::Laterality,
    age_years: f64,
) -> VisualField {
    let mut field = VisualField::normal(eye, age_years);
    Glaucoma { stage }.take_from(&mut field);
    field
}
