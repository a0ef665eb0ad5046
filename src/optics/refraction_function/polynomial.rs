//! The refraction function as one polynomial: Chebyshev series in the same unfolded coordinates.
//!
//! In: an eye, a place, a light. Out: the entry point `K`. The function is sampled at the roots of
//! Chebyshev polynomials in the light's obliquity, β² and `w` ([`super::domain`]), and its series
//! summed: a few kilobytes and no cells, but every coefficient is read for every place. A point of
//! the measured front, not what the picture uses. References use a fit of this kind in plain
//! coordinates: total degree 12 in the radius and stereographic direction, 0.1 mm up to 80°.

use super::domain::{FRAME, Frame, RefractionEye, frame_a, frame_place};
use super::fill::{complete, extend};
use super::{LOWEST_W, grade, ungrade};
use core::f64::consts::PI;
use glam::{DVec2, DVec3};

/// Most coefficients along a coordinate.
const MOST: usize = 24;

/// A precomputed refraction function without cells.
#[derive(Clone, Debug)]
pub struct RefractionPolynomial {
    /// Coefficients along the light's obliquity, in β², and in `w`.
    size: [usize; 3],
    greatest: f64,
    frames: Vec<[f32; FRAME]>,
    /// `K` along the azimuth, and across it over β (mm).
    values: Vec<[f32; 2]>,
}

/// The roots of the Chebyshev polynomial of this degree, in [0, 1] and rising.
fn roots(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| 0.5 - 0.5 * (PI * (i as f64 + 0.5) / count as f64).cos())
        .collect()
}

/// Turns samples at [`roots`] into coefficients along the middle axis of a block `[outer, count,
/// inner]`.
fn transform(samples: &[f64], [outer, count, inner]: [usize; 3]) -> Vec<f64> {
    let mut out = vec![0.0; samples.len()];
    for block in 0..outer {
        for degree in 0..count {
            let scale = if degree == 0 { 1.0 } else { 2.0 } / count as f64;
            for i in 0..count {
                // x = −cos at the rising roots.
                let angle = PI - PI * (i as f64 + 0.5) / count as f64;
                let weight = scale * (degree as f64 * angle).cos();
                for lane in 0..inner {
                    out[(block * count + degree) * inner + lane] +=
                        weight * samples[(block * count + i) * inner + lane];
                }
            }
        }
    }
    out
}

/// The polynomials' values at a place of [0, 1].
fn chebyshev(place: f64, count: usize) -> [f64; MOST] {
    let x = (2.0 * place - 1.0).clamp(-1.2, 1.2);
    let mut values = [0.0; MOST];
    values[0] = 1.0;
    values[1] = x;
    for i in 2..count {
        values[i] = 2.0 * x * values[i - 1] - values[i - 2];
    }
    values
}

impl RefractionPolynomial {
    /// Fits an eye's function with `size` coefficients along the obliquity, β² and `w`; each from 3
    /// to 24, and what lies outside counts as the nearer.
    pub fn new(eye: RefractionEye, size: [usize; 3]) -> Self {
        let size = size.map(|count| count.clamp(3, MOST));
        let [nt, nb, nw] = size;
        let greatest = eye.greatest_half_tangent();
        let (ts, qs, ws) = (roots(nt), roots(nb), roots(nw));
        let half_tangents: Vec<f64> = ts.iter().map(|&x| greatest * ungrade(x)).collect();
        let frames: Vec<Frame> = half_tangents.iter().map(|&t| eye.frame(t)).collect();
        let mut samples = Vec::with_capacity(nt * nb * nw * 2);
        for (&t, frame) in half_tangents.iter().zip(&frames) {
            let light = RefractionEye::light(t);
            let mut sheet = Vec::with_capacity(nb);
            for &q in &qs {
                let beta = q.sqrt();
                let place_of = |x: f64| DVec2::new(frame_a(frame, wide(x), beta), beta * frame[0]);
                let mut column: Vec<Option<DVec2>> =
                    ws.iter().map(|&x| eye.solve(place_of(x), light)).collect();
                extend(&mut column, |node, near| {
                    eye.continued(place_of(ws[node]), light, near)
                });
                sheet.push(column);
            }
            let whole = complete(&sheet, &ws, eye.limbus_mm);
            for (row, &q) in whole.chunks_exact(nw).zip(&qs) {
                samples.extend(row.iter().flat_map(|k| [k.x, k.y / q.sqrt()]));
            }
        }
        let numbers: Vec<f64> = frames.iter().flatten().copied().collect();
        let frames = transform(&numbers, [1, nt, FRAME]);
        let values = transform(&samples, [1, nt, nb * nw * 2]);
        let values = transform(&values, [nt, nb, nw * 2]);
        let values = transform(&values, [nt * nb, nw, 2]);
        Self {
            size,
            greatest,
            frames: frames
                .chunks_exact(FRAME)
                .map(|frame| core::array::from_fn(|i| frame[i] as f32))
                .collect(),
            values: values
                .chunks_exact(2)
                .map(|pair| [pair[0] as f32, pair[1] as f32])
                .collect(),
        }
    }

    /// Bytes of the coefficients.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.frames[..])
    }

    /// The entry point `K` (x, y in mm) of the light from the unit direction `light` that reaches
    /// `place` (mm). Finite for all finite arguments.
    pub fn entry(&self, place: DVec2, light: DVec3) -> DVec2 {
        let [nt, nb, nw] = self.size;
        let across = light.truncate() + DVec2::new(1e-12, 0.0);
        let sine = across.length();
        let along = across / sine;
        let half_tangent = (sine / (1.0 - light.z) / self.greatest).min(1.0);
        let by_t = chebyshev(f64::from(grade(half_tangent as f32)), nt);
        let mut frame: Frame = [0.0; FRAME];
        for (weight, row) in by_t.iter().zip(&self.frames) {
            for (sum, value) in frame.iter_mut().zip(row) {
                *sum += weight * f64::from(*value);
            }
        }
        let (a, b) = (place.dot(along), along.perp_dot(place));
        let (w, beta) = frame_place(&frame, a, b.abs());
        let by_b = chebyshev(beta * beta, nb);
        let by_w = chebyshev(narrow(w), nw);
        let (mut k, mut at) = ([0.0; 2], 0);
        for weight_t in &by_t[..nt] {
            for weight_b in &by_b[..nb] {
                let mut row = [0.0; 2];
                for (weight, value) in by_w.iter().zip(&self.values[at..at + nw]) {
                    row[0] += weight * f64::from(value[0]);
                    row[1] += weight * f64::from(value[1]);
                }
                k[0] += weight_t * weight_b * row[0];
                k[1] += weight_t * weight_b * row[1];
                at += nw;
            }
        }
        let across = k[1] * beta.min(1.2) * 1.0_f64.copysign(b);
        k[0] * along + across * along.perp()
    }
}

/// The grid's `w` of a place in [0, 1], and back.
fn wide(x: f64) -> f64 {
    f64::from(LOWEST_W) + x * (1.0 - f64::from(LOWEST_W))
}

fn narrow(w: f64) -> f64 {
    (w - f64::from(LOWEST_W)) / (1.0 - f64::from(LOWEST_W))
}
