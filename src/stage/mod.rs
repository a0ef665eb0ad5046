//! The stage: one patient before one scene, on two panels: her eye, and what it sees.
//!
//! Enters: a [`Session`] (patient, scene, seed), then [`SessionCommand`]s. Leaves: the entities that
//! show it, all of them parts that any app may use: a patient with two eyes, an [`EyeModel`] in a
//! studio with a camera before it, and a camera that [`SeesAs`] she does.

pub mod head;
mod panel_light;
mod scene_light;
mod scene_view;

pub use panel_light::PanelLight;

pub use head::{Head, HeadPath};

use crate::anatomy::{Adaptation, Patient};
use crate::appearance::{
    EyeCamera, EyeDetail, EyeLight, EyeModel, EyeOrbit, EyeQuality, eye_camera,
};
use crate::frame::readiness::Readiness;
use crate::frame::{
    EyeCommands, EyeSystems, Panel, SimulationClock, cluster_lights_on_the_processor,
};
use crate::motion::{Candidates, GazeController};
use crate::patients::PatientFile;
use crate::percept::places::unseen_places;
use crate::percept::{Percept, SeesAs, SharpnessField, ViewOptions};
use crate::scene::catalog::LoadedScene;
use crate::scene::playing::{PlayingScene, play};
use bevy::camera::RenderTarget;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::sync::Arc;

/// Layer of the eye that is shown, away from what it sees.
pub const EYE_LAYER: usize = 30;
/// Smaller side of a panel above which the finest maps of the eye show, pixels.
const FINE_ABOVE_PX: u32 = 560;

/// What is shown at first.
#[derive(Clone)]
pub struct Session {
    /// The patient, as read and checked.
    pub patient: PatientFile,
    /// What is looked at.
    pub scene: Arc<LoadedScene>,
    /// Seed of every random choice.
    pub seed: u64,
    /// What the eye is lit by.
    pub light: PanelLight,
}

impl Session {
    /// A session that begins with these, the eye before a window.
    pub fn new(patient: PatientFile, scene: LoadedScene, seed: u64) -> Self {
        Self {
            patient,
            scene: Arc::new(scene),
            seed,
            light: PanelLight::default(),
        }
    }
}

/// What a user, a link or a script may ask of the stage.
#[derive(Message, Clone)]
pub enum SessionCommand {
    /// Show this patient, from time 0.
    Patient(Box<PatientFile>),
    /// Let the patient be like this from now on.
    Change(Box<PatientFile>),
    /// Look at this scene, from time 0.
    Scene(Arc<LoadedScene>),
    /// Start again at time 0 with this seed.
    Restart(u64),
}

/// Time has begun anew at 0.
#[derive(Message, Clone, Copy, Debug)]
pub struct Restarted;

/// Who and what is on the stage.
#[derive(Resource, Clone)]
pub struct Stage {
    /// The patient.
    pub patient: Entity,
    /// Her eye, seen from outside.
    pub model: Entity,
    /// The camera before it.
    pub eye: Entity,
    /// The camera that sees as she does.
    pub view: Entity,
    /// What she looks at.
    pub scene: Arc<LoadedScene>,
}

/// The stage's two panels.
#[derive(SystemParam)]
pub struct Panels<'w, 's> {
    stage: Res<'w, Stage>,
    panels: Query<'w, 's, &'static mut Panel>,
}

impl Panels<'_, '_> {
    fn panel(&self, camera: Entity) -> &Panel {
        self.panels.get(camera).expect(HAS_PANEL)
    }

    /// The panel of the eye.
    pub fn eye(&self) -> &Panel {
        self.panel(self.stage.eye)
    }

    /// The panel of what it sees.
    pub fn view(&self) -> &Panel {
        self.panel(self.stage.view)
    }

    /// The panel of the eye, to be shown, hidden or resized.
    pub fn eye_mut(&mut self) -> Mut<'_, Panel> {
        self.panels.get_mut(self.stage.eye).expect(HAS_PANEL)
    }

    /// The panel of the view, to be shown, hidden or resized.
    pub fn view_mut(&mut self) -> Mut<'_, Panel> {
        self.panels.get_mut(self.stage.view).expect(HAS_PANEL)
    }

    /// Which are shown: (eye, view).
    pub fn shown(&self) -> [bool; 2] {
        [self.eye().visible, self.view().visible]
    }

    /// Shows or hides them.
    pub fn show(&mut self, shown: [bool; 2]) {
        for (camera, visible) in [self.stage.eye, self.stage.view].into_iter().zip(shown) {
            let mut panel = self.panels.get_mut(camera).expect(HAS_PANEL);
            if panel.visible != visible {
                panel.visible = visible;
            }
        }
    }
}

/// The stage's cameras are made with their panels, and nobody takes those away.
const HAS_PANEL: &str = "the stage's cameras have panels";

/// Sets the stage.
pub struct StagePlugin {
    /// What is shown at first.
    pub session: Session,
    /// Sizes of the panels in pixels (eye, view).
    pub sizes: [UVec2; 2],
    /// Which panels are shown at first (eye, view).
    pub shown: [bool; 2],
}

impl Plugin for StagePlugin {
    fn build(&self, app: &mut App) {
        let stage = set(app.world_mut(), &self.session, self.sizes, self.shown);
        app.insert_resource(stage)
            .init_resource::<scene_light::FoundLight>()
            .add_message::<SessionCommand>()
            .add_message::<Restarted>()
            .add_systems(PreStartup, cluster_lights_on_the_processor)
            .add_systems(
                Update,
                (
                    offer_unseen_places.before(EyeCommands),
                    (
                        carry_out,
                        sync_models_with_panels,
                        scene_view::fit_field,
                        scene_light::adapt,
                    )
                        .chain()
                        .in_set(EyeCommands),
                )
                    .in_set(EyeSystems::Sense),
            )
            .add_systems(
                Update,
                (
                    (
                        head::follow_path,
                        head::place_head,
                        scene_light::light_by_scene,
                    )
                        .chain(),
                    play.run_if(any_with_component::<PlayingScene>.and_then(is_view_shown)),
                )
                    .in_set(EyeSystems::Move),
            );
    }
}

/// What nobody looks at does not move.
fn is_view_shown(stage: Res<Stage>, panels: Query<&Panel>) -> bool {
    panels.get(stage.view).is_ok_and(|panel| panel.visible)
}

/// Spawns everybody and everything.
fn set(world: &mut World, session: &Session, sizes: [UVec2; 2], shown: [bool; 2]) -> Stage {
    let [eye_panel, view_panel] = {
        let mut images = world.resource_mut::<Assets<Image>>();
        [0, 1].map(|i| Panel::new(&mut images, sizes[i], shown[i]))
    };
    let patient = world
        .spawn((
            session.patient.clone(),
            GazeController::with_seed(session.seed),
            Candidates::default(),
            Adaptation {
                luminance_cd_m2: session.scene.mean_luminance_cd_m2(),
                is_measured: false,
            },
        ))
        .id();
    let layer = RenderLayers::layer(EYE_LAYER);
    let model = world
        .spawn((EyeModel(patient), session.light.component(), layer.clone()))
        .id();
    let eye = world.spawn(eye_camera(model, eye_panel, layer)).id();
    let view = world
        .spawn((
            Camera3d::default(),
            Camera {
                order: -1,
                ..default()
            },
            RenderTarget::Image(view_panel.image.clone().into()),
            view_panel,
            SeesAs(patient),
            Head::default(),
            head::Seat::default(),
        ))
        .id();
    world.flush();
    let stage = Stage {
        patient,
        model,
        eye,
        view,
        scene: session.scene.clone(),
    };
    world.insert_resource(scene_view::Wanted(session.scene.clone()));
    stage
}

/// What begins anew with time.
type Living<'a> = (&'a mut GazeController, &'a mut SharpnessField);

/// Carries out the commands of this frame.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads and makes"
)]
fn carry_out(
    mut asked: MessageReader<SessionCommand>,
    mut restarted: MessageWriter<Restarted>,
    mut stage: ResMut<Stage>,
    mut clock: ResMut<SimulationClock>,
    mut living: Query<Living>,
    mut heads: Query<&mut Head>,
    mut wanted: ResMut<scene_view::Wanted>,
    mut scenery: scene_view::Scenery,
    mut commands: Commands,
) {
    for command in asked.read() {
        let Ok((mut controller, mut memory)) = living.get_mut(stage.patient) else {
            continue;
        };
        let mut seed = controller.seed();
        match command {
            SessionCommand::Change(file) => {
                commands.entity(stage.patient).insert((**file).clone());
                continue;
            }
            SessionCommand::Patient(file) => {
                commands.entity(stage.patient).insert((**file).clone());
            }
            SessionCommand::Scene(scene) => wanted.0 = scene.clone(),
            SessionCommand::Restart(asked) => seed = *asked,
        }
        controller.restart(seed);
        memory.restart();
        clock.time_s = 0.0;
        if let Ok(mut head) = heads.get_mut(stage.view) {
            head.set_if_neq(Head::default());
        }
        restarted.write(Restarted);
    }
    if wanted.is_changed() {
        stage.scene = wanted.0.clone();
        // Time waits for the new scene's candidates.
        clock.ready = false;
        commands.entity(stage.patient).insert(Adaptation {
            luminance_cd_m2: stage.scene.mean_luminance_cd_m2(),
            is_measured: false,
        });
        scenery.put(&stage, &mut commands);
    }
}

/// What is hidden is not moved, and small pictures do with small maps.
fn sync_models_with_panels(
    panels: Panels,
    mut models: Query<(&mut Visibility, &mut EyeDetail), With<EyeModel>>,
) {
    let panel = panels.eye();
    if let Ok((mut visibility, mut detail)) = models.get_mut(panels.stage.model) {
        visibility.set_if_neq(if panel.visible {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        });
        detail.set_if_neq(EyeDetail {
            fine: panel.size.min_element() > FINE_ABOVE_PX,
        });
    }
}

/// An eye that is shown alone still looks about; no pass of the view runs for it. Where its head goes it finds what is
/// there.
fn offer_unseen_places(
    panels: Panels,
    readiness: Res<Readiness>,
    mut clock: ResMut<SimulationClock>,
    mut found: ResMut<scene_light::FoundLight>,
    heads: Query<(&Head, &Transform)>,
    mut people: Query<(&GazeController, &mut Candidates), With<Patient>>,
    mut offered_at: Local<Option<Transform>>,
) {
    let stage = &panels.stage;
    let Ok((head, place)) = heads.get(stage.view) else {
        return;
    };
    if panels.view().visible {
        *offered_at = None;
        return;
    }
    let is_away = *head != Head::default();
    let has_moved = scene_light::has_moved(
        offered_at.as_ref(),
        place,
        scene_light::ADAPTED_M,
        scene_light::TURNED_RAD,
    );
    let is_wanted = (!clock.ready && readiness.quiet_frames() >= 3)
        || (clock.ready && has_moved && (is_away || offered_at.is_some()));
    if !is_wanted {
        return;
    }
    if let Ok((controller, mut candidates)) = people.get_mut(stage.patient) {
        *offered_at = Some(*place);
        let tree = is_away.then(|| found.tree_of(&stage.scene)).flatten();
        let from = tree.map(|tree| (place, tree));
        let (list, ahead_distance_m) = unseen_places(&stage.scene, from, controller.seed());
        *candidates = Candidates {
            list,
            ahead_distance_m,
        };
        clock.ready = true;
    }
}

/// What a picture of the stage depends on beside patient, scene and time.
#[derive(SystemParam)]
pub struct StageView<'w, 's> {
    stage: Res<'w, Stage>,
    eye: Query<'w, 's, (&'static mut EyeOrbit, &'static mut EyeQuality), With<EyeCamera>>,
    view: Query<'w, 's, (&'static mut ViewOptions, &'static Percept)>,
    people: Query<'w, 's, (&'static Patient, &'static GazeController)>,
    heads: Query<'w, 's, &'static mut Head, Without<HeadPath>>,
    lights: Query<'w, 's, &'static mut EyeLight>,
}

impl StageView<'_, '_> {
    /// Where the camera before the eye stands.
    pub fn orbit(&self) -> EyeOrbit {
        self.eye
            .get(self.stage.eye)
            .map_or_else(|_| EyeOrbit::default(), |(orbit, _)| *orbit)
    }

    /// Puts that camera elsewhere.
    pub fn set_orbit(&mut self, orbit: EyeOrbit) {
        if let Ok((mut now, _)) = self.eye.get_mut(self.stage.eye) {
            now.set_if_neq(orbit.clamped());
        }
    }

    /// What the eye is lit by.
    pub fn light(&self) -> PanelLight {
        let light = self.lights.get(self.stage.model);
        light.map_or_else(|_| PanelLight::default(), PanelLight::from)
    }

    /// Lights the eye otherwise.
    pub fn set_light(&mut self, light: PanelLight) {
        if let Ok(mut now) = self.lights.get_mut(self.stage.model) {
            now.set_if_neq(light.component());
        }
    }

    /// Draws the eye this finely.
    pub fn set_quality(&mut self, quality: EyeQuality) {
        if let Ok((_, mut now)) = self.eye.get_mut(self.stage.eye) {
            now.set_if_neq(quality);
        }
    }

    /// What is chosen about the view.
    pub fn options(&self) -> ViewOptions {
        self.view
            .get(self.stage.view)
            .map_or_else(|_| ViewOptions::default(), |(options, _)| *options)
    }

    /// Changes what is chosen about the view.
    pub fn set_options(&mut self, options: ViewOptions) {
        if let Ok((mut now, _)) = self.view.get_mut(self.stage.view) {
            now.set_if_neq(options);
        }
    }

    /// Where the head is.
    pub fn head(&self) -> Head {
        self.heads.get(self.stage.view).copied().unwrap_or_default()
    }

    /// Moves the head, unless it goes on a path.
    pub fn set_head(&mut self, head: Head) {
        if let Ok(mut now) = self.heads.get_mut(self.stage.view) {
            now.set_if_neq(head.clamped());
        }
    }

    /// The state of the view; `None` for a stage whose view camera was taken away.
    pub fn percept(&self) -> Option<&Percept> {
        self.view
            .get(self.stage.view)
            .ok()
            .map(|(_, percept)| percept)
    }

    /// What moves the patient's eyes; `None` before the first frame.
    pub fn controller(&self) -> Option<&GazeController> {
        self.people
            .get(self.stage.patient)
            .ok()
            .map(|(_, controller)| controller)
    }

    /// The patient; `None` before the first frame.
    pub fn patient(&self) -> Option<&Patient> {
        self.people
            .get(self.stage.patient)
            .ok()
            .map(|(patient, _)| patient)
    }
}
