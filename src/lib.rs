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

#[cfg(feature = "bevy")]
pub mod anatomy;
#[cfg(feature = "app")]
pub mod app;
#[cfg(feature = "bevy")]
pub mod appearance;
#[cfg(feature = "bevy")]
pub mod conditions;
#[cfg(feature = "bevy")]
pub mod frame;
#[cfg(feature = "bevy")]
mod input_file;
#[cfg(all(feature = "bevy", not(target_arch = "wasm32")))]
pub mod lab;
#[cfg(feature = "bevy")]
pub mod motion;
pub mod optics;
#[cfg(all(feature = "bevy", not(target_arch = "wasm32")))]
pub mod output_file;
#[cfg(feature = "bevy")]
pub mod patients;
#[cfg(feature = "bevy")]
pub mod percept;
#[cfg(feature = "bevy")]
mod plugins;
#[cfg(feature = "bevy")]
pub mod scene;
#[cfg(feature = "bevy")]
pub mod stage;
pub mod tissue;
#[cfg(feature = "app")]
pub mod ui;

#[cfg(feature = "bevy")]
pub use plugins::{OculariumPlugins, prelude};

/// The README's programs, compiled as tests.
#[cfg(all(doctest, feature = "bevy"))]
#[doc = include_str!("../README.md")]
struct Readme;
