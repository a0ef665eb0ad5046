//! The cut face as a smooth surface: reads the shipped cage, fits it to the globe, refines it.
//!
//! In: `assets/face/region.obj` and `targets/*.target` (CC0, globe frame, mm; see `assets/README.md`).
//! Out: a refined quad mesh outside the orbital border loop, the same refined blend shapes, and for
//! each border vertex its place along the palpebral margin and the vertices beside it.

use glam::Vec3;

use super::lid_profile::Column;
use super::lids::Lid;
use super::subdivide::{QuadMesh, catmull_clark};

/// A shipped face file that does not hold what it must.
#[derive(Debug, thiserror::Error)]
pub enum FaceError {
    /// A line that cannot be read.
    #[error("{file}: line {line}: {what}")]
    Line {
        /// File name below `assets/face`.
        file: &'static str,
        /// Line number from 1.
        line: usize,
        /// What is wrong, with the allowed values.
        what: String,
    },
    /// The file as a whole is wrong.
    #[error("{file}: {what}")]
    File {
        /// File name below `assets/face`.
        file: &'static str,
        /// What is wrong.
        what: &'static str,
    },
}

/// The face's blend shapes, in the order of [`Cage::shapes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Shape {
    /// Lids closed.
    Blink,
    /// Gaze up.
    LookUp,
    /// Gaze down.
    LookDown,
    /// Gaze towards the nose.
    LookIn,
    /// Gaze towards the temple.
    LookOut,
    /// Orbicular squint.
    Squint,
    /// Lids wide.
    Wide,
}

/// How often the shipped face is refined.
const REFINED: usize = 2;

const REGION: &str = "region.obj";
const SHAPES: [(&str, &str); 7] = [
    (
        "targets/blink.target",
        include_str!("../../assets/face/targets/blink.target"),
    ),
    (
        "targets/look_up.target",
        include_str!("../../assets/face/targets/look_up.target"),
    ),
    (
        "targets/look_down.target",
        include_str!("../../assets/face/targets/look_down.target"),
    ),
    (
        "targets/look_in.target",
        include_str!("../../assets/face/targets/look_in.target"),
    ),
    (
        "targets/look_out.target",
        include_str!("../../assets/face/targets/look_out.target"),
    ),
    (
        "targets/squint.target",
        include_str!("../../assets/face/targets/squint.target"),
    ),
    (
        "targets/wide.target",
        include_str!("../../assets/face/targets/wide.target"),
    ),
];
const STRIDE: usize = 3 + 3 * SHAPES.len();

/// The face's own eyeball is 27.6 mm wide and set forward: scale and shift (mm) that lay its lid
/// margin on an adult globe, fissure 28 mm wide.
const FIT_SCALE: f32 = 1.09;
const FIT_SHIFT_MM: Vec3 = Vec3::new(-0.8, 0.9, 5.4);

/// One vertex of the orbital border.
#[derive(Clone, Copy, Debug)]
pub struct BorderVertex {
    /// Its index in [`Cage::positions`].
    pub index: u32,
    /// Its outer neighbour's index in [`Cage::positions`].
    pub outer: u32,
    /// Position of its inner neighbour on the uncut surface, mm, at rest.
    pub inner: Vec3,
    /// The lid column that ends here.
    pub column: Column,
}

/// The refined face outside the border loop.
#[derive(Clone, Debug)]
pub struct Cage {
    /// Rest positions, mm.
    pub positions: Vec<Vec3>,
    /// Quads, outward side counter-clockwise seen from in front.
    pub quads: Vec<[u32; 4]>,
    /// For each [`Shape`], the vertices that it moves and by how much, mm.
    pub shapes: Vec<Vec<(u32, Vec3)>>,
    /// The border loop, medial canthus first, along the upper lid and back along the lower.
    pub border: Vec<BorderVertex>,
}

struct Source {
    mesh: QuadMesh,
    margin: Vec<u32>,
    border: Vec<u32>,
}

impl Cage {
    /// Its quads at a level of division: the finest (0), those from which they were refined (1), and those from which these were
    /// (2), between the vertices that they have kept.
    pub fn quads_of(&self, level: usize) -> Vec<[u32; 4]> {
        let mut quads = self.quads.clone();
        for _ in 0..level.min(REFINED) {
            // The children of a quad follow one another, each from the corner that it has kept.
            let parents = quads.chunks_exact(4);
            quads = parents
                .map(|children| [0, 1, 2, 3].map(|child: usize| children[child][0]))
                .collect();
        }
        quads
    }

    /// Reads, fits and refines the shipped face.
    pub fn load() -> Result<Self, FaceError> {
        let mut source = parse_region(include_str!("../../assets/face/region.obj"))?;
        for (number, (file, text)) in SHAPES.into_iter().enumerate() {
            parse_shape(file, text, number, &mut source.mesh)?;
        }
        let mut inside = inside_faces(&source)?;
        for _ in 0..REFINED {
            let refined = catmull_clark(&source.mesh);
            source = Source {
                margin: refined.refine_chain(&source.margin, true),
                border: refined.refine_chain(&source.border, true),
                mesh: refined.mesh,
            };
            inside = inside.iter().flat_map(|&f| [f; 4]).collect();
        }
        assemble(&source, &inside)
    }
}

fn bad_file(what: &'static str) -> FaceError {
    FaceError::File { file: REGION, what }
}

fn numbers<const N: usize>(
    file: &'static str,
    line: usize,
    words: &[&str],
) -> Result<[f32; N], FaceError> {
    let wrong = || FaceError::Line {
        file,
        line,
        what: format!("expected {N} finite numbers"),
    };
    if words.len() != N {
        return Err(wrong());
    }
    let mut out = [0.0; N];
    for (o, w) in out.iter_mut().zip(words) {
        *o = w
            .parse()
            .ok()
            .filter(|x: &f32| x.is_finite())
            .ok_or_else(wrong)?;
    }
    Ok(out)
}

fn index(file: &'static str, line: usize, word: &str, count: usize) -> Result<u32, FaceError> {
    let first = word.split('/').next().unwrap_or("");
    match first.parse::<usize>() {
        Ok(n) if (1..=count).contains(&n) => Ok(n as u32 - 1),
        _ => Err(FaceError::Line {
            file,
            line,
            what: format!("vertex `{word}` must be 1 to {count}"),
        }),
    }
}

fn parse_region(text: &str) -> Result<Source, FaceError> {
    let (mut points, mut quads) = (Vec::new(), Vec::new());
    let (mut margin, mut border, mut group) = (Vec::new(), Vec::new(), "");
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let rest = words.get(1..).unwrap_or(&[]);
        let indices = || {
            rest.iter()
                .map(|w| index(REGION, i + 1, w, points.len()))
                .collect::<Result<Vec<_>, _>>()
        };
        match words.first().copied() {
            Some("v") => points.push(Vec3::from_array(numbers(REGION, i + 1, rest)?)),
            Some("g") => group = rest.first().copied().unwrap_or(""),
            Some("f") => {
                let quad: [u32; 4] = indices()?.try_into().map_err(|_| FaceError::Line {
                    file: REGION,
                    line: i + 1,
                    what: "a face must have 4 corners".into(),
                })?;
                quads.push(quad);
            }
            Some("l") if group == "lid_margin" => margin = indices()?,
            Some("l") if group == "lid_border" => border = indices()?,
            _ => {}
        }
    }
    if points.is_empty() || margin.len() < 8 || border.len() != margin.len() {
        return Err(bad_file(
            "needs vertices, and two equal edge loops of 8 or more",
        ));
    }
    let mut values = Vec::with_capacity(points.len() * STRIDE);
    for p in &points {
        values.extend((*p * FIT_SCALE + FIT_SHIFT_MM).to_array());
        values.extend([0.0; 3 * SHAPES.len()]);
    }
    Ok(Source {
        mesh: QuadMesh {
            quads,
            values,
            stride: STRIDE,
        },
        margin,
        border,
    })
}

fn parse_shape(
    file: &'static str,
    text: &str,
    number: usize,
    mesh: &mut QuadMesh,
) -> Result<(), FaceError> {
    for (i, line) in text
        .lines()
        .enumerate()
        .filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty())
    {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [at, x, y, z] = numbers(file, i + 1, &words)?;
        let (vertex, count) = (at as usize, mesh.vertex_count());
        if at < 0.0 || vertex >= count {
            let what = format!("vertex {at} must be 0 to {}", count - 1);
            return Err(FaceError::Line {
                file,
                line: i + 1,
                what,
            });
        }
        let start = vertex * STRIDE + 3 + 3 * number;
        for (c, d) in [x, y, z].into_iter().enumerate() {
            mesh.values[start + c] = d * FIT_SCALE;
        }
    }
    Ok(())
}

/// Which faces lie between the margin loop and the border loop.
fn inside_faces(source: &Source) -> Result<Vec<bool>, FaceError> {
    let on_border = |a: u32, b: u32| {
        let at = source.border.iter().position(|&v| v == a);
        at.is_some_and(|i| {
            let n = source.border.len();
            source.border[(i + 1) % n] == b || source.border[(i + n - 1) % n] == b
        })
    };
    let quads = &source.mesh.quads;
    let mut inside: Vec<bool> = quads
        .iter()
        .map(|q| q.iter().any(|v| source.margin.contains(v)))
        .collect();
    loop {
        let mut grew = false;
        for f in 0..quads.len() {
            if !inside[f] {
                continue;
            }
            for g in 0..quads.len() {
                let shared = |k: usize| {
                    let (a, b) = (quads[f][k], quads[f][(k + 1) % 4]);
                    quads[g].contains(&a) && quads[g].contains(&b) && !on_border(a, b)
                };
                if !inside[g] && (0..4).any(shared) {
                    inside[g] = true;
                    grew = true;
                }
            }
        }
        if !grew {
            break;
        }
    }
    if inside.iter().all(|&f| f) {
        return Err(bad_file(
            "the loop lid_border does not close around lid_margin",
        ));
    }
    Ok(inside)
}

fn assemble(source: &Source, inside: &[bool]) -> Result<Cage, FaceError> {
    let mesh = &source.mesh;
    let row = |v: u32| &mesh.values[v as usize * STRIDE..(v as usize + 1) * STRIDE];
    let point = |v: u32, at: usize| Vec3::new(row(v)[at], row(v)[at + 1], row(v)[at + 2]);
    let mut new = vec![u32::MAX; mesh.vertex_count()];
    let mut order = Vec::new();
    let mut quads = Vec::new();
    for (quad, _) in mesh
        .quads
        .iter()
        .zip(inside)
        .filter(|(_, inside)| !**inside)
    {
        quads.push(quad.map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = order.len() as u32;
                order.push(v);
            }
            new[v as usize]
        }));
    }
    let shapes = (0..SHAPES.len())
        .map(|s| {
            let moved = order
                .iter()
                .enumerate()
                .map(|(i, &v)| (i as u32, point(v, 3 + 3 * s)));
            moved.filter(|(_, d)| d.length_squared() > 1e-6).collect()
        })
        .collect();

    let columns = columns(
        &source
            .margin
            .iter()
            .map(|&v| point(v, 0))
            .collect::<Vec<_>>(),
    );
    // Across a border vertex, the neighbour that is not on the border, on the wanted side.
    let beside = |v: u32, wanted: bool| {
        let faces = mesh
            .quads
            .iter()
            .zip(inside)
            .filter(|(q, i)| **i == wanted && q.contains(&v));
        faces
            .flat_map(|(q, _)| (0..4).map(|k| (q[k], q[(k + 1) % 4])))
            .find_map(|(a, b)| {
                let other = if a == v {
                    b
                } else if b == v {
                    a
                } else {
                    return None;
                };
                (!source.border.contains(&other)).then_some(other)
            })
    };
    let mut border = Vec::new();
    for (i, &v) in source.border.iter().enumerate() {
        let (Some(inner), Some(outer)) = (beside(v, true), beside(v, false)) else {
            return Err(bad_file(
                "a vertex of lid_border has no neighbour on one side",
            ));
        };
        border.push(BorderVertex {
            index: new[v as usize],
            outer: new[outer as usize],
            inner: point(inner, 0),
            column: columns[i],
        });
    }
    let first = (0..border.len())
        .min_by(|&a, &b| border[a].column.t.total_cmp(&border[b].column.t))
        .ok_or_else(|| bad_file("lid_border is empty"))?;
    border.rotate_left(first);
    if border.get(1).is_some_and(|b| b.column.lid == Lid::Lower) {
        border[1..].reverse();
    }
    Ok(Cage {
        positions: order.iter().map(|&v| point(v, 0)).collect(),
        quads,
        shapes,
        border,
    })
}

/// Where each vertex of the face's own margin loop lies along the upper or lower margin.
fn columns(margin: &[Vec3]) -> Vec<Column> {
    let n = margin.len();
    let by_x = |a: &usize, b: &usize| margin[*a].x.total_cmp(&margin[*b].x);
    let medial = (0..n).min_by(by_x).unwrap_or(0);
    let lateral = (0..n).max_by(by_x).unwrap_or(0);
    let mut out = vec![
        Column {
            lid: Lid::Upper,
            t: 0.0
        };
        n
    ];
    for step in [1, n - 1] {
        let mut chain = vec![medial];
        while chain[chain.len() - 1] != lateral {
            chain.push((chain[chain.len() - 1] + step) % n);
        }
        let mut length = vec![0.0];
        for w in chain.windows(2) {
            length.push(length[length.len() - 1] + margin[w[0]].distance(margin[w[1]]));
        }
        let height = |c: &[usize]| c.iter().map(|&v| margin[v].y).sum::<f32>() / c.len() as f32;
        let middle = 0.5 * (margin[medial].y + margin[lateral].y);
        let lid = if height(&chain) > middle {
            Lid::Upper
        } else {
            Lid::Lower
        };
        for (&v, l) in chain.iter().zip(&length).skip(1).take(chain.len() - 2) {
            out[v] = Column {
                lid,
                t: l / length[length.len() - 1],
            };
        }
    }
    out[lateral].t = 1.0;
    out
}
