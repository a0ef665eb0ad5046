//! Attention: which candidate is looked at next.
//!
//! What enters: candidates (features with a score), the current fixation, recent fixations, the
//! visual field and random numbers. What leaves: the index of the chosen candidate, or none, in
//! which case the eye stays for another fixation. The rules are those of Nießner et al. (2013),
//! section 3: the first target is drawn near the centre by a bivariate Gaussian, the following
//! ones nearby but beyond a minimal distance from what was looked at; the visual field adapts the
//! probabilities and makes the eye skip a step. "Nearby" is a log-normal law of amplitudes that
//! puts 53 % of saccades under 5° and 83 % under 15°, as people's in a natural task; places looked
//! at before are delayed, not banned (Wilming et al. 2013).

use glam::DVec3;
use rand::Rng;

use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::visual_field::VisualField;
use crate::motion::random;

/// Something worth looking at, in head-fixed angles.
#[derive(Clone, Copy, Debug, PartialEq, bevy::reflect::Reflect)]
pub struct Candidate {
    /// Positive to the patient's right, rad.
    pub azimuth_rad: f64,
    /// Positive up, rad.
    pub elevation_rad: f64,
    /// Strength of the feature, ≥ 0; only ratios count.
    pub score: f64,
    /// Distance, m, > 0, may be infinite.
    pub distance_m: f64,
}

impl Candidate {
    /// Whether the numbers can be used: finite angles and score, a distance above 0.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.azimuth_rad.is_finite()
            && self.elevation_rad.is_finite()
            && self.score.is_finite()
            && self.score >= 0.0
            && self.distance_m > 0.0
    }

    fn gaze(&self) -> GazeAngles {
        GazeAngles::new(self.azimuth_rad, self.elevation_rad)
    }
}

/// A place that was looked at, and how long ago the eye left it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// Where.
    pub gaze: GazeAngles,
    /// Time since the eye left, s, ≥ 0.
    pub left_ago_s: f64,
}

/// The chooser's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttentionSettings {
    /// Smallest distance to the current fixation and to recent ones, rad.
    pub minimal_distance_rad: f64,
    /// Spread of the Gaussian that draws the first target, rad.
    pub first_sigma_rad: f64,
    /// Time for which a place that was left is not returned to, s; after it the place regains its
    /// attraction with the same time constant.
    pub return_delay_s: f64,
}

/// Quantiles of natural saccades (°, share below).
const AMPLITUDE_QUANTILES: [(f64, f64); 2] = [(5.0, 0.53), (15.0, 0.83)];
/// Standard normal quantiles of those two shares.
const AMPLITUDE_Z: [f64; 2] = [0.075_27, 0.954_17];
/// Bins of log amplitude in which the law is levelled against the density of candidates.
const AMPLITUDE_BINS: usize = 14;
/// Largest amplitude of the law, °.
const LARGEST_DEG: f64 = 110.0;
/// A feature that is noticed less often than this is lost.
const NOTICED_AT_LEAST: f64 = 0.1;

/// Draws the first target: a bivariate Gaussian about straight ahead, mildly favouring strong
/// features. `None` without candidates, or where the field shows none of them.
pub fn choose_first(
    candidates: &[Candidate],
    current: GazeAngles,
    field: Option<&VisualField>,
    settings: &AttentionSettings,
    rng: &mut impl Rng,
) -> Option<usize> {
    let strongest = strongest_score(candidates);
    let exponents: Vec<f64> = candidates
        .iter()
        .map(|c| {
            let angle = GazeAngles::default().angle_to(c.gaze());
            -0.5 * (angle / settings.first_sigma_rad).powi(2)
        })
        .collect();
    // Only ratios count; the largest exponent is taken off so that far features do not vanish.
    let largest = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = candidates
        .iter()
        .zip(&exponents)
        .map(|(c, exponent)| {
            (exponent - largest).exp() * salience(c, strongest) * noticed(c, current, field)
        })
        .collect();
    draw(&weights, rng)
}

/// Draws the next target after a fixation.
///
/// Amplitudes follow the law whatever the density of candidates, as far as there are candidates
/// at each amplitude. With a field, the eye skips the step as often as the target that it would
/// have chosen with a whole field is not noticed, and otherwise chooses among what is: shorter,
/// clustered paths and slower search follow from the lost field alone.
pub fn choose_next(
    candidates: &[Candidate],
    current: GazeAngles,
    history: &[Visit],
    field: Option<&VisualField>,
    settings: &AttentionSettings,
    rng: &mut impl Rng,
) -> Option<usize> {
    let strongest = strongest_score(candidates);
    let law = AmplitudeLaw::new(settings.minimal_distance_rad.to_degrees());
    let inhibition = Inhibition::new(history, settings);
    let bins: Vec<Option<usize>> = candidates
        .iter()
        .map(|c| law.bin(current.angle_to(c.gaze()).to_degrees()))
        .collect();
    let mut counts = [0_u32; AMPLITUDE_BINS];
    for bin in bins.iter().flatten() {
        counts[*bin] += 1;
    }
    let mut weights: Vec<f64> = candidates
        .iter()
        .zip(&bins)
        .map(|(c, bin)| {
            bin.map_or(0.0, |bin| {
                law.share(bin) / f64::from(counts[bin])
                    * salience(c, strongest)
                    * inhibition.attraction_at(c.gaze().direction())
            })
        })
        .collect();
    // The number is drawn with or without a field, so that both see the same stream.
    let skip = random::uniform(rng);
    if field.is_some() {
        let whole: f64 = weights.iter().sum();
        for (weight, candidate) in weights.iter_mut().zip(candidates) {
            if *weight > 0.0 {
                *weight *= noticed(candidate, current, field);
            }
        }
        let left: f64 = weights.iter().sum();
        if skip * whole >= left {
            return None;
        }
    }
    draw(&weights, rng)
}

/// People's law of amplitudes, shifted so that it starts at the minimal distance.
struct AmplitudeLaw {
    minimal_deg: f64,
    mu: f64,
    sigma: f64,
}

impl AmplitudeLaw {
    fn new(minimal_deg: f64) -> Self {
        // Below 4.5° so that the first quantile stays above the minimum.
        let minimal_deg = minimal_deg.clamp(0.05, 4.5);
        let [low, high] = AMPLITUDE_QUANTILES.map(|(deg, _)| (deg - minimal_deg).ln());
        let sigma = (high - low) / (AMPLITUDE_Z[1] - AMPLITUDE_Z[0]);
        Self {
            minimal_deg,
            mu: low - sigma * AMPLITUDE_Z[0],
            sigma,
        }
    }

    fn edge_deg(&self, bin: usize) -> f64 {
        let share = bin as f64 / AMPLITUDE_BINS as f64;
        self.minimal_deg * (LARGEST_DEG / self.minimal_deg).powf(share)
    }

    /// The bin of an amplitude, or `None` below the minimal distance.
    fn bin(&self, amplitude_deg: f64) -> Option<usize> {
        if amplitude_deg < self.minimal_deg {
            return None;
        }
        let place = (amplitude_deg / self.minimal_deg).ln() / (LARGEST_DEG / self.minimal_deg).ln();
        Some(((place * AMPLITUDE_BINS as f64) as usize).min(AMPLITUDE_BINS - 1))
    }

    /// Probability of a bin.
    fn share(&self, bin: usize) -> f64 {
        self.below(self.edge_deg(bin + 1)) - self.below(self.edge_deg(bin))
    }

    fn below(&self, amplitude_deg: f64) -> f64 {
        let excess = amplitude_deg - self.minimal_deg;
        if excess <= 0.0 {
            0.0
        } else {
            normal_cdf((excess.ln() - self.mu) / self.sigma)
        }
    }
}

/// The standard normal distribution function by Abramowitz and Stegun 26.2.17, to 7.5e-8.
fn normal_cdf(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let poly = t
        * (0.319_381_530
            + t * (-0.356_563_782
                + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * poly;
    if z >= 0.0 { 1.0 - tail } else { tail }
}

fn strongest_score(candidates: &[Candidate]) -> f64 {
    candidates.iter().map(|c| c.score).fold(0.0, f64::max)
}

/// A strong feature attracts up to three times as much as a weak one.
fn salience(candidate: &Candidate, strongest: f64) -> f64 {
    if strongest > 0.0 {
        0.5 + candidate.score / strongest
    } else {
        1.0
    }
}

/// The chance that a candidate is noticed from the current fixation; 0 where it is lost.
fn noticed(candidate: &Candidate, current: GazeAngles, field: Option<&VisualField>) -> f64 {
    let Some(field) = field else { return 1.0 };
    let place = current.field_position_of(candidate.gaze());
    let seen = field.seen(place.azimuth_rad, place.elevation_rad);
    if seen < NOTICED_AT_LEAST { 0.0 } else { seen }
}

/// What is left of the attraction of a place that was left `left_ago_s` ago.
fn attraction_after(left_ago_s: f64, return_delay_s: f64) -> f64 {
    if return_delay_s <= 0.0 {
        return 1.0;
    }
    let since = left_ago_s / return_delay_s - 1.0;
    if since <= 0.0 {
        0.0
    } else {
        -(-since).exp_m1()
    }
}

/// The places where something was looked at so lately that they attract less.
struct Inhibition {
    places: Vec<(DVec3, f64)>,
    cos_radius: f64,
}

impl Inhibition {
    fn new(history: &[Visit], settings: &AttentionSettings) -> Self {
        let left = |visit: &Visit| attraction_after(visit.left_ago_s, settings.return_delay_s);
        Self {
            places: history
                .iter()
                .map(|visit| (visit.gaze.direction(), left(visit)))
                .filter(|(_, left)| *left < 1.0)
                .collect(),
            cos_radius: settings.minimal_distance_rad.cos(),
        }
    }

    fn attraction_at(&self, direction: DVec3) -> f64 {
        self.places
            .iter()
            .filter(|(place, _)| place.dot(direction) > self.cos_radius)
            .fold(1.0, |least, (_, left)| least.min(*left))
    }
}

/// Draws an index in proportion to its weight; `None` when no weight is positive.
fn draw(weights: &[f64], rng: &mut impl Rng) -> Option<usize> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut left = random::uniform(rng) * total;
    let mut last = None;
    for (index, weight) in weights.iter().enumerate() {
        if *weight > 0.0 {
            if left < *weight {
                return Some(index);
            }
            left -= weight;
            // Rounding can leave a crumb after the last one, which then takes it.
            last = Some(index);
        }
    }
    last
}

#[cfg(test)]
#[path = "attention_tests.rs"]
mod tests;
