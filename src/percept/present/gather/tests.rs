use super::*;

#[test]
fn sigma_is_that_of_the_disc_it_stands_for() {
    // Variance of a uniform disc along x, integrated in rings: R^2/4 = d^2/16.
    let (d, n) = (7.0, 100_000);
    let (mut moment, mut area) = (0.0, 0.0);
    for i in 0..n {
        let r = (f64::from(i) + 0.5) / f64::from(n) * d / 2.0;
        moment += r * r * r / 2.0;
        area += r;
    }
    assert!((moment / area - (d / 4.0_f64).powi(2)).abs() < 1e-6);
}

#[test]
fn the_window_is_the_closed_form() {
    let (h, n) = (GAUSSIAN_WINDOW, 100_000);
    assert!((GAUSSIAN_WINDOW_EDGE - (-0.5 * h * h).exp()).abs() < 1e-9);
    let (mut weight, mut moment) = (0.0, 0.0);
    for i in 0..n {
        let u = (f64::from(i) + 0.5) / f64::from(n) * h;
        let here = gaussian_window(gaussian_steps(u, 1.0)[0]);
        weight += here;
        moment += here * u * u;
    }
    let variance = moment / weight;
    assert!(
        (GAUSSIAN_WINDOW_VARIANCE - variance).abs() < 1e-7,
        "{variance}"
    );
}

/// Levels of the mips of a row of pixels: each the one before under (1, 3, 3, 1)/8.
fn mips(row: Vec<f64>, levels: usize) -> Vec<f64> {
    (0..levels).fold(row, |fine, _| {
        let at = |i: isize| fine[i.clamp(0, fine.len() as isize - 1) as usize];
        (0..fine.len() as isize / 2)
            .map(|i| 2 * i)
            .map(|i| (at(i - 1) + 3.0 * at(i) + 3.0 * at(i + 1) + at(i + 2)) / 8.0)
            .collect()
    })
}

/// Light, centroid (pixels from the point) and variance of what a row makes of one bright pixel.
fn drawn(sigma: f64, pairs: u32, point: usize) -> [f64; 3] {
    let level = gaussian_disc_level(sigma, pairs);
    let deviation = gaussian_disc_deviation(sigma, level);
    let mut row = vec![0.0; 1024];
    row[point] = 1.0;
    let texels = mips(row, level as usize);
    let reach = i64::from(gaussian_disc_pairs(deviation));
    let mut sums = [0.0; 3];
    for x in 0..1024_i32 {
        let at = (f64::from(x) + 0.5) / level.exp2() - 0.5;
        let (mut light, mut total) = (0.0, 0.0);
        let first = at.floor() as i64 - reach + 1;
        let [mut gaussian, mut factor, fall] = gaussian_steps(first as f64 - at, deviation);
        for k in first..first + 2 * reach {
            let weight = gaussian_window(gaussian);
            gaussian *= factor;
            factor *= fall;
            light += weight * texels[k.clamp(0, texels.len() as i64 - 1) as usize];
            total += weight;
        }
        let off = f64::from(x) - point as f64;
        (0..3).for_each(|i| sums[i] += light / total * off.powi(i as i32));
    }
    let centroid = sums[1] / sums[0];
    [sums[0], centroid, sums[2] / sums[0] - centroid * centroid]
}

#[test]
fn a_point_is_drawn_as_wide_wherever_it_lies() {
    for max_taps in [20, 48] {
        let pairs = gaussian_disc_budget(max_taps);
        let mut worst = [0.0_f64; 3];
        let mut sigma = 0.75;
        while sigma < 30.0 {
            for point in 480..512 {
                let [light, centroid, variance] = drawn(sigma, pairs, point);
                let off = [light - 1.0, centroid / sigma, variance.sqrt() / sigma - 1.0];
                (0..3).for_each(|i| worst[i] = worst[i].max(off[i].abs()));
            }
            sigma *= 1.07;
        }
        println!("{max_taps} taps: light, centroid and width off by {worst:?}");
        // The mips keep a point's light and centroid; the window is a sum over texels in place of an
        // integral.
        assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
        assert!(worst[2] < 0.004, "{worst:?}");
    }
}

#[test]
fn taps_keep_their_budget() {
    assert_eq!(gaussian_disc_taps(0.12, 48), 0);
    assert_eq!(gaussian_disc_taps(0.13, 48), 4);
    assert_eq!(gaussian_disc_taps(0.71, 48), 9);
    let mut sigma = 0.71;
    while sigma < 1e9 {
        for (max_taps, most) in [(0, 16), (20, 16), (48, 36), (1000, 36)] {
            let taps = gaussian_disc_taps(sigma, max_taps);
            assert!((4..=most).contains(&taps), "{sigma}: {taps}");
        }
        sigma *= 1.01;
    }
    assert_eq!(spread_taps(6.7, 48), 30);
    assert_eq!(spread_taps(1e9, 48), 48);
    assert_eq!(spread_taps(1e9, 0), 20);
}

#[test]
fn a_lid_takes_of_a_direction_what_it_covers_of_the_pupil() {
    let open = |slope: f64| eyelid_transmission(slope, [4.6, 1.7], [-5.0, 1.8], 1.75);
    // Nothing within 25° of straight ahead, and all of it far up, where the margin stands in the way.
    for slope in [-0.46, 0.0, 0.46] {
        assert_eq!(open(slope), 1.0, "{slope}");
    }
    assert!(open(2.0) < 1e-12 && open(0.9) < 1.0);
    // An edge before the middle of the pupil leaves half of what is straight ahead, less above.
    let half = |slope: f64| eyelid_transmission(slope, [0.0, 3.0], [-5.0, 1.8], 1.75);
    assert!((half(0.0) - 0.5).abs() < 1e-12);
    // 3 mm ahead at a slope of 0.35 are 1.05 mm, 0.6 of the pupil's radius; upwards the thick margin adds
    // 0.7 mm, and the whole radius is covered.
    assert!(half(0.35) < 1e-12 && (half(-0.35) - 0.857_6).abs() < 1e-3);
    // Closed is dark, whatever the numbers.
    assert_eq!(eyelid_transmission(0.1, [-1.0, 3.0], [-1.0, 3.0], 2.0), 0.0);
    assert_eq!(eyelid_transmission(0.1, [-2.0, 3.0], [-1.0, 3.0], 2.0), 0.0);
    assert_eq!(
        (disc_below(-9.0), disc_below(0.0), disc_below(9.0)),
        (0.0, 0.5, 1.0)
    );
    // 0.5 + (asin 0.5 + 0.5 √0.75)/π.
    assert!((disc_below(0.5) - 0.804_498_890_52).abs() < 1e-9);
}

#[test]
fn angles_are_those_of_spherical_trigonometry() {
    let tan = 30_f64.to_radians().tan();
    let middle = view_ray([160.0, 160.0], [320.0; 2], [tan; 2]);
    assert_eq!(middle, [0.0, 0.0, -1.0]);
    let right = view_ray([320.0, 160.0], [320.0; 2], [tan; 2]);
    assert!((angle_between(middle, right).to_degrees() - 30.0).abs() < 1e-12);
    let up = view_ray([160.0, 0.0], [320.0; 2], [tan; 2]);
    assert!(up[1] > 0.0);
    let p = perimetric_angles(right, middle);
    assert!((p[0].to_degrees() - 30.0).abs() < 1e-12 && p[1].abs() < 1e-12);
    let p = perimetric_angles(up, middle);
    assert!((p[1].to_degrees() - 30.0).abs() < 1e-12 && p[0].abs() < 1e-12);
    // What lies straight ahead is left of a fixation to the right.
    let p = perimetric_angles(middle, right);
    assert!((p[0].to_degrees() + 30.0).abs() < 1e-12);
    assert_eq!(perimetric_angles(right, right), [0.0; 2]);
    assert!(
        (angle_between([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]) - std::f64::consts::PI).abs() < 1e-12
    );
    assert!(
        perimetric_angles([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
            .iter()
            .all(|v| v.is_finite())
    );
}

#[test]
fn retinal_blur_doubles_at_e2_and_adds_in_quadrature() {
    let arcmin = 1_f64.to_radians() / 60.0;
    let e2 = 2.5_f64.to_radians();
    assert!((neural_blur(0.0, arcmin, e2) - arcmin).abs() < 1e-18);
    assert!((neural_blur(e2, arcmin, e2) - 2.0 * arcmin).abs() < 1e-18);
    assert!((combined_blur(3.0, 4.0) - 5.0).abs() < 1e-15);
}

struct Picture {
    radiance: Vec<[f32; 3]>,
    vergence: Vec<f32>,
    blur: Vec<f32>,
}

impl Picture {
    fn seen(&self, width: usize, height: usize) -> Vec<[f64; 3]> {
        reference_gather(&View {
            width,
            height,
            radiance: &self.radiance,
            vergence_d: &self.vergence,
            blur_px: &self.blur,
            astigmatism: None,
        })
    }
}

#[test]
fn a_bright_point_keeps_its_energy_and_gets_its_width() {
    let n = 61;
    for d in [0.3, 1.0, 3.0, 10.0, 20.0] {
        let mut radiance = vec![[0.0; 3]; n * n];
        radiance[30 * n + 30] = [1000.0, 500.0, 0.0];
        let picture = Picture {
            radiance,
            vergence: vec![1.0; n * n],
            blur: vec![d; n * n],
        };
        let seen = picture.seen(n, n);
        let sum: f64 = seen.iter().map(|c| c[0]).sum();
        assert!((sum / 1000.0 - 1.0).abs() < 0.01, "{d}: {sum}");
        let moment: f64 = seen
            .iter()
            .enumerate()
            .map(|(i, c)| c[0] * ((i % n) as f64 - 30.0).powi(2))
            .sum();
        if d >= 3.0 {
            assert!(
                ((moment / sum).sqrt() / (f64::from(d) / 4.0) - 1.0).abs() < 0.01,
                "{d}"
            );
        }
    }
}

/// Left half near and bright, right half far and dark, with one blur for each.
fn edge(near_blur: f32, far_blur: f32) -> Vec<f64> {
    let (w, h) = (80, 41);
    let left = |i: usize| i % w < w / 2;
    let picture = Picture {
        radiance: (0..w * h)
            .map(|i| [f32::from(u8::from(left(i))); 3])
            .collect(),
        vergence: (0..w * h)
            .map(|i| if left(i) { 3.0 } else { 0.3 })
            .collect(),
        blur: (0..w * h)
            .map(|i| if left(i) { near_blur } else { far_blur })
            .collect(),
    };
    picture.seen(w, h)[20 * w..21 * w]
        .iter()
        .map(|c| c[0])
        .collect()
}

#[test]
fn sharp_near_edges_do_not_bleed_and_blurred_ones_spread() {
    let sharp_near = edge(0.1, 16.0);
    assert!(
        sharp_near[39] == 1.0 && sharp_near[41..].iter().all(|v| *v < 0.01),
        "{sharp_near:?}"
    );
    // The near side of 16 pixels (sigma 4) over a sharp far side: half covered at the edge, nothing
    // beyond 2.4 sigma cut at one tile.
    let blurred_near = edge(16.0, 0.1);
    assert!((blurred_near[40] - 0.45).abs() < 0.05, "{blurred_near:?}");
    assert!(blurred_near[60] < 1e-4 && blurred_near[30] > 0.99);
    assert!(
        blurred_near.windows(2).all(|w| w[1] <= w[0] + 0.06),
        "{blurred_near:?}"
    );
}

#[test]
fn inconsistent_views_give_nothing() {
    let view = View {
        width: 2,
        height: 2,
        radiance: &[[0.0; 3]; 4],
        vergence_d: &[0.0; 3],
        blur_px: &[0.0; 4],
        astigmatism: None,
    };
    assert_eq!(reference_gather(&view), Vec::<[f64; 3]>::new());
}
