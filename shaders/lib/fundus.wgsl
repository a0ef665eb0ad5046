// The red reflex: a lamp's light that the fundus sends back through the pupil. Twin: src/appearance/shading/fundus.rs.

// From the eye's second nodal point to its retina (Gullstrand), mm.
const FUNDUS_DISTANCE_MM: f32 = 16.7;
// Index of the vitreous: radiance is less by its square outside.
const FUNDUS_INDEX: f32 = 1.336;
// How far light spreads in the fundus, rad in front of the eye.
const FUNDUS_SPREAD: f32 = 0.005;

// A power vector (M, J0, J45) times a place.
fn power_times(power: vec3f, place: vec2f) -> vec2f {
    return vec2f((power.x + power.y) * place.x + power.z * place.y, power.z * place.x + (power.x - power.y) * place.y);
}

// Light on the fundus `off` (rad) from the middle of a lamp of angular radius `radius` for which the eye is `blur` (1/mm, a power
// vector) out of focus, over all of it, per steradian before the eye; `pupil` is the entrance pupil's radius (mm).
fn fundus_lit(off: vec2f, radius: f32, blur: vec3f, pupil: f32) -> f32 {
    let x = power_times(blur, vec2f(pupil, 0.0));
    let y = power_times(blur, vec2f(0.0, pupil));
    let soft = radius * radius + FUNDUS_SPREAD * FUNDUS_SPREAD;
    let xx = dot(x, x) + soft;
    let yy = dot(y, y) + soft;
    let xy = dot(x, y);
    let area = max(xx * yy - xy * xy, 1e-12);
    let from_middle = sqrt(max(yy * off.x * off.x - 2.0 * xy * off.x * off.y + xx * off.y * off.y, 0.0) / area);
    let edge = clamp(2.0 * FUNDUS_SPREAD / sqrt(sqrt(area)), 0.02, 0.9);
    let lit = smoothstep(1.0 + edge, 1.0 - edge, from_middle) / (1.0 + 0.2 * edge * edge);
    return lit / (3.14159265 * sqrt(area));
}

// Radiance through a place (mm, from its middle) of an entrance pupil of radius `pupil` (mm), towards the unit direction
// `towards`, of light from `light` (unit): over its irradiance / pi, for a fundus that sends back all. `radius` is the lamp's
// (rad), `hole` the share of it that is dark, `vergence` one over its distance (1/mm), `focus` the vergence for which the eye is
// in focus now (1/mm, a power vector). Eye frame: x to the patient's right, y up.
fn fundus_reflex(light: vec3f, radius: f32, hole: f32, vergence: f32, towards: vec3f, place: vec2f, focus: vec3f, pupil: f32) -> f32 {
    // Where on the retina the view ends, as a direction before the eye.
    let off = light.xy - (towards.xy - power_times(focus, place));
    let blur = focus + vec3f(vergence, 0.0, 0.0);
    let dark = clamp(hole, 0.0, 0.95);
    let inner = dark * dark * fundus_lit(off, dark * radius, blur, pupil);
    let lit = max(fundus_lit(off, radius, blur, pupil) - inner, 0.0) / (1.0 - dark * dark);
    let share = pupil / (FUNDUS_DISTANCE_MM * FUNDUS_INDEX);
    return 3.14159265 * share * share * lit * max(-light.z, 0.0);
}
