// A voxel of the table. Whoever joins this text names `voxel_tag`.

// Slot of a voxel that may have one.
fn find_slot(name: vec2<u32>) -> u32 {
    var slot = name.y & percept.slot_mask;
    for (var probe = 0u; probe < MAX_PROBES; probe++) {
        let found = atomicLoad(&voxel_tag[slot]);
        if found == name.x {
            return slot;
        }
        if found == 0u {
            break;
        }
        slot = (slot + 1u) & percept.slot_mask;
    }
    return NO_SLOT;
}
