// The upper lashes as what stands before the globe: a comb on a sheet that curls up before the lid. Head frame, millimetres.
// Twin: src/appearance/shading/lash_comb.rs.

// How much they rise (1/mm: their height over the margin is this times the square of how far they stand before it), how
// far they reach forward (mm), and how dark they are.
const LASH_CURL: f32 = 0.09;
const LASH_REACH_MM: f32 = 8.0;
const LASH_DARK: f32 = 0.8;
// Their comb, rad/mm, and the share of it that is lash.
const LASH_COMB: f32 = 19.0;
const LASH_SHARE: f32 = 0.29;

// How much steeper than the lowest ray that meets the sheet a ray rises where half of the lashes that it crosses are there: not every lash
// curls alike.
const LASH_EVEN: f32 = 0.45;

// How far before the lid (mm) half of them end.
const LASH_HALF_MM: f32 = 0.75 * LASH_REACH_MM;

// How steep the ray is, from a place `upper_gap` mm below the upper lid's margin, that half of the lashes that it crosses let pass: its rise
// for each unit forward. Steeper ones meet all of them.
fn lash_rise(upper_gap: f32) -> f32 {
    let gap = max(upper_gap, 0.0);
    return max(sqrt(4.0 * LASH_CURL * gap + LASH_EVEN), LASH_CURL * LASH_HALF_MM + gap / LASH_HALF_MM);
}

// Share of a ray in the unit direction r, from a place `x` mm aside and `upper_gap` mm below the upper lid's margin, that they let pass where
// it is blurred by `near` mm at the place and `far` mm for each millimetre that it goes forward: what is wider than the comb's teeth sees what
// they take in the mean.
fn lashes_left(x: f32, r: vec3f, upper_gap: f32, near: f32, far: f32) -> f32 {
    let forward = max(-r.z, 0.2);
    let rise = r.y / forward;
    let crosses = rise * rise - 4.0 * LASH_CURL * max(upper_gap, 0.0);
    let reach = (rise - sqrt(max(crosses, 0.0))) / (2.0 * LASH_CURL);
    let aside = x + r.x / forward * reach;
    let comb = sin(aside * LASH_COMB + 2.5 * sin(aside * 2.3) + 1.7 * sin(aside * 5.1));
    let turn = LASH_COMB * (near * (1.0 + abs(r.x) / forward * inverseSqrt(max(crosses, 0.01))) + far * reach);
    let tooth = mix(LASH_SHARE, smoothstep(0.3, 0.95, comb), exp(-turn * turn));
    let there = smoothstep(0.0, 2.0 * LASH_EVEN, crosses) * smoothstep(0.0, 0.3, rise) * (1.0 - smoothstep(0.5 * LASH_REACH_MM, LASH_REACH_MM, reach));
    return 1.0 - LASH_DARK * there * tooth;
}
