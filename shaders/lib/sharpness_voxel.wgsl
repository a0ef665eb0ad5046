// Where a seen point lies in the sharpness field. Twin: src/percept/field/sharpness_field.rs.
//
// Cells are cubes on one world-fixed grid. Uniform: side `voxel_size_m` (the paper's grid, but
// sparse). In proportion to distance: the side is the power of two (times `voxel_angle_rad`) that
// spans between a half and one `voxel_angle_rad` as seen from the field's origin, and the power is
// part of the cell's name. Points beyond `SHARPNESS_FAR_M` are named by direction.

const SHARPNESS_FAR_M: f32 = 1000.0;
const SHARPNESS_LEVEL_UNIFORM: i32 = 1000;
const SHARPNESS_LEVEL_SKY: i32 = 1001;

// Cell (xyz) and level (w) of a point (metres from the field's origin).
fn sharpness_voxel_at(point: vec3<f32>, voxel_size_m: f32, voxel_angle_rad: f32) -> vec4<i32> {
    if voxel_size_m > 0.0 {
        return vec4<i32>(vec3<i32>(floor(point / voxel_size_m)), SHARPNESS_LEVEL_UNIFORM);
    }
    let level = i32(floor(log2(max(length(point), 1e-4))));
    let side = voxel_angle_rad * exp2(f32(level));
    return vec4<i32>(vec3<i32>(floor(point / side)), level);
}

// Cell (xyz) and level (w) of the point at `vergence_per_m` along the unit world direction
// `direction`, seen from `eye_m` (metres from the field's origin).
fn sharpness_voxel(
    eye_m: vec3<f32>,
    direction: vec3<f32>,
    vergence_per_m: f32,
    voxel_size_m: f32,
    voxel_angle_rad: f32,
) -> vec4<i32> {
    if vergence_per_m < 1.0 / SHARPNESS_FAR_M {
        return vec4<i32>(vec3<i32>(floor(direction / voxel_angle_rad)), SHARPNESS_LEVEL_SKY);
    }
    return sharpness_voxel_at(eye_m + direction / vergence_per_m, voxel_size_m, voxel_angle_rad);
}

// Finaliser of MurmurHash3: every input bit reaches every output bit.
fn sharpness_mix(word: u32) -> u32 {
    var h = word;
    h = (h ^ (h >> 16u)) * 0x85EBCA6Bu;
    h = (h ^ (h >> 13u)) * 0xC2B2AE35u;
    return h ^ (h >> 16u);
}

// Two independent 32-bit names of a cell: x its tag (never 0, which marks a free slot), y the hash
// whose low bits are its home slot. Two cells are confused only when the tags agree and the homes
// fall within one probe run: about n^2 / 2^51 for n cells, 6e-6 for a hundred thousand.
fn sharpness_voxel_hash(voxel: vec4<i32>) -> vec2<u32> {
    let v = bitcast<vec4<u32>>(voxel);
    var tag = 0x9E3779B9u;
    var home = 0x7F4A7C15u;
    for (var i = 0u; i < 4u; i++) {
        tag = sharpness_mix(tag ^ v[i]) + 0x632BE5ABu;
        home = sharpness_mix(home + v[i] * 0x2C1B3C6Du) ^ 0x297A2D39u;
    }
    return vec2<u32>(max(tag, 1u), home);
}
