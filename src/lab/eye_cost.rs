//! What an eye costs the processor in a frame, apart from what draws it.
//!
//! Leaves: [`EyeCost`] of an eye that turns, looks at one place, or is paused. Processor time runs from the beginning of a frame
//! until the render schedule begins to record commands: simulation, lids, tables, extraction and upload are in it, drawing is not.

use super::bench::BenchError;
use super::frame_cost::SIDE;
use super::headless::{Headless, Which};
use super::render::median;
use crate::appearance::EyeCamera;
use crate::frame::panel::target_image;
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::stage::Session;
use bevy::camera::RenderTarget;
use bevy::camera::visibility::RenderLayers;
use bevy::ecs::schedule::IntoScheduleConfigs;
use bevy::math::UVec2;
use bevy::prelude::*;
use bevy::render::{Render, RenderSystems};
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// A frame in which the gaze has changed by more than this, °, is one in which the eye turns.
const TURNING_DEG: f64 = 0.2;
/// Side of a panel in which skin and lids are as finely divided as they can be, pixels.
const LARGE_SIDE: u32 = 800;
/// Parts of an eye that are drawn: three of the globe, conjunctiva, skin, lid margins, lashes, brow and tears.
const EYE_PARTS: usize = 9;
/// In how many turns the ways of showing an eye are measured.
const ROUNDS: usize = 5;
/// A layer on which nothing else is.
const PLAIN_LAYER: usize = 29;
/// Frames of a sixtieth of a second between two commands to look elsewhere: a saccade begins 0.2 s
/// after its command.
const TURN_EVERY: usize = 20;

/// Milliseconds of the processor in frames of an eye, less those of the same frames without one.
#[derive(Clone, Debug, Serialize)]
pub struct EyeCost {
    /// Frames with nothing shown.
    pub nothing_shown_ms: f64,
    /// Added by an eye that is shown, in frames in which it turns.
    pub turning_ms: f64,
    /// Added by one that looks at one place while time runs: its pupil is never at rest.
    pub still_ms: f64,
    /// The same two where its camera is awake as before, but no part of the eye is on its layers: all
    /// that an eye needs is worked out and handed to the device, and only the drawing is missing, after
    /// which a software rasteriser leaves cold caches to everything else.
    pub turning_undrawn_ms: f64,
    /// See [`Self::turning_undrawn_ms`].
    pub still_undrawn_ms: f64,
    /// As [`Self::turning_undrawn_ms`], with skin and lids as finely divided as in a large picture.
    pub turning_finest_undrawn_ms: f64,
    /// Added by one whose time stands.
    pub paused_ms: f64,
    /// Added by a camera of Bevy's that draws as many plain meshes every frame, one of whose materials
    /// changes: what no eye that is drawn can do without.
    pub plain_meshes_ms: f64,
    /// Added by a camera of Bevy's with nothing before it: what no eye whose camera is awake can do without.
    pub plain_camera_ms: f64,
}

/// When the frame began, and what it took.
#[derive(Resource, Clone, Default)]
struct Stopwatch(Arc<Mutex<(Option<Instant>, f64)>>);

impl Stopwatch {
    fn begin(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).0 = Some(Instant::now());
    }

    fn end(&self) {
        let mut own = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(began) = own.0.take() {
            own.1 = began.elapsed().as_secs_f64() * 1e3;
        }
    }

    fn ms(&self) -> f64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).1
    }

    /// Puts a stopwatch into an app.
    fn put_into(headless: &mut Headless) -> Self {
        let own = Self::default();
        let recorded = own.clone();
        headless
            .render_app()
            .insert_resource(own.clone())
            .add_systems(
                Render,
                (move || recorded.end())
                    .after(RenderSystems::Prepare)
                    .before(RenderSystems::Render),
            );
        own
    }
}

/// Milliseconds of the processor in `count` frames from `from_s`, and in which of them the eye turned.
fn frames(
    headless: &mut Headless,
    stopwatch: &Stopwatch,
    count: usize,
    mut step: impl FnMut(&mut Headless, usize),
) -> Vec<(f64, bool)> {
    let gaze = |headless: &Headless| {
        let state = headless.state();
        (state.gaze_azimuth_rad, state.gaze_elevation_rad)
    };
    (0..count)
        .map(|frame| {
            let before = gaze(headless);
            stopwatch.begin();
            step(headless, frame);
            headless.finish_frame();
            let after = gaze(headless);
            let turned = (after.0 - before.0).hypot(after.1 - before.1).to_degrees();
            (stopwatch.ms(), turned > TURNING_DEG)
        })
        .collect()
}

fn look(headless: &mut Headless, azimuth_deg: f64) {
    headless
        .world()
        .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
            azimuth_rad: azimuth_deg.to_radians(),
            elevation_rad: 0.0,
            distance_m: 1.0,
        }));
}

/// Median of the frames that are wanted.
///
/// # Errors
/// Where there is none: an eye that should turn stood still, or the other way round.
fn median_of(frames: &[(f64, bool)], turning: bool) -> Result<f64, BenchError> {
    let mut chosen: Vec<f64> = frames
        .iter()
        .filter(|(_, turned)| *turned == turning)
        .map(|(ms, _)| *ms)
        .collect();
    if chosen.is_empty() {
        return Err(BenchError::NoSuchFrame(turning));
    }
    Ok(median(&mut chosen))
}

/// Gives the eye's camera other layers; returns those that it had.
fn swap_layers(headless: &mut Headless, layers: RenderLayers) -> RenderLayers {
    let world = headless.world();
    let mut cameras = world.query_filtered::<&mut RenderLayers, With<EyeCamera>>();
    cameras
        .iter_mut(world)
        .map(|mut of| std::mem::replace(&mut *of, layers.clone()))
        .next()
        .unwrap_or(layers)
}

/// As many boxes as an eye has parts, before a camera of their own.
struct Plain {
    camera: Entity,
    /// Of one of the boxes.
    material: Handle<StandardMaterial>,
}

impl Plain {
    fn spawn(headless: &mut Headless) -> Self {
        let world = headless.world();
        let image = world
            .resource_mut::<Assets<Image>>()
            .add(target_image(UVec2::splat(SIDE)));
        let camera = world.spawn((
            Camera3d::default(),
            Msaa::Off,
            RenderTarget::Image(image.into()),
            Transform::from_xyz(0.0, 0.0, 5.0),
            RenderLayers::none(),
        ));
        let camera = camera.id();
        let mesh = world.resource_mut::<Assets<Mesh>>().add(Cuboid::default());
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let own: Vec<_> = (0..EYE_PARTS)
            .map(|_| materials.add(Color::WHITE))
            .collect();
        for material in &own {
            world.spawn((
                Mesh3d(mesh.clone()),
                MeshMaterial3d(material.clone()),
                RenderLayers::layer(PLAIN_LAYER),
            ));
        }
        Self {
            camera,
            material: own[0].clone(),
        }
    }

    fn show(&self, headless: &mut Headless, shown: Shown) {
        let mut camera = headless.world().entity_mut(self.camera);
        if let Some(mut camera) = camera.get_mut::<Camera>() {
            camera.is_active = matches!(shown, Shown::PlainMeshes | Shown::PlainCamera);
        }
        camera.insert(match shown {
            Shown::PlainMeshes => RenderLayers::layer(PLAIN_LAYER),
            _ => RenderLayers::none(),
        });
    }

    /// Changes a material, as an eye that moves does.
    fn change(&self, headless: &mut Headless, frame: usize) {
        let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
        if let Some(mut material) = materials.get_mut(&self.material) {
            material.perceptual_roughness = 0.3 + 0.1 * (frame % 5) as f32;
        }
    }
}

/// How an eye is shown while it is measured.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    /// In a small panel.
    Drawn,
    /// Its camera is awake, and its parts are off the camera's layers.
    Undrawn,
    /// The same, with skin and lids as finely divided as in a large picture.
    FinestUndrawn,
    /// Not at all.
    Hidden,
    /// As many plain meshes in its place, one of whose materials changes.
    PlainMeshes,
    /// A camera with nothing before it in its place.
    PlainCamera,
}

impl Shown {
    const ALL: [Self; 6] = [
        Self::Drawn,
        Self::Undrawn,
        Self::FinestUndrawn,
        Self::Hidden,
        Self::PlainMeshes,
        Self::PlainCamera,
    ];

    /// Shows the eye so, or what stands in its place; `layers` are those of its parts.
    fn apply(self, headless: &mut Headless, layers: &RenderLayers, plain: &Plain) {
        let is_eye = matches!(self, Self::Drawn | Self::Undrawn | Self::FinestUndrawn);
        headless.show([is_eye, false]);
        plain.show(headless, self);
        swap_layers(headless, layers.clone());
        if self == Self::FinestUndrawn {
            // A large picture, whose size is known some frames later: an eye that nobody sees stays as finely
            // divided as it was.
            headless.resize(Which::Eye, UVec2::splat(LARGE_SIDE));
            for _ in 0..6 {
                headless.stand_still();
                headless.finish_frame();
            }
        }
        if matches!(self, Self::Undrawn | Self::FinestUndrawn) {
            swap_layers(headless, RenderLayers::none());
        }
        headless.resize(Which::Eye, UVec2::splat(SIDE));
    }
}

/// Milliseconds of frames in which an eye turns, and in which it looks at one place.
#[derive(Default)]
struct Times {
    turning: Vec<(f64, bool)>,
    still: Vec<(f64, bool)>,
}

impl Times {
    fn medians(&self) -> Result<[f64; 2], BenchError> {
        Ok([
            median_of(&self.turning, true)?,
            median_of(&self.still, false)?,
        ])
    }
}

/// Measures an eye, by itself, over `count` frames of each kind.
///
/// # Errors
/// Where no frame can be made.
pub fn eye(session: Session, count: usize) -> Result<EyeCost, BenchError> {
    let mut headless = Headless::new(session, [UVec2::splat(SIDE); 2], [true, false])?;
    let stopwatch = Stopwatch::put_into(&mut headless);
    let plain = Plain::spawn(&mut headless);
    let mut time_s = 1.0;
    let mut run = |headless: &mut Headless, shown: Shown, turning: bool, count: usize| {
        let mut place_deg = 12.0;
        frames(headless, &stopwatch, count, |headless, frame| {
            if turning && frame % TURN_EVERY == 0 {
                place_deg = -place_deg;
                look(headless, place_deg);
            }
            if shown == Shown::PlainMeshes {
                plain.change(headless, frame);
            }
            time_s += 1.0 / 60.0;
            headless.go_to(time_s);
        })
    };
    let layers = swap_layers(&mut headless, RenderLayers::none());
    let mut times: [Times; Shown::ALL.len()] = Default::default();
    // In turn, so that whatever else the machine does falls on all alike; the first round fills caches.
    for round in 0..=ROUNDS {
        for (shown, times) in Shown::ALL.into_iter().zip(&mut times) {
            shown.apply(&mut headless, &layers, &plain);
            run(&mut headless, shown, true, 2 * TURN_EVERY);
            let turning = run(&mut headless, shown, true, count / ROUNDS);
            look(&mut headless, 0.0);
            run(&mut headless, shown, false, 2 * TURN_EVERY);
            let still = run(&mut headless, shown, false, count / ROUNDS);
            if round > 0 {
                times.turning.extend(turning);
                times.still.extend(still);
            }
        }
    }
    let paused = |headless: &mut Headless, shown: Shown| {
        shown.apply(headless, &layers, &plain);
        let frames = frames(headless, &stopwatch, count, |headless, _| {
            headless.stand_still();
        });
        median_of(&frames, false)
    };
    let hidden_paused = paused(&mut headless, Shown::Hidden)?;
    paused(&mut headless, Shown::Drawn)?;
    let paused_ms = paused(&mut headless, Shown::Drawn)? - hidden_paused;
    let [drawn, undrawn, finest, hidden, meshes, camera] = &times;
    let [turning, still] = drawn.medians()?;
    let [turning_undrawn, still_undrawn] = undrawn.medians()?;
    let [turning_finest, _] = finest.medians()?;
    let [hidden_turning, hidden] = hidden.medians()?;
    let [_, plain_meshes] = meshes.medians()?;
    let [_, plain_camera] = camera.medians()?;
    Ok(EyeCost {
        nothing_shown_ms: hidden,
        turning_ms: turning - hidden_turning,
        still_ms: still - hidden,
        turning_undrawn_ms: turning_undrawn - hidden_turning,
        still_undrawn_ms: still_undrawn - hidden,
        turning_finest_undrawn_ms: turning_finest - hidden_turning,
        paused_ms,
        plain_meshes_ms: plain_meshes - hidden,
        plain_camera_ms: plain_camera - hidden,
    })
}
