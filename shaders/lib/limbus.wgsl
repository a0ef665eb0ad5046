// needs: knots.wgsl
//
// The limbus, where the cornea goes over into the sclera. Twin: src/appearance/shading/limbus.rs.

// How far within and beyond the limbus' radius the sclera's lamellae fade over the cornea, mm.
const LIMBUS_WITHIN_MM: f32 = 0.4;
const LIMBUS_BEYOND_MM: f32 = 0.95;
// How far that is in all.
const LIMBUS_MM: f32 = LIMBUS_WITHIN_MM + LIMBUS_BEYOND_MM;

// Share of the cornea (1 inside, 0 outside) at distance `r` from the axis: it ends softly.
fn limbus_share(r: f32, limbus_radius: f32) -> f32 {
    return smoothstep(limbus_radius + LIMBUS_BEYOND_MM, limbus_radius - LIMBUS_WITHIN_MM, r);
}

// The surface's normal there: the globe's outside, the cornea's own from a third of the way in.
fn limbus_normal(globe: vec3f, cornea: vec3f, share: f32) -> vec3f {
    return normalize(mix(globe, cornea, smoothstep(0.0, 0.35, share)));
}

// Between which knots of the lamellae's tables, of what they do at the squares of even shares of their thickness, this share of it
// lies; the last knot is all of the sclera.
fn lamellae_knot(share: f32) -> Knot {
    return knot_at(sqrt(clamp(share, 0.0, 1.0)), 8);
}

// How much of the white's colour is seen where lamellae send this back and all of the sclera `whole`.
fn limbus_white(reflected: vec3f, whole: vec3f) -> vec3f {
    return reflected / max(whole, vec3f(1e-3));
}

// How much of what lies behind the cornea is lit and seen where lamellae pass this and all of the sclera `whole`: nothing of it
// there.
fn limbus_through(passed: vec3f, whole: vec3f) -> vec3f {
    let kept = (passed - whole) / max(vec3f(1.0) - whole, vec3f(1e-3));
    return kept * kept;
}

// How far from the axis a place counts as being where the transition is `width` mm wide and not LIMBUS_MM.
fn limbus_place(r: f32, limbus_radius: f32, width: f32) -> f32 {
    return limbus_radius + (r - limbus_radius) * (LIMBUS_MM / max(width, 1e-3));
}

// Share of the cornea's own shape where the transition is `width` mm wide: all of it where the cornea is clear, none from the limbus' radius on.
fn limbus_shaped(r: f32, limbus_radius: f32, width: f32) -> f32 {
    return smoothstep(limbus_radius, limbus_radius - LIMBUS_WITHIN_MM, limbus_place(r, limbus_radius, width));
}

// How much narrower the transition is where it is narrowest.
const LIMBUS_UNEVEN: f32 = 0.22;

// Width of the transition at a place (mm from the axis), against LIMBUS_MM: above and below the sclera goes further over the cornea, and here
// and there less far; `own` (rad) makes it that of this eye.
fn limbus_width(at: vec2f, own: f32) -> f32 {
    let sine = at.y / max(length(at), 1e-3);
    let broad = sin(1.1 * at.x + own) + sin(1.5 * at.y - 1.3 * own);
    let uneven = 0.5 + (broad + 0.6 * sin(2.9 * at.x + 1.7 * at.y + broad + 2.0 * own)) / 5.2;
    return limbus_widest(sine) * (1.0 - LIMBUS_UNEVEN * uneven);
}

// The most that it can be in this direction (`sine` of the angle to the horizontal).
fn limbus_widest(sine: f32) -> f32 {
    return 0.87 + 0.48 * sine * sine;
}

// What the lipid of an arcus scatters where it is densest, as a share of what all of the sclera's lamellae do.
const ARCUS_DENSEST: f32 = 0.3;

// Width (mm) of the clear rim about it.
const ARCUS_CLEAR_MM: f32 = 0.08;

// Density of the lipid of an arcus at a place of the cornea, `r` from the axis: a ring, sharp outwards and soft inwards, with a clear rim outside
// it, within the limbus of this `width` (`limbus_width`), which comes first and is broadest above and below and is as uneven as that limbus;
// `lipid` 0 to 1.
fn arcus_share(r: f32, sine: f32, limbus_radius: f32, lipid: f32, width: f32) -> f32 {
    let inside = limbus_radius - r - 0.85 * LIMBUS_WITHIN_MM * width;
    // 0 where that limbus is as wide as it can be there, 1 where it is narrowest.
    let lean = (1.0 - width / limbus_widest(sine)) / LIMBUS_UNEVEN;
    let wide = (0.5 + 0.6 * lipid) * (1.0 - 0.35 * lean) * (0.85 + 0.25 * sine * sine);
    let ring = smoothstep(ARCUS_CLEAR_MM, ARCUS_CLEAR_MM + 0.25, inside) * (1.0 - smoothstep(ARCUS_CLEAR_MM + 0.35 * wide, wide + 0.6, inside));
    let there = mix(0.65 * smoothstep(0.15, 0.85, lipid), smoothstep(0.0, 0.5, lipid), sine * sine);
    return ring * there * (1.0 - 0.3 * lean);
}
