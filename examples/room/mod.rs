//! What the examples share: a small furnished room, and the command line.

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

/// Floor, walls, a shelf of boxes at several distances, and two lights.
pub fn furnish(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut paint = |r: f32, g: f32, b: f32| materials.add(Color::srgb(r, g, b));
    let floor = meshes.add(Plane3d::default().mesh().size(8.0, 8.0));
    commands.spawn((Mesh3d(floor), MeshMaterial3d(paint(0.45, 0.33, 0.22))));
    let wall = meshes.add(Cuboid::new(8.0, 3.0, 0.1));
    commands.spawn((
        Mesh3d(wall.clone()),
        MeshMaterial3d(paint(0.55, 0.65, 0.6)),
        Transform::from_xyz(0.0, 1.5, -4.0),
    ));
    for side in [-1.0, 1.0] {
        commands.spawn((
            Mesh3d(wall.clone()),
            MeshMaterial3d(paint(0.7, 0.68, 0.6)),
            Transform::from_xyz(side * 3.0, 1.5, 0.0)
                .with_rotation(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)),
        ));
    }
    let brick = meshes.add(Cuboid::new(0.12, 0.3, 0.12));
    for index in 0..40_u8 {
        let (column, row) = (f32::from(index % 8), f32::from(index / 8));
        let hue = f32::from(index) * 47.0 % 360.0;
        commands.spawn((
            Mesh3d(brick.clone()),
            MeshMaterial3d(materials.add(Color::hsl(hue, 0.6, 0.45))),
            Transform::from_xyz(0.35 * (column - 3.5), 0.3 + 0.35 * row, -3.5 + 0.9 * row)
                .with_scale(Vec3::splat(1.0 - 0.12 * row)),
        ));
    }
    commands.spawn((
        PointLight {
            intensity: 120_000.0,
            range: 12.0,
            ..default()
        },
        Transform::from_xyz(1.2, 2.6, 0.5),
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 400.0,
            ..default()
        },
        Transform::default().looking_to(Vec3::new(0.3, -1.0, 0.6), Vec3::Y),
    ));
}
