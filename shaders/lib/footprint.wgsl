// How much of a surface a pixel covers, and the level of a map that holds no more detail than that.
// Twin: src/appearance/shading/footprint.rs.

// Size (mm) of a pixel's footprint at this distance (mm); `scale` is the projection's vertical one
// (clip from view, second column's second number).
fn pixel_footprint(distance_mm: f32, scale: f32, height_px: f32) -> f32 {
    return 2.0 * distance_mm / (scale * height_px);
}

// Mip level whose texels are as wide as the footprint.
fn footprint_level(footprint_mm: f32, texel_mm: f32) -> f32 {
    return max(log2(footprint_mm / texel_mm), 0.0);
}
