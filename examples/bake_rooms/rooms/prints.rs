//! Everything printed or painted: the chart, the letter, the telephone's screen, book spines, the
//! clock's dial and the portrait.

use super::shapes::Shape;
use super::text::{Style, Typeface};
use super::{Set, Target, facing, ground_of};
use ab_glyph::InvalidFont;
use glam::Vec3;
use ocularium::scene::paint::{Canvas, Clouds, hex, mix, smoothstep, unit_hash};

/// The fonts of the built-in scenes.
pub(super) struct Fonts {
    pub(super) sans: Typeface,
    pub(super) mono: Typeface,
}

impl Fonts {
    pub(super) fn new() -> Result<Self, InvalidFont> {
        Ok(Self {
            sans: Typeface::proportional()?,
            mono: Typeface::monospace()?,
        })
    }
}

/// The inks of what is printed on a ground.
pub(super) fn inks_of(material: &str) -> &'static [u32] {
    match material {
        "letter" => &[0x1d2440, 0x263a8a],
        "book spines" => &[0x3a2618, 0xf0d9a0],
        "eye chart" => &[0x0c0c0e, 0x55585c, 0x2f8f4e, 0xc0392b],
        "dial" => &[0x22201c, 0xa8792c],
        "telephone screen" => &[0xffffff, 0x17191d, 0x6c737c],
        _ => &[],
    }
}

/// Width and height of the chart, m.
pub(super) const CHART_SIZE_M: [f32; 2] = [0.5, 0.72];
/// Texels a metre on the chart.
pub(super) const CHART_TEXELS_PER_M: f32 = 2400.0;
/// The lines: logMAR and letters, largest first.
pub(super) const CHART_LINES: [(f32, &str); 9] = [
    (1.0, "E"),
    (0.8, "FP"),
    (0.6, "TOC"),
    (0.5, "LPEF"),
    (0.4, "HULTO"),
    (0.3, "EFCTPL"),
    (0.2, "UOHFELT"),
    (0.1, "PCLTUEOH"),
    (0.0, "FTHOLEUC"),
];

/// Height of an optotype at 6 m, m: five strokes of 10^logMAR minutes of arc each (ISO 8596).
pub(super) fn optotype_height_m(log_mar: f32) -> f32 {
    let stroke_arcmin = 10f32.powf(log_mar);
    6.0 * (5.0 * stroke_arcmin / 60.0).to_radians().tan()
}

/// An optotype on the five-by-five grid; `None` for the round ones.
fn optotype(letter: char) -> Option<[&'static str; 5]> {
    Some(match letter {
        'E' => ["#####", "#....", "#####", "#....", "#####"],
        'F' => ["#####", "#....", "#####", "#....", "#...."],
        'H' => ["#...#", "#...#", "#####", "#...#", "#...#"],
        'L' => ["#....", "#....", "#....", "#....", "#####"],
        'P' => ["#####", "#...#", "#####", "#....", "#...."],
        'T' => ["#####", "..#..", "..#..", "..#..", "..#.."],
        'U' => ["#...#", "#...#", "#...#", "#...#", "#####"],
        _ => return None,
    })
}

/// Draws one optotype with its upper left corner at `(x, y)`, `size` texels high. O is a ring and
/// C a Landolt ring with its gap, one stroke wide, to the right.
fn draw_optotype(canvas: &mut Canvas, letter: char, x: f32, y: f32, size: f32) {
    let ink = hex(0x0c0c0e);
    let stroke = size / 5.0;
    if let Some(rows) = optotype(letter) {
        for (row, cells) in rows.iter().enumerate() {
            // Runs rather than cells, so that antialiased seams do not show.
            let mut start = None;
            for (column, cell) in cells.chars().chain(['.']).enumerate() {
                match (cell, start) {
                    ('#', None) => start = Some(column),
                    ('.', Some(first)) => {
                        let [x0, x1] = [first, column].map(|c| x + stroke * c as f32);
                        let y0 = y + stroke * row as f32;
                        canvas.rect(x0, y0, x1, y0 + stroke + 0.01, ink);
                        start = None;
                    }
                    _ => {}
                }
            }
        }
        return;
    }
    let (radius, centre) = (size / 2.0, [x + size / 2.0, y + size / 2.0]);
    canvas.stamp(
        [x - 1.0, y - 1.0, x + size + 1.0, y + size + 1.0],
        ink,
        |px, py| {
            let (dx, dy) = (px - centre[0], py - centre[1]);
            let d = dx.hypot(dy);
            let ring =
                (radius - d + 0.5).clamp(0.0, 1.0) * (d - radius + stroke + 0.5).clamp(0.0, 1.0);
            let gap = if letter == 'C' && dx > 0.0 {
                (dy.abs() - stroke / 2.0 + 0.5).clamp(0.0, 1.0)
            } else {
                1.0
            };
            ring * gap
        },
    );
}

/// Height of the top of each line on the chart, texels, and its letter size, texels.
pub(super) fn chart_rows() -> Vec<(f32, f32)> {
    let mut y = 95.0;
    CHART_LINES
        .iter()
        .map(|&(log_mar, _)| {
            let size = optotype_height_m(log_mar) * CHART_TEXELS_PER_M;
            let row = (y, size);
            y += size * 1.18 + 46.0;
            row
        })
        .collect()
}

pub(super) fn chart_canvas(fonts: &Fonts) -> Canvas {
    let [width, height] = CHART_SIZE_M.map(|metres| (metres * CHART_TEXELS_PER_M).round());
    let mut canvas = ground_of("eye chart");
    let small = Style::new(26.0, hex(0x55585c));
    fonts.sans.draw_centred(
        &mut canvas,
        width / 2.0,
        55.0,
        "READ FROM 6 METRES",
        Style::new(34.0, hex(0x55585c)),
    );
    for (&(log_mar, letters), (y, size)) in CHART_LINES.iter().zip(chart_rows()) {
        let count = letters.chars().count() as f32;
        // Letter spacing is one letter, closed up where a line would not fit.
        let gap = size.min((width - 260.0 - count * size) / (count - 1.0).max(1.0));
        let mut x = (width - count * size - (count - 1.0) * gap) / 2.0;
        for letter in letters.chars() {
            draw_optotype(&mut canvas, letter, x, y, size);
            x += size + gap;
        }
        let label = format!("6/{:.0}", 6.0 * 10f32.powf(log_mar));
        fonts.sans.draw(
            &mut canvas,
            width - 105.0,
            y + size / 2.0 + 9.0,
            &label,
            small,
        );
    }
    canvas.rect(
        70.0,
        height - 62.0,
        width - 70.0,
        height - 50.0,
        hex(0x2f8f4e),
    );
    canvas.rect(
        70.0,
        height - 40.0,
        width - 70.0,
        height - 28.0,
        hex(0xc0392b),
    );
    canvas
}

/// Hangs the chart in a thin frame with its printed face at the target.
pub(super) fn hang_chart(set: &mut Set, fonts: &Fonts, target: &Target) {
    let here = facing(target, 0.0);
    let [width, height] = CHART_SIZE_M;
    let paper = set.printed("eye chart", &chart_canvas(fonts), false, 0.8);
    set.add(
        "eye chart",
        Shape::picture(width, height).moved(here),
        paper,
    );
    let dark = set.plain("chart frame", 0x2b2d31, 0.4);
    set.add(
        "chart frame",
        frame(width, height, 0.018, 0.022).moved(here),
        dark,
    );
}

/// Four bars round a picture of `width × height`, standing out towards the viewer.
pub(super) fn frame(width: f32, height: f32, bar: f32, depth: f32) -> Shape {
    let piece = |w: f32, h: f32| {
        Shape::rounded_box(
            Vec3::new(w, h, depth),
            (0.3 * bar.min(depth)).min(0.008),
            1.0,
        )
    };
    Shape::joined([
        piece(width + 2.0 * bar, bar).at(0.0, (height + bar) / 2.0, 0.0),
        piece(width + 2.0 * bar, bar).at(0.0, -(height + bar) / 2.0, 0.0),
        piece(bar, height).at((width + bar) / 2.0, 0.0, 0.0),
        piece(bar, height).at(-(width + bar) / 2.0, 0.0, 0.0),
    ])
}

pub(super) fn letter_canvas(fonts: &Fonts) -> Canvas {
    let mut canvas = ground_of("letter");
    let ink = hex(0x1d2440);
    fonts.sans.draw(
        &mut canvas,
        70.0,
        150.0,
        "Dear Ada,",
        Style::new(96.0, ink).bold(),
    );
    let text = "the garden is in bloom, and from the desk I can read the name of the street again. \
        When I look up, the page melts away; when I look down, the window does.";
    let y = fonts.sans.draw_column(
        &mut canvas,
        (70.0, 265.0),
        760.0,
        68.0,
        text,
        Style::new(58.0, ink),
    );
    let finer = "The lens in the eye grows rounder for what is near and flatter for what is far. At ten years it \
        can add fourteen dioptres, at sixty hardly one. So the old hold their letters at arm's length, and \
        then their arms become too short. Spectacles put back what the years have taken.";
    let y = fonts.sans.draw_column(
        &mut canvas,
        (70.0, y + 40.0),
        760.0,
        46.0,
        finer,
        Style::new(38.0, ink),
    );
    let finest = "If you can read this line without your glasses at sixty centimetres, your near vision is \
        better than most. Bring the page closer until it blurs: that is your near point.";
    let y = fonts.sans.draw_column(
        &mut canvas,
        (70.0, y + 30.0),
        760.0,
        32.0,
        finest,
        Style::new(25.0, ink),
    );
    fonts.sans.draw(
        &mut canvas,
        480.0,
        (y + 90.0).min(1200.0),
        "Yours, Johannes",
        Style::new(56.0, hex(0x263a8a)),
    );
    canvas
}

pub(super) fn phone_canvas(fonts: &Fonts) -> Canvas {
    let mut canvas = ground_of("telephone screen");
    let (ink, grey) = (hex(0x17191d), hex(0x6c737c));
    fonts.sans.draw(
        &mut canvas,
        36.0,
        46.0,
        "09:41",
        Style::new(32.0, hex(0xffffff)).bold(),
    );
    fonts.sans.draw(
        &mut canvas,
        36.0,
        122.0,
        "Reading test",
        Style::new(66.0, hex(0xffffff)).bold(),
    );
    let mut y = 240.0;
    for (size, line) in [(84.0, "Sharp near"), (84.0, "and far?")] {
        fonts
            .sans
            .draw(&mut canvas, 36.0, y, line, Style::new(size, ink).bold());
        y += size * 1.05;
    }
    let big = "Hold me at thirty centimetres. A young eye adds more than three dioptres to see me.";
    y = fonts.sans.draw_column(
        &mut canvas,
        (36.0, y + 10.0),
        530.0,
        54.0,
        big,
        Style::new(46.0, ink),
    );
    let small = "Now look at the chart on the far wall and back again. The change takes about a third of a \
        second, and the pupil narrows a little as you come near. With forty-five years the nearest \
        point of clear sight moves beyond this telephone.";
    y = fonts.sans.draw_column(
        &mut canvas,
        (36.0, y + 24.0),
        530.0,
        36.0,
        small,
        Style::new(29.0, ink),
    );
    for (i, colour) in [0xe0663b, 0xf2b544, 0x3d9a6b, 0x3a78c2]
        .into_iter()
        .enumerate()
    {
        canvas.rect(
            36.0 + 134.0 * i as f32,
            y + 10.0,
            150.0 + 134.0 * i as f32,
            y + 90.0,
            hex(colour),
        );
    }
    let tiny = "N3  the quick brown fox jumps over the lazy dog";
    fonts
        .mono
        .draw(&mut canvas, 36.0, y + 140.0, tiny, Style::new(19.0, grey));
    canvas
}

/// Titles on the book spines of [`spines_canvas`], one column each.
const TITLES: [&str; 16] = [
    "OPTICKS",
    "On Light",
    "THE GARDEN",
    "Night Sky",
    "Birds of the Coast",
    "ATLAS",
    "A Short Walk",
    "COLOUR",
    "Rivers",
    "THE EYE",
    "Letters",
    "Bread & Salt",
    "SEA ROADS",
    "Small Hours",
    "Glass",
    "THE ORCHARD",
];

/// Sixteen book spines side by side, titles running down.
pub(super) fn spines_canvas(fonts: &Fonts) -> Canvas {
    // Drawn lying on the side (one spine a row), then turned by the coordinates.
    let mut canvas = ground_of("book spines");
    for (row, title) in TITLES.into_iter().enumerate() {
        let y = 64.0 * row as f32;
        let gold = if [2, 6, 14].contains(&row) {
            hex(0x3a2618)
        } else {
            hex(0xf0d9a0)
        };
        for x in [26.0, 36.0, 470.0, 480.0] {
            canvas.rect(x, y + 2.0, x + 4.0, y + 62.0, gold);
        }
        let size = if title.len() > 12 { 40.0 } else { 50.0 };
        fonts.sans.draw_centred(
            &mut canvas,
            256.0,
            y + 32.0 + 0.3 * size,
            title,
            Style::new(size, gold).bold(),
        );
    }
    canvas
}

pub(super) fn dial_canvas(fonts: &Fonts) -> Canvas {
    let mut canvas = ground_of("dial");
    let ink = hex(0x22201c);
    for minute in 0..60u8 {
        let angle = f32::from(minute) * 6f32.to_radians();
        let inner = if minute % 5 == 0 { 158.0 } else { 168.0 };
        let at = |r: f32| [192.0 + r * angle.sin(), 192.0 - r * angle.cos()];
        canvas.line(
            at(inner),
            at(176.0),
            if minute % 5 == 0 { 5.0 } else { 2.0 },
            ink,
            1.0,
        );
    }
    for hour in 1..=12u8 {
        let angle = f32::from(hour) * 30f32.to_radians();
        let (x, y) = (192.0 + 130.0 * angle.sin(), 192.0 - 130.0 * angle.cos());
        fonts.sans.draw_centred(
            &mut canvas,
            x,
            y + 16.0,
            &hour.to_string(),
            Style::new(50.0, ink).bold(),
        );
    }
    for (turn, length, width) in [(10.15 / 12.0, 85.0, 11.0), (9.0 / 60.0, 135.0, 7.0)] {
        let angle: f32 = std::f32::consts::TAU * turn;
        canvas.line(
            [192.0, 192.0],
            [192.0 + length * angle.sin(), 192.0 - length * angle.cos()],
            width,
            ink,
            1.0,
        );
    }
    canvas.ellipse([192.0, 192.0], [12.0, 12.0], hex(0xa8792c), 1.0, 0.1);
    canvas
}

/// A painted portrait of a woman in a blue shawl.
pub(super) fn portrait_canvas() -> Canvas {
    let patches = Clouds::new(6, 90);
    let mut canvas = Canvas::shaded(384, 480, |u, v| {
        let glow = 1.0 - smoothstep(0.0, 0.8, (u - 0.45).hypot(v - 0.4));
        mix(
            hex(0x3b3a2c),
            hex(0x9a8458),
            glow * (0.6 + 0.4 * patches.at(u, v)),
        )
    });
    let (skin, shade, hair) = (hex(0xe8bd98), hex(0xb98263), hex(0x4a2c1c));
    canvas.ellipse([192.0, 500.0], [175.0, 170.0], hex(0x2f5d86), 1.0, 0.05);
    canvas.ellipse([150.0, 470.0], [90.0, 110.0], hex(0x4a7dab), 0.7, 0.5);
    canvas.ellipse([192.0, 205.0], [100.0, 128.0], hair, 1.0, 0.06);
    canvas.ellipse([192.0, 300.0], [92.0, 80.0], hair, 1.0, 0.2);
    canvas.ellipse([192.0, 320.0], [38.0, 70.0], shade, 1.0, 0.1);
    canvas.ellipse([192.0, 372.0], [70.0, 36.0], skin, 1.0, 0.3);
    canvas.ellipse([192.0, 220.0], [68.0, 90.0], skin, 1.0, 0.06);
    canvas.ellipse([225.0, 235.0], [34.0, 72.0], shade, 0.45, 0.7);
    canvas.ellipse([172.0, 190.0], [40.0, 44.0], hex(0xf6d6b6), 0.6, 0.8);
    for side in [-1.0f32, 1.0] {
        let x = 192.0 + side * 29.0;
        canvas.ellipse([x, 212.0], [17.0, 11.0], shade, 0.6, 0.5);
        canvas.ellipse([x, 213.0], [12.0, 6.5], hex(0xf5efe6), 1.0, 0.15);
        canvas.ellipse([x + 1.0, 213.0], [5.8, 6.2], hex(0x4b6a4a), 1.0, 0.15);
        canvas.ellipse([x + 1.0, 213.0], [2.8, 3.0], hex(0x14100c), 1.0, 0.2);
        canvas.line([x - 12.0, 208.0], [x + 12.0, 207.0], 3.0, hair, 0.9);
        canvas.line(
            [x - 15.0, 193.0 + 2.0 * side],
            [x + 15.0, 193.0 - 2.0 * side],
            5.0,
            hair,
            0.8,
        );
        canvas.ellipse(
            [x + side * 8.0, 250.0],
            [18.0, 14.0],
            hex(0xd98a6e),
            0.45,
            0.9,
        );
    }
    canvas.line([196.0, 208.0], [203.0, 246.0], 5.0, shade, 0.5);
    canvas.ellipse([194.0, 250.0], [13.0, 7.0], shade, 0.7, 0.6);
    canvas.ellipse([192.0, 276.0], [22.0, 6.0], hex(0xa8473f), 1.0, 0.3);
    canvas.ellipse([192.0, 280.0], [17.0, 6.0], hex(0xc4655a), 1.0, 0.4);
    canvas.ellipse([192.0, 128.0], [76.0, 46.0], hair, 1.0, 0.2);
    for i in 0..160i32 {
        let (x, y) = (384.0 * unit_hash(i, 0, 5), 480.0 * unit_hash(i, 1, 5));
        let dab = if unit_hash(i, 2, 5) > 0.5 {
            [1.0; 3]
        } else {
            [0.0; 3]
        };
        canvas.ellipse([x, y], [16.0, 4.0], dab, 0.05, 0.6);
    }
    canvas
}
