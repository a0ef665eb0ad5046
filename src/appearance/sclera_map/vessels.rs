//! Vessels of the bulbar conjunctiva and episclera, grown tip by tip.
//!
//! In: seed, settings, sizes of maps. Out: columns of blood, mm, in two layers: of the conjunctiva, and of
//! episclera and sclera below it, which scattering blurs. Branch calibres follow Murray's law (r³ = r₁³ + r₂³).

use core::f32::consts::{PI, TAU};

use super::{LIMBUS_DEG, MAP_EDGE_DEG, Place, ScleraMapSettings};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{HashStream, value_noise};

/// Length of one step of growth, degrees (0.06 mm of an 11.5 mm globe).
const STEP_DEG: f32 = 0.3;
/// How far a vessel has come from a fork, degrees, when it is turned from its way by a third of what it was there.
const FORK_STRAIGHTENS_DEG: f32 = 9.0;
/// Degrees per millimetre on the globe.
const DEG_PER_MM: f32 = 180.0 / PI / 11.5;

/// Columns of blood, mm, texel by texel.
pub(super) struct Blood {
    size: usize,
    coarse: usize,
    pub shallow: Vec<f32>,
    pub deep: Vec<f32>,
}

/// A growing tip.
#[derive(Clone, Copy)]
struct Tip {
    at: Place,
    /// How far it was turned from its way at its fork, rad, and how far it has come since, degrees.
    turned: f32,
    since: f32,
    radius_mm: f32,
    left_deg: f32,
    seed: u32,
    generation: u32,
}

/// How the vessels of one plexus grow.
struct Habit {
    /// How far it turns from its way to the limbus, rad: in slow swings and in tight wriggles.
    swing: f32,
    wriggle: f32,
    /// Chance of a branch per degree of length.
    branching: f32,
    /// Angle from the corneal axis at which they end, degrees.
    stop_deg: f32,
    /// Width of the blur, degrees; below one texel it is antialiasing only.
    blur_deg: f32,
    deep: bool,
    gain: f32,
}

/// Grows every plexus.
pub(super) fn grow(seed: u32, settings: &ScleraMapSettings, size: usize, coarse: usize) -> Blood {
    let mut blood = Blood {
        size,
        coarse,
        shallow: vec![0.0; size * size],
        deep: vec![0.0; coarse * coarse],
    };
    let redness = settings.redness;
    deep_vessels(&mut blood, seed, redness);
    // Injected vessels are wider, and more of them are open.
    let fullness = 0.9 + 0.9 * redness;
    let count = (60.0 + 200.0 * redness) as u32;
    let habit = Habit {
        swing: 0.75,
        wriggle: 0.85,
        branching: 0.05,
        stop_deg: LIMBUS_DEG + 2.0,
        blur_deg: 0.03,
        deep: false,
        gain: 1.0,
    };
    let mut dice = HashStream::new(seed, 41);
    for which in 0..count {
        // Most come from the canthi, some from the fornices.
        let side = if dice.unit() < 0.5 { 0.0 } else { PI };
        let spread = if dice.unit() < 0.72 { 0.36 } else { 1.1 };
        let angle = side + spread * dice.normal();
        let start = dice.range(55.0, 99.0);
        // One or two in a quarter of an eye are thick.
        let trunk = if which % 16 == 0 { 0.008 } else { 0.0 };
        let radius_mm = fullness * (0.0075 + trunk + 0.030 * dice.unit() * dice.unit());
        let tip = tip_at(&mut dice, angle, start, radius_mm, 75.0);
        grow_tree(&mut blood, &mut dice, tip, &habit);
    }
    limbal_loops(&mut blood, seed, fullness);
    blood
}

/// Anterior ciliary vessels over the four recti, and the veiled scleral plexus around them.
fn deep_vessels(blood: &mut Blood, seed: u32, redness: f32) {
    let mut dice = HashStream::new(seed, 42);
    let mut habit = Habit {
        swing: 0.5,
        wriggle: 0.3,
        branching: 0.020,
        stop_deg: LIMBUS_DEG + 15.0,
        blur_deg: 0.7,
        deep: true,
        gain: 0.8 + 0.6 * redness,
    };
    for rectus in 0..4 {
        for _ in 0..2 {
            let angle = rectus as f32 * TAU / 4.0 + 0.22 * dice.normal();
            let start = dice.range(70.0, 98.0);
            let radius_mm = dice.range(0.035, 0.075);
            let tip = tip_at(&mut dice, angle, start, radius_mm, 60.0);
            grow_tree(blood, &mut dice, tip, &habit);
        }
    }
    habit.stop_deg = LIMBUS_DEG + 5.0;
    habit.blur_deg = 1.3;
    habit.gain *= 0.8;
    for _ in 0..26 {
        let angle = TAU * dice.unit();
        let start = dice.range(45.0, 90.0);
        let radius_mm = dice.range(0.03, 0.07);
        let tip = tip_at(&mut dice, angle, start, radius_mm, 40.0);
        grow_tree(blood, &mut dice, tip, &habit);
    }
}

/// Hair-fine arcades along the limbus, denser above and below (where the palisades are).
fn limbal_loops(blood: &mut Blood, seed: u32, fullness: f32) {
    let mut dice = HashStream::new(seed, 43);
    for _ in 0..640 {
        let angle = TAU * dice.unit();
        let upright = angle.sin().abs();
        if dice.unit() > 0.45 + 0.55 * upright {
            continue;
        }
        let outer = LIMBUS_DEG + dice.range(2.0, 5.5);
        let habit = Habit {
            swing: 0.6,
            wriggle: 0.8,
            branching: 0.10,
            stop_deg: LIMBUS_DEG - dice.range(0.0, 1.2),
            blur_deg: 0.03,
            deep: false,
            gain: fullness,
        };
        let radius_mm = dice.range(0.005, 0.011);
        let tip = tip_at(&mut dice, angle, outer, radius_mm, 7.0);
        grow_tree(blood, &mut dice, tip, &habit);
    }
}

fn tip_at(dice: &mut HashStream, angle: f32, from_deg: f32, radius_mm: f32, length: f32) -> Tip {
    Tip {
        at: [from_deg * angle.cos(), from_deg * angle.sin()],
        turned: 0.45 * dice.normal(),
        since: 0.0,
        radius_mm,
        left_deg: length * dice.range(0.5, 1.2),
        seed: dice.next_u32(),
        generation: 0,
    }
}

fn grow_tree(blood: &mut Blood, dice: &mut HashStream, trunk: Tip, habit: &Habit) {
    let mut waiting = vec![trunk];
    while let Some(tip) = waiting.pop() {
        grow_branch(blood, dice, tip, habit, &mut waiting);
    }
}

fn grow_branch(
    blood: &mut Blood,
    dice: &mut HashStream,
    mut tip: Tip,
    habit: &Habit,
    waiting: &mut Vec<Tip>,
) {
    let whole = tip.left_deg;
    let mut along = 0.0;
    while tip.left_deg > 0.0 {
        let distance = tip.at[0].hypot(tip.at[1]);
        if distance < habit.stop_deg || distance > MAP_EDGE_DEG * 1.3 {
            break;
        }
        let inward = (-tip.at[1]).atan2(-tip.at[0]);
        let restless =
            0.35 + 0.65 * smoothstep(-0.5, 0.6, value_noise(along * 0.08, 0, tip.seed ^ 3));
        // However it winds it goes to the limbus: no vessel turns back.
        let heading = inward
            + tip.turned * (-tip.since / FORK_STRAIGHTENS_DEG).exp()
            + habit.swing * value_noise(along * 0.11, 0, tip.seed)
            + restless * habit.wriggle * value_noise(along * 0.42, 0, tip.seed ^ 1)
            + restless * 0.6 * habit.wriggle * value_noise(along * 1.1, 0, tip.seed ^ 2);
        let next = [
            tip.at[0] + STEP_DEG * heading.cos(),
            tip.at[1] + STEP_DEG * heading.sin(),
        ];
        // Vessels fade in from the depth at their source and out at their tip.
        let ends = smoothstep(0.0, 5.0, along).max(tip.generation.min(1) as f32)
            * smoothstep(0.0, 0.35, tip.left_deg / whole);
        let filled = 0.75 + 0.35 * value_noise(along * 0.25, 0, tip.seed ^ 4);
        // They thin towards the limbus.
        let radius_mm = tip.radius_mm * (0.45 + 0.55 * smoothstep(LIMBUS_DEG, 72.0, distance));
        blood.draw(tip.at, next, radius_mm, habit, ends * filled * habit.gain);
        tip.at = next;
        tip.left_deg -= STEP_DEG;
        along += STEP_DEG;
        tip.since += STEP_DEG;
        if tip.generation < 4 && dice.unit() < habit.branching * STEP_DEG {
            waiting.push(fork(&mut tip, dice));
        }
    }
}

/// Splits a tip by Murray's law; the thinner daughter is returned, the other goes on.
fn fork(tip: &mut Tip, dice: &mut HashStream) -> Tip {
    let share = dice.range(0.15, 0.5);
    let side = if dice.unit() < 0.5 { -1.0 } else { 1.0 };
    let bend = side * dice.range(0.4, 1.1);
    let straightened = (-tip.since / FORK_STRAIGHTENS_DEG).exp();
    tip.turned *= straightened;
    tip.since = 0.0;
    let daughter = Tip {
        turned: tip.turned + bend,
        radius_mm: tip.radius_mm * share.cbrt(),
        left_deg: tip.left_deg * dice.range(0.3, 0.9),
        seed: dice.next_u32(),
        generation: tip.generation + 1,
        ..*tip
    };
    tip.radius_mm *= (1.0 - share).cbrt();
    tip.turned -= 0.3 * bend;
    daughter
}

impl Blood {
    /// Adds a piece of vessel with a Gaussian cross-section, `filled` with this share of the blood that it can
    /// hold: π r² of it for each length, whatever the blur or the texel size.
    fn draw(&mut self, from: Place, to: Place, radius_mm: f32, habit: &Habit, filled: f32) {
        let size = if habit.deep { self.coarse } else { self.size };
        let texels_per_deg = size as f32 / (2.0 * MAP_EDGE_DEG);
        let calibre = radius_mm * DEG_PER_MM;
        // A round rod has a quarter of its squared radius as variance across.
        let sigma_deg = (0.25 * calibre * calibre + habit.blur_deg * habit.blur_deg)
            .sqrt()
            .max(0.5 / texels_per_deg);
        let sigma_mm = sigma_deg / DEG_PER_MM;
        let peak = PI * radius_mm * radius_mm / (sigma_mm * TAU.sqrt()) * filled;
        let sigma = sigma_deg * texels_per_deg;
        let half = size as f32 * 0.5;
        // So many round dabs a step that nobody can count them.
        let dabs = (STEP_DEG / (0.7 * sigma_deg)).ceil().max(1.0);
        for dab in 0..dabs as u32 {
            let along = (dab as f32 + 0.5) / dabs;
            let at = |k: usize| from[k] + (to[k] - from[k]) * along;
            let centre = [
                at(0) * texels_per_deg + half - 0.5,
                half - at(1) * texels_per_deg - 0.5,
            ];
            self.dab(centre, sigma, peak / dabs, size, habit.deep);
        }
    }

    /// One round dab of a vessel's step, at a place in texels.
    fn dab(&mut self, centre: [f32; 2], sigma: f32, peak: f32, size: usize, deep: bool) {
        let texels_per_deg = size as f32 / (2.0 * MAP_EDGE_DEG);
        // Each carries its step's share of the line.
        let share = STEP_DEG * texels_per_deg / (sigma * (TAU).sqrt());
        let reach = 2.6 * sigma;
        let limit = size as f32 - 1.0;
        let span = |c: f32| {
            let first = (c - reach).ceil().max(0.0);
            let last = (c + reach).floor().min(limit);
            (first as usize, last as usize, first <= last)
        };
        let ((x0, x1, on_x), (y0, y1, on_y)) = (span(centre[0]), span(centre[1]));
        if !(on_x && on_y) {
            return;
        }
        let layer = if deep {
            &mut self.deep
        } else {
            &mut self.shallow
        };
        for y in y0..=y1 {
            let dy = y as f32 - centre[1];
            for x in x0..=x1 {
                let dx = x as f32 - centre[0];
                let fall = (-(dx * dx + dy * dy) / (2.0 * sigma * sigma)).exp();
                layer[y * size + x] += peak * share * fall;
            }
        }
    }
}
