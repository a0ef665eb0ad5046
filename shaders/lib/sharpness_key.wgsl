// The sharpness field's ordered key. Twin: src/percept/field/sharpness_field.rs.
//
// A voxel seen with a circle of confusion c0 (rad) when the starvation R(t) = integral of r dt stood
// at R0 has c(t) = c0 exp(R(t) - R0) ever after, so ln c0 - R0 alone orders voxels by sharpness at
// every later time. The key is that number in steps of 1/4096 (0.0244 % of blur), as an unsigned
// integer whose order is the order of sharpness, below the inverted blink epoch in the top byte:
// a newer epoch is always the smaller key, so one atomicMin does both the update and the reset.

const SHARPNESS_STEPS_PER_NAT: f32 = 4096.0;
// ln(1e-6 rad) and ln(e^(65535/4096) * 1e-6 rad) bound what a key can say.
const SHARPNESS_LN_MIN: f32 = -13.815510558;
const SHARPNESS_LN_STEPS_MAX: f32 = 65535.0;
// Starvation that one epoch can hold, in steps: 4,077 nats, nearly two hours at 0.6 per second.
const SHARPNESS_STARVE_STEPS_MAX: u32 = 16700000u;
const SHARPNESS_VALUE_MAX: u32 = 0xFFFFFEu;
const SHARPNESS_NEVER_SEEN: u32 = 0xFFFFFFFFu;

fn sharpness_epoch_bits(epoch: u32) -> u32 {
    return (255u - min(epoch, 255u)) << 24u;
}

// Key of a circle of confusion `coc_rad` seen now, R(now) being `starve_steps` steps.
fn sharpness_key_encode(coc_rad: f32, starve_steps: u32, epoch: u32) -> u32 {
    let ln_steps = (log(max(coc_rad, 1e-6)) - SHARPNESS_LN_MIN) * SHARPNESS_STEPS_PER_NAT;
    let value = u32(clamp(ln_steps + 0.5, 0.0, SHARPNESS_LN_STEPS_MAX))
        + (SHARPNESS_STARVE_STEPS_MAX - min(starve_steps, SHARPNESS_STARVE_STEPS_MAX));
    return sharpness_epoch_bits(epoch) | value;
}

// Circle of confusion (rad) now of a voxel with this key, at most `cap_rad`; the cap itself for a
// voxel not seen since the last blink.
fn sharpness_key_decode(key: u32, starve_steps: u32, epoch: u32, cap_rad: f32) -> f32 {
    let value = key & 0xFFFFFFu;
    let remaining = SHARPNESS_STARVE_STEPS_MAX - min(starve_steps, SHARPNESS_STARVE_STEPS_MAX);
    let seen = (key >> 24u) == 255u - min(epoch, 255u) && value <= SHARPNESS_VALUE_MAX;
    // 81,920 steps are 500 rad: beyond any cap, and exp() stays finite.
    let ln_steps = f32(clamp(i32(value) - i32(remaining), 0, 81920));
    let coc = exp(ln_steps / SHARPNESS_STEPS_PER_NAT + SHARPNESS_LN_MIN);
    return select(cap_rad, min(coc, cap_rad), seen);
}

// The same key after the clock has been set back to R = 0 within its epoch, `rebase_steps` being R
// before; 0xFFFFFFFF forgets everything.
fn sharpness_key_rebase(key: u32, rebase_steps: u32, epoch: u32) -> u32 {
    let value = key & 0xFFFFFFu;
    if rebase_steps == 0xFFFFFFFFu || value > SHARPNESS_VALUE_MAX
        || (key >> 24u) != 255u - min(epoch, 255u) {
        return SHARPNESS_NEVER_SEEN;
    }
    let shifted = value + min(rebase_steps, SHARPNESS_STARVE_STEPS_MAX);
    return sharpness_epoch_bits(epoch) | min(shifted, SHARPNESS_VALUE_MAX);
}
