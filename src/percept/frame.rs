//! What the main world hands to the view's passes each frame, and what comes back.

use super::field::movers::Moved;
use super::gpu_data::{MediaUniform, PerceptUniform, PhotoUniform};
use super::pass::Effects;
use crate::anatomy::VisualField;
use bevy::asset::Handle;
use bevy::ecs::reflect::ReflectComponent;
use bevy::image::Image;
use bevy::math::UVec2;
use bevy::prelude::Component;
use bevy::reflect::Reflect;
use bevy::render::extract_component::ExtractComponent;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where a capture takes its picture from.
#[derive(Clone, Debug)]
pub enum CaptureSource {
    /// The scene camera's colour and depth of this frame.
    Scene,
    /// A photograph and its vergence, both of the view's size.
    Photo {
        /// Linear colour, RGBA16F or sRGB bytes.
        colour: Handle<Image>,
        /// Vergence in 1/m, R32F.
        vergence: Handle<Image>,
        /// Where the view is in its frame.
        numbers: PhotoUniform,
    },
}

/// A view to make static.
#[derive(Clone, Debug)]
pub struct CaptureRequest {
    /// Number of the capture.
    pub serial: u64,
    /// Where it comes from.
    pub source: CaptureSource,
    /// Is it another place, so that nothing remembered applies?
    pub forget: bool,
    /// What has moved.
    pub moved: Moved,
}

/// The visual field as a square map about the fixation; see `shaders/view/visual_field.wgsl`.
#[derive(Clone, Debug)]
pub struct FieldMap {
    /// The field that it shows.
    pub of: Arc<VisualField>,
    /// Texels along a side.
    pub side: u32,
    /// 0 blind to 1 seen, the highest row first.
    pub seen: Arc<Vec<f32>>,
    /// The mean of that.
    pub mean_seen: f32,
}

/// One frame of the view of a camera.
#[derive(Component, Clone, Debug, Default, ExtractComponent, Reflect)]
#[reflect(opaque, Component)]
pub struct PerceptFrame {
    /// Is the panel shown? If not, nothing runs.
    pub visible: bool,
    /// The numbers.
    pub uniform: PerceptUniform,
    /// A capture to make in this frame.
    pub capture: Option<CaptureRequest>,
    /// Write this moment's blur into the field?
    pub update: bool,
    /// Draw the picture?
    pub present: bool,
    /// Forget everything that was seen?
    pub forget: bool,
    /// Draw nothing but black, as nobody's view?
    pub blank: bool,
    /// The visual field, for a patient who has lost some of it.
    pub field_loss: Option<FieldMap>,
    /// What the media do to the light, for an eye in which they are clouded.
    pub media: Option<MediaUniform>,
    /// What is drawn into.
    pub target: Handle<Image>,
    /// The way back.
    pub returned: PerceptReturn,
}

impl PerceptFrame {
    /// What its eye has that a healthy one has not.
    pub(super) fn effects(&self) -> Effects {
        Effects {
            field_loss: self.field_loss.is_some(),
            media: self.media.is_some(),
            astigmatism: self.uniform.j0_d != 0.0 || self.uniform.j45_d != 0.0,
        }
    }
}

/// A finished capture, on the CPU.
#[derive(Clone, Debug, Default)]
pub struct CaptureResult {
    /// Number of the capture.
    pub serial: u64,
    /// Size of the view.
    pub size: UVec2,
    /// Corners (x, y, score, bits of the vergence), row by row.
    pub corners: Vec<[u32; 4]>,
    /// Corners found; more than listed when the list was full.
    pub found: u32,
    /// Vergence of every pixel, D.
    pub vergence_d: Vec<f32>,
    /// Voxels in the field's table.
    pub occupied: u32,
    /// Mean luminance of the picture, cd/m² by the exposure with which it was drawn; of a photograph in its
    /// own units.
    pub mean_luminance: f32,
}

impl CaptureResult {
    /// Is there nothing in the view: no surface at any distance and no corner?
    pub fn is_empty(&self) -> bool {
        !self.vergence_d.is_empty()
            && self.corners.is_empty()
            && self.vergence_d.iter().all(|vergence_d| *vergence_d == 0.0)
    }
}

#[derive(Debug, Default)]
struct Returned {
    result: Mutex<Option<CaptureResult>>,
    recorded: AtomicU64,
    is_lost: AtomicBool,
}

/// Carries finished captures from the render world; cloning shares it.
#[derive(Clone, Debug, Default)]
pub struct PerceptReturn(Arc<Returned>);

impl PerceptReturn {
    /// Leaves a result; an older one that nobody took is replaced.
    pub fn give(&self, result: CaptureResult) {
        *self.lock() = Some(result);
    }

    /// Says that one was lost on the way.
    pub fn lose(&self) {
        self.0.is_lost.store(true, Ordering::Release);
    }

    /// Was one lost since this was last asked?
    pub fn take_lost(&self) -> bool {
        self.0.is_lost.swap(false, Ordering::AcqRel)
    }

    /// Takes the result, if there is one.
    pub fn take(&self) -> Option<CaptureResult> {
        self.lock().take()
    }

    /// Notes that a capture has been recorded: the scene need not be drawn for it again.
    pub fn note_recorded(&self, serial: u64) {
        self.0.recorded.store(serial, Ordering::Release);
    }

    /// The last capture that has been recorded.
    pub fn recorded(&self) -> u64 {
        self.0.recorded.load(Ordering::Acquire)
    }

    fn lock(&self) -> MutexGuard<'_, Option<CaptureResult>> {
        self.0.result.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
