//! Saving what is seen: the panels' own pixels as PNG.

use super::host;
use super::state::UiState;
use crate::frame::Panel;
use crate::frame::picture::{encode_png, from_padded_rows, side_by_side};
use crate::stage::Panels;
use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::renderer::RenderDevice;
use image::RgbaImage;

/// Which panels are saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// The patient's eye.
    Eye,
    /// What the patient sees.
    View,
    /// Both, the eye on the left.
    Both,
}

impl Saved {
    fn file_name(self) -> &'static str {
        match self {
            Self::Eye => "ocularium-eye.png",
            Self::View => "ocularium-view.png",
            Self::Both => "ocularium.png",
        }
    }
}

/// A panel on its way from the GPU.
#[derive(Component)]
pub(super) struct Copying {
    part: usize,
    size: UVec2,
}

/// The parts of a picture that is being saved.
#[derive(Resource, Default)]
pub(super) struct Saving {
    wanted: Option<Saved>,
    parts: [Option<RgbaImage>; 2],
    missing: usize,
    done: Option<(Saved, RgbaImage)>,
}

impl Saving {
    /// Is something on its way?
    pub(super) fn is_busy(&self) -> bool {
        self.wanted.is_some() || self.done.is_some()
    }

    /// Asks for the panels' pixels as they are in the next frame.
    pub(super) fn begin(&mut self, saved: Saved, panels: &Panels, commands: &mut Commands) {
        if self.is_busy() {
            return;
        }
        let parts: &[(usize, &Panel)] = match saved {
            Saved::Eye => &[(0, panels.eye())],
            Saved::View => &[(1, panels.view())],
            Saved::Both => &[(0, panels.eye()), (1, panels.view())],
        };
        *self = Self {
            wanted: Some(saved),
            missing: parts.len(),
            ..Self::default()
        };
        for &(part, panel) in parts {
            let size = panel.size;
            commands
                .spawn((
                    Readback::texture(panel.image.clone()),
                    Copying { part, size },
                ))
                .observe(arrived);
        }
    }
}

fn arrived(
    copy: On<ReadbackComplete>,
    copying: Query<&Copying>,
    panels: Panels,
    mut saving: ResMut<Saving>,
    mut commands: Commands,
) {
    let Ok(&Copying { part, size }) = copying.get(copy.entity) else {
        return;
    };
    let panel = if part == 0 {
        panels.eye()
    } else {
        panels.view()
    };
    let padded = RenderDevice::align_copy_bytes_per_row(size.x as usize * 4);
    let picture = from_padded_rows(size.x, size.y, padded, &copy.data);
    let whole = copy.data.len() == padded * size.y as usize;
    commands.entity(copy.entity).despawn();
    match picture.filter(|_| whole) {
        Some(picture) => {
            saving.parts[part] = Some(picture);
            saving.missing = saving.missing.saturating_sub(1);
        }
        // The panel was resized between the request and the copy: ask again at its new size.
        None => {
            commands
                .spawn((
                    Readback::texture(panel.image.clone()),
                    Copying {
                        part,
                        size: panel.size,
                    },
                ))
                .observe(arrived);
        }
    }
    if saving.missing == 0
        && let Some(wanted) = saving.wanted.take()
    {
        let picture = match saving.parts.each_mut().map(Option::take) {
            [Some(eye), Some(view)] => Some(side_by_side(&eye, &view)),
            [one, other] => one.or(other),
        };
        saving.done = picture.map(|picture| (wanted, picture));
    }
}

/// Encodes a picture that is complete and hands it to the machine.
pub(super) fn finish(
    mut saving: ResMut<Saving>,
    mut state: ResMut<UiState>,
    _main_thread: NonSendMarker,
) {
    let Some((saved, picture)) = saving.done.take() else {
        return;
    };
    match encode_png(&picture) {
        Ok(bytes) => host::save_file(saved.file_name(), bytes),
        Err(error) => state.message = Some(format!("The picture could not be encoded: {error}.")),
    }
}
