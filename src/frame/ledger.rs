//! The ledger of work: what each frame really did, counted where it is done.
//!
//! Shared between the main world and the render world. Tests read it to prove
//! that what is hidden, paused or absent costs nothing; the window shows it.

use bevy::prelude::Resource;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

macro_rules! ledger {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {
        #[derive(Default)]
        struct Counters { $($name: AtomicU64),+ }

        /// What has been done since the program began, or between two such moments.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
        pub struct Work { $($(#[$doc])* pub $name: u64),+ }

        impl Work {
            /// The work done since `earlier`.
            pub fn since(self, earlier: Self) -> Self {
                Self { $($name: self.$name.saturating_sub(earlier.$name)),+ }
            }

            /// Every count with its name.
            pub fn entries(self) -> Vec<(&'static str, u64)> {
                vec![$((stringify!($name), self.$name)),+]
            }
        }

        impl WorkLedger {
            /// All counts now.
            pub fn read(&self) -> Work {
                Work { $($name: self.0.$name.load(Ordering::Relaxed)),+ }
            }

            $(
                $(#[$doc])*
                pub fn $name(&self, count: u64) {
                    self.0.$name.fetch_add(count, Ordering::Relaxed);
                }
            )+
        }
    };
}

/// The counters; cloning shares them.
#[derive(Resource, Clone, Default)]
pub struct WorkLedger(Arc<Counters>);

ledger! {
    /// Passes that drew the eye.
    eye_passes,
    /// Pixels of those passes.
    eye_pixels,
    /// Times the lids' geometry was computed.
    lid_poses,
    /// Vertices of lids and lashes sent to the GPU.
    lid_vertices,
    /// Passes that drew the scene.
    scene_passes,
    /// Captures of colour and distance for the view.
    view_captures,
    /// Runs of the feature detector.
    feature_passes,
    /// Updates of the sharpness field.
    field_updates,
    /// Pixels that wrote into the field.
    field_pixels,
    /// Passes that drew the view from the field.
    view_passes,
    /// Pixels of those passes.
    view_pixels,
    /// Passes that ran the code of a lost field.
    field_loss_passes,
    /// Passes that spread the veil of clouded media.
    veil_passes,
    /// Pictures of the world taken from an eye's place for what it mirrors.
    probe_pictures,
    /// Bytes of uniforms and maps sent to the GPU by us.
    bytes_uploaded,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_the_counts_and_differences_are_what_was_added() {
        let ledger = WorkLedger::default();
        let before = ledger.read();
        ledger.clone().eye_passes(2);
        assert_eq!(
            ledger.read().since(before),
            Work {
                eye_passes: 2,
                ..Work::default()
            }
        );
        assert_eq!(ledger.read().entries()[0], ("eye_passes", 2));
    }
}
