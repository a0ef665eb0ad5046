//! The visual field: what an eye sees where, whole or with losses.
//!
//! What enters: a direction relative to the line of sight, the eye's side, its owner's age and the
//! losses that conditions cause. What leaves: sensitivity in dB, the chance that a feature there is
//! noticed, the mean deviation, and the blur that comes with eccentricity. The normal field is the
//! 24-2 table of 91 controls (open SUNY-IU data, age 50, −0.061 dB a year), continued along each
//! meridian to the field's border; losses are even, or follow the nerve-fibre paths of
//! [`nerve_fibre`] (Jansonius et al. 2009).
//!
//! Field coordinates are the perimetrist's: eccentricity and meridian in degrees, x to the
//! patient's right, y up. Tables are for OD; OS is its mirror image.

pub mod nerve_fibre;

use super::Laterality;
use super::gaze::GazeAngles;
use crate::optics::smoothstep::smoothstep;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::Component;
use bevy::reflect::Reflect;
use nerve_fibre::bundle_of;

/// Sensitivity at which every second feature is noticed, dB. A model choice: the features of a
/// scene are far larger and stronger than a perimeter's spot, so they survive a moderate loss.
const SEEN_MIDPOINT_DB: f64 = 10.0;
/// Steepness of that chance, dB.
const SEEN_SPREAD_DB: f64 = 2.5;
/// Change of normal sensitivity with age, dB a year, about age 50.
const DB_PER_YEAR: f64 = -0.061;
/// Eccentricity at which acuity has halved, ° (E2 of letter acuity, within the published 1.5–3).
const ACUITY_E2_DEG: f64 = 2.5;
/// Foveal minimum angle of resolution, arcmin.
const FOVEAL_MAR_ARCMIN: f64 = 1.0;
/// Centre of the blind spot of OD and its two full diameters, °.
const BLIND_SPOT_DEG: [f64; 4] = [15.0, -1.5, 5.5, 7.5];

/// Border of the normal field of OD by meridian, °, every 45° from temporal by way of up.
const EXTENT_DEG: [f64; 8] = [85.0, 55.0, 45.0, 55.0, 60.0, 50.0, 65.0, 85.0];

const COLUMNS: usize = 10;
/// Normal sensitivity of OD at 50 years, dB, on the 6° grid x = −27 … 27 in rows y = 21 … −21.
/// NaN: not tested, filled from the neighbour towards the centre. The two places on the blind spot
/// hold the mean of their neighbours in the row; the spot itself is added as an ellipse.
const NORMAL_DB: [[f64; COLUMNS]; 8] = {
    const N: f64 = f64::NAN;
    [
        [N, N, N, 27.5, 27.4, 26.5, 26.5, N, N, N],
        [N, N, 28.7, 29.6, 29.5, 29.1, 29.6, 29.0, N, N],
        [N, 29.1, 30.6, 31.7, 31.6, 31.3, 30.5, 30.5, 29.6, N],
        [27.5, 29.9, 31.7, 32.7, 33.2, 33.0, 32.2, 31.2, 30.2, N],
        [27.6, 30.1, 32.2, 33.0, 33.4, 33.7, 32.7, 31.65, 30.6, N],
        [N, 29.2, 31.5, 32.7, 32.5, 32.5, 32.2, 31.6, 30.4, N],
        [N, N, 30.4, 31.2, 31.1, 31.1, 31.4, 31.2, N, N],
        [N, N, N, 29.8, 29.9, 30.3, 30.5, N, N, N],
    ]
};
/// Fall from a tested place to an untested one next to it, dB in 6°.
const FILL_STEP_DB: f64 = 2.0;

/// The field of one eye, and what it has lost.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct VisualField {
    eye: Laterality,
    age_years: f64,
    even_loss_db: f64,
    bundle_losses: Vec<BundleLoss>,
    eccentricity_factor: f64,
    normal_db: [[f64; COLUMNS]; 8],
}

/// Loss along one group of nerve-fibre bundles.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct BundleLoss {
    /// Centre of the group at the disc, ° (positive above on the retina, so below in the field).
    pub centre_deg: f64,
    /// Spread of the group at the disc, °, above 0.
    pub spread_deg: f64,
    /// Deepest loss, dB.
    pub depth_db: f64,
    /// Share of the loss that already stands near the disc, 0–1; the rest comes at the far end, which
    /// makes the nasal step.
    pub near_share: f64,
}

impl VisualField {
    /// The normal field of an eye at an age in years (0–120; others count as the nearer end).
    #[must_use]
    pub fn normal(eye: Laterality, age_years: f64) -> Self {
        Self {
            eye,
            age_years: if age_years.is_finite() {
                age_years.clamp(0.0, 120.0)
            } else {
                50.0
            },
            even_loss_db: 0.0,
            bundle_losses: Vec::new(),
            eccentricity_factor: 1.0,
            normal_db: filled_table(),
        }
    }

    /// Takes `even_db` everywhere and each group of bundles what it has lost, dB; the blur that comes
    /// with eccentricity grows `eccentricity_factor` times (1 and more).
    pub fn lose(&mut self, even_db: f64, bundles: &[BundleLoss], eccentricity_factor: f64) {
        self.even_loss_db += even_db.max(0.0);
        self.bundle_losses.extend_from_slice(bundles);
        self.eccentricity_factor *= eccentricity_factor.max(1.0);
    }

    /// Has nothing been lost?
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.even_loss_db == 0.0 && self.bundle_losses.is_empty() && self.eccentricity_factor == 1.0
    }

    /// How much faster than in a healthy eye blur grows with eccentricity, 1 and more
    /// ([`eccentricity_blur_rad`]).
    #[must_use]
    pub fn eccentricity_factor(&self) -> f64 {
        self.eccentricity_factor
    }

    /// Sensitivity, dB, in a direction relative to the line of sight (rad, right and up): 0 in the
    /// blind spot and outside the field.
    #[must_use]
    pub fn sensitivity_db(&self, azimuth_rel: f64, elevation_rel: f64) -> f64 {
        self.place(azimuth_rel, elevation_rel)
            .map_or(0.0, |(x, y)| self.sensitivity_at_deg(x, y))
    }

    /// The chance that a feature in that direction is noticed, 0–1; exactly 0 outside the field.
    #[must_use]
    pub fn seen(&self, azimuth_rel: f64, elevation_rel: f64) -> f64 {
        match self.place(azimuth_rel, elevation_rel) {
            Some((x, y)) if x.hypot(y) < extent_deg(x, y) => {
                let db = self.sensitivity_at_deg(x, y);
                1.0 / (1.0 + ((SEEN_MIDPOINT_DB - db) / SEEN_SPREAD_DB).exp())
            }
            _ => 0.0,
        }
    }

    /// Loss against the normal field of the same age, dB, as perimetry would find it: it cannot
    /// exceed the sensitivity that there was.
    #[must_use]
    pub fn loss_db(&self, azimuth_rel: f64, elevation_rel: f64) -> f64 {
        self.place(azimuth_rel, elevation_rel)
            .map_or(0.0, |(x, y)| {
                self.normal_at_deg(x, y) - self.sensitivity_at_deg(x, y)
            })
    }

    /// Mean of the deviations from normal over the 52 places of the 24-2 that are not on the blind
    /// spot, dB, unweighted (a perimeter weights them by their normal variance).
    #[must_use]
    pub fn mean_deviation_db(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (row, values) in NORMAL_DB.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                let (x, y) = grid_place_deg(row, column);
                let blind = (x - 15.0).abs() < 1.0 && y.abs() < 4.0;
                if value.is_finite() && !blind {
                    sum += self.sensitivity_at_deg(x, y) - self.normal_at_deg(x, y);
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    /// Field coordinates of OD, °, or `None` for what is not a direction.
    fn place(&self, azimuth_rel: f64, elevation_rel: f64) -> Option<(f64, f64)> {
        if !(azimuth_rel.is_finite() && elevation_rel.is_finite()) {
            return None;
        }
        let v = GazeAngles::new(azimuth_rel, elevation_rel).direction();
        let across = v.x.hypot(v.y);
        if across == 0.0 {
            return (v.z < 0.0).then_some((0.0, 0.0));
        }
        let eccentricity_deg = across.atan2(-v.z).to_degrees();
        let mirror = match self.eye {
            Laterality::OD => 1.0,
            Laterality::OS => -1.0,
        };
        Some((
            mirror * eccentricity_deg * v.x / across,
            eccentricity_deg * v.y / across,
        ))
    }

    fn sensitivity_at_deg(&self, x: f64, y: f64) -> f64 {
        (self.normal_at_deg(x, y) - self.pathological_loss_db(x, y)).max(0.0)
    }

    fn normal_at_deg(&self, x: f64, y: f64) -> f64 {
        let eccentricity = x.hypot(y);
        let border = extent_deg(x, y);
        if eccentricity >= border {
            return 0.0;
        }
        // Inside the tested rectangle the table speaks; outside, its edge falls to 0 at the border.
        let shrink = (27.0 / x.abs()).min(21.0 / y.abs()).min(1.0);
        let edge = bilinear(&self.normal_db, x * shrink, y * shrink);
        let aged = edge + DB_PER_YEAR * (self.age_years - 50.0);
        let reach = eccentricity * shrink;
        let share = if shrink < 1.0 {
            (border - eccentricity) / (border - reach)
        } else {
            1.0
        };
        (aged * share * outside_blind_spot(x, y)).max(0.0)
    }

    fn pathological_loss_db(&self, x: f64, y: f64) -> f64 {
        if self.bundle_losses.is_empty() {
            return self.even_loss_db;
        }
        // The retina is the field upside down.
        let bundle = bundle_of(x, -y);
        let along = smoothstep(10.0, 30.0, bundle.distance_deg);
        self.bundle_losses
            .iter()
            .fold(self.even_loss_db, |sum, group| {
                let offset: f64 = (bundle.angle_deg - group.centre_deg) / group.spread_deg;
                let share = group.near_share + (1.0 - group.near_share) * along;
                sum + group.depth_db * share * (-0.5 * offset * offset).exp()
            })
    }
}

/// Additional diameter of the blur disc at an eccentricity (rad), rad: what the periphery's
/// coarser sampling costs, MAR(E) − MAR(0) with MAR = 1′ (1 + E/2.5°), the linear law of cortical
/// magnification, times a factor of 1 for a healthy eye and more for one that has lost fibres
/// ([`VisualField::eccentricity_factor`]). Zero where one looks; constant beyond 90°.
#[must_use]
pub fn eccentricity_blur_rad(eccentricity_rad: f64, factor: f64) -> f64 {
    let eccentricity_deg = eccentricity_rad.abs().to_degrees().min(90.0);
    let arcmin = FOVEAL_MAR_ARCMIN * eccentricity_deg / ACUITY_E2_DEG;
    factor.max(0.0) * (arcmin / 60.0).to_radians()
}

/// Border of the normal field of OD towards (x, y), °.
fn extent_deg(x: f64, y: f64) -> f64 {
    let sector = y.atan2(x).to_degrees().rem_euclid(360.0) / 45.0;
    let low = (sector.floor() as usize).min(7);
    let share = sector - low as f64;
    EXTENT_DEG[low] * (1.0 - share) + EXTENT_DEG[(low + 1) % 8] * share
}

/// 0 inside the blind spot, 1 outside, with an edge a fifth of its radius wide.
fn outside_blind_spot(x: f64, y: f64) -> f64 {
    let [centre_x, centre_y, width, height] = BLIND_SPOT_DEG;
    let radius = (2.0 * (x - centre_x) / width).hypot(2.0 * (y - centre_y) / height);
    smoothstep(0.9, 1.1, radius)
}

fn grid_place_deg(row: usize, column: usize) -> (f64, f64) {
    (-27.0 + 6.0 * column as f64, 21.0 - 6.0 * row as f64)
}

/// The table with its untested corners filled outwards from the tested part of each row.
fn filled_table() -> [[f64; COLUMNS]; 8] {
    let mut table = NORMAL_DB;
    for row in &mut table {
        for column in COLUMNS / 2..COLUMNS {
            if row[column].is_nan() {
                row[column] = row[column - 1] - FILL_STEP_DB;
            }
        }
        for column in (0..COLUMNS / 2).rev() {
            if row[column].is_nan() {
                row[column] = row[column + 1] - FILL_STEP_DB;
            }
        }
    }
    table
}

fn bilinear(table: &[[f64; COLUMNS]; 8], x: f64, y: f64) -> f64 {
    let column = ((x + 27.0) / 6.0).clamp(0.0, (COLUMNS - 1) as f64);
    let row = ((21.0 - y) / 6.0).clamp(0.0, 7.0);
    let (c, r) = ((column as usize).min(COLUMNS - 2), (row as usize).min(6));
    let (u, v) = (column - c as f64, row - r as f64);
    let across = |r: usize| table[r][c] * (1.0 - u) + table[r][c + 1] * u;
    across(r) * (1.0 - v) + across(r + 1) * v
}

#[cfg(test)]
mod tests;
