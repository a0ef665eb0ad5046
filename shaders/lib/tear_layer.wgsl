// The tear film as it lies over the eye since the lids last opened: how thick its lipid is from place to place, how its
// surface is tilted, and where it has broken. Head frame, millimetres, seconds. Twin: src/appearance/shading/tear_layer.rs.

struct TearLayer { lipid_nm: f32, tilt: vec2f, broken: f32 };

// How long the lipid drifts up after a blink.
const TEAR_DRIFT_S: f32 = 1.05;
// How much thicker and thinner than its mean the lipid is, as a share.
const LIPID_WAVES: f32 = 0.35;
// How far the surface of a settled film is tilted (rad), and how many times that more one that was just laid down.
const TEAR_TILT: f32 = 0.0016;
const TEAR_FRESH_TILT: f32 = 4.0;
const TEAR_CALMS_S: f32 = 0.35;

// Age (s) of the film in the tag of a globe's mesh, whose other half is the pupil.
fn tear_age(tag: u32) -> f32 {
    let code = f32(tag >> 16u) / 65535.0;
    return 0.25 * (exp(6.0 * code) - 1.0);
}

// How far up (mm) the lipid has drifted.
fn tear_drift(age: f32) -> f32 {
    let t = clamp(age, 1e-3, TEAR_DRIFT_S);
    return 2.25 * t * (1.0 + log(TEAR_DRIFT_S / t));
}

// The film at a place of this age, whose lipid is so thick in the mean and which begins to break after so long (s); `own` (rad) makes
// its waves those of this eye.
fn tear_layer(place: vec2f, age: f32, lipid_nm: f32, breakup_s: f32, own: f32) -> TearLayer {
    let q = vec2f(place.x, place.y - tear_drift(age));
    let warp = vec2f(sin(0.9 * q.y + own), sin(0.7 * q.x - 1.7 * own));
    let along = 1.3 * q.x + 0.6 * q.y + 0.9 * warp.x + own;
    let across = 2.1 * q.y - 0.8 * q.x + 1.1 * warp.y + 2.0 * own;
    let small = 3.7 * q.x + 2.9 * q.y + 1.5 * (warp.x + warp.y);
    let waves = 0.45 * sin(along) + 0.35 * sin(across) + 0.2 * sin(small);
    let fresh = TEAR_TILT * (1.0 + TEAR_FRESH_TILT * exp(-age / TEAR_CALMS_S));
    // The thinnest places break first, where they stand.
    let thin = 0.5 + 0.3 * sin(1.9 * place.x + 1.3 * warp.y + own) + 0.2 * sin(2.7 * place.y - 0.9 * place.x + 3.0 * own);
    let breaks = breakup_s * (1.0 + 2.5 * thin);
    let broken = smoothstep(1.0, 1.25, age / max(breaks, 0.1));
    return TearLayer(lipid_nm * (1.0 + LIPID_WAVES * waves) * (1.0 - broken), fresh * vec2f(cos(along), cos(across)), broken);
}

// How far (rad) the surface spreads what it mirrors where the film has broken: the cornea's own is rough.
const BROKEN_BLUR: f32 = 0.16;
