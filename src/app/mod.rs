//! The app: the stage in a window, in a browser, or driven by a command line.

#[cfg(all(feature = "app", not(target_arch = "wasm32")))]
pub mod cli;
#[cfg(all(feature = "app", target_arch = "wasm32"))]
pub mod web;
#[cfg(feature = "app")]
pub mod windowed;
