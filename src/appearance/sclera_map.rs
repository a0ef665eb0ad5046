//! A seeded white of the eye: colour, vessels and fine relief of the front of the globe.
//!
//! In: [`ScleraMapSettings`] and a size. Out: a square [`ScleraMap`] in the azimuthal equidistant
//! projection about the corneal axis: the distance from the centre is the angle at the globe's
//! centre, [`MAP_EDGE_DEG`] at the middle of each edge. Right in the map is +x of the globe frame
//! (the patient's right), up is +y.
//!
//! What is drawn follows the anatomy of the bulbar conjunctiva and episclera (Bron, Tripathi and
//! Tripathi, "Wolff's Anatomy of the Eye and Orbit", 1997): conjunctival vessels come from the
//! fornices and the canthi, branch and wind towards the limbus; the anterior ciliary vessels of
//! the four recti lie deeper, straighter, and dive some 4 mm before it; fine loops fringe the
//! limbus. Blood is an optical density: it multiplies the albedo by exp(−density × absorption),
//! and density adds where vessels cross.
//!
//! The limbus itself (where the sclera gives way to the cornea) is left to the shader.

use crate::frame::mips::{Level, chain};
use core::f32::consts::TAU;

use serde::{Deserialize, Serialize};

mod vessels;

use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{fbm, lerp, value_noise};

/// Angle from the corneal axis at the middle of the map's edges, degrees.
pub const MAP_EDGE_DEG: f32 = 100.0;
/// Angle of the limbus at the centre of an 11.5 mm globe, degrees: asin(5.9 / 11.5).
pub const LIMBUS_DEG: f32 = 30.9;

/// Absorption of blood in the conjunctiva, linear red, green, blue, per unit of density.
const SHARP_ABSORPTION: [f32; 3] = [0.22, 1.0, 0.92];
/// The same seen through scattering sclera: long waves dim more, blue is scattered back.
const DEEP_ABSORPTION: [f32; 3] = [0.42, 0.72, 0.52];

/// What kind of sclera to grow. Values out of range are brought to the nearest legal one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScleraMapSettings {
    /// Which individual: every seed has other vessels.
    pub seed: u32,
    /// Years, 0–100: a child's sclera is bluish, an old one yellow.
    pub age_years: f32,
    /// Conjunctival redness, 0 (rested) – 1 (inflamed); healthy eyes lie below 0.35.
    pub redness: f32,
    /// Where the nose is: −1 for a right eye (nasal = −x), 1 for a left eye.
    pub nasal_sign: f32,
}

impl Default for ScleraMapSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            age_years: 30.0,
            redness: 0.2,
            nasal_sign: -1.0,
        }
    }
}

impl ScleraMapSettings {
    /// The same settings with every field inside its documented range; a field that is not a
    /// number takes its default.
    #[must_use]
    pub fn clamped(&self) -> Self {
        let default = Self::default();
        let legal = |value: f32, low: f32, high: f32, fallback: f32| {
            if value.is_finite() {
                value.clamp(low, high)
            } else {
                fallback
            }
        };
        Self {
            seed: self.seed,
            age_years: legal(self.age_years, 0.0, 100.0, default.age_years),
            redness: legal(self.redness, 0.0, 1.0, default.redness),
            nasal_sign: if self.nasal_sign > 0.0 { 1.0 } else { -1.0 },
        }
    }
}

/// The baked map, rows from the top (+y) down.
#[derive(Clone, Debug, PartialEq)]
pub struct ScleraMap {
    /// Texels along each side.
    pub size: usize,
    /// Linear red, green, blue albedo (0–1) and relief in mm (about ±0.05, positive outwards).
    pub texels: Vec<[f32; 4]>,
    /// How much vessel covers each texel, 0–1.
    pub vessel_mask: Vec<f32>,
}

/// A direction of the map: degrees right (+x) and up (+y) of the corneal axis.
type Place = [f32; 2];

impl ScleraMap {
    /// Grows the sclera of `settings` on `size` × `size` texels (16–4096).
    #[must_use]
    pub fn new(settings: &ScleraMapSettings, size: usize) -> Self {
        let settings = settings.clamped();
        let seed = settings.seed;
        let size = size.clamp(16, 4096);
        let blood = vessels::grow(seed, &settings, size);
        let slow = SlowFields::new(seed, size);
        let mut texels = Vec::with_capacity(size * size);
        let mut vessel_mask = Vec::with_capacity(size * size);
        for index in 0..size * size {
            let place = place_of(index % size, index / size, size);
            let slow = slow.at(index % size, index / size);
            let ground = ground(seed, &settings, place, slow[0]);
            let (sharp, deep) = (blood.sharp[index], blood.deep[index]);
            let mut texel = [0.0; 4];
            for channel in 0..3 {
                let depth = sharp * SHARP_ABSORPTION[channel] + deep * DEEP_ABSORPTION[channel];
                texel[channel] = (ground[channel] * (-depth).exp()).clamp(0.0, 1.0);
            }
            texel[3] = relief_mm(seed, place, slow[1]) + 0.012 * sharp.min(1.5);
            texels.push(texel);
            vessel_mask.push(1.0 - (-1.6 * sharp - 0.8 * deep).exp());
        }
        Self {
            size,
            texels,
            vessel_mask,
        }
    }

    /// The bilinear texel in direction (`x_deg` right, `y_deg` up of the corneal axis, measured
    /// along the great circle from it); outside the map the nearest edge.
    #[must_use]
    pub fn sample(&self, x_deg: f32, y_deg: f32) -> [f32; 4] {
        let last = (self.size - 1) as f32;
        let scale = self.size as f32 * 0.5;
        let x = ((x_deg / MAP_EDGE_DEG + 1.0) * scale - 0.5).clamp(0.0, last);
        let y = ((1.0 - y_deg / MAP_EDGE_DEG) * scale - 0.5).clamp(0.0, last);
        let (left, top) = (x as usize, y as usize);
        let at = |i: usize, j: usize| {
            self.texels[(top + j).min(self.size - 1) * self.size + (left + i).min(self.size - 1)]
        };
        let (tx, ty) = (x - left as f32, y - top as f32);
        core::array::from_fn(|channel| {
            lerp(
                lerp(at(0, 0)[channel], at(1, 0)[channel], tx),
                lerp(at(0, 1)[channel], at(1, 1)[channel], tx),
                ty,
            )
        })
    }

    /// Its levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> Vec<Level<4>> {
        chain((self.size, self.size), self.texels.clone())
    }
}

/// Slowly varying noises, evaluated at every fourth texel and bilinear in between.
struct SlowFields {
    columns: usize,
    /// Clouds of colour and folds of the conjunctiva, each in −1 to 1.
    values: Vec<[f32; 2]>,
}

impl SlowFields {
    const STEP: usize = 4;

    fn new(seed: u32, size: usize) -> Self {
        let columns = size / Self::STEP + 2;
        let values = (0..columns * columns)
            .map(|k| {
                let (column, row) = (k % columns * Self::STEP, k / columns * Self::STEP);
                let [x, y] = place_of(column, row, size);
                [
                    fbm(x * 0.035, y * 0.035, [0, 0], 4, seed ^ 0xa1),
                    fbm(x * 0.05, y * 0.11, [0, 0], 3, seed ^ 0xb1),
                ]
            })
            .collect();
        Self { columns, values }
    }

    fn at(&self, column: usize, row: usize) -> [f32; 2] {
        let (left, top) = (column / Self::STEP, row / Self::STEP);
        let part = |k: usize| (k % Self::STEP) as f32 / Self::STEP as f32;
        let at = |i: usize, j: usize| self.values[(top + j) * self.columns + left + i];
        core::array::from_fn(|n| {
            let above = lerp(at(0, 0)[n], at(1, 0)[n], part(column));
            let below = lerp(at(0, 1)[n], at(1, 1)[n], part(column));
            lerp(above, below, part(row))
        })
    }
}

fn place_of(column: usize, row: usize, size: usize) -> Place {
    let scale = 2.0 / size as f32;
    [
        ((column as f32 + 0.5) * scale - 1.0) * MAP_EDGE_DEG,
        (1.0 - (row as f32 + 0.5) * scale) * MAP_EDGE_DEG,
    ]
}

/// Albedo without vessels: warm grey-white, yellow towards the canthi, pink in the corners and
/// the fornices, bluish where the sclera thins and the uvea shows through at the limbus.
fn ground(seed: u32, settings: &ScleraMapSettings, place: Place, cloud: f32) -> [f32; 3] {
    let [x, y] = place;
    let radius = x.hypot(y);
    let fine = fbm(x * 0.4 + 90.0, y * 0.4 + 90.0, [0, 0], 2, seed ^ 0xa2);
    let age = settings.age_years / 100.0;
    let mut colour = [0.735, 0.645, 0.555];
    let mut tint = |to: [f32; 3], amount: f32| {
        let amount = amount.clamp(0.0, 1.0);
        for (value, target) in colour.iter_mut().zip(to) {
            *value = lerp(*value, target, amount);
        }
    };
    let sideways = smoothstep(32.0, 85.0, x.abs() + 4.0 * cloud);
    let level = (-(y / 38.0).powi(2)).exp();
    tint(
        [0.70, 0.615, 0.48],
        sideways * level * (0.30 + 0.45 * age) + 0.30 * age * age,
    );
    tint(
        [0.655, 0.70, 0.745],
        0.30 * (1.0 - age * 2.2).max(0.0) * (0.7 + 0.6 * cloud),
    );
    // Pinguecula: years of sun leave a yellow patch beside the limbus, more on the nasal side.
    let nasal = x * settings.nasal_sign;
    let patch = |centre: f32| (-((nasal - centre) / 6.0).powi(2) - ((y + 1.5) / 5.5).powi(2)).exp();
    let elder = smoothstep(0.3, 0.8, age);
    tint(
        [0.74, 0.64, 0.42],
        elder * (0.40 * patch(39.0) + 0.22 * patch(-39.0)) * (1.0 + cloud),
    );
    let corner = smoothstep(
        50.0,
        96.0,
        radius + 9.0 * cloud + 7.0 * smoothstep(-30.0, 60.0, nasal),
    );
    tint(
        [0.66, 0.36, 0.31],
        corner * (0.42 + 0.38 * settings.redness),
    );
    let flush = settings.redness * (0.10 + 0.14 * smoothstep(0.0, 0.6, cloud + 0.2));
    tint([0.70, 0.42, 0.37], flush);
    let uneven = 2.2 * cloud + 1.2 * value_noise(y.atan2(x) / TAU * 31.0, 31, seed ^ 0xa3);
    let limbal = smoothstep(LIMBUS_DEG + 9.0, LIMBUS_DEG - 1.0, radius + uneven);
    tint([0.44, 0.47, 0.50], 0.62 * limbal);
    let shade = 1.0 + 0.045 * cloud + 0.03 * fine;
    colour.map(|value| (value * shade).clamp(0.0, 1.0))
}

/// Fine relief of the conjunctiva, mm: soft folds that grow towards the fornices.
fn relief_mm(seed: u32, place: Place, fold: f32) -> f32 {
    let [x, y] = place;
    let loose = smoothstep(35.0, 95.0, x.hypot(y));
    let ripple = fbm(x * 0.3 + 7.0, y * 0.35 + 7.0, [0, 0], 2, seed ^ 0xb2);
    lerp(0.006, 0.03, loose) * fold + lerp(0.003, 0.007, loose) * ripple
}

#[cfg(test)]
mod tests;
