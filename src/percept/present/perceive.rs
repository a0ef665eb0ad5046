//! What each frame of a view shows: its numbers, and what the passes are to do, if anything.

use super::super::field::SharpnessField;
use super::super::frame::{CaptureRequest, CaptureSource, FieldMap, PerceptFrame};
use super::super::gpu_data::{
    FORGET, MediaUniform, PerceptUniform, PhotoUniform, default_voxel_angle_rad, pixels_per_radian,
};
use super::super::sees_as::{SeesAs, Worn};
use super::super::view::{LaidOut, Percept, QUIET_FRAMES, Stage, ViewOptions, is_shown};
use crate::anatomy::{
    Accommodation, Cornea, Effective, Eye, EyeFinder, Eyelids, Gaze, Iris, Lids, OcularMedia,
    Pupil, Refraction, VisualField,
};
use crate::appearance::lid_edges::lid_edges;
use crate::frame::readiness::Readiness;
use crate::frame::{Panel, SimulationClock};
use crate::motion::GazeController;
use crate::optics::glare::{Veil, VeilSource};
use crate::scene::photo_view::STEP_SHARE;
use bevy::prelude::*;
use std::sync::Arc;

/// Texels of the visual-field map along a side, and half the angle it covers.
const FIELD_SIDE: u32 = 64;
const FIELD_HALF_DEG: f32 = 40.0;

/// What is shown where nothing is seen any more: people with field loss report blurred and missing parts,
/// not black ones (Crabb et al. 2013, who do not measure how blurred: these three are choices). Blur,
/// share of the light and share of the colour that are gone.
const LOSS_BLUR_DEG: f32 = 1.6;
const LOSS_DARKENING: f32 = 0.28;
const LOSS_DESATURATION: f32 = 0.5;
/// How late a field that is lost goes dark: the power of the share of it that is. A choice: with half of the
/// field 6 % of what filling-in leaves is gone, with all of it everything.
const LOSS_BLINDNESS_POWER: i32 = 4;

impl Percept {
    /// What these media do to light through an entrance pupil of this diameter (mm). How it is spread is worked
    /// out where the picture's size or the pigment has changed, as is its colour where the media have.
    fn media_uniform(
        &mut self,
        media: &OcularMedia,
        entrance_mm: f64,
        uniform: &PerceptUniform,
    ) -> MediaUniform {
        let pigment = media.pigment;
        let of = (pigment.to_bits(), uniform.size, uniform.pixels_per_radian);
        let mut found = match &self.spread {
            Some((known, spread)) if *known == of => *spread,
            _ => {
                let spread = spread_over(pigment, uniform);
                self.spread = Some((of, spread));
                spread
            }
        };
        found.transmittance = match &self.colour {
            Some((density, colour)) if *density == media.nuclear_density => *colour,
            _ => {
                let colour = media.transmittance().to_array();
                self.colour = Some((media.nuclear_density, colour));
                colour
            }
        };
        let straylight = media.straylight_through(entrance_mm);
        found.scattered = Veil::new(straylight, pigment).scattered() as f32;
        found
    }
}

/// What of an eye decides what it sees.
type SeeingEye<'a> = (
    &'a Eye,
    &'a Gaze,
    &'a Pupil,
    &'a Accommodation,
    &'a Effective<Refraction>,
    &'a Cornea,
    &'a Effective<Iris>,
    &'a Effective<Lids>,
    Option<Ref<'a, VisualField>>,
    Option<&'a OcularMedia>,
);

/// What of a person decides what her eyes see.
type Seer<'a> = (&'a Eyelids, &'a SharpnessField, &'a GazeController);

/// The parts of a camera that its frame is made from.
type Framing<'a> = (
    &'a SeesAs,
    &'a Worn,
    Option<&'a Panel>,
    &'a ViewOptions,
    &'a mut Percept,
    &'a mut PerceptFrame,
);

/// The frame of every view: what the passes are to do, if anything.
pub(in crate::percept) fn perceive(
    clock: Res<SimulationClock>,
    readiness: Res<Readiness>,
    finder: EyeFinder,
    eyes: Query<SeeingEye>,
    people: Query<Seer>,
    mut views: Query<Framing>,
) {
    let quiet = readiness.quiet_frames() >= QUIET_FRAMES;
    for (sees, worn, panel, options, mut percept, mut frame) in &mut views {
        let Some(target) = worn.image() else {
            *frame = PerceptFrame::default();
            continue;
        };
        let found = finder
            .find(sees.0)
            .and_then(|(eye, patient)| Some((eyes.get(eye).ok()?, people.get(patient).ok()?)));
        let into = Some((target.clone(), worn.size(), found.is_none()));
        if percept.drawn_into != into {
            percept.drawn_into = into;
            percept.show_anew();
        }
        let visible = is_shown(options, panel) && worn.size() != UVec2::ZERO;
        let Some((eye, person)) = found else {
            match finder.find(sees.0) {
                Some((eye, _)) if !eyes.contains(eye) => warn_once!(
                    "somebody is seen through who is not whole: an eye needs a Cornea and an Iris, as a patient file gives them"
                ),
                Some(_) => warn_once!(
                    "somebody is seen through who is not whole: a person needs Eyelids, a SharpnessField and a GazeController, which a Patient brings with it"
                ),
                None => {}
            }
            // Who sees again sees anew.
            percept.begin_scene();
            *frame = PerceptFrame {
                blank: visible && percept.shown.is_none(),
                target: target.clone(),
                ..PerceptFrame::default()
            };
            percept.shown = visible.then(Default::default);
            continue;
        };
        let shows = Shows {
            visible,
            size: worn.size(),
            moved: clock.moved,
            quiet,
        };
        *frame = frame_of(&mut percept, &shows, options, eye, person, target);
    }
}

/// What of panel and clock decides a frame.
struct Shows {
    visible: bool,
    size: UVec2,
    moved: bool,
    quiet: bool,
}

fn frame_of(
    percept: &mut Percept,
    shows: &Shows,
    options: &ViewOptions,
    (eye, gaze, pupil, accommodation, refraction, cornea, iris, own_lids, field, media): <SeeingEye<'_> as bevy::ecs::query::QueryData>::Item<'_, '_>,
    (lids, memory, controller): <Seer<'_> as bevy::ecs::query::QueryData>::Item<'_, '_>,
    target: &Handle<Image>,
) -> PerceptFrame {
    if percept.lifetime != memory.lifetime() {
        percept.lifetime = memory.lifetime();
        percept.forget = true;
        percept.show_anew();
    }
    update_field_map(percept, field.as_ref());
    let size = percept.captured.size;
    // Until a panel of another size has its own capture, it shows the old one.
    let stands_in = percept.stage == Stage::Wanted
        && percept.captured.serial == percept.serial
        && size != UVec2::ZERO
        && size != shows.size
        && !percept.is_new;
    // What has changed but in size is captured and shown in the same frame.
    let follows = percept.stage == Stage::Asked && size == shows.size && !percept.is_new;
    let (drawn, half) = if stands_in {
        (size, percept.captured_half)
    } else {
        (shows.size, percept.sight.half)
    };
    let mut uniform = static_uniform(percept, drawn, half, options);
    uniform.target_size = shows.size.as_vec2().to_array();
    uniform.fixation = gaze.direction().as_vec3().to_array();
    uniform.focus_vergence_d = accommodation.response_d as f32;
    let error = refraction.0.power_vector();
    uniform.refraction_d = error.m_d as f32;
    // The eye's top leans to the patient's right by its torsion.
    let seen = error.in_view().turned(-gaze.torsion_rad);
    [uniform.j0_d, uniform.j45_d] = [seen.j0_d as f32, seen.j45_d as f32];
    let entrance_mm = pupil.diameter_mm * cornea.pupil_magnification(iris.0.depth_mm);
    uniform.pupil_m = (entrance_mm * 1e-3) as f32;
    let own_lids = &own_lids.0;
    let open = (lids.aperture * own_lids.opening, own_lids.droop);
    let edges = lid_edges(eye, cornea, iris.0.depth_mm, gaze, open);
    uniform.upper_lid_mm = edges.upper.height_mm as f32;
    uniform.upper_lid_ahead_mm = edges.upper.ahead_mm as f32;
    uniform.lower_lid_mm = edges.lower.height_mm as f32;
    uniform.lower_lid_ahead_mm = edges.lower.ahead_mm as f32;
    uniform.epoch = u32::from(memory.clock().epoch());
    uniform.starve_steps = memory.clock().starve_steps();
    uniform.rebase_steps = memory.rebase_steps();
    uniform.coc_cap_rad = memory.blur_cap_rad as f32;
    uniform.voxel_size_m = memory.voxel_m as f32;
    if options.marker && !stands_in {
        place_marker(&mut uniform, gaze, shows.size);
    }
    if let Some(field) = field.filter(|field| !field.is_whole()) {
        let mean_seen = percept.field.as_ref().map_or(1.0, |map| map.mean_seen);
        loss_numbers(&mut uniform, &field, mean_seen);
    }

    let visible = shows.visible;
    if uniform.rebase_steps != FORGET && !(visible && percept.stage == Stage::Done) {
        // Nobody will shift the old keys now, and unshifted they would read as perfectly sharp.
        percept.forget = true;
    }
    if percept.forget {
        uniform.rebase_steps = FORGET;
    }
    let captured = percept.stage == Stage::Done && size == shows.size;
    let is_asked = visible && percept.stage == Stage::Asked && !percept.is_recorded();
    let is_asked = is_asked && !std::mem::take(&mut percept.is_rehearsal);
    let capture = is_asked.then(|| CaptureRequest {
        serial: percept.serial,
        source: match &percept.photo {
            Some(laid) => CaptureSource::Photo {
                colour: laid.colour.clone(),
                vergence: laid.vergence.clone(),
                numbers: photo_uniform(laid, percept.sight.pose),
            },
            None => CaptureSource::Scene,
        },
        forget: percept.asked.forget,
        moved: percept.asked.moved.clone(),
    });
    if !shows.quiet {
        // A pass whose pipeline is not built yet is skipped, so what was asked for may not be shown.
        percept.shown = None;
    }
    let first = percept.shown.is_none() && !percept.has_looked;
    // During a saccade vision is suppressed, and behind closed lids there is none. A new view is looked
    // at once all the same, or its voxels that an older view left unseen would stand between those that
    // it saw.
    let seeing = edges.leave_open(0.5 * entrance_mm) && (!controller.state().in_saccade || first);
    let media = media
        .filter(|media| !media.is_clear())
        .map(|media| percept.media_uniform(media, entrance_mm, &uniform));
    let changed = percept.shown != Some((uniform, media)) || capture.is_some();
    let frame = PerceptFrame {
        visible,
        update: visible
            && (captured || follows)
            && (shows.moved || first || capture.is_some())
            && seeing,
        present: visible && (captured || stands_in || follows) && (changed || percept.forget),
        forget: (captured || follows) && percept.forget,
        uniform,
        capture,
        field_loss: percept.field.clone(),
        media,
        blank: false,
        target: target.clone(),
        returned: percept.returned.clone(),
    };
    // While pipelines are built what is asked for may be skipped, and is asked for again.
    percept.has_looked |= frame.update && shows.quiet;
    if frame.present {
        percept.shown = Some((uniform, media));
        // A view that only stands in for another has forgotten nothing yet.
        percept.forget &= !frame.forget;
    }
    frame
}

fn static_uniform(
    percept: &Percept,
    size: UVec2,
    half: Vec2,
    options: &ViewOptions,
) -> PerceptUniform {
    let pose = &percept.sight.pose;
    let pixels = pixels_per_radian(size.x, half.x);
    let photo = percept.photo.is_some();
    // A picture of a scene holds what the camera's exposure leaves; a photograph is shown as it is.
    let exposure = if photo { 1.0 } else { options.exposure };
    let eye = Vec3::from(pose.translation) - percept.origin;
    PerceptUniform {
        right: (pose.rotation * Vec3::X).to_array(),
        tan_half_fov_x: half.x,
        up: (pose.rotation * Vec3::Y).to_array(),
        tan_half_fov_y: half.y,
        back: (pose.rotation * Vec3::Z).to_array(),
        near_m: percept.sight.near_m,
        eye_m: eye.to_array(),
        size: size.to_array(),
        supersampling: percept.scale,
        fast_threshold: u32::from(options.threshold),
        pixels_per_radian: pixels,
        voxel_angle_rad: default_voxel_angle_rad(pixels),
        exposure,
        luma_exposure: exposure,
        target_size: size.as_vec2().to_array(),
        field_half_width_rad: FIELD_HALF_DEG.to_radians(),
        display_referred: u32::from(photo),
        ..PerceptUniform::default()
    }
}

fn place_marker(uniform: &mut PerceptUniform, gaze: &Gaze, size: UVec2) {
    let [x, y, z] = gaze.direction().as_vec3().to_array();
    if z < -0.05 {
        let u = x / -z / uniform.tan_half_fov_x;
        let v = y / -z / uniform.tan_half_fov_y;
        uniform.marker = [
            (0.5 + 0.5 * u) * size.x as f32,
            (0.5 - 0.5 * v) * size.y as f32,
        ];
        uniform.marker_radius_px = (size.min_element() as f32 * 0.022).max(5.0);
    }
}

/// Where a view with this pose is in the frame of its photograph.
fn photo_uniform(laid: &LaidOut, pose: Isometry3d) -> PhotoUniform {
    let own = laid.taken_from.inverse() * pose;
    let axis = |axis: Vec3| (own.rotation * axis).to_array();
    // Poses that come down a hierarchy are rounded.
    let is_at_rest = own.translation.length() < 1e-6 && own.rotation.xyz().length() < 1e-6;
    // The shader's farthest.
    let flat_m = laid.photo.depth_m.constant_m().unwrap_or(0.0).min(1e9);
    PhotoUniform {
        right: axis(Vec3::X),
        up: axis(Vec3::Y),
        back: axis(Vec3::Z),
        eye_m: Vec3::from(own.translation).to_array(),
        has_moved: u32::from(!is_at_rest),
        flat_m,
        step_share: STEP_SHARE,
        ..PhotoUniform::default()
    }
}

/// How media with this pigment spread light over a view with these numbers.
fn spread_over(pigment: f64, uniform: &PerceptUniform) -> MediaUniform {
    let scale = uniform.pixels_per_radian.into();
    let source = VeilSource::new(scale, uniform.size);
    // How much light it is makes no difference to where it goes.
    let kernel = Veil::new(1.0, pigment).kernel(scale, uniform.size);
    MediaUniform {
        weights: std::array::from_fn(|row| {
            std::array::from_fn(|column| kernel.weights[4 * row + column] as f32)
        }),
        near: kernel.near as f32,
        source_size: source.size,
        texels_per_radian: source.texels_per_radian as f32,
        last_level: source.last_level() as u32,
        ..MediaUniform::default()
    }
}

/// What a lost field adds beyond what is not seen (Nießner 2013, section 3: the penalty).
fn loss_numbers(uniform: &mut PerceptUniform, field: &VisualField, mean_seen: f32) {
    // The healthy slope is one minute of arc in E2; the uniform adds what exceeds it.
    let slope = uniform.neural_floor_rad / uniform.eccentricity_e2_rad;
    uniform.eccentricity_penalty = (field.eccentricity_factor() as f32 - 1.0).max(0.0) * slope;
    uniform.loss_blur_rad = LOSS_BLUR_DEG.to_radians();
    // What is lost is filled in from what is seen; where hardly anything is, it is dark.
    let blindness = (1.0 - mean_seen).powi(LOSS_BLINDNESS_POWER);
    uniform.loss_darkening = LOSS_DARKENING + (1.0 - LOSS_DARKENING) * blindness;
    uniform.loss_desaturation = LOSS_DESATURATION;
}

fn update_field_map(percept: &mut Percept, field: Option<&Ref<VisualField>>) {
    let Some(field) = field.filter(|field| !field.is_whole()) else {
        if percept.field.take().is_some() {
            percept.show_anew();
        }
        return;
    };
    if percept.field.as_ref().is_some_and(|map| *map.of == **field) {
        return;
    }
    let seen = field_texels(field);
    percept.show_anew();
    percept.field = Some(FieldMap {
        of: Arc::new((**field).clone()),
        side: FIELD_SIDE,
        mean_seen: seen.iter().sum::<f32>() / seen.len() as f32,
        seen: Arc::new(seen),
    });
}

fn field_texels(field: &VisualField) -> Vec<f32> {
    let angle = |i: u32| {
        let share = (f64::from(i) + 0.5) / f64::from(FIELD_SIDE) * 2.0 - 1.0;
        (share * f64::from(FIELD_HALF_DEG)).to_radians()
    };
    (0..FIELD_SIDE)
        .flat_map(|row| {
            (0..FIELD_SIDE).map(move |column| field.seen(angle(column), -angle(row)) as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_map_has_the_highest_row_first_and_left_first() {
        let field = crate::conditions::glaucoma::glaucoma_field(
            crate::conditions::GlaucomaStage::Moderate,
            crate::anatomy::Laterality::OD,
            60.0,
        );
        let texels = field_texels(&field);
        let at = |column: usize, row: usize| texels[row * FIELD_SIDE as usize + column];
        let degrees = |i: usize| (i as f64 + 0.5) / 64.0 * 80.0 - 40.0;
        // The texel of (+10.6°, +15.6°).
        let expected = field.seen(degrees(40).to_radians(), (-degrees(19)).to_radians()) as f32;
        assert_eq!(at(40, 19), expected);
        assert!(texels.iter().all(|&seen| (0.0..=1.0).contains(&seen)));
        assert!(texels.iter().any(|&seen| seen < 0.5) && texels.iter().any(|&seen| seen > 0.9));
    }
}
