// The sharpness field: find each pixel's voxel once a view, then one atomicMin a pixel a frame.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> pixel_slot: array<u32>;
@group(0) @binding(3) var<storage, read_write> voxel_tag: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> voxel_home: array<u32>;
@group(0) @binding(5) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
// 0: voxels in the table; 1: insertions that found no free slot.
@group(0) @binding(6) var<storage, read_write> table_counters: array<atomic<u32>, 4>;
@group(0) @binding(7) var<storage, read_write> blur_px: array<f32>;
// Per 16 x 16 tile: largest blur diameter in pixels, largest vergence.
@group(0) @binding(8) var<storage, read_write> tile_near: array<vec2<f32>>;
@group(0) @binding(9) var<storage, read> voxel_tag_old: array<u32>;
@group(0) @binding(10) var<storage, read> voxel_home_old: array<u32>;
@group(0) @binding(11) var<storage, read> sharpness_keys_old: array<u32>;
#ifdef FIELD_LOSS
@group(0) @binding(12) var visual_field: texture_2d<f32>;
#endif
@group(0) @binding(13) var<storage, read> movers: Movers;

// A thing that has moved: what was seen of it is kept where it was before it ever moved, under its own
// name. Columns are rows: a point (m from the field's origin, 1) times them is the mapped one. Keep in
// sync with src/percept/movers.rs.
struct Mover {
    own: mat3x4<f32>,     // into its own frame, where its box is
    rest: mat3x4<f32>,    // to where it was
    center: vec3<f32>,    // of its box
    name: u32,            // from 1
    half_size: vec3<f32>, // of its box
    is_new: u32,          // 1: what was seen of it stands under no name yet
};

struct Movers {
    count: u32,
    unused: vec3<u32>,
    list: array<Mover>,   // smaller ones first
};

const NO_SLOT: u32 = 0xFFFFFFFFu;
const MAX_PROBES: u32 = 128u;

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

// The thing that has moved to where a point is, by its place in the list; their number where there is none.
fn mover_at(point: vec3<f32>) -> u32 {
    for (var k = 0u; k < movers.count; k++) {
        let off = vec4<f32>(point, 1.0) * movers.list[k].own - movers.list[k].center;
        if all(abs(off) <= movers.list[k].half_size) {
            return k;
        }
    }
    return movers.count;
}

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

fn ray_of(pixel: vec2<u32>) -> vec3<f32> {
    let tan_half_fov = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    return view_ray(vec2<f32>(pixel) + 0.5, vec2<f32>(percept.size), tan_half_fov);
}

// Unit direction of a pixel in the world.
fn direction_of(pixel: vec2<u32>) -> vec3<f32> {
    let ray = ray_of(pixel);
    return ray.x * percept.right + ray.y * percept.up + ray.z * percept.back;
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

// Blur of a pixel at this moment, rad: defocus, retina, and what disease adds.
fn blur_now(pixel: vec2<u32>) -> f32 {
    let ray = ray_of(pixel);
    let vergence = textureLoad(view_vergence, pixel, 0).x;
    let eccentricity = angle_between(ray, percept.fixation);
    let defocus = defocus_blur_angle(percept.pupil_m, vergence, percept.focus_vergence_d, percept.refraction_d);
    var neural = neural_blur(eccentricity, percept.neural_floor_rad, percept.eccentricity_e2_rad);
#ifdef FIELD_LOSS
    neural += percept.eccentricity_penalty * eccentricity;
    let seen = seen_fraction(visual_field, perimetric_angles(ray, percept.fixation));
    neural = combined_blur(neural, (1.0 - seen) * percept.loss_blur_rad);
#endif
    return min(combined_blur(defocus, neural), percept.coc_cap_rad);
}

@compute @workgroup_size(8, 8)
fn update_field(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let slot = pixel_slot[pixel.y * percept.size.x + pixel.x];
    if slot != NO_SLOT {
        atomicMin(&sharpness_keys[slot], sharpness_key_encode(blur_now(pixel), percept.starve_steps, percept.epoch));
    }
}

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
        var coc = sharpness_key_decode(key, percept.starve_steps, percept.epoch, percept.coc_cap_rad);
#ifdef FIELD_LOSS
        // What is lost now is filled in from its surround, whatever memory holds.
        let seen = seen_fraction(visual_field, perimetric_angles(ray_of(pixel), percept.fixation));
        coc = combined_blur(coc, (1.0 - seen) * percept.loss_blur_rad);
#endif
        let diameter = coc * percept.pixels_per_radian;
        blur_px[at] = diameter;
        // Non-negative floats order as their bits do.
        atomicMax(&tile_blur, bitcast<u32>(diameter));
        atomicMax(&tile_vergence, bitcast<u32>(textureLoad(view_vergence, pixel, 0).x));
    }
    workgroupBarrier();
    if local == 0u {
        tile_near[tile.y * tiles.x + tile.x] =
            vec2<f32>(bitcast<f32>(atomicLoad(&tile_blur)), bitcast<f32>(atomicLoad(&tile_vergence)));
    }
}
