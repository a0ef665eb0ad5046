//! Where the eye points between two events: at rest, in a saccade, or gliding after a target.
//!
//! What enters: directions and times. What leaves: the direction and the speed at a time, as
//! closed curves along great circles.

use crate::anatomy::gaze::GazeAngles;
use crate::motion::saccade::SaccadeProfile;

/// A closed curve of gaze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GazeCurve {
    /// At rest.
    Hold(GazeAngles),
    /// On the way from one fixation to the next.
    Saccade {
        from: GazeAngles,
        to: GazeAngles,
        start_s: f64,
        profile: SaccadeProfile,
    },
    /// First-order approach to a target that moves slowly.
    Pursuit {
        from: GazeAngles,
        to: GazeAngles,
        start_s: f64,
        time_constant_s: f64,
    },
}

impl GazeCurve {
    pub fn saccade(from: GazeAngles, to: GazeAngles, start_s: f64) -> Self {
        Self::Saccade {
            from,
            to,
            start_s,
            profile: SaccadeProfile::new(from.angle_to(to).to_degrees()),
        }
    }

    /// Direction and speed (rad/s) at `t`.
    pub fn at(&self, t: f64) -> (GazeAngles, f64) {
        match *self {
            Self::Hold(gaze) => (gaze, 0.0),
            Self::Saccade {
                from,
                to,
                start_s,
                profile,
            } => {
                let elapsed = t - start_s;
                if elapsed >= profile.duration_s() {
                    return (to, 0.0);
                }
                let share = profile.position_deg(elapsed) / profile.amplitude_deg();
                let speed = profile.velocity_deg_s(elapsed).to_radians();
                (from.along(to, share), speed)
            }
            Self::Pursuit {
                from,
                to,
                start_s,
                time_constant_s,
            } => {
                let left = (-((t - start_s).max(0.0)) / time_constant_s).exp();
                let speed = from.angle_to(to) * left / time_constant_s;
                (from.along(to, 1.0 - left), speed)
            }
        }
    }

    /// Whether a tracker would report a saccade at `t`.
    pub fn in_saccade(&self, t: f64) -> bool {
        match self {
            Self::Saccade {
                start_s, profile, ..
            } => profile.is_fast_at(t - start_s),
            Self::Hold(_) | Self::Pursuit { .. } => false,
        }
    }
}
