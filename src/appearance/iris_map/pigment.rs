//! Melanin of the anterior border layer: blotches, the ring round the collarette, freckles.
//!
//! In: the layout and the grown surface. Out: relative density per texel, 0–1.

use super::canvas::{self, Canvas, Grid};
use super::layout::Layout;
use super::{DESIGN_WIDTH_MM, IrisMapSettings, turns_per_mm};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{HashStream, fbm, lerp, value_noise, wrap_half};

/// How much the sectors of a closed border layer differ in density (a choice).
const SECTORS: f32 = 1.8;

/// Least density of a closed border layer, but towards the root (a choice: below it the stroma's blue shows in brown irises).
const LEAST: f32 = 0.3;

/// How the layer's cells crowd in one place and are sparse in another, whatever there is of them.
#[derive(Clone, Debug)]
pub(super) struct Mottles {
    blotches: Vec<f32>,
    /// Most of them about a twelfth of a turn wide.
    sectors: Vec<f32>,
    fine: Vec<f32>,
}

impl Mottles {
    /// Those of one iris.
    pub fn new(seed: u32, grid: Grid) -> Self {
        let seed = seed ^ 0x61;
        let fine = |index: usize| {
            let (u, v) = (grid.u(index % grid.width), grid.v(index / grid.width));
            fbm(u * 90.0, v * 16.0, [90, 0], 3, seed ^ 1)
        };
        Self {
            blotches: canvas::slow_field(grid, |u, v| fbm(u * 9.0, v * 2.5, [9, 0], 4, seed)),
            sectors: canvas::slow_field(grid, |u, v| fbm(u * 6.0, v * 0.9, [6, 0], 3, seed ^ 2)),
            fine: (0..grid.len()).map(fine).collect(),
        }
    }
}

/// Paints all of it.
pub(super) fn paint(
    settings: &IrisMapSettings,
    layout: &Layout,
    surface: &Canvas,
    mottles: &Mottles,
) -> Vec<f32> {
    let grid = surface.grid;
    let cover = settings.border_layer_cover;
    let columns: Vec<Column> = (0..grid.width)
        .map(|i| Column::new(settings, layout, grid.u(i)))
        .collect();
    let mut melanin = vec![0.0; grid.len()];
    for (row, line) in melanin.chunks_mut(grid.width).enumerate() {
        let v = grid.v(row);
        for (column, value) in line.iter_mut().enumerate() {
            let index = row * grid.width + column;
            let (tag, relief) = (surface.tag[index] - 0.5, surface.relief[index]);
            let (blotch, mottle) = (mottles.blotches[index], mottles.fine[index]);
            // Where the layer covers all it is dense everywhere, down to the floors of the crypts.
            let closed = smoothstep(0.15, 0.6, cover);
            let cells = lerp(0.12, 0.70, closed)
                + lerp(1.0, 2.05, closed) * (0.6 * blotch + 0.45 * mottle + 0.6 * tag)
                + SECTORS * closed * mottles.sectors[index];
            // The border layer lies on the crests and is missing over openings.
            let laid = lerp(lerp(0.5, 0.85, closed), 1.1, smoothstep(0.15, 0.75, relief));
            let bare = 1.0 - lerp(0.6, 0.1, closed) * layout.crypt[index];
            let ring = columns[column].ring(settings, v, tag + 0.3 * mottle);
            let own = (cells * lerp(1.0, 0.6, settings.central_heterochromia) + ring) * laid * bare;
            let brown = (cells + lerp(0.56, 0.3, closed)) * laid * bare;
            // A closed one's own melanin is nowhere bare but towards the root.
            let least = LEAST * closed * smoothstep(0.95, 0.75, v);
            let own = lerp(least, 1.0, own.clamp(0.0, 1.0)) * settings.own_melanin;
            // Light irides may have more of it about the collarette than anywhere else.
            let gathered = smoothstep(0.1, 0.5, ring * laid * bare) * settings.ring_melanin;
            let own = own.max(gathered);
            *value = lerp(own, brown, columns[column].sector(v, tag + 0.3 * mottle));
        }
    }
    freckles(&mut melanin, settings, grid);
    melanin
        .iter_mut()
        .for_each(|value| *value = value.clamp(0.0, 1.0));
    melanin
}

/// Central heterochromia at one angle: dense at the collarette, running out along single fibres
/// like flames.
struct Column {
    rim: f32,
    flame: f32,
    /// How far within the sector of another colour it lies, turns; negative outside.
    within: f32,
}

impl Column {
    fn new(settings: &IrisMapSettings, layout: &Layout, u: f32) -> Self {
        let seed = settings.seed ^ 0x62;
        Self {
            rim: layout.collarette(u),
            flame: 0.05
                + 0.09 * value_noise(u * 17.0, 17, seed)
                + 0.05 * value_noise(u * 53.0, 53, seed ^ 1),
            within: {
                let [middle, half] = settings.sector;
                let ragged = 0.02 * value_noise(u * 71.0, 71, seed ^ 2)
                    + 0.015 * value_noise(u * 23.0, 23, seed ^ 4);
                if half > 0.0 {
                    half - wrap_half(u - middle).abs() + ragged
                } else {
                    -1.0
                }
            },
        }
    }

    /// Share of the sector's colour: its border runs along the fibres.
    fn sector(&self, v: f32, tag: f32) -> f32 {
        let border = self.within + 0.035 * tag + 0.01 * (v - 0.5);
        if self.within > -0.05 {
            smoothstep(-0.006, 0.014, border)
        } else {
            0.0
        }
    }

    fn ring(&self, settings: &IrisMapSettings, v: f32, tag: f32) -> f32 {
        let rim = self.rim;
        let flame = self.flame + 0.16 * tag;
        let out = smoothstep(rim + flame + 0.10, rim + flame - 0.06, v);
        let inner = lerp(0.55, 1.0, smoothstep(rim - 0.22, rim - 0.02, v));
        let across = (v - rim - 0.01) / 0.05;
        let ring = (-across * across).exp();
        settings.central_heterochromia * 1.1 * out * inner + 0.14 * ring
    }
}

fn freckles(melanin: &mut [f32], settings: &IrisMapSettings, grid: Grid) {
    let mut dice = HashStream::new(settings.seed, 20);
    for _ in 0..settings.freckle_count {
        let (u, v) = (dice.unit(), dice.range(0.12, 0.95));
        let size = dice.unit();
        let radius_mm = lerp(0.03, 0.26, size * size * size);
        let (density, seed) = (dice.range(0.7, 1.0), dice.next_u32());
        let stretch = dice.range(0.8, 1.5);
        let reach = 1.8 * radius_mm * stretch / DESIGN_WIDTH_MM;
        for row in grid.rows(v - reach, v + reach) {
            let y = (grid.v(row) - v) * DESIGN_WIDTH_MM / (radius_mm * stretch);
            let scale = turns_per_mm(grid.v(row));
            let half = (1.8 * radius_mm * scale * grid.width as f32).ceil() as i64;
            let centre = (u * grid.width as f32) as i64;
            for column in centre - half..=centre + half {
                let index = row * grid.width + grid.wrap_column(column);
                let x =
                    wrap_half((column as f32 + 0.5) / grid.width as f32 - u) / (scale * radius_mm);
                let rough = 0.5 * fbm(x * 1.6 + 9.0, y * 1.1, [0, 0], 4, seed);
                let spot = density * smoothstep(1.05, 0.75, x.hypot(y) + rough);
                melanin[index] = melanin[index].max(spot).max(melanin[index] + 0.5 * spot);
            }
        }
    }
}
