//! Glare: how the eye's media scatter the light of a source over the retina.
//!
//! In: the angle from the source (rad), age (years), pigmentation of the eye. Out: the spread
//! function (sr⁻¹), its energy within any cone and the straylight parameter.
//!
//! The total glare function of CIE 135/1-1999 (Vos & van den Berg, *Report on disability glare*,
//! the complete equation; also equation 2 of McCann & Vonikakis 2018, Front. Psychol. 8:2079), with
//! θ in degrees, `a = (age/70)⁴` and the pigmentation `p` (0 very dark eyes, 0.5 brown, 1 green,
//! 1.2 light blue):
//!
//! ```text
//! f = [1 − 0.08 a] [9.2e6/(1 + (θ/0.0046)²)^1.5 + 1.5e5/(1 + (θ/0.045)²)^1.5]
//!   + [1 + 1.6 a] {400/(1 + (θ/0.1)²) + 3e-8 θ²
//!                  + p [1300/(1 + (θ/0.1)²)^1.5 + 0.8/(1 + (θ/0.1)²)^0.5]}
//!   + 2.5e-3 p
//! ```
//!
//! The narrowest width is 0.0046°: with the 0.046° that many copies print, the function holds 38
//! times the light that enters (see the tests). As published it holds 1.03 of the light within the
//! hemisphere for a young brown eye, 1.005 for a young eye without the pigment terms, and more with
//! age (1.07 at 70 years, 1.53 at the extreme of 110 years and a light blue iris);
//! [`Glare::normalised`] scales it to exactly 1. It describes the mean of many observers: log s of
//! individuals of one age has a standard deviation of 0.1 to 0.2. It is stated for angles up to
//! 100° and extrapolated beyond. Its core stands for the aberrations of an average eye, whatever its
//! pupil: a renderer with its own blur takes only what lies outside a few minutes of arc
//! ([`Glare::share_outside`]).
//!
//! **Energy in closed form.** Within a cone of half-angle θ it is `2π ∫ f sin t dt`. The sine's
//! series turns every term into moments `∫ t^(2j+1)/(1 + t²/b²)^k dt`, and these follow from one
//! another by recurrences (integration by parts), for k = ½, 1 and 3/2 alike. No quadrature: the
//! error is rounding, below 1e-12 of the whole.
//!
//! **Modulation transfer in closed form.** On the plane of small angles the terms' two-dimensional
//! Fourier transforms are `2π b² e^{−kb}`, `2π b² K₀(kb)` and `2π b² e^{−kb}/(kb)` for the powers 3/2,
//! 1 and ½ ([`Glare::modulation`]). (A one-dimensional transform of the same function, which is in
//! use, is not the eye's transfer.)
//!
//! For comparison, the simplified equations of CIE 146:2002 stand beside it ([`glare_general`],
//! [`glare_small_angle`], [`glare_age_adjusted`]) with the classical [`glare_stiles_holladay`].

mod veil;

pub use veil::{VEIL_LEVELS, Veil, VeilKernel, VeilSource, cubic_spline, stereographic};

use super::fresnel::clamp_or;
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Youngest and oldest age (years); what lies outside counts as the nearer one.
pub const GLARE_AGE_RANGE_YEARS: (f64, f64) = (1.0, 110.0);
/// Largest pigmentation factor (light blue eyes); 0 is the smallest.
pub const GLARE_LARGEST_PIGMENT: f64 = 1.2;

/// The widths of the terms (degrees).
const CORE_DEG: f64 = 0.0046;
const HALO_DEG: f64 = 0.045;
const WIDE_DEG: f64 = 0.1;

/// Standard observer for ages and pigments that are not numbers.
const STANDARD_AGE_YEARS: f64 = 30.0;
const STANDARD_PIGMENT: f64 = 0.5;

/// The glare function of one eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Weight of the two narrow terms, `1 − 0.08 a`.
    core: f64,
    /// Weight of the wide terms, `1 + 1.6 a`.
    wide: f64,
    pigment: f64,
    scale: f64,
}

impl Glare {
    /// The eye of an age and a pigmentation. The age is limited to 1 to 110 years, the pigmentation
    /// to 0 to 1.2; what is not a number counts as 30 years and 0.5.
    pub fn new(age_years: f64, pigment: f64) -> Self {
        let a = (clamp_or(age_years, 1.0, 110.0, STANDARD_AGE_YEARS) / 70.0).powi(4);
        Self::with_age_factor(a, pigment)
    }

    fn with_age_factor(a: f64, pigment: f64) -> Self {
        Self {
            core: 1.0 - 0.08 * a,
            wide: 1.0 + 1.6 * a,
            pigment: clamp_or(pigment, 0.0, GLARE_LARGEST_PIGMENT, STANDARD_PIGMENT),
            scale: 1.0,
        }
    }

    /// The same eye with all light kept: the energy within the hemisphere is 1.
    pub fn normalised(self) -> Self {
        Self {
            scale: self.scale / self.energy_within(FRAC_PI_2),
            ..self
        }
    }

    /// Equivalent luminance (cd/m²) per lux at the eye, at `theta_rad` from the source: the share of
    /// the light per steradian, sr⁻¹. The sign of the angle does not matter; angles beyond π, and
    /// what is not a number, count as π.
    pub fn spread(self, theta_rad: f64) -> f64 {
        let theta = clamp_angle(theta_rad).to_degrees();
        let squared = theta * theta;
        let core = 1.0 + squared * (1.0 / (CORE_DEG * CORE_DEG));
        let halo = 1.0 + squared * (1.0 / (HALO_DEG * HALO_DEG));
        let wide = 1.0 / (1.0 + squared * (1.0 / (WIDE_DEG * WIDE_DEG)));
        let root = wide.sqrt();
        let narrow = 9.2e6 / (core * core.sqrt()) + 1.5e5 / (halo * halo.sqrt());
        let pigment = self.pigment * root * (1300.0 * wide + 0.8);
        self.scale
            * (self.core * narrow
                + self.wide * (400.0 * wide + 3e-8 * squared + pigment)
                + 2.5e-3 * self.pigment)
    }

    /// Light within the cone of half-angle `theta_rad` around the source's image, relative to what
    /// enters the eye: `∫ f dω`, rising with the angle. π/2 gives the hemisphere. It is also the
    /// veiling luminance at the centre of a disc of this radius and luminance 1. Angles as for
    /// [`Self::spread`].
    pub fn energy_within(self, theta_rad: f64) -> f64 {
        let theta = clamp_angle(theta_rad);
        let degrees_squared = (180.0 / PI).powi(2);
        let (sin, cos) = theta.sin_cos();
        let (_, core) = root_moments(CORE_DEG.to_radians(), theta);
        let (_, halo) = root_moments(HALO_DEG.to_radians(), theta);
        let (half, three_halves) = root_moments(WIDE_DEG.to_radians(), theta);
        let lorentz = lorentz_moment(WIDE_DEG.to_radians(), theta);
        let square = 2.0 * theta * sin + (2.0 - theta * theta) * cos - 2.0;
        let flat = 2.0 * (0.5 * theta).sin().powi(2);
        TAU * self.scale
            * (self.core * (9.2e6 * core + 1.5e5 * halo)
                + self.wide
                    * (400.0 * lorentz
                        + 3e-8 * degrees_squared * square
                        + self.pigment * (1300.0 * three_halves + 0.8 * half))
                + 2.5e-3 * self.pigment * flat)
    }

    /// Share of the hemisphere's light that falls further than `theta_rad` from the source's image.
    pub fn share_outside(self, theta_rad: f64) -> f64 {
        let within = self.energy_within(theta_rad.abs().min(FRAC_PI_2));
        (1.0 - within / self.energy_within(FRAC_PI_2)).clamp(0.0, 1.0)
    }

    /// The half-angle (rad) of the cone that holds `share` of the hemisphere's light: the inverse of
    /// 1 − [`Self::share_outside`], to 1e-12 of itself. A share of 0 or less, or one that is not a
    /// number, gives 0; of 1 or more, π/2.
    pub fn radius_of_share(self, share: f64) -> f64 {
        if share.is_nan() || share <= 0.0 {
            return 0.0;
        }
        if share >= 1.0 {
            return FRAC_PI_2;
        }
        let wanted = share * self.energy_within(FRAC_PI_2);
        // Newton's steps in ln θ, where the energy is smooth over all its decades, kept within a
        // shrinking bracket.
        let (mut low, mut high) = (1e-12_f64.ln(), FRAC_PI_2.ln());
        let mut t = HALO_DEG.to_radians().ln();
        for _ in 0..100 {
            let theta = t.exp();
            let miss = self.energy_within(theta) - wanted;
            if miss > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let slope = TAU * theta.sin() * theta * self.spread(theta);
            let newton = t - miss / slope;
            let next = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - t).abs() < 1e-13 {
                t = next;
                break;
            }
            t = next;
        }
        t.exp()
    }

    /// The straylight parameter `s = θ² L_eq/E` (deg² sr⁻¹) of van den Berg, which instruments
    /// measure at 7 to 10°.
    pub fn straylight(self, theta_rad: f64) -> f64 {
        let theta = clamp_angle(theta_rad).to_degrees();
        theta * theta * self.spread(theta_rad)
    }

    /// Modulation transfer, 0 to 1, of the light kept within the hemisphere at `frequency_cpd` (cycles
    /// per degree): the two-dimensional Fourier transform of the spread function over its energy. Its
    /// sign does not matter; what is not a number counts as infinite.
    ///
    /// The transform of the infinite plane stands for that of the sphere: at every age within 2e-4
    /// from 0.1 cycles per degree and 6e-6 from 1. Towards 0 the plane holds more light than the
    /// sphere, without limit, and the result is cut at 1.
    pub fn modulation(self, frequency_cpd: f64) -> f64 {
        let cycles = if frequency_cpd.is_nan() {
            f64::INFINITY
        } else {
            frequency_cpd.abs()
        };
        let wave_number = TAU * cycles * (180.0 / PI);
        let term = |width_deg: f64| {
            let b = width_deg.to_radians();
            // e^−kb vanishes long before this, and k b stays off 0 and infinity.
            let kb = (wave_number * b).clamp(1e-9, 800.0);
            (TAU * b * b, kb, (-kb).exp())
        };
        let (core_area, _, core) = term(CORE_DEG);
        let (halo_area, _, halo) = term(HALO_DEG);
        let (wide_area, kb, wide) = term(WIDE_DEG);
        let pigment = self.pigment * wide * (1300.0 + 0.8 / kb);
        let transform = self.core * (9.2e6 * core_area * core + 1.5e5 * halo_area * halo)
            + self.wide * wide_area * (400.0 * bessel_k0(kb) + pigment);
        (self.scale * transform / self.energy_within(FRAC_PI_2)).clamp(0.0, 1.0)
    }

    /// Decimal logarithm of [`Self::straylight`], as clinics quote it; angles below 1e-9 rad count
    /// as that.
    pub fn log_straylight(self, theta_rad: f64) -> f64 {
        let theta = if theta_rad.is_nan() { PI } else { theta_rad };
        self.straylight(theta.abs().max(1e-9)).log10()
    }
}

/// Stiles and Holladay's `10/θ²` (sr⁻¹), θ in degrees, stated for 1 to 30° and a young eye: half of
/// the complete function at 1°, equal to it near 3°, 1.6 times it at 10 to 20°.
/// Angles are limited to 0.1 to 100°; what is not a number counts as 100°.
pub fn glare_stiles_holladay(theta_rad: f64) -> f64 {
    10.0 / equation_angle(theta_rad).powi(2)
}

/// The age-adjusted Stiles–Holladay equation of CIE 146:2002, `10 [1 + (age/70)⁴]/θ²` (sr⁻¹),
/// stated for 1 to 30° and there within a factor of 1.9 of the complete function. Angles as for [`glare_stiles_holladay`], ages as for [`Glare::new`].
pub fn glare_age_adjusted(theta_rad: f64, age_years: f64) -> f64 {
    let age = clamp_or(age_years, 1.0, 110.0, STANDARD_AGE_YEARS);
    (1.0 + (age / 70.0).powi(4)) * glare_stiles_holladay(theta_rad)
}

/// The small-angle equation of CIE 146:2002, `10/θ³ + 5 [1 + (age/62.5)⁴]/θ²` (sr⁻¹), stated for
/// 0.1 to 30° and there within a factor of 1.4 of the complete function.
pub fn glare_small_angle(theta_rad: f64, age_years: f64) -> f64 {
    glare_general(theta_rad, age_years, 0.0)
}

/// The general equation of CIE 146:2002,
/// `10/θ³ + [5/θ² + 0.1 p/θ][1 + (age/62.5)⁴] + 2.5e-3 p` (sr⁻¹), stated for 0.1 to 100° and there
/// within a factor of 1.4 of the complete function.
pub fn glare_general(theta_rad: f64, age_years: f64, pigment: f64) -> f64 {
    let per_degree = 1.0 / equation_angle(theta_rad);
    let age = clamp_or(age_years, 1.0, 110.0, STANDARD_AGE_YEARS);
    let p = clamp_or(pigment, 0.0, GLARE_LARGEST_PIGMENT, STANDARD_PIGMENT);
    let aged = 1.0 + (age / 62.5).powi(4);
    per_degree * (aged * (0.1 * p + 5.0 * per_degree) + 10.0 * per_degree * per_degree) + 2.5e-3 * p
}

/// Degrees within the domain of CIE 146.
fn equation_angle(theta_rad: f64) -> f64 {
    clamp_angle(theta_rad).to_degrees().clamp(0.1, 100.0)
}

fn clamp_angle(theta_rad: f64) -> f64 {
    clamp_or(theta_rad.abs(), 0.0, PI, PI)
}

/// Terms of the sine's series smaller than this are left out: π²⁷/27! = 2e-15 is the first that may
/// be, and it enters with a weight below the function's wide part, 1e-2.
const SINE_SERIES_END: f64 = 1e-17;

/// `∫₀^θ sin t (1 + t²/b²)^−k dt` for k = ½ and 3/2.
///
/// With `w = √(1 + θ²/b²)` the moments `M_j = ∫ t^(2j+1)/(…)^k dt` are
/// `M½_0 = θ²/(1 + w)`, `(2j + 1) M½_j = b² (θ^2j w − 2j M½_{j−1})` and
/// `M³_0 = M½_0/w`, `M³_j = b² (M½_{j−1} − M³_{j−1})`. Each step multiplies the error of the last by
/// b² < 1e-5, so that the recurrence forgets it.
fn root_moments(b: f64, theta: f64) -> (f64, f64) {
    let (b_squared, theta_squared) = (b * b, theta * theta);
    let w = (1.0 + theta_squared / b_squared).sqrt();
    let mut half = theta_squared / (1.0 + w);
    let mut three_halves = half / w;
    let (mut half_sum, mut three_halves_sum) = (half, three_halves);
    // θ^2j and (−1)^j/(2j + 1)!.
    let (mut power, mut factor, mut twice_j) = (1.0, 1.0_f64, 0.0);
    loop {
        twice_j += 2.0;
        power *= theta_squared;
        factor /= -(twice_j * (twice_j + 1.0));
        if power * factor.abs() < SINE_SERIES_END {
            return (half_sum, three_halves_sum);
        }
        three_halves = b_squared * (half - three_halves);
        half = b_squared * (power * w - twice_j * half) / (twice_j + 1.0);
        half_sum += factor * half;
        three_halves_sum += factor * three_halves;
    }
}

/// `∫₀^θ sin t/(1 + t²/b²) dt`, from `M_0 = ½ b² ln(1 + θ²/b²)` and
/// `M_j = b² (θ^2j/2j − M_{j−1})`.
fn lorentz_moment(b: f64, theta: f64) -> f64 {
    let (b_squared, theta_squared) = (b * b, theta * theta);
    let mut moment = 0.5 * b_squared * (theta_squared / b_squared).ln_1p();
    let mut sum = moment;
    let (mut power, mut factor, mut twice_j) = (1.0, 1.0_f64, 0.0);
    loop {
        twice_j += 2.0;
        power *= theta_squared;
        factor /= -(twice_j * (twice_j + 1.0));
        if power * factor.abs() < SINE_SERIES_END {
            return sum;
        }
        moment = b_squared * (power / twice_j - moment);
        sum += factor * moment;
    }
}

/// The modified Bessel function K₀ for `x` above 0, to 1e-14 of itself.
fn bessel_k0(x: f64) -> f64 {
    /// Euler's constant.
    const EULER: f64 = 0.577_215_664_901_532_9;
    if x < 1.0 {
        // Σ (x²/4)^k/(k!)² (H_k − ln(x/2) − γ), H_k the harmonic numbers.
        let quarter = 0.25 * x * x;
        let logarithm = (0.5 * x).ln() + EULER;
        let (mut term, mut harmonic, mut k, mut sum) = (1.0, 0.0, 0.0, -logarithm);
        while term > 1e-17 {
            k += 1.0;
            term *= quarter / (k * k);
            harmonic += 1.0 / k;
            sum += term * (harmonic - logarithm);
        }
        return sum;
    }
    // ∫₀^∞ e^{−x cosh t} dt by the trapezoidal rule, whose error for this integrand falls with
    // e^{−π²/h}: 1e-17 with h = ¼.
    let step = 0.25_f64;
    let mut sum = 0.5 * (-x).exp();
    let mut t = step;
    loop {
        let value = (-x * t.cosh()).exp();
        sum += value;
        if value <= 1e-17 * sum {
            return step * sum;
        }
        t += step;
    }
}

#[cfg(test)]
mod tests;
