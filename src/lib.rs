//! Ocularium: an anatomically accurate human eye that you can look at and look
//! through, both at once, on the desktop and in a browser.
//!
//! One patient ([`anatomy`], read from files by [`patients`]) drives two viewers: [`appearance`] draws
//! her eyes from outside, [`percept`] makes a camera see as they do, and [`motion`] moves both.
//! [`conditions`] change anatomy. [`optics`] and [`tissue`] are the mathematics below them, free of
//! Bevy and usable alone. [`OculariumPlugins`] puts the plugins together; [`stage`] shows one
//! patient before one scene with them.
//!
//! Units: millimetres in the eye, metres in the scene, dioptres for vergence,
//! seconds, radians; degrees where a name ends in `_deg`.

pub mod anatomy;
pub mod app;
pub mod appearance;
pub mod conditions;
pub mod frame;
mod input_file;
#[cfg(not(target_arch = "wasm32"))]
pub mod lab;
pub mod motion;
pub mod optics;
pub mod patients;
pub mod percept;
mod plugins;
pub mod scene;
pub mod stage;
pub mod tissue;
#[cfg(feature = "app")]
pub mod ui;

pub use plugins::{OculariumPlugins, prelude};
