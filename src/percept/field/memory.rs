//! The memory of what was seen sharply, as a person has it: how fast it fades, and its clock.

use super::super::gpu_data::FORGET;
use super::sharpness_field::SharpnessClock;
use crate::anatomy::Eyelids;
use crate::frame::SimulationClock;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The memory of what was seen sharply (Nießner 2013, section 4). What is remembered of a place lies
/// with the camera that sees it; here is how it fades.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component)]
pub struct SharpnessField {
    /// Starving rate r, 1/s: the blur of an unseen place grows as e^(r t).
    /// 1–2 % a step at 30 Hz is 0.3–0.6.
    pub starve_rate_per_s: f64,
    /// Edge of a voxel, m.
    pub voxel_m: f64,
    /// Largest blur that is shown, as a visual angle in radians.
    pub blur_cap_rad: f64,
    #[reflect(ignore)]
    clock: SharpnessClock,
    clock_s: f64,
    blinks: u64,
    /// What has to be taken off every key in this frame.
    rebase_steps: u32,
    /// Which memory this is: what was remembered under another number is forgotten.
    lifetime: u64,
}

impl Default for SharpnessField {
    fn default() -> Self {
        Self::new(0.45, 0.01, 2f64.to_radians())
    }
}

impl SharpnessField {
    /// A memory in which nothing is yet: starving rate (1/s), edge of a voxel (m), largest blur (rad).
    pub fn new(starve_rate_per_s: f64, voxel_m: f64, blur_cap_rad: f64) -> Self {
        static LIFETIMES: AtomicU64 = AtomicU64::new(0);
        Self {
            starve_rate_per_s,
            voxel_m,
            blur_cap_rad,
            clock: SharpnessClock::default(),
            clock_s: 0.0,
            blinks: 0,
            rebase_steps: FORGET,
            lifetime: LIFETIMES.fetch_add(1, Ordering::Relaxed) + 1,
        }
    }

    /// Does it fade, and is it divided, like this one?
    pub fn fades_like(&self, other: &Self) -> bool {
        (self.starve_rate_per_s, self.voxel_m, self.blur_cap_rad)
            == (other.starve_rate_per_s, other.voxel_m, other.blur_cap_rad)
    }

    /// Forgets everything and begins at time 0.
    pub fn restart(&mut self) {
        *self = Self::new(self.starve_rate_per_s, self.voxel_m, self.blur_cap_rad);
    }

    /// Blink epoch and starvation now.
    pub fn clock(&self) -> &SharpnessClock {
        &self.clock
    }

    /// What has to be taken off every key in this frame, or [`FORGET`].
    pub(in crate::percept) fn rebase_steps(&self) -> u32 {
        self.rebase_steps
    }

    /// Which memory this is.
    pub(in crate::percept) fn lifetime(&self) -> u64 {
        self.lifetime
    }

    /// Lets time pass up to `time_s`, with this many blinks so far.
    fn advance(&mut self, time_s: f64, blinks: u64) {
        self.rebase_steps = FORGET;
        let passed = (time_s - self.clock_s).max(0.0);
        self.clock_s = time_s;
        if let Some(rebase) = self.clock.advance(passed, self.starve_rate_per_s) {
            self.rebase_steps = rebase.steps;
        }
        while self.blinks < blinks {
            self.blinks += 1;
            if self.clock.blink().is_some() {
                self.restart_keys();
            }
        }
        self.blinks = self.blinks.min(blinks);
    }

    /// Every key is forgotten, and the clock goes on.
    fn restart_keys(&mut self) {
        self.lifetime = Self::new(0.0, 0.0, 0.0).lifetime;
    }
}

/// Lets the memory of everybody fade.
pub(in crate::percept) fn remember(
    clock: Res<SimulationClock>,
    mut fields: Query<(&mut SharpnessField, &Eyelids)>,
) {
    for (mut field, lids) in &mut fields {
        // What passes in every frame is no change of how it fades.
        field
            .bypass_change_detection()
            .advance(clock.time_s, lids.blink_epoch);
    }
}
