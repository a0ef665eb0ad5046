//! What the engine says: the pose at a time, and the recent path of fixations.
//!
//! Nothing enters but the engine's own numbers; angles are head-fixed, rad, right and up.

/// One fixation, for drawing the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixationRecord {
    /// Number, from 0 (straight ahead, before the first choice).
    pub index: u64,
    /// To the patient's right, rad.
    pub azimuth_rad: f64,
    /// Up, rad.
    pub elevation_rad: f64,
    /// Distance of the fixated point, m.
    pub distance_m: f64,
    /// Time at which the eye lands, s. The record appears when the eye departs, so it may lie a
    /// saccade ahead.
    pub start_s: f64,
    /// Time at which the eye leaves, s; infinite as long as it has not.
    pub end_s: f64,
}

/// The pose of the eye at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OculomotorState {
    /// Time, s.
    pub time_s: f64,
    /// Gaze to the patient's right, rad.
    pub gaze_azimuth_rad: f64,
    /// Gaze up, rad.
    pub gaze_elevation_rad: f64,
    /// Top of the eye to the patient's right, rad, by Listing's law.
    pub gaze_torsion_rad: f64,
    /// Speed of the line of sight, rad/s.
    pub gaze_velocity_rad_s: f64,
    /// Whether a tracker would call this a saccade (above 30 °/s).
    pub in_saccade: bool,
    /// The fixated point, or the one that the eye is on its way to: to the right, rad.
    pub fixation_azimuth_rad: f64,
    /// The same point: up, rad.
    pub fixation_elevation_rad: f64,
    /// The same point: distance, m, may be infinite.
    pub fixation_distance_m: f64,
    /// Inverse of the distance at which the lines of sight of both eyes meet, 1/m.
    pub vergence_per_m: f64,
    /// Number of the fixation; it grows when the eye departs.
    pub fixation_index: u64,
    /// Response of the lens above its relaxed state, D.
    pub accommodation_d: f64,
    /// Pupil diameter, mm, 1–9.
    pub pupil_mm: f64,
    /// Opening of the lids: 1 as open as gaze lets them be, 0 closed.
    pub lid_aperture: f64,
    /// Whether a blink covers any of it.
    pub blinking: bool,
    /// Number of blinks that have fully closed.
    pub blink_epoch: u64,
}
