// FAST-9/16 corners of the view: strengths, then their histogram, then the list of the best.

@group(0) @binding(1) var<storage, read> luma: array<u32>;
@group(0) @binding(2) var<storage, read_write> strengths: array<u32>;
// 0: listed; 1: corners after suppression; 2: lowest score listed; 4..=259: corners by score.
@group(0) @binding(3) var<storage, read_write> feature_counters: array<atomic<u32>, 260>;
// x, y, score, bits of the vergence in D.
@group(0) @binding(4) var<storage, read_write> candidates: array<vec4<u32>>;
@group(0) @binding(5) var view_vergence: texture_2d<f32>;

const FAST_RING = array<vec2<i32>, 16>(
    vec2<i32>(0, -3), vec2<i32>(1, -3), vec2<i32>(2, -2), vec2<i32>(3, -1),
    vec2<i32>(3, 0), vec2<i32>(3, 1), vec2<i32>(2, 2), vec2<i32>(1, 3),
    vec2<i32>(0, 3), vec2<i32>(-1, 3), vec2<i32>(-2, 2), vec2<i32>(-3, 1),
    vec2<i32>(-3, 0), vec2<i32>(-3, -1), vec2<i32>(-2, -2), vec2<i32>(-1, -3),
);

fn inside_margin(pixel: vec2<u32>) -> bool {
    return all(pixel >= vec2<u32>(3u)) && all(pixel + 3u < percept.size);
}

// Strength of every pixel that is a corner at the threshold, 0 elsewhere.
@compute @workgroup_size(8, 8)
fn fast_strength(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let at = pixel.y * percept.size.x + pixel.x;
    var strength = 0u;
    if inside_margin(pixel) {
        let centre = i32(luma[at]);
        var ring = FAST_RING;
        var difference: array<i32, 16>;
        for (var k = 0u; k < 16u; k++) {
            let place = vec2<i32>(pixel) + ring[k];
            difference[k] = i32(luma[u32(place.y) * percept.size.x + u32(place.x)]) - centre;
        }
        strength = fast_strength_of(difference);
    }
    strengths[at] = select(0u, strength, strength > percept.fast_threshold);
}

// Score is strength minus one, and a non-corner's is 0.
fn score_at(pixel: vec2<u32>) -> u32 {
    return max(strengths[pixel.y * percept.size.x + pixel.x], 1u) - 1u;
}

// A corner whose score is strictly above all eight neighbours'.
fn is_suppressed_maximum(pixel: vec2<u32>) -> bool {
    if !inside_margin(pixel) || strengths[pixel.y * percept.size.x + pixel.x] == 0u {
        return false;
    }
    let score = score_at(pixel);
    for (var k = 0u; k < 9u; k++) {
        if k != 4u && score_at(pixel + vec2<u32>(k % 3u, k / 3u) - 1u) >= score {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(8, 8)
fn count_corners(@builtin(global_invocation_id) id: vec3<u32>) {
    if is_suppressed_maximum(id.xy) {
        atomicAdd(&feature_counters[1], 1u);
        atomicAdd(&feature_counters[4u + min(score_at(id.xy), 255u)], 1u);
    }
}

var<workgroup> lowest_score: u32;

// Lists every corner at or above the lowest score whose corners, with all better ones, fit: the
// same set as a higher threshold gives, so the list never depends on the order of execution.
@compute @workgroup_size(8, 8)
fn append_corners(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    if local == 0u {
        var score = 256u;
        var listed = 0u;
        while score > 0u {
            listed += atomicLoad(&feature_counters[3u + score]);
            if listed > percept.candidate_capacity {
                break;
            }
            score -= 1u;
        }
        lowest_score = score;
    }
    workgroupBarrier();
    if all(id.xy == vec2<u32>(0u)) {
        atomicStore(&feature_counters[2], lowest_score);
    }
    if is_suppressed_maximum(id.xy) && score_at(id.xy) >= lowest_score {
        let at = atomicAdd(&feature_counters[0], 1u);
        if at < percept.candidate_capacity {
            let vergence = textureLoad(view_vergence, id.xy, 0).x;
            candidates[at] = vec4<u32>(id.xy, score_at(id.xy), bitcast<u32>(vergence));
        }
    }
}
