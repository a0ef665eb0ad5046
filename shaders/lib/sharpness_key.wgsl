// The sharpness field's ordered key. Twin: src/percept/field/sharpness_field.rs.
//
// A voxel seen with a circle of confusion c0 (rad) when the starvation R(t) = integral of r dt stood
// at R0 has c(t) = c0 exp(R(t) - R0) ever after, so ln c0 - R0 alone orders voxels by sharpness at
// every later time. The key is that number in steps of 1/4096 (0.0244 % of blur), as an unsigned
// integer whose order is the order of sharpness, below the inverted blink epoch in the top four bits:
// a newer epoch is always the smaller key, so one atomicMin does both the update and the reset. Below
// it, in the last seven bits, rides how long the blur was for its width (see `astigmatic_blur`).

const SHARPNESS_STEPS_PER_NAT: f32 = 4096.0;
// ln(1e-6 rad) and ln(e^(65535/4096) * 1e-6 rad) bound what a key can say.
const SHARPNESS_LN_MIN: f32 = -13.815510558;
const SHARPNESS_LN_STEPS_MAX: f32 = 65535.0;
// Starvation that one epoch can hold, in steps: 495 nats, 14 minutes at 0.6 per second.
const SHARPNESS_STARVE_STEPS_MAX: u32 = 2030000u;
const SHARPNESS_VALUE_MAX: u32 = 0x1FFFFEu;
const SHARPNESS_NEVER_SEEN: u32 = 0xFFFFFFFFu;
const SHARPNESS_EPOCH_MAX: u32 = 15u;
// Steps of a right angle in which the elongation's arcsine is kept, around the code of a disc.
const SHARPNESS_ELONGATION_STEPS: f32 = 63.0;
const SHARPNESS_DISC: u32 = 64u;

fn sharpness_epoch_bits(epoch: u32) -> u32 {
    return (SHARPNESS_EPOCH_MAX - min(epoch, SHARPNESS_EPOCH_MAX)) << 28u;
}

// Seven bits for an elongation (-1 to 1), by its arcsine.
fn elongation_encode(elongation: f32) -> u32 {
    let turn = asin(clamp(elongation, -1.0, 1.0)) * (SHARPNESS_ELONGATION_STEPS / 1.57079633);
    return u32(floor(turn + 0.5) + f32(SHARPNESS_DISC));
}

fn elongation_decode(code: u32) -> f32 {
    return sin((f32(code) - f32(SHARPNESS_DISC)) * (1.57079633 / SHARPNESS_ELONGATION_STEPS));
}

// Key of a circle of confusion `coc_rad` of this elongation (-1 to 1) seen now, R(now) being
// `starve_steps` steps.
fn sharpness_key_encode(coc_rad: f32, elongation: f32, starve_steps: u32, epoch: u32) -> u32 {
    let ln_steps = (log(max(coc_rad, 1e-6)) - SHARPNESS_LN_MIN) * SHARPNESS_STEPS_PER_NAT;
    let value = u32(clamp(ln_steps + 0.5, 0.0, SHARPNESS_LN_STEPS_MAX))
        + (SHARPNESS_STARVE_STEPS_MAX - min(starve_steps, SHARPNESS_STARVE_STEPS_MAX));
    return sharpness_epoch_bits(epoch) | value << 7u | elongation_encode(elongation);
}

// Circle of confusion (rad) now of a voxel with this key, at most `cap_rad`; the cap itself for a
// voxel not seen since the last blink.
fn sharpness_key_decode(key: u32, starve_steps: u32, epoch: u32, cap_rad: f32) -> f32 {
    let value = (key >> 7u) & 0x1FFFFFu;
    let remaining = SHARPNESS_STARVE_STEPS_MAX - min(starve_steps, SHARPNESS_STARVE_STEPS_MAX);
    let seen = key >> 28u == sharpness_epoch_bits(epoch) >> 28u && value <= SHARPNESS_VALUE_MAX;
    // 81,920 steps are 500 rad: beyond any cap, and exp() stays finite.
    let ln_steps = f32(clamp(i32(value) - i32(remaining), 0, 81920));
    let coc = exp(ln_steps / SHARPNESS_STEPS_PER_NAT + SHARPNESS_LN_MIN);
    return select(cap_rad, min(coc, cap_rad), seen);
}

// Elongation (-1 to 1) with which a voxel of this key was seen; 0 for one not seen since the last blink.
fn sharpness_key_elongation(key: u32, epoch: u32) -> f32 {
    let seen = key >> 28u == sharpness_epoch_bits(epoch) >> 28u && key != SHARPNESS_NEVER_SEEN;
    return select(0.0, elongation_decode(key & 0x7Fu), seen);
}

// The same key after the clock has been set back to R = 0 within its epoch, `rebase_steps` being R
// before; 0xFFFFFFFF forgets everything.
fn sharpness_key_rebase(key: u32, rebase_steps: u32, epoch: u32) -> u32 {
    let value = (key >> 7u) & 0x1FFFFFu;
    if rebase_steps == 0xFFFFFFFFu || value > SHARPNESS_VALUE_MAX
        || key >> 28u != sharpness_epoch_bits(epoch) >> 28u {
        return SHARPNESS_NEVER_SEEN;
    }
    let shifted = value + min(rebase_steps, SHARPNESS_STARVE_STEPS_MAX);
    return sharpness_epoch_bits(epoch) | min(shifted, SHARPNESS_VALUE_MAX) << 7u | (key & 0x7Fu);
}
