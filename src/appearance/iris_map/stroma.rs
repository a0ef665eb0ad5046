//! The stroma of one iris without its pigment, which takes most of the work: more melanin covers the same fibres.

use super::canvas::{self, Canvas, Grid};
use super::layout::Layout;
use super::pigment::Mottles;
use super::{
    FURROW_MM, IrisMap, IrisMapSettings, front_surface, pigment, scale_to_profile, strands,
    texel_at,
};
use crate::tissue::noise::{fbm, lerp};

/// A grown stroma, on which any pigment can be laid.
#[derive(Clone, Debug)]
pub struct IrisStroma {
    /// What it was grown by; no pigment.
    settings: IrisMapSettings,
    grid: Grid,
    layout: Layout,
    surface: Canvas,
    felt: Felt,
    mottles: Mottles,
}

/// The border layer as a felt that bridges narrow gaps.
#[derive(Clone, Debug)]
struct Felt {
    /// Relief where it covers all.
    relief: Vec<f32>,
    /// How much of it lies there.
    share: Vec<f32>,
}

impl Felt {
    fn new(seed: u32, surface: &Canvas, layout: &Layout) -> Self {
        let grid = surface.grid;
        let mut relief = surface.relief.clone();
        canvas::blur(&mut relief, grid, 0.26, 0.30);
        let seed = seed ^ 0x51ab;
        let patches = canvas::slow_field(grid, |u, v| {
            0.5 + 0.5 * fbm(u * 12.0, v * 3.0, [12, 0], 3, seed ^ 3)
        });
        let humps = canvas::slow_field(grid, |u, v| {
            0.04 * fbm(u * 60.0, v * 11.0, [60, 0], 2, seed ^ 9)
        });
        for (index, value) in relief.iter_mut().enumerate() {
            let (u, v) = (grid.u(index % grid.width), grid.v(index / grid.width));
            let grain = 0.05 * fbm(u * 330.0, v * 56.0, [330, 0], 2, seed) + humps[index];
            *value = *value * 1.04 + grain;
        }
        let open = layout.crypt.iter().map(|crypt| 1.0 - 0.8 * crypt);
        let share = patches
            .iter()
            .zip(open)
            .map(|(patch, open)| 0.9 * lerp(0.75, 1.15, *patch) * open);
        Self {
            relief,
            share: share.collect(),
        }
    }

    /// Strands sink under it, wide crypts stay.
    fn over(&self, surface: &Canvas, cover: f32) -> Canvas {
        let mut covered = surface.clone();
        if cover > 0.0 {
            let felt = self.relief.iter().zip(&self.share);
            for (own, (felt, share)) in covered.relief.iter_mut().zip(felt) {
                *own = lerp(*own, *felt, (cover * share).clamp(0.0, 0.95));
            }
        }
        covered
    }
}

impl IrisStroma {
    /// Grows that of `settings`; arguments as of [`IrisMap::new`].
    #[must_use]
    pub fn new(settings: &IrisMapSettings, width: usize, height: usize) -> Self {
        let settings = settings.clamped().without_pigment();
        let grid = Grid {
            width: width.clamp(16, 8192),
            height: height.clamp(8, 8192),
        };
        let layout = Layout::new(&settings, grid);
        let surface = strands::grow(&settings, &layout, grid);
        Self {
            felt: Felt::new(settings.seed, &surface, &layout),
            mottles: Mottles::new(settings.seed, grid),
            settings,
            grid,
            layout,
            surface,
        }
    }

    /// Whether it is that of these settings at this size.
    #[must_use]
    pub fn fits(&self, settings: &IrisMapSettings, width: usize, height: usize) -> bool {
        (self.grid.width, self.grid.height) == (width, height)
            && self.settings == settings.clamped().without_pigment()
    }

    /// The map with the pigment of `settings`, whose stroma is taken for this one.
    #[must_use]
    pub fn pigmented(&self, settings: &IrisMapSettings) -> IrisMap {
        let (settings, grid) = (settings.clamped(), self.grid);
        let surface = self.felt.over(&self.surface, settings.border_layer_cover);
        let thickness = scale_to_profile(&surface, &self.layout);
        let melanin = pigment::paint(&settings, &self.layout, &surface, &self.mottles);
        let relief = front_surface(&thickness, grid);
        let seed = self.settings.seed;
        let texels = (0..grid.len()).map(|index| {
            let furrow = FURROW_MM * self.layout.furrow[index];
            texel_at(seed, &thickness, &melanin, (&relief, furrow), grid, index)
        });
        IrisMap {
            width: grid.width,
            height: grid.height,
            texels: texels.collect(),
        }
    }
}
