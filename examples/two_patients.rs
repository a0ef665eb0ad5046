//! The same room through two pairs of eyes: before and after.
//!
//! `cargo run --release --example two_patients`, or with `--frames 5 --out out/two` without a window.

mod room;

use bevy::camera::{Hdr, Viewport};
use bevy::prelude::*;
use ocularium::lab::record::{RecordPlugin, plugins};
use ocularium::prelude::*;

fn main() -> AppExit {
    let recording =
        room::recording("The same room through two pairs of eyes: before and after glaucoma.");
    App::new()
        .add_plugins((plugins(recording.as_ref()), OculariumPlugins))
        .add_plugins(RecordPlugin(recording.clone()))
        .insert_resource(Width(recording.map_or(UVec2::new(1280, 720), |it| it.size)))
        .add_systems(Startup, (room::furnish, meet))
        .run()
}

/// Size of the picture, pixels.
#[derive(Resource)]
struct Width(UVec2);

fn meet(mut commands: Commands, size: Res<Width>) {
    let before = commands.spawn(Patient::preset("healthy-brown")).id();
    let after = commands
        .spawn((
            Patient::preset("healthy-brown"),
            Glaucoma::from(GlaucomaStage::Severe),
        ))
        .id();
    let half = UVec2::new(size.0.x / 2, size.0.y);
    for (index, patient) in [before, after].into_iter().enumerate() {
        commands.spawn((
            Camera3d::default(),
            Camera {
                order: index as isize,
                viewport: Some(Viewport {
                    physical_position: UVec2::new(index as u32 * half.x, 0),
                    physical_size: half,
                    ..default()
                }),
                // The second must not wipe away what the first has drawn.
                clear_color: ClearColorConfig::Default,
                ..default()
            },
            Hdr,
            SeesAs(patient),
            room::seat(),
        ));
    }
}
