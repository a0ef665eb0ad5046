// The limbus, where the cornea goes over into the sclera. Twin: src/appearance/shading/limbus.rs.

// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
fn limbus_share(r: f32, limbus_radius: f32) -> f32 {
    return smoothstep(limbus_radius + 0.27, limbus_radius - 0.63, r);
}

// The surface's normal there: the globe's outside, the cornea's own from a third of the way in.
fn limbus_normal(globe: vec3f, cornea: vec3f, share: f32) -> vec3f {
    return normalize(mix(globe, cornea, smoothstep(0.0, 0.35, share)));
}

// What lamellae do where this share of their thickness lies over the cornea; `table` has it at the squares of even steps.
fn limbus_lamellae(table: array<vec4<f32>, 8>, share: f32) -> vec3f {
    var values = table;
    let place = sqrt(clamp(share, 0.0, 1.0)) * 7.0;
    let below = min(i32(place), 6);
    return mix(values[below].rgb, values[below + 1].rgb, place - f32(below));
}

// How much of the white's colour is seen there: all of it where all of the sclera is.
fn limbus_white(reflects: array<vec4<f32>, 8>, share: f32) -> vec3f {
    return limbus_lamellae(reflects, share) / max(reflects[7].rgb, vec3f(1e-3));
}

// How much of what lies behind the cornea: lit and seen through the lamellae, and nothing of it where all of the sclera is.
fn limbus_through(passes: array<vec4<f32>, 8>, share: f32) -> vec3f {
    let last = passes[7].rgb;
    let kept = (limbus_lamellae(passes, share) - last) / max(vec3f(1.0) - last, vec3f(1e-3));
    return kept * kept;
}

// How far from the axis a place counts as being where the transition is `width` mm wide and not 0.9.
fn limbus_place(r: f32, limbus_radius: f32, width: f32) -> f32 {
    return limbus_radius + (r - limbus_radius) * (0.9 / max(width, 1e-3));
}

// Width of the transition where a place lies in this direction (`sine` of the angle to the horizontal), against 0.9 mm: above and
// below the sclera goes further over the cornea.
fn limbus_width(sine: f32) -> f32 {
    return 0.87 + 0.48 * sine * sine;
}

// What the lipid of an arcus scatters where it is densest, as a share of what all of the sclera's lamellae do.
const ARCUS_DENSEST: f32 = 0.3;

// Density of the lipid of an arcus at a place of the cornea, `r` from the axis: a ring with a clear rim outside it, which comes
// first above and below; `lipid` 0 to 1.
fn arcus_share(r: f32, sine: f32, limbus_radius: f32, lipid: f32) -> f32 {
    let inside = limbus_radius - r;
    let wide = 0.7 + 1.3 * lipid;
    let ring = smoothstep(-0.05, 0.4, inside) * smoothstep(wide + 0.7, 0.35 * wide, inside);
    let there = mix(0.65 * smoothstep(0.15, 0.85, lipid), smoothstep(0.0, 0.5, lipid), sine * sine);
    return ring * there;
}
