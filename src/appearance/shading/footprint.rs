//! How much of a surface a pixel covers. Twin: `shaders/lib/footprint.wgsl`.

/// Size (mm) of a pixel's footprint at this distance (mm); `scale` is the projection's vertical one.
pub fn pixel_footprint(distance_mm: f64, scale: f64, height_px: f64) -> f64 {
    2.0 * distance_mm / (scale * height_px)
}

/// Mip level whose texels are as wide as the footprint.
pub fn footprint_level(footprint_mm: f64, texel_mm: f64) -> f64 {
    (footprint_mm / texel_mm).log2().max(0.0)
}
