// Once a view: a photograph with distances becomes the static view, from where it was taken, and from
// where the head has gone since.

// Where the view is in the photograph's frame (+x right, +y up, taken looking along -z from its origin).
// Keep in sync with src/percept/gpu_data.rs.
struct PhotoUniform {
    right: vec3<f32>,   // view +x
    has_moved: u32,     // 0: the view is the photograph's own
    up: vec3<f32>,      // view +y
    flat_m: f32,        // distance of all of it; 0: by its map
    back: vec3<f32>,    // view +z
    step_share: f32,    // of its distance, by how much a surface may step over one texel and still be one
    eye_m: vec3<f32>,   // the eye
    unused: f32,
};

@group(0) @binding(1) var photo_colour: texture_2d<f32>;
@group(0) @binding(2) var photo_vergence: texture_2d<f32>;
@group(0) @binding(6) var<uniform> photo: PhotoUniform;

// Nothing is farther; what is infinitely far stands here.
const FARTHEST_M: f32 = 1e9;
// The nearest and the farthest surface that is looked for, as vergences, and the steps between them. What is
// infinitely far lies beyond all of them.
const NEAREST_D: f32 = 20.0;
const FARTHEST_D: f32 = 1e-6;
const STEPS: u32 = 160u;
const HALVINGS: u32 = 10u;

// What a ray meets: at which distance from the eye (0: nothing), and where on the photograph, in texels
// (negative: what is there is not in the photograph).
struct Met {
    distance_m: f32,
    place: vec2<f32>,
};

// Where a point or direction is on the photograph, in texels; beside it where it lies behind.
fn place_of(point: vec3<f32>) -> vec2<f32> {
    let tan_half_fov = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let ahead = -point.z;
    if ahead <= 1e-4 * length(point) {
        return vec2<f32>(-1.0);
    }
    let ndc = point.xy / (ahead * tan_half_fov);
    return vec2<f32>(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * vec2<f32>(percept.size);
}

fn is_inside(place: vec2<f32>) -> bool {
    return all(place >= vec2<f32>(0.0)) && all(place < vec2<f32>(percept.size));
}

// Where nothing floats in the soft edge of a thing.
fn distance_at(place: vec2<f32>) -> f32 {
    let vergence = textureLoad(photo_vergence, vec2<i32>(floor(place)), 0).y;
    return 1.0 / max(vergence, 1.0 / FARTHEST_M);
}

// How far a point lies behind what the photograph shows in its direction; beside the photograph there is
// nothing.
fn depth_behind(point: vec3<f32>) -> f32 {
    let place = place_of(point);
    if !is_inside(place) {
        return -FARTHEST_M;
    }
    return length(point) - distance_at(place);
}

// Distance from the eye to where a ray leaves the sphere of this radius about where the photograph was taken
// or, from outside, enters it; 0: it does not.
fn sphere_distance(direction: vec3<f32>, radius: f32) -> f32 {
    let along = dot(photo.eye_m, direction);
    let inside = radius * radius - dot(photo.eye_m, photo.eye_m);
    let square = along * along + inside;
    // Who has stepped back out of it looks through its open side.
    if square <= 0.0 || (inside <= 0.0 && along >= 0.0) {
        return 0.0;
    }
    // Without the difference of two large numbers.
    let root = sqrt(square);
    return select(inside / (root + along), root - along, along < 0.0);
}

// All of it at one distance from where it was taken.
fn meet_sphere(direction: vec3<f32>, radius: f32) -> Met {
    let distance = sphere_distance(direction, radius);
    let place = place_of(photo.eye_m + distance * direction);
    return Met(select(0.0, distance, is_inside(place)), place);
}

// The first surface of its map that a ray meets from before. What goes in behind a nearer thing comes out
// again beside it, or is not in the photograph: then it is taken to be as far as what is seen beside that thing.
fn meet_map(direction: vec3<f32>) -> Met {
    var before_d = NEAREST_D;
    var before = depth_behind(photo.eye_m + direction / before_d);
    var hidden_m = 0.0;
    for (var k = 1u; k <= STEPS; k++) {
        let share = 1.0 - f32(k) / f32(STEPS);
        let at_d = max(NEAREST_D * share * share, FARTHEST_D);
        let behind = depth_behind(photo.eye_m + direction / at_d);
        if before < 0.0 && behind >= 0.0 {
            var near_d = before_d;
            var far_d = at_d;
            var near = before;
            var far = behind;
            for (var i = 0u; i < HALVINGS; i++) {
                let middle_d = 0.5 * (near_d + far_d);
                let middle = depth_behind(photo.eye_m + direction / middle_d);
                if middle < 0.0 {
                    near_d = middle_d;
                    near = middle;
                } else {
                    far_d = middle_d;
                    far = middle;
                }
            }
            let point = photo.eye_m + direction / far_d;
            if far - near <= photo.step_share * length(point) {
                return Met(1.0 / far_d, place_of(point));
            }
            let beside = place_of(photo.eye_m + direction / near_d);
            if hidden_m == 0.0 && is_inside(beside) {
                hidden_m = sphere_distance(direction, distance_at(beside));
            }
        }
        before_d = at_d;
        before = behind;
    }
    // What is infinitely far has only a direction.
    let place = place_of(direction);
    if before < 0.0 && is_inside(place) && distance_at(place) >= 0.5 * FARTHEST_M {
        return Met(FARTHEST_M, place);
    }
    return Met(hidden_m, vec2<f32>(-1.0));
}

// Colour between the texels that show the surface on which `place` lies, at this distance from where the
// photograph was taken: across its edge there is another one.
fn colour_between(place: vec2<f32>, from_m: f32) -> vec3<f32> {
    let last = vec2<i32>(percept.size) - 1;
    let low = place - 0.5;
    let corner = vec2<i32>(floor(low));
    let share = fract(low);
    var sum = vec4<f32>(0.0);
    for (var k = 0; k < 4; k++) {
        let off = vec2<i32>(k & 1, k >> 1u);
        let weights = select(1.0 - share, share, off == vec2<i32>(1));
        let texel = clamp(corner + off, vec2<i32>(0), last);
        let distance = distance_at(vec2<f32>(texel));
        if abs(distance - from_m) <= photo.step_share * max(distance, from_m) {
            let colour = safe_radiance(textureLoad(photo_colour, texel, 0).rgb);
            sum += weights.x * weights.y * vec4<f32>(colour, 1.0);
        }
    }
    if sum.a < 1e-3 {
        let own = clamp(vec2<i32>(floor(place)), vec2<i32>(0), last);
        return safe_radiance(textureLoad(photo_colour, own, 0).rgb);
    }
    return sum.rgb / sum.a;
}

fn direction_of(place: vec2<f32>) -> vec3<f32> {
    let tan_half_fov = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let ray = view_ray(place, vec2<f32>(percept.size), tan_half_fov);
    return ray.x * photo.right + ray.y * photo.up + ray.z * photo.back;
}

@compute @workgroup_size(8, 8)
fn capture_photo(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    if photo.has_moved == 0u {
        let colour = safe_radiance(textureLoad(photo_colour, pixel, 0).rgb);
        write_view(pixel, colour, textureLoad(photo_vergence, pixel, 0).x);
        return;
    }
    let centre = vec2<f32>(pixel) + 0.5;
    let direction = direction_of(centre);
    var met: Met;
    if photo.flat_m > 0.0 {
        met = meet_sphere(direction, photo.flat_m);
    } else {
        met = meet_map(direction);
    }
    if met.distance_m <= 0.0 {
        write_view(pixel, vec3<f32>(0.0), 0.0);
        return;
    }
    let vergence = select(1.0 / met.distance_m, 0.0, met.distance_m >= 0.5 * FARTHEST_M);
    if met.place.x < 0.0 {
        write_view(pixel, vec3<f32>(0.0), vergence);
        return;
    }
    // A pixel's light: the same surface in the directions of its quarters.
    var colour = vec3<f32>(0.0);
    let from_m = distance_at(met.place);
    for (var k = 0; k < 4; k++) {
        let quarter = 0.5 * vec2<f32>(f32(k & 1), f32(k >> 1u)) - 0.25;
        let place = place_of(photo.eye_m + met.distance_m * direction_of(centre + quarter));
        colour += 0.25 * colour_between(select(met.place, place, is_inside(place)), from_m);
    }
    write_view(pixel, colour, vergence);
}
