//! Brow hairs: short hairs that lie on the skin over the orbital rim.
//!
//! In: a seed and the region (its brow weights and rest shape), and at each pose the posed skin.
//! Out: a [`HairMesh`] with fixed topology. Hairs are 5–9 mm long; they stand up and lean to the
//! temple near the nose and lie along the arch further out. Globe frame, mm, right eye.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::face_region::{EyeRegion, PosedRegion};
use super::hair::{HairLevel, HairMesh, HairStrips, LEVELS};
use crate::optics::smoothstep::smoothstep;

/// Hairs that are planted.
pub(super) const COUNT: usize = 700;

/// Points along a hair of the brow, which is straighter than a lash: there are so many that most of the vertices of an eye are theirs.
pub(super) const LEVELS_OF: [HairLevel; LEVELS] = [
    HairLevel::new(5, 1),
    HairLevel::new(5, 1),
    HairLevel::new(4, 1),
    HairLevel::new(3, 2),
];
/// Points that the finest has.
const MOST_POINTS: usize = LEVELS_OF[0].points;

#[derive(Clone, Copy, Debug)]
struct BrowHair {
    corners: [u32; 3],
    weights: [f32; 3],
    length_mm: f32,
    radius_mm: f32,
    /// Angle above the direction to the temple, radians.
    rise: f32,
    /// Change of that angle to the tip.
    bend: f32,
    /// Height of the arc over the skin, mm.
    lift_mm: f32,
}

/// The brow of one eye.
#[derive(Clone, Debug)]
pub struct Brow {
    hairs: Vec<BrowHair>,
}

impl Brow {
    /// Plants about `count` hairs (0 to 4,000) by brow weight; the same seed plants the same hairs.
    pub fn new(region: &EyeRegion, count: usize, seed: u64) -> Self {
        let mut random = Pcg32::seed_from_u64(seed);
        let rest = |v: u32| {
            region
                .rest()
                .get(v as usize)
                .map_or(Vec3::ZERO, |p| Vec3::from(*p))
        };
        let weight = |v: u32| region.tissue().get(v as usize).map_or(0.0, |t| t[3]);
        let shares: Vec<([u32; 3], f32)> = region
            .triangles()
            .map(|t| {
                let area = (rest(t[1]) - rest(t[0]))
                    .cross(rest(t[2]) - rest(t[0]))
                    .length();
                (t, area * t.iter().map(|&v| weight(v)).sum::<f32>())
            })
            .filter(|(_, share)| *share > 0.0)
            .collect();
        let total: f32 = shares.iter().map(|(_, share)| share).sum();
        let mut hairs = Vec::new();
        for (corners, share) in shares {
            let wanted = share / total.max(1e-6) * count.min(4000) as f32;
            let whole = wanted as usize + usize::from(random.random::<f32>() < wanted.fract());
            let x = corners.iter().map(|&v| rest(v).x).sum::<f32>() / 3.0;
            hairs.extend((0..whole).map(|_| plant(corners, x, &mut random)));
        }
        Self { hairs }
    }

    /// What of its mesh does not move at a level.
    pub fn strips(&self, level: usize) -> HairStrips {
        let radii = self.hairs.iter().map(|hair| hair.radius_mm);
        HairStrips::new(radii, LEVELS_OF[level.min(LEVELS - 1)])
    }

    /// Lays the hairs of a level on the posed skin.
    pub fn pose(&self, region: &PosedRegion, level: usize, out: &mut HairMesh) {
        out.clear();
        let HairLevel { points, one_of } = LEVELS_OF[level.min(LEVELS - 1)];
        let at = |list: &[[f32; 3]], hair: &BrowHair| -> Vec3 {
            let corner = |k: usize| {
                list.get(hair.corners[k] as usize)
                    .map_or(Vec3::ZERO, |p| Vec3::from(*p))
            };
            (0..3).map(|k| corner(k) * hair.weights[k]).sum()
        };
        for hair in self.hairs.iter().step_by(one_of) {
            let normal = at(&region.normals, hair).normalize_or(Vec3::NEG_Z);
            let temple = (Vec3::X - normal * normal.x).normalize_or(Vec3::X);
            let up = temple.cross(normal);
            let up = if up.y < 0.0 { -up } else { up };
            let mut p = at(&region.positions, hair) - normal * 0.1;
            let step = hair.length_mm / (points - 1) as f32;
            let line: [Vec3; MOST_POINTS] = std::array::from_fn(|point| {
                let here = p;
                let s = (point as f32 + 0.5) / (points - 1) as f32;
                let (sin, cos) = (hair.rise + hair.bend * s).sin_cos();
                // An arc over the skin: leaves it, then comes back.
                let slope = hair.lift_mm / hair.length_mm * 4.0 * (1.0 - 1.7 * s);
                p += (temple * cos + up * sin + normal * slope).normalize_or(temple) * step;
                here
            });
            out.push(&line[..points]);
        }
    }
}

fn plant(corners: [u32; 3], x: f32, random: &mut Pcg32) -> BrowHair {
    let (a, b) = (random.random::<f32>().sqrt(), random.random::<f32>());
    let mut around =
        |middle: f32, spread: f32| middle + spread * random.random_range(-1.0..1.0_f32);
    let out = smoothstep(-16.0, 8.0, x);
    BrowHair {
        corners,
        weights: [1.0 - a, a * (1.0 - b), a * b],
        length_mm: around(7.0, 1.8),
        radius_mm: around(0.0415, 0.01),
        rise: around(1.25 - 1.05 * out, 0.28),
        bend: around(-0.35, 0.25),
        lift_mm: around(0.55, 0.25),
    }
}
