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
    assert_ne!(first.vessel_mask, grow(4, &settings, 256).vessel_mask);
}

#[test]
fn every_channel_stays_in_its_range_even_for_illegal_settings() {
    let wild = ScleraMapSettings {
        age_years: f32::NAN,
        redness: f32::INFINITY,
        nasal_sign: f32::NAN,
        seed: 0,
    };
    let old = ScleraMapSettings {
        age_years: 1e9,
        redness: 1.0,
        nasal_sign: 1.0,
        seed: 0,
    };
    for settings in [wild, old, ScleraMapSettings::default()] {
        let map = grow(1, &settings, 200);
        for [red, green, blue, height] in &map.texels {
            assert!([red, green, blue].iter().all(|c| (0.0..=1.0).contains(*c)));
            assert!(height.abs() < 0.08, "{height}");
        }
        assert!(map.vessel_mask.iter().all(|m| (0.0..=1.0).contains(m)));
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
            open[0] > open[1] && open[1] > open[2] && open[2] > 0.4,
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
        map.vessel_mask.iter().sum::<f32>() / map.vessel_mask.len() as f32
    };
    let (calm, inflamed) = (cover(0.1), cover(0.9));
    assert!((0.003..0.08).contains(&calm), "{calm}");
    assert!(inflamed > 1.8 * calm, "{calm} {inflamed}");
}

#[test]
fn blood_is_kept_when_the_map_shrinks() {
    // The same vessels at half the size hold the same blood: mean optical density is preserved.
    let blood = |size| {
        let grown = vessels::grow(5, &ScleraMapSettings::default(), size);
        grown.sharp.iter().sum::<f32>() / grown.sharp.len() as f32
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
    let map = grow(6, &ScleraMapSettings::default(), 256);
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
    let map = grow(1, &ScleraMapSettings::default(), 101);
    let [x, y] = place_of(40, 70, 101);
    for (sampled, texel) in map.sample(x, y).iter().zip(map.texels[70 * 101 + 40]) {
        assert!((sampled - texel).abs() < 1e-4);
    }
    assert!(map.sample(500.0, -500.0).iter().all(|c| c.is_finite()));
    let levels = grow(1, &ScleraMapSettings::default(), 128).levels();
    let texels = levels.iter().map(|level| level.2.len());
    assert_eq!((levels.len(), texels.sum::<usize>()), (8, 21_845));
}
