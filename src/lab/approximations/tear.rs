//! The colour of the tear film: few wavelengths, and tables.

use super::rows::Task;
use super::timing::Stopwatch;
use crate::optics::fresnel::{LIPID_INDEX, TEAR_INDEX, fresnel_thin_film_rgb};
use crate::optics::tear_film::{tear_film_rgb, tear_film_rgb_exact};
use glam::{DVec3, Vec3};
use half::f16;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Thickest lipid layer (nm).
const THICKEST_NM: f64 = 300.0;

struct Film {
    cos: f64,
    nm: f64,
    exact: DVec3,
}

/// Reflectances on a square grid of cosine and thickness, rounded to half floats as in a texture, and
/// held decoded, as a GPU's sampler sees them.
struct Table {
    side: usize,
    texels: Vec<Vec3>,
}

impl Table {
    fn new(side: usize) -> Self {
        let at = |i: usize| i as f64 / (side - 1) as f64;
        let texels = (0..side * side)
            .map(|i| {
                let (cos, nm) = (at(i % side), THICKEST_NM * at(i / side));
                let rgb = tear_film_rgb_exact(cos, LIPID_INDEX, TEAR_INDEX, nm).as_vec3();
                Vec3::from_array(rgb.to_array().map(|c| f16::from_f32(c).to_f32()))
            })
            .collect();
        Self { side, texels }
    }

    fn bytes(&self) -> usize {
        self.texels.len() * 3 * size_of::<f16>()
    }

    fn sample(&self, cos: f64, nm: f64) -> Vec3 {
        let last = (self.side - 1) as f32;
        let cell = |u: f32| {
            let x = u.clamp(0.0, 1.0) * last;
            let first = (x as usize).min(self.side - 2);
            (first, x - first as f32)
        };
        let (i, u) = cell(cos as f32);
        let (j, v) = cell(nm as f32 * (1.0 / THICKEST_NM as f32));
        let row = |j: usize| {
            let first = j * self.side + i;
            self.texels[first].lerp(self.texels[first + 1], u)
        };
        row(j).lerp(row(j + 1), v)
    }
}

/// Measures every form on `count` films.
pub fn measure(stopwatch: &Stopwatch, count: usize) -> Task {
    let mut random = Pcg64::seed_from_u64(17);
    let cases: Vec<Film> = (0..count)
        .map(|_| {
            let (cos, nm) = (random.random(), THICKEST_NM * random.random::<f64>());
            Film {
                cos,
                nm,
                exact: tear_film_rgb_exact(cos, LIPID_INDEX, TEAR_INDEX, nm),
            }
        })
        .collect();
    let error = |film: &Film, rgb: DVec3| (rgb - film.exact).abs().max_element();
    // Three wavelengths; four with their weights; the spectrum's weights.
    let mut rows = vec![
        stopwatch.row(
            ("a wavelength a channel", 3, 12),
            &cases,
            |film| fresnel_thin_film_rgb(film.cos, LIPID_INDEX, TEAR_INDEX, film.nm),
            error,
        ),
        stopwatch.row(
            ("wavelengths and a matrix", 4, 64),
            &cases,
            |film| tear_film_rgb(film.cos, LIPID_INDEX, TEAR_INDEX, film.nm),
            error,
        ),
    ];
    for side in [8, 16, 32, 64, 128] {
        let table = Table::new(side);
        let method = ("table", format!("{side}×{side}"), table.bytes());
        let run = |film: &Film| table.sample(film.cos, film.nm);
        let error = |film: &Film, rgb: Vec3| error(film, rgb.as_dvec3());
        rows.push(stopwatch.row(method, &cases, run, error));
    }
    rows.push(stopwatch.row(
        ("every 10 nm", 41, 41 * 3 * size_of::<f64>()),
        &cases,
        |film| tear_film_rgb_exact(film.cos, LIPID_INDEX, TEAR_INDEX, film.nm),
        error,
    ));
    Task {
        name: "tear-film".to_owned(),
        title: "The colour of the tear film".to_owned(),
        call: "linear sRGB at one incidence and thickness".to_owned(),
        domain: format!(
            "{count} seeded films; lipid (1.48) of 0 to 300 nm over tear (1.337); cosine of incidence 0 to 1"
        ),
        reference: "Airy's sum at all 41 wavelengths (largest of the channels)".to_owned(),
        unit: "linear sRGB".to_owned(),
        rows,
    }
}
