// The limbus, where the cornea goes over into the sclera. Twin: src/appearance/shading/limbus.rs.

// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
fn limbus_share(r: f32, limbus_radius: f32) -> f32 {
    return smoothstep(limbus_radius + 0.27, limbus_radius - 0.63, r);
}

// The surface's normal there: the globe's outside, the cornea's own from a third of the way in.
fn limbus_normal(globe: vec3f, cornea: vec3f, share: f32) -> vec3f {
    return normalize(mix(globe, cornea, smoothstep(0.0, 0.35, share)));
}

// Tint of the blue-grey ring where the sclera thins over the dark angle.
fn limbus_tint(share: f32) -> vec3f {
    let ring = share * (1.0 - share) * 4.0;
    return mix(vec3f(1.0), vec3f(0.62, 0.66, 0.72), ring * 0.75);
}

// How far from the axis a place counts as being where the transition is `width` mm wide and not 0.9.
fn limbus_place(r: f32, limbus_radius: f32, width: f32) -> f32 {
    return limbus_radius + (r - limbus_radius) * (0.9 / max(width, 1e-3));
}

// Width of the transition where a place lies in this direction (`sine` of the angle to the horizontal), against 0.9 mm: above and
// below the sclera goes further over the cornea.
fn limbus_width(sine: f32) -> f32 {
    return 0.97 + 0.48 * sine * sine;
}

// What lipid in the cornea's rim sends back, linear sRGB, where it covers all.
const ARCUS_COLOR = vec3<f32>(0.62, 0.58, 0.47);

// Share of a place of the cornea, `r` from the axis, that an arcus covers: a ring with a clear rim outside it, which comes first
// above and below; `lipid` 0 to 1.
fn arcus_share(r: f32, sine: f32, limbus_radius: f32, lipid: f32) -> f32 {
    let inside = limbus_radius - r;
    let wide = 0.7 + 1.3 * lipid;
    let ring = smoothstep(-0.05, 0.4, inside) * smoothstep(wide + 0.7, 0.35 * wide, inside);
    let there = mix(0.65 * smoothstep(0.15, 0.85, lipid), smoothstep(0.0, 0.5, lipid), sine * sine);
    return 0.85 * ring * there;
}
