//! Eyelashes: irregular clumps of curved hairs on the anterior edges of the lid margins.
//!
//! In: a seed, and at each pose the lash lines of a [`PosedRegion`]. Out: a [`HairMesh`] whose
//! topology belongs to its level. Upper lid 122–146 lashes 8–11 mm long (shorter towards the canthi) that leave the lid
//! forwards and curve up; lower lid 62–76 of 5–7 mm that curve down and out. The same seed gives the
//! same lashes. Globe frame, mm.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::face_region::{MARGIN_POINTS, PosedRegion};
use super::hair::{HairLevel, HairMesh, HairStrips, LEVELS};
use super::lids::Lid;
use crate::optics::smoothstep::smoothstep;

/// Points along a lash: where one points at who looks, its projection turns round within a few tenths of a millimetre.
pub(super) const LEVELS_OF: [HairLevel; LEVELS] = [
    HairLevel::new(16, 1),
    HairLevel::new(10, 1),
    HairLevel::new(8, 1),
    HairLevel::new(5, 2),
];
/// Points that the finest has.
pub(super) const MOST_POINTS: usize = LEVELS_OF[0].points;

/// One lash in the frame of its root.
#[derive(Clone, Copy, Debug)]
struct Lash {
    lid: Lid,
    /// Place along the lash line, 0 medial … 1 lateral.
    t: f32,
    /// Offset of the root away from the margin, mm: lashes stand in two or three uneven rows.
    row_mm: f32,
    length_mm: f32,
    radius_mm: f32,
    /// Pitch from the lid's normal at the root and its change to the tip, radians, positive away
    /// from the fissure.
    pitch: f32,
    curl: f32,
    /// Turn towards the temple at the root and its change to the tip, radians.
    fan: f32,
    lean: f32,
}

/// All lashes of one eye.
#[derive(Clone, Debug)]
pub struct Lashes {
    lashes: Vec<Lash>,
    level: HairLevel,
    strips: HairStrips,
}

impl Lashes {
    /// Grows lashes from a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Pcg32::seed_from_u64(seed);
        let mut lashes = Vec::new();
        let (upper, lower) = (random.random_range(122..=146), random.random_range(62..=76));
        grow(Lid::Upper, upper, 0.155, 0.98, &mut random, &mut lashes);
        grow(Lid::Lower, lower, 0.2, 0.965, &mut random, &mut lashes);
        let level = LEVELS_OF[0];
        Self {
            strips: HairStrips::new(lashes.iter().map(|lash| lash.radius_mm), level),
            lashes,
            level,
        }
    }

    /// Divides them as finely as belongs to a level.
    pub fn divide(&mut self, level: usize) {
        let level = LEVELS_OF[level.min(LEVELS - 1)];
        if level != self.level {
            let radii = self.lashes.iter().map(|lash| lash.radius_mm);
            self.strips = HairStrips::new(radii, level);
            self.level = level;
        }
    }

    /// Number of lashes on a lid.
    #[cfg(test)]
    pub fn count(&self, lid: Lid) -> usize {
        self.lashes.iter().filter(|l| l.lid == lid).count()
    }

    /// What of their mesh does not move.
    pub fn strips(&self) -> &HairStrips {
        &self.strips
    }

    /// Stands the lashes on a posed region.
    pub fn pose(&self, region: &PosedRegion, out: &mut HairMesh) {
        out.clear();
        let HairLevel { points, one_of } = self.level;
        for lash in self.lashes.iter().step_by(one_of) {
            let (line, margin) = match lash.lid {
                Lid::Upper => (&region.upper_lash_line, &region.upper_margin),
                Lid::Lower => (&region.lower_lash_line, &region.lower_margin),
            };
            out.push(&lash.line(line, margin, points)[..points]);
        }
    }
}

impl Lash {
    /// Its `points` points first; no others are worked out.
    fn line(&self, lash_line: &[Vec3], margin: &[Vec3], points: usize) -> [Vec3; MOST_POINTS] {
        if lash_line.len() != MARGIN_POINTS || margin.len() != MARGIN_POINTS {
            return [Vec3::ZERO; MOST_POINTS];
        }
        let (root, tangent) = sample(lash_line, self.t);
        let (inner, _) = sample(margin, self.t);
        // The lid's normal here: from the globe's centre, bent by how the margin itself stands.
        let normal = (root.normalize_or_zero() * 2.0 + (root - inner).normalize_or_zero())
            .normalize_or(Vec3::NEG_Z);
        let normal = (normal - tangent * normal.dot(tangent)).normalize_or(Vec3::NEG_Z);
        let up = normal.cross(tangent);
        let away = match self.lid {
            Lid::Upper => up * up.y.signum(),
            Lid::Lower => -up * up.y.signum(),
        };
        // Rooted a little inside the skin.
        let mut at = root + away * self.row_mm - normal * 0.15;
        let step = self.length_mm / (points - 1) as f32;
        let mut line = [Vec3::ZERO; MOST_POINTS];
        for (point, here) in line.iter_mut().take(points).enumerate() {
            *here = at;
            let s = (point as f32 + 0.5) / (points - 1) as f32;
            let (sin, cos) = (self.pitch + self.curl * s.powf(1.2)).sin_cos();
            let (turn_sin, turn_cos) = (self.fan + self.lean * s).sin_cos();
            at += ((normal * cos + away * sin) * turn_cos + tangent * turn_sin) * step;
        }
        line
    }
}

fn sample(line: &[Vec3], t: f32) -> (Vec3, Vec3) {
    let at = t.clamp(0.0, 1.0) * (line.len() - 1) as f32;
    let i = (at as usize).min(line.len() - 2);
    let (before, after) = (line[i.saturating_sub(1)], line[(i + 2).min(line.len() - 1)]);
    (
        line[i].lerp(line[i + 1], at - i as f32),
        (after - before).normalize_or(Vec3::X),
    )
}

/// Clumps of one to five lashes whose tips lean together.
fn grow(lid: Lid, count: usize, from: f32, to: f32, random: &mut Pcg32, out: &mut Vec<Lash>) {
    let start = out.len();
    let spacing = (to - from) / count as f32;
    let mut next = from;
    while out.len() - start < count {
        let members = random
            .random_range(1..=5_usize)
            .min(count - (out.len() - start));
        let middle = next + 0.5 * spacing * members as f32;
        let gather = random.random_range(0.35..0.95_f32);
        let tilt = random.random_range(-0.12..0.12_f32);
        for _ in 0..members {
            // The roots of a tuft stand closer than those of two.
            let t = next + spacing * random.random_range(0.1..0.9_f32);
            let t = (middle + 0.8 * (t - middle)).clamp(from, to);
            let lash = one(lid, t, (middle - t) * gather, tilt, random);
            out.push(lash);
            next += spacing;
        }
    }
}

fn one(lid: Lid, t: f32, towards_clump: f32, tilt: f32, random: &mut Pcg32) -> Lash {
    let mut around =
        |middle: f32, spread: f32| middle + spread * random.random_range(-1.0..1.0_f32);
    let ends = smoothstep(0.1, 0.62, t) * (1.0 - 0.75 * smoothstep(0.8, 1.0, t));
    // About 31 mm of margin: what the tip must lean to reach the middle of its clump.
    let lean_for = |length: f32| 31.0 * towards_clump / length;
    let fan = -0.34 + 0.78 * smoothstep(0.1, 1.0, t);
    match lid {
        Lid::Upper => {
            let length_mm = around(4.2 + 4.5 * ends, 1.1).min(11.0);
            Lash {
                lid,
                t,
                row_mm: around(0.15, 0.25),
                length_mm,
                radius_mm: around(0.042, 0.012),
                pitch: around(0.12, 0.1) + tilt,
                curl: around(0.62, 0.2),
                fan: around(0.55 * fan, 0.11),
                lean: around(0.55 * fan, 0.14) + 1.6 * lean_for(length_mm),
            }
        }
        Lid::Lower => {
            let length_mm = around(2.3 + 2.2 * ends, 0.9).min(7.0);
            Lash {
                lid,
                t,
                row_mm: around(0.0, 0.22),
                length_mm,
                radius_mm: around(0.035, 0.011),
                pitch: around(0.3, 0.3) + tilt,
                curl: around(0.55, 0.45),
                fan: around(0.6 * fan, 0.18),
                lean: around(0.4 * fan, 0.24) + 1.6 * lean_for(length_mm),
            }
        }
    }
}
