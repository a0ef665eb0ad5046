// What the eye's materials share: the vertex stage, the studio that lights
// the eye, and the lids' shadow. Entry files follow it.
//
// Spaces: local = millimetres with the globe's centre of rotation at the
// origin, y up, gaze along -z. The globe's mesh turns with gaze (its local
// space is the eye frame); skin and lashes do not (theirs is the head frame).

#import bevy_pbr::mesh_functions::{get_world_from_local, get_local_from_world, mesh_position_local_to_clip}
#import bevy_pbr::mesh_view_bindings::view

struct Studio {
    // Direction towards the window in the head frame; w: angular half-width of the window (rad).
    key_direction: vec4<f32>,
    // Irradiance / pi from the window, linear sRGB; w: exposure.
    key_color: vec4<f32>,
    fill_direction: vec4<f32>,
    fill_color: vec4<f32>,
    // Radiance of the surroundings from above and from below.
    ambient_up: vec4<f32>,
    ambient_down: vec4<f32>,
};

const LID_SAMPLES: i32 = 32;
const LID_HALF_SPAN_MM: f32 = 20.0;

struct Lids {
    // Heights (y, mm, head frame) of the lid margins at LID_SAMPLES places
    // from x = -LID_HALF_SPAN_MM to +LID_HALF_SPAN_MM, four to a vector.
    upper: array<vec4<f32>, 8>,
    lower: array<vec4<f32>, 8>,
};

struct VertexIn {
    @builtin(instance_index) instance: u32,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rest: vec4<f32>,
    @location(3) tissue: vec4<f32>,
};

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rest: vec3<f32>,
    @location(3) tissue: vec4<f32>,
    @location(4) @interpolate(flat) camera: vec3<f32>,
};

@vertex
fn vertex(in: VertexIn) -> Surface {
    var out: Surface;
    let world_from_local = get_world_from_local(in.instance);
    out.clip = mesh_position_local_to_clip(world_from_local, vec4(in.position, 1.0));
    out.position = in.position;
    out.normal = in.normal;
    out.rest = in.rest.xyz;
    out.tissue = in.tissue;
    out.camera = (get_local_from_world(in.instance) * vec4(view.world_position, 1.0)).xyz;
    return out;
}

// Size (mm) of a pixel's footprint at this distance (mm).
fn pixel_footprint(distance_mm: f32) -> f32 {
    return 2.0 * distance_mm / (view.clip_from_view[1][1] * view.viewport.w);
}

// Radiance that arrives from direction d: a room with a four-paned window
// (the key light), a smaller lamp (the fill) and soft surroundings.
// `blur` (rad) is the width of the edges: wide for rough surfaces.
fn studio_radiance(studio: Studio, d: vec3<f32>, blur: f32) -> vec3<f32> {
    let up = 0.5 + 0.5 * d.y;
    var radiance = mix(studio.ambient_down.rgb, studio.ambient_up.rgb, smoothstep(0.15, 0.85, up));
    let key = studio.key_direction.xyz;
    let right = normalize(cross(vec3(0.0, 1.0, 0.0), key));
    let above = cross(key, right);
    let along = dot(d, key);
    if along > 0.05 {
        let p = vec2(dot(d, right), dot(d, above)) / along;
        let half_size = vec2(0.72, 1.0) * studio.key_direction.w;
        let edge = max(blur, 0.008);
        let inside = smoothstep(vec2(edge), vec2(-edge), abs(p) - half_size);
        let bar = max(0.02, 0.07 * half_size.x);
        let panes = smoothstep(vec2(-edge), vec2(edge), abs(p) - vec2(bar));
        let coverage = inside.x * inside.y * mix(1.0, panes.x * panes.y, exp(-blur * 12.0));
        // The radiance of a window of this solid angle that gives the key's irradiance.
        let solid_angle = 4.0 * half_size.x * half_size.y;
        radiance += studio.key_color.rgb * (3.14159265 / solid_angle) * coverage * (0.75 + 0.25 * clamp(p.y / half_size.y, -1.0, 1.0));
    }
    let fill = dot(d, studio.fill_direction.xyz);
    let radius = studio.fill_direction.w;
    let fill_edge = max(blur, 0.02);
    let fill_angle = acos(clamp(fill, -1.0, 1.0));
    radiance += studio.fill_color.rgb / (radius * radius) * smoothstep(radius + fill_edge, radius - fill_edge, fill_angle);
    return radiance;
}

// Irradiance / pi from the surroundings without the two lamps on a surface of normal n.
fn studio_ambient(studio: Studio, n: vec3<f32>) -> vec3<f32> {
    return mix(studio.ambient_down.rgb, studio.ambient_up.rgb, 0.5 + 0.5 * n.y);
}

// Mean cosine of a lamp of angular half-width `half` over a surface that bends light
// around its terminator by `wrap` (0: Lambert), never negative.
fn wrapped_cosine(cosine: f32, wrap: f32) -> f32 {
    let c = (cosine + wrap) / (1.0 + wrap);
    return max(c, 0.0) * max(c, 0.0) * 0.35 + max(c, 0.0) * 0.65;
}

fn lid_height(heights: array<vec4<f32>, 8>, x: f32) -> f32 {
    var table = heights;
    let at = clamp((x + LID_HALF_SPAN_MM) / (2.0 * LID_HALF_SPAN_MM), 0.0, 1.0) * f32(LID_SAMPLES - 1);
    let i = min(i32(at), LID_SAMPLES - 2);
    let a = table[i / 4][i % 4];
    let b = table[(i + 1) / 4][(i + 1) % 4];
    return mix(a, b, at - f32(i));
}

struct LidShade { sky: f32, key: f32, upper_gap: f32, lower_gap: f32 };

// How much of the sky and of the key light the lids leave at a point p (head
// frame) of the globe: the upper lid and its lashes overhang, so that a soft
// band lies below its margin; the lower lid only touches.
fn lid_shade(lids: Lids, p: vec3<f32>) -> LidShade {
    let upper = lid_height(lids.upper, p.x) - p.y;
    let lower = p.y - lid_height(lids.lower, p.x);
    let u = max(upper, 0.0);
    let l = max(lower, 0.0);
    var shade: LidShade;
    shade.sky = (1.0 - 0.72 * exp(-u / 1.5)) * (1.0 - 0.5 * exp(-l / 0.8));
    shade.key = smoothstep(-0.4, 2.4, upper) * (1.0 - 0.4 * exp(-l / 0.5));
    shade.upper_gap = upper;
    shade.lower_gap = lower;
    return shade;
}
