//! Eyes in the sight of somebody who looks: one that moves is seen to, and costs nothing where nobody sees it.

use crate::people::{seen, world};
use crate::stage::{mean, turn};
use bevy::prelude::*;
use ocularium::lab::headless::Headless;
use ocularium::prelude::*;

/// Captures in frames of a moving clock, and the pupils that there were.
fn captures(headless: &mut Headless, time_s: &mut f64) -> (u64, usize) {
    let before = headless.work();
    let mut pupils = Vec::new();
    for _ in 0..6 {
        *time_s += 1.0 / 60.0;
        headless.go_to(*time_s);
        headless.finish_frame();
        let world = headless.world();
        let mut all = world.query::<&Pupil>();
        let pupil = all.iter(world).next().expect("a pupil");
        pupils.push(pupil.diameter_mm.to_bits());
    }
    pupils.dedup();
    (headless.work().since(before).view_captures, pupils.len())
}

#[test]
fn an_eye_that_moves_is_seen_to_where_it_is_in_the_picture_and_not_elsewhere() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(1);
    let world = headless.world();
    let mut people = world.query_filtered::<Entity, With<Patient>>();
    let ann = people.iter(world).next().expect("somebody");
    // Five times as large, and what it fills begins half a metre behind who looks.
    let behind = Transform::from_xyz(0.0, 0.0, 1.0).with_scale(Vec3::splat(5.0));
    let model = world.spawn((EyeModel(ann), behind)).id();
    let mut time_s = 0.0;
    // Until what is new is built and taken.
    let calm = (0..20).find(|_| captures(&mut headless, &mut time_s).0 == 0);
    println!("calm after {calm:?} times six frames");
    let (taken, pupils) = captures(&mut headless, &mut time_s);
    assert!(pupils > 1, "a pupil is never at rest");
    assert_eq!(taken, 0, "of an eye that nobody sees");
    let without = seen(&mut headless, cameras[0]);

    let place = |headless: &mut Headless, place: Transform| {
        *headless
            .world()
            .get_mut::<Transform>(model)
            .expect("its place") = place;
    };
    place(
        &mut headless,
        // It looks back at who looks.
        Transform::from_xyz(0.0, 0.0, -1.0)
            .with_rotation(Quat::from_rotation_y(std::f32::consts::PI))
            .with_scale(Vec3::splat(5.0)),
    );
    let (taken, _) = captures(&mut headless, &mut time_s);
    assert!(taken > 1, "{taken} of an eye that is seen to move");
    let with = seen(&mut headless, cameras[0]);
    let off = (mean(&with) - mean(&without)).abs();
    assert!(off > 2.0, "it is in the picture: {off}");

    // Where it has been something else is seen once it has gone.
    place(&mut headless, behind);
    let (taken, _) = captures(&mut headless, &mut time_s);
    println!("{taken} captures once it has gone");
    assert!(taken >= 1, "it is seen to go");
    captures(&mut headless, &mut time_s);
    assert_eq!(captures(&mut headless, &mut time_s).0, 0);
    let gone = seen(&mut headless, cameras[0]);
    assert!(
        (mean(&gone) - mean(&without)).abs() < 0.5 * off,
        "nothing of it stays"
    );
}
