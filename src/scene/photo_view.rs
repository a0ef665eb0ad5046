//! A photograph as the two images that the view is captured from: colour and vergence at the
//! panel's size, cropped to its shape about the middle.

use super::photo::PhotoScene;
use bevy::asset::RenderAssetUsages;
use bevy::image::Image;
use bevy::math::{UVec2, Vec2};
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use half::f16;

/// Colour (RGBA16F, linear), vergence (R32F, 1/m), and the angle (degrees) that the panel's smaller
/// side now spans.
pub fn photo_images(photo: &PhotoScene, size: UVec2) -> (Image, Image, f32) {
    let source = Vec2::new(photo.width as f32, photo.height as f32);
    let scale = (source / size.as_vec2()).min_element();
    let crop = size.as_vec2() * scale;
    let corner = (source - crop) * 0.5;
    let mut colour = Vec::with_capacity((size.x * size.y * 8) as usize);
    let mut vergence = Vec::with_capacity((size.x * size.y * 4) as usize);
    for y in 0..size.y {
        for x in 0..size.x {
            let low = corner + Vec2::new(x as f32, y as f32) * scale;
            for channel in mean_colour(photo, low, low + scale) {
                colour.extend_from_slice(&f16::from_f32(channel).to_le_bytes());
            }
            colour.extend_from_slice(&f16::ONE.to_le_bytes());
            // Distances are not averaged: between two surfaces there is nothing.
            let middle = (low + 0.5 * scale)
                .clamp(Vec2::ZERO, source - 1.0)
                .as_uvec2();
            let depth_m = photo.depth_at_m(middle.x, middle.y);
            let value = if depth_m.is_finite() && depth_m > 0.0 {
                1.0 / depth_m
            } else {
                0.0
            };
            vergence.extend_from_slice(&value.to_le_bytes());
        }
    }
    let full_half = (0.5 * photo.vertical_fov_deg.to_radians()).tan();
    let half = full_half * crop.min_element() / source.y;
    (
        image(size, TextureFormat::Rgba16Float, colour),
        image(size, TextureFormat::R32Float, vergence),
        2.0 * half.atan().to_degrees(),
    )
}

/// Mean linear colour of the texels whose centres lie between two corners, or of the nearest one.
fn mean_colour(photo: &PhotoScene, low: Vec2, high: Vec2) -> [f32; 3] {
    let last = UVec2::new(photo.width - 1, photo.height - 1);
    let from = (low + 0.5).floor().max(Vec2::ZERO).as_uvec2().min(last);
    let to = (high - 0.5)
        .floor()
        .max(Vec2::ZERO)
        .as_uvec2()
        .min(last)
        .max(from);
    let mut sum = [0.0f32; 3];
    for y in from.y..=to.y {
        for x in from.x..=to.x {
            let at = ((y * photo.width + x) * 3) as usize;
            for (channel, total) in sum.iter_mut().enumerate() {
                *total += super::model::srgb16_to_linear(photo.rgb16_srgb[at + channel]);
            }
        }
    }
    let count = ((to.x - from.x + 1) * (to.y - from.y + 1)) as f32;
    sum.map(|total| total / count)
}

fn image(size: UVec2, format: TextureFormat, data: Vec<u8>) -> Image {
    let mut image = Image::new_uninit(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        format,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    image
}
