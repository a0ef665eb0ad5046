//! Procedural pictures and surface textures.
//!
//! Enters: sRGB-encoded colours 0–1, texel coordinates (x right, y down), seeds. Leaves: a
//! [`SceneTexture`]. A seed gives the same texels on every machine. What is called for every texel is `#[inline]`: a call costs more than what it does.

use super::model::{SceneTexture, Wrap, srgb_to_linear};
pub use crate::optics::smoothstep::smoothstep;
pub use crate::tissue::noise::{ValueNoise, unit_hash};

/// An sRGB-encoded colour from `0xRRGGBB`, 0–1.
#[inline]
pub fn hex(code: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| ((code >> shift) & 0xff) as f32 / 255.0)
}

/// A linear colour from `0xRRGGBB`.
pub fn linear(code: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| srgb_to_linear(((code >> shift) & 0xff) as u8))
}

/// From `a` (at 0) to `b` (at 1).
#[inline]
pub fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Four octaves of [`ValueNoise`] 0–1 that repeat over the unit square.
#[derive(Debug, Clone)]
pub struct Clouds {
    octaves: [ValueNoise; 4],
}

impl Clouds {
    /// The clouds of a seed, with `period` cells in the first octave.
    pub fn new(period: i32, seed: u32) -> Self {
        let octaves = [0, 1, 2, 3].map(|octave| ValueNoise::new(period << octave, seed + octave));
        Self { octaves }
    }

    /// Their value at a place.
    #[inline]
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let (mut sum, mut weight) = (0.0, 0.5);
        for octave in &self.octaves {
            let cells = octave.period() as f32;
            sum += weight * octave.at(u * cells, v * cells);
            weight *= 0.5;
        }
        sum / 0.9375
    }
}

/// A picture under construction, sRGB-encoded floats.
#[derive(Debug, Clone)]
pub struct Canvas {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

impl Canvas {
    /// A canvas of one opaque colour.
    pub fn new(width: u32, height: u32, color: [f32; 3]) -> Self {
        let texel = [color[0], color[1], color[2], 1.0];
        Self {
            width,
            height,
            texels: vec![texel; (width * height) as usize],
        }
    }

    /// A canvas coloured by a function of `(u, v)` in 0–1.
    pub fn shaded(width: u32, height: u32, color: impl Fn(f32, f32) -> [f32; 3]) -> Self {
        let mut canvas = Self::new(width, height, [0.0; 3]);
        for y in 0..height {
            for x in 0..width {
                let (u, v) = (
                    (x as f32 + 0.5) / width as f32,
                    (y as f32 + 0.5) / height as f32,
                );
                let [r, g, b] = color(u, v);
                canvas.texels[(y * width + x) as usize] = [r, g, b, 1.0];
            }
        }
        canvas
    }

    /// Width in texels.
    pub fn width(&self) -> f32 {
        self.width as f32
    }

    /// Height in texels.
    pub fn height(&self) -> f32 {
        self.height as f32
    }

    /// Blends one texel; outside the canvas nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, color: [f32; 3], opacity: f32) {
        if (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y) {
            let texel = &mut self.texels[y as usize * self.width as usize + x as usize];
            for (channel, value) in color.into_iter().enumerate() {
                texel[channel] += (value - texel[channel]) * opacity;
            }
            texel[3] = texel[3].max(opacity);
        }
    }

    /// Sets every texel's alpha to zero; what is blended afterwards becomes visible.
    pub fn clear_alpha(&mut self) {
        self.texels.iter_mut().for_each(|texel| texel[3] = 0.0);
    }

    /// Blends wherever `opacity(x, y)` (texel centres) is positive inside a box.
    pub fn stamp(&mut self, bounds: [f32; 4], color: [f32; 3], opacity: impl Fn(f32, f32) -> f32) {
        let [x0, y0, x1, y1] = bounds;
        let clip = |value: f32, limit: u32| value.clamp(0.0, limit as f32) as i64;
        for y in clip(y0.floor(), self.height)..clip(y1.ceil(), self.height) {
            for x in clip(x0.floor(), self.width)..clip(x1.ceil(), self.width) {
                let amount = opacity(x as f32 + 0.5, y as f32 + 0.5);
                if amount > 0.0 {
                    self.blend(x, y, color, amount.min(1.0));
                }
            }
        }
    }

    /// A filled rectangle with antialiased edges.
    pub fn rect(&mut self, x0: f32, y0: f32, x1: f32, y1: f32, color: [f32; 3]) {
        self.stamp([x0, y0, x1, y1], color, |x, y| {
            let cover = |low: f32, high: f32, at: f32| {
                ((at + 0.5).min(high) - (at - 0.5).max(low)).clamp(0.0, 1.0)
            };
            cover(x0, x1, x) * cover(y0, y1, y)
        });
    }

    /// An ellipse; `soft` is the width of its edge as a part of the radius.
    pub fn ellipse(
        &mut self,
        centre: [f32; 2],
        radii: [f32; 2],
        color: [f32; 3],
        opacity: f32,
        soft: f32,
    ) {
        let [cx, cy] = centre;
        let [rx, ry] = radii.map(|r| r * (1.0 + soft));
        self.stamp([cx - rx, cy - ry, cx + rx, cy + ry], color, |x, y| {
            let d = ((x - cx) / radii[0]).hypot((y - cy) / radii[1]);
            let edge = soft.max(1.0 / radii[0].min(radii[1]).max(1.0));
            opacity * (1.0 - smoothstep(1.0 - edge, 1.0 + edge, d))
        });
    }

    /// A line with round ends.
    pub fn line(
        &mut self,
        from: [f32; 2],
        to: [f32; 2],
        width: f32,
        color: [f32; 3],
        opacity: f32,
    ) {
        let half = 0.5 * width;
        let bounds = [
            from[0].min(to[0]) - half - 1.0,
            from[1].min(to[1]) - half - 1.0,
            from[0].max(to[0]) + half + 1.0,
            from[1].max(to[1]) + half + 1.0,
        ];
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).max(1e-9);
        self.stamp(bounds, color, |x, y| {
            let t = (((x - from[0]) * dx + (y - from[1]) * dy) / length).clamp(0.0, 1.0);
            let away = (x - from[0] - dx * t).hypot(y - from[1] - dy * t);
            opacity * (half + 0.5 - away).clamp(0.0, 1.0)
        });
    }

    /// The finished sRGB texture.
    pub fn texture(&self, repeat: bool) -> SceneTexture {
        let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        SceneTexture {
            width: self.width,
            height: self.height,
            rgba8: self
                .texels
                .iter()
                .flatten()
                .map(|&value| byte(value))
                .collect(),
            srgb: true,
            wrap: [if repeat { Wrap::Repeat } else { Wrap::Clamp }; 2],
        }
    }
}

/// Planks of wood with grain along x; one repeat is about 1 m.
pub fn wood(light: u32, dark: u32, planks: i32, seed: u32) -> Canvas {
    let (light, dark) = (hex(light), hex(dark));
    let warps = Clouds::new(3, seed + 3);
    let (rings, pores) = (
        ValueNoise::new(48, seed + 9),
        ValueNoise::new(256, seed + 5),
    );
    // A single board needs fewer texels than a floor.
    let side = if planks > 1 { 512 } else { 256 };
    Canvas::shaded(side, side, move |u, v| {
        let plank = (v * planks as f32).floor();
        let shift = unit_hash(plank as i32, 7, seed);
        let warp = warps.at(u, v) - 0.5;
        // Growth rings cut at a shallow angle: stretched noise, then a periodic band.
        let ring = rings.at(u * 4.0 + shift * 31.0, (v + 0.05 * warp) * 48.0);
        let band = (0.5 + 0.5 * ((ring * 9.0 + warp * 5.0).sin())) * 0.5 + ring * 0.3;
        let pore = pores.at(u * 16.0 + shift * 7.0, v * 256.0);
        let mut color = mix(light, dark, (0.75 * band + 0.25 * shift).clamp(0.0, 1.0));
        color = mix(color, dark, 0.35 * smoothstep(0.72, 0.95, pore));
        let edge = (v * planks as f32).fract();
        let seam = if planks > 1 {
            smoothstep(0.0, 0.018, edge.min(1.0 - edge))
        } else {
            1.0
        };
        let joint = (u + 0.37 * plank + shift).fract();
        let gap = if planks > 1 {
            smoothstep(0.0, 0.003, joint.min(1.0 - joint))
        } else {
            1.0
        };
        mix(mix(color, [0.1, 0.06, 0.03], 0.6), color, seam.min(gap))
    })
}

/// Plain-weave cloth of two yarn colours; one repeat has 32 yarns each way.
pub fn weave(warp: u32, weft: u32, seed: u32) -> Canvas {
    let (warp, weft) = (hex(warp), hex(weft));
    let patches = Clouds::new(4, seed);
    Canvas::shaded(256, 256, move |u, v| {
        let (x, y) = (u * 32.0, v * 32.0);
        let over = (x.floor() as i32 + y.floor() as i32) % 2 == 0;
        let (fx, fy) = (x.fract() - 0.5, y.fract() - 0.5);
        let across = if over { fx } else { fy };
        let round = 1.0 - 1.3 * across * across;
        let fleck = 0.88 + 0.24 * unit_hash(x as i32, y as i32, seed);
        let cloudy = 0.92 + 0.16 * patches.at(u, v);
        let base = if over { warp } else { weft };
        base.map(|c| c * round * fleck * cloudy)
    })
}

/// Rolled plaster or paint.
pub fn plaster(color: u32, seed: u32) -> Canvas {
    let color = hex(color);
    let (rolled, grains) = (Clouds::new(3, seed), ValueNoise::new(128, seed + 20));
    Canvas::shaded(256, 256, move |u, v| {
        let wide = rolled.at(u, v) - 0.5;
        let fine = grains.at(u * 128.0, v * 128.0) - 0.5;
        color.map(|c| c * (1.0 + 0.05 * wide + 0.025 * fine))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_stays_in_range_and_depends_on_the_seed() {
        let noise = ValueNoise::new(8, 1);
        for i in 0..200 {
            let (x, y) = (i as f32 * 0.37, i as f32 * 0.11);
            let value = noise.at(x, y);
            assert!((0.0..=1.0).contains(&value));
            assert!((value - noise.at(x + 8.0, y - 16.0)).abs() < 1e-4);
        }
        assert!((noise.at(0.3, 0.4) - ValueNoise::new(8, 2).at(0.3, 0.4)).abs() > 1e-3);
    }

    #[test]
    fn rectangles_cover_their_exact_area() {
        let mut canvas = Canvas::new(20, 20, [0.0; 3]);
        canvas.rect(2.25, 3.5, 10.75, 8.0, [1.0; 3]);
        let sum: f32 = canvas.texels.iter().map(|t| t[0]).sum();
        assert!((sum - 8.5 * 4.5).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn wood_and_cloth_tile_without_a_visible_jump() {
        for canvas in [weave(0x808080, 0xa0a0a0, 3), plaster(0xe0d8c8, 4)] {
            let texture = canvas.texture(true);
            let row = |y: u32| y * texture.width * 4;
            let jump: f32 = (0..texture.width)
                .map(|x| {
                    let at = |y| f32::from(texture.rgba8[(row(y) + x * 4) as usize]);
                    (at(0) - at(texture.height - 1)).abs()
                })
                .sum::<f32>()
                / texture.width as f32;
            assert!(jump < 60.0, "{jump}");
        }
    }
}
