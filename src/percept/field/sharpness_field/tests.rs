use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

const CAP: f64 = 0.0349;

/// Random visits, pauses of 0 to 10 s and blinks, through the paper's grid and through the keys.
fn play(seed: u64, per_step: f64, blink_chance: f64, key_of: impl Fn(f64, u32, u8) -> u32) -> f64 {
    let mut rng = Pcg32::seed_from_u64(seed);
    let rate = starve_rate_per_s(per_step, 30.0);
    let mut dense = DenseField::new(64, rate);
    let mut sparse = SparseField::default();
    let mut clock = SharpnessClock::default();
    let mut time = 0.0;
    let mut worst = 0.0_f64;
    for _ in 0..4000 {
        let dt = [0.0, 1.0 / 144.0, 1.0 / 30.0, 0.1, 10.0][rng.random_range(0..5usize)];
        time += dt;
        if let Some(rebase) = clock.advance(dt, rate) {
            sparse.rebase(rebase, &clock);
        }
        if rng.random_range(0.0..1.0) < blink_chance {
            dense.blink();
            if let Some(rebase) = clock.blink() {
                sparse.rebase(rebase, &clock);
            }
        }
        for _ in 0..20 {
            let cell = rng.random_range(0..64usize);
            let coc = rng.random_range(-9.0..-3.0_f64).exp();
            dense.update(cell, coc, time);
            let key = key_of(coc, clock.starve_steps(), clock.epoch());
            let held = sparse
                .keys
                .entry([cell as i32, 0, 0, 0])
                .or_insert(NEVER_SEEN);
            *held = key.min(*held);
        }
        for cell in 0..64 {
            let a = dense.read(cell, time, CAP);
            let b = sparse.read([cell as i32, 0, 0, 0], &clock, CAP);
            worst = worst.max((b / a).ln().abs());
        }
    }
    worst
}

#[test]
fn keys_follow_the_papers_grid_within_the_quantisation() {
    for (seed, per_step) in [(1, 0.01), (2, 0.015), (3, 0.02)] {
        for blink_chance in [0.0, 0.01, 0.5] {
            let worst = play(seed, per_step, blink_chance, |coc, steps, epoch| {
                sharpness_key_encode(coc, 0.0, steps, epoch)
            });
            assert!(worst <= KEY_RELATIVE_ERROR * 1.001, "{worst}");
            assert!(
                worst > 0.1 * KEY_RELATIVE_ERROR,
                "{worst} is too good to be a comparison"
            );
        }
    }
}

#[test]
fn the_comparison_can_fail() {
    // Keys that forget to starve, and keys of a one percent larger blur.
    let unstarved = play(1, 0.01, 0.01, |coc, _, epoch| {
        sharpness_key_encode(coc, 0.0, 0, epoch)
    });
    assert!(unstarved > 0.1);
    let larger = play(1, 0.01, 0.01, |coc, steps, epoch| {
        sharpness_key_encode(1.01 * coc, 0.0, steps, epoch)
    });
    assert!(larger > 2.0 * KEY_RELATIVE_ERROR);
}

#[test]
fn a_key_says_its_blur_within_a_half_step() {
    let mut coc = 1.1e-6;
    while coc < 8.0 {
        let key = sharpness_key_encode(coc, 0.0, 1234, 7);
        let back = sharpness_key_decode(key, 1234, 7, f64::MAX);
        assert!(
            (back / coc).ln().abs() <= 0.5001 / STEPS_PER_NAT,
            "{coc} {back}"
        );
        coc *= 1.0137;
    }
    // 0.0244 % a step, well under a fifth of a percent.
    assert!((1.0 / STEPS_PER_NAT).exp_m1() < 2.5e-4);
}

#[test]
fn starving_is_one_to_two_percent_a_step() {
    for fraction in [0.01, 0.02] {
        let rate = starve_rate_per_s(fraction, 30.0);
        let mut clock = SharpnessClock::default();
        let key = sharpness_key_encode(1e-3, 0.0, clock.starve_steps(), clock.epoch());
        assert_eq!(clock.advance(1.0 / 30.0, rate), None);
        let coc = sharpness_key_decode(key, clock.starve_steps(), clock.epoch(), 1.0);
        assert!((coc / 1e-3 - 1.0 - fraction).abs() < 2.0 * KEY_RELATIVE_ERROR);
    }
    assert!((starve_rate_per_s(0.01, 30.0) - 0.2985).abs() < 1e-4);
    assert!((starve_rate_per_s(0.02, 30.0) - 0.5941).abs() < 1e-4);
}

#[test]
fn the_sharpest_sight_brings_its_own_direction() {
    // Round is exactly round, and lines are lines.
    for (elongation, exact) in [(0.0, true), (1.0, true), (-1.0, true), (0.43, false)] {
        let key = sharpness_key_encode(1e-3, elongation, 7, 3);
        let back = sharpness_key_elongation(key, 3);
        assert!(if exact {
            back == elongation
        } else {
            (back - elongation).abs() < 0.0113
        });
        let later = sharpness_key_rebase(key, 1000, 3);
        assert_eq!(sharpness_key_elongation(later, 3), back);
        assert_eq!(sharpness_key_elongation(key, 4), 0.0);
    }
    assert_eq!(sharpness_key_elongation(NEVER_SEEN, 0), 0.0);
    // A step of blur counts for more than any direction.
    let sharper = sharpness_key_encode(1e-3, 1.0, 0, 0);
    let blurred = sharpness_key_encode(1.0005e-3, -1.0, 0, 0);
    assert!(sharper < blurred);
    // The shorter diameter of the longer one, to 1.3 %.
    for step in 0..=400 {
        let elongation = f64::from(step) / 400.0;
        let back = sharpness_key_elongation(sharpness_key_encode(1e-3, elongation, 0, 0), 0);
        let ratio = |e: f64| ((1.0 - e) / (1.0 + e)).sqrt();
        assert!(
            (ratio(back) - ratio(elongation)).abs() < 0.013,
            "{elongation}"
        );
    }
}

#[test]
fn a_newer_epoch_wins_and_an_older_one_is_unseen() {
    let sharp_but_old = sharpness_key_encode(1e-6, 1.0, 0, 3);
    let blurred_but_new = sharpness_key_encode(8.0, -1.0, 0, 4);
    assert!(blurred_but_new < sharp_but_old);
    assert_eq!(sharpness_key_decode(sharp_but_old, 0, 4, CAP), CAP);
    assert_eq!(sharpness_key_decode(NEVER_SEEN, 0, 0, CAP), CAP);
}

#[test]
fn odd_input_stays_finite() {
    for coc in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, 1e300] {
        for steps in [0, STARVE_STEPS_MAX, u32::MAX] {
            for elongation in [0.0, f64::NAN, 2.0, f64::NEG_INFINITY] {
                let key = sharpness_key_encode(coc, elongation, steps, 255);
                assert!((key >> ELONGATION_BITS) & 0x1F_FFFF <= VALUE_MAX);
                assert!(sharpness_key_decode(key, u32::MAX, 255, CAP) <= CAP);
                assert!(sharpness_key_elongation(key, 255).abs() <= 1.0);
            }
        }
    }
    let mut clock = SharpnessClock::default();
    for (dt, rate) in [
        (f64::NAN, 0.3),
        (0.1, f64::INFINITY),
        (-1.0, 0.3),
        (0.1, -0.3),
        (-1.0, -1.0),
        (0.0, 0.3),
    ] {
        assert_eq!(clock.advance(dt, rate), None);
    }
    assert_eq!(clock, SharpnessClock::default());
    assert_eq!(
        sharpness_voxel([0.0; 3], [0.0, 0.0, -1.0], f64::NAN, 0.01, 0.01)[3],
        LEVEL_SKY
    );
}

#[test]
fn two_hours_without_a_blink_and_300_blinks_keep_what_they_should() {
    let mut clock = SharpnessClock::default();
    let mut field = SparseField::default();
    let (mut rebases, mut nats) = (0, 0.0);
    assert_eq!(clock.blink(), None);
    for _ in 0..2000 {
        field.update([0; 4], 1e-3, &clock);
        if let Some(rebase) = clock.advance(10.0, 0.6) {
            field.rebase(rebase, &clock);
            rebases += 1;
        }
        nats += 6.0;
        // Six nats after the visit: 403 times the blur.
        let read = field.read([0; 4], &clock, 1.0);
        assert!(
            (read / (1e-3 * 6.0_f64.exp())).ln().abs() <= KEY_RELATIVE_ERROR,
            "{nats} {read}"
        );
    }
    // 12,000 nats, 391 to a pass.
    assert_eq!(rebases, 30);
    assert_eq!(clock.epoch(), 1);
    let mut passes = 0;
    for _ in 0..300 {
        field.update([0; 4], 1e-3, &clock);
        assert!(field.read([0; 4], &clock, CAP) < 1.001e-3);
        if let Some(rebase) = clock.blink() {
            field.rebase(rebase, &clock);
            passes += 1;
        }
        assert_eq!(field.read([0; 4], &clock, CAP), CAP);
    }
    assert_eq!(passes, 18);
}

fn unit(rng: &mut Pcg32) -> [f64; 3] {
    let z = rng.random_range(-1.0..1.0_f64);
    let a = rng.random_range(0.0..std::f64::consts::TAU);
    let r = (1.0 - z * z).sqrt();
    [r * a.cos(), r * a.sin(), z]
}

#[test]
fn voxels_span_between_a_half_and_one_voxel_angle() {
    let mut rng = Pcg32::seed_from_u64(5);
    for _ in 0..10_000 {
        let d = unit(&mut rng);
        let distance = rng.random_range(-7.0..6.9_f64).exp();
        let voxel = sharpness_voxel([0.0; 3], d, 1.0 / distance, 0.0, 0.01);
        let side = 0.01 * f64::from(voxel[3]).exp2();
        assert!(side / distance <= 0.010_001 && side / distance >= 0.004_999);
        for i in 0..3 {
            let inside = d[i] * distance / side - f64::from(voxel[i]);
            assert!((-1e-6..=1.000_001).contains(&inside));
        }
    }
}

#[test]
fn the_sky_has_voxels_by_direction_and_the_grid_is_fixed_in_the_world() {
    let a = sharpness_voxel([0.0; 3], [0.0, 0.6, -0.8], 0.0, 0.01, 0.005);
    let b = sharpness_voxel([5.0, 1.0, 2.0], [0.0, 0.6, -0.8], 1e-4, 0.0, 0.005);
    assert_eq!(a, b);
    assert_ne!(
        a,
        sharpness_voxel([0.0; 3], [0.0, 0.8, -0.6], 0.0, 0.01, 0.005)
    );
    // The same point seen from two places, on the uniform grid and by distance.
    for size in [0.01, 0.0] {
        let from_origin = sharpness_voxel([0.0; 3], [0.0, 0.0, -1.0], 1.0 / 2.005, size, 0.005);
        let from_aside =
            sharpness_voxel([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0 / 3.005, size, 0.005);
        assert_eq!(from_origin, from_aside);
    }
}

#[test]
fn memory_follows_what_was_seen_not_the_rooms_size() {
    // The same 100 x 100 rays into a room and into one of eight times its volume.
    let seen = |scale: f64| {
        let mut field = SparseField::default();
        let clock = SharpnessClock::default();
        for i in 0..10_000 {
            let (x, y) = (
                f64::from(i % 100) / 100.0 - 0.5,
                f64::from(i / 100) / 100.0 - 0.5,
            );
            let n = (1.0 + x * x + y * y).sqrt();
            let voxel = sharpness_voxel(
                [0.0; 3],
                [x / n, y / n, -1.0 / n],
                1.0 / (3.0 * scale * n),
                0.0,
                0.02,
            );
            field.update(voxel, 1e-3, &clock);
        }
        field.len()
    };
    assert_eq!(seen(1.0), seen(2.0));
    assert!(seen(1.0) <= 10_000 && seen(1.0) > 2_000);
}

#[test]
fn a_hundred_thousand_voxels_get_different_names_spread_evenly() {
    let mut names = std::collections::HashSet::new();
    let mut homes = vec![0u32; 1024];
    for x in 0..47 {
        for y in 0..47 {
            for z in 0..47 {
                let [tag, home] = sharpness_voxel_hash([x - 23, y - 23, z - 23, 1000]);
                assert_ne!(tag, 0);
                assert!(names.insert((tag, home)));
                homes[home as usize % 1024] += 1;
            }
        }
    }
    // Chi-squared with 1023 degrees of freedom: mean 1023, standard deviation 45.
    let mean = f64::from(47 * 47 * 47) / 1024.0;
    let chi2: f64 = homes
        .iter()
        .map(|n| (f64::from(*n) - mean).powi(2) / mean)
        .sum();
    assert!((chi2 - 1023.0).abs() < 5.0 * 45.3, "{chi2}");
}
