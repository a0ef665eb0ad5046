//! Somebody's eye among other things, under the lights that shine on it, and beside it what she sees of them.
//!
//! `cargo run --release --example eye_in_my_scene`, or with `--frames 5 --out out/eye` without a window.

mod room;

use bevy::camera::{Exposure, Hdr};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use ocularium::lab::record::{RecordPlugin, plugins};
use ocularium::prelude::*;
use room::PictureSize;

fn main() -> AppExit {
    let recording = room::recording(
        "The eye of a patient in a scene, under its lights, and beside it what she sees.",
    );
    App::new()
        .add_plugins((plugins(recording.as_ref()), OculariumPlugins))
        .insert_resource(PictureSize::of(recording.as_ref()))
        .add_plugins(RecordPlugin(recording))
        .add_systems(Startup, (room::load, look_at_her))
        .add_systems(Update, (walk_around, worsen))
        .run()
}

/// Where her eyes are, m.
const PLACE: Vec3 = Vec3::new(0.0, 1.2, 1.5);

fn look_at_her(mut commands: Commands, size: Res<PictureSize>) {
    let ann = commands
        .spawn((Patient::preset("healthy-blue"), Cataract::nuclear(0.0)))
        .id();
    commands.spawn((
        EyeModel(ann),
        // Her cornea mirrors the room, as her eye sees it.
        EyeProbe::default(),
        Transform::from_translation(PLACE),
    ));
    // An examiner's lamp beside the camera, so that there is something to see in her pupil.
    commands.spawn((
        PointLight {
            intensity: 1500.0,
            range: 2.0,
            radius: 0.01,
            ..default()
        },
        Transform::from_translation(PLACE + Vec3::new(0.08, 0.1, -0.25)),
    ));
    // Before her face.
    commands.spawn((
        Camera3d::default(),
        size.half(0),
        Hdr,
        Projection::Perspective(PerspectiveProjection {
            fov: 0.4,
            near: 0.01,
            ..default()
        }),
        Exposure { ev100: 8.7 },
        // The default one needs a table that not every build of Bevy carries.
        Tonemapping::AcesFitted,
        Transform::default(),
        Wandering,
    ));
    // In her eye, which is nearer than this camera draws anything.
    commands.spawn((
        Camera3d::default(),
        size.half(1),
        Hdr,
        SeesAs(ann),
        Transform::from_translation(PLACE),
    ));
}

/// Her lens clouds over, in her pupil and in what she sees.
fn worsen(mut cataracts: Query<&mut Cataract>, clock: Res<SimulationClock>) {
    for mut cataract in &mut cataracts {
        cataract.nuclear = (3.0 * clock.time_s).min(6.0);
    }
}

/// The camera that walks around her.
#[derive(Component)]
struct Wandering;

fn walk_around(mut cameras: Query<&mut Transform, With<Wandering>>, clock: Res<SimulationClock>) {
    for mut camera in &mut cameras {
        let angle = 0.5 * (clock.time_s as f32).sin();
        // Her face looks along -z.
        let away = Vec3::new(angle.sin(), 0.1, -angle.cos()) * 0.11;
        *camera = Transform::from_translation(PLACE + away).looking_at(PLACE, Vec3::Y);
    }
}
