//! The two panels: an image each, drawn only while it is shown.

use bevy::asset::RenderAssetUsages;
use bevy::image::{Image, ImageSampler};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};

/// Smallest side of a panel, pixels.
pub const SMALLEST_SIDE: u32 = 16;
/// Largest side of a panel, pixels.
pub const LARGEST_SIDE: u32 = 8192;

/// One panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Is it shown? A hidden panel runs no pass.
    pub visible: bool,
    /// Size in physical pixels.
    pub size: UVec2,
    /// What it shows, sRGB-encoded.
    pub image: Handle<Image>,
}

/// Both panels.
#[derive(Resource, Clone, Debug)]
pub struct Panels {
    /// The patient's eye, from outside.
    pub eye: Panel,
    /// What the patient sees.
    pub view: Panel,
}

impl Panels {
    /// Two panels of this size, each shown or not.
    pub fn new(images: &mut Assets<Image>, eye: UVec2, view: UVec2, shown: [bool; 2]) -> Self {
        let mut panel = |size: UVec2, visible| Panel {
            visible,
            size,
            image: images.add(target_image(size)),
        };
        Self {
            eye: panel(eye, shown[0]),
            view: panel(view, shown[1]),
        }
    }
}

impl Panel {
    /// Gives the panel another size; says whether that changed anything.
    pub fn resize(&mut self, images: &mut Assets<Image>, size: UVec2) -> bool {
        let size = size.clamp(UVec2::splat(SMALLEST_SIDE), UVec2::splat(LARGEST_SIDE));
        if size == self.size {
            return false;
        }
        self.size = size;
        // The handle stays, so that the camera and the window find the new texture under it.
        images.insert(self.image.id(), target_image(size)).is_ok()
    }
}

/// An image that a camera can draw into and a test can read back.
pub fn target_image(size: UVec2) -> Image {
    let mut image = Image::new_uninit(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING
        | TextureUsages::COPY_SRC
        | TextureUsages::COPY_DST
        | TextureUsages::RENDER_ATTACHMENT;
    image.sampler = ImageSampler::linear();
    image
}
