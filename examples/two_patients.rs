//! The same room through two pairs of eyes: before and after.
//!
//! `cargo run --release --example two_patients`, or with `--frames 5 --out out/two` without a window.

mod room;

use bevy::camera::Hdr;
use bevy::prelude::*;
use ocularium::lab::record::{RecordPlugin, plugins};
use ocularium::prelude::*;
use room::PictureSize;

fn main() -> AppExit {
    let recording =
        room::recording("The same room through two pairs of eyes: before and after glaucoma.");
    App::new()
        .add_plugins((plugins(recording.as_ref()), OculariumPlugins))
        .insert_resource(PictureSize::of(recording.as_ref()))
        .add_plugins(RecordPlugin(recording))
        .add_systems(Startup, (room::load, setup))
        .run()
}

fn setup(mut commands: Commands, size: Res<PictureSize>) {
    let before = commands.spawn(Patient::preset("healthy-brown")).id();
    let after = commands
        .spawn((
            Patient::preset("healthy-brown"),
            Glaucoma::from(GlaucomaStage::Severe),
        ))
        .id();
    for (index, patient) in [(0, before), (1, after)] {
        commands.spawn((
            Camera3d::default(),
            size.half(index),
            Hdr,
            SeesAs(patient),
            room::seat(),
        ));
    }
}
