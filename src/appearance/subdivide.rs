//! Catmull–Clark subdivision of a quad mesh whose vertices carry any number of linear channels.
//!
//! In: quads and, for each vertex, `stride` numbers (position, texture coordinates, blend-shape
//! offsets …). Out: four times as many quads and the same channels refined. The rules are linear
//! in the channels, so a blend shape refined once here may be added to the refined positions at
//! run time and gives exactly the surface that refining the blended cage would give.
//! Rules: Catmull & Clark 1978; open borders follow the cubic B-spline rule
//! (Hoppe et al. 1994, crease masks).

use std::collections::BTreeMap;

/// A quad mesh with `stride` numbers for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadMesh {
    /// Corners of each quad, counter-clockwise.
    pub quads: Vec<[u32; 4]>,
    /// Channels of all vertices, `stride` numbers each.
    pub values: Vec<f32>,
    /// Numbers for each vertex, at least 1.
    pub stride: usize,
}

/// A refined mesh and where its new vertices came from.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The refined mesh. The children of quad `q` are `4q … 4q + 3`, child `k` at corner `k`.
    /// Vertices come in the order: old vertices, edge points, face points.
    pub mesh: QuadMesh,
    edge_point: BTreeMap<(u32, u32), u32>,
}

impl QuadMesh {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.values.len() / self.stride
    }

    fn row(&self, vertex: u32) -> &[f32] {
        let start = vertex as usize * self.stride;
        &self.values[start..start + self.stride]
    }
}

impl Refined {
    /// A chain of old edges (closed when `closed`) as a chain of new edges: old vertices with the
    /// edge points between them. An edge that the mesh lacks ends the chain.
    pub fn refine_chain(&self, chain: &[u32], closed: bool) -> Vec<u32> {
        let mut out = Vec::with_capacity(2 * chain.len());
        for (i, &a) in chain.iter().enumerate() {
            out.push(a);
            let next = if i + 1 < chain.len() {
                chain[i + 1]
            } else if closed {
                chain[0]
            } else {
                break;
            };
            match self.edge_point.get(&key(a, next)) {
                Some(&middle) => out.push(middle),
                None => break,
            }
        }
        out
    }
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// What surrounds one vertex.
#[derive(Clone, Default)]
struct Ring {
    faces: Vec<u32>,
    neighbours: Vec<u32>,
    border: Vec<u32>,
}

/// One Catmull–Clark step. Quads must index existing vertices and share an edge at most twice.
pub fn catmull_clark(mesh: &QuadMesh) -> Refined {
    let stride = mesh.stride;
    let count = mesh.vertex_count();
    let mut edges: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
    for (f, quad) in mesh.quads.iter().enumerate() {
        for k in 0..4 {
            edges
                .entry(key(quad[k], quad[(k + 1) % 4]))
                .or_default()
                .push(f as u32);
        }
    }
    let edge_point: BTreeMap<_, _> = edges
        .keys()
        .enumerate()
        .map(|(i, &e)| (e, (count + i) as u32))
        .collect();
    let first_face = (count + edges.len()) as u32;

    let face_values: Vec<f32> = mesh.quads.iter().flat_map(|q| mean(mesh, q)).collect();
    let face_row = |f: u32| &face_values[f as usize * stride..(f as usize + 1) * stride];

    let mut rings = vec![Ring::default(); count];
    for (&(a, b), faces) in &edges {
        for (v, other) in [(a, b), (b, a)] {
            rings[v as usize].neighbours.push(other);
            if faces.len() == 1 {
                rings[v as usize].border.push(other);
            }
        }
    }
    for (f, quad) in mesh.quads.iter().enumerate() {
        for &v in quad {
            rings[v as usize].faces.push(f as u32);
        }
    }

    let mut values = Vec::with_capacity((first_face as usize + mesh.quads.len()) * stride);
    for (v, ring) in rings.iter().enumerate() {
        values.extend(vertex_point(mesh, v as u32, ring, &face_row));
    }
    for (&(a, b), faces) in &edges {
        let (ra, rb) = (mesh.row(a), mesh.row(b));
        match faces.as_slice() {
            [f, g] => {
                let (rf, rg) = (face_row(*f), face_row(*g));
                values.extend((0..stride).map(|c| 0.25 * (ra[c] + rb[c] + rf[c] + rg[c])));
            }
            _ => values.extend((0..stride).map(|c| 0.5 * (ra[c] + rb[c]))),
        }
    }
    values.extend_from_slice(&face_values);

    let mut quads = Vec::with_capacity(4 * mesh.quads.len());
    for (f, quad) in mesh.quads.iter().enumerate() {
        let centre = first_face + f as u32;
        let middle = |k: usize| edge_point[&key(quad[k % 4], quad[(k + 1) % 4])];
        for (k, &corner) in quad.iter().enumerate() {
            quads.push([corner, middle(k), centre, middle(k + 3)]);
        }
    }
    Refined {
        mesh: QuadMesh {
            quads,
            values,
            stride,
        },
        edge_point,
    }
}

fn mean(mesh: &QuadMesh, vertices: &[u32]) -> Vec<f32> {
    let mut sum = vec![0.0; mesh.stride];
    for &v in vertices {
        for (s, x) in sum.iter_mut().zip(mesh.row(v)) {
            *s += x / vertices.len() as f32;
        }
    }
    sum
}

fn vertex_point<'a>(
    mesh: &QuadMesh,
    vertex: u32,
    ring: &Ring,
    face_row: &impl Fn(u32) -> &'a [f32],
) -> Vec<f32> {
    let own = mesh.row(vertex);
    if !ring.border.is_empty() || ring.faces.is_empty() {
        // Two border edges: the B-spline rule. Any other number is a corner and stays.
        if let [a, b] = ring.border[..] {
            let (ra, rb) = (mesh.row(a), mesh.row(b));
            return (0..mesh.stride)
                .map(|c| 0.75 * own[c] + 0.125 * (ra[c] + rb[c]))
                .collect();
        }
        return own.to_vec();
    }
    let n = ring.faces.len() as f32;
    let neighbours = mean(mesh, &ring.neighbours);
    let mut out = vec![0.0; mesh.stride];
    for &f in &ring.faces {
        for (o, x) in out.iter_mut().zip(face_row(f)) {
            *o += x / (n * n);
        }
    }
    for c in 0..mesh.stride {
        out[c] += neighbours[c] / n + own[c] * (n - 2.0) / n;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> QuadMesh {
        let values = (0..8)
            .flat_map(|i| [i & 1, (i >> 1) & 1, i >> 2].map(|b| 2.0 * b as f32 - 1.0))
            .collect();
        let quads = vec![
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        QuadMesh {
            quads,
            values,
            stride: 3,
        }
    }

    #[test]
    fn a_cube_follows_the_published_masks() {
        // Valence 3: F = (1/3,1/3,1/3)·corner, mean neighbour = 1/3·corner, so
        // V' = F/3 + N/3 + V/3 = 5/9 of the corner; edge points (1+1+0.5+0.5)/4 = 3/4.
        let refined = catmull_clark(&cube());
        for k in 0..24 {
            let (new, old) = (refined.mesh.values[k], cube().values[k]);
            assert!((new - old * 5.0 / 9.0).abs() < 1e-6, "{new} for {old}");
        }
        let edge = &refined.mesh.values[8 * 3..9 * 3];
        let mut sizes: Vec<f32> = edge.iter().map(|x| x.abs()).collect();
        sizes.sort_by(f32::total_cmp);
        for (got, want) in sizes.iter().zip([0.0, 0.75, 0.75]) {
            assert!((got - want).abs() < 1e-6);
        }
        assert_eq!(refined.mesh.quads.len(), 24);
        assert_eq!(refined.mesh.vertex_count(), 8 + 12 + 6);
    }

    #[test]
    fn a_flat_sheet_stays_flat_and_keeps_its_outline() {
        let values = vec![
            0., 0., 5., 1., 0., 5., 2., 0., 5., 0., 1., 5., 1., 1., 5., 2., 1., 5.,
        ];
        let mesh = QuadMesh {
            quads: vec![[0, 1, 4, 3], [1, 2, 5, 4]],
            values,
            stride: 3,
        };
        let refined = catmull_clark(&mesh);
        for row in refined.mesh.values.chunks(3) {
            assert!((row[2] - 5.0).abs() < 1e-6);
            assert!((-1e-6..=2.0).contains(&row[0]) && (-1e-6..=1.0).contains(&row[1]));
        }
        let chain = refined.refine_chain(&[0, 1, 2], false);
        assert_eq!(chain.len(), 5);
        let x: Vec<f32> = chain
            .iter()
            .map(|&v| refined.mesh.values[3 * v as usize])
            .collect();
        assert!(x.windows(2).all(|w| w[0] < w[1]), "{x:?}");
    }

    #[test]
    fn refining_is_linear_in_the_channels() {
        let mut other = cube();
        other
            .values
            .iter_mut()
            .enumerate()
            .for_each(|(i, v)| *v = (i * i % 7) as f32);
        let mut sum = cube();
        sum.values
            .iter_mut()
            .zip(&other.values)
            .for_each(|(a, b)| *a += 0.3 * b);
        let (a, b, s) = (
            catmull_clark(&cube()),
            catmull_clark(&other),
            catmull_clark(&sum),
        );
        for k in 0..s.mesh.values.len() {
            assert!((a.mesh.values[k] + 0.3 * b.mesh.values[k] - s.mesh.values[k]).abs() < 1e-5);
        }
    }
}
