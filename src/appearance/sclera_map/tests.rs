//! What a sclera map must be, whatever the seed.

use super::*;

fn grow(seed: u32, settings: &ScleraMapSettings, size: usize) -> ScleraMap {
    let settings = ScleraMapSettings {
        seed,
        ..settings.clone()
    };
    ScleraMap::new(&settings, size)
}

fn mean_in(map: &ScleraMap, inside: impl Fn(f32, f32) -> bool) -> [f32; 4] {
    let (mut sum, mut count) = ([0.0_f32; 4], 0.0_f32);
    for (index, texel) in map.texels.iter().enumerate() {
        let [x, y] = place_of(index % map.size, index / map.size, map.size);
        if inside(x, y) {
            sum.iter_mut().zip(texel).for_each(|(s, t)| *s += t);
            count += 1.0;
        }
    }
    assert!(count > 0.0);
    sum.map(|s| s / count)
}

#[test]
fn same_seed_same_map_and_other_seed_other_vessels() {
    let settings = ScleraMapSettings::default();
    let (first, again) = (grow(3, &settings, 256), grow(3, &settings, 256));
    assert_eq!(first, again);
    assert_ne!(first.vessels, grow(4, &settings, 256).vessels);
}

#[test]
fn every_channel_stays_in_its_range_even_for_illegal_settings() {
    let wild = ScleraMapSettings {
        age_years: f32::NAN,
        redness: f32::INFINITY,
        nasal_sign: f32::NAN,
        bilirubin_mg_dl: f32::NAN,
        pinguecula: f32::NEG_INFINITY,
        flush_radius: f32::NAN,
        flush_hardness: f32::INFINITY,
        melanin: f32::NAN,
        seed: 0,
    };
    let old = ScleraMapSettings {
        age_years: 1e9,
        redness: 1.0,
        nasal_sign: 1.0,
        bilirubin_mg_dl: 1e9,
        pinguecula: 1.0,
        flush_radius: 9.0,
        flush_hardness: 1e9,
        melanin: 1e9,
        seed: 0,
    };
    for settings in [wild, old, ScleraMapSettings::default()] {
        let map = grow(1, &settings, 200);
        for [red, green, blue, _] in &map.texels {
            assert!([red, green, blue].iter().all(|c| (0.0..=1.0).contains(*c)));
        }
        for [shallow, deep, height, _] in &map.vessels {
            assert!((0.0..1.0).contains(shallow) && (0.0..1.0).contains(deep));
            assert!(height.abs() < 0.13, "{height}");
        }
    }
}

#[test]
fn white_is_warm_and_the_canthi_are_yellower_and_the_limbus_bluer() {
    for seed in 0..4 {
        let map = grow(seed, &ScleraMapSettings::default(), 256);
        let open = mean_in(&map, |x, y| {
            (42.0..48.0).contains(&x.hypot(y)) && x.abs() < 20.0
        });
        let canthus = mean_in(&map, |x, y| {
            (55.0..75.0).contains(&x.abs()) && y.abs() < 15.0
        });
        let limbus = mean_in(&map, |x, y| (LIMBUS_DEG..34.0).contains(&x.hypot(y)));
        let blue_over_red = |c: [f32; 4]| c[2] / c[0];
        assert!(
            open[0] > open[1] && open[1] > open[2] && open[2] > 0.3,
            "{open:?}"
        );
        assert!(blue_over_red(canthus) < blue_over_red(open) - 0.05);
        assert!(blue_over_red(limbus) > blue_over_red(open) + 0.03);
    }
}

#[test]
fn healthy_vessels_are_sparse_and_redness_adds_to_them() {
    let cover = |redness: f32| {
        let settings = ScleraMapSettings {
            redness,
            ..ScleraMapSettings::default()
        };
        let map = grow(2, &settings, 512);
        let green = |v: &[f32; 4]| 1.0 - (-18.8 * v[0]).exp();
        map.vessels.iter().map(green).sum::<f32>() / map.vessels.len() as f32
    };
    let (calm, inflamed) = (cover(0.1), cover(0.9));
    assert!((0.003..0.08).contains(&calm), "{calm}");
    assert!(inflamed > 1.8 * calm, "{calm} {inflamed}");
    // More of them and wider: 3.2 times as many, each with 2.7 times the blood.
    let volume = |redness: f32| {
        let settings = ScleraMapSettings {
            redness,
            ..ScleraMapSettings::default()
        };
        let map = grow(2, &settings, 512);
        map.vessels.iter().map(|v| v[0]).sum::<f32>()
    };
    let ratio = volume(0.9) / volume(0.1);
    assert!((5.0..10.0).contains(&ratio), "{ratio}");
}

#[test]
fn blood_is_kept_when_the_map_shrinks() {
    // The same vessels at half the size hold the same blood.
    let blood = |size| {
        let grown = vessels::grow(5, &ScleraMapSettings::default(), size, size / COARSER);
        grown.shallow.iter().sum::<f32>() / grown.shallow.len() as f32
    };
    let (large, small) = (blood(1024), blood(256));
    // Cut-off dabs at 2.6 sigma and the texel floor leave a few percent.
    assert!((large / small - 1.0).abs() < 0.1, "{large} {small}");
}

#[test]
fn ages_yellow() {
    let tint = |age: f32| {
        let settings = ScleraMapSettings {
            age_years: age,
            ..ScleraMapSettings::default()
        };
        let map = grow(2, &settings, 128);
        let mean = mean_in(&map, |x, y| (40.0..70.0).contains(&x.hypot(y)));
        mean[2] / mean[0]
    };
    assert!(tint(5.0) > tint(35.0) && tint(35.0) > tint(85.0) + 0.02);
}

#[test]
fn there_is_no_seam_where_the_angle_wraps() {
    let map = grow(6, &ScleraMapSettings::default(), 1024);
    let step = |row: usize| -> f32 {
        (0..80)
            .map(|i| {
                let (a, b) = (map.texels[row * 256 + i], map.texels[(row + 1) * 256 + i]);
                (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>()
            })
            .sum()
    };
    let usual = (100..156).map(step).sum::<f32>() / 56.0;
    assert!(step(127) < 2.0 * usual, "{} {usual}", step(127));
}

#[test]
fn sampling_meets_texels_and_levels_go_down_to_one() {
    let map = grow(1, &ScleraMapSettings::default(), 404);
    let [x, y] = place_of(40, 70, 101);
    for (sampled, texel) in map.sample(x, y).iter().zip(map.texels[70 * 101 + 40]) {
        assert!((sampled - texel).abs() < 1e-4);
    }
    assert!(map.sample(500.0, -500.0).iter().all(|c| c.is_finite()));
    let map = grow(1, &ScleraMapSettings::default(), 128);
    let count = |levels: Vec<Level<4>>| {
        let texels = levels.iter().map(|level| level.2.len());
        (levels.len(), texels.sum::<usize>())
    };
    assert_eq!(count(map.vessel_levels()), (8, 21_845));
    assert_eq!(count(map.levels()), (6, 1_365));
}

#[test]
fn jaundice_yellows_and_a_pinguecula_is_raised_and_yellow() {
    let of = |change: fn(&mut ScleraMapSettings)| {
        let mut settings = ScleraMapSettings::default();
        change(&mut settings);
        grow(2, &settings, 512)
    };
    let blue = |map: &ScleraMap, x: f32, y: f32| {
        let c = map.sample(x, y);
        c[2] / c[0]
    };
    let (usual, jaundiced, raised) = (
        of(|_| {}),
        of(|s| s.bilirubin_mg_dl = 12.0),
        of(|s| s.pinguecula = 1.0),
    );
    assert!(blue(&jaundiced, 45.0, 10.0) < 0.75 * blue(&usual, 45.0, 10.0));
    // Nasal of a right eye is −x.
    assert!(blue(&raised, -39.0, -1.5) < 0.85 * blue(&usual, -39.0, -1.5));
    assert!((blue(&raised, 0.0, 60.0) / blue(&usual, 0.0, 60.0) - 1.0).abs() < 1e-3);
    let height = |map: &ScleraMap, x: f32, y: f32| {
        let texel = |v: f32, sign: f32| ((1.0 + sign * v / MAP_EDGE_DEG) * 256.0) as usize;
        map.vessels[texel(y, -1.0) * 512 + texel(x, 1.0)][2]
    };
    assert!(height(&raised, -39.0, -1.5) > height(&usual, -39.0, -1.5) + 0.05);
}

/// What the shader holds of slopes that a pixel does not see (`unseen_slopes`) is what the levels of this map have lost of them, about
/// the fissure.
#[test]
fn the_slopes_of_the_wet_white_are_those_that_its_shine_is_told_of() {
    use crate::appearance::shading::sclera_shade::{SCLERA_HALF_ANGLE, unseen_slopes};
    for seed in 0..3 {
        let map = grow(seed, &ScleraMapSettings::default(), 2048);
        let texel = 2.0 * SCLERA_HALF_ANGLE * 11.5 / 2048.0;
        let variance = |level: usize| {
            let (side, _, texels) = &map.vessel_levels()[level];
            let side = *side as usize;
            let run = texel * f64::from(1_u32 << level);
            let (mut sum, mut count) = (0.0, 0.0);
            for row in 1..side - 1 {
                for column in 1..side - 1 {
                    let [x, y] = place_of(column, row, side);
                    if x.abs() < 75.0 && y.abs() < 35.0 && x.hypot(y) > LIMBUS_DEG + 4.0 {
                        let here = texels[row * side + column][2];
                        let right = f64::from(texels[row * side + column + 1][2] - here) / run;
                        let below = f64::from(texels[(row + 1) * side + column][2] - here) / run;
                        sum += 0.5 * (right * right + below * below);
                        count += 1.0;
                    }
                }
            }
            sum / count
        };
        let all = variance(0);
        let everything = unseen_slopes(1e6);
        assert!(
            (all / everything - 1.0).abs() < 0.1,
            "{seed}: {all} {everything}"
        );
        // Half of the slopes less far away or twice as far would be off by 0.2.
        for level in 1..6 {
            let told = unseen_slopes(texel * f64::from(1_u32 << level)) / everything;
            let lost = 1.0 - variance(level) / all;
            assert!((told - lost).abs() < 0.06, "{seed}, {level}: {told} {lost}");
        }
    }
}
