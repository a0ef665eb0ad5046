#ifdef FIELD_LOSS
// Fraction still seen at a place of the visual field (rad from the fixation, +x right, +y up),
// from a square map whose first row is the highest; its edge continues outwards.
fn seen_fraction(map: texture_2d<f32>, angles_rad: vec2<f32>) -> f32 {
    let side = vec2<f32>(textureDimensions(map));
    let uv = vec2<f32>(angles_rad.x, -angles_rad.y) / (2.0 * percept.field_half_width_rad) + 0.5;
    let place = clamp(uv * side - 0.5, vec2<f32>(0.0), side - 1.0);
    let corner = vec2<i32>(floor(place));
    let next = min(corner + 1, vec2<i32>(side) - 1);
    let f = fract(place);
    let top = mix(textureLoad(map, corner, 0).x, textureLoad(map, vec2<i32>(next.x, corner.y), 0).x, f.x);
    let bottom = mix(textureLoad(map, vec2<i32>(corner.x, next.y), 0).x, textureLoad(map, next, 0).x, f.x);
    return clamp(mix(top, bottom, f.y), 0.0, 1.0);
}
#endif
