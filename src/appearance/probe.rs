//! What the world looks like from an eye's own place, so that its cornea mirrors it and its light falls on it.
//!
//! Enters: [`EyeProbe`] beside an [`super::EyeModel`]. Leaves: six pictures of the world, taken by cameras of our own from the globe's
//! centre and read back, as a map of what surrounds the eye. They are taken when something of it has changed, at most one set in
//! [`EVERY_FRAMES`] frames: six small pictures and some milliseconds of a processor. In between they cost nothing.

use super::images::f16_texels;
use super::model::{EyeLight, EyeModel, EyePart};
use super::surroundings::Surroundings;
use crate::frame::ledger::WorkLedger;
use crate::frame::readiness::Readiness;
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{Exposure, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::ecs::system::SystemParam;
use bevy::light::{AmbientLight, EnvironmentMapLight, GlobalAmbientLight, Skybox};
use bevy::math::{DQuat, DVec2, DVec3};
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use core::f32::consts::FRAC_PI_2;
use std::sync::Arc;

/// Fewest frames from one set of pictures to the next: a tenth of a second of most screens.
pub const EVERY_FRAMES: u32 = 6;
/// Movements of the eye that make its surroundings others: m, rad.
const MOVED_M: f32 = 0.01;
const TURNED_RAD: f32 = 0.02;
/// Brightest that is mirrored, cd/m²: as much as half floats hold. A sun is a lamp.
const MOST_CD_M2: f64 = 65_504.0;
/// Frames after which pictures that have not come back are given up: there is no device, or it is lost.
const PATIENCE_FRAMES: u32 = 240;
/// Pixels along a side are a multiple of this: rows of a picture are read back in whole blocks of 256 bytes.
const BLOCK: u32 = 32;

/// Lets an eye whose [`super::EyeLight`] is that of its world mirror and be lit by what stands around it there, and not by the lights and
/// the ambient light alone: by six small pictures from its own place, taken again only when something that is drawn there has changed.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component)]
#[require(Probed)]
pub struct EyeProbe {
    /// Pixels along a side of each of its six pictures, 32 to 256, in steps of 32.
    pub side: u32,
    /// What is nearer than this to the globe's centre is not seen, m of the eye's own: beyond the eye's parts, which end at 0.07.
    pub near_m: f32,
    /// A camera whose sky, environment map and ambient light the pictures have too.
    #[entities]
    pub like: Option<Entity>,
}

impl Default for EyeProbe {
    fn default() -> Self {
        Self {
            side: 64,
            near_m: 0.08,
            like: None,
        }
    }
}

impl EyeProbe {
    /// Pixels along a side, within their range.
    fn pixels(&self) -> u32 {
        self.side.clamp(BLOCK, 256).next_multiple_of(BLOCK)
    }
}

/// Where a set of pictures is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// There is none to come.
    #[default]
    Idle,
    /// Being drawn in this frame.
    Drawn,
    /// Being read back.
    Copied,
}

/// What a probe has found.
#[derive(Component, Default, Reflect)]
#[reflect(Component, from_reflect = false)]
pub struct Probed {
    #[reflect(ignore)]
    cameras: Vec<(Entity, Handle<Image>)>,
    #[reflect(ignore)]
    made_of: Option<EyeProbe>,
    #[reflect(ignore)]
    phase: Phase,
    /// From where the last set was taken.
    #[reflect(ignore)]
    from: Option<GlobalTransform>,
    #[reflect(ignore)]
    is_stale: bool,
    /// Whether all pipelines were there, and whether a set was drawn to ask for them.
    #[reflect(ignore)]
    settled: bool,
    #[reflect(ignore)]
    frames: u32,
    /// Counts its sets, so that no picture of one comes into another.
    #[reflect(ignore)]
    set: u32,
    #[reflect(ignore)]
    copies: Vec<Entity>,
    #[reflect(ignore)]
    faces: [Option<Vec<[f32; 3]>>; 6],
    #[reflect(ignore)]
    around: Option<Arc<Surroundings>>,
}

impl Probed {
    /// Takes its cameras and what is on its way away; what it has found stays.
    fn stop(&mut self, commands: &mut Commands) {
        let cameras = self.cameras.drain(..).map(|(camera, _)| camera);
        for entity in cameras.chain(self.copies.drain(..)) {
            commands.entity(entity).try_despawn();
        }
        *self = Self {
            set: self.set + 1,
            around: self.around.take(),
            ..default()
        };
    }

    /// What surrounds the eye, cd/m², without lamps; `None` until the first pictures have arrived.
    pub fn around(&self) -> Option<&Arc<Surroundings>> {
        self.around.as_ref()
    }
}

/// A camera of a probe.
#[derive(Component, Clone, Copy, Debug)]
pub struct ProbeCamera;

/// A picture that is on its way back.
#[derive(Component, Clone, Copy)]
pub struct Copying {
    model: Entity,
    face: usize,
    set: u32,
}

/// How the cameras are turned in the head: to both sides, up and down, to the back and ahead.
fn turned(face: usize) -> Quat {
    let (towards, up) = [
        (Vec3::X, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::Y, Vec3::Z),
        (Vec3::NEG_Y, Vec3::Z),
        (Vec3::Z, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Y),
    ][face];
    Transform::default().looking_to(towards, up).rotation
}

/// Radiances that the six pictures, row by row from the top, have in a unit direction of the head, which these turns bring before their
/// cameras.
fn radiance(faces: &[Vec<[f32; 3]>; 6], turns: &[DQuat; 6], side: usize, d: DVec3) -> DVec3 {
    // The one that looks there most directly.
    let axis = d.abs().max_position();
    let face = 2 * axis + usize::from(d[axis] < 0.0);
    let local = turns[face] * d;
    let at = DVec2::new(local.x, -local.y) / -local.z;
    let at =
        ((0.5 + 0.5 * at) * side as f64 - 0.5).clamp(DVec2::ZERO, DVec2::splat(side as f64 - 1.0));
    let texel = |x: usize, y: usize| {
        let [x, y] = [x, y].map(|k| k.min(side - 1));
        let [r, g, b] = faces[face][y * side + x];
        DVec3::new(r.into(), g.into(), b.into())
    };
    let (x, y) = (at.x as usize, at.y as usize);
    let part = at - at.floor();
    let row = |y: usize| texel(x, y).lerp(texel(x + 1, y), part.x);
    row(y).lerp(row(y + 1), part.y)
}

/// What they are of, as a map: values over the camera's exposure are cd/m².
fn surroundings(faces: &[Vec<[f32; 3]>; 6], side: usize) -> Surroundings {
    let turns = core::array::from_fn(|face| turned(face).inverse().as_dquat());
    let exposure = f64::from(Exposure::default().exposure());
    let around = |d: DVec3| {
        let value = radiance(faces, &turns, side, d) / exposure;
        // The map holds half floats.
        value.min(DVec3::splat(MOST_CD_M2))
    };
    let mut found = Surroundings::new(2 * side, around, |_| DVec3::ZERO, Vec::new());
    found.is_luminance = true;
    found
}

/// What of the world a picture of it shows, as it changes. The parts of eyes are left out: they are never still.
type Altered = (
    Or<(
        Changed<GlobalTransform>,
        Changed<InheritedVisibility>,
        Changed<RenderLayers>,
        Changed<Mesh3d>,
        Changed<MeshMaterial3d<StandardMaterial>>,
        Changed<PointLight>,
        Changed<DirectionalLight>,
        Changed<SpotLight>,
    )>,
    Or<(
        With<Mesh3d>,
        With<PointLight>,
        With<DirectionalLight>,
        With<SpotLight>,
    )>,
    Without<EyePart>,
);

/// Whether anything has changed that a picture of the world would show.
#[derive(SystemParam)]
pub struct WorldChanges<'w, 's> {
    altered: Query<'w, 's, (), Altered>,
    gone: RemovedComponents<'w, 's, Mesh3d>,
    dark: (
        RemovedComponents<'w, 's, PointLight>,
        RemovedComponents<'w, 's, DirectionalLight>,
        RemovedComponents<'w, 's, SpotLight>,
    ),
    materials: MessageReader<'w, 's, AssetEvent<StandardMaterial>>,
    images: MessageReader<'w, 's, AssetEvent<Image>>,
    meshes: MessageReader<'w, 's, AssetEvent<Mesh>>,
    ambient: Option<Res<'w, GlobalAmbientLight>>,
    sky: Option<Res<'w, ClearColor>>,
}

impl WorldChanges<'_, '_> {
    fn any(&mut self) -> bool {
        // All are read, so that none tells of it twice. Eyes change images and meshes of their own: of those files alone count.
        let told = [
            self.gone.read().count(),
            self.dark.0.read().count(),
            self.dark.1.read().count(),
            self.dark.2.read().count(),
            self.materials.read().count(),
            loaded(&mut self.images),
            loaded(&mut self.meshes),
        ];
        let changes = [
            !self.altered.is_empty(),
            told.iter().sum::<usize>() > 0,
            self.ambient
                .as_ref()
                .is_some_and(|light| light.is_changed()),
            self.sky.as_ref().is_some_and(|color| color.is_changed()),
        ];
        changes.contains(&true)
    }
}

/// How many of these say that a file has been loaded.
fn loaded<A: Asset>(events: &mut MessageReader<AssetEvent<A>>) -> usize {
    let is_loaded =
        |event: &&AssetEvent<A>| matches!(event, AssetEvent::LoadedWithDependencies { .. });
    events.read().filter(is_loaded).count()
}

/// A picture of the world to be drawn into and read back.
fn picture(side: u32) -> Image {
    let mut image = Image::new_target_texture(side, side, TextureFormat::Rgba16Float, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    image
}

/// An eye with a probe.
type Probing<'a> = (
    Entity,
    &'a EyeProbe,
    &'a EyeLight,
    &'a GlobalTransform,
    Option<&'a RenderLayers>,
    &'a mut Probed,
);

/// Has the pictures drawn and copied where something has changed.
pub fn take_probes(
    mut models: Query<Probing, With<EyeModel>>,
    mut changes: WorldChanges,
    mut cameras: Query<(&mut Camera, &mut Transform, &mut Projection), With<ProbeCamera>>,
    mut images: ResMut<Assets<Image>>,
    readiness: Res<Readiness>,
    ledger: Res<WorkLedger>,
    mut commands: Commands,
) {
    let has_changed = changes.any();
    // While a pipeline is missing a picture is drawn to ask for it, and another when it is there.
    let settled = readiness.quiet_frames() >= 3;
    for (model, probe, light, place, layers, mut probed) in &mut models {
        let is_read = matches!(light, EyeLight::World);
        if probed.made_of != Some(*probe) || !is_read {
            // Whatever a studio lights needs no world.
            if probed.made_of.is_some() {
                probed.stop(&mut commands);
            }
            if is_read {
                probed.cameras = spawn_cameras(probe, &mut images, &mut commands);
                probed.made_of = Some(*probe);
                (probed.is_stale, probed.frames) = (true, EVERY_FRAMES);
            }
            // They are there in the next frame.
            continue;
        }
        let moved = probed.from.is_some_and(|from| {
            from.translation().distance(place.translation()) > MOVED_M
                || from.rotation().angle_between(place.rotation()) > TURNED_RAD
        });
        if has_changed || moved {
            probed.is_stale = true;
        }
        probed.frames += 1;
        // What a set is the first to show may lack its pipelines: once they are there another is taken.
        probed.settled &= settled || probed.phase == Phase::Idle;
        match probed.phase {
            Phase::Idle => {
                let asks = probed.is_stale || (settled && !probed.settled);
                let may = settled || probed.from.is_none();
                if asks && may && probed.frames >= EVERY_FRAMES {
                    let near = probe.near_m.max(1e-3) * place.scale().abs().max_element();
                    for (face, (camera, _)) in probed.cameras.iter().enumerate() {
                        if let Ok((mut camera, mut transform, mut projection)) =
                            cameras.get_mut(*camera)
                        {
                            camera.is_active = true;
                            transform.translation = place.translation();
                            transform.rotation = place.rotation() * turned(face);
                            *projection = Projection::Perspective(PerspectiveProjection {
                                fov: FRAC_PI_2,
                                near,
                                far: 1e4,
                                ..default()
                            });
                        }
                        let mut camera = commands.entity(*camera);
                        camera.insert(layers.cloned().unwrap_or_default());
                        let camera = camera.id();
                        if let Some(like) = probe.like
                            && let Ok(mut other) = commands.get_entity(like)
                        {
                            other.clone_components::<(Skybox, EnvironmentMapLight, AmbientLight)>(
                                camera,
                            );
                        }
                    }
                    ledger.probe_pictures(6);
                    probed.phase = Phase::Drawn;
                    probed.from = Some(*place);
                    probed.set += 1;
                    (probed.is_stale, probed.settled, probed.frames) = (false, settled, 0);
                }
            }
            Phase::Drawn => {
                let set = probed.set;
                let mut copies = Vec::new();
                for (face, (camera, image)) in probed.cameras.iter().enumerate() {
                    if let Ok((mut camera, ..)) = cameras.get_mut(*camera) {
                        camera.is_active = false;
                    }
                    let copying = Copying { model, face, set };
                    let mut copy = commands.spawn((Readback::texture(image.clone()), copying));
                    copies.push(copy.observe(arrived).id());
                }
                probed.copies = copies;
                probed.phase = Phase::Copied;
            }
            Phase::Copied => {
                if probed.faces.iter().all(Option::is_some) {
                    let faces = core::mem::take(&mut probed.faces).map(Option::unwrap_or_default);
                    let side = probe.pixels() as usize;
                    probed.around = Some(Arc::new(surroundings(&faces, side)));
                    probed.phase = Phase::Idle;
                } else if probed.frames > PATIENCE_FRAMES {
                    probed.stop(&mut commands);
                }
            }
        }
    }
}

fn spawn_cameras(
    probe: &EyeProbe,
    images: &mut Assets<Image>,
    commands: &mut Commands,
) -> Vec<(Entity, Handle<Image>)> {
    let camera = |_| {
        let image = images.add(picture(probe.pixels()));
        let camera = commands.spawn((
            ProbeCamera,
            Camera3d::default(),
            Camera {
                order: -3,
                is_active: false,
                ..default()
            },
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            Exposure::default(),
            RenderTarget::Image(image.clone().into()),
        ));
        (camera.id(), image)
    };
    (0..6).map(camera).collect()
}

/// Takes in a picture.
fn arrived(
    copy: On<ReadbackComplete>,
    copying: Query<&Copying>,
    mut models: Query<&mut Probed>,
    mut commands: Commands,
) {
    let Ok(&Copying { model, face, set }) = copying.get(copy.entity) else {
        return;
    };
    commands.entity(copy.entity).try_despawn();
    let Ok(mut probed) = models.get_mut(model) else {
        return;
    };
    let texels = f16_texels(&copy.data);
    let side = probed.made_of.map_or(0, |probe| probe.pixels());
    if texels.len() == (side * side) as usize && probed.set == set {
        probed.copies.retain(|own| *own != copy.entity);
        probed.faces[face] = Some(texels);
    }
}

/// Takes the cameras of a probe away with it.
pub fn end_probe(removed: On<Remove, EyeProbe>, models: Query<&mut Probed>, commands: Commands) {
    end(removed.entity, models, commands);
}

/// And with its eye.
pub fn end_probed(removed: On<Remove, EyeModel>, models: Query<&mut Probed>, commands: Commands) {
    end(removed.entity, models, commands);
}

fn end(model: Entity, mut models: Query<&mut Probed>, mut commands: Commands) {
    if let Ok(mut probed) = models.get_mut(model) {
        probed.stop(&mut commands);
        probed.around = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures of a world whose radiance is its direction.
    fn pictures(side: usize) -> [Vec<[f32; 3]>; 6] {
        core::array::from_fn(|face| {
            let at = |i: usize| {
                let p = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
                let d =
                    turned(face) * Vec3::new(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, -1.0).normalize();
                (0.5 + 0.5 * d).to_array()
            };
            (0..side * side).map(at).collect()
        })
    }

    #[test]
    fn six_pictures_are_the_world_from_one_place() {
        let side = 64;
        let faces = pictures(side);
        let turns = core::array::from_fn(|face| turned(face).inverse().as_dquat());
        for i in 0..2000 {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 2000.0;
            let (sin, cos) = (f64::from(i) * 2.399_963).sin_cos();
            let d = (DVec2::new(cos, sin) * (1.0 - z * z).sqrt()).extend(z);
            let found = radiance(&faces, &turns, side, d);
            // Between texels along lines, and half of one at the edges of the faces.
            let off = (found - (0.5 + 0.5 * d)).abs().max_element();
            assert!(off < 0.009, "{d}: {found}");
        }
        // Turned by a degree and a half they are of another world.
        let other = turns.map(|turn| DQuat::from_rotation_y(0.026) * turn);
        let found = radiance(&faces, &other, side, DVec3::NEG_Z);
        assert!((found - DVec3::new(0.5, 0.5, 0.0)).abs().max_element() > 0.009);
    }

    #[test]
    fn its_light_is_that_of_the_world() {
        let found = surroundings(&pictures(64), 64);
        let exposure = f64::from(Exposure::default().exposure());
        for d in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, -0.8)] {
            // Of radiance (1 + d)/2 a surface gets (1/2 + n/3) π.
            let wanted = (0.5 + d / 3.0) / exposure;
            let ours = found.irradiance(d);
            assert!(
                ((ours - wanted) * exposure).abs().max_element() < 0.01,
                "{d}: {ours} {wanted}"
            );
        }
        assert!(found.is_luminance && found.lamps.is_empty());
    }
}
