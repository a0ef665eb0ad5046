//! Motion: what the eye does over time, as a function of time.
//!
//! What enters: [`settings::OculomotorSettings`], a seed, a list of gaze candidates and commands.
//! What leaves: [`engine::OculomotorState`], the pose of globe, lids, pupil and lens at a time.
//! [`engine::Oculomotor`] is event-driven and free of frames: random choices come from a stream
//! keyed by (seed, name, number) ([`random`]), and everything between two events is a closed
//! curve ([`saccade`], [`blink`], [`accommodation`], [`pupil`], [`gaze`]).

pub mod accommodation;
pub mod attention;
pub mod blink;
pub mod engine;

pub(crate) mod plugin;
pub mod pupil;
pub(crate) mod random;
pub mod saccade;
pub mod settings;
pub mod trace;

pub use attention::Candidate;
pub use engine::{Oculomotor, OculomotorState};
pub use plugin::{Candidates, GazeController, MotionCommand, MotionPlugin};
