// Once a view from elsewhere: what the view before it saw of what lies in voxels in which nothing was seen yet. Far away a pixel is
// wider than a voxel, so that each step of a head, and each turn, finds others.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> pixel_slot: array<u32>;
@group(0) @binding(3) var<storage, read_write> voxel_tag: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
// The view before: its numbers and its vergences.
@group(0) @binding(5) var<uniform> before: PerceptUniform;
@group(0) @binding(6) var vergence_before: texture_2d<f32>;
// By pixel, the key that it is handed, or SHARPNESS_NEVER_SEEN.
@group(0) @binding(7) var<storage, read_write> carried: array<u32>;
// Slots of the pixels of the view before, in the table as it was then.
@group(0) @binding(8) var<storage, read> slot_before: array<u32>;

// How many pixels of the view before two places that count as one may lie apart, nearly all of it along the line of sight, as on a floor
// that is seen slantingly: of that view's pixels only those around the place are looked at.
const CARRY_PIXELS: f32 = 4.0;

// Place (pixels) of a direction of the world in the view before; far outside where that did not look.
fn place_before(direction: vec3<f32>) -> vec2<f32> {
    let away = -dot(direction, before.back);
    let aside = vec2<f32>(dot(direction, before.right), -dot(direction, before.up));
    let ndc = aside / (max(away, 1e-6) * vec2<f32>(before.tan_half_fov_x, before.tan_half_fov_y));
    return select(vec2<f32>(-1e6), (0.5 * ndc + 0.5) * vec2<f32>(before.size), away > 1e-6);
}

fn direction_before(pixel: vec2<u32>) -> vec3<f32> {
    let tan_half_fov = vec2<f32>(before.tan_half_fov_x, before.tan_half_fov_y);
    let ray = view_ray(vec2<f32>(pixel) + 0.5, vec2<f32>(before.size), tan_half_fov);
    return ray.x * before.right + ray.y * before.up + ray.z * before.back;
}

// Key with which a pixel of the view before lies in the table. In one that has grown since it is looked for where it lies in the world.
fn key_before(pixel: vec2<u32>) -> u32 {
    var slot = slot_before[pixel.y * before.size.x + pixel.x];
    if percept.table_slots_old > 0u {
        let vergence = textureLoad(vergence_before, pixel, 0).x;
        let voxel = sharpness_voxel(before.eye_m, direction_before(pixel), vergence, percept.voxel_size_m, percept.voxel_angle_rad);
        slot = find_slot(sharpness_voxel_hash(voxel));
    }
    if slot == NO_SLOT {
        return SHARPNESS_NEVER_SEEN;
    }
    return atomicLoad(&sharpness_keys[slot]);
}

// Looks up what is to be handed on. No key changes meanwhile, so that the order of pixels does not matter.
@compute @workgroup_size(8, 8)
fn carry_over(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let at = pixel.y * percept.size.x + pixel.x;
    carried[at] = SHARPNESS_NEVER_SEEN;
    let slot = pixel_slot[at];
    if slot == NO_SLOT {
        return;
    }
    let known = atomicLoad(&sharpness_keys[slot]);
    if known != SHARPNESS_NEVER_SEEN && known >> 28u == sharpness_epoch_bits(percept.epoch) >> 28u {
        return;
    }
    let direction = direction_of(pixel);
    let vergence = textureLoad(view_vergence, pixel, 0).x;
    let is_far = vergence < 1.0 / SHARPNESS_FAR_M;
    // By its distance, so that what two places are apart is an angle; of what is far, the direction alone.
    let scale = select(vergence, 0.0, is_far);
    let seen = direction + scale * (percept.eye_m - before.eye_m);
    let place = vec2<i32>(floor(place_before(normalize(seen))));
    // What is new at the border of a view was not seen.
    if any(place < vec2<i32>(0)) || any(place >= vec2<i32>(before.size)) {
        return;
    }
    var nearest = CARRY_PIXELS / before.pixels_per_radian;
    var best = vec2<i32>(-1);
    for (var k = 0; k < 9; k++) {
        let there = place + vec2<i32>(k % 3 - 1, k / 3 - 1);
        if any(there < vec2<i32>(0)) || any(there >= vec2<i32>(before.size)) {
            continue;
        }
        let own = textureLoad(vergence_before, there, 0).x;
        if (own < 1.0 / SHARPNESS_FAR_M) != is_far {
            continue;
        }
        let reach = select(scale / max(own, 1.0 / SHARPNESS_FAR_M), 1.0, is_far);
        let apart = distance(direction_before(vec2<u32>(there)) * reach, seen);
        if apart < nearest {
            nearest = apart;
            best = there;
        }
    }
    if best.x >= 0 {
        carried[at] = key_before(vec2<u32>(best));
    }
}

// Hands it on.
@compute @workgroup_size(8, 8)
fn take_carried(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let at = pixel.y * percept.size.x + pixel.x;
    let slot = pixel_slot[at];
    if slot != NO_SLOT && carried[at] != SHARPNESS_NEVER_SEEN {
        atomicMin(&sharpness_keys[slot], carried[at]);
    }
}
