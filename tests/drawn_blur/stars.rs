//! A star through a pupil out of focus: how wide it is drawn, and whether its light is kept.
//!
//! Sixteen stars stand at all places that a star can have in a texel of four pixels a side, the
//! coarsest mip level that these blurs are read from. What is judged is their mean about their own
//! places: a single one is drawn wider or narrower according to its place, and the test prints the
//! range. A star is two pixels wide: the light of one pixel, spread over 21, is so weak that the
//! panel's rounding takes 0.9 % of it. Their brightness differs so that its rounding does.

use super::{Eye, Photograph, SIDE, linear};
use crate::stage::alone;
use bevy::math::{DVec2, IVec2};
use ocularium::lab::headless::Headless;
use ocularium::percept::gather::{
    GAUSSIAN_DISC_RADIUS, SMALL_DISC_SIGMA_PX, gaussian_disc_level, gaussian_disc_tap_sigma,
    gaussian_disc_taps,
};
use ocularium::percept::gpu_data::PerceptUniform;

const PUPILS_MM: [f64; 5] = [2.0, 3.0, 4.0, 5.0, 6.0];
const DEFOCI_D: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];
/// Pixels from star to star: one more than a multiple of four.
const SPACING: u32 = SIDE / 4;
/// Pixels along a star's side, and the first of them among those of its spacing.
const STAR: u32 = 2;
const FIRST: u32 = 20;
/// Half of the window in which a star is measured, pixels: the widest kernel reaches 14.
const WINDOW: i32 = 20;
/// Parts along a pixel's side when its light is sorted by distance.
const PARTS: i32 = 9;
/// On diameters and radii.
const WIDTH_TOLERANCE: f64 = 0.02;
const LIGHT_TOLERANCE: f64 = 0.005;

fn is_star(x: u32, y: u32) -> bool {
    [x, y]
        .iter()
        .all(|i| (i % SPACING).abs_diff(FIRST) < STAR && i % SPACING >= FIRST)
}

fn is_first_pixel(x: u32, y: u32) -> bool {
    [x, y].iter().all(|i| i % SPACING == FIRST)
}

fn stars() -> Photograph {
    Photograph::new(|x, y| {
        let code = 255 - (x / SPACING + 4 * (y / SPACING)) as u8;
        (if is_star(x, y) { code } else { 0 }, false)
    })
}

/// Light by place relative to a star, and distances (px) and lights of its parts.
#[derive(Default)]
struct Spot {
    light: f64,
    /// Light times squared distance.
    moment: f64,
    parts: Vec<(f64, f64)>,
}

impl Spot {
    /// The light around a star, by place from its first pixel.
    fn new(light: impl Fn(IVec2) -> f64) -> Self {
        let mut spot = Self::default();
        for y in -WINDOW..=WINDOW {
            for x in -WINDOW..=WINDOW {
                let here = light(IVec2::new(x, y));
                let middle = DVec2::splat(0.5 * f64::from(STAR - 1));
                let place = DVec2::new(f64::from(x), f64::from(y)) - middle;
                spot.light += here;
                spot.moment += here * place.length_squared();
                let step = |k: i32| (f64::from(k) + 0.5) / f64::from(PARTS) - 0.5;
                spot.parts.extend((0..PARTS * PARTS).map(|k| {
                    let at = place + DVec2::new(step(k % PARTS), step(k / PARTS));
                    (at.length(), here / f64::from(PARTS * PARTS))
                }));
            }
        }
        spot
    }

    fn add(&mut self, other: &Self, share: f64) {
        self.light += share * other.light;
        self.moment += share * other.moment;
        let parts = other.parts.iter();
        self.parts
            .extend(parts.map(|(at, light)| (*at, share * light)));
    }

    /// Diameter (px) of the uniform disc that adds this second moment to the star's own: d²/8.
    fn disc_px(&self) -> f64 {
        let own = f64::from(STAR * STAR - 1) / 6.0;
        (8.0 * (self.moment / self.light - own).max(0.0)).sqrt()
    }

    /// Radius (px) of the circle that holds half of the light.
    fn half_light_px(&self) -> f64 {
        let mut parts = self.parts.clone();
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut within = 0.0;
        let half = parts.iter().find(|(_, light)| {
            within += light;
            within >= 0.5 * self.light
        });
        half.map_or(f64::NAN, |(radius, _)| *radius)
    }
}

/// The stars as an eye is shown them, their own light being 1.
fn drawn(photograph: &Photograph, headless: &mut Headless, eye: Eye) -> Vec<Spot> {
    let picture = eye.draw(headless);
    let own = photograph.linear();
    let places = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    let stars = places.filter(|(x, y)| is_first_pixel(*x, *y));
    stars
        .map(|(x, y)| {
            let own = own[(y * SIDE + x) as usize];
            Spot::new(|from| {
                let at = IVec2::new(x as i32, y as i32) + from;
                linear(picture.get_pixel(at.x as u32, at.y as u32).0[1])
                    / (own * f64::from(STAR * STAR))
            })
        })
        .collect()
}

/// A star under the kernel that `gaussian_disc.wgsl` describes, with taps without
/// number: four bilinear taps at ±σ², or a Gaussian cut at 2.4 of its deviations, as wide as the disc.
fn described(diameter_px: f64) -> Spot {
    const TAPS: u32 = 4000;
    let sigma = 0.25 * diameter_px;
    let a = sigma * sigma;
    let taps: Vec<(DVec2, f64)> = if sigma <= SMALL_DISC_SIGMA_PX {
        let corners = [(-a, -a), (a, -a), (-a, a), (a, a)];
        corners.map(|(x, y)| (DVec2::new(x, y), 1.0)).to_vec()
    } else {
        let tap_sigma = gaussian_disc_tap_sigma(sigma, 0.0);
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let tap = |k: u32| {
            let share = (f64::from(k) + 0.5) / f64::from(TAPS);
            let radius = GAUSSIAN_DISC_RADIUS * share.sqrt();
            let direction = DVec2::from_angle(golden * f64::from(k));
            (
                radius * tap_sigma * direction,
                (-0.5 * radius * radius).exp(),
            )
        };
        (0..TAPS).map(tap).collect()
    };
    let total: f64 = taps.iter().map(|(_, weight)| weight).sum();
    // Each tap reads the star's pixels with the weights of bilinear interpolation.
    let read = |x: f64| {
        let weights = (0..STAR).map(|pixel| (1.0 - (x - f64::from(pixel)).abs()).max(0.0));
        weights.sum::<f64>() / f64::from(STAR)
    };
    Spot::new(|from| {
        let seen = taps.iter().map(|(offset, weight)| {
            let at = from.as_dvec2() + *offset;
            weight * read(at.x) * read(at.y)
        });
        seen.sum::<f64>() / total
    })
}

/// Root of the mean square of the blur diameters (px) that optics gives the stars: pupil times
/// defocus and, added in quadrature, the retina's own blur at each star.
fn optics_px(photograph: &Photograph, eye: Eye) -> f64 {
    let blur = photograph.blur_px(eye).into_iter().enumerate();
    let at_stars = blur.filter(|(i, _)| is_first_pixel(*i as u32 % SIDE, *i as u32 / SIDE));
    let squares: Vec<f64> = at_stars.map(|(_, d)| f64::from(d).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Share of a blur's variance that the texels of a coarser mip level make; the kernel described is
/// that of the picture itself.
fn texel_share(diameter_px: f64) -> f64 {
    let sigma = 0.25 * diameter_px;
    let taps = gaussian_disc_taps(sigma, PerceptUniform::default().max_taps);
    let level = gaussian_disc_level(sigma, taps);
    if taps <= 4 || level == 0.0 {
        return 0.0;
    }
    let texel2 = (2.0 * level).exp2();
    ((texel2 - 1.0) / 12.0 + texel2 / 6.0) / (sigma * sigma)
}

fn mean_of(spots: &[Spot]) -> Spot {
    let mut mean = Spot::default();
    for spot in spots {
        mean.add(spot, 1.0 / spots.len() as f64);
    }
    mean
}

#[test]
fn stars_are_as_wide_as_optics_says_and_keep_their_light() {
    let _alone = alone();
    let photograph = stars();
    let mut headless = photograph.open();
    let mut halves_judged = 0;
    let eyes = PUPILS_MM.map(|pupil_mm| {
        DEFOCI_D.map(|defocus_d| Eye {
            pupil_mm,
            sphere_d: -defocus_d,
        })
    });
    for eye in eyes.as_flattened() {
        let spots = drawn(&photograph, &mut headless, *eye);
        let mean = mean_of(&spots);
        let width = optics_px(&photograph, *eye);
        let ratio = mean.disc_px() / width;
        let half = mean.half_light_px() / described(width).half_light_px();
        let single = spots.iter().map(|spot| spot.disc_px() / width);
        let range = single.fold([f64::MAX, 0.0], |[a, b], v| [a.min(v), b.max(v)]);
        println!(
            "{eye:?}: {width:.2} px, drawn {ratio:.4} (single {range:.3?}), half {half:.4}, light {:.4}",
            mean.light
        );
        assert!((ratio - 1.0).abs() < WIDTH_TOLERANCE, "{eye:?}: {ratio}");
        assert!((mean.light - 1.0).abs() < LIGHT_TOLERANCE, "{eye:?}");
        // Where the mip's texels make a third of the blur, its profile is theirs as much as the
        // Gaussian's, and the half-light radius is found 2.2 to 2.4 % small.
        if texel_share(width) < 0.31 {
            halves_judged += 1;
            assert!((half - 1.0).abs() < WIDTH_TOLERANCE, "{eye:?}: {half}");
        }
        // A quarter of a dioptre less is another width.
        let weaker = Eye {
            sphere_d: eye.sphere_d + 0.25,
            ..*eye
        };
        let other = mean.disc_px() / optics_px(&photograph, weaker);
        assert!((other - 1.0).abs() > WIDTH_TOLERANCE, "{eye:?}: {other}");
    }
    // All but 6.3, 12.6 and, twice, 14.0 pixels.
    assert_eq!(halves_judged, 21);
}
