//! The refraction function as François et al. 2007 lay it out (section 5.1), as a baseline: samples
//! of `K`, three 32-bit numbers each, on one radius of the iris and over the hemisphere of
//! directions, read by linear interpolation in both.
//!
//! The paper does not say how it samples the hemisphere: here a square grid in the stereographic
//! projection of the direction, `ω_xy/(1 + |ω_z|)`, the mildest of the usual ones at the rim. Where
//! no light arrives (below the horizon, in the corners of the grid, past grazing incidence) the samples
//! go on analytically as far as the map does not turn back, and stay constant beyond.
//!
//! The paper gives 12 KB for 10 × 100 samples and 300 KB for 100 × 2,500. The former is 12 bytes a
//! sample; by the same measure the latter is 3 MB, and 300 KB hold 100 × 250 or 10 × 2,500.

use crate::optics::conicoid::conicoid_sag;
use crate::optics::refraction_function::domain::RefractionEye;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Parts of the way from the axis to a direction without light, for the continuation.
const PARTS: u32 = 24;

/// The paper's table.
pub struct PublishedTable {
    radii: usize,
    side: usize,
    limbus_mm: f32,
    samples: Vec<Vec3>,
}

impl PublishedTable {
    /// Samples the function of an eye at `radii` places of a radius and `directions` directions (a
    /// square number; the next smaller one counts). Both at least 2 a side.
    pub fn new(eye: &RefractionEye, radii: usize, directions: usize) -> Self {
        let (radii, side) = (radii.max(2), directions.isqrt().max(2));
        let node = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let mut samples = Vec::with_capacity(radii * side * side);
        for radius in 0..radii {
            let place = DVec2::new(eye.limbus_mm * node(radius, radii), 0.0);
            for row in 0..side {
                for column in 0..side {
                    let q = DVec2::new(node(column, side), node(row, side)) * 2.0 - 1.0;
                    samples.push(sample(eye, place, q).as_vec3());
                }
            }
        }
        Self {
            radii,
            side,
            limbus_mm: eye.limbus_mm as f32,
            samples,
        }
    }

    /// Bytes of the samples.
    pub fn bytes(&self) -> usize {
        self.samples.len() * size_of::<Vec3>()
    }

    /// The entry point for the light from the unit direction `light` that reaches `place` (mm).
    pub fn entry(&self, place: DVec2, light: DVec3) -> DVec3 {
        let (place, light) = (place.as_vec2(), light.as_vec3());
        let radius = place.length();
        let along = if radius > 0.0 {
            place / radius
        } else {
            Vec2::X
        };
        let across = light.truncate();
        let q = Vec2::new(across.dot(along), along.perp_dot(across)) / (1.0 - light.z);
        let (i, u) = cell(radius / self.limbus_mm, self.radii);
        let (j, v) = cell(0.5 * q.y + 0.5, self.side);
        let (k, w) = cell(0.5 * q.x + 0.5, self.side);
        let at = |di: usize, dj: usize| {
            let first = ((i + di) * self.side + j + dj) * self.side + k;
            self.samples[first].lerp(self.samples[first + 1], w)
        };
        let inner = at(0, 0).lerp(at(0, 1), v);
        let outer = at(1, 0).lerp(at(1, 1), v);
        let entry = inner.lerp(outer, u);
        (entry.x * along + entry.y * along.perp())
            .extend(entry.z)
            .as_dvec3()
    }
}

/// The cell of a coordinate from 0 to 1 among `count` nodes, and the share of the way across it.
fn cell(u: f32, count: usize) -> (usize, f32) {
    let x = u.clamp(0.0, 1.0) * (count - 1) as f32;
    let first = (x as usize).min(count - 2);
    (first, x - first as f32)
}

/// The direction whose stereographic projection is `q`; outside of the unit disc below the horizon.
fn direction(q: DVec2) -> DVec3 {
    let squared = q.length_squared();
    (2.0 * q).extend(squared - 1.0) / (1.0 + squared)
}

fn sample(eye: &RefractionEye, place: DVec2, q: DVec2) -> DVec3 {
    let lift = |k: DVec2| k.extend(conicoid_sag(k.length(), eye.surface.x, eye.surface.y));
    let light = direction(q);
    // Light through the cornea's rim outside of the limbus would come by another path.
    let lit = eye.solve(place, light).filter(|k| {
        let bent = eye.land(*k, light);
        light.z < 0.0 && bent.cos_incidence > 0.0 && k.length() < 1.2 * eye.limbus_mm
    });
    if let Some(k) = lit {
        return lift(k);
    }
    let mut k = eye.solve(place, DVec3::NEG_Z).unwrap_or(place);
    for part in 1..=PARTS {
        let nearer = direction(q * (f64::from(part) / f64::from(PARTS)));
        // Past grazing light the map turns back on itself: there the last sample serves better.
        match eye.continued(place, nearer, k) {
            Some(next) if eye.land(next, nearer).cos_incidence > 0.0 => k = next,
            _ => break,
        }
    }
    lift(k)
}
