// Voxels into the table. Whoever joins this text names `voxel_tag`, `voxel_home` and `table_counters`.

// Slot of a voxel, taken if it has none yet. At a load under 60 % the longest run of a good hash
// stays well under the limit; a full table costs memory of sharpness, never a hang.
fn slot_of(name: vec2<u32>) -> u32 {
    var slot = name.y & percept.slot_mask;
    for (var probe = 0u; probe < MAX_PROBES; probe++) {
        let found = atomicLoad(&voxel_tag[slot]);
        if found == name.x {
            return slot;
        }
        if found == 0u {
            // A weak exchange may fail without cause: stay on the slot until it is decided.
            loop {
                let claim = atomicCompareExchangeWeak(&voxel_tag[slot], 0u, name.x);
                if claim.exchanged {
                    voxel_home[slot] = name.y;
                    atomicAdd(&table_counters[0], 1u);
                    return slot;
                }
                if claim.old_value == name.x {
                    return slot;
                }
                if claim.old_value != 0u {
                    break;
                }
            }
        }
        slot = (slot + 1u) & percept.slot_mask;
    }
    atomicAdd(&table_counters[1], 1u);
    return NO_SLOT;
}
