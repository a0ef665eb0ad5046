//! FAST-9/16 corners (Rosten and Drummond 2005), the candidates for the next fixation.
//!
//! Enters: an 8-bit grey image. Leaves: corners in row-major order with their scores.
//!
//! A pixel is a corner at threshold t if at least nine contiguous pixels of the 16 on the circle of
//! radius 3 are all brighter than it by more than t, or all darker by more than t. Its *strength*
//! is the largest over the sixteen arcs of nine and both signs of the smallest difference; it is a
//! corner where the strength exceeds t, and the score, the largest t that still passes, is the
//! strength minus one. So one pass finds both, without a search over thresholds.
//!
//! All differences are taken with saturation, in bytes and in lanes of sixteen pixels, so that the
//! compiler turns the arcs into vector minima. The GPU's twin is `shaders/lib/fast_strength.wgsl`.

/// One corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// Column, pixels from the left.
    pub x: u32,
    /// Row, pixels from the top.
    pub y: u32,
    /// Largest threshold at which the pixel is still a corner.
    pub score: u8,
}

/// Radius of the circle, pixels: no corner lies nearer than this to the border.
pub const RADIUS: usize = 3;

/// The circle, clockwise from the top, as (x, y) from its centre.
pub const RING: [(isize, isize); 16] = [
    (0, -3),
    (1, -3),
    (2, -2),
    (3, -1),
    (3, 0),
    (3, 1),
    (2, 2),
    (1, 3),
    (0, 3),
    (-1, 3),
    (-2, 2),
    (-3, 1),
    (-3, 0),
    (-3, -1),
    (-2, -2),
    (-1, -3),
];

const LANES: usize = 16;
type Bytes = [u8; LANES];

/// A grey image that [`detect`] cannot read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a grey image of {width} x {height} pixels has {width} x {height} bytes, not {bytes}")]
pub struct SizeError {
    /// Bytes given.
    pub bytes: usize,
    /// Columns given.
    pub width: usize,
    /// Rows given.
    pub height: usize,
}

/// Corners of a row-major grey image at a threshold, with or without non-maximum suppression
/// (strictly above all eight neighbours, a non-corner counting 0: of a tie none survives).
///
/// # Errors
/// [`SizeError`] when `gray` does not hold exactly `width · height` bytes.
pub fn detect(
    gray: &[u8],
    width: usize,
    height: usize,
    threshold: u8,
    nms: bool,
) -> Result<Vec<Corner>, SizeError> {
    if width.checked_mul(height) != Some(gray.len()) {
        return Err(SizeError {
            bytes: gray.len(),
            width,
            height,
        });
    }
    let mut corners = Vec::new();
    if width <= 2 * RADIUS || height <= 2 * RADIUS {
        return Ok(corners);
    }
    // Three rows of strengths are alive at a time; the row above the first and below the last are 0.
    let mut above = vec![0u8; width];
    let mut here = vec![0u8; width];
    let mut below = vec![0u8; width];
    strengths_of_row(gray, width, RADIUS, threshold, &mut here);
    for y in RADIUS..height - RADIUS {
        if y + 1 < height - RADIUS {
            strengths_of_row(gray, width, y + 1, threshold, &mut below);
        } else {
            below.fill(0);
        }
        collect_row(&above, &here, &below, y, nms, &mut corners);
        std::mem::swap(&mut above, &mut here);
        std::mem::swap(&mut here, &mut below);
    }
    Ok(corners)
}

/// Score of a strength: a non-corner's strength and score are both 0.
fn score_of(strength: u8) -> u8 {
    strength.saturating_sub(1)
}

fn collect_row(
    above: &[u8],
    here: &[u8],
    below: &[u8],
    y: usize,
    nms: bool,
    corners: &mut Vec<Corner>,
) {
    for x in RADIUS..here.len() - RADIUS {
        if here[x] == 0 {
            continue;
        }
        let score = score_of(here[x]);
        let beaten = |s: &u8| score_of(*s) >= score;
        let dies = nms
            && (above[x - 1..=x + 1].iter().any(beaten)
                || below[x - 1..=x + 1].iter().any(beaten)
                || beaten(&here[x - 1])
                || beaten(&here[x + 1]));
        if !dies {
            corners.push(Corner {
                x: x as u32,
                y: y as u32,
                score,
            });
        }
    }
}

/// Strength of every pixel of row `y` that is a corner at the threshold, 0 elsewhere.
fn strengths_of_row(gray: &[u8], width: usize, y: usize, threshold: u8, out: &mut [u8]) {
    out.fill(0);
    let (first, last) = (RADIUS, width - RADIUS);
    let mut x = first;
    while x < last {
        if last - first >= LANES {
            // The last block overlaps the one before rather than running over the border.
            let at = x.min(last - LANES);
            let block = strengths_of_block(gray, width, y * width + at, threshold);
            out[at..at + LANES].copy_from_slice(&block);
            x = at + LANES;
        } else {
            out[x] = strength_at(gray, width, y * width + x, threshold);
            x += 1;
        }
    }
}

/// The same for one pixel, for images too narrow for a block.
fn strength_at(gray: &[u8], width: usize, centre: usize, threshold: u8) -> u8 {
    let ring = ring_offsets(width).map(|offset| gray[centre.wrapping_add_signed(offset)]);
    let arc = |value: &dyn Fn(u8) -> u8| {
        (0..16)
            .map(|start| (0..9).map(|k| value(ring[(start + k) % 16])).min())
            .max()
            .flatten()
            .unwrap_or(0)
    };
    let c = gray[centre];
    let strength = arc(&|v| v.saturating_sub(c)).max(arc(&|v| c.saturating_sub(v)));
    if strength > threshold { strength } else { 0 }
}

fn ring_offsets(width: usize) -> [isize; 16] {
    RING.map(|(dx, dy)| dy * width as isize + dx)
}

fn lanes(gray: &[u8], start: usize) -> Bytes {
    let mut out = [0; LANES];
    out.copy_from_slice(&gray[start..start + LANES]);
    out
}

fn each(a: &Bytes, b: &Bytes, f: impl Fn(u8, u8) -> u8) -> Bytes {
    std::array::from_fn(|i| f(a[i], b[i]))
}

/// Strengths of sixteen neighbouring pixels from `centre` on, 0 where not above the threshold.
fn strengths_of_block(gray: &[u8], width: usize, centre: usize, threshold: u8) -> Bytes {
    let c = lanes(gray, centre);
    let ring = ring_offsets(width).map(|offset| lanes(gray, centre.wrapping_add_signed(offset)));
    let brighter = arcs(&ring, &c, threshold, |v, c| v.saturating_sub(c));
    let darker = arcs(&ring, &c, threshold, |v, c| c.saturating_sub(v));
    let best = each(&brighter, &darker, u8::max);
    best.map(|s| if s > threshold { s } else { 0 })
}

/// Largest over the arcs of the smallest of nine differences of one sign, in every lane.
fn arcs(
    ring: &[Bytes; 16],
    centre: &Bytes,
    threshold: u8,
    difference: impl Fn(u8, u8) -> u8 + Copy,
) -> Bytes {
    let d1: [Bytes; 16] = std::array::from_fn(|k| each(&ring[k], centre, difference));
    // Of two opposite pixels every arc of nine holds at least one, so the smallest of the eight
    // pairs' larger differences bounds the strength: nearly all of a picture leaves here.
    let bound = (0..8).fold([u8::MAX; LANES], |bound, k| {
        each(&bound, &each(&d1[k], &d1[k + 8], u8::max), u8::min)
    });
    if bound.iter().all(|b| *b <= threshold) {
        return [0; LANES];
    }
    // Minima over 2, 4, 8 and 9 neighbours by doubling.
    let d2: [Bytes; 16] = std::array::from_fn(|k| each(&d1[k], &d1[(k + 1) % 16], u8::min));
    let d4: [Bytes; 16] = std::array::from_fn(|k| each(&d2[k], &d2[(k + 2) % 16], u8::min));
    let d8: [Bytes; 16] = std::array::from_fn(|k| each(&d4[k], &d4[(k + 4) % 16], u8::min));
    (0..16).fold([0; LANES], |best, k| {
        let d9 = each(&d8[k], &d1[(k + 8) % 16], u8::min);
        each(&best, &d9, u8::max)
    })
}

/// Grey value of an sRGB colour: Rec. 709 luma of the encoded channels, rounded to nearest.
pub fn luma_of_srgb8([r, g, b]: [u8; 3]) -> u8 {
    let sum = 2126 * u32::from(r) + 7152 * u32::from(g) + 722 * u32::from(b) + 5000;
    // The weights add up to 10,000, so the quotient is at most 255.
    (sum / 10_000) as u8
}

#[cfg(test)]
mod tests;
