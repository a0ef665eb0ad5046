//! The sharpness field (Nießner et al. 2013, section 4): what was seen sharply is remembered for a
//! while.
//!
//! Enters: the circle of confusion (rad) of every visible point, now. Leaves: the sharpest one that
//! the point's voxel has kept since the last blink, starved by the time that has passed.
//!
//! The paper keeps (CoC, time stamp) in a dense grid ([`DenseField`], the reference here). Starving
//! by a rate r gives c(t) = c₀·e^(R(t) − R(t₀)) with R = ∫ r dt, so ln c₀ − R(t₀) alone orders
//! voxels by sharpness at every later time. That number, quantised, below the inverted blink epoch,
//! is a `u32` *key*: an update is one minimum, starving costs nothing, a blink is one counter. Cells
//! exist only where something was seen ([`SparseField`]; on the GPU an open-addressed table).
//!
//! An astigmatic eye's blur has a direction. Its axis is the eye's own of this moment, and is not
//! remembered; how much longer than wide it was
//! ([`crate::optics::defocus::astigmatic_blur`]) rides in the key's last seven bits, below all
//! that orders: whichever sight was the sharpest brings its own.
//!
//! Twins of the pure functions: `shaders/lib/sharpness_key.wgsl` and `sharpness_voxel.wgsl`. The GPU
//! takes logarithms in f32, so its key may differ from the one here by one step.
//!
//! Error: encoding rounds ln c to 1/4096 and R is rounded to 1/4096 when written and when read, so a
//! circle of confusion is off by at most 1.5 steps, 0.037 %. It is clamped to 1e-6 rad … 8.9 rad.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

/// Steps of the key per nat of blur.
pub const STEPS_PER_NAT: f64 = 4096.0;
/// ln(1e-6 rad), the sharpest that a key can say.
pub const LN_MIN: f64 = -13.815_510_558;
/// Steps from there to the most blurred, 8.9 rad.
pub const LN_STEPS_MAX: u32 = 65_535;
/// Starvation that one epoch can hold, in steps: 495 nats, 14 minutes at 0.6 1/s.
pub const STARVE_STEPS_MAX: u32 = 2_030_000;
/// Largest value below the epoch; the one above marks a voxel never seen.
pub const VALUE_MAX: u32 = 0x1F_FFFE;
/// The last blink epoch; the one after it is 0 again, and what was seen before is wiped out by a pass.
pub const EPOCH_MAX: u8 = 15;
/// Bits below the value, which hold the elongation.
pub const ELONGATION_BITS: u32 = 7;
/// Steps of a right angle in which the elongation's arcsine is kept.
pub const ELONGATION_STEPS: f64 = 63.0;
/// What stands there for a disc.
const DISC: u32 = 64;
/// Key of a voxel never seen.
pub const NEVER_SEEN: u32 = u32::MAX;
/// Largest relative error of a circle of confusion that went through a key.
pub const KEY_RELATIVE_ERROR: f64 = 1.5 / STEPS_PER_NAT;
/// Distance beyond which voxels are named by direction, m.
pub const FAR_M: f64 = 1000.0;
const LEVEL_UNIFORM: i32 = 1000;
const LEVEL_SKY: i32 = 1001;
/// Starvation at which the clock asks for a rebase: some minutes before the key would saturate.
const REBASE_STEPS: u32 = 1_600_000;

/// Bits of a blink epoch (at most [`EPOCH_MAX`]): a newer one is smaller.
pub fn sharpness_epoch_bits(epoch: u8) -> u32 {
    u32::from(EPOCH_MAX - epoch.min(EPOCH_MAX)) << 28
}

/// The value in a key, and whether the voxel has been seen in this epoch.
fn parts(key: u32, epoch: u8) -> (u32, bool) {
    let value = (key >> ELONGATION_BITS) & 0x1F_FFFF;
    let is_of_epoch = key & 0xF000_0000 == sharpness_epoch_bits(epoch);
    (value, is_of_epoch && value <= VALUE_MAX)
}

/// Seven bits for an elongation (−1 to 1), by its arcsine; what is not a number is round.
pub fn elongation_encode(elongation: f64) -> u32 {
    let turn = elongation.clamp(-1.0, 1.0).asin() * (ELONGATION_STEPS / FRAC_PI_2);
    let turn = if turn.is_nan() { 0.0 } else { turn };
    ((turn + 0.5).floor() + f64::from(DISC)) as u32
}

/// The elongation that [`elongation_encode`] has kept, within 1/126 of a right angle of its arcsine.
pub fn elongation_decode(code: u32) -> f64 {
    ((f64::from(code) - f64::from(DISC)) * (FRAC_PI_2 / ELONGATION_STEPS)).sin()
}

/// Key of a circle of confusion (rad) of this elongation (−1 to 1) seen now. What is not a number counts
/// as wholly blurred, and as round.
pub fn sharpness_key_encode(coc_rad: f64, elongation: f64, starve_steps: u32, epoch: u8) -> u32 {
    let coc = if coc_rad.is_nan() { f64::MAX } else { coc_rad };
    let ln_steps = (coc.max(1e-6).ln() - LN_MIN) * STEPS_PER_NAT;
    let value = (ln_steps + 0.5).clamp(0.0, f64::from(LN_STEPS_MAX)) as u32
        + STARVE_STEPS_MAX.saturating_sub(starve_steps);
    sharpness_epoch_bits(epoch) | value << ELONGATION_BITS | elongation_encode(elongation)
}

/// Circle of confusion (rad) now of a voxel with this key, at most `cap_rad`; the cap itself for a
/// voxel not seen since the last blink.
pub fn sharpness_key_decode(key: u32, starve_steps: u32, epoch: u8, cap_rad: f64) -> f64 {
    let (value, true) = parts(key, epoch) else {
        return cap_rad;
    };
    let remaining = STARVE_STEPS_MAX.saturating_sub(starve_steps);
    let ln_steps = value.saturating_sub(remaining).min(81_920);
    (f64::from(ln_steps) / STEPS_PER_NAT + LN_MIN)
        .exp()
        .min(cap_rad)
}

/// Elongation (−1 to 1) with which a voxel of this key was seen; 0 for one not seen since the last
/// blink. Its arcsine is kept in steps of 1/63 of a right angle, so that near a line (±1) the shorter
/// diameter is within 1.3 % of the longer one.
pub fn sharpness_key_elongation(key: u32, epoch: u8) -> f64 {
    let is_of_epoch = key & 0xF000_0000 == sharpness_epoch_bits(epoch);
    if !is_of_epoch || key == NEVER_SEEN {
        return 0.0;
    }
    elongation_decode(key & 0x7F)
}

/// The same key after the clock has been set back to R = 0 within its epoch; `u32::MAX` forgets all.
pub fn sharpness_key_rebase(key: u32, rebase_steps: u32, epoch: u8) -> u32 {
    let (value, is_kept) = parts(key, epoch);
    if rebase_steps == u32::MAX || !is_kept {
        return NEVER_SEEN;
    }
    let shifted = (value + rebase_steps.min(STARVE_STEPS_MAX)).min(VALUE_MAX);
    sharpness_epoch_bits(epoch) | shifted << ELONGATION_BITS | (key & 0x7F)
}

/// Rate r (1/s) at which blur grows when every one of `steps_per_s` steps adds `fraction` of it:
/// the paper's 1 – 2 % at 30 steps a second are 0.30 and 0.59.
pub fn starve_rate_per_s(fraction: f64, steps_per_s: f64) -> f64 {
    steps_per_s * fraction.ln_1p()
}

/// A pass over all keys that the clock asks for: the `rebase` entry point, with this number and the
/// clock's own epoch in its uniform, before any key is written or read again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rebase {
    /// Starvation to take off the keys of the clock's epoch, or `u32::MAX` to forget everything.
    pub steps: u32,
}

/// Blink epoch and starvation R(t) since the last blink.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SharpnessClock {
    epoch: u8,
    starved_nats: f64,
}

impl SharpnessClock {
    /// Blink epoch, for keys and the uniform.
    pub fn epoch(&self) -> u8 {
        self.epoch
    }

    /// R(now) in steps, for keys and the uniform.
    pub fn starve_steps(&self) -> u32 {
        // A float-to-integer cast saturates, and so does the key.
        ((self.starved_nats * STEPS_PER_NAT).round() as u32).min(STARVE_STEPS_MAX)
    }

    /// Lets `dt_s` seconds pass at `rate_per_s` (1/s). Negative or non-finite values pass no time.
    /// Returns the pass that is due once in about 11 minutes without a blink.
    #[must_use]
    pub fn advance(&mut self, dt_s: f64, rate_per_s: f64) -> Option<Rebase> {
        let starved = dt_s * rate_per_s;
        if starved.is_finite() && dt_s > 0.0 && rate_per_s > 0.0 {
            self.starved_nats += starved;
        }
        let steps = self.starve_steps();
        if steps < REBASE_STEPS {
            return None;
        }
        // What is less than a step stays, or every pass would add its rounding to all that is remembered.
        self.starved_nats -= f64::from(steps) / STEPS_PER_NAT;
        Some(Rebase { steps })
    }

    /// Forgets everything seen: one counter, and once in 16 blinks the pass that is returned.
    #[must_use]
    pub fn blink(&mut self) -> Option<Rebase> {
        self.starved_nats = 0.0;
        if self.epoch < EPOCH_MAX {
            self.epoch += 1;
            return None;
        }
        self.epoch = 0;
        Some(Rebase { steps: u32::MAX })
    }
}

/// Name of a voxel: its cell on the grid of its level, and the level.
pub type Voxel = [i32; 4];

/// Voxel of the point at `vergence_per_m` (1/m along the ray, 0 at infinity) in the unit direction
/// `direction`, seen from `eye_m` (m from the field's origin). `voxel_size_m` > 0 is the paper's
/// uniform grid; otherwise a voxel spans between a half and one `voxel_angle_rad` at the origin.
pub fn sharpness_voxel(
    eye_m: [f64; 3],
    direction: [f64; 3],
    vergence_per_m: f64,
    voxel_size_m: f64,
    voxel_angle_rad: f64,
) -> Voxel {
    if vergence_per_m.is_nan() || vergence_per_m < 1.0 / FAR_M {
        return cell(direction, voxel_angle_rad, LEVEL_SKY);
    }
    let point = std::array::from_fn(|i| eye_m[i] + direction[i] / vergence_per_m);
    sharpness_voxel_at(point, voxel_size_m, voxel_angle_rad)
}

/// Voxel of a point (m from the field's origin).
pub fn sharpness_voxel_at(point: [f64; 3], voxel_size_m: f64, voxel_angle_rad: f64) -> Voxel {
    if voxel_size_m > 0.0 {
        return cell(point, voxel_size_m, LEVEL_UNIFORM);
    }
    let distance = point.iter().map(|v| v * v).sum::<f64>().sqrt();
    let level = distance.max(1e-4).log2().floor();
    cell(point, voxel_angle_rad * level.exp2(), level as i32)
}

fn cell(p: [f64; 3], side: f64, level: i32) -> Voxel {
    let [x, y, z] = p.map(|v| (v / side).floor() as i32);
    [x, y, z, level]
}

/// Finaliser of MurmurHash3.
pub fn sharpness_mix(word: u32) -> u32 {
    let h = (word ^ (word >> 16)).wrapping_mul(0x85EB_CA6B);
    let h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// Tag (never 0) and home hash of a voxel, as the GPU's table uses them.
pub fn sharpness_voxel_hash(voxel: Voxel) -> [u32; 2] {
    let (mut tag, mut home) = (0x9E37_79B9_u32, 0x7F4A_7C15_u32);
    for v in voxel.map(i32::cast_unsigned) {
        tag = sharpness_mix(tag ^ v).wrapping_add(0x632B_E5AB);
        home = sharpness_mix(home.wrapping_add(v.wrapping_mul(0x2C1B_3C6D))) ^ 0x297A_2D39;
    }
    [tag.max(1), home]
}

/// The field by keys, holding only voxels that were seen.
#[derive(Clone, Debug, Default)]
pub struct SparseField {
    keys: HashMap<Voxel, u32>,
}

impl SparseField {
    /// Takes a voxel's circle of confusion (rad) of this moment.
    pub fn update(&mut self, voxel: Voxel, coc_rad: f64, clock: &SharpnessClock) {
        let key = sharpness_key_encode(coc_rad, 0.0, clock.starve_steps(), clock.epoch());
        let held = self.keys.entry(voxel).or_insert(NEVER_SEEN);
        *held = key.min(*held);
    }

    /// Circle of confusion (rad) that a voxel shows now, at most `cap_rad`.
    pub fn read(&self, voxel: Voxel, clock: &SharpnessClock, cap_rad: f64) -> f64 {
        let key = self.keys.get(&voxel).copied().unwrap_or(NEVER_SEEN);
        sharpness_key_decode(key, clock.starve_steps(), clock.epoch(), cap_rad)
    }

    /// Does what a clock asked for.
    pub fn rebase(&mut self, rebase: Rebase, clock: &SharpnessClock) {
        for key in self.keys.values_mut() {
            *key = sharpness_key_rebase(*key, rebase.steps, clock.epoch());
        }
    }

    /// Voxels held.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether nothing has been seen yet.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }
}

/// The paper's own field: a dense grid of (CoC, time stamp), cleared by every blink. The reference.
#[derive(Clone, Debug)]
pub struct DenseField {
    cells: Vec<(f64, f64)>,
    /// Rate of starving, 1/s.
    pub rate_per_s: f64,
}

impl DenseField {
    /// A grid of `cells` voxels, none of them seen, that starves by `rate_per_s` (1/s).
    pub fn new(cells: usize, rate_per_s: f64) -> Self {
        Self {
            cells: vec![(f64::INFINITY, 0.0); cells],
            rate_per_s,
        }
    }

    /// Takes a cell's circle of confusion (rad) at `time_s` where it is sharper than what is held.
    pub fn update(&mut self, cell: usize, coc_rad: f64, time_s: f64) {
        if coc_rad < self.read(cell, time_s, f64::INFINITY) {
            self.cells[cell] = (coc_rad, time_s);
        }
    }

    /// Circle of confusion (rad) that a cell shows at `time_s`, at most `cap_rad`.
    pub fn read(&self, cell: usize, time_s: f64, cap_rad: f64) -> f64 {
        let (coc, stamp) = self.cells[cell];
        (coc * (self.rate_per_s * (time_s - stamp)).exp()).min(cap_rad)
    }

    /// Forgets everything, a write to every cell.
    pub fn blink(&mut self) {
        self.cells.fill((f64::INFINITY, 0.0));
    }
}

#[cfg(test)]
mod tests;
