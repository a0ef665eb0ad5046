// The light that falls on an eye: lamps, and what surrounds it. Head frame: x to the patient's right, y up,
// the face looks along -z. Twin: src/appearance/shading/surroundings.rs.

struct Lamp {
    // Unit direction towards it.
    direction: vec3<f32>,
    // Its angular radius (rad).
    radius: f32,
    // Irradiance / pi across its beam, linear sRGB.
    color: vec3<f32>,
    // What it is mirrored as: a disc (0), a ring whose hole has this share of its radius (to 1), or nothing,
    // as it stands in the map of the surroundings (-1).
    hole: f32,
    // One over its distance from where its direction is taken, the globe's centre (1/mm); 0 far away.
    vergence: f32,
};

// The lamp as it is from the place p (mm) of the frame of its direction: nearer to it, brighter and wider; its vergence is the one
// there.
fn lamp_from(lamp: Lamp, p: vec3<f32>) -> Lamp {
    let towards = lamp.direction - lamp.vergence * p;
    // Nothing comes nearer to a lamp than to a hundredth of its distance.
    let nearer = inverseSqrt(max(dot(towards, towards), 1e-4));
    return Lamp(towards * nearer, lamp.radius * nearer, lamp.color * (nearer * nearer), lamp.hole, lamp.vergence * nearer);
}

struct Illumination {
    lamps: array<Lamp, 8>,
    // Irradiance / pi from the surroundings without the lamps, by the normal n: the factors of 1, y, z, x, xy,
    // yz, 3zz - 1, xz and xx - yy.
    ambient: array<vec4<f32>, 9>,
    // Irradiance / pi of the lids' edges, lamps and all.
    lids_lit: vec3<f32>,
    exposure: f32,
    // 1 where the camera's exposure is still to come.
    is_luminance: f32,
};

// Place in the map of the surroundings, the equal-area azimuthal projection about the direction of the
// face: what is straight behind lies all around its rim.
fn surroundings_uv(d: vec3<f32>) -> vec2<f32> {
    let half_cosine = sqrt(max(0.5 * (1.0 - d.z), 1e-4));
    return 0.5 + vec2<f32>(0.25, -0.25) * d.xy / half_cosine;
}

// Radiance from the unit direction d; `blur` (rad) is what the mirror's roughness spreads it over.
fn surroundings_radiance(map: texture_2d<f32>, linear: sampler, d: vec3<f32>, blur: f32) -> vec3<f32> {
    // A texel of the map is 4 rad over its side wide.
    let level = log2(max(0.5 * blur * f32(textureDimensions(map).x), 1.0));
    let below = floor(level);
    let uv = surroundings_uv(d);
    let fine = textureSampleLevel(map, linear, uv, below).rgb;
    let coarse = textureSampleLevel(map, linear, uv, below + 1.0).rgb;
    return mix(fine, coarse, level - below);
}

// Radiance over irradiance / pi of a round lamp of angular radius `radius` about `direction`.
fn round_lamp(d: vec3<f32>, direction: vec3<f32>, radius: f32, blur: f32) -> f32 {
    let edge = max(blur, 0.02);
    // The chord for the angle: an arc cosine is coarse where lamps are small.
    let angle = length(d - direction);
    // A lamp is at least as wide as its edge, and the edge adds a fifth of its square: the light stays
    // what it was.
    let wide = max(radius, edge);
    return smoothstep(wide + edge, wide - edge, angle) / (wide * wide + 0.2 * edge * edge);
}

// Share of the unit direction d that does not lead back into the head itself.
fn past_head(d: vec3<f32>) -> f32 {
    return smoothstep(-0.05, 0.25, 0.25 - d.z);
}

// Radiance of a lamp by itself from the unit direction d.
fn lamp_radiance(lamp: Lamp, d: vec3<f32>, blur: f32) -> vec3<f32> {
    // No branch hangs on uniforms alone: lavapipe puts their values into the code and compiles it anew
    // for each draw, 12 ms a frame of the eye.
    let hole = clamp(lamp.hole, 0.0, 0.95);
    let kept = 1.0 - hole * hole;
    let whole = round_lamp(d, lamp.direction, lamp.radius, blur);
    let inner = round_lamp(d, lamp.direction, hole * lamp.radius, blur) * (hole * hole);
    // Blurred more than it is wide, a hole is no more.
    let seen = max(whole - inner * step(blur, hole * lamp.radius), 0.0) / mix(1.0, kept, step(blur, hole * lamp.radius));
    return lamp.color * (seen * step(-0.5, lamp.hole));
}

// Irradiance / pi from the surroundings on a surface of normal n, never negative.
fn ambient_light(ambient: array<vec4<f32>, 9>, n: vec3<f32>) -> vec3<f32> {
    var sum = ambient[0].rgb + ambient[1].rgb * n.y + ambient[2].rgb * n.z + ambient[3].rgb * n.x;
    sum += ambient[4].rgb * (n.x * n.y) + ambient[5].rgb * (n.y * n.z) + ambient[6].rgb * (3.0 * n.z * n.z - 1.0);
    sum += ambient[7].rgb * (n.x * n.z) + ambient[8].rgb * (n.x * n.x - n.y * n.y);
    return max(sum, vec3<f32>(0.0));
}

// Mean cosine of a lamp over a surface that bends light around its terminator by `wrap` (0: Lambert),
// never negative.
fn wrapped_cosine(cosine: f32, wrap: f32) -> f32 {
    let c = (cosine + wrap) / (1.0 + wrap);
    return max(c, 0.0) * max(c, 0.0) * 0.35 + max(c, 0.0) * 0.65;
}

// The same by channel: light that travels under the surface, red furthest.
fn wrapped_cosines(cosine: f32, wrap: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(wrapped_cosine(cosine, wrap.r), wrapped_cosine(cosine, wrap.g), wrapped_cosine(cosine, wrap.b));
}
