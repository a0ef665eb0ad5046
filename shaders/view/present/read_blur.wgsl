// A frame: the blur that is shown, from the sharpest that each voxel was seen.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> pixel_slot: array<u32>;
@group(0) @binding(3) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
#ifdef ASTIGMATISM
@group(0) @binding(4) var<storage, read_write> blur_px: array<u32>; // bits of the diameter, the last seven of its elongation
#else
@group(0) @binding(4) var<storage, read_write> blur_px: array<f32>;
#endif
// Per 16 x 16 tile: largest (longer) blur diameter in pixels, largest vergence.
@group(0) @binding(5) var<storage, read_write> tile_near: array<vec2<f32>>;
#ifdef FIELD_LOSS
@group(#{FIELD_LOSS_GROUP}) @binding(0) var visual_field: texture_2d<f32>;
#endif

var<workgroup> tile_blur: atomic<u32>;
var<workgroup> tile_vergence: atomic<u32>;

// Blur that is shown, as a diameter in pixels, and each tile's extremes.
@compute @workgroup_size(16, 16)
fn read_blur(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(num_workgroups) tiles: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let pixel = id.xy;
    if all(pixel < percept.size) {
        let at = pixel.y * percept.size.x + pixel.x;
        let slot = pixel_slot[at];
        // A pixel that found no slot in a full table is remembered by none: it stays blurred.
        var key = SHARPNESS_NEVER_SEEN;
        if slot != NO_SLOT {
            key = atomicLoad(&sharpness_keys[slot]);
        }
        let kept = sharpness_key_decode(key, percept.starve_steps, percept.epoch, percept.coc_cap_rad);
        var coc = kept;
#ifdef FIELD_LOSS
        // What is lost now is filled in from its surround, whatever memory holds.
        let seen = seen_fraction(visual_field, perimetric_angles(ray_of(pixel), percept.fixation));
        coc = combined_blur(coc, (1.0 - seen) * percept.loss_blur_rad);
#endif
        let diameter = coc * percept.pixels_per_radian;
#ifdef ASTIGMATISM
        let share = kept / max(coc, 1e-12);
        let elongation = share * share * sharpness_key_elongation(key, percept.epoch);
        blur_px[at] = (bitcast<u32>(diameter) & 0xFFFFFF80u) | elongation_encode(elongation);
        let longest = diameter * sqrt(1.0 + abs(elongation));
#else
        blur_px[at] = diameter;
        let longest = diameter;
#endif
        // Non-negative floats order as their bits do.
        atomicMax(&tile_blur, bitcast<u32>(longest));
        atomicMax(&tile_vergence, bitcast<u32>(textureLoad(view_vergence, pixel, 0).x));
    }
    workgroupBarrier();
    if local == 0u {
        tile_near[tile.y * tiles.x + tile.x] =
            vec2<f32>(bitcast<f32>(atomicLoad(&tile_blur)), bitcast<f32>(atomicLoad(&tile_vergence)));
    }
}
