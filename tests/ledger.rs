//! What is hidden, paused or absent costs nothing: proved by the ledger of work.

use crate::stage::{look, open, patient, session, settle, turn};
use bevy::asset::AssetEvent;
use bevy::ecs::message::Messages;
use bevy::math::UVec2;
use bevy::render::render_resource::{PipelineCache, PipelineDescriptor};
use bevy::shader::ShaderDefVal;
use ocularium::appearance::GlobeMaterial;
use ocularium::frame::ledger::Work;
use ocularium::lab::headless::{Headless, Which};
use ocularium::motion::MotionCommand;
use ocularium::percept::gpu_data::PerceptUniform;
use ocularium::scene::catalog::LoadedScene;
use ocularium::scene::room::room_scaled;
use ocularium::stage::SessionCommand;
use std::sync::Arc;

const STEP_S: f64 = 1.0 / 60.0;
const FRAMES: u64 = 8;
/// Bytes of one vertex of lids and lashes.
const VERTEX_BYTES: u64 = 48;
/// What a frame of the eye may upload besides: its uniforms and the table of light on the iris.
const EYE_BYTES: u64 = 16 << 10;

/// What an eye may have that a healthy one has not, as the shaders are told.
const EFFECTS: [&str; 3] = ["FIELD_LOSS", "MEDIA", "ASTIGMATISM"];

/// A running app and its time.
struct Run {
    headless: Headless,
    time_s: f64,
}

impl Run {
    /// Eight frames with a blink in them, so that lids, view and field all have something to do.
    fn play(&mut self) -> Work {
        let before = self.headless.work();
        self.headless.world().write_message(MotionCommand::Blink);
        for _ in 0..FRAMES {
            self.time_s += STEP_S;
            self.headless.go_to(self.time_s);
        }
        let work = self.headless.work().since(before);
        // The blink ends before the next one is asked for.
        self.time_s += 0.5;
        self.headless.go_to(self.time_s);
        work
    }

    fn show(&mut self, eye: bool, view: bool) {
        self.headless.show([eye, view]);
    }

    fn resize(&mut self, which: Which, size: UVec2) {
        assert!(self.headless.resize(which, size), "the size is another one");
    }

    /// The view's pipelines by the names of their entry points, each with what it is told of the eye.
    fn forms(&mut self) -> Vec<(String, Vec<String>)> {
        let cache = self.headless.render_world().resource::<PipelineCache>();
        let told = |defs: &[ShaderDefVal]| -> Vec<String> {
            let told = defs.iter().filter_map(|def| match def {
                ShaderDefVal::Bool(name, true) => Some(name.clone()),
                _ => None,
            });
            told.filter(|name| EFFECTS.contains(&name.as_str()))
                .collect()
        };
        let forms = cache.pipelines().filter_map(|pipeline| {
            let (label, defs) = match &pipeline.descriptor {
                PipelineDescriptor::ComputePipelineDescriptor(own) => {
                    (own.label.as_ref()?, &own.shader_defs)
                }
                PipelineDescriptor::RenderPipelineDescriptor(own) => {
                    (own.label.as_ref()?, &own.fragment.as_ref()?.shader_defs)
                }
            };
            Some((label.to_string(), told(defs)))
        });
        forms.collect()
    }
}

/// Few lights need no passes of their own: nobody asks for the pipelines that share them out.
#[test]
fn what_a_scene_does_not_need_has_no_pipelines() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let headless = open(
        session(patient("healthy-brown"), 5),
        size,
        size,
        [true, true],
    );
    let mut run = Run {
        headless,
        time_s: 0.0,
    };
    settle(&mut run.headless);
    let labels: Vec<String> = run.forms().into_iter().map(|(label, _)| label).collect();
    let holds = |part: &str| labels.iter().any(|label| label.contains(part));
    assert!(holds("opaque_mesh"), "{labels:?}");
    assert!(!holds("clustering"), "{labels:?}");
}

#[test]
fn what_is_hidden_paused_or_unchanged_costs_nothing() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let headless = open(
        session(patient("healthy-brown"), 5),
        size,
        size,
        [true, true],
    );
    let mut run = Run {
        headless,
        time_s: 0.0,
    };
    settle(&mut run.headless);
    // A gaze that stays: in flight nothing is seen, and the field would rest.
    look(&mut run.headless, 0.0, 0.0, 3.0);
    run.headless.go_to(0.1);
    run.headless.go_to(1.0);
    run.time_s = 1.0;

    hidden_panels_do_no_work(&mut run);
    a_standing_clock_costs_nothing(&mut run);
    a_new_size_captures_once(&mut run);
    a_small_eye_has_fewer_vertices(&mut run);
    a_pupil_changes_no_material(&mut run);
    uploads_are_bounded(&mut run);
    glaucoma_runs_only_for_who_has_it(&mut run);
}

fn hidden_panels_do_no_work(run: &mut Run) {
    let both = run.play();
    assert!(both.eye_passes > 0 && both.lid_poses > 0, "{both:?}");
    assert!(both.view_passes > 0 && both.field_updates > 0, "{both:?}");
    // One pass a frame at most, and the blink hides some updates of the field.
    assert!(
        both.eye_passes <= FRAMES && both.view_passes <= FRAMES,
        "{both:?}"
    );
    assert!(
        both.field_updates < FRAMES,
        "behind closed lids nothing is seen: {both:?}"
    );

    run.show(false, true);
    let view_alone = run.play();
    assert!(
        view_alone.view_passes > 0 && view_alone.field_updates > 0,
        "{view_alone:?}"
    );
    let of_the_eye = Work {
        eye_passes: view_alone.eye_passes,
        eye_pixels: view_alone.eye_pixels,
        lid_poses: view_alone.lid_poses,
        lid_vertices: view_alone.lid_vertices,
        ..Work::default()
    };
    assert_eq!(of_the_eye, Work::default());

    run.show(true, false);
    let eye_alone = run.play();
    assert!(
        eye_alone.eye_passes > 0 && eye_alone.lid_poses > 0,
        "{eye_alone:?}"
    );
    let only_the_eye = Work {
        eye_passes: eye_alone.eye_passes,
        eye_pixels: eye_alone.eye_pixels,
        lid_poses: eye_alone.lid_poses,
        lid_vertices: eye_alone.lid_vertices,
        bytes_uploaded: eye_alone.bytes_uploaded,
        ..Work::default()
    };
    assert_eq!(eye_alone, only_the_eye, "the hidden view did something");

    run.show(false, false);
    assert_eq!(run.play(), Work::default());
    run.show(true, true);
    settle(&mut run.headless);
}

fn a_standing_clock_costs_nothing(run: &mut Run) {
    run.time_s += STEP_S;
    run.headless.go_to(run.time_s);
    let before = run.headless.work();
    for _ in 0..3 {
        run.headless.go_to(run.time_s);
        run.headless.stand_still();
    }
    assert_eq!(run.headless.work().since(before), Work::default());
    // And the same count is not zero when the clock moves.
    run.time_s += STEP_S;
    run.headless.go_to(run.time_s);
    assert_ne!(run.headless.work().since(before), Work::default());
}

fn a_new_size_captures_once(run: &mut Run) {
    assert_eq!(run.play().feature_passes, 0, "the view did not change");
    let before = run.headless.work();
    run.resize(Which::View, UVec2::new(128, 112));
    settle(&mut run.headless);
    let work = run.headless.work().since(before);
    assert_eq!(
        (work.feature_passes, work.view_captures),
        (1, 1),
        "{work:?}"
    );
    assert!(work.view_passes > 0, "the new size is shown: {work:?}");
    let picture = run.headless.panel(Which::View).expect("a picture");
    assert_eq!(picture.dimensions(), (128, 112));

    let before = run.headless.work();
    run.resize(Which::Eye, UVec2::new(112, 128));
    settle(&mut run.headless);
    let work = run.headless.work().since(before);
    assert!(work.eye_passes > 0, "{work:?}");
    assert_eq!(
        (work.feature_passes, work.view_captures),
        (0, 0),
        "{work:?}"
    );
    let after = run.play();
    assert_eq!(
        (
            after.feature_passes,
            after.view_captures,
            after.scene_passes
        ),
        (0, 0, 0)
    );
}

fn a_small_eye_has_fewer_vertices(run: &mut Run) {
    let mut vertices = |side: u32| {
        run.resize(Which::Eye, UVec2::splat(side));
        settle(&mut run.headless);
        let work = run.play();
        work.lid_vertices / work.lid_poses
    };
    let [small, middle, large] = [64, 320, 800].map(&mut vertices);
    // Skin and margins have a quarter of their vertices at each coarser level, lashes five eighths and a half.
    assert!(
        middle > small + 1500 && large > middle + 6000,
        "{small}, {middle} and {large} vertices a pose"
    );
    assert_eq!(vertices(64), small, "and it goes back");
    run.resize(Which::Eye, UVec2::splat(96));
    settle(&mut run.headless);
}

fn a_pupil_changes_no_material(run: &mut Run) {
    run.show(true, false);
    settle(&mut run.headless);
    // Materials that have changed in eight frames, and pupils that were seen.
    let play = |run: &mut Run| {
        type Changes = Messages<AssetEvent<GlobeMaterial>>;
        let world = run.headless.world();
        let mut cursor = world.resource::<Changes>().get_cursor_current();
        let (mut materials, mut pupils) = (0, Vec::new());
        for _ in 0..FRAMES {
            run.time_s += STEP_S;
            run.headless.go_to(run.time_s);
            pupils.push(run.headless.state().pupil_mm.to_bits());
            let changes = run.headless.world().resource::<Changes>();
            let is_modified = |event: &&AssetEvent<_>| matches!(event, AssetEvent::Modified { .. });
            materials += cursor.read(changes).filter(is_modified).count();
        }
        pupils.dedup();
        (materials, pupils.len())
    };
    let (materials, pupils) = play(run);
    assert!(pupils > 1, "a pupil is never at rest");
    assert_eq!(materials, 0, "of {pupils} pupils");
    look(&mut run.headless, 10.0, 0.0, 3.0);
    // A saccade begins 0.2 s after the frame that takes its command.
    for wait_s in [STEP_S, 0.2] {
        run.time_s += wait_s;
        run.headless.go_to(run.time_s);
    }
    assert!(play(run).0 > 0, "an eye that turns changes them");
    look(&mut run.headless, 0.0, 0.0, 3.0);
    run.time_s += 1.0;
    run.headless.go_to(run.time_s);
    run.show(true, true);
    settle(&mut run.headless);
}

fn uploads_are_bounded(run: &mut Run) {
    let uniform = size_of::<PerceptUniform>() as u64;
    let both = run.play();
    let most = FRAMES * (uniform + EYE_BYTES) + both.lid_vertices * VERTEX_BYTES;
    assert!(
        both.bytes_uploaded > 0 && both.bytes_uploaded <= most,
        "{both:?}"
    );
    run.show(false, true);
    let small = run.play();
    assert!(small.bytes_uploaded <= FRAMES * uniform, "{small:?}");
    run.resize(Which::View, UVec2::splat(192));
    settle(&mut run.headless);
    let large = run.play();
    // A view of 2.6 times the pixels uploads what the small one did: the uniform.
    assert!(large.view_pixels > 2 * small.view_pixels, "{large:?}");
    assert!(large.bytes_uploaded <= FRAMES * uniform, "{large:?}");
    run.resize(Which::View, UVec2::splat(96));
    run.show(true, true);
    settle(&mut run.headless);
}

fn glaucoma_runs_only_for_who_has_it(run: &mut Run) {
    assert_eq!(
        run.headless.work().field_loss_passes,
        0,
        "nobody has had glaucoma"
    );
    let healthy = run.forms();
    let form = |name: &str, effects: &[&str]| {
        let effects = effects.iter().map(|effect| (*effect).to_owned());
        (name.to_owned(), effects.collect::<Vec<_>>())
    };
    assert!(healthy.contains(&form("present", &[])), "{healthy:?}");
    assert!(
        healthy.iter().all(|(_, effects)| effects.is_empty()),
        "{healthy:?}"
    );

    let change = |run: &mut Run, name: &str| {
        let command = SessionCommand::Patient(Box::new(patient(name)));
        run.headless.command(command);
        run.headless.go_to(0.0);
        settle(&mut run.headless);
        run.time_s = 0.0;
        run.play()
    };
    let work = change(run, "glaucoma-moderate");
    assert!(work.field_loss_passes > 0, "{work:?}");
    assert_eq!(
        work.field_loss_passes, work.view_passes,
        "every picture shows the loss"
    );
    let work = change(run, "healthy-blue");
    assert!(work.view_passes > 0, "{work:?}");
    assert_eq!(work.field_loss_passes, 0, "the next patient is healthy");
    let clouded = change(run, "cataract-nuclear");
    assert_eq!(
        clouded.veil_passes, 0,
        "a still view has its veil: {clouded:?}"
    );
    assert!(
        clouded.view_passes > 1 && clouded.field_loss_passes == 0,
        "{clouded:?}"
    );
    let work = change(run, "healthy-green");
    assert_eq!(
        (work.veil_passes, work.field_loss_passes),
        (0, 0),
        "{work:?}"
    );
    assert_eq!(run.headless.work().veil_passes, 1, "one veil for one view");
    let keys = run.forms();
    assert!(
        !keys.contains(&form("present", &["ASTIGMATISM"])),
        "{keys:?}"
    );
    change(run, "astigmat");
    let keys = run.forms();
    for pass in ["update_field", "read_blur", "present"] {
        for effect in ["FIELD_LOSS", "ASTIGMATISM"] {
            assert!(
                keys.contains(&form(pass, &[effect])),
                "{pass:?} in {keys:?}"
            );
        }
    }
    assert!(keys.contains(&form("present", &["MEDIA"])), "{keys:?}");
    // Passes that do not know an effect have one form.
    assert!(
        !keys.contains(&form("fast_strength", &["FIELD_LOSS"])),
        "{keys:?}"
    );
    assert!(
        !keys.contains(&form("update_field", &["MEDIA"])),
        "{keys:?}"
    );
}

#[test]
fn the_field_holds_what_is_seen_and_not_the_rooms_volume() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let session = session(patient("healthy-brown"), 5);
    let mut headless = open(session, UVec2::splat(16), size, [false, true]);
    settle(&mut headless);
    let voxels = |headless: &mut Headless| f64::from(headless.percept().captured().occupied);
    let small = voxels(&mut headless);
    let model = room_scaled(8.0).expect("a larger room");
    let scene = Arc::new(LoadedScene::Model(Box::new(model)));
    headless.command(SessionCommand::Scene(scene));
    look(&mut headless, 0.0, 0.0, 3.0);
    settle(&mut headless);
    let large = voxels(&mut headless);
    let pixels = f64::from(size.x * size.y);
    for count in [small, large] {
        assert!(
            count > 0.3 * pixels && count <= pixels,
            "{count} voxels of {pixels} pixels"
        );
    }
    // Walls that stand farther off fill a few more voxels; a dense grid would need 8 times as many.
    let ratio = large / small;
    assert!((0.9..=1.1).contains(&ratio), "{small} and {large} voxels");
}
