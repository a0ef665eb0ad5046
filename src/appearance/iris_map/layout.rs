//! Where the structures of one iris lie: collarette, crypts, furrows, and the flow of the fibres.
//!
//! In: settings and a grid. Out: a [`Layout`] that the strand and pigment passes read.

use core::f32::consts::TAU;

use super::canvas::Grid;
use super::{IrisMapSettings, turns_per_mm};
use crate::optics::smoothstep::smoothstep;
use crate::tissue::noise::{HashStream, fbm, gradient_noise, lerp, value_noise, wrap_half};

/// An opening in the stroma: a lens with uneven sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crypt {
    pub u: f32,
    pub v: f32,
    /// Half its width, turns, and half its length, radial fraction.
    pub half_width: f32,
    pub half_length: f32,
    /// How deep it goes, 0–1.
    pub depth: f32,
    pub seed: u32,
}

impl Crypt {
    /// How far one side (−1 or 1) of the opening reaches at radial fraction `v`, turns.
    pub fn reach(&self, v: f32, side: f32) -> f32 {
        let t = (v - self.v) / self.half_length;
        if t.abs() >= 1.0 {
            return 0.0;
        }
        let offset = if side < 0.0 { 17.0 } else { 43.0 };
        let uneven = 1.0 + 0.45 * value_noise(t * 1.4 + offset, 0, self.seed);
        self.half_width * (1.0 - t * t).powf(1.2) * uneven
    }

    /// The opening's axis at radial fraction `v`, turns: crypts lean a little.
    pub fn axis(&self, v: f32) -> f32 {
        let lean = value_noise(5.0, 0, self.seed) * 0.5;
        self.u + lean * self.half_width * (v - self.v) / self.half_length
    }
}

/// The plan of one iris.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    seed: u32,
    waviness: f32,
    collarette: Vec<f32>,
    pub crypts: Vec<Crypt>,
    /// How open each texel is, 0–1.
    pub crypt: Vec<f32>,
    /// Contraction furrows per texel: 1 in a groove, slightly negative on its lips.
    pub furrow: Vec<f32>,
}

impl Layout {
    pub fn new(settings: &IrisMapSettings, grid: Grid) -> Self {
        let mut layout = Self {
            seed: settings.seed,
            waviness: settings.waviness,
            collarette: zigzag(settings),
            crypts: Vec::new(),
            crypt: vec![0.0; grid.len()],
            furrow: vec![0.0; grid.len()],
        };
        layout.crypts = layout.scatter_crypts(settings);
        layout.open_crypts(grid);
        layout.fold_furrows(settings, grid);
        layout
    }

    /// Radial fraction of the collarette at angle fraction `u`.
    pub fn collarette(&self, u: f32) -> f32 {
        let count = self.collarette.len();
        let x = (u - u.floor()) * count as f32;
        let cell = (x as usize).min(count - 1);
        let t = x - cell as f32;
        lerp(
            self.collarette[cell],
            self.collarette[(cell + 1) % count],
            t,
        )
    }

    /// Where the strand of rest angle `a` (turns) runs at radial fraction `v` of the ciliary zone:
    /// neighbours crowd into trabeculae and part again along the way.
    pub fn ciliary_path(&self, a: f32, v: f32) -> f32 {
        let seed = self.seed;
        let lean = 0.008 * gradient_noise(a * 9.0, v * 1.4, [9, 0], seed ^ 0x11);
        let a = a + lean;
        let bundle = 0.50 / 52.0 * gradient_noise(a * 52.0, v * 1.9, [52, 0], seed ^ 0x12);
        let tuft = 0.62 / 130.0 * gradient_noise(a * 130.0, v * 4.2, [130, 0], seed ^ 0x13);
        let wave = self.waviness
            * (0.0020 * gradient_noise(a * 34.0, v * 11.0, [34, 0], seed ^ 0x14)
                + 0.0011 * gradient_noise(a * 110.0, v * 21.0, [110, 0], seed ^ 0x15));
        a + bundle + tuft + wave
    }

    /// The same for the finer, straighter strands of the pupillary zone.
    pub fn pupillary_path(&self, a: f32, v: f32) -> f32 {
        let seed = self.seed;
        a + 0.006 * gradient_noise(a * 11.0, v * 2.0, [11, 0], seed ^ 0x21)
            + 0.55 / 110.0 * gradient_noise(a * 110.0, v * 5.0, [110, 0], seed ^ 0x22)
            + 0.0009 * self.waviness * gradient_noise(a * 60.0, v * 24.0, [60, 0], seed ^ 0x23)
    }

    /// The crypts that may move a strand near angle `u`.
    pub fn crypts_near(&self, u: f32) -> Vec<Crypt> {
        let near = |crypt: &&Crypt| wrap_half(crypt.u - u).abs() < 5.0 * crypt.half_width + 0.02;
        self.crypts.iter().filter(near).copied().collect()
    }

    fn scatter_crypts(&self, settings: &IrisMapSettings) -> Vec<Crypt> {
        let mut dice = HashStream::new(settings.seed, 2);
        let density = settings.crypt_density;
        let mut crypts: Vec<Crypt> = Vec::new();
        let count = |full: f32| (density * full).round() as u32;
        // Crypts of Fuchs just outside the collarette: the large ones, in loose groups.
        let growth = lerp(0.75, 1.35, density);
        for _ in 0..count(76.0) {
            let cluster = 0.03 * dice.normal();
            let u = (dice.range(0.0, 7.0).floor() / 7.0 + 0.11 * dice.normal() + cluster)
                .rem_euclid(1.0);
            let size = dice.unit().powf(1.6);
            let half_length = lerp(0.04, 0.14, size) * dice.range(0.8, 1.3) * growth;
            let v = self.collarette(u) + half_length * 0.9 + 0.09 * dice.unit() * dice.unit();
            push_apart(
                &mut crypts,
                &mut dice,
                [u, v],
                lerp(0.04, 0.20, size) * growth,
                half_length,
                1.0,
            );
        }
        // Small ones on the pupil's side of it.
        for _ in 0..count(34.0) {
            let u = dice.unit();
            let half_length = dice.range(0.018, 0.05);
            let v = self.collarette(u) - half_length - 0.015 - 0.03 * dice.unit();
            let width = dice.range(0.03, 0.09);
            push_apart(&mut crypts, &mut dice, [u, v], width, half_length, 0.75);
        }
        // Slits between the trabeculae of the ciliary zone.
        for _ in 0..count(110.0) {
            let (u, v) = (dice.unit(), dice.range(0.48, 0.88));
            let (width, half_length) = (dice.range(0.02, 0.06), dice.range(0.03, 0.12));
            let depth = dice.range(0.4, 0.9);
            push_apart(&mut crypts, &mut dice, [u, v], width, half_length, depth);
        }
        // Crypts of the root: many, small, nearly round.
        for _ in 0..count(130.0) {
            let (u, v) = (dice.unit(), 0.955 - 0.06 * dice.unit() * dice.unit().sqrt());
            let (width, half_length) = (dice.range(0.03, 0.10), dice.range(0.010, 0.026));
            push_apart(&mut crypts, &mut dice, [u, v], width, half_length, 0.8);
        }
        crypts
    }

    fn open_crypts(&mut self, grid: Grid) {
        for crypt in &self.crypts {
            let (from, to) = (crypt.v - crypt.half_length, crypt.v + crypt.half_length);
            for row in grid.rows(from, to) {
                let v = grid.v(row);
                let soft = (0.026 * turns_per_mm(v)).max(0.75 / grid.width as f32);
                let (left, right) = (crypt.reach(v, -1.0), crypt.reach(v, 1.0));
                let axis = crypt.axis(v);
                let first = ((axis - left - soft) * grid.width as f32).floor() as i64;
                let last = ((axis + right + soft) * grid.width as f32).ceil() as i64;
                for column in first..=last {
                    let away = (column as f32 + 0.5) / grid.width as f32 - axis;
                    let reach = if away < 0.0 { left } else { right };
                    let open = crypt.depth * smoothstep(reach + soft, reach - soft, away.abs());
                    let index = row * grid.width + grid.wrap_column(column);
                    self.crypt[index] = self.crypt[index].max(open);
                }
            }
        }
    }

    fn fold_furrows(&mut self, settings: &IrisMapSettings, grid: Grid) {
        let mut dice = HashStream::new(settings.seed, 3);
        for number in 0..settings.furrow_count {
            let place =
                (number as f32 + 0.5 + 0.35 * dice.normal() * 0.5) / settings.furrow_count as f32;
            let v0 = lerp(0.52, 0.93, place);
            let (centre, arc) = (dice.unit(), dice.range(0.16, 0.42));
            let (depth, width) = (dice.range(0.5, 1.0), dice.range(0.009, 0.017));
            let seed = dice.next_u32();
            for column in 0..grid.width {
                let u = grid.u(column);
                let along = wrap_half(u - centre).abs() / arc;
                let broken = smoothstep(-0.45, 0.1, fbm(u * 9.0, 0.5, [9, 0], 2, seed));
                let strength = depth * broken * smoothstep(1.0, 0.75, along);
                if strength <= 0.01 {
                    continue;
                }
                let wander = 0.034 * value_noise(u * 6.0, 6, seed ^ 1)
                    + 0.010 * value_noise(u * 23.0, 23, seed ^ 2)
                    + 0.003 * value_noise(u * 90.0, 90, seed ^ 4);
                let path = v0 + wander;
                for row in grid.rows(path - 4.0 * width, path + 4.0 * width) {
                    let x = (grid.v(row) - path) / width;
                    let groove = (-x * x).exp() - 0.35 * (-(x.abs() - 2.0).powi(2)).exp();
                    self.furrow[row * grid.width + column] += strength * groove;
                }
            }
        }
        self.furrow
            .iter_mut()
            .for_each(|value| *value = value.clamp(-0.5, 1.0));
    }
}

fn push_apart(
    crypts: &mut Vec<Crypt>,
    dice: &mut HashStream,
    place: [f32; 2],
    half_width_mm: f32,
    half_length: f32,
    depth: f32,
) {
    let [u, v] = place;
    let half_width = half_width_mm * turns_per_mm(v);
    let seed = dice.next_u32();
    let overlaps = crypts.iter().any(|other| {
        let across = wrap_half(other.u - u).abs() / (other.half_width + half_width);
        let along = (other.v - v).abs() / (other.half_length + half_length);
        across.hypot(along) < 0.7
    });
    if !overlaps {
        crypts.push(Crypt {
            u,
            v,
            half_width,
            half_length,
            depth,
            seed,
        });
    }
}

/// The collarette's radial fraction at evenly spaced angles: uneven teeth on a wandering ring.
fn zigzag(settings: &IrisMapSettings) -> Vec<f32> {
    let mut dice = HashStream::new(settings.seed, 1);
    let teeth = 22 + (dice.next_u32() % 12) as usize;
    let irregular = settings.collarette_irregularity;
    let mut corners: Vec<(f32, f32)> = (0..teeth * 2)
        .map(|k| {
            let u = (k as f32 + dice.range(-0.42, 0.42)) / (teeth * 2) as f32;
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            (u, side * dice.unit() * 0.034 * irregular)
        })
        .collect();
    let (first, second) = (corners[0], corners[1]);
    let last = corners[corners.len() - 1];
    corners.insert(0, (last.0 - 1.0, last.1));
    corners.push((first.0 + 1.0, first.1));
    corners.push((second.0 + 1.0, second.1));
    let seed = settings.seed ^ 0x31;
    let phase = dice.unit();
    let mut segment = 0;
    (0..2048)
        .map(|k| {
            let u = k as f32 / 2048.0;
            while corners[segment + 1].0 <= u {
                segment += 1;
            }
            let (start, end) = (corners[segment], corners[segment + 1]);
            let t = ((u - start.0) / (end.0 - start.0)).clamp(0.0, 1.0);
            let tooth = lerp(start.1, end.1, 0.4 * t + 0.6 * smoothstep(0.0, 1.0, t));
            let wander = 0.03 * (0.4 + irregular) * fbm(u * 4.0, 0.37, [4, 0], 3, seed)
                + 0.012 * ((u + phase) * TAU).sin();
            settings.collarette_radius + tooth + wander
        })
        .collect()
}
