//! Copies from the GPU that arrive when they are ready, on the desktop and in a browser.

use super::super::frame::CaptureResult;
use super::super::gpu_data::{CANDIDATE_CAPACITY, FEATURE_COUNTERS, TABLE_COUNTERS, mip_levels};
use super::super::pass::Recorder;
use super::view_images::ViewImages;
use bevy::color::{LinearRgba, Luminance};
use bevy::math::UVec2;
use bevy::render::render_resource::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, MapMode, Origin3d, TexelCopyBufferInfo,
    TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
};
use bevy::render::renderer::RenderDevice;
use half::f16;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const WAITING: u8 = 0;
const MAPPED: u8 = 1;
const FAILED: u8 = 2;

/// Order of the parts in the staging buffer.
const COUNTERS_BYTES: u64 = FEATURE_COUNTERS as u64 * 4;
const TABLE_BYTES: u64 = TABLE_COUNTERS as u64 * 4;
const CANDIDATE_BYTES: u64 = CANDIDATE_CAPACITY as u64 * 16;
/// Texture copies start at multiples of this.
const TEXTURE_OFFSET: u64 = (COUNTERS_BYTES + TABLE_BYTES + CANDIDATE_BYTES).next_multiple_of(256);

/// A texel of the view's colour, in a row of its own.
const MEAN_BYTES: u64 = 256;

/// Where the mean of the picture stands, after its vergences.
fn mean_offset(row_bytes: u32, size: UVec2) -> u64 {
    TEXTURE_OFFSET + u64::from(row_bytes) * u64::from(size.y)
}

/// Luminance of a texel of halves that has `exposure` of each unit; what is not finite counts as dark.
fn luminance(rgba: &[u32], exposure: f32) -> f32 {
    let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
    let [rg, ba] = [rgba[0], rgba[1]];
    let mean = LinearRgba::rgb(half(rg), half(rg >> 16), half(ba)).luminance() / exposure;
    if mean.is_finite() { mean.max(0.0) } else { 0.0 }
}

/// One capture on its way to the CPU.
pub(in crate::percept) struct Staging {
    buffer: Buffer,
    serial: u64,
    exposure: f32,
    size: UVec2,
    row_bytes: u32,
    state: Arc<AtomicU8>,
    asked: bool,
}

impl Staging {
    /// Records the copies of a view, its corners and what its table counts; they run when the encoder is
    /// submitted. `exposure` is what the picture has of each cd/m².
    pub(in crate::percept) fn copy(
        recorder: &mut Recorder,
        (serial, exposure): (u64, f32),
        view: &ViewImages,
        (counters, candidates): (&Buffer, &Buffer),
        table_counters: &Buffer,
    ) -> Self {
        let (device, encoder, size) = (recorder.device, &mut *recorder.encoder, view.size);
        let row_bytes = RenderDevice::align_copy_bytes_per_row(size.x as usize * 4) as u32;
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("capture staging"),
            size: mean_offset(row_bytes, size) + MEAN_BYTES,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(counters, 0, &buffer, 0, COUNTERS_BYTES);
        encoder.copy_buffer_to_buffer(table_counters, 0, &buffer, COUNTERS_BYTES, TABLE_BYTES);
        encoder.copy_buffer_to_buffer(
            candidates,
            0,
            &buffer,
            COUNTERS_BYTES + TABLE_BYTES,
            CANDIDATE_BYTES,
        );
        let mut copy_level = |texture, mip_level, size: UVec2, offset, row_bytes| {
            encoder.copy_texture_to_buffer(
                TexelCopyTextureInfo {
                    texture,
                    mip_level,
                    origin: Origin3d::ZERO,
                    aspect: TextureAspect::All,
                },
                TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: TexelCopyBufferLayout {
                        offset,
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: None,
                    },
                },
                Extent3d {
                    width: size.x,
                    height: size.y,
                    depth_or_array_layers: 1,
                },
            );
        };
        copy_level(&view.vergence, 0, size, TEXTURE_OFFSET, row_bytes);
        // The last level of the mips is their mean.
        let (last, offset) = (mip_levels(size.x, size.y) - 1, mean_offset(row_bytes, size));
        copy_level(&view.colour, last, UVec2::ONE, offset, MEAN_BYTES as u32);
        Self {
            buffer,
            serial,
            exposure,
            size,
            row_bytes,
            state: Arc::new(AtomicU8::new(WAITING)),
            asked: false,
        }
    }

    fn ask(&mut self) {
        self.asked = true;
        let state = self.state.clone();
        self.buffer
            .slice(..)
            .map_async(MapMode::Read, move |result| {
                let now = if result.is_ok() { MAPPED } else { FAILED };
                state.store(now, Ordering::Release);
            });
    }

    fn read(&self) -> CaptureResult {
        let bytes = self.buffer.slice(..).get_mapped_range();
        let words = |from: u64, bytes_long: u64| -> Vec<u32> {
            bytes[from as usize..(from + bytes_long) as usize]
                .chunks_exact(4)
                .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
                .collect()
        };
        let counters = words(0, COUNTERS_BYTES);
        let listed = counters[0].min(CANDIDATE_CAPACITY);
        let mut corners: Vec<[u32; 4]> =
            words(COUNTERS_BYTES + TABLE_BYTES, u64::from(listed) * 16)
                .chunks_exact(4)
                .map(|corner| [corner[0], corner[1], corner[2], corner[3]])
                .collect();
        // The GPU lists them in any order; row by row is the same in every run.
        corners.sort_unstable_by_key(|corner| (corner[1], corner[0]));
        let row_words = u64::from(self.size.x) * 4;
        let vergence_d = (0..self.size.y)
            .flat_map(|row| {
                let from = TEXTURE_OFFSET + u64::from(row) * u64::from(self.row_bytes);
                words(from, row_words).into_iter().map(f32::from_bits)
            })
            .collect();
        CaptureResult {
            serial: self.serial,
            size: self.size,
            corners,
            found: counters[1],
            vergence_d,
            occupied: words(COUNTERS_BYTES, TABLE_BYTES)[0],
            mean_luminance: luminance(
                &words(mean_offset(self.row_bytes, self.size), 8),
                self.exposure,
            ),
        }
    }
}

/// The one capture that may be on its way.
#[derive(Default)]
pub(in crate::percept) struct Readback {
    staging: Option<Staging>,
}

impl Readback {
    /// Is one on its way?
    pub(in crate::percept) fn busy(&self) -> bool {
        self.staging.is_some()
    }

    /// Starts one, recorded in this frame.
    pub(in crate::percept) fn start(&mut self, staging: Staging) {
        self.staging = Some(staging);
    }

    /// The one that has arrived; `None` inside where it was lost on the way. Called after the frame's work is
    /// submitted.
    pub(in crate::percept) fn take_finished(&mut self) -> Option<Option<CaptureResult>> {
        let staging = self.staging.as_mut()?;
        if !staging.asked {
            staging.ask();
            return None;
        }
        match staging.state.load(Ordering::Acquire) {
            MAPPED => {
                let result = staging.read();
                staging.buffer.unmap();
                self.staging = None;
                Some(Some(result))
            }
            FAILED => {
                // The device was lost or replaced.
                self.staging = None;
                Some(None)
            }
            _ => None,
        }
    }
}
