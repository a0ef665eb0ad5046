//! What an iris map must be, whatever the seed.

use super::*;

const SIZE: (usize, usize) = (768, 192);

fn map(settings: &IrisMapSettings) -> IrisMap {
    IrisMap::new(settings, SIZE.0, SIZE.1)
}

fn seeded(seed: u32) -> IrisMapSettings {
    IrisMapSettings {
        seed,
        ..IrisMapSettings::default()
    }
}

/// Sum of absolute differences of thickness between neighbours `(dx, dy)` texels apart, per mm.
fn gradient_per_mm(map: &IrisMap, from: f32, to: f32, radial: bool) -> f64 {
    let (mut sum, mut count) = (0.0_f64, 0.0);
    for j in 0..map.height - 1 {
        let v = (j as f32 + 0.5) / map.height as f32;
        if !(from..to).contains(&v) {
            continue;
        }
        for i in 0..map.width {
            let here = map.texels[j * map.width + i][0];
            let (there, distance_mm) = if radial {
                let below = map.texels[(j + 1) * map.width + i][0];
                (below, DESIGN_WIDTH_MM / map.height as f32)
            } else {
                let right = map.texels[j * map.width + (i + 1) % map.width][0];
                (right, TAU * radius_mm(v) / map.width as f32)
            };
            sum += f64::from((here - there).abs() / distance_mm);
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn same_seed_same_map_and_other_seed_other_map() {
    let (first, again, other) = (map(&seeded(5)), map(&seeded(5)), map(&seeded(6)));
    assert_eq!(first, again);
    let differing = first
        .texels
        .iter()
        .zip(&other.texels)
        .filter(|(a, b)| (a[0] - b[0]).abs() > 0.02)
        .count();
    // Two people share the mean profile, not the strands.
    assert!(differing * 2 > first.texels.len(), "{differing}");
}

#[test]
fn every_channel_stays_in_its_range_for_legal_and_illegal_settings() {
    let wild = IrisMapSettings {
        seed: u32::MAX,
        collarette_radius: f32::NAN,
        collarette_irregularity: 9.0,
        crypt_density: f32::INFINITY,
        fibre_count: u32::MAX,
        waviness: -4.0,
        furrow_count: 99,
        central_heterochromia: 7.0,
        ring_melanin: f32::INFINITY,
        freckle_count: 10_000,
        border_layer_cover: f32::NEG_INFINITY,
        own_melanin: f32::NAN,
        sector: [7.0, f32::NAN],
    };
    let open = IrisMapSettings {
        crypt_density: 1.0,
        collarette_radius: 0.2,
        collarette_irregularity: 1.0,
        waviness: 1.0,
        border_layer_cover: 0.0,
        ..seeded(2)
    };
    let closed = IrisMapSettings {
        crypt_density: 0.0,
        fibre_count: 60,
        furrow_count: 0,
        freckle_count: 0,
        border_layer_cover: 1.0,
        ..seeded(3)
    };
    for settings in [wild, open, closed, seeded(0)] {
        for &[thickness, melanin, height, furrow] in &map(&settings).texels {
            assert!((MIN_THICKNESS_MM..=MAX_THICKNESS_MM).contains(&thickness));
            assert!((0.0..=1.0).contains(&melanin));
            assert!((-0.6..=0.4).contains(&height), "{height}");
            assert!(furrow.abs() < 0.2, "{furrow}");
        }
    }
}

#[test]
fn clamping_keeps_legal_settings_and_mends_the_rest() {
    assert_eq!(seeded(3).clamped(), seeded(3));
    let bad = IrisMapSettings {
        waviness: f32::NAN,
        collarette_radius: 0.9,
        fibre_count: 1,
        ..seeded(3)
    };
    let mended = bad.clamped();
    assert_eq!(mended.waviness, IrisMapSettings::default().waviness);
    assert_eq!((mended.collarette_radius, mended.fibre_count), (0.5, 60));
}

#[test]
fn the_seam_is_as_smooth_as_any_other_column() {
    let map = map(&seeded(8));
    let step = |i: usize| -> f64 {
        let next = (i + 1) % map.width;
        (0..map.height)
            .map(|j| {
                let (a, b) = (
                    map.texels[j * map.width + i],
                    map.texels[j * map.width + next],
                );
                (0..4).map(|c| f64::from((a[c] - b[c]).abs())).sum::<f64>()
            })
            .sum()
    };
    let steps: Vec<f64> = (0..map.width - 1).map(step).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let largest = steps.iter().copied().fold(0.0, f64::max);
    let seam = step(map.width - 1);
    // No worse than the roughest inner column and of the order of the mean.
    assert!(seam <= largest.max(2.0 * mean), "{seam} against {mean}");
}

#[test]
fn mean_profile_passes_through_the_published_places() {
    // Pavlin et al. 1992 as printed in François' figure 5.
    let places = [
        (0.16, 0.645),
        (1.0 - 2.0 / 4.1, 0.457),
        (1.0 - 0.5 / 4.1, 0.372),
    ];
    for (v, published) in places {
        assert!((mean_thickness_mm(v) - published).abs() < 2e-4);
    }
    for step in 0..=1_000 {
        let v = step as f32 / 1_000.0;
        let jump = mean_thickness_mm(v + 1e-3) - mean_thickness_mm(v);
        assert!(jump.abs() < 4e-3 && mean_thickness_mm(v) > 0.2);
    }
}

#[test]
fn rows_average_to_the_published_thickness() {
    for seed in 1..5 {
        let map = map(&seeded(seed));
        // Published standard deviations: 0.103, 0.080, 0.058 mm; a map stays within one.
        for (v, published, spread) in [
            (0.16_f32, 0.645, 0.103),
            (0.512, 0.457, 0.080),
            (0.878, 0.372, 0.058),
        ] {
            let rows = ((v - 0.02) * map.height as f32) as usize
                ..((v + 0.02) * map.height as f32) as usize;
            let texels = &map.texels[rows.start * map.width..rows.end * map.width];
            let mean = texels.iter().map(|t| t[0]).sum::<f32>() / texels.len() as f32;
            assert!((mean - published).abs() < spread, "{seed} {v}: {mean}");
        }
    }
}

#[test]
fn crypts_open_with_their_density() {
    let thin_share = |density: f32| {
        let settings = IrisMapSettings {
            crypt_density: density,
            ..seeded(4)
        };
        let map = map(&settings);
        let thin = |t: &&[f32; 4]| t[0] < 0.15 && t[3] < 0.05;
        map.texels.iter().filter(thin).count() as f32 / map.texels.len() as f32
    };
    let (none, usual, lacunar) = (thin_share(0.0), thin_share(0.5), thin_share(1.0));
    assert!((0.03..0.2).contains(&usual), "{usual}");
    assert!(
        none + 0.01 < usual && usual + 0.01 < lacunar,
        "{none} {usual} {lacunar}"
    );
}

#[test]
fn strands_run_radially() {
    for seed in 1..4 {
        let map = map(&seeded(seed));
        for (from, to) in [(0.06, 0.24), (0.5, 0.9)] {
            let round = gradient_per_mm(&map, from, to, false);
            let outward = gradient_per_mm(&map, from, to, true);
            assert!(round > 2.0 * outward, "{seed}: {round} against {outward}");
        }
    }
}

#[test]
fn the_ruff_is_a_tenth_of_a_millimetre_and_black() {
    let map = map(&seeded(9));
    // Where there is no stroma, but pigment.
    let bare = |t: &&[f32; 4]| t[0] < 1.5 * MIN_THICKNESS_MM && t[1] > 0.9;
    let covered = map.texels.iter().filter(bare).count() as f32;
    let width_mm = covered / map.width as f32 * DESIGN_WIDTH_MM / map.height as f32;
    assert!((0.05..0.16).contains(&width_mm), "{width_mm}");
    let edge = &map.texels[..map.width];
    assert!(edge.iter().all(|t| bare(&t)));
}

#[test]
fn heterochromia_gathers_pigment_at_the_collarette() {
    let contrast = |amount: f32| {
        let map = map(&IrisMapSettings {
            central_heterochromia: amount,
            freckle_count: 0,
            ..seeded(7)
        });
        let mean = |from: f32, to: f32| {
            let (a, b) = ((from * 192.0) as usize, (to * 192.0) as usize);
            let rows = &map.texels[a * map.width..b * map.width];
            rows.iter().map(|t| t[1]).sum::<f32>() / rows.len() as f32
        };
        mean(0.28, 0.38) - mean(0.7, 0.9)
    };
    assert!(contrast(1.0) > contrast(0.0) + 0.2);
}

#[test]
fn sampling_wraps_and_meets_texel_centres() {
    let map = map(&seeded(1));
    let centre = map.sample(10.5 / 768.0, 20.5 / 192.0);
    let texel = map.texels[20 * 768 + 10];
    assert!((centre.thickness_mm - texel[0]).abs() < 1e-4);
    let (a, b) = (map.sample(-0.25, 0.4), map.sample(0.75, 0.4));
    assert!((a.height_mm - b.height_mm).abs() < 1e-4);
    let seam = map.sample(0.0, 0.5).thickness_mm;
    let mean = |j: usize| 0.5 * (map.texels[j * 768][0] + map.texels[j * 768 + 767][0]);
    assert!((seam - 0.5 * (mean(95) + mean(96))).abs() < 1e-4);
    assert!(map.sample(0.3, 7.0).thickness_mm.is_finite());
}

#[test]
fn levels_begin_with_the_map() {
    let map = IrisMap::new(&seeded(1), 256, 64);
    let levels = map.levels();
    assert_eq!((levels[0].0, levels[0].1, levels.len()), (256, 64, 9));
    assert_eq!(levels[0].2, map.texels);
}

#[test]
fn a_sector_is_as_dense_as_a_brown_iris_and_the_rest_keeps_its_own() {
    let own = IrisMapSettings {
        own_melanin: 0.04,
        freckle_count: 0,
        ..seeded(5)
    };
    let sector = IrisMapSettings {
        sector: [0.25, 0.1],
        ..own.clone()
    };
    let (own, sector) = (map(&own), map(&sector));
    let mean = |map: &IrisMap, from: f32, to: f32| {
        let places = (0..200).flat_map(|i| (2..9).map(move |j| (i, j)));
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, j) in places {
            let u = from + (to - from) * (i as f32 + 0.5) / 200.0;
            sum += map.sample(u, j as f32 * 0.1).border_melanin;
            count += 1.0;
        }
        sum / count
    };
    assert!(
        mean(&sector, 0.18, 0.32) > 0.4,
        "{}",
        mean(&sector, 0.18, 0.32)
    );
    assert!(mean(&own, 0.18, 0.32) < 0.04);
    // Beyond its ragged border nothing has changed.
    for (from, to) in [(0.4, 0.9), (0.0, 0.12)] {
        assert!((mean(&sector, from, to) - mean(&own, from, to)).abs() < 1e-6);
    }
}

#[test]
fn another_pigment_on_a_grown_stroma_is_the_map_of_that_iris() {
    let pale = seeded(11);
    let dark = IrisMapSettings {
        border_layer_cover: 0.45,
        central_heterochromia: 0.2,
        freckle_count: 9,
        own_melanin: 0.6,
        sector: [0.3, 0.1],
        ..pale.clone()
    };
    let stroma = IrisStroma::new(&pale, 256, 64);
    let fresh = IrisMap::new(&dark, 256, 64);
    assert_eq!(stroma.pigmented(&dark), fresh);
    assert_ne!(stroma.pigmented(&pale), fresh);
    assert!(stroma.fits(&dark, 256, 64) && !stroma.fits(&dark, 512, 64));
    let others = [
        seeded(12),
        IrisMapSettings {
            crypt_density: 0.9,
            ..dark.clone()
        },
        IrisMapSettings {
            furrow_count: 1,
            ..dark
        },
    ];
    assert!(others.iter().all(|other| !stroma.fits(other, 256, 64)));
}
