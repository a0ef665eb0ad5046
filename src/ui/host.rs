//! What the app asks of the machine it runs on: to choose files, to copy text, to keep a file.
//!
//! The same calls on the desktop and in a browser. Answers come when they come: [`take`] hands them
//! out.

use super::own_files::OwnFile;
use std::sync::{Mutex, PoisonError};

#[cfg(not(target_arch = "wasm32"))]
mod desktop;
#[cfg(target_arch = "wasm32")]
mod page;

#[cfg(not(target_arch = "wasm32"))]
pub use desktop::{Clipboard, choose_files, copy_text, is_touch, read_paths, save_file};
#[cfg(target_arch = "wasm32")]
pub use page::{
    Clipboard, address, choose_files, copy_text, device_lost, fragment, is_telephone, is_touch,
    replace_fragment, save_file,
};

/// What comes in from outside.
#[derive(Clone, Debug)]
pub enum Arrival {
    /// Files that were chosen or dropped together.
    Files(Vec<OwnFile>),
    /// A sentence for the user: where a file went, or why not.
    Said(String),
}

// One process or page has one window, and a browser calls from outside of the app.
static ARRIVALS: Mutex<Vec<Arrival>> = Mutex::new(Vec::new());

/// Hands something in from outside.
pub fn arrive(arrival: Arrival) {
    ARRIVALS
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(arrival);
}

/// What has come in since the last call.
pub fn take() -> Vec<Arrival> {
    std::mem::take(&mut *ARRIVALS.lock().unwrap_or_else(PoisonError::into_inner))
}
