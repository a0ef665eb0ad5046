//! A panel: an image that a camera draws into, only while it is shown.

use bevy::asset::RenderAssetUsages;
use bevy::image::{Image, ImageSampler};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};

/// Smallest side of a panel, pixels.
pub const SMALLEST_SIDE: u32 = 16;
/// Largest side of a panel, pixels.
pub const LARGEST_SIDE: u32 = 8192;

/// The panel of a camera.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Panel {
    /// Is it shown? A hidden panel runs no pass.
    pub visible: bool,
    /// Size in physical pixels.
    pub size: UVec2,
    /// What it shows, sRGB-encoded.
    pub image: Handle<Image>,
}

impl Panel {
    /// A panel of this size, each side clamped to what is allowed.
    pub fn new(images: &mut Assets<Image>, size: UVec2, visible: bool) -> Self {
        let size = size.clamp(UVec2::splat(SMALLEST_SIDE), UVec2::splat(LARGEST_SIDE));
        Self {
            visible,
            size,
            image: images.add(target_image(size)),
        }
    }

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
