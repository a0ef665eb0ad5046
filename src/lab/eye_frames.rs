//! What the picture of an eye costs by what is in it: how many lamps light it, how far away it is.
//!
//! Leaves: rows of milliseconds a frame of an eye alone whose lids and gaze move, all drawn in turn, so that whatever else the
//! machine does falls on all alike.

use super::bench::{BenchError, time_frames};
use super::headless::Headless;
use super::render::median;
use crate::appearance::{EyeModel, EyeOrbit};
use crate::stage::{PanelLight, Session};
use bevy::camera::visibility::RenderLayers;
use bevy::math::UVec2;
use bevy::prelude::*;
use serde::Serialize;

/// Side of the picture, pixels.
const SIDE: u32 = 320;
/// In how many turns the ways are measured.
const ROUNDS: usize = 4;
/// Illuminance of one of the lamps, lx.
const LAMP_LUX: f32 = 400.0;

/// One way of showing an eye.
#[derive(Clone, Debug, Serialize)]
pub struct EyeFrames {
    /// What is shown.
    pub name: &'static str,
    /// Lamps that light it; `null`: those of the studio's window.
    pub lamps: Option<usize>,
    /// Distance of the camera from the cornea, mm.
    pub distance_mm: f32,
    /// Median of a frame.
    pub ms_median: f64,
}

/// Lights an eye by so many suns, and nothing else.
fn light(headless: &mut Headless, lamps: usize) {
    let world = headless.world();
    let layers = world
        .query_filtered::<&RenderLayers, With<EyeModel>>()
        .iter(world)
        .next()
        .cloned()
        .unwrap_or_default();
    let own = world
        .query_filtered::<Entity, Or<(With<DirectionalLight>, With<PointLight>, With<SpotLight>)>>()
        .iter(world)
        .collect::<Vec<_>>();
    for entity in own {
        world.entity_mut(entity).insert(Visibility::Hidden);
    }
    for lamp in 0..lamps {
        let aside = (lamp as f32 - 1.5) * 0.4;
        let towards = Vec3::new(aside, 0.5, 1.0);
        world.spawn((
            DirectionalLight {
                illuminance: LAMP_LUX,
                shadow_maps_enabled: false,
                ..default()
            },
            Transform::from_translation(towards).looking_at(Vec3::ZERO, Vec3::Y),
            layers.clone(),
        ));
    }
}

/// Measures them, `count` frames of each.
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
    ];
    let mut running = Vec::new();
    for (name, lamps, distance_mm) in ways {
        let session = Session {
            light: if lamps.is_some() {
                PanelLight::Scene
            } else {
                PanelLight::default()
            },
            ..session()?
        };
        let mut headless = Headless::new(session, [UVec2::splat(SIDE); 2], [true, false])?;
        headless.set_orbit(EyeOrbit {
            distance_mm,
            ..default()
        });
        if let Some(lamps) = lamps {
            light(&mut headless, lamps);
        }
        time_frames(&mut headless, 0.0, 8);
        running.push((
            EyeFrames {
                name,
                lamps,
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
