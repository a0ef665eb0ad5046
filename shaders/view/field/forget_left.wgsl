// Once a view in which something has moved: what was remembered where it stood.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> voxel_tag: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> movers: Movers;

// Of what has moved away from a view as it was before, nothing stays where it stood.
@compute @workgroup_size(8, 8)
fn forget_left(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let vergence = textureLoad(view_vergence, pixel, 0).x;
    if vergence < 1.0 / SHARPNESS_FAR_M {
        return;
    }
    let point = percept.eye_m + direction_of(pixel) / vergence;
    if mover_at(point) < movers.count {
        let voxel = sharpness_voxel_at(point, percept.voxel_size_m, percept.voxel_angle_rad);
        let slot = find_slot(sharpness_voxel_hash(voxel));
        if slot != NO_SLOT {
            atomicStore(&sharpness_keys[slot], SHARPNESS_NEVER_SEEN);
        }
    }
}
