// Where a table has become too small: an old one into a larger one.

@group(0) @binding(1) var<storage, read_write> voxel_tag: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> voxel_home: array<u32>;
@group(0) @binding(3) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
// 0: voxels in the table; 1: insertions that found no free slot.
@group(0) @binding(4) var<storage, read_write> table_counters: array<atomic<u32>, 4>;
@group(0) @binding(5) var<storage, read> voxel_tag_old: array<u32>;
@group(0) @binding(6) var<storage, read> voxel_home_old: array<u32>;
@group(0) @binding(7) var<storage, read> sharpness_keys_old: array<u32>;

// Moves every voxel of the old table into the new, larger one. One invocation a slot.
@compute @workgroup_size(64)
fn grow_table(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let old = id.y * groups.x * 64u + id.x;
    if old >= percept.table_slots_old {
        return;
    }
    let tag = voxel_tag_old[old];
    if tag == 0u {
        return;
    }
    let slot = slot_of(vec2<u32>(tag, voxel_home_old[old]));
    if slot != NO_SLOT {
        atomicMin(&sharpness_keys[slot], sharpness_keys_old[old]);
    }
}
