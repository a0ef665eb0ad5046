//! The app: the stage in a window, in a browser, or driven by a command line.

#[cfg(not(target_arch = "wasm32"))]
pub mod cli;
#[cfg(target_arch = "wasm32")]
pub mod web;
pub mod windowed;
