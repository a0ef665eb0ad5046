//! What the engine can be told while it runs: where to look, what is there to see, when to blink.
//!
//! What enters: commands with their times. What leaves: events in the engine's queue. A command
//! for a time that has passed takes effect now; one that comes before the first advance sets the
//! pose in which the run begins.

use super::queue::{Event, Target};
use super::{AHEAD_RAD, Candidate, GazeCurve, Mode, Oculomotor, VERGENCE_TIME_CONSTANT_S};
use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::visual_field::VisualField;
use crate::motion::accommodation::{Approach, demand_d};
use crate::motion::pupil::{Hippus, LIGHT_REFLEX_LATENCY_S, PupilMode};
use crate::motion::settings::{MotionError, OculomotorSettings, within};

/// Delay of the pursuit system, s.
const PURSUIT_DELAY_S: f64 = 0.1;
/// Change of demand that makes the lens move while a target is followed, D.
const FOLLOW_STEP_D: f64 = 0.05;

/// Where to look. Angles are head-fixed, rad, right and up; distances in m, > 0, may be infinite.
/// Directions beyond the eye's reach (55°) are clamped to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GazeCommand {
    /// The eye looks around by itself.
    #[default]
    Auto,
    /// A saccade there, and the eye stays.
    Fixed {
        /// To the right, rad.
        azimuth_rad: f64,
        /// Up, rad.
        elevation_rad: f64,
        /// Distance, m.
        distance_m: f64,
    },
    /// The eye glides after this point and jumps when it has fallen far behind. Send it whenever
    /// the point moves.
    Follow {
        /// To the right, rad.
        azimuth_rad: f64,
        /// Up, rad.
        elevation_rad: f64,
        /// Distance, m.
        distance_m: f64,
    },
    /// One saccade there, then the eye looks around by itself again.
    LookOnce {
        /// To the right, rad.
        azimuth_rad: f64,
        /// Up, rad.
        elevation_rad: f64,
        /// Distance, m.
        distance_m: f64,
    },
}

impl GazeCommand {
    fn check(&self) -> Result<(), MotionError> {
        match *self {
            Self::Auto => Ok(()),
            Self::Fixed {
                azimuth_rad,
                elevation_rad,
                distance_m,
            }
            | Self::Follow {
                azimuth_rad,
                elevation_rad,
                distance_m,
            }
            | Self::LookOnce {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                let turn = std::f64::consts::PI;
                within("azimuth_rad", azimuth_rad, -turn, turn, "-π to π")?;
                within("elevation_rad", elevation_rad, -turn, turn, "-π to π")?;
                let (low, high) = (f64::MIN_POSITIVE, f64::INFINITY);
                within("distance_m", distance_m, low, high, "greater than 0 m")
            }
        }
    }
}

fn target(azimuth_rad: f64, elevation_rad: f64, distance_m: f64) -> Target {
    Target {
        gaze: GazeAngles::new(azimuth_rad, elevation_rad).within_range(),
        distance_m,
    }
}

impl Oculomotor {
    /// Replaces the candidates from now on; unusable ones (not finite, or a distance of 0 or
    /// less) are left out, and those beyond the eye's reach too. Head-fixed lists that change only
    /// with the scene keep the trace free of the frame rate.
    pub fn set_candidates(&mut self, candidates: Vec<Candidate>) {
        self.candidates = usable(candidates);
        if !self.started && self.mode == Mode::Auto && !self.chosen_once {
            self.settle_ahead();
        }
    }

    /// Says how far away in m the thing straight ahead is, as long as nothing has happened yet: an eye
    /// without a candidate near there begins by looking at it. What is not above 0 does nothing.
    pub fn set_ahead_distance(&mut self, distance_m: f64) {
        if distance_m > 0.0 {
            self.ahead_distance_m = distance_m;
            if !self.started && self.mode == Mode::Auto && !self.chosen_once {
                self.settle_ahead();
            }
        }
    }

    /// Sets the visual field that attention works with; `None`, the default, is a whole one and
    /// costs nothing.
    pub fn set_visual_field(&mut self, field: Option<VisualField>) {
        self.field = field;
    }

    /// Tells the eye at time `t` in s where to look.
    ///
    /// # Errors
    /// [`MotionError`] when the time or an angle is not finite or a distance is not above 0.
    pub fn command(&mut self, t: f64, command: GazeCommand) -> Result<(), MotionError> {
        command.check()?;
        if self.started || t > 0.0 {
            return self.enter(t, Event::Command(command));
        }
        check_time(t)?;
        self.begin_with(command);
        Ok(())
    }

    /// A voluntary, full blink at time `t` in s. One that is under way is not interrupted.
    ///
    /// # Errors
    /// [`MotionError`] when `t` is not finite.
    pub fn blink_now(&mut self, t: f64) -> Result<(), MotionError> {
        self.enter(t, Event::VoluntaryBlink)
    }

    /// Starts again at time 0 with another seed. Settings, candidates and field stay; commands and
    /// gaze do not.
    pub fn reset(&mut self, seed: u64) {
        self.settings.seed = seed;
        // The settings were checked when they came in.
        if let Ok(fresh) = Self::new(self.settings.clone()) {
            let (candidates, field) = (std::mem::take(&mut self.candidates), self.field.take());
            *self = fresh;
            self.candidates = candidates;
            self.field = field;
            self.settle_ahead();
        }
    }

    /// Changes the settings from now on. Gaze, lids, lens and pupil go on from where they are; a
    /// new seed acts on the choices that follow.
    ///
    /// # Errors
    /// [`MotionError`] when a setting is out of range; the old ones stay.
    pub fn set_settings(&mut self, settings: OculomotorSettings) -> Result<(), MotionError> {
        settings.check()?;
        let old = std::mem::replace(&mut self.settings, settings);
        if !self.started {
            self.hippus = Hippus::new(self.settings.seed);
            self.settle_on(self.fixation);
            return Ok(());
        }
        let new = &self.settings;
        let timing_changed = new.fixation_timing != old.fixation_timing;
        let blinks_changed = new.blinks != old.blinks || new.blink_rate != old.blink_rate;
        let looks = new.saccades;
        let looks_changed = looks != old.saccades || timing_changed;
        let light_changed = new.pupil != old.pupil;
        let manual = matches!(new.pupil, PupilMode::Manual(_));
        if blinks_changed {
            self.schedule_blink(self.time_s);
        }
        if looks_changed {
            // A saccade that is planned already, perhaps on command, still comes.
            self.queue
                .retain(|event| !matches!(event, Event::Decide { .. }));
            if !self.has_plans() {
                self.schedule_choice(self.time_s.max(self.landed_s));
            }
        }
        if self.lens_target_d() != self.lens.to {
            self.accommodate(self.lens_distance_m);
        }
        if light_changed && !manual {
            let t = self.time_s + LIGHT_REFLEX_LATENCY_S;
            self.queue.push(t, Event::Light);
        } else {
            self.turn_pupil();
        }
        Ok(())
    }

    fn enter(&mut self, t: f64, event: Event) -> Result<(), MotionError> {
        check_time(t)?;
        self.queue.push(t.max(self.time_s), event);
        Ok(())
    }

    /// Before the run: the pose is where the command wants it.
    fn begin_with(&mut self, command: GazeCommand) {
        match command {
            GazeCommand::Auto => {
                self.mode = Mode::Auto;
                self.settle_ahead();
            }
            GazeCommand::Fixed {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                self.mode = Mode::Fixed;
                self.settle_on(target(azimuth_rad, elevation_rad, distance_m));
            }
            GazeCommand::Follow {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                let target = target(azimuth_rad, elevation_rad, distance_m);
                self.mode = Mode::Follow(target);
                self.settle_on(target);
            }
            GazeCommand::LookOnce {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                self.mode = Mode::Auto;
                self.chosen_once = true;
                self.settle_on(target(azimuth_rad, elevation_rad, distance_m));
            }
        }
    }

    /// Straight ahead, at the distance of the candidate nearest to there, if one is near; else at the
    /// distance of what is there.
    fn settle_ahead(&mut self) {
        let ahead = GazeAngles::default();
        let angle = |c: &Candidate| ahead.angle_to(GazeAngles::new(c.azimuth_rad, c.elevation_rad));
        let nearest = self
            .candidates
            .iter()
            .filter(|c| angle(c) < AHEAD_RAD)
            .min_by(|a, b| angle(a).total_cmp(&angle(b)));
        let distance_m = nearest.map_or(self.ahead_distance_m, |c| c.distance_m);
        self.settle_on(Target {
            gaze: ahead,
            distance_m,
        });
    }

    /// Gaze, lens and pupil stand still, adapted to this target.
    pub(super) fn settle_on(&mut self, target: Target) {
        self.curve = GazeCurve::Hold(target.gaze);
        self.fixation = target;
        self.lens_distance_m = target.distance_m;
        self.vergence = Approach::rest(1.0 / target.distance_m);
        self.lens = Approach::rest(self.lens_target_d());
        self.pupil = Approach::rest(self.pupil_target_mm());
        self.unrest_mm = Approach::rest(self.unrest_target_mm());
    }

    pub(super) fn apply_command(&mut self, command: GazeCommand) {
        match command {
            GazeCommand::Auto => {
                self.mode = Mode::Auto;
                if !self.has_plans() {
                    self.schedule_choice(self.time_s.max(self.landed_s));
                }
            }
            GazeCommand::Fixed {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                self.mode = Mode::Fixed;
                self.look_at(target(azimuth_rad, elevation_rad, distance_m));
            }
            GazeCommand::LookOnce {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                self.mode = Mode::Auto;
                self.chosen_once = true;
                self.look_at(target(azimuth_rad, elevation_rad, distance_m));
            }
            GazeCommand::Follow {
                azimuth_rad,
                elevation_rad,
                distance_m,
            } => {
                let target = target(azimuth_rad, elevation_rad, distance_m);
                if !matches!(self.mode, Mode::Follow(_)) {
                    self.forget_plans();
                }
                self.mode = Mode::Follow(target);
                let seen_s = self.time_s + PURSUIT_DELAY_S.min(self.settings.command_latency_s());
                self.queue.push(seen_s, Event::Pursue(target));
            }
        }
    }

    /// Plans a saccade to a target that appears now, after latency and refractory time.
    fn look_at(&mut self, target: Target) {
        self.forget_plans();
        let ready_s = self.time_s + self.settings.command_latency_s();
        self.plan_departure(target, ready_s);
    }

    fn plan_departure(&mut self, target: Target, ready_s: f64) {
        let rested_s = if self.fixation_index == 0 {
            ready_s
        } else {
            self.landed_s + self.settings.refractory_in_use_s()
        };
        let decided_s = self.time_s;
        self.queue
            .push(ready_s.max(rested_s), Event::Depart { target, decided_s });
    }

    /// Follows a target: glides when it is near, jumps when it is far.
    pub(super) fn pursue(&mut self, target: Target) {
        let Mode::Follow(_) = self.mode else { return };
        if self.in_flight() {
            return;
        }
        let mut retargeted = false;
        self.queue.for_each(|event| {
            if let Event::Depart {
                target: planned, ..
            } = event
            {
                *planned = target;
                retargeted = true;
            }
        });
        if retargeted {
            return;
        }
        let gaze = self.curve.at(self.time_s).0;
        if gaze.angle_to(target.gaze).to_degrees() > self.settings.catch_up_deg {
            let rest = (self.settings.command_latency_s() - PURSUIT_DELAY_S).max(0.0);
            self.plan_departure(target, self.time_s + rest);
            return;
        }
        self.vergence = self.vergence.turn_to(
            self.time_s,
            1.0 / target.distance_m,
            VERGENCE_TIME_CONSTANT_S,
        );
        self.curve = GazeCurve::Pursuit {
            from: gaze,
            to: target.gaze,
            start_s: self.time_s,
            time_constant_s: self.settings.pursuit_time_constant_s,
        };
        let step_d = demand_d(target.distance_m) - demand_d(self.fixation.distance_m);
        if step_d.abs() > FOLLOW_STEP_D {
            self.fixation.distance_m = target.distance_m;
            self.focus_on(target.distance_m, self.time_s);
        }
        self.fixation.gaze = target.gaze;
    }

    /// Drops the choice and the saccade that are planned; a saccade in flight goes on.
    fn forget_plans(&mut self) {
        self.queue.retain(|event| {
            !matches!(
                event,
                Event::Decide { .. } | Event::Depart { .. } | Event::Pursue(_)
            )
        });
    }

    fn has_plans(&self) -> bool {
        self.queue
            .any(|event| matches!(event, Event::Decide { .. } | Event::Depart { .. }))
    }
}

fn check_time(t: f64) -> Result<(), MotionError> {
    within("time_s", t, f64::MIN, f64::MAX, "a finite time")
}

fn usable(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.retain(|c| {
        let gaze = GazeAngles::new(c.azimuth_rad, c.elevation_rad);
        c.is_valid() && gaze == gaze.within_range()
    });
    candidates
}
