//! The one clock that both panels follow.
//!
//! Enters: real time, or a time set from outside (headless, replay). Leaves:
//! the simulation's time in seconds and whether it moved in this frame.

use bevy::prelude::*;

/// Largest step of real time that one frame may take, s: a stalled window does not jump.
const LARGEST_FRAME_S: f64 = 0.25;

/// Who moves the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Real time, times the speed.
    Realtime,
    /// Somebody sets the time; the clock goes there in the next frame.
    Manual(f64),
}

/// The simulation's clock.
#[derive(Resource, Clone, Debug)]
pub struct SimulationClock {
    /// Time, s, from 0.
    pub time_s: f64,
    /// Stopped by the user?
    pub paused: bool,
    /// Seconds of simulation in a second of real time, 0.05 to 4.
    pub speed: f64,
    /// Who moves it.
    pub drive: Drive,
    /// Length of a single step, s.
    pub step_s: f64,
    /// Single steps asked for.
    pub steps: u32,
    /// True when the view's candidates have arrived and every pipeline is built: time starts then.
    pub ready: bool,
    /// Did it move in this frame?
    pub moved: bool,
}

impl Default for SimulationClock {
    fn default() -> Self {
        Self {
            time_s: 0.0,
            paused: false,
            speed: 1.0,
            drive: Drive::Realtime,
            step_s: 1.0 / 60.0,
            steps: 0,
            ready: false,
            moved: false,
        }
    }
}

/// Moves the clock; runs first in a frame.
pub fn advance_clock(mut clock: ResMut<SimulationClock>, real: Res<Time<Real>>) {
    let before = clock.time_s;
    if clock.ready {
        match clock.drive {
            Drive::Manual(time_s) => clock.time_s = time_s.max(0.0),
            Drive::Realtime if clock.paused => {
                let steps = std::mem::take(&mut clock.steps);
                clock.time_s += f64::from(steps) * clock.step_s;
            }
            Drive::Realtime => {
                clock.time_s += real.delta_secs_f64().min(LARGEST_FRAME_S) * clock.speed;
            }
        }
    }
    clock.moved = clock.time_s != before;
}
