//! What frames of people and of views cost.
//!
//! Leaves: [`CrowdCost`] of people that nobody draws; [`ViewsCost`] of cameras that see one still scene.

use super::bench::{BenchError, time_frames};
use super::headless::{Headless, plugins};
use super::render::median;
use crate::anatomy::Gaze;
use crate::frame::Panel;
use crate::frame::panel::target_image;
use crate::motion::attention::Candidate;
use crate::motion::{Candidates, GazeController};
use crate::patients::load_patient;
use crate::percept::SeesAs;
use crate::plugins::OculariumPlugins;
use crate::stage::{HeadPath, Session};
use bevy::camera::{Hdr, RenderTarget};
use bevy::math::UVec2;
use bevy::prelude::*;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Side of the panels, pixels: small, so that what draws is out of the way.
pub(super) const SIDE: u32 = 64;
/// Places among which a person of a crowd chooses, about what a view tells of.
const PLACES: usize = 600;
/// Frames in which everybody looks elsewhere at least once.
const MOVING_FRAMES: usize = 120;

/// A frame of people that nobody draws.
#[derive(Clone, Debug, Serialize)]
pub struct CrowdCost {
    /// How many, two eyes each.
    pub people: usize,
    /// Milliseconds of the processor, median.
    pub ms_median: f64,
    /// Least that anybody's eye has turned since, °: nobody stands still.
    pub turned_deg: f64,
}

/// A frame of a view whose head walks, so that each has a capture.
#[derive(Clone, Debug, Serialize)]
pub struct WalkCost {
    /// Milliseconds until the device has finished, median.
    pub ms_median: f64,
    /// The same at rest.
    pub ms_median_at_rest: f64,
    /// Captures in a frame of the walk.
    pub captures: f64,
}

/// Measures a view of `side` pixels along each side while and after the head goes the way that comes with the program, ten frames a second.
///
/// # Errors
/// Where no frame can be made.
pub fn walking(session: Session, side: u32, count: usize) -> Result<WalkCost, BenchError> {
    let sizes = [UVec2::splat(side); 2];
    let path = HeadPath::load(Path::new("walk"))?;
    let mut headless = Headless::prepared(session, sizes, [false, true], |world, stage| {
        world.entity_mut(stage.view).insert(path);
    })?;
    time_frames(&mut headless, 0.0, 8);
    let before = headless.work();
    // It goes from 0.4 to 3.8 s.
    let mut times: Vec<f64> = (5..35)
        .map(|tenth| {
            let from = Instant::now();
            headless.go_to(0.1 * f64::from(tenth));
            headless.finish_frame();
            from.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    let frames = times.len();
    let captures = headless.work().since(before).view_captures as f64 / frames as f64;
    let mut at_rest = time_frames(&mut headless, 5.0, count);
    Ok(WalkCost {
        ms_median: median(&mut times),
        ms_median_at_rest: median(&mut at_rest),
        captures,
    })
}

/// A frame of cameras that see as somebody, before one still scene.
#[derive(Clone, Debug, Serialize)]
pub struct ViewsCost {
    /// How many cameras.
    pub cameras: usize,
    /// Milliseconds until the device has finished, median.
    pub ms_median: f64,
    /// Pictures presented in a frame.
    pub presents: f64,
    /// Captures in a frame.
    pub captures: f64,
}

/// Measures `people` that nobody draws: their eyes move, their pupils and lids too.
///
/// # Errors
/// Where no frame can be made.
pub fn crowd(people: usize, count: usize) -> Result<CrowdCost, BenchError> {
    let file = load_patient("healthy-brown")?;
    let mut app = App::new();
    app.add_plugins((plugins(), OculariumPlugins));
    // Everybody chooses for herself where to look, among as many places as a view tells of at most.
    let place = |k: usize| {
        let share = |n: usize| (k * n % 97) as f64 / 97.0 - 0.5;
        Candidate {
            azimuth_rad: 0.6 * share(31),
            elevation_rad: 0.4 * share(57),
            score: 20.0 + (k % 50) as f64,
            distance_m: 1.0 + (k % 5) as f64,
        }
    };
    let candidates = Candidates {
        list: (0..PLACES).map(place).collect(),
        ahead_distance_m: 3.0,
    };
    for seed in 0..people {
        app.world_mut().spawn((
            file.clone(),
            GazeController::with_seed(seed as u64 + 1),
            candidates.clone(),
        ));
    }
    let mut headless = Headless::of(app)?;
    let gazes = |headless: &mut Headless| -> Vec<(Entity, f64)> {
        let world = headless.world();
        let mut gazes = world.query::<(Entity, &Gaze)>();
        let all = gazes.iter(world);
        all.map(|(eye, gaze)| (eye, gaze.azimuth_rad)).collect()
    };
    // The first second fills caches.
    time_frames(&mut headless, 1.0, 60);
    let before = gazes(&mut headless);
    let mut times = time_frames(&mut headless, 2.0, count.max(MOVING_FRAMES));
    let turned_deg = gazes(&mut headless)
        .into_iter()
        .zip(before)
        .map(|(now, then)| (now.1 - then.1).abs().to_degrees())
        .fold(f64::INFINITY, f64::min);
    if turned_deg < 1e-6 {
        return Err(BenchError::NoSuchFrame(true));
    }
    Ok(CrowdCost {
        people,
        turned_deg,
        ms_median: median(&mut times),
    })
}

/// Measures `cameras` that see as one person does, before a wall that stands still.
///
/// # Errors
/// Where no frame can be made.
pub fn views(cameras: usize, count: usize) -> Result<ViewsCost, BenchError> {
    let file = load_patient("healthy-brown")?;
    let mut app = App::new();
    app.add_plugins((plugins(), OculariumPlugins));
    let world = app.world_mut();
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(9.0, 9.0, 0.1));
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(Color::srgb(0.7, 0.5, 0.4));
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 0.0, -3.0),
    ));
    world.spawn((
        DirectionalLight::default(),
        Transform::default().looking_to(Vec3::new(0.3, -0.5, -1.0), Vec3::Y),
    ));
    let somebody = world.spawn(file).id();
    let size = UVec2::splat(4 * SIDE);
    for _ in 0..cameras {
        let image = world
            .resource_mut::<Assets<Image>>()
            .add(target_image(size));
        world.spawn((
            Camera3d::default(),
            Hdr,
            RenderTarget::Image(image.clone().into()),
            Panel {
                visible: true,
                size,
                image,
            },
            SeesAs(somebody),
        ));
    }
    let mut headless = Headless::of(app)?;
    time_frames(&mut headless, 0.0, 20);
    let before = headless.work();
    let mut times = time_frames(&mut headless, 1.0, count);
    let work = headless.work().since(before);
    Ok(ViewsCost {
        cameras,
        ms_median: median(&mut times),
        presents: work.view_passes as f64 / count as f64,
        captures: work.view_captures as f64 / count as f64,
    })
}
