//! A panel of another size shows the old view until it has one of its own: the same picture, as high
//! as the panel, and never the old one at its old size, with its last texels drawn out beside it.

use crate::stage::{look, open, patient, session, settle, turn, without_blinks};
use bevy::math::UVec2;
use bevy::prelude::{Assets, Image, PostUpdate, ResMut, Resource, Schedules};
use image::RgbaImage;
use image::imageops::{FilterType, resize};
use ocularium::lab::headless::{Headless, Which};
use ocularium::stage::Panels;

/// A size that the view is given late in the frame, as the window's controls do.
#[derive(Resource, Default)]
struct Wanted(Option<UVec2>);

fn lay_out(mut wanted: ResMut<Wanted>, mut panels: Panels, mut images: ResMut<Assets<Image>>) {
    if let Some(size) = wanted.0.take() {
        panels.view_mut().resize(&mut images, size);
        if panels.eye().visible {
            panels.eye_mut().resize(&mut images, size);
        }
    }
}

/// Mean difference over the columns from `first` on and as many as `wanted` has.
fn difference(wanted: &RgbaImage, picture: &RgbaImage, first: u32) -> f64 {
    let sum: f64 = wanted
        .enumerate_pixels()
        .map(|(x, y, pixel)| {
            let other = picture.get_pixel(first + x, y);
            (0..3)
                .map(|i| f64::from(pixel.0[i].abs_diff(other.0[i])))
                .sum::<f64>()
                / 3.0
        })
        .sum();
    sum / f64::from(wanted.width() * wanted.height())
}

fn view(headless: &Headless) -> RgbaImage {
    headless
        .panel(Which::View)
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_resized_view_keeps_its_picture_until_it_has_another() {
    let _turn = turn();
    let size = UVec2::new(160, 120);
    let mut headless = open(
        session(patient("healthy-blue"), 3),
        UVec2::splat(16),
        size,
        [false, true],
    );
    settle(&mut headless);
    without_blinks(&mut headless);
    look(&mut headless, 4.0, -6.0, 1.0);
    headless.go_to(0.5);
    headless.finish_frame();
    let world = headless.world();
    world.init_resource::<Wanted>();
    world
        .resource_mut::<Schedules>()
        .add_systems(PostUpdate, lay_out);
    // Twice as wide and high; broader than the view, with black beside it; narrower, with less of it.
    for size in [
        UVec2::new(320, 240),
        UVec2::new(400, 120),
        UVec2::new(120, 240),
    ] {
        let old = view(&headless);
        let wide = size.y * old.width() / old.height();
        let filled = resize(&old, wide, size.y, FilterType::Triangle);
        headless.world().insert_resource(Wanted(Some(size)));
        // The frame that resizes, and those that wait for the capture.
        for frame in 0..3 {
            headless.stand_still();
            headless.finish_frame();
            assert_ne!(headless.percept().captured().size, size);
            let picture = view(&headless);
            assert_eq!(picture.dimensions(), size.into());
            let (cut, beside) = (
                wide.saturating_sub(size.x) / 2,
                size.x.saturating_sub(wide) / 2,
            );
            let part = image::imageops::crop_imm(&filled, cut, 0, wide.min(size.x), size.y);
            let off = difference(&part.to_image(), &picture, beside);
            println!("{size}, frame {frame}: {off:.2}");
            // A view is gathered anew for the pixels that there are, not filtered: where it is shown half as
            // high, one texel in four. An empty panel is off by 116.
            assert!(off < 4.0, "{size}, frame {frame}: off by {off}");
            let black = (0..size.y)
                .all(|y| (0..beside).all(|x| picture.get_pixel(x, y).0 == [0, 0, 0, 255]));
            assert!(black, "{size}: something is drawn beside the view");
        }
        settle(&mut headless);
        headless.stand_still();
    }
}

#[test]
fn the_eye_is_drawn_at_every_size_on_the_way() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let mut headless = open(
        session(patient("healthy-blue"), 3),
        size,
        size,
        [true, true],
    );
    settle(&mut headless);
    without_blinks(&mut headless);
    let lit = |headless: &Headless| {
        let eye = headless.panel(Which::Eye);
        let eye = eye.unwrap_or_else(|error| panic!("{error}"));
        let bright = eye.pixels().filter(|pixel| pixel.0[0] > 60).count();
        bright as f64 / f64::from(eye.width() * eye.height())
    };
    headless.go_to(0.1);
    headless.finish_frame();
    let share = lit(&headless);
    assert!(share > 0.5, "{share}");
    let world = headless.world();
    world.init_resource::<Wanted>();
    world
        .resource_mut::<Schedules>()
        .add_systems(PostUpdate, lay_out);
    // A window's edge that is dragged: the view waits for the end of it, the eye must not.
    for step in 1..12u32 {
        let size = UVec2::new(96 + 4 * step, 96 + 2 * step);
        headless.world().insert_resource(Wanted(Some(size)));
        headless.go_to(0.1 + 0.05 * f64::from(step));
        headless.finish_frame();
        let now = lit(&headless);
        assert!(
            (now - share).abs() < 0.15,
            "step {step}: {now}, not {share}"
        );
    }
}
