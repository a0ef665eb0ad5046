//! What the picture of an eye costs by how far away it is.
//!
//! Leaves: rows of milliseconds a frame of an eye alone whose lids and gaze move, all drawn in turn, so that whatever else the
//! machine does falls on all alike.

use super::bench::{BenchError, time_frames};
use super::headless::Headless;
use super::render::median;
use crate::appearance::EyeOrbit;
use crate::stage::Session;
use bevy::math::UVec2;
use bevy::prelude::*;
use serde::Serialize;

/// Side of the picture, pixels.
const SIDE: u32 = 320;
/// In how many turns the ways are measured.
const ROUNDS: usize = 4;
/// One way of showing an eye.
#[derive(Clone, Debug, Serialize)]
pub struct EyeFrames {
    /// What is shown.
    pub name: &'static str,
    /// Distance of the camera from the cornea, mm.
    pub distance_mm: f32,
    /// Median of a frame.
    pub ms_median: f64,
}

/// Measures them, `count` frames of each.
///
/// # Errors
/// Where there is no device.
pub fn cases(
    session: impl Fn() -> Result<Session, BenchError>,
    count: usize,
) -> Result<Vec<EyeFrames>, BenchError> {
    let ways = [("macro, 45 mm", 45.0), ("face, 400 mm", 400.0)];
    let mut running = Vec::new();
    for (name, distance_mm) in ways {
        let mut headless = Headless::new(session()?, [UVec2::splat(SIDE); 2], [true, false])?;
        headless.set_orbit(EyeOrbit {
            distance_mm,
            ..default()
        });
        time_frames(&mut headless, 0.0, 8);
        running.push((
            EyeFrames {
                name,
                distance_mm,
                ms_median: 0.0,
            },
            headless,
            Vec::new(),
        ));
    }
    let each = count.div_ceil(ROUNDS);
    for round in 0..ROUNDS {
        for (_, headless, times) in &mut running {
            times.extend(time_frames(
                headless,
                1.0 + (round * each) as f64 / 60.0,
                each,
            ));
        }
    }
    Ok(running
        .into_iter()
        .map(|(case, _, mut times)| EyeFrames {
            ms_median: median(&mut times),
            ..case
        })
        .collect())
}
