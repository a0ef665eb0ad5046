//! The oculomotor engine: one eye's pose as a function of time.
//!
//! What enters: settings with a seed, a list of candidates, a visual field and commands, each with
//! its time. What leaves: [`OculomotorState`] at any later time. [`Oculomotor::advance_to`]
//! processes the events up to a time in their order and at their exact times (a choice, the start
//! and the end of a saccade, a blink, a step of the lens or the pupil); between events every
//! quantity is a closed curve. So the state at t depends on settings, seed, candidates and
//! commands, and not on the frames in between.
//!
//! A fixation lasts an ex-Gaussian time. Its successor is chosen one saccadic latency before the
//! eye leaves, or as soon as the eye has set out for the present one when the fixation is too
//! short for that (saccades are prepared in parallel). The lens starts its own latency after the
//! choice, never before the eye leaves.

mod commands;
mod curve;
mod queue;
mod state;

use super::accommodation::{Approach, steady_response_d, step_time_constant_s};
use super::blink::Blink;
use super::pupil::{
    CONSTRICTION_TIME_CONSTANT_S, Hippus, PupilMode, steady_diameter_mm, time_constant_s,
};
use super::random;
use super::settings::{
    FixationTiming, MotionError, NIESSNER_LENS_TIME_CONSTANT_S, OculomotorSettings,
};
use crate::anatomy::PUPIL_RANGE_MM;
use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::visual_field::VisualField;
use crate::motion::attention::{self, Visit};
use curve::GazeCurve;
use queue::{Event, EventQueue, Target};

pub use crate::motion::attention::Candidate;
pub use commands::GazeCommand;
pub use state::{FixationRecord, OculomotorState};

/// How many fixations [`Oculomotor::fixations`] remembers.
pub const FIXATIONS_KEPT: usize = 64;
/// Shortest time between the end of a blink and the next spontaneous one, s.
const BLINK_GAP_S: f64 = 0.1;
/// A candidate this near to straight ahead sets the distance of the first gaze, rad (10°).
const AHEAD_RAD: f64 = 0.174_533;
/// Time constant of vergence, s: symmetric steps of 1 to 4° are done in about 0.6 s (Rashbass and
/// Westheimer 1961).
const VERGENCE_TIME_CONSTANT_S: f64 = 0.2;
/// Depth of a partial blink.
const PARTIAL_DEPTH: (f64, f64) = (0.4, 0.8);

/// What steers the gaze.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Auto,
    Fixed,
    Follow(Target),
}

/// The engine of one eye.
#[derive(Clone, Debug)]
pub struct Oculomotor {
    settings: OculomotorSettings,
    time_s: f64,
    /// Whether anything has happened yet; before that, commands and candidates set the start.
    started: bool,
    queue: EventQueue,
    mode: Mode,
    candidates: Vec<Candidate>,
    /// Distance of what lies straight ahead, m.
    ahead_distance_m: f64,
    field: Option<VisualField>,
    curve: GazeCurve,
    fixation: Target,
    fixation_index: u64,
    /// When the last saccade started and when the eye landed or will land, s.
    departed_s: f64,
    landed_s: f64,
    records: Vec<FixationRecord>,
    chosen_once: bool,
    decisions: u64,
    durations: u64,
    blink_draws: u64,
    blink: Option<Blink>,
    closures: u64,
    lens: Approach,
    vergence: Approach,
    lens_distance_m: f64,
    pupil: Approach,
    unrest_mm: Approach,
    hippus: Hippus,
}

impl Oculomotor {
    /// An eye that looks straight ahead at time 0, settled for the distance there.
    ///
    /// # Errors
    /// [`MotionError`] when a setting is out of range.
    pub fn new(settings: OculomotorSettings) -> Result<Self, MotionError> {
        settings.check()?;
        let ahead = Target {
            gaze: GazeAngles::default(),
            distance_m: f64::INFINITY,
        };
        let mut engine = Self {
            hippus: Hippus::new(settings.seed),
            settings,
            time_s: 0.0,
            started: false,
            queue: EventQueue::default(),
            mode: Mode::Auto,
            candidates: Vec::new(),
            ahead_distance_m: f64::INFINITY,
            field: None,
            curve: GazeCurve::Hold(ahead.gaze),
            fixation: ahead,
            fixation_index: 0,
            departed_s: 0.0,
            landed_s: 0.0,
            records: Vec::new(),
            chosen_once: false,
            decisions: 0,
            durations: 0,
            blink_draws: 0,
            blink: None,
            closures: 0,
            lens: Approach::rest(0.0),
            vergence: Approach::rest(0.0),
            lens_distance_m: f64::INFINITY,
            pupil: Approach::rest(4.0),
            unrest_mm: Approach::rest(0.0),
        };
        engine.settle_on(ahead);
        Ok(engine)
    }

    /// The time up to which events have been processed, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The settings in use.
    #[must_use]
    pub fn settings(&self) -> &OculomotorSettings {
        &self.settings
    }

    /// The recent fixations, oldest first, the current one last.
    #[must_use]
    pub fn fixations(&self) -> &[FixationRecord] {
        &self.records
    }

    /// Processes everything up to `t` in s. An earlier time, and what is not finite, does nothing.
    pub fn advance_to(&mut self, t: f64) {
        if !(t.is_finite() && t >= self.time_s) {
            return;
        }
        if !self.started {
            self.start();
        }
        while let Some((time_s, event)) = self.queue.pop_due(t) {
            // Events entered late happen now: the past stays as it was.
            self.time_s = time_s.max(self.time_s);
            self.process(event);
        }
        self.time_s = t;
    }

    /// The pose at [`Self::time_s`].
    #[must_use]
    pub fn state(&self) -> OculomotorState {
        let t = self.time_s;
        let (gaze, velocity) = self.curve.at(t);
        let lid_aperture = self.blink.map_or(1.0, |blink| blink.aperture(t));
        let closed_now = self
            .blink
            .is_some_and(|blink| blink.is_full() && t >= blink.closed_from_s());
        let pupil_mm = self.pupil.at(t) + self.unrest_mm.at(t) * self.hippus.at(t);
        OculomotorState {
            time_s: t,
            gaze_azimuth_rad: gaze.azimuth_rad,
            gaze_elevation_rad: gaze.elevation_rad,
            gaze_torsion_rad: gaze.listing_torsion_rad(),
            gaze_velocity_rad_s: velocity,
            in_saccade: self.curve.in_saccade(t),
            fixation_azimuth_rad: self.fixation.gaze.azimuth_rad,
            fixation_elevation_rad: self.fixation.gaze.elevation_rad,
            fixation_distance_m: self.fixation.distance_m,
            vergence_per_m: self.vergence.at(t),
            fixation_index: self.fixation_index,
            accommodation_d: self.lens.at(t),
            pupil_mm: pupil_mm.clamp(PUPIL_RANGE_MM.0, PUPIL_RANGE_MM.1),
            lid_aperture,
            blinking: lid_aperture < 1.0,
            blink_epoch: self.closures + u64::from(closed_now),
        }
    }

    /// The first event: gaze, lens and pupil stand settled, and the first choices are drawn.
    fn start(&mut self) {
        self.started = true;
        self.records.push(FixationRecord {
            index: self.fixation_index,
            azimuth_rad: self.fixation.gaze.azimuth_rad,
            elevation_rad: self.fixation.gaze.elevation_rad,
            distance_m: self.fixation.distance_m,
            start_s: 0.0,
            end_s: f64::INFINITY,
        });
        self.schedule_blink(0.0);
        if self.mode == Mode::Auto {
            self.schedule_choice(0.0);
        }
    }

    fn process(&mut self, event: Event) {
        match event {
            Event::Command(command) => self.apply_command(command),
            Event::Pursue(target) => self.pursue(target),
            Event::VoluntaryBlink => self.begin_blink(Blink::voluntary(self.time_s)),
            Event::SpontaneousBlink => self.blink_spontaneously(),
            Event::Decide { onset_s } => self.decide(onset_s),
            Event::Depart { target, decided_s } => self.depart(target, decided_s),
            Event::Land => self.land(),
            Event::Accommodate { distance_m } => self.accommodate(distance_m),
            Event::Light => self.turn_pupil(),
        }
    }

    /// Whether the eye is between departure and landing.
    fn in_flight(&self) -> bool {
        self.landed_s > self.time_s
    }

    /// Draws how long the eye rests from `from_s` on and schedules the choice of what follows.
    fn schedule_choice(&mut self, from_s: f64) {
        if !self.settings.saccades || self.mode != Mode::Auto {
            return;
        }
        let mut rng = random::stream(self.settings.seed, "fixation", self.durations);
        self.durations += 1;
        let duration = self
            .settings
            .fixation_timing
            .draw_duration_s(self.settings.refractory_s, &mut rng);
        let onset_s = from_s + duration;
        let choice_s = (onset_s - self.settings.command_latency_s()).max(self.time_s);
        self.queue.push(choice_s, Event::Decide { onset_s });
    }

    fn decide(&mut self, onset_s: f64) {
        let number = self.decisions;
        self.decisions += 1;
        let rng = &mut random::stream(self.settings.seed, "choice", number);
        let (current, field) = (self.fixation.gaze, self.field.as_ref());
        let settings = self.settings.attention();
        let chosen = if self.chosen_once {
            let history = self.history();
            attention::choose_next(&self.candidates, current, &history, field, &settings, rng)
        } else {
            attention::choose_first(&self.candidates, current, field, &settings, rng)
        };
        let Some(candidate) = chosen.and_then(|index| self.candidates.get(index)) else {
            // Nothing to see: the previous feature serves for another step.
            self.schedule_choice(onset_s);
            return;
        };
        self.chosen_once = true;
        let target = Target {
            gaze: GazeAngles::new(candidate.azimuth_rad, candidate.elevation_rad),
            distance_m: candidate.distance_m,
        };
        let decided_s = self.time_s;
        self.queue
            .push(onset_s, Event::Depart { target, decided_s });
    }

    /// The places that were left, with the time since. The current fixation is not among them.
    fn history(&self) -> Vec<Visit> {
        let left = |record: &&FixationRecord| record.end_s <= self.time_s;
        self.records
            .iter()
            .filter(left)
            .map(|record| Visit {
                gaze: GazeAngles::new(record.azimuth_rad, record.elevation_rad),
                left_ago_s: self.time_s - record.end_s,
            })
            .collect()
    }

    fn depart(&mut self, target: Target, decided_s: f64) {
        let from = self.curve.at(self.time_s).0;
        let curve = GazeCurve::saccade(from, target.gaze, self.time_s);
        self.curve = curve;
        self.departed_s = self.time_s;
        let flight_s = match curve {
            GazeCurve::Saccade { profile, .. } => profile.duration_s(),
            GazeCurve::Hold(_) | GazeCurve::Pursuit { .. } => 0.0,
        };
        self.landed_s = self.time_s + flight_s;
        self.fixation = target;
        let vergence_per_m = 1.0 / target.distance_m;
        self.vergence =
            self.vergence
                .turn_to(self.time_s, vergence_per_m, VERGENCE_TIME_CONSTANT_S);
        self.fixation_index += 1;
        if let Some(last) = self.records.last_mut() {
            last.end_s = self.time_s;
        }
        if self.records.len() == FIXATIONS_KEPT {
            self.records.remove(0);
        }
        self.records.push(FixationRecord {
            index: self.fixation_index,
            azimuth_rad: target.gaze.azimuth_rad,
            elevation_rad: target.gaze.elevation_rad,
            distance_m: target.distance_m,
            start_s: self.landed_s,
            end_s: f64::INFINITY,
        });
        self.queue.push(self.landed_s, Event::Land);
        self.focus_on(target.distance_m, decided_s);
        // The next target may be prepared while this saccade still flies.
        self.schedule_choice(self.landed_s);
    }

    fn land(&mut self) {
        self.curve = GazeCurve::Hold(self.fixation.gaze);
        self.landed_s = self.time_s;
        if let Mode::Follow(target) = self.mode {
            self.pursue(target);
        }
    }

    /// Schedules the lens for a point that was chosen at `decided_s`.
    fn focus_on(&mut self, distance_m: f64, decided_s: f64) {
        let start_s = (decided_s + self.settings.lens_latency_s()).max(self.time_s);
        self.queue.push(start_s, Event::Accommodate { distance_m });
    }

    fn accommodate(&mut self, distance_m: f64) {
        self.lens_distance_m = distance_m;
        let from = self.lens.at(self.time_s);
        let to = self.lens_target_d();
        let time_constant_s = match self.settings.fixation_timing {
            FixationTiming::Physiological => {
                step_time_constant_s(from, to, self.settings.accommodation_time_constant_s)
            }
            FixationTiming::Niessner => NIESSNER_LENS_TIME_CONSTANT_S,
        };
        self.lens = self.lens.turn_to(self.time_s, to, time_constant_s);
        self.turn_pupil();
    }

    fn lens_target_d(&self) -> f64 {
        steady_response_d(
            self.lens_distance_m,
            self.settings.far_point_d,
            self.settings.accommodation_amplitude_d,
            self.settings.accommodation_lag,
        )
    }

    fn pupil_target_mm(&self) -> f64 {
        steady_diameter_mm(
            self.settings.pupil,
            self.settings.age_years,
            self.lens.to,
            self.settings.near_response_mm_per_d,
        )
    }

    fn unrest_target_mm(&self) -> f64 {
        match self.settings.pupil {
            PupilMode::Manual(_) => 0.0,
            PupilMode::Auto { .. } => self.settings.hippus_rms_mm,
        }
    }

    fn turn_pupil(&mut self) {
        let (t, to) = (self.time_s, self.pupil_target_mm());
        if to != self.pupil.to {
            let time_constant_s = time_constant_s(self.pupil.at(t), to);
            self.pupil = self.pupil.turn_to(t, to, time_constant_s);
        }
        let unrest_mm = self.unrest_target_mm();
        if unrest_mm != self.unrest_mm.to {
            self.unrest_mm = self
                .unrest_mm
                .turn_to(t, unrest_mm, CONSTRICTION_TIME_CONSTANT_S);
        }
    }

    /// Draws the next spontaneous blink after one that began at `from_s`.
    fn schedule_blink(&mut self, from_s: f64) {
        self.queue.retain(|event| *event != Event::SpontaneousBlink);
        if !self.settings.blinks {
            return;
        }
        let mut rng = random::stream(self.settings.seed, "blink interval", self.blink_draws);
        self.blink_draws += 1;
        if let Some(interval_s) = self.settings.blink_rate.draw_interval_s(&mut rng) {
            let free_s = self
                .blink
                .map_or(from_s, |blink| blink.end_s() + BLINK_GAP_S);
            self.queue
                .push((from_s + interval_s).max(free_s), Event::SpontaneousBlink);
        }
    }

    fn blink_spontaneously(&mut self) {
        let mut rng = random::stream(self.settings.seed, "blink depth", self.blink_draws);
        let partial = random::uniform(&mut rng) < self.settings.partial_blink_fraction;
        let depth = if partial {
            random::uniform_between(&mut rng, PARTIAL_DEPTH.0, PARTIAL_DEPTH.1)
        } else {
            1.0
        };
        self.begin_blink(Blink::spontaneous(self.time_s, depth));
    }

    /// Starts a blink unless one is under way, and draws the next spontaneous one.
    fn begin_blink(&mut self, blink: Blink) {
        if self.blink.is_some_and(|last| self.time_s < last.end_s()) {
            return;
        }
        if self.blink.is_some_and(|last| last.is_full()) {
            self.closures += 1;
        }
        self.blink = Some(blink);
        self.schedule_blink(self.time_s);
    }
}

#[cfg(test)]
mod command_tests;
#[cfg(test)]
mod tests;
