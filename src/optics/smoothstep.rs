//! The cubic step that shaders call `smoothstep`, for either precision.

use core::ops::{Div, Mul, Sub};

/// 0 at `low`, 1 at `high` (whichever is the larger), flat beyond both, and a cubic between; what is not a
/// number counts as 0.
#[inline]
#[must_use]
pub fn smoothstep<T>(low: T, high: T, x: T) -> T
where
    T: Copy + PartialOrd + From<f32> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>,
{
    let (none, all) = (T::from(0.0), T::from(1.0));
    let t = (x - low) / (high - low);
    let t = if t > none { t } else { none };
    let t = if t < all { t } else { all };
    t * t * (T::from(3.0) - T::from(2.0) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_or_falls_and_stays_within_its_ends() {
        for (low, high) in [(1.0, 3.0), (3.0, 1.0)] {
            assert_eq!(
                (smoothstep(low, high, low), smoothstep(low, high, high)),
                (0.0, 1.0)
            );
            assert_eq!(smoothstep(low, high, 2.0), 0.5);
            // 3 t² − 2 t³ at a quarter.
            assert_eq!(smoothstep(low, high, low + 0.25 * (high - low)), 0.156_25);
        }
        assert_eq!(
            (
                smoothstep(0.0_f32, 1.0, -9.0),
                smoothstep(0.0_f32, 1.0, 9.0)
            ),
            (0.0, 1.0)
        );
        assert_eq!(smoothstep(0.0, 1.0, f64::NAN), 0.0);
    }
}
