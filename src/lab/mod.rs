//! The laboratory: frames without a window, measurements, and reports.
//!
//! Enters: a session. Leaves: images, traces and numbers, on the desktop only.

#[cfg(feature = "app")]
pub mod approximations;
#[cfg(feature = "app")]
pub mod bench;
pub mod display;
#[cfg(feature = "app")]
pub mod eye_cost;
pub mod eye_frames;
pub mod frame_cost;
pub mod frame_folder;
pub mod headless;
pub mod image_difference;
#[cfg(feature = "app")]
pub mod iris_picture;
#[cfg(feature = "app")]
pub mod irradiance;
#[cfg(feature = "app")]
pub mod looks;
pub mod measure;
pub mod record;
pub mod render;
