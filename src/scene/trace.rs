//! Rays into a scene on the CPU.
//!
//! Enters: a [`SceneModel`]. Leaves: the first surface along a ray (exact distances for tests and
//! for putting things where they belong), ambient occlusion baked into vertex colours, and the
//! mean luminance of the view. Surfaces are taken as Lambertian here: `L = ρ E / π`, plus emission
//! and ambient light (see [`SceneLight`] for the units). Triangles are intersected as in Möller
//! and Trumbore 1997, inside a median-split bounding volume hierarchy.

use super::model::{
    Alpha, SceneLight, SceneModel, UNLIT_WHITE_CD_M2, Wrap, luminance, srgb_to_linear,
};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// Where a ray first meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the unit ray, m.
    pub distance_m: f32,
    /// Index into [`SceneModel::meshes`].
    pub mesh: usize,
    triangle: usize,
    barycentric: Vec2,
}

#[derive(Debug, Clone, Copy)]
struct Triangle {
    corner: Vec3,
    edges: [Vec3; 2],
    mesh: u32,
    first_index: u32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// Leaf: first triangle. Inner node: the right child (the left one follows its parent).
    start: u32,
    /// Triangles in a leaf, 0 in an inner node.
    count: u32,
    /// Along which the children are sorted.
    axis: usize,
}

/// All triangles of a scene, sorted for rays.
#[derive(Debug)]
pub struct Tree {
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

/// The way from a place to a light that shines on it, unless something is in it.
struct Ray {
    towards: Vec3,
    length_m: f32,
    color: Vec3,
    /// Illuminance of a surface that faces the light, lx.
    lux: f32,
    shadows: bool,
    is_sun: bool,
}

impl Ray {
    fn to(light: &SceneLight, place: Vec3) -> Option<Self> {
        match *light {
            SceneLight::Ambient { .. } => None,
            SceneLight::Directional {
                direction,
                color,
                illuminance_lux,
                shadows,
            } => Some(Self {
                towards: -Vec3::from(direction),
                length_m: 1e4,
                color: color.into(),
                lux: illuminance_lux,
                shadows,
                is_sun: true,
            }),
            SceneLight::Point {
                position,
                color,
                intensity_lm,
                range,
                shadows,
            } => {
                let offset = Vec3::from(position) - place;
                let distance = offset.length().max(1e-3);
                let candela = intensity_lm / (4.0 * PI);
                (distance < range).then(|| Self {
                    towards: offset / distance,
                    length_m: distance,
                    color: color.into(),
                    lux: candela / (distance * distance),
                    shadows,
                    is_sun: false,
                })
            }
        }
    }
}

/// A scene prepared for rays.
#[derive(Debug)]
pub struct Tracer<'a> {
    scene: &'a SceneModel,
    tree: Arc<Tree>,
}

impl<'a> Tracer<'a> {
    /// Sorts all triangles of a valid scene (see [`SceneModel::validate`]).
    pub fn new(scene: &'a SceneModel) -> Self {
        let mut triangles = Vec::with_capacity(scene.triangle_count());
        for (mesh_index, mesh) in scene.meshes.iter().enumerate() {
            for (index, corners) in mesh.indices.chunks_exact(3).enumerate() {
                let at = |k: usize| Vec3::from(mesh.positions[corners[k] as usize]);
                triangles.push(Triangle {
                    corner: at(0),
                    edges: [at(1) - at(0), at(2) - at(0)],
                    mesh: mesh_index as u32,
                    first_index: 3 * index as u32,
                });
            }
        }
        let mut nodes = Vec::with_capacity(triangles.len());
        let count = triangles.len();
        if count > 0 {
            split(&mut triangles, 0, count, &mut nodes);
        }
        Self::with(scene, Arc::new(Tree { triangles, nodes }))
    }

    /// The same scene again, with the tree that was made of it ([`Self::tree`]).
    pub fn with(scene: &'a SceneModel, tree: Arc<Tree>) -> Self {
        Self { scene, tree }
    }

    /// The sorted triangles, to be kept.
    pub fn tree(&self) -> Arc<Tree> {
        self.tree.clone()
    }

    /// The nearest surface at a distance between `near` and `far` metres along the unit
    /// direction, through the holes of masked textures.
    pub fn cast(&self, origin: Vec3, direction: Vec3, near: f32, far: f32) -> Option<Hit> {
        // A tiny slope in place of zero keeps 0 · ∞ out of the slab test.
        let steep = |c: f32| if c.abs() < 1e-18 { 1e18 } else { c.recip() };
        let inverse = Vec3::new(steep(direction.x), steep(direction.y), steep(direction.z));
        let (mut best, mut limit) = (None, far);
        let mut stack = [0u32; 64];
        let Tree { triangles, nodes } = &*self.tree;
        let mut depth = usize::from(!nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &nodes[stack[depth] as usize];
            if !crosses(node, origin, inverse, limit) {
                continue;
            }
            if node.count == 0 {
                // The nearer child is on top of the stack.
                let (left, right) = (stack[depth] + 1, node.start);
                let leftwards = direction[node.axis] < 0.0;
                stack[depth] = if leftwards { left } else { right };
                stack[depth + 1] = if leftwards { right } else { left };
                depth += 2;
                continue;
            }
            for index in node.start..node.start + node.count {
                let triangle = &triangles[index as usize];
                if let Some((distance, barycentric)) = intersect(triangle, origin, direction)
                    && distance > near
                    && distance < limit
                {
                    let hit = Hit {
                        distance_m: distance,
                        mesh: triangle.mesh as usize,
                        triangle: triangle.first_index as usize,
                        barycentric,
                    };
                    if self.is_solid(&hit) {
                        limit = distance;
                        best = Some(hit);
                    }
                }
            }
        }
        best
    }

    fn is_solid(&self, hit: &Hit) -> bool {
        match self.scene.materials[self.scene.meshes[hit.mesh].material].alpha {
            Alpha::Mask(cut_off) => self.albedo(hit)[3] >= cut_off,
            Alpha::Opaque | Alpha::Blend => true,
        }
    }

    fn interpolate<const N: usize>(&self, hit: &Hit, values: &[[f32; N]]) -> [f32; N] {
        let corners = &self.scene.meshes[hit.mesh].indices[hit.triangle..hit.triangle + 3];
        let Vec2 { x: b, y: c } = hit.barycentric;
        let at = |k: usize, i: usize| values[corners[k] as usize][i];
        std::array::from_fn(|i| at(0, i) * (1.0 - b - c) + at(1, i) * b + at(2, i) * c)
    }

    fn sample(&self, hit: &Hit, texture: Option<usize>, on_second: bool) -> [f32; 4] {
        let mesh = &self.scene.meshes[hit.mesh];
        let uvs = if on_second {
            &mesh.second_uvs
        } else {
            &mesh.uvs
        };
        let (Some(index), Some(uvs)) = (texture, uvs) else {
            return [1.0; 4];
        };
        let texture = &self.scene.textures[index];
        let [u, v] = self.interpolate(hit, uvs);
        let texel = |coordinate: f32, size: u32, wrap: Wrap| {
            let wrapped = match wrap {
                Wrap::Clamp => coordinate,
                Wrap::Repeat => coordinate.rem_euclid(1.0),
                Wrap::Mirror => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
            };
            ((wrapped * size as f32).max(0.0) as u32).min(size - 1)
        };
        let row = texel(v, texture.height, texture.wrap[1]);
        let column = texel(u, texture.width, texture.wrap[0]);
        let at = (row * texture.width + column) as usize * 4;
        let alpha = f32::from(texture.rgba8[at + 3]) / 255.0;
        let [r, g, b] = [0, 1, 2].map(|k| srgb_to_linear(texture.rgba8[at + k]));
        [r, g, b, alpha]
    }

    /// Linear base colour and alpha at a hit.
    pub fn albedo(&self, hit: &Hit) -> [f32; 4] {
        let mesh = &self.scene.meshes[hit.mesh];
        let material = &self.scene.materials[mesh.material];
        let color = mesh
            .colors
            .as_ref()
            .map_or([1.0; 4], |c| self.interpolate(hit, c));
        let texel = self.sample(hit, material.base_color_texture, false);
        std::array::from_fn(|i| material.base_color[i] * texel[i] * color[i])
    }

    /// Radiance that arrives at `origin` from a unit direction, linear sRGB in cd/m².
    pub fn radiance(&self, origin: Vec3, direction: Vec3) -> [f32; 3] {
        let Some(hit) = self.cast(origin, direction, 1e-3, f32::INFINITY) else {
            return self.scene.background;
        };
        let mesh = &self.scene.meshes[hit.mesh];
        let material = &self.scene.materials[mesh.material];
        let facing = Vec3::from(self.interpolate(&hit, &mesh.normals)).normalize_or(-direction);
        let normal = if facing.dot(direction) > 0.0 {
            -facing
        } else {
            facing
        };
        let point = origin + direction * hit.distance_m + normal * 2e-3;
        let albedo = self.albedo(&hit);
        if material.unlit {
            return std::array::from_fn(|i| albedo[i] * UNLIT_WHITE_CD_M2);
        }
        let light = self.arriving(point, normal);
        let on_second = material.on_second_uvs.emissive;
        let glow = self.sample(&hit, material.emissive_texture, on_second);
        std::array::from_fn(|i| albedo[i] * light[i] + material.emissive[i] * glow[i])
    }

    /// Luminance of a white matt surface at a point, linear sRGB in cd/m².
    fn arriving(&self, point: Vec3, normal: Vec3) -> [f32; 3] {
        let lights = self.scene.lights.iter();
        let sum: Vec3 = lights
            .map(|light| match (*light, Ray::to(light, point)) {
                (SceneLight::Ambient { color, brightness }, _) => Vec3::from(color) * brightness,
                (_, Some(ray)) => {
                    let cosine = normal.dot(ray.towards);
                    // What faces away needs no ray for its shadow.
                    if cosine > 0.0 && self.is_free(point, &ray) {
                        ray.color * (ray.lux * cosine / PI)
                    } else {
                        Vec3::ZERO
                    }
                }
                _ => Vec3::ZERO,
            })
            .sum();
        sum.into()
    }

    fn is_free(&self, place: Vec3, ray: &Ray) -> bool {
        !ray.shadows || self.cast(place, ray.towards, 1e-4, ray.length_m).is_none()
    }

    /// The scene's own lights that reach a place: towards it (unit), and the luminance that a white matt surface facing it
    /// has, linear sRGB in cd/m²; and whether it is a sun.
    pub fn lights_at(&self, place: Vec3) -> impl Iterator<Item = (Vec3, Vec3, bool)> + '_ {
        let lights = self.scene.lights.iter();
        lights
            .filter_map(move |light| Ray::to(light, place))
            .filter(move |ray| self.is_free(place, ray))
            .map(|ray| (ray.towards, ray.color * (ray.lux / PI), ray.is_sun))
    }

    /// Mean luminance of the view from the scene's eye, cd/m², over `side × side` directions that
    /// are even in the image plane of the placement's field of view.
    pub fn mean_luminance_cd_m2(&self, side: u32) -> f64 {
        let eye = &self.scene.eye;
        let (forward, up) = (Vec3::from(eye.forward), Vec3::from(eye.up));
        let right = forward.cross(up);
        let extent = [eye.horizontal_fov_deg, eye.vertical_fov_deg]
            .map(|deg| (0.5 * deg.to_radians()).tan());
        let mut sum = 0.0;
        for row in 0..side {
            for column in 0..side {
                let [x, y] = [column, row].map(|k| 2.0 * (k as f32 + 0.5) / side as f32 - 1.0);
                let ray = (forward + right * (x * extent[0]) + up * (y * extent[1])).normalize();
                sum += f64::from(luminance(self.radiance(eye.position_m.into(), ray)));
            }
        }
        sum / f64::from(side * side).max(1.0)
    }
}

/// Builds the subtree over `triangles[start..end]`; returns nothing, as the root of a subtree is
/// where `nodes` ended before.
fn split(triangles: &mut [Triangle], start: usize, end: usize, nodes: &mut Vec<Node>) {
    let part = &mut triangles[start..end];
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (mut centre_low, mut centre_high) = (low, high);
    for t in part.iter() {
        let corners = [t.corner, t.corner + t.edges[0], t.corner + t.edges[1]];
        for corner in corners {
            (low, high) = (low.min(corner), high.max(corner));
        }
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        (centre_low, centre_high) = (centre_low.min(centre), centre_high.max(centre));
    }
    let this = nodes.len();
    let count = end - start;
    nodes.push(Node {
        low,
        high,
        start: start as u32,
        count: count as u32,
        axis: 0,
    });
    if count <= 4 {
        return;
    }
    let extent = centre_high - centre_low;
    let axis = usize::from(extent.y > extent.x);
    let axis = if extent.z > extent[axis] { 2 } else { axis };
    let key = |t: &Triangle| 3.0 * t.corner[axis] + t.edges[0][axis] + t.edges[1][axis];
    part.select_nth_unstable_by(count / 2, |a, b| key(a).total_cmp(&key(b)));
    let middle = start + count / 2;
    split(triangles, start, middle, nodes);
    nodes[this].start = nodes.len() as u32;
    nodes[this].count = 0;
    nodes[this].axis = axis;
    split(triangles, middle, end, nodes);
}

fn crosses(node: &Node, origin: Vec3, inverse: Vec3, limit: f32) -> bool {
    let (a, b) = (
        (node.low - origin) * inverse,
        (node.high - origin) * inverse,
    );
    let enter = a.min(b).max_element().max(0.0);
    let leave = a.max(b).min_element();
    enter <= leave * 1.000_01 && enter < limit
}

fn intersect(triangle: &Triangle, origin: Vec3, direction: Vec3) -> Option<(f32, Vec2)> {
    let [e1, e2] = triangle.edges;
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let offset = origin - triangle.corner;
    let u = offset.dot(p) / determinant;
    let q = offset.cross(e1);
    let v = direction.dot(q) / determinant;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then(|| (e2.dot(q) / determinant, Vec2::new(u, v)))
}

#[cfg(test)]
mod tests {
    use super::super::model::{EyePlacement, SceneMaterial, SceneMesh};
    use super::*;

    /// A unit sphere of 128 × 64 facets above the origin.
    fn ball() -> SceneMesh {
        let (sides, rings) = (128u32, 64u32);
        let lattice = (0..=rings).flat_map(|ring| (0..=sides).map(move |side| (ring, side)));
        let normals: Vec<[f32; 3]> = lattice
            .map(|(ring, side)| {
                let polar = PI * ring as f32 / rings as f32;
                let angle = 2.0 * PI * side as f32 / sides as f32;
                let (height, radius) = (-polar.cos(), polar.sin());
                [radius * angle.sin(), height, radius * angle.cos()]
            })
            .collect();
        let cells = (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side)));
        let indices = cells.flat_map(|(ring, side)| {
            let a = ring * (sides + 1) + side;
            let (b, c) = (a + 1, a + sides + 1);
            [a, b, c + 1, a, c + 1, c]
        });
        SceneMesh {
            name: "ball".into(),
            positions: normals.iter().map(|&[x, y, z]| [x, y + 1.0, z]).collect(),
            indices: indices.collect(),
            normals,
            ..Default::default()
        }
    }

    fn floor() -> SceneMesh {
        SceneMesh {
            name: "floor".into(),
            positions: [[-5.0, 5.0], [5.0, 5.0], [5.0, -5.0], [-5.0, -5.0]]
                .map(|[x, z]| [x, 0.0, z])
                .to_vec(),
            normals: vec![[0.0, 1.0, 0.0]; 4],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..Default::default()
        }
    }

    fn sphere_over_floor() -> SceneModel {
        SceneModel {
            meshes: vec![ball(), floor()],
            materials: vec![SceneMaterial {
                base_color: [1.0; 4],
                ..Default::default()
            }],
            ..Default::default()
        }
    }

    #[test]
    fn rays_meet_a_sphere_at_the_closed_form_distance() {
        let scene = sphere_over_floor();
        let tracer = Tracer::new(&scene);
        let origin = Vec3::new(0.0, 1.0, 4.0);
        for i in 0..500 {
            let target = Vec3::new(
                0.9 * (i as f32 * 0.7).sin(),
                1.0 + 0.6 * (i as f32 * 1.3).cos(),
                0.0,
            );
            let direction = (target - origin).normalize();
            let offset = origin - Vec3::Y;
            let b = offset.dot(direction);
            let root = b * b - offset.length_squared() + 1.0;
            // Near the rim the facets' sagitta (0.3 mm here) is divided by the grazing cosine.
            if root > 0.1 {
                let hit = tracer.cast(origin, direction, 0.0, 100.0).unwrap();
                assert_eq!(hit.mesh, 0);
                assert!((hit.distance_m - (-b - root.sqrt())).abs() < 5e-3);
            }
        }
        assert!(tracer.cast(origin, Vec3::Y, 0.0, 100.0).is_none());
        assert!(tracer.cast(origin, Vec3::NEG_Y, 0.0, 0.9).is_none());
    }

    #[test]
    fn a_white_floor_in_known_light_has_the_textbook_luminance() {
        let mut scene = sphere_over_floor();
        scene.meshes.remove(0);
        scene.lights = vec![
            SceneLight::Directional {
                direction: [0.0, -1.0, 0.0],
                color: [1.0; 3],
                illuminance_lux: 1000.0,
                shadows: true,
            },
            SceneLight::Ambient {
                color: [1.0; 3],
                brightness: 50.0,
            },
        ];
        scene.eye = EyePlacement {
            position_m: [0.0, 2.0, 0.0],
            forward: [0.0, -1.0, 0.0],
            up: [0.0, 0.0, -1.0],
            ..Default::default()
        };
        let exact = 1000.0 / std::f64::consts::PI + 50.0;
        let mean = Tracer::new(&scene).mean_luminance_cd_m2(8);
        assert!((mean / exact - 1.0).abs() < 1e-4, "{mean} {exact}");
        scene.lights = vec![SceneLight::Point {
            position: [0.0, 2.0, 0.0],
            color: [1.0; 3],
            intensity_lm: 1000.0,
            range: 50.0,
            shadows: true,
        }];
        let below = Tracer::new(&scene).radiance(Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_Y)[1];
        // The lit point is lifted by 2 mm off the surface, hence 0.3 %.
        let exact = 1000.0 / (4.0 * PI) / 4.0 / PI;
        assert!((below / exact - 1.0).abs() < 3e-3, "{below} {exact}");
    }
}
