use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

/// The definition, word for word: a corner at t has an arc of nine beyond t; the score is found by
/// trying every larger threshold.
fn oracle(gray: &[u8], w: usize, h: usize, t: u8, nms: bool) -> Vec<Corner> {
    // The circle again, from its equation rather than from the table under test.
    let mut circle: Vec<(i32, i32)> = (-3..=3i32)
        .flat_map(|y| (-3..=3i32).map(move |x| (x, y)))
        .filter(|(x, y)| (3.0 - f64::from(x * x + y * y).sqrt()).abs() < 0.5)
        .collect();
    circle.sort_by(|a, b| {
        f64::from(a.1)
            .atan2(f64::from(a.0))
            .total_cmp(&f64::from(b.1).atan2(f64::from(b.0)))
    });
    assert_eq!(circle.len(), 16);
    let is_corner = |x: usize, y: usize, t: i32| {
        let c = i32::from(gray[y * w + x]);
        let v: Vec<i32> = circle
            .iter()
            .map(|(dx, dy)| {
                i32::from(gray[(y as i32 + dy) as usize * w + (x as i32 + dx) as usize])
            })
            .collect();
        (0..16).any(|s| {
            (0..9).all(|k| v[(s + k) % 16] > c + t) || (0..9).all(|k| v[(s + k) % 16] < c - t)
        })
    };
    let score = |x: usize, y: usize| -> Option<i32> {
        if x < 3 || y < 3 || x + 3 >= w || y + 3 >= h || !is_corner(x, y, i32::from(t)) {
            return None;
        }
        (i32::from(t)..256)
            .take_while(|s| is_corner(x, y, *s))
            .last()
    };
    let mut out = Vec::new();
    for y in 0..h {
        for x in 0..w {
            let Some(s) = score(x, y) else { continue };
            let survives = (-1..=1i32).all(|dy| {
                (-1..=1i32).all(|dx| {
                    (dx, dy) == (0, 0)
                        || s > score((x as i32 + dx) as usize, (y as i32 + dy) as usize)
                            .unwrap_or(0)
                })
            });
            if !nms || survives {
                out.push(Corner {
                    x: x as u32,
                    y: y as u32,
                    score: s as u8,
                });
            }
        }
    }
    out
}

fn same_as_oracle(gray: &[u8], w: usize, h: usize) -> usize {
    let mut found = 0;
    for t in [0, 1, 7, 20, 60, 254, 255] {
        for nms in [false, true] {
            let corners = detect(gray, w, h, t, nms).unwrap();
            assert_eq!(
                corners,
                oracle(gray, w, h, t, nms),
                "{w}x{h} t {t} nms {nms}"
            );
            found += corners.len();
        }
    }
    found
}

#[test]
fn noise_of_every_contrast_matches_the_definition() {
    let mut rng = Pcg32::seed_from_u64(9);
    let mut found = 0;
    for (levels, step) in [(256u32, 1u32), (2, 255), (3, 100), (2, 1), (5, 8), (16, 16)] {
        for (w, h) in [(40, 30), (7, 40), (22, 9), (23, 23)] {
            let gray: Vec<u8> = (0..w * h)
                .map(|_| (rng.random_range(0..levels) * step).min(255) as u8)
                .collect();
            found += same_as_oracle(&gray, w, h);
        }
    }
    assert!(found > 1000, "{found} corners prove little");
}

#[test]
fn shapes_gradients_and_ties_match_the_definition() {
    let (w, h) = (37, 29);
    let image = |f: &dyn Fn(i32, i32) -> i32| -> Vec<u8> {
        (0..w * h)
            .map(|i| f((i % w) as i32, (i / w) as i32).clamp(0, 255) as u8)
            .collect()
    };
    let mut found = 0;
    for gray in [
        image(&|_, _| 128),
        image(&|_, _| 0),
        image(&|_, _| 255),
        image(&|x, _| 7 * x),
        image(&|x, y| 255 - 4 * x - 3 * y),
        image(&|x, y| if (x / 5 + y / 5) % 2 == 0 { 255 } else { 0 }),
        image(&|x, y| if x % 9 < 2 && y % 9 < 2 { 200 } else { 30 }),
        image(&|x, y| if x > 12 && y > 9 { 220 } else { 40 }),
        image(&|x, y| {
            if (x - 18).pow(2) + (y - 14).pow(2) < 40 {
                10
            } else {
                90
            }
        }),
    ] {
        found += same_as_oracle(&gray, w, h);
    }
    assert!(found > 100, "{found} corners prove little");
}

#[test]
fn the_smallest_images_match_the_definition() {
    let mut rng = Pcg32::seed_from_u64(3);
    for w in 1..=8 {
        for h in 1..=8 {
            for _ in 0..20 {
                let mut gray: Vec<u8> = (0..w * h).map(|_| rng.random_range(200..=255u8)).collect();
                if w > 3 && h > 3 {
                    gray[3 * w + 3] = 0;
                }
                let found = same_as_oracle(&gray, w, h);
                assert_eq!(found > 0, w >= 7 && h >= 7);
            }
        }
    }
    assert_eq!(detect(&[], 0, 0, 20, true), Ok(vec![]));
    assert_eq!(detect(&[], 0, 9, 20, true), Ok(vec![]));
}

#[test]
fn of_a_tie_none_survives() {
    let mut gray = vec![0u8; 20 * 20];
    gray[10 * 20 + 9] = 200;
    assert_eq!(
        detect(&gray, 20, 20, 20, true).unwrap(),
        [Corner {
            x: 9,
            y: 10,
            score: 199
        }]
    );
    gray[10 * 20 + 10] = 200;
    assert_eq!(detect(&gray, 20, 20, 20, false).unwrap().len(), 2);
    assert_eq!(detect(&gray, 20, 20, 20, true).unwrap(), []);
}

#[test]
fn a_wrong_size_is_an_error_that_says_so() {
    let error = detect(&[0; 10], 3, 4, 20, true).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a grey image of 3 x 4 pixels has 3 x 4 bytes, not 10"
    );
    assert!(detect(&[0; 10], usize::MAX, 2, 20, true).is_err());
}

#[test]
fn luma_keeps_grey_and_rounds() {
    for v in 0..=255 {
        assert_eq!(luma_of_srgb8([v, v, v]), v);
    }
    assert_eq!(luma_of_srgb8([255, 0, 0]), 54); // 54.213
    assert_eq!(luma_of_srgb8([0, 255, 0]), 182); // 182.376
    assert_eq!(luma_of_srgb8([0, 0, 255]), 18); // 18.411
}
