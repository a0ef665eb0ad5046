//! Roots of functions of one number between two places where their signs differ.

/// Where `f` is 0 between `low`, where it is `at_low`, and `high`, where it is `at_high` (of opposite
/// signs): regula falsi in its Illinois form (Dowell and Jarratt 1971). Ends where `f` is within
/// `tolerance` of 0, or the bracket is narrower than that; of values without a change of sign the end
/// whose value is nearer to 0.
#[must_use]
pub fn illinois(
    (mut low, mut at_low): (f64, f64),
    (mut high, mut at_high): (f64, f64),
    tolerance: f64,
    f: impl Fn(f64) -> f64,
) -> f64 {
    if at_low * at_high > 0.0 {
        return if at_low.abs() < at_high.abs() {
            low
        } else {
            high
        };
    }
    let mut last_side = 0.0;
    for _ in 0..100 {
        let width = at_high - at_low;
        if width == 0.0 || (high - low).abs() < tolerance {
            break;
        }
        let middle = low - at_low * (high - low) / width;
        let value = f(middle);
        if value.abs() < tolerance {
            return middle;
        }
        // The end that stays for a second time counts half, so that it will not stay.
        if value * at_low > 0.0 {
            (low, at_low) = (middle, value);
            if last_side < 0.0 {
                at_high *= 0.5;
            }
            last_side = -1.0;
        } else {
            (high, at_high) = (middle, value);
            if last_side > 0.0 {
                at_low *= 0.5;
            }
            last_side = 1.0;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_whichever_way_the_function_goes() {
        for root in [0.1, 0.5, 0.999] {
            for sign in [1.0, -1.0] {
                for power in [1, 3, 9] {
                    let f = |x: f64| sign * (x.powi(power) - f64::powi(root, power));
                    let found = illinois((0.0, f(0.0)), (1.0, f(1.0)), 1e-12, f);
                    // A ninth power is flat at 0: its value says little about its place there.
                    assert!(f(found).abs() < 1e-11, "{found}, not {root}");
                }
            }
        }
        let exponential = |x: f64| (30.0 * x).exp() - 2.0;
        let ends = [0.0, 1.0].map(|x| (x, exponential(x)));
        let found = illinois(ends[0], ends[1], 1e-12, exponential);
        assert!((found - 2f64.ln() / 30.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_change_of_sign_it_is_the_nearer_end() {
        assert_eq!(
            illinois((0.0, 1.0), (1.0, 3.0), 1e-9, |x| 1.0 + 2.0 * x),
            0.0
        );
        assert_eq!(
            illinois((0.0, -3.0), (1.0, -1.0), 1e-9, |x| 2.0 * x - 3.0),
            1.0
        );
        assert_eq!(illinois((0.0, 0.0), (1.0, 0.0), 1e-9, |_| 0.0), 0.5);
    }
}
