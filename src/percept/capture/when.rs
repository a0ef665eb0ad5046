//! When the view of a camera is captured: once its size is known and all that it shows is built, and again
//! when the camera or anything before it has changed.

use super::super::field::SharpnessField;
use super::super::frame::PerceptFrame;
use super::super::sees_as::{SeesAs, Worn};
use super::super::view::{
    LaidOut, NEAR_M, Percept, QUIET_FRAMES, Sight, Stage, ViewOptions, is_shown,
};
use super::sight::{CameraLook, SceneChanges};
use crate::anatomy::EyeFinder;
use crate::frame::readiness::Readiness;
use crate::frame::{Panel, SimulationClock};
use crate::scene::photo_view::{Photograph, photo_images};
use bevy::camera::RenderTarget;
use bevy::camera::visibility::RenderLayers;
use bevy::mesh::MeshTag;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use std::sync::Arc;

/// Longer side of the picture that a camera draws before its first capture, pixels.
const REHEARSAL_SIDE: u32 = 32;
/// Largest side of the scene's picture that every device takes.
const LARGEST_TEXTURE: u32 = 8192;

/// The parts of a camera that a capture needs.
type Capturing<'a> = (
    &'a SeesAs,
    &'a mut Worn,
    &'a ViewOptions,
    CameraLook,
    &'a GlobalTransform,
    Option<&'a Panel>,
    Option<&'a Photograph>,
    Option<&'a RenderLayers>,
    Mut<'a, Projection>,
    &'a mut Percept,
    &'a mut Camera,
    &'a mut RenderTarget,
);

/// Asks for captures where size, sight or scene have changed, as soon as everything that they show is
/// built.
#[expect(
    clippy::too_many_arguments,
    reason = "a system's arguments are what it reads and makes"
)]
pub(in crate::percept) fn drive_captures(
    readiness: Res<Readiness>,
    changes: Res<SceneChanges>,
    clear: Option<Res<ClearColor>>,
    clock: Res<SimulationClock>,
    finder: EyeFinder,
    people: Query<&SharpnessField>,
    mut images: ResMut<Assets<Image>>,
    mut views: Query<Capturing>,
) {
    let is_recolored = clear.is_some_and(|clear| clear.is_changed());
    for (
        sees,
        mut worn,
        options,
        look,
        transform,
        panel,
        photo,
        layers,
        mut projection,
        mut percept,
        mut camera,
        mut target,
    ) in &mut views
    {
        let size = worn.size();
        let is_photo = photo.is_some();
        // What changes while nobody looks counts when somebody does. All are asked: each remembers.
        let scene_changed = !is_photo
            && (changes.touch(layers, || projection.compute_frustum(transform))
                | is_recolored
                | look.has_changed(&camera, &mut percept.look));
        let memory = finder
            .find(sees.0)
            .and_then(|(_, patient)| people.get(patient).ok());
        let drawing = match memory {
            Some(memory) if is_shown(options, panel) && size != UVec2::ZERO => {
                let percept = &mut *percept;
                let is_resized = lay_out(
                    percept,
                    photo.map(|photo| (photo, photo.photo.picture_at(clock.time_s))),
                    size,
                    options,
                    &readiness,
                    &mut images,
                    (&mut worn, &mut target),
                );
                let sight = sight_of(percept, transform, &projection);
                let taken_with = (options.threshold, options.exposure, memory.voxel_m);
                // Voxels of another size are another memory.
                percept.forget_voxels |= percept.taken_with.2 != taken_with.2;
                let mut has_changed =
                    is_resized || percept.is_outdated || taken_with != percept.taken_with;
                has_changed |= sight != percept.sight || scene_changed;
                percept.sight = sight;
                percept.taken_with = taken_with;
                // Until it has been asked for.
                percept.is_outdated = has_changed;
                if percept.is_new && percept.stage == Stage::Wanted {
                    percept.origin = percept.sight.pose.translation.into();
                }
                if (has_changed || percept.stage == Stage::Wanted) && !is_photo {
                    let (origin, known) = (percept.origin, &percept.known_movers);
                    let knows = |name| known.contains(&name);
                    percept.moved = changes.movers().seen_by(layers, origin, knows);
                }
                let quiet = readiness.quiet_frames() >= QUIET_FRAMES;
                let asked = percept.serial;
                let draws = drive(percept, has_changed, quiet) && !is_photo;
                if percept.serial != asked {
                    percept.is_rehearsal = draws && changes.has_morphs(layers);
                    if let Some(picture) = percept.full_picture.take() {
                        worn.draw_into(picture, percept.scale as f32, &mut target);
                        // Bevy asks for a target's size when this or the image changes, not for another target.
                        projection.set_changed();
                    }
                }
                draws
            }
            _ => {
                percept.is_outdated |= scene_changed;
                false
            }
        };
        if camera.is_active != drawing {
            camera.is_active = drawing;
        }
    }
}

/// Gives a view its size and its photograph; says whether it has another picture of the size that it had.
fn lay_out(
    percept: &mut Percept,
    photo: Option<(&Photograph, usize)>,
    size: UVec2,
    options: &ViewOptions,
    readiness: &Readiness,
    images: &mut Assets<Image>,
    (worn, target): (&mut Worn, &mut RenderTarget),
) -> bool {
    let scale = match photo {
        Some(_) => 1,
        None => supersampling(size, options),
    };
    let is_same_photo = match (photo, &percept.photo) {
        (Some((photo, picture)), Some(laid)) => {
            Arc::ptr_eq(&photo.photo, &laid.photo)
                && photo.taken_from == laid.taken_from
                && picture == laid.picture
        }
        (photo, laid) => photo.is_none() && laid.is_none(),
    };
    let is_resized = percept.size != size || percept.scale != scale;
    if !is_resized && is_same_photo {
        return false;
    }
    percept.size = size;
    percept.scale = scale;
    match photo {
        None => {
            percept.photo = None;
            // For its pipelines a small one of its shape will do.
            let small = (size * REHEARSAL_SIDE / size.max_element()).max(UVec2::ONE);
            worn.draw_into(images.add(picture_image(small)), 1.0, target);
            // The full one is there when it is drawn.
            percept.full_picture = Some(images.add(picture_image(size * scale)));
        }
        Some((photo, picture)) => {
            percept.full_picture = None;
            let (colour, vergence, smaller_deg) = photo_images(&photo.photo, picture, size);
            percept.photo = Some(LaidOut {
                photo: photo.photo.clone(),
                picture,
                taken_from: photo.taken_from,
                colour: images.add(colour),
                vergence: images.add(vergence),
                tan_half: (0.5 * smaller_deg.to_radians()).tan(),
            });
        }
    }
    // A new picture has to be made, and to be drawn into, before it is captured.
    if is_resized || photo.is_none() {
        percept.stage = Stage::Wanted;
        percept.waited = 0;
        readiness.restart();
    }
    !is_resized
}

/// From where and how wide a view looks now.
fn sight_of(percept: &Percept, transform: &GlobalTransform, projection: &Projection) -> Sight {
    let size = percept.size.as_vec2();
    let aspect = size.x / size.y;
    let half = match (&percept.photo, projection) {
        (Some(laid), _) => Vec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0)) * laid.tan_half,
        (None, Projection::Perspective(lens)) => {
            let up = (0.5 * lens.fov).tan();
            Vec2::new(up * aspect, up)
        }
        // An eye has no other projection; what such a camera draws is taken for one of 60°.
        (None, _) => {
            warn_once!("a camera that sees as an eye does must be perspective");
            let up = (0.5 * 60f32.to_radians()).tan();
            Vec2::new(up * aspect, up)
        }
    };
    let near_m = match projection {
        Projection::Perspective(lens) => lens.near,
        _ => NEAR_M,
    };
    Sight {
        pose: transform.to_isometry(),
        half,
        near_m,
    }
}

/// The next step of a view's capture; says whether its camera draws in this frame.
fn drive(percept: &mut Percept, has_changed: bool, quiet: bool) -> bool {
    match percept.stage {
        // The camera draws twice: once so that its pipelines are asked for, once for the capture.
        Stage::Wanted if quiet => percept.ask(),
        Stage::Wanted => percept.waited += 1,
        Stage::Asked if (has_changed || percept.is_unread) && percept.is_recorded() => {
            percept.ask()
        }
        Stage::Asked => percept.captured_half = percept.sight.half,
        Stage::Done if has_changed => {
            percept.is_unfinished = !quiet;
            percept.ask();
        }
        Stage::Done if percept.is_unfinished && quiet => {
            percept.is_unfinished = false;
            percept.ask();
        }
        Stage::Done => {}
    }
    match percept.stage {
        Stage::Wanted => percept.waited <= 2,
        // Until it is recorded: its pipelines may be late. The answer takes longer.
        Stage::Asked => !percept.is_recorded(),
        Stage::Done => false,
    }
}

/// A mesh that Bevy's morph targets shape.
type Morphed<'a> = (Entity, Option<&'a mut MeshTag>);

/// Makes Bevy take in again what it draws by its morph targets while a view is captured. Bevy 0.19 knows the
/// shape of a mesh only from the frame after it has come into sight on, and only of what changes then; a view's
/// camera would be gone by then, and draws once more for it.
pub(in crate::percept) fn activate_for_morphs(
    views: Query<&PerceptFrame>,
    mut meshes: Query<Morphed, With<MeshMorphWeights>>,
    mut commands: Commands,
) {
    if meshes.is_empty() || !views.iter().any(|view| view.capture.is_some()) {
        return;
    }
    for (mesh, tag) in &mut meshes {
        match tag {
            Some(mut tag) => tag.set_changed(),
            None => {
                commands.entity(mesh).insert(MeshTag::default());
            }
        }
    }
}

/// What was asked for, as far as the largest texture allows.
fn supersampling(size: UVec2, options: &ViewOptions) -> u32 {
    let most = LARGEST_TEXTURE / size.max_element().max(1);
    options.supersampling.clamp(1, most.max(1))
}

fn picture_image(size: UVec2) -> Image {
    let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba16Float, None);
    image.asset_usage = bevy::asset::RenderAssetUsages::RENDER_WORLD;
    image.data = None;
    // Its first picture has nothing to be copied from.
    image.copy_on_resize = false;
    image
}
