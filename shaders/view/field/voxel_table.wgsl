// The table of voxels: a tag, a home and a key a slot.

// A pixel that has found no voxel in a full table has none.
const NO_SLOT: u32 = 0xFFFFFFFFu;
const MAX_PROBES: u32 = 128u;
