//! Ambient occlusion of the built-in scenes, baked into their vertex colours.

use glam::Vec3;
use ocularium::scene::model::SceneModel;
use ocularium::scene::trace::Tracer;
use std::f32::consts::TAU;

/// Multiplies each vertex colour of the meshes that `wanted` selects by its openness (with a
/// floor, as light bounces), using the scene's own triangles as occluders.
pub(super) fn bake_ambient_occlusion(
    scene: &mut SceneModel,
    reach: f32,
    rays: u32,
    wanted: impl Fn(&str) -> bool,
) {
    const FLOOR: f32 = 0.25;
    let tracer = Tracer::new(scene);
    let baked: Vec<Option<Vec<f32>>> = scene
        .meshes
        .iter()
        .map(|mesh| {
            wanted(&mesh.name).then(|| {
                let vertices = mesh.positions.iter().zip(&mesh.normals);
                vertices
                    .map(|(&p, &n)| openness(&tracer, p.into(), n.into(), reach, rays))
                    .collect()
            })
        })
        .collect();
    for (mesh, openness) in scene.meshes.iter_mut().zip(baked) {
        let Some(openness) = openness else { continue };
        let colors = mesh
            .colors
            .get_or_insert_with(|| vec![[1.0; 4]; mesh.positions.len()]);
        for (color, open) in colors.iter_mut().zip(openness) {
            let factor = FLOOR + (1.0 - FLOOR) * open;
            color[..3].iter_mut().for_each(|channel| *channel *= factor);
        }
    }
}

/// Openness 0–1 of a surface point: the cosine-weighted part of the hemisphere that is free
/// within `reach` metres, with occluders fading out towards `reach`.
fn openness(tracer: &Tracer, point: Vec3, normal: Vec3, reach: f32, rays: u32) -> f32 {
    let (side, other) = normal.any_orthonormal_pair();
    let origin = point + normal * 1e-3;
    let mut open = 0.0;
    for ray in 0..rays {
        // The same cosine-weighted spiral at every vertex: errors are smooth, not noisy.
        let t = (ray as f32 + 0.5) / rays as f32;
        let angle = TAU * 0.618_034 * ray as f32;
        let direction =
            (side * angle.cos() + other * angle.sin()) * t.sqrt() + normal * (1.0 - t).sqrt();
        let near = tracer.cast(origin, direction, 1e-4, reach);
        open += near.map_or(1.0, |hit| (hit.distance_m / reach).powi(2));
    }
    open / rays.max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::super::shapes::Shape;
    use super::*;
    use ocularium::scene::model::SceneMaterial;

    #[test]
    fn openness_of_a_floor_under_a_sphere_falls_to_the_form_factor() {
        let ball = Shape::ellipsoid(Vec3::ONE, 128).at(0.0, 1.0, 0.0);
        let floor = Shape::sheet(
            Vec3::new(-5.0, 0.0, 5.0),
            Vec3::X * 10.0,
            Vec3::NEG_Z * 10.0,
            1.0,
        );
        let scene = SceneModel {
            meshes: vec![ball.mesh("ball", 0), floor.mesh("floor", 0)],
            materials: vec![SceneMaterial::default()],
            ..Default::default()
        };
        let tracer = Tracer::new(&scene);
        // A unit sphere seen from its contact plane at horizontal distance 2: the form factor of a
        // sphere is r² h / d³ while it is wholly above the horizon, which it just is.
        let exact = 1.0 - 1.0 / 5.0f32.powf(1.5);
        let open = openness(&tracer, Vec3::new(2.0, 0.0, 0.0), Vec3::Y, 1e3, 4096);
        assert!((open - exact).abs() < 0.01, "{open} {exact}");
    }
}
