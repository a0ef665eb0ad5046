//! An eye in a world of one's own that mirrors what stands around it there.

use crate::people::difference;
use crate::stage::turn;
use bevy::app::App;
use bevy::camera::visibility::RenderLayers;
use bevy::math::{DVec2, DVec3, UVec2};
use bevy::prelude::*;
use image::RgbaImage;
use ocularium::OculariumPlugins;
use ocularium::appearance::shading::surroundings::surroundings_direction;
use ocularium::appearance::{EyeOrbit, Probed, eye_camera};
use ocularium::frame::ledger::WorkLedger;
use ocularium::frame::panel::target_image;
use ocularium::lab::headless::{Headless, plugins};
use ocularium::prelude::*;

/// What the card sends out, cd/m².
const CARD_CD_M2: f32 = 3000.0;
/// Half its width, m.
const HALF_M: f32 = 0.3;
/// Half of what a pixel of the probe's pictures shows in their middle, rad.
const HALF_PIXEL: f64 = 1.0 / 64.0;
/// Where it hangs.
const AT: Vec3 = Vec3::new(-0.9, 0.5, -2.0);

struct World {
    headless: Headless,
    model: Entity,
    card: Entity,
    picture: Handle<Image>,
    time_s: f64,
}

/// A red card that shines before an eye, a camera that looks at the eye, and a lamp; the sky is black.
fn world(probe: bool) -> World {
    let mut app = App::new();
    app.add_plugins((plugins(), OculariumPlugins));
    app.insert_resource(ClearColor(Color::BLACK));
    let world = app.world_mut();
    let mesh =
        world
            .resource_mut::<Assets<Mesh>>()
            .add(Cuboid::new(2.0 * HALF_M, 2.0 * HALF_M, 0.01));
    let red = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color: Color::BLACK,
            emissive: LinearRgba::rgb(CARD_CD_M2, 0.0, 0.0),
            emissive_exposure_weight: 1.0,
            reflectance: 0.0,
            ..default()
        });
    let card = world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(red),
            Transform::from_translation(AT).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .id();
    world.spawn((
        PointLight {
            intensity: 4000.0,
            range: 9.0,
            ..default()
        },
        Transform::from_xyz(0.6, 0.6, -1.0),
    ));
    let ann = world.spawn(Patient::preset("healthy-brown")).id();
    let model = world.spawn(EyeModel(ann)).id();
    if probe {
        world.entity_mut(model).insert(EyeProbe::default());
    }
    let size = UVec2::splat(128);
    let picture = world
        .resource_mut::<Assets<Image>>()
        .add(target_image(size));
    let panel = Panel {
        visible: true,
        size,
        image: picture.clone(),
    };
    world.spawn((
        eye_camera(model, panel, RenderLayers::default()),
        EyeOrbit {
            distance_mm: 60.0,
            ..default()
        },
    ));
    let headless = Headless::of(app).unwrap_or_else(|error| panic!("{error}"));
    let mut found = World {
        headless,
        model,
        card,
        picture,
        time_s: 0.0,
    };
    found.wait();
    found
}

impl World {
    /// Two seconds on, by sixty frames.
    fn wait(&mut self) {
        for _ in 0..60 {
            self.time_s += 1.0 / 30.0;
            self.headless.go_to(self.time_s);
            self.headless.finish_frame();
        }
    }

    fn pictures_taken(&mut self) -> u64 {
        let ledger = self.headless.world().resource::<WorkLedger>();
        ledger.read().probe_pictures
    }

    /// Where the card is in what surrounds the eye, and how bright.
    fn card(&mut self) -> (DVec3, f32) {
        let model = self.model;
        let probed = self.headless.world().get::<Probed>(model).expect("a probe");
        let around = probed.around().expect("pictures have arrived");
        let (side, _, texels) = &around.levels[0];
        let (mut sum, mut most) = (DVec3::ZERO, 0.0_f32);
        for (i, texel) in texels.iter().enumerate() {
            let i = i as u32;
            let at = DVec2::new(f64::from(i % side), f64::from(i / side)) + 0.5;
            // Green and blue are those of nothing.
            assert!(texel[1] < 1.0 && texel[2] < 1.0, "{texel:?}");
            sum += surroundings_direction(at / f64::from(*side)) * f64::from(texel[0]);
            most = most.max(texel[0]);
        }
        (sum.normalize_or_zero(), most)
    }

    fn drawn(&mut self) -> RgbaImage {
        self.headless.picture(&self.picture).expect("a picture")
    }
}

#[test]
fn an_eye_mirrors_the_world_that_it_stands_in() {
    let _turn = turn();
    let mut probed = world(true);
    let (direction, most) = probed.card();
    let wanted = AT.as_dvec3().normalize();
    assert!(
        direction.distance(wanted) < HALF_PIXEL,
        "{direction} {wanted}"
    );
    assert!((most / CARD_CD_M2 - 1.0).abs() < 0.01, "{most}");
    // Nothing changes: nothing is taken again.
    let taken = probed.pictures_taken();
    probed.wait();
    assert_eq!(probed.pictures_taken(), taken);
    let before = probed.drawn();

    // The card goes elsewhere.
    let aside = Vec3::new(1.2, -0.4, -1.8);
    let card = probed.card;
    *probed
        .headless
        .world()
        .get_mut::<Transform>(card)
        .expect("a place") = Transform::from_translation(aside).looking_at(Vec3::ZERO, Vec3::Y);
    probed.wait();
    let again = probed.pictures_taken() - taken;
    assert!((6..=12).contains(&again), "{again}");
    let (direction, _) = probed.card();
    assert!(
        direction.distance(aside.as_dvec3().normalize()) < HALF_PIXEL,
        "{direction}"
    );
    let moved = difference(&before, &probed.drawn());

    // The head turns to its right: the world to its left.
    let turn = Quat::from_rotation_y(-0.5);
    let model = probed.model;
    probed
        .headless
        .world()
        .get_mut::<Transform>(model)
        .expect("a place")
        .rotation = turn;
    probed.wait();
    let (direction, _) = probed.card();
    let wanted = (turn.inverse() * aside).as_dvec3().normalize();
    assert!(
        direction.distance(wanted) < HALF_PIXEL,
        "{direction} {wanted}"
    );

    // Without a probe the world is its lights alone.
    let mut bare = world(false);
    let without = difference(&before, &bare.drawn());
    println!("elsewhere {moved:.3}, without {without:.3}");
    assert!(moved > 0.05 && without > 0.05, "{moved} {without}");
    assert_eq!(bare.pictures_taken(), 0);

    // It goes with its cameras.
    let cameras = |world: &mut bevy::prelude::World| world.query::<&Camera>().iter(world).count();
    let with = cameras(probed.headless.world());
    probed
        .headless
        .world()
        .entity_mut(model)
        .remove::<EyeProbe>();
    probed.wait();
    assert_eq!(with - cameras(probed.headless.world()), 6);
}
