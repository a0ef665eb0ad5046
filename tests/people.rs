//! People in a world of one's own: eyes as entities, views on cameras, all of it changed as it runs.

use crate::stage::{look, mean, open, patient, session, settle, turn, without_blinks};
use bevy::app::App;
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{Hdr, RenderTarget};
use bevy::math::UVec2;
use bevy::prelude::*;
use image::RgbaImage;
use ocularium::OculariumPlugins;
use ocularium::anatomy::{Accommodation, VisualField};
use ocularium::appearance::{EyeDetail, EyeOrbit, EyeQuality};
use ocularium::frame::panel::target_image;
use ocularium::lab::headless::{Headless, Which, plugins};
use ocularium::motion::Candidates;
use ocularium::patients::{PatientFile, PupilSetting};
use ocularium::prelude::*;
use std::f32::consts::FRAC_PI_2;

pub const SIDE: u32 = 64;

/// A wall with a box before it, somebody, and `count` cameras that see as she does.
pub fn world(count: usize) -> (Headless, Vec<Entity>, Entity) {
    world_with(count, |_| {})
}

/// The same in an app that is `prepared`.
pub fn world_with(count: usize, prepare: impl FnOnce(&mut App)) -> (Headless, Vec<Entity>, Entity) {
    let mut app = App::new();
    app.add_plugins((plugins(), OculariumPlugins));
    prepare(&mut app);
    let world = app.world_mut();
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(1.0, 1.0, 1.0));
    let paint = |world: &mut World, hue: f32| {
        world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(Color::hsl(hue, 0.7, 0.5))
    };
    let (red, blue) = (paint(world, 0.0), paint(world, 220.0));
    world.spawn((
        Mesh3d(mesh.clone()),
        MeshMaterial3d(red),
        Transform::from_xyz(0.0, 0.0, -5.0).with_scale(Vec3::new(9.0, 9.0, 0.1)),
    ));
    let thing = world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(blue),
            Transform::from_xyz(0.3, 0.0, -2.0).with_scale(Vec3::splat(0.4)),
        ))
        .id();
    world.spawn((
        DirectionalLight {
            illuminance: 2000.0,
            ..default()
        },
        Transform::default().looking_to(Vec3::new(0.3, -0.5, -1.0), Vec3::Y),
    ));
    let ann = world.spawn(Patient::preset("healthy-blue")).id();
    let cameras = (0..count)
        .map(|_| {
            let image = world
                .resource_mut::<Assets<Image>>()
                .add(target_image(UVec2::splat(SIDE)));
            world
                .spawn((
                    Camera3d::default(),
                    Hdr,
                    RenderTarget::Image(image.clone().into()),
                    Panel {
                        visible: true,
                        size: UVec2::splat(SIDE),
                        image,
                    },
                    SeesAs(ann),
                ))
                .id()
        })
        .collect();
    let headless = Headless::of(app).unwrap_or_else(|error| panic!("{error}"));
    (headless, cameras, thing)
}

pub fn seen(headless: &mut Headless, camera: Entity) -> RgbaImage {
    let image = headless
        .world()
        .get::<Panel>(camera)
        .expect("a panel")
        .image
        .clone();
    headless.picture(&image).expect("a picture")
}

#[test]
fn a_view_of_nobody_stops_no_clock() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(2);
    headless.go_to(0.1);
    // One of two sees as nobody from now on; then both do, in a world of its own.
    headless
        .world()
        .entity_mut(cameras[0])
        .insert(SeesAs(Entity::PLACEHOLDER));
    headless.go_to(0.2);
    assert_eq!(headless.world().resource::<SimulationClock>().time_s, 0.2);
    let mut app = App::new();
    app.add_plugins((plugins(), OculariumPlugins));
    let world = app.world_mut();
    let image = world
        .resource_mut::<Assets<Image>>()
        .add(target_image(UVec2::splat(SIDE)));
    world.spawn((
        Camera3d::default(),
        Hdr,
        RenderTarget::Image(image.into()),
        SeesAs(Entity::PLACEHOLDER),
    ));
    let mut blind = Headless::of(app).unwrap_or_else(|error| panic!("{error}"));
    blind.go_to(0.5);
    assert_eq!(blind.world().resource::<SimulationClock>().time_s, 0.5);
}

#[test]
fn four_views_of_a_still_scene_cost_four_pictures_and_no_capture() {
    let _turn = turn();
    let (mut headless, cameras, thing) = world(4);
    headless.go_to(0.1);
    headless.go_to(0.2);
    let before = headless.work();
    for frame in 1..=5 {
        headless.go_to(0.2 + f64::from(frame) / 60.0);
    }
    let work = headless.work().since(before);
    assert_eq!(
        (work.view_captures, work.scene_passes, work.feature_passes),
        (0, 0, 0),
        "{work:?}"
    );
    // Pupils are never at rest.
    assert_eq!(work.view_passes, 4 * 5, "{work:?}");
    let still = seen(&mut headless, cameras[0]);
    assert!(mean(&still) > 10.0, "there is something to be seen");

    // Something moves where they look: each of them sees it, at once.
    headless
        .world()
        .get_mut::<Transform>(thing)
        .expect("the box")
        .translation
        .x = -0.3;
    let before = headless.work();
    headless.stand_still();
    headless.finish_frame();
    let work = headless.work().since(before);
    assert_eq!((work.view_captures, work.view_passes), (4, 4), "{work:?}");
    let moved = seen(&mut headless, cameras[0]);
    assert!(difference(&still, &moved) > 3.0);

    // Elsewhere nobody looks.
    headless
        .world()
        .entity_mut(thing)
        .insert(RenderLayers::layer(7));
    for _ in 0..4 {
        headless.stand_still();
        headless.finish_frame();
    }
    let gone = seen(&mut headless, cameras[0]);
    assert!(difference(&moved, &gone) > 3.0, "it is out of their sight");
    let before = headless.work();
    headless
        .world()
        .get_mut::<Transform>(thing)
        .expect("the box")
        .translation
        .x = 0.1;
    headless.stand_still();
    headless.stand_still();
    assert_eq!(headless.work().since(before).view_captures, 0);

    // A camera that is done seeing is Bevy's again.
    headless.world().entity_mut(cameras[0]).remove::<SeesAs>();
    headless.stand_still();
    let world = headless.world();
    let target = world.get::<RenderTarget>(cameras[0]).expect("a target");
    let panel = world.get::<Panel>(cameras[0]).expect("a panel");
    assert_eq!(target.as_image(), Some(&panel.image));
    assert!(world.get::<Camera>(cameras[0]).expect("a camera").is_active);
}

#[test]
fn a_view_is_taken_again_when_only_the_lens_of_an_eye_in_it_changes() {
    let _turn = turn();
    let (mut headless, _, _) = world(1);
    let bob = headless
        .world()
        .spawn(Patient::preset("healthy-green"))
        .id();
    headless.world().spawn((
        EyeModel(bob),
        // It looks back at the camera, 0.3 m away.
        Transform::from_xyz(0.0, 0.0, -0.3).with_rotation(Quat::from_rotation_y(FRAC_PI_2 * 2.0)),
    ));
    headless.go_to(0.1);
    headless.go_to(0.2);
    let captures = |headless: &mut Headless| {
        let before = headless.work();
        headless.stand_still();
        headless.finish_frame();
        headless.work().since(before).view_captures
    };
    for _ in 0..8 {
        captures(&mut headless);
    }
    assert_eq!(captures(&mut headless), 0, "nothing moves");
    headless
        .world()
        .entity_mut(bob)
        .insert(Cataract::nuclear(4.0));
    assert_eq!(captures(&mut headless), 1, "the lens is another");
    // Once more when the pipeline for clouded lenses is there.
    for _ in 0..8 {
        captures(&mut headless);
    }
    assert_eq!(captures(&mut headless), 0, "and stays so");
}

pub fn difference(one: &RgbaImage, other: &RgbaImage) -> f64 {
    let sum: f64 = one
        .as_raw()
        .iter()
        .zip(other.as_raw())
        .map(|(a, b)| f64::from(a.abs_diff(*b)))
        .sum();
    sum / one.as_raw().len() as f64
}

/// What was seen sharply is so still after the head was turned away and back, and would not be if it
/// had been forgotten.
#[test]
fn what_is_remembered_is_there_when_the_head_comes_back() {
    let _turn = turn();
    let view = UVec2::splat(320);
    let mut headless = open(
        session(patient("healthy-brown"), 3),
        UVec2::splat(16),
        view,
        [false, true],
    );
    settle(&mut headless);
    without_blinks(&mut headless);
    // The telephone in the hand, then the wall behind it.
    look(&mut headless, -13.0, -14.5, 0.3);
    headless.go_to(0.5);
    headless.go_to(1.0);
    look(&mut headless, 0.0, 8.0, 6.0);
    for step in 0..10 {
        headless.go_to(1.1 + 0.1 * f64::from(step));
    }
    let picture = |headless: &Headless| headless.panel(Which::View).expect("a picture");
    let telephone = |headless: &Headless| {
        image::imageops::crop_imm(&picture(headless), 60, 200, 80, 90).to_image()
    };
    let sharp = telephone(&headless);
    // Away is turned, and half a metre forwards and aside.
    let turn = |headless: &mut Headless, yaw_deg: f32| {
        headless.set_head(ocularium::stage::Head {
            yaw_deg,
            place_m: Vec3::new(0.4, 0.0, 0.5) * (yaw_deg / 50.0),
            ..default()
        });
    };
    turn(&mut headless, 50.0);
    headless.go_to(2.05);
    headless.finish_frame();
    headless.go_to(2.10);
    let away = picture(&headless);
    turn(&mut headless, 0.0);
    headless.go_to(2.15);
    headless.finish_frame();
    headless.go_to(2.20);
    let back = difference(&sharp, &telephone(&headless));
    assert!(
        difference(&away, &picture(&headless)) > 10.0,
        "it was turned"
    );

    let patient = headless.stage().patient;
    headless
        .world()
        .get_mut::<SharpnessField>(patient)
        .expect("a memory")
        .restart();
    headless.go_to(2.25);
    let forgotten = difference(&sharp, &telephone(&headless));
    // 0.2 s at 0.45/s let blur grow by 9 %; without memory it is that of a lens set for the wall.
    assert!(
        back < 0.1 * forgotten && forgotten > 1.0,
        "{back} when it comes back, {forgotten} when it is forgotten"
    );
}

/// Both panels four seconds on, when what is slow, a pupil, has had its time. Through an eye that is not whole
/// nobody sees, and no view comes.
fn pictures_later(headless: &mut Headless, is_whole: bool) -> [RgbaImage; 2] {
    for _ in 0..2 {
        let now = headless.world().resource::<SimulationClock>().time_s;
        headless.go_to(now + 2.0);
    }
    if is_whole {
        settle(headless);
    }
    [Which::Eye, Which::View].map(|which| headless.panel(which).expect("a picture"))
}

/// Somebody without blinks on two small panels, who has looked for a while at one place (degrees to the right and up, m).
fn looking(somebody: PatientFile, [right_deg, up_deg, distance_m]: [f64; 3]) -> Headless {
    let size = UVec2::splat(112);
    let mut headless = open(session(somebody, 3), size, size, [true; 2]);
    settle(&mut headless);
    without_blinks(&mut headless);
    look(&mut headless, right_deg, up_deg, distance_m);
    headless.go_to(0.5);
    headless.go_to(4.0);
    headless
}

/// The right eye of whoever is on the stage.
fn right_eye(headless: &mut Headless) -> Entity {
    let world = headless.world();
    world
        .query_filtered::<(Entity, &Eye), With<EyeOf>>()
        .iter(world)
        .find(|(_, eye)| eye.laterality == Laterality::OD)
        .map(|(entity, _)| entity)
        .expect("a right eye")
}

/// Which panels a change must show in: (eye, view).
type Change = (&'static str, fn(&mut World, Entity, Entity), [bool; 2]);

/// Changes a component where it is.
fn with<C: Component<Mutability = bevy::ecs::component::Mutable>>(
    world: &mut World,
    entity: Entity,
    change: impl FnOnce(&mut C),
) {
    change(&mut world.get_mut::<C>(entity).expect("a component"));
}

const CHANGES: &[Change] = &[
    (
        "Refraction",
        |w, eye, _| with(w, eye, |r: &mut Refraction| r.sphere_d = -4.0),
        [false, true],
    ),
    (
        "PupilControl",
        |w, _, patient| with(w, patient, |p: &mut PupilControl| p.fixed_mm = Some(6.5)),
        [true, true],
    ),
    (
        "Iris",
        |w, eye, _| with(w, eye, |iris: &mut Iris| iris.color = IrisColor::Blue),
        [true, false],
    ),
    (
        "Cornea",
        |w, eye, _| with(w, eye, |c: &mut Cornea| c.anterior_radius_mm = 7.0),
        [true, false],
    ),
    (
        "Eye",
        // It turns behind lids that cut its view.
        |w, eye, _| with(w, eye, |e: &mut Eye| e.angle_alpha_deg = [12.0, 0.0]),
        [true, true],
    ),
    (
        "Sclera",
        |w, eye, _| with(w, eye, |s: &mut Sclera| s.redness = 1.0),
        [true, false],
    ),
    (
        "Skin",
        |w, _, patient| with(w, patient, |s: &mut Skin| s.tone = 0.9),
        [true, false],
    ),
    (
        "Glaucoma of the eye",
        |w, eye, _| {
            w.entity_mut(eye)
                .insert(Glaucoma::from(GlaucomaStage::Severe));
        },
        [false, true],
    ),
    (
        "no glaucoma of the eye",
        |w, eye, _| {
            w.entity_mut(eye).remove::<Glaucoma>();
        },
        [false, true],
    ),
    (
        "Glaucoma of the person",
        |w, _, patient| {
            w.entity_mut(patient)
                .insert(Glaucoma::from(GlaucomaStage::Severe));
        },
        [false, true],
    ),
    (
        "no glaucoma of the person",
        |w, _, patient| {
            w.entity_mut(patient).remove::<Glaucoma>();
        },
        [false, true],
    ),
    (
        "Cataract of the eye",
        |w, eye, _| {
            w.entity_mut(eye).insert(Cataract {
                nuclear: 5.0,
                subcapsular: 4.0,
                ..Cataract::default()
            });
        },
        [true, true],
    ),
    (
        "another Cataract",
        |w, eye, _| with(w, eye, |c: &mut Cataract| c.nuclear = 1.0),
        [true, true],
    ),
    (
        "no cataract",
        |w, eye, _| {
            w.entity_mut(eye).remove::<Cataract>();
        },
        [true, true],
    ),
    (
        "Lids",
        |w, eye, _| with(w, eye, |lids: &mut Lids| lids.opening = 0.5),
        [true, true],
    ),
    (
        "Ptosis on half-open lids",
        |w, eye, _| {
            w.entity_mut(eye).insert(Ptosis { mrd1_mm: -1.0 });
        },
        [true, true],
    ),
    (
        "usual Lids, no ptosis",
        |w, eye, _| {
            w.entity_mut(eye).insert(Lids::default()).remove::<Ptosis>();
        },
        [true, true],
    ),
    (
        "Look",
        |w, eye, _| with(w, eye, |look: &mut Look| look.iris_brightness = 3.0),
        [true, false],
    ),
    (
        "usual Look",
        |w, eye, _| with(w, eye, |look: &mut Look| *look = Look::default()),
        [true, false],
    ),
    (
        "free pupils",
        |w, _, patient| with(w, patient, |p: &mut PupilControl| p.fixed_mm = None),
        [true, true],
    ),
    (
        "Adaptation",
        |w, _, patient| {
            with(w, patient, |a: &mut Adaptation| {
                a.luminance_cd_m2 = 0.01;
            });
        },
        [true, true],
    ),
    (
        "SharpnessField",
        |w, _, patient| {
            with(w, patient, |f: &mut SharpnessField| {
                // From now on hardly anything is remembered.
                f.blur_cap_rad = 0.01;
                f.starve_rate_per_s = 10.0;
            });
        },
        [false, true],
    ),
    (
        "Lens",
        |w, eye, _| with(w, eye, |lens: &mut Lens| lens.amplitude_d = Some(0.0)),
        [false, true],
    ),
    (
        "EyeLight",
        |w, _, _| {
            let mut lights = w.query::<&mut EyeLight>();
            for mut light in lights.iter_mut(w) {
                *light = EyeLight::Studio(Studio {
                    light: StudioLight::Lamp,
                    ..Studio::default()
                });
            }
        },
        [true, false],
    ),
    (
        "EyeOrbit",
        |w, _, _| {
            // Near enough to see how fine the maps are.
            let mut orbits = w.query::<&mut EyeOrbit>();
            for mut orbit in orbits.iter_mut(w) {
                orbit.distance_mm = 35.0;
            }
        },
        [true, false],
    ),
    (
        "EyeDetail",
        |w, _, _| {
            let mut details = w.query::<&mut EyeDetail>();
            for mut detail in details.iter_mut(w) {
                detail.fine = !detail.fine;
            }
        },
        [true, false],
    ),
    (
        "ViewOptions",
        |w, _, _| {
            let mut options = w.query::<&mut ViewOptions>();
            for mut options in options.iter_mut(w) {
                options.exposure *= 0.5;
            }
        },
        [false, true],
    ),
    (
        "Patient",
        |w, _, patient| with(w, patient, |p: &mut Patient| p.leading = Laterality::OS),
        // The left eye is shown, and sees from its own place.
        [true, true],
    ),
    (
        "EyeModel and SeesAs of another person",
        |w, _, _| {
            let ben = w
                .spawn((
                    Patient::preset("glaucoma-moderate"),
                    PupilControl {
                        held_mm: Some(4.0),
                        ..default()
                    },
                ))
                .id();
            let mut models = w.query::<&mut EyeModel>();
            for mut model in models.iter_mut(w) {
                model.0 = ben;
            }
            let mut views = w.query::<&mut SeesAs>();
            for mut sees in views.iter_mut(w) {
                sees.0 = ben;
            }
        },
        [true, true],
    ),
];

#[test]
fn both_panels_follow_every_component() {
    let _turn = turn();
    let mut headless = looking(patient("healthy-brown"), [0.0, 0.0, 0.15]);
    let patient = headless.stage().patient;
    let mut before = pictures_later(&mut headless, true);
    for (name, change, shows) in CHANGES {
        let eye = right_eye(&mut headless);
        // Time alone changes the pictures: pupils are never at rest.
        let control = pictures_later(&mut headless, true);
        change(headless.world(), eye, patient);
        let after = pictures_later(&mut headless, true);
        for panel in 0..2 {
            let by_itself = difference(&before[panel], &control[panel]);
            let found = difference(&control[panel], &after[panel]);
            let shown = ["eye", "view"][panel];
            println!("{name:26} {shown:4} {found:7.3}, by itself {by_itself:.3}");
            if shows[panel] {
                assert!(
                    found > 0.03 + by_itself,
                    "{name}: the {shown} differs by {found}"
                );
            } else {
                assert!(
                    found < 0.5 + 2.0 * by_itself,
                    "{name}: the {shown} differs by {found}"
                );
            }
        }
        before = after;
    }
}

/// Takes a component out of its entity; gives back what puts it in again.
type Removal = (
    &'static str,
    fn(&mut World, Entity, Entity) -> PutBack,
    [bool; 2],
);
type PutBack = Box<dyn FnOnce(&mut World)>;

fn take<C: Component + Clone>(world: &mut World, entity: Entity) -> PutBack {
    let taken = world.get::<C>(entity).expect("a component").clone();
    world.entity_mut(entity).remove::<C>();
    Box::new(move |world| {
        world.entity_mut(entity).insert(taken);
    })
}

macro_rules! of_eye {
    ($component:ty, $shows:expr) => {
        (
            stringify!($component),
            |world, eye, _| take::<$component>(world, eye),
            $shows,
        )
    };
}
macro_rules! of_person {
    ($component:ident, $shows:expr) => {
        (
            stringify!($component),
            |world, _, person| take::<$component>(world, person),
            $shows,
        )
    };
}

/// Takes each component out and puts it in again. Where it shows, what is gone `is_seen`, given how far the
/// pictures without it and those with it again are from those before; where not, nothing is. `is_whole` says
/// that an eye without it still sees.
fn take_and_put_back(
    headless: &mut Headless,
    removals: &[Removal],
    is_whole: bool,
    is_seen: impl Fn(f64, f64) -> bool,
) {
    let patient = headless.stage().patient;
    for (name, remove, shows) in removals {
        let eye = right_eye(headless);
        let before = pictures_later(headless, true);
        let put_back = remove(headless.world(), eye, patient);
        let without = pictures_later(headless, is_whole);
        put_back(headless.world());
        let after = pictures_later(headless, true);
        for panel in 0..2 {
            let shown = ["eye", "view"][panel];
            let gone = difference(&before[panel], &without[panel]);
            let back = difference(&before[panel], &after[panel]);
            println!("{name:14} {shown:4} without it {gone:7.3}, with it again {back:.3}");
            if shows[panel] {
                assert!(is_seen(gone, back), "{name}: the {shown} differs by {gone}");
            } else {
                assert!(gone < 0.6, "{name}: the {shown} differs by {gone}");
            }
            // Pupils are never at rest.
            assert!(back < 0.6, "{name}: the {shown} differs by {back}");
        }
    }
}

/// Every component of a person and of an eye that somebody may set, and which panels show that it is gone.
const REMOVALS: &[Removal] = &[
    of_eye!(Cornea, [true, true]),
    of_eye!(Iris, [true, true]),
    of_eye!(Sclera, [true, false]),
    of_eye!(Lens, [false, false]),
    of_eye!(Refraction, [true, true]),
    of_eye!(Lids, [true, true]),
    of_eye!(Gaze, [false, true]),
    of_eye!(Pupil, [false, true]),
    of_eye!(Accommodation, [false, true]),
    of_eye!(OcularMedia, [false, false]),
    of_eye!(VisualField, [false, false]),
    // What is written of its own parts is written again.
    of_eye!(Effective<Refraction>, [false, false]),
    of_eye!(Effective<Iris>, [false, false]),
    of_eye!(Effective<Lids>, [false, false]),
    of_person!(Skin, [true, false]),
    of_person!(Eyelids, [false, true]),
    of_eye!(Look, [false, false]),
    of_person!(PupilControl, [false, false]),
    of_person!(Adaptation, [false, false]),
];

macro_rules! of_whoever_has {
    ($component:ty, $shows:expr) => {
        (
            stringify!($component),
            |world, _, _| {
                let mut all = world.query_filtered::<Entity, With<$component>>();
                let entity = all.iter(world).next().expect("one that has it");
                take::<$component>(world, entity)
            },
            $shows,
        )
    };
}

/// What makes entities a person, her eyes, a model of one and a view through it, and which panels show that it is
/// gone.
const PARTS: &[Removal] = &[
    of_person!(SharpnessField, [false, true]),
    of_person!(Patient, [true, true]),
    of_eye!(Eye, [true, true]),
    of_whoever_has!(EyeModel, [true, false]),
    of_whoever_has!(SeesAs, [false, true]),
];

/// Whatever of the parts is taken out, nothing stops, and back it is what it was.
#[test]
fn every_part_may_go_and_come_back() {
    let _turn = turn();
    let mut headless = looking(patient("healthy-brown"), [0.0, 0.0, 0.15]);
    take_and_put_back(&mut headless, PARTS, false, |gone, _| gone > 10.0);
}

/// What is chosen about a person's motion, a model's light and a camera, and which panels show that it is gone.
const CHOICES: &[Removal] = &[
    of_person!(GazeController, [true, true]),
    // The other eye is shown then, which sees nearly the same.
    of_eye!(EyeOf, [true, false]),
    of_person!(Candidates, [false, false]),
    // Where the camera stood, what lit the eye and how finely it was drawn stays until somebody says otherwise.
    of_whoever_has!(EyeLight, [false, false]),
    of_whoever_has!(EyeOrbit, [false, false]),
    of_whoever_has!(EyeDetail, [false, false]),
    of_whoever_has!(EyeQuality, [false, false]),
    of_whoever_has!(ViewOptions, [false, false]),
];

#[test]
fn what_is_chosen_goes_with_its_component() {
    let _turn = turn();
    let mut headless = looking(patient("healthy-brown"), [15.0, 5.0, 0.3]);
    headless.set_orbit(EyeOrbit {
        distance_mm: 45.0,
        ..default()
    });
    take_and_put_back(&mut headless, CHOICES, true, |gone, back| {
        gone > 0.2 + 2.0 * back
    });
}

/// Whatever is taken out of a person or an eye, nothing stops; and when it is put back both panels show again
/// what they showed.
#[test]
fn every_component_may_go_and_come_back() {
    let _turn = turn();
    let mut headless = looking(patient("healthy-brown"), [0.0, 0.0, 0.15]);
    // An eye that is not whole is not drawn, or not drawn anew, and sees nothing.
    take_and_put_back(&mut headless, REMOVALS, false, |gone, _| gone > 30.0);
}

/// Components of somebody with clouded lenses, a lost field, an artist's irises and wide pupils, and which
/// panels show that they are gone.
const UNUSUAL: &[Removal] = &[
    of_eye!(Look, [true, false]),
    of_person!(PupilControl, [true, true]),
    // What conditions write they write again.
    of_eye!(VisualField, [false, false]),
    of_eye!(OcularMedia, [false, false]),
    of_eye!(Glaucoma, [false, true]),
    of_eye!(Cataract, [true, true]),
    of_eye!(Lens, [false, true]),
];

/// What somebody has otherwise than usual is gone with its component, and back with it.
#[test]
fn what_is_unusual_goes_with_its_component() {
    let _turn = turn();
    let somebody = PatientFile {
        cataract: Some(Cataract {
            nuclear: 5.0,
            subcapsular: 4.0,
            ..Cataract::default()
        }),
        glaucoma: Some(GlaucomaStage::Severe.into()),
        accommodation_amplitude_d: Some(0.0),
        look_iris_brightness: 3.0,
        pupil: PupilSetting::Fixed(7.0),
        ..patient("healthy-brown")
    };
    let mut headless = looking(somebody, [0.0, 0.0, 0.3]);
    headless.set_orbit(EyeOrbit {
        distance_mm: 45.0,
        ..default()
    });
    take_and_put_back(&mut headless, UNUSUAL, true, |gone, back| {
        gone > 0.2 + 2.0 * back
    });
}

/// Her eyes meet on what she looks at, both accommodate for it, and both pupils are as wide.
#[test]
fn the_eyes_of_a_person_meet_where_she_looks() {
    let _turn = turn();
    let (mut headless, _, _) = world(1);
    headless
        .world()
        .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
            azimuth_rad: 0.1,
            elevation_rad: -0.05,
            distance_m: 0.3,
        }));
    headless.go_to(0.5);
    headless.go_to(3.0);
    let world = headless.world();
    let mut gazes: Vec<(Laterality, Vec3)> = world
        .query::<(&Eye, &Gaze)>()
        .iter(world)
        .map(|(eye, gaze)| (eye.laterality, gaze.direction().as_vec3()))
        .collect();
    gazes.sort_by_key(|(eye, _)| *eye == Laterality::OS);
    let [(_, right), (_, left)] = gazes[..] else {
        panic!("two eyes: {gazes:?}");
    };
    let both: Vec<(f64, f64)> = world
        .query::<(&Accommodation, &Pupil)>()
        .iter(world)
        .map(|(lens, pupil)| (lens.response_d, pupil.diameter_mm))
        .collect();
    let [one, other] = both[..] else {
        panic!("two eyes: {both:?}");
    };
    assert_eq!(one, other);
    // For a third of a metre, with a lag; and narrower than in the dark.
    assert!(
        (2.0..3.4).contains(&one.0) && (1.5..7.0).contains(&one.1),
        "{one:?}"
    );
    let point = right * 0.3;
    let from_left = (point + Vec3::X * 0.063).normalize();
    assert!((from_left - left).length() < 1e-3, "{from_left} {left}");
    assert!(left.angle_between(right) > 0.15 && left.angle_between(right) < FRAC_PI_2);
}
