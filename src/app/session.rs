//! What is shown: a patient, a scene, a seed; and the commands that change them.

use super::SimulationClock;
use crate::anatomy::{Glaucoma, PatientFile};
use crate::scene::catalog::LoadedScene;
use bevy::prelude::*;
use std::sync::Arc;

/// What is shown.
#[derive(Resource, Clone)]
pub struct Session {
    /// The patient, as read and checked.
    pub patient: PatientFile,
    /// What is looked at.
    pub scene: Arc<LoadedScene>,
    /// Seed of every random choice.
    pub seed: u64,
    /// Counts changes of the scene.
    pub scene_version: u64,
    /// Counts restarts from time 0.
    pub restarts: u64,
}

impl Session {
    /// A session that begins with these.
    pub fn new(patient: PatientFile, scene: LoadedScene, seed: u64) -> Self {
        Self {
            patient,
            scene: Arc::new(scene),
            seed,
            scene_version: 1,
            restarts: 0,
        }
    }
}

/// What a user, a link or a script may ask of a session.
#[derive(Message, Clone)]
pub enum SessionCommand {
    /// Show this patient, from time 0.
    Patient(Box<PatientFile>),
    /// Look at this scene, from time 0.
    Scene(Arc<LoadedScene>),
    /// Start again at time 0 with this seed.
    Restart(u64),
}

/// The patient's entity.
#[derive(Component)]
pub struct PatientMarker;

/// Puts the first patient into the world.
pub fn spawn_patient(session: Res<Session>, mut commands: Commands) {
    let entity = commands.spawn(PatientMarker).id();
    dress(&session.patient, entity, &mut commands);
}

/// Gives an entity the components of this patient and takes away those that he has not.
fn dress(patient: &PatientFile, entity: Entity, commands: &mut Commands) {
    let mut entity = commands.entity(entity);
    entity.insert(patient.components());
    match patient.glaucoma {
        Some(stage) => entity.insert(Glaucoma { stage }),
        None => entity.remove::<Glaucoma>(),
    };
}

/// Obeys the commands of this frame.
pub fn obey(
    mut asked: MessageReader<SessionCommand>,
    mut session: ResMut<Session>,
    mut clock: ResMut<SimulationClock>,
    patient: Query<Entity, With<PatientMarker>>,
    mut commands: Commands,
) {
    for command in asked.read() {
        match command {
            SessionCommand::Patient(file) => {
                session.patient = (**file).clone();
                for entity in &patient {
                    dress(file, entity, &mut commands);
                }
            }
            SessionCommand::Scene(scene) => {
                session.scene = scene.clone();
                session.scene_version += 1;
                // Time waits for the new scene's candidates.
                clock.ready = false;
            }
            SessionCommand::Restart(seed) => session.seed = *seed,
        }
        session.restarts += 1;
        clock.time_s = 0.0;
    }
}
