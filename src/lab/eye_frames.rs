//! What the picture of an eye costs, by what is in it: lamps, distance, and by how its iris is computed.
//!
//! Leaves: rows of milliseconds a frame of an eye alone, all drawn in turn, so that whatever else the machine does falls on all
//! alike; and what a fixed count of steps costs and changes.

use super::approximations::{ErrorRow, Task};
use super::bench::{BenchError, time_frames};
use super::headless::{Headless, Which};
use super::render::median;
use crate::appearance::surroundings::Surroundings;
use crate::appearance::{EyeModel, EyeOrbit, EyeQuality, EyeShading, EyeSurroundings, Lamp};
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::stage::{PanelLight, Session, SessionCommand};
use bevy::asset::Handle;
use bevy::image::Image;
use bevy::math::{DVec3, UVec2};
use bevy::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// Side of the picture, pixels.
const SIDE: u32 = 320;
/// In how many turns the ways are measured.
const ROUNDS: usize = 4;
/// The nearest that a camera stands, mm: there the iris fills most of the picture.
const NEAREST_MM: f32 = 35.0;
/// Half of the side of the square in the middle of that picture that is compared, as a share of its half side: from the front it holds iris
/// and pupil alone.
const IRIS_SHARE: f64 = 0.4;

/// One way of showing an eye.
#[derive(Clone, Debug, Serialize)]
pub struct EyeFrames {
    /// What is shown.
    pub name: &'static str,
    /// Far lamps that light it, beside an even sky; `null`: the light of the studio's window.
    pub lamps: Option<usize>,
    /// Distance of the camera from the cornea, mm.
    pub distance_mm: f32,
    /// Median of a frame.
    pub ms_median: f64,
}

/// What the ways of computing an iris cost, and how far they are from a fixed count of steps everywhere.
#[derive(Clone, Debug, Serialize)]
pub struct FixedSteps {
    /// From how far aside it is seen, degrees.
    pub angle_deg: f32,
    /// A frame by [`EyeShading::Fast`].
    pub fast_ms: f64,
    /// By [`EyeShading::Full`].
    pub full_ms: f64,
    /// By [`EyeShading::FixedSteps`].
    pub fixed_ms: f64,
    /// Root mean square difference of the radiances of iris and pupil between the first and the last, of their mean.
    pub fast_rms_share: f64,
    /// Between the second and the last.
    pub full_rms_share: f64,
    /// All three as rows of error against time.
    #[serde(skip)]
    pub rows: Vec<ErrorRow>,
}

impl FixedSteps {
    /// How many times as long as the full one the fixed steps take.
    pub fn slower(&self) -> f64 {
        self.fixed_ms / self.full_ms
    }
}

/// Lights an eye by an even sky and so many lamps.
fn light(headless: &mut Headless, lamps: usize) {
    let mut around = Surroundings::even(Vec3::splat(0.2));
    around.lamps = (0..lamps)
        .map(|lamp| {
            let aside = (lamp as f32 - 0.5 * (lamps as f32 - 1.0)) * 0.3;
            Lamp {
                direction: Vec3::new(aside, 0.4, -1.0).normalize(),
                color: Vec3::splat(0.5 / lamps as f32),
                ..default()
            }
        })
        .collect();
    let around = EyeSurroundings(Arc::new(around));
    let world = headless.world();
    let mut models = world.query_filtered::<Entity, With<EyeModel>>();
    let models: Vec<Entity> = models.iter(world).collect();
    for model in models {
        world.entity_mut(model).insert(around.clone());
    }
}

/// Times what runs in turns, `count` frames of each in all, and gives their medians.
fn in_turns(running: &mut [Headless], count: usize) -> Vec<f64> {
    let each = count.div_ceil(ROUNDS);
    let mut times = vec![Vec::new(); running.len()];
    for headless in running.iter_mut() {
        time_frames(headless, 0.0, 8);
    }
    for round in 0..ROUNDS {
        for (headless, times) in running.iter_mut().zip(&mut times) {
            let from_s = 1.0 + (round * each) as f64 / 60.0;
            times.extend(time_frames(headless, from_s, each));
        }
    }
    times.iter_mut().map(|times| median(times)).collect()
}

/// Measures an eye whose lids and gaze move, by lamps and by distance, `count` frames of each, one sample a pixel.
///
/// # Errors
/// Where there is no device.
pub fn cases(
    session: impl Fn() -> Result<Session, BenchError>,
    count: usize,
) -> Result<Vec<EyeFrames>, BenchError> {
    let ways = [
        ("two lamps", Some(2), 93.0),
        ("four lamps", Some(4), 93.0),
        ("eight lamps", Some(8), 93.0),
        ("macro, 45 mm", None, 45.0),
        ("face, 400 mm", None, 400.0),
        ("face, 1 m", None, 1000.0),
    ];
    let mut running = Vec::new();
    for (_, lamps, distance_mm) in ways {
        let mut session = session()?;
        if lamps.is_some() {
            session.light = PanelLight::Scene;
        }
        let mut headless = Headless::new(session, [UVec2::splat(SIDE); 2], [true, false])?;
        headless.set_quality(EyeQuality::PLAIN);
        headless.set_orbit(EyeOrbit {
            distance_mm,
            ..default()
        });
        if let Some(lamps) = lamps {
            light(&mut headless, lamps);
        }
        running.push(headless);
    }
    let times = in_turns(&mut running, count);
    for (headless, (_, lamps, _)) in running.iter_mut().zip(ways) {
        let world = headless.world();
        let mut found = world.query::<&EyeSurroundings>();
        let lit = found
            .iter(world)
            .all(|own| own.0.lamps.len() == lamps.unwrap_or(0));
        if lamps.is_some() && !lit {
            return Err(BenchError::OtherLight);
        }
    }
    let ways = ways.into_iter().zip(times);
    Ok(ways
        .map(|((name, lamps, distance_mm), ms_median)| EyeFrames {
            name,
            lamps,
            distance_mm,
            ms_median,
        })
        .collect())
}

/// All of them as one task: whole pictures, from every side.
pub fn task(steps: &[FixedSteps]) -> Task {
    Task {
        name: "iris-pictures".to_owned(),
        title: "pictures of an iris, from the front and from aside".to_owned(),
        call: format!("a frame of {SIDE} by {SIDE} pixels that the iris fills"),
        domain: "a brown iris in a window's light, at 0, 30 and 60 degrees".to_owned(),
        reference: "64 steps and 64 segments everywhere".to_owned(),
        unit: "share of the mean radiance".to_owned(),
        rows: steps.iter().flat_map(|own| own.rows.clone()).collect(),
    }
}

/// Milliseconds from a change of the border layer's melanin, as a slider makes one, to the picture with it: the median of `count` of
/// them, one after another.
///
/// # Errors
/// Without a device, or where a picture does not change.
pub fn pigment_change(mut session: Session, count: usize) -> Result<f64, BenchError> {
    let mut file = session.patient.clone();
    file.border_layer_melanin_fraction = Some(0.3);
    session.patient = file.clone();
    let mut headless = Headless::new(session, [UVec2::splat(SIDE); 2], [true, false])?;
    headless.set_quality(EyeQuality::PLAIN);
    headless.warm_up()?;
    let mut times = Vec::new();
    let mut before = headless.panel(Which::Eye)?;
    // The first grows the stroma that the next ones lay their pigment on.
    for change in 0..=count {
        file.border_layer_melanin_fraction = Some(0.3 + 0.02 * (change % 9 + 1) as f64);
        let began = Instant::now();
        headless.command(SessionCommand::Change(Box::new(file.clone())));
        headless.stand_still();
        headless.finish_frame();
        let took = began.elapsed().as_secs_f64() * 1e3;
        let after = headless.panel(Which::Eye)?;
        if after == before {
            return Err(BenchError::Unchanged);
        }
        before = after;
        if change > 0 {
            times.push(took);
        }
    }
    Ok(median(&mut times))
}

/// Differences of two pictures' radiances in the middle, each the root of the mean square of its channels, of the second one's mean.
fn differences(picture: &[DVec3], truth: &[DVec3]) -> Vec<f64> {
    let is_middle = |i: usize| {
        let place = [i % SIDE as usize, i / SIDE as usize];
        place
            .iter()
            .all(|&p| ((p as f64 + 0.5) / (0.5 * f64::from(SIDE)) - 1.0).abs() < IRIS_SHARE)
    };
    let both = || {
        let all = picture.iter().zip(truth).enumerate();
        all.filter(|(i, _)| is_middle(*i)).map(|(_, both)| both)
    };
    let sum: f64 = both().map(|(_, b)| b.element_sum() / 3.0).sum();
    let mean = sum / both().count() as f64;
    both()
        .map(|(a, b)| (*a - *b).length() / 3.0_f64.sqrt() / mean)
        .collect()
}

/// Measures an iris that fills most of the picture, in each way, seen from this far aside (°).
///
/// # Errors
/// Where there is no device.
pub fn fixed_steps(
    session: impl Fn() -> Result<Session, BenchError>,
    azimuth_deg: f32,
    count: usize,
) -> Result<FixedSteps, BenchError> {
    let prepared = |shading| -> Result<(Headless, Handle<Image>), BenchError> {
        let (mut headless, image) = Headless::with_radiance(session()?, UVec2::splat(SIDE))?;
        headless.set_orbit(EyeOrbit {
            distance_mm: NEAREST_MM,
            azimuth_deg,
            ..default()
        });
        headless.set_quality(EyeQuality {
            shading,
            ..EyeQuality::PLAIN
        });
        headless
            .world()
            .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
                azimuth_rad: 0.0,
                elevation_rad: 0.0,
                distance_m: 1.0,
            }));
        Ok((headless, image))
    };
    let (mut running, mut images) = (Vec::new(), Vec::new());
    for shading in [EyeShading::Fast, EyeShading::Full, EyeShading::FixedSteps] {
        let (headless, image) = prepared(shading)?;
        running.push(headless);
        images.push(image);
    }
    let times = in_turns(&mut running, count);
    let drawn = running.iter_mut().zip(&images);
    let drawn = drawn.map(|(headless, image)| headless.radiances(image));
    let drawn = drawn.collect::<Result<Vec<_>, _>>()?;
    let setting = format!("{azimuth_deg}°");
    let row = |at: usize, method: &str| {
        let errors = differences(&drawn[at], &drawn[2]);
        ErrorRow::new(method, &setting, 0, times[at] * 1e6, errors)
    };
    let rows = vec![row(0, "fast"), row(1, "full"), row(2, "64 steps")];
    Ok(FixedSteps {
        angle_deg: azimuth_deg,
        fast_ms: times[0],
        full_ms: times[1],
        fixed_ms: times[2],
        fast_rms_share: rows[0].err_rms,
        full_rms_share: rows[1].err_rms,
        rows,
    })
}
