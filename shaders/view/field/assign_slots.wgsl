// Once a view: the voxel of every pixel.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> pixel_slot: array<u32>;
@group(0) @binding(3) var<storage, read_write> voxel_tag: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> voxel_home: array<u32>;
@group(0) @binding(5) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
// 0: voxels in the table; 1: insertions that found no free slot.
@group(0) @binding(6) var<storage, read_write> table_counters: array<atomic<u32>, 4>;
@group(0) @binding(7) var<storage, read> movers: Movers;

// Slot of a point on something that has moved.
fn slot_on_mover(point: vec3<f32>, k: u32) -> u32 {
    let at = vec4<f32>(point, 1.0) * movers.list[k].rest;
    let voxel = sharpness_voxel_at(at, percept.voxel_size_m, percept.voxel_angle_rad);
    let named = voxel + vec4<i32>(0, 0, 0, i32(movers.list[k].name) << 12u);
    let slot = slot_of(sharpness_voxel_hash(named));
    if movers.list[k].is_new != 0u && slot != NO_SLOT {
        let before = find_slot(sharpness_voxel_hash(voxel));
        if before != NO_SLOT {
            atomicMin(&sharpness_keys[slot], atomicLoad(&sharpness_keys[before]));
        }
    }
    return slot;
}

@compute @workgroup_size(8, 8)
fn assign_slots(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let direction = direction_of(pixel);
    let vergence = textureLoad(view_vergence, pixel, 0).x;
    let at = pixel.y * percept.size.x + pixel.x;
    if movers.count > 0u && vergence >= 1.0 / SHARPNESS_FAR_M {
        let point = percept.eye_m + direction / vergence;
        let mover = mover_at(point);
        if mover < movers.count {
            pixel_slot[at] = slot_on_mover(point, mover);
            return;
        }
    }
    let voxel = sharpness_voxel(percept.eye_m, direction, vergence, percept.voxel_size_m, percept.voxel_angle_rad);
    pixel_slot[at] = slot_of(sharpness_voxel_hash(voxel));
}
