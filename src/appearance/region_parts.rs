//! The meshes of the skin around an eye, as finely divided as a picture shows.
//!
//! In: the triangles of a region ([`EyeRegion`](super::face_region::EyeRegion)). Out: lists of its vertices and the triangles
//! between them, for each of its materials. A coarser level has every second or fourth vertex of the finest one, where it stands
//! there, and normals of its own: a software rasteriser shades four by four pixels for each triangle that touches
//! them, so that triangles of a few pixels cost several times what larger ones do.

use super::lid_profile::ROWS;
use std::collections::HashMap;

/// Levels of division.
pub const LEVELS: usize = 3;

/// Columns of the lids that one quad spans at each level.
pub(super) const COLUMN_STEP: [usize; LEVELS] = [1, 2, 4];

/// Steps of the corners' grids that one quad spans.
pub(super) const CORNER_STEP: [usize; LEVELS] = [1, 2, 2];

/// Rows of the lids that have vertices at each level: closer where the lid turns round its edges and at the fold. The last one is the
/// orbital border.
pub(super) const ROWS_OF: [&[usize]; LEVELS] = [
    &[
        0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24,
        25, 26, 27, ROWS,
    ],
    &[0, 2, 3, 5, 7, 9, 11, 13, 15, 16, 17, 19, 21, 23, 25, ROWS],
    &[0, 3, 5, 7, 10, 13, 16, 19, 22, 25, ROWS],
];

/// Pixels for each millimetre of skin from which the next finer level is drawn: where a coarser one would be half a pixel off
/// ([`ERROR_MM`]).
pub const PIXELS_A_MM: [f32; LEVELS - 1] = [0.5 / ERROR_MM[1], 0.5 / ERROR_MM[2]];

/// How far the surface of each level is from the vertices of the finest one that are in sight, mm: root mean square, measured by a
/// test.
pub const ERROR_MM: [f32; LEVELS] = [0.0, 0.04, 0.12];

/// The level for so many pixels a millimetre, where from these on the next finer one is drawn. One that is drawn is kept until a tenth more or
/// less.
pub fn level_for(pixels_a_mm: f32, drawn: usize, finer_from: &[f32]) -> usize {
    let level = |pixels: f32| finer_from.iter().filter(|&&from| pixels < from).count();
    drawn.clamp(level(pixels_a_mm * 1.1), level(pixels_a_mm / 1.1))
}

/// Some triangles of a region that are a mesh of their own.
#[derive(Clone, Debug, Default)]
pub struct RegionPart {
    /// Its vertices in the region's lists.
    pub vertices: Vec<u32>,
    /// Its triangles: places in `vertices`.
    pub indices: Vec<u32>,
}

impl RegionPart {
    fn of(triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut part = Self::default();
        let mut places = HashMap::new();
        for vertex in triangles.flatten() {
            let place = *places.entry(vertex).or_insert_with(|| {
                part.vertices.push(vertex);
                part.vertices.len() as u32 - 1
            });
            part.indices.push(place);
        }
        part
    }

    /// What a list of the region has for the vertices of this part.
    ///
    /// # Panics
    /// If the list is not one of the region that this part is of.
    pub fn of_list<'a, T: Copy>(&'a self, list: &'a [T]) -> impl ExactSizeIterator<Item = T> + 'a {
        self.vertices.iter().map(|&vertex| list[vertex as usize])
    }
}

/// The meshes of one level.
#[derive(Clone, Debug, Default)]
pub struct RegionParts {
    /// The skin, which is dry.
    pub skin: RegionPart,
    /// The lid margins, which tears wet.
    pub margin: RegionPart,
    /// Plica, caruncle and outer corner.
    pub conjunctiva: RegionPart,
}

impl RegionParts {
    /// Divides the triangles of face and lids by whether any of their vertices is wet.
    pub(super) fn new(face: &[[u32; 3]], corners: &[[u32; 3]], wet: impl Fn(u32) -> bool) -> Self {
        let is_wet = |triangle: &[u32; 3]| triangle.iter().any(|&vertex| wet(vertex));
        let (margin, skin): (Vec<[u32; 3]>, Vec<_>) = face.iter().partition(|&t| is_wet(t));
        Self {
            skin: RegionPart::of(skin.into_iter()),
            margin: RegionPart::of(margin.into_iter()),
            conjunctiva: RegionPart::of(corners.iter().copied()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::face_region::{EyeRegion, LidPose, PosedRegion};
    use glam::Vec3;

    /// Distance from a triangle's plane within it, or from its edges.
    fn from_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
        let segment = |a: Vec3, b: Vec3| {
            let along = b - a;
            let s = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            p.distance(a + along * s)
        };
        let normal = (b - a).cross(c - a);
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
        if inside && normal.length_squared() > 0.0 {
            (p - a).dot(normal.normalize()).abs()
        } else {
            segment(a, b).min(segment(b, c)).min(segment(c, a))
        }
    }

    #[test]
    fn a_coarser_level_is_off_by_what_is_said() {
        let region = EyeRegion::load().unwrap();
        for aperture in [1.0, 0.5, 0.0] {
            let pose = LidPose {
                aperture,
                ..LidPose::default()
            };
            let mut out = PosedRegion::default();
            region.pose(&pose, &|_| 11.5, &mut out);
            let place = |vertex: u32| Vec3::from(out.positions[vertex as usize]);
            for (level, most) in ERROR_MM.into_iter().enumerate().skip(1) {
                let parts = region.parts(level);
                let mut triangles: Vec<[Vec3; 3]> = Vec::new();
                for part in [&parts.skin, &parts.margin, &parts.conjunctiva] {
                    let own = part.indices.chunks_exact(3);
                    triangles.extend(
                        own.map(|t| [t[0], t[1], t[2]].map(|at| place(part.vertices[at as usize]))),
                    );
                }
                let (mut sum, mut count, mut largest) = (0.0, 0.0, (0.0, Vec3::ZERO));
                for (vertex, light) in out.light.iter().enumerate() {
                    // What lies under the lid or deep in its fold is not seen.
                    if *light < 0.75 {
                        continue;
                    }
                    let p = place(vertex as u32);
                    let near = triangles
                        .iter()
                        .map(|t| from_triangle(p, *t))
                        .fold(f32::MAX, f32::min);
                    sum += f64::from(near * near);
                    count += 1.0;
                    if near > largest.0 {
                        largest = (near, p);
                    }
                }
                let rms = (sum / count).sqrt() as f32;
                println!("{aperture} open, level {level}: {rms:.4} mm, largest {largest:?}");
                assert!(rms < most, "{aperture} {level}: {rms}");
            }
        }
    }

    #[test]
    fn levels_are_chosen_by_pixels_and_kept_a_while() {
        let level_for = |pixels, drawn| super::level_for(pixels, drawn, &PIXELS_A_MM);
        assert_eq!(level_for(f32::INFINITY, 2), 0);
        assert_eq!(level_for(0.0, 0), LEVELS - 1);
        for (level, from) in PIXELS_A_MM.into_iter().enumerate() {
            assert_eq!(level_for(from * 1.2, level + 1), level);
            assert_eq!(level_for(from / 1.2, level), level + 1);
            // Between, what is drawn stays.
            for pixels in [from * 1.05, from / 1.05] {
                assert_eq!(level_for(pixels, level), level);
                assert_eq!(level_for(pixels, level + 1), level + 1);
            }
        }
    }

    #[test]
    fn every_level_is_closed_as_the_finest_is() {
        let region = EyeRegion::load().unwrap();
        let rims: Vec<usize> = (0..LEVELS)
            .map(|level| {
                let parts = region.parts(level);
                let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
                for part in [&parts.skin, &parts.margin] {
                    for t in part.indices.chunks_exact(3) {
                        for k in 0..3 {
                            let [a, b] =
                                [t[k], t[(k + 1) % 3]].map(|at| part.vertices[at as usize]);
                            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
                        }
                    }
                }
                assert!(edges.values().all(|&faces| faces <= 2));
                edges.values().filter(|&&faces| faces == 1).count()
            })
            .collect();
        println!("edges of the rims: {rims:?}");
        // The rims of face and fissure alone, of half and of a quarter of the edges; a crack would add two.
        assert!(
            rims.windows(2).all(|pair| pair[0] == 2 * pair[1]),
            "{rims:?}"
        );
    }
}
