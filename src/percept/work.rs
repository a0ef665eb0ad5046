//! What the passes of the view cost, counted from their sizes: for the ledger.
//!
//! Enters: the uniform that the passes will read. Leaves: pixels, voxels and taps. Nothing is read
//! back, so the counts are the same on every machine. The taps here are the most that the gather can
//! take; the `COUNT_WORK` build of `shaders/view/gather.wgsl` counts those that it took.

use super::gather::{SPREAD_SIGMA_MAX_PX, gaussian_disc_budget, gaussian_disc_taps, spread_taps};
use super::gpu_data::{PerceptUniform, mip_levels};

/// Counts of one view change or one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewWork {
    /// Passes and dispatches.
    pub passes: u64,
    /// Pixels written by capture and its mip chain.
    pub pixels_captured: u64,
    /// Pixels tested for corners.
    pub pixels_searched: u64,
    /// Voxels touched: looked up, updated or read, one a pixel each.
    pub voxels_touched: u64,
    /// Pixels blurred.
    pub pixels_gathered: u64,
    /// Texture taps of the gather at most.
    pub taps_at_most: u64,
}

fn pixels(uniform: &PerceptUniform) -> u64 {
    u64::from(uniform.size[0]) * u64::from(uniform.size[1])
}

/// Work of a new view: capture, mips, three passes of features, slots.
pub fn view_change_work(uniform: &PerceptUniform) -> ViewWork {
    let [width, height] = uniform.size;
    let levels = mip_levels(width, height);
    let mip_pixels: u64 = (1..levels)
        .map(|l| u64::from((width >> l).max(1)) * u64::from((height >> l).max(1)))
        .sum();
    ViewWork {
        passes: u64::from(levels) + 4,
        pixels_captured: pixels(uniform) + mip_pixels,
        pixels_searched: pixels(uniform),
        voxels_touched: pixels(uniform),
        ..ViewWork::default()
    }
}

/// Work of a frame: the field's update where `update` says that it runs, its reading, the gather.
pub fn frame_work(uniform: &PerceptUniform, update: bool) -> ViewWork {
    let target = uniform.target_size.map(|side| side.max(0.0) as u64);
    let shaded = target[0] * target[1];
    let dark = uniform.lid_aperture <= 0.0;
    let blur_rad = uniform.coc_cap_rad.hypot(uniform.loss_blur_rad);
    let sigma = 0.25 * f64::from(blur_rad * uniform.pixels_per_radian);
    // A wider blur takes fewer taps where it begins a new level: the most is the budget. Where
    // something nearer lies under the kernel, each of the four texels of a tap comes again by itself;
    // four taps cover 16 texels.
    let own = match gaussian_disc_taps(sigma, uniform.max_taps) {
        0 => 0,
        4 => 4 + 16,
        _ => 5 * gaussian_disc_budget(uniform.max_taps).pow(2),
    };
    let spread = match own {
        0 => 0,
        _ => spread_taps(sigma.min(SPREAD_SIGMA_MAX_PX), uniform.max_taps),
    };
    let gathered = if dark { 0 } else { shaded };
    ViewWork {
        passes: 2 + u64::from(update),
        voxels_touched: pixels(uniform) * (1 + u64::from(update)),
        pixels_gathered: gathered,
        taps_at_most: gathered * u64::from(own + spread),
        ..ViewWork::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_follow_the_sizes_alone() {
        let mut u = PerceptUniform::default();
        let view = view_change_work(&u);
        assert_eq!(view.pixels_searched, 102_400);
        // 320², and 160² + 80² + 40² + 20² + 10² + 5² + 2² + 1².
        assert_eq!(view.pixels_captured, 102_400 + 34_130);
        assert_eq!(view.passes, 9 + 4);
        let frame = frame_work(&u, true);
        assert_eq!((frame.passes, frame.voxels_touched), (3, 204_800));
        assert_eq!(frame.pixels_gathered, 102_400);
        u.lid_aperture = 0.0;
        let closed = frame_work(&u, false);
        assert_eq!(
            (closed.passes, closed.voxels_touched, closed.taps_at_most),
            (2, 102_400, 0)
        );
        u.lid_aperture = 1.0;
        u.coc_cap_rad = 0.0;
        assert_eq!(frame_work(&u, true).taps_at_most, 0);
    }
}
