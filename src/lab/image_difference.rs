//! How different two pictures are: a mean, a high percentile and the largest, with limits for each.

use image::RgbaImage;

/// Difference of two pictures of one size, in sRGB steps of 0 to 255 (largest channel of a pixel).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean over all pixels.
    pub mean: f64,
    /// The difference that 999 of 1,000 pixels do not exceed.
    pub percentile_999: u8,
    /// The largest.
    pub max: u8,
}

/// Limits that a picture must keep.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// On the mean.
    pub mean: f64,
    /// On the 99.9th percentile.
    pub percentile_999: u8,
    /// On the largest.
    pub max: u8,
}

impl Difference {
    /// Compares; `None` when the sizes differ or there is no pixel.
    pub fn between(a: &RgbaImage, b: &RgbaImage) -> Option<Self> {
        if a.dimensions() != b.dimensions() || a.is_empty() {
            return None;
        }
        let mut steps: Vec<u8> = a
            .pixels()
            .zip(b.pixels())
            .map(|(p, q)| (0..3).map(|c| p[c].abs_diff(q[c])).max().unwrap_or(0))
            .collect();
        steps.sort_unstable();
        let sum: u64 = steps.iter().map(|&step| u64::from(step)).sum();
        let last = steps.len() - 1;
        Some(Self {
            mean: sum as f64 / steps.len() as f64,
            percentile_999: steps[last * 999 / 1000],
            max: steps[last],
        })
    }

    /// Is it within the limits?
    pub fn keeps(&self, limits: &Limits) -> bool {
        self.mean <= limits.mean
            && self.percentile_999 <= limits.percentile_999
            && self.max <= limits.max
    }
}

/// The difference as a picture, eight times as strong.
pub fn difference_picture(a: &RgbaImage, b: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(a.width(), a.height(), |x, y| {
        let (p, q) = (a.get_pixel(x, y), b.get_pixel(x, y));
        let step = |c: usize| p[c].abs_diff(q[c]).saturating_mul(8);
        image::Rgba([step(0), step(1), step(2), 255])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_mean_the_percentile_and_the_largest() {
        // 2,000 pixels: one differs by 200, three by 50, 996 by 1.
        let picture = RgbaImage::from_pixel(50, 40, image::Rgba([20, 20, 20, 255]));
        let mut other = picture.clone();
        for (index, pixel) in other.pixels_mut().take(1000).enumerate() {
            pixel.0[index % 3] += match index {
                0 => 200,
                1..=3 => 50,
                _ => 1,
            };
        }
        let found = Difference::between(&picture, &other).expect("sizes");
        // Of the sorted 0 to 1,999 place 1,997 is the third from above: 50.
        let expected = Difference {
            mean: (200.0 + 3.0 * 50.0 + 996.0) / 2000.0,
            percentile_999: 50,
            max: 200,
        };
        assert_eq!(found, expected);
        assert_eq!(Difference::between(&picture, &RgbaImage::new(1, 1)), None);
    }

    #[test]
    fn every_limit_counts() {
        let limits = Limits {
            mean: 0.5,
            percentile_999: 8,
            max: 30,
        };
        let within = Difference {
            mean: 0.5,
            percentile_999: 8,
            max: 30,
        };
        assert!(within.keeps(&limits));
        let (mut mean, mut percentile, mut max) = (within, within, within);
        mean.mean = 0.51;
        percentile.percentile_999 = 9;
        max.max = 31;
        for beyond in [mean, percentile, max] {
            assert!(!beyond.keeps(&limits), "{beyond:?}");
        }
    }
}
