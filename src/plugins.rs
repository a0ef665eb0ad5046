//! The plugins together, and what is used with them.

use bevy::app::{PluginGroup, PluginGroupBuilder};

/// Everything that makes people see, move and be seen: add it to an app with Bevy's `DefaultPlugins`.
pub struct OculariumPlugins;

impl PluginGroup for OculariumPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(crate::frame::FramePlugin)
            .add(crate::conditions::ConditionsPlugin)
            .add(crate::motion::MotionPlugin)
            .add(crate::percept::PerceptPlugin)
            .add(crate::appearance::AppearancePlugin)
    }
}

/// What an app of one's own needs.
pub mod prelude {
    pub use super::OculariumPlugins;
    pub use crate::anatomy::{
        Adaptation, Cornea, Effective, Eye, EyeOf, Eyelids, Eyes, Gaze, Iris, IrisColor,
        Laterality, Lens, Lids, Look, OcularMedia, Patient, Pupil, PupilControl, Refraction,
        Sclera, Skin,
    };
    pub use crate::appearance::{
        EyeLight, EyeModel, EyeProbe, EyeSurroundings, Studio, StudioLight,
    };
    pub use crate::conditions::{
        AddCondition, Cataract, Condition, Glaucoma, GlaucomaStage, Ptosis,
    };
    pub use crate::frame::{EyeSystems, Panel, SimulationClock};
    pub use crate::motion::engine::GazeCommand;
    pub use crate::motion::{GazeController, MotionCommand};
    pub use crate::patients::{PatientFile, load_patient};
    pub use crate::percept::{Percept, SeesAs, SharpnessField, ViewOptions};
    pub use crate::scene::photo_view::Photograph;
    pub use bevy::camera::Hdr;
}
