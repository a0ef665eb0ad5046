//! How different two pictures are: a mean and a high percentile, with limits for both.

use image::RgbaImage;

/// Difference of two pictures of one size, in sRGB steps of 0 to 255 (largest channel of a pixel).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean over all pixels.
    pub mean: f64,
    /// The difference that 99 of 100 pixels do not exceed.
    pub percentile_99: u8,
    /// The largest.
    pub max: u8,
}

/// Limits that a picture must keep.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// On the mean.
    pub mean: f64,
    /// On the 99th percentile.
    pub percentile_99: u8,
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
            percentile_99: steps[last * 99 / 100],
            max: steps[last],
        })
    }

    /// Is it within the limits?
    pub fn keeps(&self, limits: &Limits) -> bool {
        self.mean <= limits.mean && self.percentile_99 <= limits.percentile_99
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
    fn it_accepts_itself_and_rejects_a_shift() {
        let picture = RgbaImage::from_fn(40, 30, |x, y| {
            image::Rgba([(x * 6) as u8, (y * 8) as u8, 0, 255])
        });
        let shifted = RgbaImage::from_fn(40, 30, |x, y| *picture.get_pixel((x + 3) % 40, y));
        let limits = Limits {
            mean: 0.5,
            percentile_99: 8,
        };
        let same = Difference::between(&picture, &picture).expect("sizes");
        assert!(same.keeps(&limits) && same.max == 0);
        assert!(
            !Difference::between(&picture, &shifted)
                .expect("sizes")
                .keeps(&limits)
        );
        assert_eq!(Difference::between(&picture, &RgbaImage::new(1, 1)), None);
    }
}
