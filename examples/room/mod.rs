//! What the examples share: a small furnished room from a file, and the command line.

#![allow(dead_code, reason = "no example uses all of it")]

use bevy::camera::Viewport;
use bevy::prelude::*;
use ocularium::lab::display::require_display;
use ocularium::lab::headless::require_device;
use ocularium::lab::record::{Recording, USAGE};

/// What the command line asks for; the program ends where it makes no sense, or where there is nothing to
/// draw with. `shows` says what the example is of.
pub fn recording(shows: &str) -> Option<Recording> {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Mesa's device-selection layer would complain that there is no session.
        // SAFETY: this is the program's only thread so far.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
    if std::env::args().any(|argument| matches!(&*argument, "--help" | "-h")) {
        println!("{shows} It opens a window. Options: {USAGE}.");
        std::process::exit(0);
    }
    let recording =
        Recording::from_arguments(std::env::args().skip(1)).unwrap_or_else(|sentence| {
            eprintln!("{sentence}");
            std::process::exit(2);
        });
    let fault = require_device().map_err(|error| error.to_string());
    let fault = match recording {
        Some(_) => fault,
        None => fault.and_then(|()| require_display()),
    };
    if let Err(error) = fault {
        eprintln!("{error}");
        std::process::exit(1);
    }
    recording
}

/// Size of the picture, pixels: that of the recording, or of the window.
#[derive(Resource)]
pub struct PictureSize(pub UVec2);

impl PictureSize {
    pub fn of(recording: Option<&Recording>) -> Self {
        Self(recording.map_or(UVec2::new(1280, 720), |it| it.size))
    }

    /// A camera that draws into the left half (0) or the right one (1).
    pub fn half(&self, index: u32) -> Camera {
        let size = UVec2::new(self.0.x / 2, self.0.y);
        Camera {
            order: index as isize,
            viewport: Some(Viewport {
                physical_position: UVec2::new(index * size.x, 0),
                physical_size: size,
                ..default()
            }),
            ..default()
        }
    }
}

/// Where somebody sits in the room, and where she looks.
pub fn seat() -> Transform {
    Transform::from_xyz(0.0, 1.2, 1.5).looking_at(Vec3::new(0.0, 1.0, -2.0), Vec3::Y)
}

/// Floor, walls, a shelf of boxes at several distances, and two lights, from a glTF file by Bevy's own loader.
pub fn load(mut commands: Commands, server: Res<AssetServer>) {
    let clinic = GltfAssetLabel::Scene(0).from_asset("examples/clinic.glb");
    commands.spawn(WorldAssetRoot(server.load(clinic)));
}
