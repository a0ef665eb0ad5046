//! A seeded white of the eye: colour, blood and fine relief of the front of the globe.
//!
//! In: [`ScleraMapSettings`] and a size. Out: two square maps in the azimuthal equidistant projection
//! about the corneal axis: the distance from the centre is the angle at the globe's centre,
//! [`MAP_EDGE_DEG`] at the middle of each edge. Right in the map is +x of the globe frame (the
//! patient's right), up is +y. The coarse one holds the colour of the tissue without the vessels that are seen
//! singly, by [`crate::tissue::sclera`]: what varies over the globe is its thickness, its blood and its yellow
//! pigment. The fine one holds the vessels as columns of blood, the superficial ones and the deep ones
//! apart, and the relief; the shader ([`super::shading::sclera_shade`]) sees each at its own depth.
//!
//! What is drawn follows the anatomy of the bulbar conjunctiva and episclera (Bron, Tripathi and
//! Tripathi, "Wolff's Anatomy of the Eye and Orbit", 1997): conjunctival vessels come from the
//! fornices and the canthi, branch and wind towards the limbus; the anterior ciliary vessels of
//! the four recti lie deeper, straighter, and dive some 4 mm before it; fine loops fringe the
//! limbus. Towards the limbus the scleral lamellae thin out over the dark angle behind.

use crate::frame::mips::{Level, chain};
use core::f32::consts::TAU;

use serde::{Deserialize, Serialize};

mod vessels;

use crate::optics::fresnel::diffuse_surface;
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{fbm, gradient_noise, lerp, value_noise, worley};
use crate::tissue::sclera::{SCLERA_INDEX, ScleraTable, ScleralTissue, epithelium_passes};

/// Angle from the corneal axis at the middle of the map's edges, degrees.
pub const MAP_EDGE_DEG: f32 = 100.0;
/// Angle of the limbus at the centre of an 11.5 mm globe, degrees: asin(5.9 / 11.5).
pub const LIMBUS_DEG: f32 = 30.9;

/// Thickness of a sclera above, below, nasally and temporally, mm (Teeuw, 107 people), at
/// [`MEASURED_AGE`] years, and how it grows with each year.
const THICKNESS_MM: [f32; 4] = [0.467, 0.596, 0.567, 0.516];
const THICKER_MM_A_YEAR: f32 = 0.000_96;
const MEASURED_AGE: f32 = 45.0;
/// It is thinner at the equator than at the limbus by this factor (Vurgese 2012: 0.42 of 0.50 mm).
const EQUATOR_SHARE: f32 = 0.84;
/// Blood in vessels not seen singly: share of the volume in a quiet eye, what full redness adds, and
/// what the corners have beyond.
const QUIET_BLOOD: f32 = 0.009;
const RED_BLOOD: f32 = 0.014;
const CORNER_BLOOD: f32 = 0.05;

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
    /// Bilirubin in the serum, mg/dL, 0–50; healthy people have 0.2 to 1.2, and from 2.5 the white is
    /// seen to be yellow.
    pub bilirubin_mg_dl: f32,
    /// How much elastotic tissue lies beside the limbus, 0 (none) – 1 (a raised, yellow pinguecula).
    pub pinguecula: f32,
    /// Where the nose is: −1 for a right eye (nasal = −x), 1 for a left eye.
    pub nasal_sign: f32,
    /// How far out it turns pink, against its own distance, 0.5 to 1.5.
    pub flush_radius: f32,
    /// How sharply it does, against its own, 0.25 to 4.
    pub flush_hardness: f32,
    /// Melanosomes in the epithelium, share of its volume, 0 to 0.2: in the mean of where they are, about the limbus and between the
    /// lids.
    pub melanin: f32,
}

impl Default for ScleraMapSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            age_years: 30.0,
            redness: 0.2,
            bilirubin_mg_dl: 0.6,
            pinguecula: 0.0,
            nasal_sign: -1.0,
            flush_radius: 1.0,
            flush_hardness: 1.0,
            melanin: 0.0,
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
            bilirubin_mg_dl: legal(self.bilirubin_mg_dl, 0.0, 50.0, default.bilirubin_mg_dl),
            pinguecula: legal(self.pinguecula, 0.0, 1.0, default.pinguecula),
            nasal_sign: if self.nasal_sign > 0.0 { 1.0 } else { -1.0 },
            flush_radius: legal(self.flush_radius, 0.5, 1.5, default.flush_radius),
            flush_hardness: legal(self.flush_hardness, 0.25, 4.0, default.flush_hardness),
            melanin: legal(self.melanin, 0.0, 0.2, default.melanin),
        }
    }
}

/// The baked maps, rows from the top (+y) down.
#[derive(Clone, Debug, PartialEq)]
pub struct ScleraMap {
    /// Texels along each side of the map of colour.
    pub size: usize,
    /// Linear red, green, blue albedo (0–1) without the vessels that are seen singly, and 1.
    pub texels: Vec<[f32; 4]>,
    /// Texels along each side of the map of vessels.
    pub vessels_size: usize,
    /// Columns of blood, mm, in conjunctival vessels and in those of the episclera and deeper; relief, mm (about
    /// ±0.13, positive outwards); height of the lumps of plica and caruncle, mm, which stand in the head: about the direction that
    /// an eye has straight ahead.
    pub vessels: Vec<[f32; 4]>,
}

/// A direction of the map: degrees right (+x) and up (+y) of the corneal axis.
type Place = [f32; 2];

/// The map of colour is this much coarser than that of vessels, and so are the deep vessels, which scattering blurs.
const COARSER: usize = 4;

impl ScleraMap {
    /// Grows the sclera of `settings`, its vessels on `size` × `size` texels (64–4096, brought to a multiple of 4).
    #[must_use]
    pub fn new(settings: &ScleraMapSettings, size: usize) -> Self {
        let settings = settings.clamped();
        let seed = settings.seed;
        let coarse = (size / COARSER).clamp(16, 1024);
        let fine = coarse * COARSER;
        let blood = vessels::grow(seed, &settings, fine, coarse);
        let table = ScleraTable::new(
            f64::from(settings.bilirubin_mg_dl),
            diffuse_surface(SCLERA_INDEX),
        );
        let epithelium = epithelium_passes(f64::from(settings.melanin)).map(|c| c as f32);
        let slow = SlowFields::new(seed, fine);
        let texels = (0..coarse * coarse)
            .map(|index| {
                let (column, row) = (index % coarse, index / coarse);
                let cloud = slow.values[row * slow.columns + column][0];
                ground(
                    seed,
                    &settings,
                    (&table, epithelium),
                    place_of(column, row, coarse),
                    cloud,
                )
            })
            .collect();
        let vessels = (0..fine * fine)
            .map(|index| {
                let (column, row) = (index % fine, index / fine);
                let fold = slow.at(column, row)[1];
                let lump = if settings.pinguecula > 0.0 {
                    settings.pinguecula * pinguecula(&settings, place_of(column, row, fine))
                } else {
                    0.0
                };
                [
                    blood.shallow[index],
                    bilinear(&blood.deep, coarse, column, row),
                    relief_mm(seed, place_of(column, row, fine), fold)
                        + 0.06 * lump
                        + VESSEL_RISE * blood.shallow[index],
                    lumps_mm(seed, &settings, place_of(column, row, fine)),
                ]
            })
            .collect();
        Self {
            size: coarse,
            texels,
            vessels_size: fine,
            vessels,
        }
    }

    /// The bilinear colour in direction (`x_deg` right, `y_deg` up of the corneal axis, measured
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

    /// Levels of the map of colour, the finest first.
    #[must_use]
    pub fn levels(&self) -> Vec<Level<4>> {
        chain((self.size, self.size), self.texels.clone())
    }

    /// Levels of the map of vessels.
    #[must_use]
    pub fn vessel_levels(&self) -> Vec<Level<4>> {
        let side = self.vessels_size;
        chain((side, side), self.vessels.clone())
    }
}

/// A coarse field at a texel of the fine map.
fn bilinear(field: &[f32], coarse: usize, column: usize, row: usize) -> f32 {
    let place = |k: usize| {
        let at = ((k as f32 + 0.5) / COARSER as f32 - 0.5).clamp(0.0, (coarse - 1) as f32);
        (at as usize, at.fract())
    };
    let ((x, fx), (y, fy)) = (place(column), place(row));
    let at = |i: usize, j: usize| field[(y + j).min(coarse - 1) * coarse + (x + i).min(coarse - 1)];
    lerp(
        lerp(at(0, 0), at(1, 0), fx),
        lerp(at(0, 1), at(1, 1), fx),
        fy,
    )
}

/// Slowly varying noises, evaluated at every fourth texel and bilinear in between.
struct SlowFields {
    columns: usize,
    /// Clouds of colour and folds of the conjunctiva, each in −1 to 1.
    values: Vec<[f32; 2]>,
}

impl SlowFields {
    const STEP: usize = COARSER;

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

/// How much of a pinguecula lies at a place, 0–1: beside the limbus in the open fissure, more on the nasal side,
/// about 2.2 mm tall and wider than tall.
fn pinguecula(settings: &ScleraMapSettings, [x, y]: Place) -> f32 {
    let nasal = x * settings.nasal_sign;
    let patch = |centre: f32| (-((nasal - centre) / 6.5).powi(2) - ((y + 1.5) / 5.5).powi(2)).exp();
    patch(39.0) + 0.55 * patch(-39.0)
}

/// Thickness of the sclera, mm, without what the limbus takes of it.
fn thickness_mm(settings: &ScleraMapSettings, [x, y]: Place) -> f32 {
    let radius = x.hypot(y).max(1e-3);
    let (across, up) = ((x / radius).powi(2), (y / radius).powi(2));
    let vertical = THICKNESS_MM[usize::from(y < 0.0)];
    let horizontal = THICKNESS_MM[2 + usize::from(x * settings.nasal_sign < 0.0)];
    let aged = THICKER_MM_A_YEAR * (settings.age_years - MEASURED_AGE);
    let far = smoothstep(LIMBUS_DEG, 90.0, radius);
    (across * horizontal + up * vertical + aged) * lerp(1.0, EQUATOR_SHARE, far)
}

/// Albedo without vessels.
fn ground(
    seed: u32,
    settings: &ScleraMapSettings,
    (table, epithelium): (&ScleraTable, [f32; 3]),
    place: Place,
    cloud: f32,
) -> [f32; 4] {
    let [x, y] = place;
    let radius = x.hypot(y);
    let fine = fbm(x * 0.4 + 90.0, y * 0.4 + 90.0, [0, 0], 2, seed ^ 0xa2);
    let age = settings.age_years / 100.0;
    let nasal = x * settings.nasal_sign;
    // The lamellae end one after another over some 1.5 mm.
    let uneven = 2.2 * cloud + 1.2 * value_noise(y.atan2(x) / TAU * 31.0, 31, seed ^ 0xa3);
    let lamellae = smoothstep(LIMBUS_DEG - 3.0, LIMBUS_DEG + 8.0, radius + uneven);
    // Towards the canthi the conjunctiva thickens and is full of blood, most of all over the last third to the nose.
    let level = (-(y / 45.0).powi(2)).exp();
    let flush = |low: f32, high: f32, at: f32| {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let from = middle * settings.flush_radius;
        let half = half / settings.flush_hardness;
        smoothstep(from - half, from + half, at)
    };
    let corner = flush(50.0, 95.0, radius + 9.0 * cloud)
        .max(level * flush(40.0, 74.0, nasal + 6.0 * cloud))
        .max(0.7 * level * flush(46.0, 84.0, -nasal + 6.0 * cloud));
    // It bleeds and yellows in patches, and what the sun reaches between the lids yellows most.
    let sideways = smoothstep(32.0, 80.0, x.abs() + 4.0 * cloud) * (-(y / 38.0).powi(2)).exp();
    let elastotic = pinguecula(settings, place) * (1.0 + cloud);
    let tissue = ScleralTissue {
        // About the limbus' radius half of them end; how they let the cornea be seen is the shader's.
        sclera_mm: f64::from(thickness_mm(settings, place) * lerp(0.5, 1.0, lamellae)),
        blood_share: f64::from(
            (QUIET_BLOOD * (0.8 + 0.4 * age)
                + RED_BLOOD * settings.redness.powi(2)
                + CORNER_BLOOD * corner.powf(1.5) * (1.0 + settings.redness))
                * (1.0 + 0.5 * cloud + 0.25 * fine).max(0.1),
        ),
        yellowing: f64::from(
            0.15 + 0.9 * age
                + sideways * (0.3 + 0.9 * age)
                + 5.0 * elastotic * settings.pinguecula.max(0.35 * smoothstep(0.3, 0.8, age)),
        ),
        ..ScleralTissue::default()
    };
    let white = table.sample(&tissue).map(|c| c as f32);
    let shade = 1.0 + 0.02 * cloud + 0.012 * fine;
    let ring = smoothstep(LIMBUS_DEG + 16.0, LIMBUS_DEG, radius + 7.0 * cloud);
    let patch = (0.3 + 1.4 * ring + 0.4 * sideways) * (1.0 + 0.9 * cloud + 0.4 * fine).max(0.0);
    let [red, green, blue] = core::array::from_fn(|c| white[c] * shade * epithelium[c].powf(patch));
    [red, green, blue, 1.0]
}

/// Angle from the front within which the inner corner shows nothing of plica and caruncle, degrees.
const LUMPS_FROM_DEG: f32 = 32.0;

/// Height, mm, of the lumps that make plica and caruncle uneven: lobules of glands 0.5 mm wide, papillae of half of that (choices).
fn lumps_mm(seed: u32, settings: &ScleraMapSettings, [x, y]: Place) -> f32 {
    if x * settings.nasal_sign < LUMPS_FROM_DEG || y.abs() > 45.0 {
        return 0.0;
    }
    // Five degrees are a millimetre.
    let lobules = worley(x * 0.4, y * 0.4, [0, 0], seed ^ 0xb3);
    let papillae = worley(x * 0.95, y * 0.85, [0, 0], seed ^ 0xb4);
    let dome = |nearest: f32| (1.0 - nearest * nearest).max(0.0);
    let there = smoothstep(
        LUMPS_FROM_DEG,
        LUMPS_FROM_DEG + 4.0,
        x * settings.nasal_sign,
    ) * smoothstep(45.0, 40.0, y.abs());
    there * (0.085 * dome(lobules.nearest) + 0.03 * dome(papillae.nearest))
}

/// Fine relief of the conjunctiva, mm: soft folds that grow towards the fornices.
fn relief_mm(seed: u32, place: Place, fold: f32) -> f32 {
    let [x, y] = place;
    let loose = smoothstep(35.0, 95.0, x.hypot(y));
    let ripple = fbm(x * 0.3 + 7.0, y * 0.35 + 7.0, [0, 0], 2, seed ^ 0xb2);
    let broad = lerp(0.006, 0.03, loose) * fold + lerp(0.003, 0.007, loose) * ripple;
    let ends = smoothstep(FINE_TO_DEG, FINE_TO_DEG - 12.0, x.hypot(y));
    if ends <= 0.0 {
        return broad;
    }
    let fine: f32 = FINE_RELIEF
        .iter()
        .map(|(per_deg, height)| {
            let noise = |turn: f32| {
                gradient_noise(
                    0.8 * x * per_deg + turn,
                    1.2 * y * per_deg,
                    [0, 0],
                    seed ^ 0xb5,
                )
            };
            height * noise(per_deg * 100.0)
        })
        .sum();
    let tight = lerp(0.5, 1.0, smoothstep(LIMBUS_DEG, 45.0, x.hypot(y)));
    broad + ends * tight * lerp(0.3, 1.6, smoothstep(-0.5, 0.5, fold)) * fine
}

/// How far a vessel lifts the epithelium over it, of its column of blood: the loose tissue gives way below more than above (a choice).
const VESSEL_RISE: f32 = 0.12;

/// The fine relief of the conjunctiva, which breaks what its tears mirror: cells for each degree (0.2 mm), and height, mm. It lies tight at the limbus
/// (half of that), is smooth in places, and ends in the 12 degrees before where no lid opens. Choices by the look of macro photographs: their slopes, 0.044 rad in the mean,
/// break the image of a softbox into patches of some 0.3 mm and specks about them.
const FINE_RELIEF: [(f32, f32); 2] = [(0.42, 0.018), (1.05, 0.0045)];
const FINE_TO_DEG: f32 = 85.0;

#[cfg(test)]
mod tests;
