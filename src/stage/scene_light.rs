//! The light of the scene at the place of the eye that looks at it.
//!
//! Enters: the scene, and where its head is. Leaves: what surrounds the shown eye, where that is lit by its
//! scene (rays from the eye into all directions, with the light that the picture of the scene has too), and the
//! luminance to which its pupil answers. Both are found again only where the head has moved.

use super::Stage;
use super::head::Head;
use crate::anatomy::Adaptation;
use crate::appearance::shading::surroundings::{surroundings_direction, surroundings_uv};
use crate::appearance::studio::face_exposure;
use crate::appearance::surroundings::Surroundings;
use crate::appearance::{EyeLight, EyeModel, EyeSurroundings, Lamp};
use crate::frame::SimulationClock;
use crate::optics::output::srgb_decode;
use crate::scene::catalog::LoadedScene;
use crate::scene::photo::{PhotoScene, WHITE_CD_M2};
use crate::scene::trace::{Tracer, Tree};
use bevy::math::{DVec2, DVec3, Vec3};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, ParallelSlice, TaskPool};
use std::sync::Arc;

/// Texels along a side of the map of a scene: 0.9° each, in a browser, which has one processor, 1.8°; and while the head moves.
const SIDE: usize = if cfg!(target_arch = "wasm32") {
    128
} else {
    256
};
const SIDE_MOVING: usize = 80;
/// Brighter than the mean by this factor, what stands in the map is a lamp.
const LAMP_CONTRAST: f64 = 6.0;
/// Parts of a lamp lie within this angle of its brightest, rad.
const LAMP_REACH: f64 = 0.5;
/// Lamps that are found in the map at most, and those that light the eye as lamps: each costs as much as the last.
const FOUND_LAMPS: usize = 2;
const KEPT_LAMPS: usize = 2;
/// Angular radius of the sun, rad.
const SUN_RAD: f32 = 0.004_65;
/// Head movements that make the surroundings others: m, and rad.
const MOVED_M: f32 = 0.25;
pub(super) const TURNED_RAD: f32 = 0.2;
/// One that makes the pupil's light another, m.
pub(super) const ADAPTED_M: f32 = 0.05;

/// Luminance of linear sRGB.
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Radiances on the map's grid.
struct Grid {
    side: usize,
    texels: Vec<DVec3>,
    is_lamp: Vec<bool>,
}

impl Grid {
    fn new(side: usize, radiance: impl Fn(DVec3) -> DVec3 + Sync) -> Self {
        let rows: Vec<usize> = (0..side).collect();
        let pool = ComputeTaskPool::get_or_init(TaskPool::default);
        let texels = rows.par_chunk_map(pool, side.div_ceil(16).max(1), |_, rows| {
            let mut texels = Vec::with_capacity(rows.len() * side);
            for row in rows {
                texels.extend((0..side).map(|column| {
                    let at = DVec2::new(column as f64, *row as f64) + 0.5;
                    let at = at / side as f64;
                    // Outside of the rim nothing is looked up.
                    if at.distance(DVec2::splat(0.5)) > 0.5 + 1.5 / side as f64 {
                        return DVec3::ZERO;
                    }
                    radiance(surroundings_direction(at))
                }));
            }
            texels
        });
        let texels: Vec<DVec3> = texels.into_iter().flatten().collect();
        Self {
            side,
            texels,
            is_lamp: vec![false; side * side],
        }
    }

    fn direction(&self, index: usize) -> Option<DVec3> {
        let at = DVec2::new((index % self.side) as f64, (index / self.side) as f64) + 0.5;
        let at = at / self.side as f64;
        (at.distance(DVec2::splat(0.5)) <= 0.5).then(|| surroundings_direction(at))
    }

    fn index(&self, d: DVec3) -> usize {
        let at = surroundings_uv(d) * self.side as f64;
        let last = (self.side - 1) as f64;
        let [x, y] = [at.x, at.y].map(|v| v.clamp(0.0, last) as usize);
        y * self.side + x
    }

    /// Solid angle of a texel.
    fn solid_angle(&self) -> f64 {
        16.0 / (self.side * self.side) as f64
    }

    /// Takes the brightest place and what is bright around it as a lamp, where there is one, with the texels that it is.
    fn take_lamp(&mut self, brighter_than: f64) -> Option<(Lamp, Vec<usize>)> {
        let brightest = (0..self.texels.len())
            .filter(|i| !self.is_lamp[*i] && self.direction(*i).is_some())
            .max_by(|a, b| luminance(self.texels[*a]).total_cmp(&luminance(self.texels[*b])))?;
        if luminance(self.texels[brightest]) <= brighter_than {
            return None;
        }
        let middle = self.direction(brightest)?;
        let (mut sum, mut towards, mut parts) = (DVec3::ZERO, DVec3::ZERO, Vec::new());
        for i in 0..self.texels.len() {
            let Some(d) = self.direction(i) else { continue };
            let own = self.texels[i];
            if d.dot(middle) > LAMP_REACH.cos() && luminance(own) > brighter_than {
                self.is_lamp[i] = true;
                sum += own;
                towards += d * luminance(own);
                parts.push(i);
            }
        }
        let direction = towards.normalize_or(middle);
        let solid_angle = parts.len() as f64 * self.solid_angle();
        let lamp = Lamp {
            direction: direction.as_vec3(),
            radius: (solid_angle / core::f64::consts::PI).sqrt().max(0.01) as f32,
            color: (sum * self.solid_angle() / core::f64::consts::PI).as_vec3(),
            // It stands in the map.
            hole: -1.0,
            vergence: 0.0,
        };
        Some((lamp, parts))
    }
}

/// What surrounds a head in a scene, under a photographer's exposure: `tree` is of that scene, if it is a model.
fn surroundings(
    scene: &LoadedScene,
    tree: Option<&Arc<Tree>>,
    head: &Transform,
    side: usize,
) -> Surroundings {
    let (grid, lamps) = match (scene, tree) {
        (LoadedScene::Model(model), Some(tree)) => {
            let tracer = Tracer::with(model, tree.clone());
            let radiance = |d: DVec3| {
                let ray = head.rotation * d.as_vec3();
                Vec3::from(tracer.radiance(head.translation, ray)).as_dvec3()
            };
            let back = head.rotation.inverse();
            let lamps = tracer.lights_at(head.translation);
            let lamps = lamps.map(|(towards, color, is_sun)| Lamp {
                direction: back * towards,
                radius: if is_sun { SUN_RAD } else { 0.02 },
                color,
                hole: 0.0,
                vergence: 0.0,
            });
            (Grid::new(side, radiance), lamps.collect())
        }
        (LoadedScene::Photo(photo), _) => (Grid::new(side, photo_around(photo)), Vec::new()),
        (LoadedScene::Model(_), None) => (Grid::new(1, |_| DVec3::ONE), Vec::new()),
    };
    lit_by(grid, lamps)
}

fn lit_by(mut grid: Grid, lamps: Vec<Lamp>) -> Surroundings {
    let seen: Vec<f64> = (0..grid.texels.len())
        .filter(|i| grid.direction(*i).is_some())
        .map(|i| luminance(grid.texels[i]))
        .collect();
    let mean = seen.iter().sum::<f64>() / seen.len().max(1) as f64;
    let mut lamps: Vec<(Lamp, Vec<usize>)> =
        lamps.into_iter().map(|lamp| (lamp, Vec::new())).collect();
    for _ in 0..FOUND_LAMPS {
        lamps.extend(grid.take_lamp(LAMP_CONTRAST * mean));
    }
    lamps.sort_by(|a, b| b.0.color.element_sum().total_cmp(&a.0.color.element_sum()));
    let rest = lamps.split_off(KEPT_LAMPS.min(lamps.len()));
    // What of the map is no lamp after all is a part of the rest, and so are weaker lights that stand in no map.
    for i in rest.iter().flat_map(|(_, parts)| parts) {
        grid.is_lamp[*i] = false;
    }
    let of = |d: DVec3, lamp: bool| {
        let index = grid.index(d);
        if grid.is_lamp[index] == lamp {
            grid.texels[index]
        } else {
            DVec3::ZERO
        }
    };
    let kept = lamps.into_iter().map(|(lamp, _)| lamp).collect();
    let mut found = Surroundings::new(grid.side, |d| of(d, false), |d| of(d, true), kept);
    for (lamp, _) in rest.iter().filter(|(_, parts)| parts.is_empty()) {
        found.spread(lamp.direction, lamp.color);
    }
    found.exposure = face_exposure(&found);
    found
}

/// A photograph before the eye, and its mean light all around.
fn photo_around(photo: &PhotoScene) -> impl Fn(DVec3) -> DVec3 + '_ {
    let up = (0.5 * f64::from(photo.vertical_fov_deg).to_radians()).tan();
    let half = DVec2::new(up * f64::from(photo.width) / f64::from(photo.height), up);
    let mean = DVec3::splat(photo.mean_luminance_cd_m2);
    move |d| {
        let at = d.truncate() / (-d.z).max(1e-6) / half;
        if d.z >= 0.0 || at.abs().max_element() >= 1.0 {
            return mean;
        }
        let place = (at * DVec2::new(0.5, -0.5) + 0.5)
            * DVec2::new(f64::from(photo.width), f64::from(photo.height));
        let index = (place.y as usize).min(photo.height as usize - 1) * photo.width as usize
            + (place.x as usize).min(photo.width as usize - 1);
        let channel = |k: usize| {
            srgb_decode(f64::from(photo.rgb16_srgb[3 * index + k]) / 65_535.0) * WHITE_CD_M2
        };
        DVec3::new(channel(0), channel(1), channel(2))
    }
}

/// Luminance of light that falls on an eye, over π: rays even in the flux of its front.
fn falling_on(tracer: &Tracer<'_>, head: &Transform) -> f64 {
    const RINGS: u32 = 8;
    const TURNS: u32 = 20;
    let mut sum = 0.0;
    for ring in 0..RINGS {
        let sine = ((f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
        let cosine = (1.0 - sine * sine).sqrt();
        for turn in 0..TURNS {
            let angle = f64::from(turn) * core::f64::consts::TAU / f64::from(TURNS)
                + f64::from(ring) * 2.399_963;
            let d = DVec3::new(sine * angle.cos(), sine * angle.sin(), -cosine);
            let ray = head.rotation * d.as_vec3();
            sum += luminance(Vec3::from(tracer.radiance(head.translation, ray)).as_dvec3());
        }
    }
    let around = sum / f64::from(RINGS * TURNS);
    let facing = head.rotation * Vec3::NEG_Z;
    let lamps = tracer.lights_at(head.translation);
    let lamps = lamps.map(|(towards, color, _)| {
        luminance(color.as_dvec3()) * f64::from(towards.dot(facing).max(0.0))
    });
    around + lamps.sum::<f64>()
}

/// What was found of the stage's scene, and where.
#[derive(Resource, Default)]
pub(super) struct FoundLight {
    scene: Option<Arc<LoadedScene>>,
    tree: Option<Arc<Tree>>,
    /// Where the pupil's light was found, and how that light is to what it was at the scene's own place.
    adapted_at: Option<Transform>,
    at_seat: f64,
    /// What the pupil was told last, cd/m².
    said: Option<f64>,
    /// Where the surroundings were found, how finely, and where the head was then and since.
    lit_at: Option<Transform>,
    lit_side: usize,
    seen_at: Option<Transform>,
}

impl FoundLight {
    /// Forgets what was of another scene.
    fn be_of(&mut self, scene: &Arc<LoadedScene>) {
        let is_same = self
            .scene
            .as_ref()
            .is_some_and(|own| Arc::ptr_eq(own, scene));
        if !is_same {
            *self = Self {
                scene: Some(scene.clone()),
                ..Self::default()
            };
        }
    }

    /// The tree of the stage's scene, if that is a model.
    pub(super) fn tree_of(&mut self, scene: &Arc<LoadedScene>) -> Option<Arc<Tree>> {
        self.be_of(scene);
        self.tree(scene)
    }

    fn tree(&mut self, scene: &LoadedScene) -> Option<Arc<Tree>> {
        let LoadedScene::Model(model) = scene else {
            return None;
        };
        let tree = self.tree.get_or_insert_with(|| Tracer::new(model).tree());
        Some(tree.clone())
    }
}

pub(super) fn has_moved(from: Option<&Transform>, to: &Transform, by_m: f32, by_rad: f32) -> bool {
    from.is_none_or(|from| {
        from.translation.distance(to.translation) > by_m
            || from.rotation.angle_between(to.rotation) > by_rad
    })
}

/// The pupil answers to the light where the head is: at the scene's own place to its mean luminance, elsewhere to as much
/// more or less as falls on the eye there; where pictures follow one another, to the one that is shown.
pub(super) fn adapt(
    stage: Res<Stage>,
    clock: Res<SimulationClock>,
    heads: Query<(&Head, &Transform)>,
    mut found: ResMut<FoundLight>,
    mut people: Query<&mut Adaptation>,
) {
    let Ok(mut adaptation) = people.get_mut(stage.patient) else {
        return;
    };
    found.be_of(&stage.scene);
    let luminance_cd_m2 = match &*stage.scene {
        LoadedScene::Photo(photo) if photo.course.is_some() => {
            photo.picture_luminance_cd_m2(photo.picture_at(clock.time_s))
        }
        LoadedScene::Photo(_) => return,
        LoadedScene::Model(model) => {
            let Ok((head, transform)) = heads.get(stage.view) else {
                return;
            };
            if *head == Head::default() {
                model.mean_luminance_cd_m2
            } else if has_moved(found.adapted_at.as_ref(), transform, ADAPTED_M, TURNED_RAD) {
                let Some(tree) = found.tree(&stage.scene) else {
                    return;
                };
                let tracer = Tracer::with(model, tree);
                if found.at_seat == 0.0 {
                    let seat = super::scene_view::seat(model);
                    found.at_seat = falling_on(&tracer, &seat).max(1e-6);
                }
                let here = falling_on(&tracer, transform);
                found.adapted_at = Some(*transform);
                model.mean_luminance_cd_m2 * here / found.at_seat
            } else {
                return;
            }
        }
    };
    // Said once: whoever says otherwise meanwhile has the last word.
    if found.said.replace(luminance_cd_m2) != Some(luminance_cd_m2) {
        adaptation.set_if_neq(Adaptation {
            luminance_cd_m2,
            is_measured: false,
        });
    }
}

/// Lights the shown eye by its scene, where that is asked for.
pub(super) fn light_by_scene(
    stage: Res<Stage>,
    heads: Query<&Transform, With<Head>>,
    mut models: Query<(&EyeLight, Option<&mut EyeSurroundings>, &Visibility), With<EyeModel>>,
    mut found: ResMut<FoundLight>,
    mut commands: Commands,
) {
    let Ok((light, own, visibility)) = models.get_mut(stage.model) else {
        return;
    };
    if *light != EyeLight::Surroundings || *visibility == Visibility::Hidden {
        return;
    }
    let Ok(head) = heads.get(stage.view) else {
        return;
    };
    found.be_of(&stage.scene);
    // A photograph goes with its head.
    let is_model = matches!(&*stage.scene, LoadedScene::Model(_));
    let is_new = own.is_none() || found.lit_at.is_none();
    let rests = found.seen_at.replace(*head) == Some(*head);
    let is_far = is_model && has_moved(found.lit_at.as_ref(), head, MOVED_M, TURNED_RAD);
    let is_coarse = found.lit_side < SIDE || (is_model && found.lit_at != Some(*head));
    let side = if is_new || (rests && is_coarse) {
        SIDE
    } else if is_far {
        SIDE_MOVING
    } else {
        return;
    };
    let tree = found.tree(&stage.scene);
    found.lit_at = Some(*head);
    found.lit_side = side;
    let around = surroundings(&stage.scene, tree.as_ref(), head, side);
    let around = EyeSurroundings(Arc::new(around));
    match own {
        Some(mut own) => *own = around,
        None => {
            commands.entity(stage.model).insert(around);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::catalog;

    fn room() -> LoadedScene {
        LoadedScene::Model(Box::new(catalog::BuiltIn::Room.build().expect("built in")))
    }

    #[test]
    fn the_map_of_a_room_is_what_is_seen_there() {
        let scene = room();
        let LoadedScene::Model(model) = &scene else {
            panic!("a model")
        };
        let tracer = Tracer::new(model);
        let head = crate::stage::scene_view::seat(model);
        let around = surroundings(&scene, Some(&tracer.tree()), &head, SIDE);
        // The mean over what the panel's camera sees, from the map and by rays.
        let (mut mapped, mut traced) = (DVec3::ZERO, DVec3::ZERO);
        let (width, _, texels) = &around.levels[0];
        for i in 0..40 {
            for j in 0..40 {
                let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) / 20.0 - 1.0);
                let d = DVec3::new(0.4 * x, 0.4 * y, -1.0).normalize();
                let at = surroundings_uv(d) * f64::from(*width);
                let texel = texels[at.y as usize * *width as usize + at.x as usize];
                mapped += DVec3::new(texel[0].into(), texel[1].into(), texel[2].into());
                let ray = head.rotation * d.as_vec3();
                traced += Vec3::from(tracer.radiance(head.translation, ray)).as_dvec3();
            }
        }
        for channel in 0..3 {
            let ratio = mapped[channel] / traced[channel];
            assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
        }
        // The light on a face is what falls on it, lamps and rest together.
        let face = luminance(around.irradiance(DVec3::NEG_Z));
        let exact = falling_on(&tracer, &head);
        assert!((face / exact - 1.0).abs() < 0.06, "{face} {exact}");
    }

    #[test]
    fn a_bright_place_is_a_lamp_and_its_light_counts_once() {
        let bright = DVec3::new(0.6, 0.3, -0.74).normalize();
        let radiance = |d: DVec3| DVec3::splat(if d.dot(bright) > 0.98 { 400.0 } else { 10.0 });
        let found = lit_by(Grid::new(128, radiance), Vec::new());
        assert_eq!(found.lamps.len(), 1);
        let lamp = found.lamps[0];
        assert!(lamp.direction.as_dvec3().dot(bright) > 0.999 && lamp.hole < 0.0);
        // A cap of cosine 0.98: π (1 − 0.98²) L/π on a plane across it.
        let cap = 400.0 * (1.0 - 0.98 * 0.98);
        let n = bright;
        assert!(
            (found.irradiance(n).x / (cap + 10.0 * (1.0 - (1.0 - 0.98 * 0.98))) - 1.0).abs() < 0.02
        );
        let even = lit_by(Grid::new(64, |_| DVec3::splat(50.0)), Vec::new());
        assert!(even.lamps.is_empty());
        let ratio = even.irradiance(DVec3::Y).y / 50.0;
        // The map ends within a texel of straight behind.
        assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
    }
}
