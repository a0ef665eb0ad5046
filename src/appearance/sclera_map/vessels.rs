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
/// How far it has come, degrees, when it winds by two thirds as it will.
const WINDS_FROM_DEG: f32 = 4.0;
/// The most that it is turned from its way, rad.
const MOST_TURNED: f32 = 1.4;
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
    /// How far it was turned from its way at its last fork, rad, and how far it has come since, degrees.
    turned: f32,
    since: f32,
    /// How far it has come since it began, degrees.
    along: f32,
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
    deep_vessels(&mut blood, seed, 1.0 + 0.35 * redness);
    // Injected vessels are wider, and more of them are open.
    let fullness = 1.0 + 0.85 * redness;
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
fn deep_vessels(blood: &mut Blood, seed: u32, fullness: f32) {
    let mut dice = HashStream::new(seed, 42);
    let mut habit = Habit {
        swing: 0.5,
        wriggle: 0.3,
        branching: 0.020,
        stop_deg: LIMBUS_DEG + 15.0,
        blur_deg: 0.7,
        deep: true,
        gain: 0.8,
    };
    for rectus in 0..4 {
        for _ in 0..2 {
            let angle = rectus as f32 * TAU / 4.0 + 0.22 * dice.normal();
            let start = dice.range(70.0, 98.0);
            let radius_mm = fullness * dice.range(0.035, 0.075);
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
        let radius_mm = fullness * dice.range(0.03, 0.07);
        let tip = tip_at(&mut dice, angle, start, radius_mm, 40.0);
        grow_tree(blood, &mut dice, tip, &habit);
    }
}

/// Hair-fine loops along the limbus, denser above and below (where the palisades are): each comes in, turns at the edge of the cornea and goes back.
fn limbal_loops(blood: &mut Blood, seed: u32, fullness: f32) {
    let mut dice = HashStream::new(seed, 43);
    let habit = Habit {
        swing: 0.0,
        wriggle: 0.0,
        branching: 0.0,
        stop_deg: 0.0,
        blur_deg: 0.03,
        deep: false,
        gain: 0.8,
    };
    for _ in 0..420 {
        let middle = TAU * dice.unit();
        if dice.unit() > 0.45 + 0.55 * middle.sin().abs() {
            continue;
        }
        let apex = LIMBUS_DEG + dice.range(-1.0, 1.2);
        let reach = dice.range(1.5, 4.5);
        let half = dice.range(0.25, 0.8) / LIMBUS_DEG;
        let radius_mm = fullness * dice.range(0.004, 0.0085);
        let own = dice.next_u32();
        let at = |t: f32| -> Place {
            let uneven = |which: u32| 0.25 * value_noise(4.0 * t, 0, own ^ which);
            let out = (2.0 * t - 1.0) * (2.0 * t - 1.0);
            let angle = middle + half * ((t - 0.5) * PI).sin() + uneven(1) / LIMBUS_DEG;
            let radius = apex + reach * out + uneven(2);
            [radius * angle.cos(), radius * angle.sin()]
        };
        let length = 2.0 * reach + 2.0 * half * LIMBUS_DEG;
        let pieces = (length / STEP_DEG).ceil().max(2.0) as u32;
        for piece in 0..pieces {
            let [from, to] = [piece, piece + 1].map(|k| at(k as f32 / pieces as f32));
            // They come up from the depth.
            let t = (piece as f32 + 0.5) / pieces as f32;
            let risen = smoothstep(0.0, 0.25, t.min(1.0 - t));
            blood.draw(from, to, radius_mm, &habit, risen * habit.gain);
        }
    }
}

fn tip_at(dice: &mut HashStream, angle: f32, from_deg: f32, radius_mm: f32, length: f32) -> Tip {
    Tip {
        at: [from_deg * angle.cos(), from_deg * angle.sin()],
        turned: 0.45 * dice.normal(),
        since: 0.0,
        along: 0.0,
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
    while tip.left_deg > 0.0 {
        let distance = tip.at[0].hypot(tip.at[1]);
        if distance < habit.stop_deg || distance > MAP_EDGE_DEG * 1.3 {
            break;
        }
        let inward = (-tip.at[1]).atan2(-tip.at[0]);
        let heading = inward + tip.deviation(habit);
        let along = tip.along;
        let next = [
            tip.at[0] + STEP_DEG * heading.cos(),
            tip.at[1] + STEP_DEG * heading.sin(),
        ];
        // Vessels fade in from the depth at their source and out at their tip.
        let ends = smoothstep(0.0, 5.0, along).max(tip.generation.min(1) as f32)
            * smoothstep(0.0, 0.35, tip.left_deg / whole);
        let filled = 0.75 + 0.25 * value_noise(along * 0.25, 0, tip.seed ^ 4);
        // They thin towards the limbus.
        let radius_mm = tip.radius_mm * (0.45 + 0.55 * smoothstep(LIMBUS_DEG, 72.0, distance));
        blood.draw(tip.at, next, radius_mm, habit, ends * filled * habit.gain);
        tip.at = next;
        tip.left_deg -= STEP_DEG;
        tip.along += STEP_DEG;
        tip.since += STEP_DEG;
        if tip.generation < 4 && dice.unit() < habit.branching * STEP_DEG {
            waiting.push(fork(&mut tip, dice, habit));
        }
    }
}

impl Tip {
    /// How far it is turned from the way to the limbus, rad. It winds, and goes there all the same: no vessel turns back.
    fn deviation(&self, habit: &Habit) -> f32 {
        let noise =
            |per_deg: f32, which: u32| value_noise(self.along * per_deg, 0, self.seed ^ which);
        let restless = 0.35 + 0.65 * smoothstep(-0.5, 0.6, noise(0.08, 3));
        let winds = habit.swing * noise(0.11, 0)
            + restless * habit.wriggle * (noise(0.42, 1) + 0.6 * noise(1.1, 2));
        // A daughter leaves as its fork says, and winds by itself only as it goes on.
        let own = 1.0 - (-self.along / WINDS_FROM_DEG).exp();
        let turned = self.turned * (-self.since / FORK_STRAIGHTENS_DEG).exp();
        (turned + own * winds).clamp(-MOST_TURNED, MOST_TURNED)
    }
}

/// Splits a tip by Murray's law; the thinner daughter is returned, the other goes on.
fn fork(tip: &mut Tip, dice: &mut HashStream, habit: &Habit) -> Tip {
    let share = dice.range(0.15, 0.5);
    let side = if dice.unit() < 0.5 { -1.0 } else { 1.0 };
    let bend = side * dice.range(0.4, 1.1);
    let daughter = Tip {
        turned: tip.deviation(habit) + bend,
        since: 0.0,
        along: 0.0,
        radius_mm: tip.radius_mm * share.cbrt(),
        left_deg: tip.left_deg * dice.range(0.3, 0.9),
        seed: dice.next_u32(),
        generation: tip.generation + 1,
        ..*tip
    };
    tip.turned = tip.turned * (-tip.since / FORK_STRAIGHTENS_DEG).exp() - 0.3 * bend;
    tip.since = 0.0;
    tip.radius_mm *= (1.0 - share).cbrt();
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
        let long = (to[0] - from[0]).hypot(to[1] - from[1]);
        let dabs = (long / (0.7 * sigma_deg)).ceil().max(1.0);
        for dab in 0..dabs as u32 {
            let along = (dab as f32 + 0.5) / dabs;
            let at = |k: usize| from[k] + (to[k] - from[k]) * along;
            let centre = [
                at(0) * texels_per_deg + half - 0.5,
                half - at(1) * texels_per_deg - 0.5,
            ];
            self.dab(centre, sigma, peak * long / dabs, size, habit.deep);
        }
    }

    /// One round dab of a vessel's step, at a place in texels.
    fn dab(&mut self, centre: [f32; 2], sigma: f32, peak: f32, size: usize, deep: bool) {
        let texels_per_deg = size as f32 / (2.0 * MAP_EDGE_DEG);
        // Each carries its step's share of the line.
        let share = texels_per_deg / (sigma * TAU.sqrt());
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

#[cfg(test)]
mod tests {
    use super::*;

    fn habit() -> Habit {
        Habit {
            swing: 0.75,
            wriggle: 0.85,
            branching: 0.05,
            stop_deg: LIMBUS_DEG,
            blur_deg: 0.03,
            deep: false,
            gain: 1.0,
        }
    }

    /// A tip that has just begun here, and everything that grows out of it: how far each step brings it nearer, and how each fork parts.
    #[test]
    fn vessels_wind_to_the_limbus_and_fork_as_they_are_told() {
        let habit = habit();
        let (mut forks, mut turned) = (Vec::new(), 0.0_f32);
        for seed in 0..300 {
            let mut dice = HashStream::new(seed, 7);
            let mut tip = tip_at(&mut dice, 0.3, 95.0, 0.03, 70.0);
            let mut from = 95.0_f32;
            while from > LIMBUS_DEG {
                let off = tip.deviation(&habit);
                turned = turned.max(off.abs());
                // By the law of cosines, inwards.
                let next =
                    (from * from + STEP_DEG * STEP_DEG - 2.0 * from * STEP_DEG * off.cos()).sqrt();
                assert!(next < from, "{seed}: {from}");
                from = next;
                tip.along += STEP_DEG;
                tip.since += STEP_DEG;
                if dice.unit() < 0.02 {
                    let before = tip.deviation(&habit);
                    let daughter = fork(&mut tip, &mut dice, &habit);
                    forks.push((daughter.deviation(&habit) - before).abs());
                    let goes_on = (tip.deviation(&habit) - before).abs();
                    assert!(goes_on < 0.34, "{goes_on}");
                    assert!(tip.radius_mm > daughter.radius_mm);
                }
            }
        }
        assert!(turned > 1.0, "they wind: {turned}");
        // Between 0.4 and 1.1 rad, less where the most that a vessel is turned cuts it.
        let within = forks
            .iter()
            .filter(|bend| (0.39..1.11).contains(*bend))
            .count();
        assert!(forks.iter().all(|bend| *bend < 1.11));
        assert!(
            within as f32 > 0.85 * forks.len() as f32,
            "{within} of {}",
            forks.len()
        );
    }
}
