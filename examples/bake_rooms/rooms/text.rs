//! Lettering: fonts that are compiled in, rasterised onto a [`Canvas`].
//!
//! Enters: a line of text, a size in texels. Leaves: antialiased coverage blended onto the canvas.
//! The fonts are those of `epaint_default_fonts` (Ubuntu Light, Hack), so that text looks the same
//! everywhere, also in a browser.

use ab_glyph::{Font, FontRef, InvalidFont, PxScale, ScaleFont, point};
use ocularium::scene::paint::Canvas;

/// A font at hand.
#[derive(Debug, Clone)]
pub struct Typeface {
    font: FontRef<'static>,
}

/// How a line is set.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Height from ascent to descent, texels.
    pub size_px: f32,
    /// sRGB-encoded colour, 0–1.
    pub color: [f32; 3],
    /// Extra stroke width, texels; a light face becomes bold at about 0.05 of its size.
    pub embolden_px: f32,
}

impl Style {
    /// Plain text.
    pub fn new(size_px: f32, color: [f32; 3]) -> Self {
        let embolden_px = 0.0;
        Self {
            size_px,
            color,
            embolden_px,
        }
    }

    /// The same with strokes that are thicker by 5 % of the size.
    #[must_use]
    pub fn bold(self) -> Self {
        let embolden_px = 0.05 * self.size_px;
        Self {
            embolden_px,
            ..self
        }
    }
}

impl Typeface {
    /// The proportional face (Ubuntu Light).
    pub fn proportional() -> Result<Self, InvalidFont> {
        Self::read(epaint_default_fonts::UBUNTU_LIGHT)
    }

    /// The fixed-pitch face (Hack Regular).
    pub fn monospace() -> Result<Self, InvalidFont> {
        Self::read(epaint_default_fonts::HACK_REGULAR)
    }

    fn read(bytes: &'static [u8]) -> Result<Self, InvalidFont> {
        let font = FontRef::try_from_slice(bytes)?;
        Ok(Self { font })
    }

    /// Width of a line, texels.
    pub fn width_px(&self, text: &str, size_px: f32) -> f32 {
        let scaled = self.font.as_scaled(PxScale::from(size_px));
        let mut previous = None;
        text.chars().fold(0.0, |width, character| {
            let id = scaled.glyph_id(character);
            let kern = previous.map_or(0.0, |p| scaled.kern(p, id));
            previous = Some(id);
            width + kern + scaled.h_advance(id)
        })
    }

    /// Sets one line with its left end at `x` and its baseline at `y` (texels, y down).
    pub fn draw(&self, canvas: &mut Canvas, x: f32, y: f32, text: &str, style: Style) {
        let scaled = self.font.as_scaled(PxScale::from(style.size_px));
        let (mut pen, mut previous) = (x, None);
        for character in text.chars() {
            let id = scaled.glyph_id(character);
            pen += previous.map_or(0.0, |p| scaled.kern(p, id));
            previous = Some(id);
            // Bold: the same outline stamped a few times within the extra stroke width.
            let stamps = (style.embolden_px * 2.0).ceil() as u32;
            for stamp in 0..=stamps {
                let shift = style.embolden_px * stamp as f32 / stamps.max(1) as f32;
                let glyph = id.with_scale_and_position(style.size_px, point(pen + shift, y));
                if let Some(outline) = self.font.outline_glyph(glyph) {
                    let corner = outline.px_bounds().min;
                    outline.draw(|dx, dy, coverage| {
                        let (px, py) = (
                            corner.x as i64 + i64::from(dx),
                            corner.y as i64 + i64::from(dy),
                        );
                        canvas.blend(px, py, style.color, coverage.clamp(0.0, 1.0));
                    });
                }
            }
            pen += scaled.h_advance(id);
        }
    }

    /// Sets one line centred on `x`.
    pub fn draw_centred(&self, canvas: &mut Canvas, x: f32, y: f32, text: &str, style: Style) {
        let width = self.width_px(text, style.size_px) + style.embolden_px;
        self.draw(canvas, x - 0.5 * width, y, text, style);
    }

    /// Sets running text in a column of `width` texels from the first baseline `y`, with lines
    /// `leading` texels apart; returns the baseline after the last line.
    pub fn draw_column(
        &self,
        canvas: &mut Canvas,
        at: (f32, f32),
        width: f32,
        leading: f32,
        text: &str,
        style: Style,
    ) -> f32 {
        let (x, mut y) = at;
        let mut line = String::new();
        for word in text.split_whitespace() {
            let longer = if line.is_empty() {
                word.to_owned()
            } else {
                format!("{line} {word}")
            };
            if self.width_px(&longer, style.size_px) > width && !line.is_empty() {
                self.draw(canvas, x, y, &line, style);
                y += leading;
                line = word.to_owned();
            } else {
                line = longer;
            }
        }
        self.draw(canvas, x, y, &line, style);
        y + leading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink(canvas: &Canvas) -> f32 {
        let texture = canvas.texture(false);
        texture
            .rgba8
            .chunks(4)
            .map(|t| 1.0 - f32::from(t[0]) / 255.0)
            .sum()
    }

    #[test]
    fn text_leaves_ink_where_it_is_set_and_bold_leaves_more() {
        let face = Typeface::proportional().unwrap();
        let style = Style::new(40.0, [0.0; 3]);
        let mut thin = Canvas::new(200, 60, [1.0; 3]);
        face.draw(&mut thin, 10.0, 42.0, "Eye", style);
        let mut thick = Canvas::new(200, 60, [1.0; 3]);
        face.draw(&mut thick, 10.0, 42.0, "Eye", style.bold());
        assert!(ink(&thin) > 100.0);
        assert!(ink(&thick) > 1.2 * ink(&thin));
        // Nothing to the right of the line's end.
        let end = 10.0 + face.width_px("Eye", 40.0) + 2.0;
        let texture = thin.texture(false);
        for y in 0..60 {
            for x in end.ceil() as usize..200 {
                assert_eq!(texture.rgba8[(y * 200 + x) * 4], 255);
            }
        }
    }

    #[test]
    fn columns_wrap_within_their_width_and_text_off_the_canvas_is_clipped() {
        let face = Typeface::monospace().unwrap();
        let mut canvas = Canvas::new(120, 200, [1.0; 3]);
        let style = Style::new(16.0, [0.0; 3]);
        let end = face.draw_column(
            &mut canvas,
            (10.0, 20.0),
            100.0,
            20.0,
            "one two three four five",
            style,
        );
        assert!(end >= 60.0, "wrapped into at least two lines");
        face.draw(&mut canvas, -500.0, 1e6, "outside", style);
    }
}
