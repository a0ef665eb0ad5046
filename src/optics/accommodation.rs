//! What a lens can do.
//!
//! Enters: an age. Leaves: the amplitude of accommodation.

/// Hofstetter's mean amplitude of accommodation, 18.5 − 0.3 × age, in D, never negative. It is
/// subjective and overstates what the lens itself does (depth of field is in it).
#[must_use]
pub fn hofstetter_amplitude_d(age_years: f64) -> f64 {
    (18.5 - 0.3 * age_years).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hofstetter_gives_the_published_line_and_never_less_than_nothing() {
        // 18.5 − 0.3·20, 18.5 − 0.3·60, and beyond 61.7 years nothing.
        assert!((hofstetter_amplitude_d(20.0) - 12.5).abs() < 1e-12);
        assert!((hofstetter_amplitude_d(60.0) - 0.5).abs() < 1e-12);
        assert_eq!(hofstetter_amplitude_d(90.0), 0.0);
    }
}
