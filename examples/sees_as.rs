//! A camera that sees as a short-sighted person does, while she walks up to what she looks at.
//!
//! `cargo run --release --example sees_as`, or with `--frames 5 --out out/sees` without a window.

mod room;

use bevy::camera::Hdr;
use bevy::prelude::*;
use ocularium::lab::record::{RecordPlugin, plugins};
use ocularium::prelude::*;

fn main() -> AppExit {
    let recording = room::recording(
        "A room as somebody sees it who grows short-sighted while she walks into it.",
    );
    App::new()
        .add_plugins((plugins(recording.as_ref()), OculariumPlugins))
        .add_plugins(RecordPlugin(recording))
        .add_systems(Startup, (room::load, sit_down))
        .add_systems(Update, (worsen, walk))
        .run()
}

fn sit_down(mut commands: Commands) {
    let ann = commands.spawn(Patient::preset("healthy-blue")).id();
    commands.spawn((Camera3d::default(), Hdr, SeesAs(ann), room::seat()));
}

/// Her eyes grow more and more short-sighted.
fn worsen(mut eyes: Query<&mut Refraction>, clock: Res<SimulationClock>) {
    for mut refraction in &mut eyes {
        refraction.sphere_d = -3.0 * clock.time_s.min(1.0);
    }
}

/// Half a metre a second.
fn walk(mut heads: Query<&mut Transform, With<SeesAs>>, clock: Res<SimulationClock>) {
    for mut head in &mut heads {
        let seat = room::seat();
        head.translation = seat.translation + 0.5 * clock.time_s.min(2.0) as f32 * *seat.forward();
    }
}
