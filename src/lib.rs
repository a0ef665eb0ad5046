//! Ocularium: an anatomically accurate human eye that you can look at and look
//! through, both at once, on the desktop and in a browser.
//!
//! One patient ([`anatomy`]) drives two viewers: [`appearance`] draws the eye
//! from outside, [`percept`] draws what it sees of a [`scene`], and [`motion`]
//! moves both. [`optics`] and [`tissue`] are the mathematics below them, free of
//! Bevy and usable alone. [`app::add_ocularium`] puts the plugins together.
//!
//! Units: millimetres in the eye, metres in the scene, dioptres for vergence,
//! seconds, radians; degrees where a name ends in `_deg`.

pub mod anatomy;
pub mod app;
pub mod appearance;
mod input_file;
#[cfg(not(target_arch = "wasm32"))]
pub mod lab;
pub mod ledger;
pub mod motion;
pub mod optics;
pub mod percept;
pub mod readiness;
pub mod scene;
pub mod shaders;
pub mod tissue;
#[cfg(feature = "app")]
pub mod ui;
