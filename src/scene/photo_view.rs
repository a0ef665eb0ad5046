//! A photograph as the two images that the view is captured from: colour and vergence at the
//! panel's size. All of it is in the view; what the panel has beside it is dark.

use super::photo::{PhotoDepth, PhotoScene};
use bevy::asset::RenderAssetUsages;
use bevy::ecs::component::Component;
use bevy::ecs::reflect::ReflectComponent;
use bevy::image::Image;
use bevy::math::{Isometry3d, UVec2, Vec2};
use bevy::reflect::Reflect;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use half::f16;
use std::sync::Arc;

/// The photograph that a camera looks at in place of what stands before it in the world.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque, Component)]
pub struct Photograph {
    /// The photograph.
    pub photo: Arc<PhotoScene>,
    /// From where, and where to, it was taken: the camera there has it before it as a whole. Elsewhere it
    /// sees what the photograph shows, by its distances, from there.
    pub taken_from: Isometry3d,
}

/// Tangent of half the widest angle that a panel spans so that all of a photograph is in it (60°): of a
/// longer strip the ends are cut off.
const WIDEST_TAN: f32 = 1.732;

/// Texels of the photograph along a pixel of the panel.
fn scale_of(source: Vec2, size: Vec2, tan_half_height: f32) -> f32 {
    let sides = source / size;
    let widest = WIDEST_TAN / tan_half_height * source.y / size.max_element();
    sides.max_element().min(widest).max(sides.min_element())
}

/// Of its distance, by how much a surface may step over one texel of a panel and still be one: what lies flat
/// before the eye steps by this much only far out.
pub const STEP_SHARE: f32 = 0.1;

/// Texels over which the edge of a thing may be smeared in a depth image.
const WIDEST_EDGE: usize = 4;

/// Takes texels that float between two surfaces to whichever of them is nearer in dioptres: depth images are made
/// with soft edges, and there is nothing at such a distance. Row by row and column by column.
fn sharpen_edges(vergences: &mut [f32], size: UVec2) {
    let (width, height) = (size.x as usize, size.y as usize);
    let mut line = Vec::new();
    let mut along = |count: usize, start: usize, stride: usize| {
        line.clear();
        line.extend((0..count).map(|i| vergences[start + i * stride]));
        sharpen_line(&mut line);
        for (i, vergence) in line.iter().enumerate() {
            vergences[start + i * stride] = *vergence;
        }
    };
    for y in 0..height {
        along(width, y * width, 1);
    }
    for x in 0..width {
        along(height, x, width);
    }
}

/// [`sharpen_edges`] of one line.
fn sharpen_line(line: &mut [f32]) {
    // Steps are shares of distances as of vergences.
    let steps = |a: f32, b: f32| (a - b).abs() > STEP_SHARE * a.max(b);
    let mut at = 1;
    while at < line.len() {
        // A run of steps that go one way.
        let first = at - 1;
        let rises = line[at] > line[first];
        let goes_on = |i: usize| steps(line[i], line[i - 1]) && (line[i] > line[i - 1]) == rises;
        let mut end = at;
        while end < line.len() && goes_on(end) {
            end += 1;
        }
        let between = end.saturating_sub(at + 1);
        if (1..=WIDEST_EDGE).contains(&between) {
            let ends = [line[first], line[end - 1]];
            for vergence in &mut line[at..end - 1] {
                let is_first = (*vergence - ends[0]).abs() <= (*vergence - ends[1]).abs();
                *vergence = if is_first { ends[0] } else { ends[1] };
            }
        }
        at = end.max(at + 1);
    }
}

/// Colour (RGBA16F, linear) of the photograph's picture of this index, vergence (RG32F, 1/m: as it is, and with
/// [`sharpen_edges`] for whoever looks from elsewhere), and the angle (degrees) that the panel's smaller side now spans.
pub fn photo_images(photo: &PhotoScene, picture: usize, size: UVec2) -> (Image, Image, f32) {
    let source = Vec2::new(photo.width as f32, photo.height as f32);
    let full_half = (0.5 * photo.vertical_fov_deg.to_radians()).tan();
    let scale = scale_of(source, size.as_vec2(), full_half);
    let crop = size.as_vec2() * scale;
    let corner = (source - crop) * 0.5;
    let codes = photo.picture(picture);
    let mut colour = Vec::with_capacity((size.x * size.y * 8) as usize);
    let mut vergences = Vec::with_capacity((size.x * size.y) as usize);
    for y in 0..size.y {
        for x in 0..size.x {
            let low = corner + Vec2::new(x as f32, y as f32) * scale;
            let covered = (low + scale).min(source) - low.max(Vec2::ZERO);
            let share = (covered.max(Vec2::ZERO) / scale).element_product();
            for channel in mean_colour(photo, codes, low, low + scale) {
                colour.extend_from_slice(&f16::from_f32(channel * share).to_le_bytes());
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
            vergences.push(value);
        }
    }
    let mut sharp = vergences.clone();
    if !matches!(photo.depth_m, PhotoDepth::Constant(_)) {
        sharpen_edges(&mut sharp, size);
    }
    let vergence = vergences
        .into_iter()
        .zip(sharp)
        .flat_map(|(own, sharp)| [own, sharp])
        .flat_map(f32::to_le_bytes)
        .collect();
    let half = full_half * crop.min_element() / source.y;
    (
        image(size, TextureFormat::Rgba16Float, colour),
        image(size, TextureFormat::Rg32Float, vergence),
        2.0 * half.atan().to_degrees(),
    )
}

/// Mean linear colour of the texels whose centres lie between two corners, or of the nearest one.
fn mean_colour(photo: &PhotoScene, codes: &[u16], low: Vec2, high: Vec2) -> [f32; 3] {
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
                *total += super::model::srgb16_to_linear(codes[at + channel]);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soft_edge_becomes_a_step_and_a_slope_stays_one() {
        let sharpened = |line: &[f32]| {
            let mut line = line.to_vec();
            sharpen_line(&mut line);
            line
        };
        for (soft, sharp) in [
            // A smeared edge, whichever way.
            (vec![2.0, 2.0, 1.1, 0.5, 0.5], vec![2.0, 2.0, 0.5, 0.5, 0.5]),
            (
                vec![0.0, 0.1, 0.8, 1.5, 1.8, 1.8],
                vec![0.0, 0.0, 0.0, 1.8, 1.8, 1.8],
            ),
            // What is an edge already, a floor that recedes, and a thin thing before another stay.
            (vec![2.0, 2.0, 0.5, 0.5], vec![2.0, 2.0, 0.5, 0.5]),
            (vec![1.0, 0.95, 0.9, 0.85], vec![1.0, 0.95, 0.9, 0.85]),
            (vec![0.5, 2.0, 0.5], vec![0.5, 2.0, 0.5]),
            // So does a surface that is seen this much aside over more texels than an edge has.
            (
                vec![4.0, 3.0, 2.2, 1.6, 1.2, 0.9, 0.6],
                vec![4.0, 3.0, 2.2, 1.6, 1.2, 0.9, 0.6],
            ),
        ] {
            assert_eq!(sharpened(&soft), sharp, "{soft:?}");
        }
        // Of every line a texel has one of the line's own distances, and ends stay.
        let mut both = vec![2.0, 2.0, 2.0, 2.0, 1.2, 0.9, 2.0, 0.9, 0.5];
        sharpen_edges(&mut both, UVec2::splat(3));
        assert!(
            both.iter().all(|vergence| [2.0, 0.5].contains(vergence)),
            "{both:?}"
        );
    }

    fn white(width: u32, height: u32, vertical_fov_deg: f32) -> PhotoScene {
        PhotoScene {
            name: "p".into(),
            width,
            height,
            rgb16_srgb: vec![u16::MAX; (width * height * 3) as usize],
            depth_m: PhotoDepth::Constant(0.5),
            vertical_fov_deg,
            mean_luminance_cd_m2: 250.0,
            course: None,
            remarks: Vec::new(),
        }
    }

    /// Light of a panel's pixels, row by row, and the angle of its smaller side.
    fn shown(photo: &PhotoScene, size: UVec2) -> (Vec<f32>, f32) {
        let (colour, vergence, angle_deg) = photo_images(photo, 0, size);
        let colour = colour.data.expect("colours");
        let red = colour
            .chunks_exact(8)
            .map(|rgba| f16::from_le_bytes([rgba[0], rgba[1]]).to_f32());
        let vergence = vergence.data.expect("vergences");
        assert!(
            vergence
                .chunks_exact(4)
                .all(|bytes| bytes == 2f32.to_le_bytes())
        );
        (red.collect(), angle_deg)
    }

    #[test]
    fn all_of_a_photograph_is_in_every_panel() {
        // Upright in a broad panel: dark at both sides, and as high as it is said to be.
        let (light, angle_deg) = shown(&white(30, 60, 40.0), UVec2::new(80, 40));
        for row in light.chunks_exact(80) {
            let wanted = |x: usize| if (30..50).contains(&x) { 1.0 } else { 0.0 };
            assert!(
                row.iter().enumerate().all(|(x, light)| *light == wanted(x)),
                "{row:?}"
            );
        }
        assert!((angle_deg - 40.0).abs() < 1e-4, "{angle_deg}");
        // Broad in an upright panel: dark above and below, the panel's width spans the picture's.
        let (light, angle_deg) = shown(&white(60, 30, 40.0), UVec2::new(40, 80));
        assert_eq!(light.iter().filter(|light| **light == 1.0).count(), 40 * 20);
        let width_deg = 2.0 * (2.0 * 20f32.to_radians().tan()).atan().to_degrees();
        assert!(
            (angle_deg - width_deg).abs() < 1e-3,
            "{angle_deg}, not {width_deg}"
        );
        // Where an edge falls into a pixel, that has its share.
        let (light, _) = shown(&white(30, 60, 40.0), UVec2::new(41, 40));
        let whole: f32 = light[..41].iter().sum();
        assert!(
            (whole - 20.0).abs() < 1e-2 && light.contains(&0.5),
            "{:?}",
            &light[..41]
        );
        // The same shape fills it, at any size.
        for side in [17, 60, 200] {
            let (light, angle_deg) = shown(&white(60, 60, 40.0), UVec2::splat(side));
            assert!(light.iter().all(|light| *light == 1.0) && (angle_deg - 40.0).abs() < 1e-4);
        }
        // A long strip is cut at its ends rather than seen under more than 120°.
        let (light, angle_deg) = shown(&white(2000, 20, 50.0), UVec2::splat(100));
        let rows = light.iter().filter(|light| **light > 0.0).count() / 100;
        assert!(
            (angle_deg - 120.0).abs() < 0.1 && (25..30).contains(&rows),
            "{angle_deg}, {rows}"
        );
    }
}
