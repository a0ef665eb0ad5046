//! A photograph from where the head has gone: what is seen where, against exact geometry.

use crate::stage::{open, patient, settle, turn, without_blinks};
use bevy::math::{DMat3, DVec2, DVec3, UVec2};
use ocularium::lab::headless::{Headless, Which};
use ocularium::patients::PupilSetting;
use ocularium::scene::catalog::LoadedScene;
use ocularium::scene::photo::{PhotoDepth, PhotoScene};
use ocularium::scene::pictures::{CoursePicture, PictureCourse, mean_luminance_cd_m2};
use ocularium::stage::{Head, Session};
use std::sync::Arc;

const SIDE: u32 = 160;
const FOV_DEG: f32 = 50.0;
/// A card this far off, before a wall.
const CARD_M: f64 = 1.0;
const WALL_M: f64 = 3.0;
/// Half the card's side, as a share of half the picture's.
const CARD_SHARE: f64 = 0.35;
const MOVED: Head = Head {
    place_m: bevy::math::Vec3::new(0.15, 0.06, 0.3),
    yaw_deg: 9.0,
    pitch_deg: -4.0,
};

fn tan_half() -> f64 {
    (0.5 * f64::from(FOV_DEG).to_radians()).tan()
}

/// Where a direction is in the picture, from −1 to 1 to the right and up; `None` beside it.
fn place(direction: DVec3) -> Option<DVec2> {
    let at = DVec2::new(direction.x, direction.y) / (-direction.z * tan_half());
    (direction.z < 0.0 && at.abs().max_element() < 1.0).then_some(at)
}

fn ray(x: u32, y: u32) -> DVec3 {
    let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(SIDE) - 1.0;
    DVec3::new(at(x) * tan_half(), -at(y) * tan_half(), -1.0).normalize()
}

/// A photograph whose red grows to the right and whose green grows downwards.
fn photograph(depth_m: PhotoDepth) -> LoadedScene {
    let code = |i: u32| ((i * 2 + 1) * 65_535 / (2 * SIDE)) as u16;
    let texels = (0..SIDE * SIDE).flat_map(|i| [code(i % SIDE), code(i / SIDE), 20_000]);
    LoadedScene::Photo(Arc::new(PhotoScene {
        name: "card".into(),
        width: SIDE,
        height: SIDE,
        course: None,
        rgb16_srgb: texels.collect(),
        depth_m,
        vertical_fov_deg: FOV_DEG,
        mean_luminance_cd_m2: 100.0,
        remarks: Vec::new(),
    }))
}

fn is_on_card(at: DVec2, margin: f64) -> bool {
    at.abs().max_element() < CARD_SHARE + margin
}

fn card_before_wall() -> PhotoDepth {
    let distances = (0..SIDE * SIDE).map(|i| {
        let ray = ray(i % SIDE, i / SIDE);
        let on_card = place(ray).is_some_and(|at| is_on_card(at, 0.0));
        (if on_card { CARD_M } else { WALL_M / -ray.z }) as f32
    });
    PhotoDepth::Map(distances.collect())
}

/// The eye and its axes (right, up, back) in the photograph's frame.
fn pose(head: &Head) -> (DVec3, DMat3) {
    let place = head.place_m.as_dvec3() * DVec3::new(1.0, 1.0, -1.0);
    let turned = DMat3::from_rotation_y(-f64::from(head.yaw_deg).to_radians())
        * DMat3::from_rotation_x(f64::from(head.pitch_deg).to_radians());
    (place, turned)
}

/// Along a ray that begins within it, where a sphere about the photograph's origin is met.
fn sphere(eye: DVec3, direction: DVec3, radius: f64) -> f64 {
    let along = eye.dot(direction);
    (along * along + radius * radius - eye.length_squared()).sqrt() - along
}

/// Distance of what is met, and where in the picture it is, if it is in it. `Err(true)` where nothing is met,
/// `Err(false)` where that hangs on less than two texels.
fn met(head: &Head, x: u32, y: u32) -> Result<(f64, Option<DVec2>), bool> {
    let (eye, axes) = pose(head);
    let direction = axes * ray(x, y);
    let margin = 4.0 / f64::from(SIDE);
    let card_m = sphere(eye, direction, CARD_M);
    let on_card = place(eye + card_m * direction);
    if let Some(at) = on_card.filter(|at| is_on_card(*at, margin)) {
        return if is_on_card(at, -margin) {
            Ok((card_m, Some(at)))
        } else {
            Err(false)
        };
    }
    if direction.z >= 0.0 {
        return Err(true);
    }
    let wall_m = (-WALL_M - eye.z) / direction.z;
    match place(eye + wall_m * direction) {
        None => Err(true),
        // The card hid it.
        Some(at) if is_on_card(at, -margin) => Ok((wall_m, None)),
        Some(at) if is_on_card(at, margin) || at.abs().max_element() > 1.0 - margin => Err(false),
        Some(at) => Ok((wall_m, Some(at))),
    }
}

fn see(scene: LoadedScene, head: Head) -> Headless {
    let mut who = patient("healthy-brown");
    who.pupil = PupilSetting::Fixed(1.0);
    let session = Session::new(who, scene, 5);
    let mut headless = open(session, UVec2::splat(16), UVec2::splat(SIDE), [false, true]);
    settle(&mut headless);
    without_blinks(&mut headless);
    let before = headless.work().view_captures;
    headless.set_head(head);
    headless.go_to(0.3);
    settle(&mut headless);
    headless.go_to(0.6);
    assert!(headless.work().view_captures > before, "it was taken again");
    headless
}

/// Share of the pixels at which the distance is wrong, and the largest error of the others' colour in codes.
fn faults(headless: &Headless, head: &Head) -> (f64, f64) {
    let vergences = headless.percept().captured().vergence_d.clone();
    let picture = headless.panel(Which::View).expect("a picture");
    let (mut judged, mut wrong, mut worst) = (0.0, 0.0, 0.0f64);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let found = f64::from(vergences[(y * SIDE + x) as usize]);
            let is_right = match met(head, x, y) {
                Err(false) => continue,
                Err(true) => found == 0.0,
                // What was hidden is as far as the wall beside it, of which the distance is taken, not the plane.
                Ok((distance_m, None)) => (found * distance_m - 1.0).abs() < 0.05,
                // A texel of the wall is 0.7 % of its distance deep.
                Ok((distance_m, Some(at))) => {
                    let is_right = (found * distance_m - 1.0).abs() < 0.012;
                    // What blur mixes in from beside is not told apart.
                    if is_right && !is_on_card(at, 0.12) && at.abs().max_element() < 0.88 {
                        let code = |share: f64| 127.5 * (1.0 + share);
                        let pixel = picture.get_pixel(x, y).0.map(f64::from);
                        let error = DVec2::new(pixel[0] - code(at.x), pixel[1] - code(-at.y));
                        worst = worst.max(error.abs().max_element());
                    }
                    is_right
                }
            };
            judged += 1.0;
            wrong += f64::from(u8::from(!is_right));
        }
    }
    assert!(judged > 0.7 * f64::from(SIDE * SIDE), "{judged}");
    (wrong / judged, worst)
}

#[test]
fn a_photograph_with_distances_is_seen_from_where_the_head_goes() {
    let _turn = turn();
    let headless = see(photograph(card_before_wall()), MOVED);
    let (wrong, colour) = faults(&headless, &MOVED);
    println!(
        "{:.2} % of the distances wrong, colours within {colour:.1} codes",
        100.0 * wrong
    );
    assert!(wrong < 0.003, "{wrong}");
    assert!(colour < 3.0, "{colour}");
    // A head 3 cm beside sees another picture.
    let mut beside = MOVED;
    beside.place_m.x += 0.03;
    let (wrong, _) = faults(&headless, &beside);
    assert!(wrong > 0.02, "{wrong}");
}

/// The soft edges that depth images are made with: of two things side by side each texel there has a third of the other.
#[test]
fn nothing_floats_in_a_soft_edge() {
    let _turn = turn();
    let PhotoDepth::Map(hard) = card_before_wall() else {
        panic!("a map");
    };
    let soft = (0..hard.len()).map(|i| {
        let beside = |off: isize| hard[i.saturating_add_signed(off).min(hard.len() - 1)];
        let other = [beside(-1), beside(1)]
            .into_iter()
            .find(|other| (1.0 / other - 1.0 / hard[i]).abs() > 0.2);
        other.map_or(hard[i], |other| 3.0 / (2.0 / hard[i] + 1.0 / other))
    });
    let headless = see(photograph(PhotoDepth::Map(soft.collect())), MOVED);
    let (wrong, _) = faults(&headless, &MOVED);
    println!("{:.2} % of the distances wrong", 100.0 * wrong);
    assert!(wrong < 0.003, "{wrong}");
}

#[test]
fn a_flat_photograph_keeps_its_distance() {
    let _turn = turn();
    let headless = see(photograph(PhotoDepth::Constant(2.0)), MOVED);
    let (eye, axes) = pose(&MOVED);
    let vergences = &headless.percept().captured().vergence_d;
    let (mut inside, mut outside) = (0, 0);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let direction = axes * ray(x, y);
            let distance_m = sphere(eye, direction, 2.0);
            let found = f64::from(vergences[(y * SIDE + x) as usize]);
            let edge = |at: DVec2| at.abs().max_element();
            match place(eye + distance_m * direction) {
                Some(at) if edge(at) < 0.999 => {
                    inside += 1;
                    assert!((found * distance_m - 1.0).abs() < 1e-5, "{x}, {y}: {found}");
                }
                Some(_) => {}
                None => {
                    let point = eye + distance_m * direction;
                    let at = DVec2::new(point.x, point.y) / (-point.z * tan_half());
                    if point.z >= 0.0 || edge(at) > 1.001 {
                        outside += 1;
                        assert_eq!(found, 0.0, "{x}, {y}");
                    }
                }
            }
        }
    }
    assert!(inside > 10_000 && outside > 1000, "{inside}, {outside}");
}

/// What is infinitely far stands still wherever the head goes, and a near thing before it does not.
#[test]
fn an_infinitely_far_background_stands_behind_what_is_near() {
    let _turn = turn();
    let PhotoDepth::Map(mut distances) = card_before_wall() else {
        panic!("a map");
    };
    for distance in &mut distances {
        if f64::from(*distance) > CARD_M + 0.1 {
            *distance = f32::INFINITY;
        }
    }
    let headless = see(photograph(PhotoDepth::Map(distances)), MOVED);
    let picture = headless.panel(Which::View).expect("a picture");
    let (eye, axes) = pose(&MOVED);
    let (mut judged, mut dark, mut worst) = (0.0, 0.0, 0.0f64);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let direction = axes * ray(x, y);
            let on_card = place(eye + sphere(eye, direction, CARD_M) * direction);
            let near_card = on_card.is_some_and(|at| is_on_card(at, 0.15));
            let Some(at) = place(direction) else { continue };
            if near_card || is_on_card(at, 0.15) || at.abs().max_element() > 0.85 {
                continue;
            }
            judged += 1.0;
            let pixel = picture.get_pixel(x, y).0.map(f64::from);
            dark += f64::from(u8::from(pixel[0] + pixel[1] < 2.0));
            let error = DVec2::new(
                pixel[0] - 127.5 * (1.0 + at.x),
                pixel[1] - 127.5 * (1.0 - at.y),
            );
            worst = worst.max(error.abs().max_element());
        }
    }
    println!("{judged} of the background, {dark} dark, within {worst:.1} codes");
    assert!(judged > 3000.0, "{judged}");
    assert_eq!(dark, 0.0);
    assert!(worst < 4.0, "{worst}");
}

/// Who steps back farther than a photograph is away still sees it, smaller.
#[test]
fn a_photograph_is_seen_from_far_behind_where_it_was_taken() {
    let _turn = turn();
    let back = Head {
        place_m: bevy::math::Vec3::new(0.0, 0.0, -0.6),
        ..Head::default()
    };
    let headless = see(photograph(PhotoDepth::Constant(0.4)), back);
    let vergences = &headless.percept().captured().vergence_d;
    let seen = vergences.iter().filter(|vergence| **vergence > 0.0).count();
    // The middle is a metre away, and all of it under less than half the angle.
    let middle = f64::from(vergences[(SIDE * SIDE / 2 + SIDE / 2) as usize]);
    assert!((middle - 1.0).abs() < 1e-3, "{middle}");
    let share = seen as f64 / f64::from(SIDE * SIDE);
    assert!((0.1..0.25).contains(&share), "{share}");
}

/// Of pictures that follow one another each is seen in its time, taken once, and the pupil follows their light.
#[test]
fn pictures_that_follow_one_another_are_seen_in_their_time() {
    let _turn = turn();
    let plain = |code: u16| vec![code; (3 * SIDE * SIDE) as usize];
    let (dark, light) = (plain(9000), plain(60_000));
    let LoadedScene::Photo(photo) = photograph(PhotoDepth::Constant(3.0)) else {
        panic!("a photograph")
    };
    let picture = |rgb16_srgb: &Vec<u16>, until_s: f64| CoursePicture {
        until_s,
        mean_luminance_cd_m2: mean_luminance_cd_m2(rgb16_srgb),
        rgb16_srgb: rgb16_srgb.clone(),
    };
    let pictures = vec![picture(&dark, 1.0), picture(&light, 4.0)];
    let scene = LoadedScene::Photo(Arc::new(PhotoScene {
        rgb16_srgb: dark.clone(),
        mean_luminance_cd_m2: mean_luminance_cd_m2(&dark),
        course: Some(Arc::new(PictureCourse { pictures })),
        ..(*photo).clone()
    }));
    let session = Session::new(patient("healthy-brown"), scene, 5);
    let mut headless = open(session, UVec2::splat(16), UVec2::splat(SIDE), [false, true]);
    settle(&mut headless);
    without_blinks(&mut headless);
    let middle = |headless: &Headless| {
        let picture = headless.panel(Which::View).expect("a picture");
        picture.get_pixel(SIDE / 2, SIDE / 2).0[1]
    };
    headless.go_to(0.9);
    settle(&mut headless);
    let (shade, wide_mm) = (middle(&headless), headless.state().pupil_mm);
    let before = headless.work();
    for time_s in [1.1, 1.6, 2.5, 3.5] {
        headless.go_to(time_s);
        settle(&mut headless);
    }
    assert_eq!(headless.work().since(before).view_captures, 1, "taken once");
    let (bright, narrow_mm) = (middle(&headless), headless.state().pupil_mm);
    assert!(
        u32::from(bright) > u32::from(shade) + 60,
        "{shade} and {bright}"
    );
    assert!(narrow_mm < wide_mm - 0.5, "{wide_mm} and {narrow_mm} mm");
    // And again from the first one on.
    headless.go_to(4.5);
    settle(&mut headless);
    assert!(middle(&headless).abs_diff(shade) <= 1);
}
