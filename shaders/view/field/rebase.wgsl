// The keys of a table back to the beginning of their scale, or forgotten.

@group(0) @binding(1) var<storage, read_write> sharpness_keys: array<atomic<u32>>;

// Sets every key of this epoch back to R = 0, and forgets all others, or everything. One invocation a slot.
@compute @workgroup_size(64)
fn rebase(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let slot = id.y * groups.x * 64u + id.x;
    if slot > percept.slot_mask {
        return;
    }
    let key = atomicLoad(&sharpness_keys[slot]);
    atomicStore(&sharpness_keys[slot], sharpness_key_rebase(key, percept.rebase_steps, percept.epoch));
}
