//! The colour of an iris from its pigment and its thickness.
//!
//! In: an [`IrisPigment`], the light's path through the stroma, the local density of the anterior
//! border layer. Out: diffuse reflectance in linear sRGB, as a function or as a table for a shader.
//!
//! Layers from the front: the anterior border layer (0.04 mm), where pigment cells lie dense; the
//! stroma; the pigment epithelium, which absorbs all that reaches it (François et al. 2007,
//! section 4). Each layer is a two-flux slab ([`super::slab`]) with the coefficients of equations 10
//! to 14 at every wavelength. A blue iris has no blue pigment: thin fibrils scatter blue more, the
//! black epithelium swallows the rest, and what melanin there is takes the blue away again, to
//! green, hazel and brown.
//!
//! **Path.** A layer of thickness `d` lit at `µ_i` and seen at `µ_o` acts by the mean slant
//! `d (1/µ_i + 1/µ_o)/2`; the table's first axis is that path in the stroma, 0 to
//! [`STROMA_PATH_MAX_MM`].

use super::melanin::{mie_scattering, rayleigh_scattering, tissue_absorption};
use super::slab::{TwoFlux, slab_two_flux};
use super::spectrum::{spectrum_from, spectrum_to_linear_srgb};

/// Longest path (mm) in the table.
pub const STROMA_PATH_MAX_MM: f64 = 2.5;
/// Thickness (mm) of the anterior border layer.
pub const BORDER_LAYER_MM: f64 = 0.04;
/// Density of thin fibrils in the stroma relative to the dermis of equation 14. The stroma is a
/// loose mesh in aqueous humour; this and [`STROMA_MIE_DENSITY`] are calibrated so that
/// [`IrisPigment::BLUE`], 0.45 mm thick, reflects what photographs of blue irises show, about
/// (0.17, 0.23, 0.33).
pub const STROMA_RAYLEIGH_DENSITY: f64 = 0.25;
/// Density of thick collagen bundles in the stroma relative to the dermis.
pub const STROMA_MIE_DENSITY: f64 = 0.07;
/// Density of collagen in the anterior border layer, a condensation of the stroma, relative to the
/// dermis: it gives dark irises the matt brown that they have in place of black.
pub const BORDER_LAYER_DENSITY: f64 = 0.15;

/// How much melanin an iris holds, where, and of which kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrisPigment {
    /// Volume fraction of melanin in the stroma, C_m of equation 13, 0 to 0.5.
    pub stroma_melanin_fraction: f64,
    /// Volume fraction of melanin in the anterior border layer where it is densest, 0 to 0.5.
    pub border_layer_melanin_fraction: f64,
    /// Ratio of eumelanin to all melanin, β_m of equation 13, 0 to 1.
    pub eumelanin_ratio: f64,
}

impl IrisPigment {
    /// Almost no melanin: blue by scattering alone.
    pub const BLUE: Self = Self {
        stroma_melanin_fraction: 0.0004,
        border_layer_melanin_fraction: 0.002,
        eumelanin_ratio: 0.9,
    };
    /// Pheomelanin in the border layer: yellow over blue; amber where it is densest.
    pub const GREEN: Self = Self {
        stroma_melanin_fraction: 0.002,
        border_layer_melanin_fraction: 0.18,
        eumelanin_ratio: 0.02,
    };
    /// Between green and brown.
    pub const HAZEL: Self = Self {
        stroma_melanin_fraction: 0.010,
        border_layer_melanin_fraction: 0.28,
        eumelanin_ratio: 0.3,
    };
    /// Dense melanin in both layers, enough of it pheomelanin to be warm.
    pub const BROWN: Self = Self {
        stroma_melanin_fraction: 0.04,
        border_layer_melanin_fraction: 0.5,
        eumelanin_ratio: 0.15,
    };

    /// Fractions clamped to their ranges; what is not a number counts as none.
    fn clamped(self) -> Self {
        let within = |v: f64, high: f64| if v.is_nan() { 0.0 } else { v.clamp(0.0, high) };
        Self {
            stroma_melanin_fraction: within(self.stroma_melanin_fraction, 1.0),
            border_layer_melanin_fraction: within(self.border_layer_melanin_fraction, 1.0),
            eumelanin_ratio: within(self.eumelanin_ratio, 1.0),
        }
    }
}

/// Reflectance of the iris at one wavelength.
fn reflectance_at(pigment: IrisPigment, path_mm: f64, density: f64, wavelength_nm: f64) -> f64 {
    let absorption = |fraction| tissue_absorption(wavelength_nm, fraction, pigment.eumelanin_ratio);
    let (mie, rayleigh) = (
        mie_scattering(wavelength_nm),
        rayleigh_scattering(wavelength_nm),
    );
    let border = slab_two_flux(
        absorption(pigment.border_layer_melanin_fraction * density),
        BORDER_LAYER_DENSITY * (mie + rayleigh),
        BORDER_LAYER_MM,
    );
    let stroma = slab_two_flux(
        absorption(pigment.stroma_melanin_fraction),
        STROMA_MIE_DENSITY * mie + STROMA_RAYLEIGH_DENSITY * rayleigh,
        path_mm,
    );
    let epithelium = TwoFlux {
        reflectance: 0.0,
        transmittance: 0.0,
    };
    border.over(stroma).over(epithelium).reflectance
}

/// Diffuse reflectance (linear sRGB, 0 to 1) of an iris whose stroma the light crosses on a path of
/// `path_mm` (from 0), under a border layer of the relative melanin density `density` (0 to 1).
/// Arguments outside their ranges are clamped; colours outside sRGB lose their negative channel.
pub fn iris_reflectance(pigment: &IrisPigment, path_mm: f64, density: f64) -> [f64; 3] {
    let pigment = pigment.clamped();
    let path_mm = if path_mm.is_nan() {
        0.0
    } else {
        path_mm.clamp(0.0, 1e3)
    };
    let density = if density.is_nan() {
        0.0
    } else {
        density.clamp(0.0, 1.0)
    };
    let spectrum = spectrum_from(|nm| reflectance_at(pigment, path_mm, density, nm));
    spectrum_to_linear_srgb(&spectrum).map(|channel| channel.clamp(0.0, 1.0))
}

/// [`iris_reflectance`] on a grid: columns along the path, rows along the border layer's density.
///
/// Values belong to texel centres: column `i` of `w` stands for the path
/// `STROMA_PATH_MAX_MM (i + ½)/w`, row `j` of `h` for the density `(j + ½)/h`, so that a linear
/// texture lookup at `(path/STROMA_PATH_MAX_MM, density)` reads the right place.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisReflectanceTable {
    rgb: Vec<[f64; 3]>,
    width: usize,
    height: usize,
}

impl IrisReflectanceTable {
    /// Computes the table; a size of 0 counts as 1.
    pub fn new(pigment: &IrisPigment, width: usize, height: usize) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let mut rgb = Vec::with_capacity(width * height);
        for row in 0..height {
            let density = (row as f64 + 0.5) / height as f64;
            for column in 0..width {
                let path = STROMA_PATH_MAX_MM * (column as f64 + 0.5) / width as f64;
                rgb.push(iris_reflectance(pigment, path, density));
            }
        }
        Self { rgb, width, height }
    }

    /// Linear sRGB reflectances, row after row.
    pub fn rgb(&self) -> &[[f64; 3]] {
        &self.rgb
    }

    /// Columns: paths.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows: densities of the border layer.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The table's value, linear between texel centres and constant beyond the outermost ones, as a
    /// texture lookup gives it.
    pub fn sample(&self, path_mm: f64, density: f64) -> [f64; 3] {
        let (column, across) = lattice(path_mm / STROMA_PATH_MAX_MM, self.width);
        let (row, down) = lattice(density, self.height);
        let (right, below) = (
            (column + 1).min(self.width - 1),
            (row + 1).min(self.height - 1),
        );
        let at = |c: usize, r: usize| self.rgb[r * self.width + c];
        let corners = [
            at(column, row),
            at(right, row),
            at(column, below),
            at(right, below),
        ];
        core::array::from_fn(|i| {
            let top = corners[0][i] + across * (corners[1][i] - corners[0][i]);
            let bottom = corners[2][i] + across * (corners[3][i] - corners[2][i]);
            top + down * (bottom - top)
        })
    }
}

/// Texel before the coordinate `u` (0 to 1) and the fraction of the way to the next.
fn lattice(u: f64, size: usize) -> (usize, f64) {
    let u = if u.is_nan() { 0.0 } else { u };
    let position = (u * size as f64 - 0.5).clamp(0.0, (size - 1) as f64);
    (position.floor() as usize, position.fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::output::linear_to_srgb;

    const THICKNESS: f64 = 0.45;

    fn show(name: &str, rgb: [f64; 3]) -> [f64; 3] {
        let encoded = linear_to_srgb(glam::DVec3::from_array(rgb)) * 255.0;
        println!(
            "{name}: linear {:.3} {:.3} {:.3}, sRGB {:.0} {:.0} {:.0}",
            rgb[0], rgb[1], rgb[2], encoded.x, encoded.y, encoded.z
        );
        rgb
    }

    #[test]
    fn a_blue_iris_is_blue_by_scattering() {
        for path in [0.2, THICKNESS, 0.8] {
            let [r, g, b] = show("blue", iris_reflectance(&IrisPigment::BLUE, path, 0.5));
            assert!(b > g && g > r, "blue-grey order");
        }
        let [r, g, b] = iris_reflectance(&IrisPigment::BLUE, THICKNESS, 0.5);
        // The calibration's aim, and the albedo of pale irises in photographs.
        assert!((r - 0.17).abs() < 0.03 && (g - 0.23).abs() < 0.03 && (b - 0.33).abs() < 0.03);
        let none = IrisPigment {
            stroma_melanin_fraction: 0.0,
            border_layer_melanin_fraction: 0.0,
            eumelanin_ratio: 0.5,
        };
        let [r, g, b] = iris_reflectance(&none, THICKNESS, 1.0);
        assert!(
            b > 1.3 * g && g > 1.2 * r,
            "no pigment at all is the bluest"
        );
    }

    #[test]
    fn a_brown_iris_is_dark_and_warm() {
        for density in [0.3, 0.5, 1.0] {
            let [r, g, b] = show(
                "brown",
                iris_reflectance(&IrisPigment::BROWN, THICKNESS, density),
            );
            assert!(r > 1.05 * g && g > 1.2 * b);
            assert!(g < 0.09 && r > 0.015);
        }
        let [r, g, b] = iris_reflectance(&IrisPigment::BROWN, THICKNESS, 0.5);
        assert!(
            r > 1.3 * g && g > 1.8 * b,
            "brown where the border layer is half dense"
        );
    }

    #[test]
    fn green_and_hazel_lie_between() {
        let [r, g, b] = show(
            "green",
            iris_reflectance(&IrisPigment::GREEN, THICKNESS, 0.5),
        );
        assert!(
            g > 1.05 * r && g > 1.2 * b,
            "green is the strongest channel"
        );
        let green = g;
        let [r, g, b] = show(
            "hazel",
            iris_reflectance(&IrisPigment::HAZEL, THICKNESS, 0.5),
        );
        assert!(r > g && g > 1.5 * b && r < 1.3 * g, "yellow-brown");
        let brown = iris_reflectance(&IrisPigment::BROWN, THICKNESS, 0.5)[1];
        assert!(green > g && g > brown);
    }

    #[test]
    fn pheomelanin_needs_the_printed_constant_to_make_green() {
        use crate::tissue::melanin::{
            PHEOMELANIN_FRANCOIS, PHEOMELANIN_JACQUES, pheomelanin_absorption,
        };
        // Diffuse light crosses the half-dense border layer twice, on average at 60°: what is left
        // of the blue against the red?
        let passes = |constant: f64| {
            let melanin = 0.5 * IrisPigment::GREEN.border_layer_melanin_fraction;
            let path = 2.0 * 2.0 * BORDER_LAYER_MM;
            let through = |nm| (-melanin * path * pheomelanin_absorption(nm, constant)).exp();
            through(460.0) / through(610.0)
        };
        // A blue stroma has 1.9 times as much blue as red: the printed constant turns that around,
        // Jacques' leaves it.
        assert!(1.9 * passes(PHEOMELANIN_FRANCOIS) < 1.0);
        assert!(1.9 * passes(PHEOMELANIN_JACQUES) > 1.7);
    }

    #[test]
    fn more_stroma_is_brighter_and_more_melanin_darker() {
        let at = |pigment: &IrisPigment, path, density| iris_reflectance(pigment, path, density)[1];
        for pigment in [IrisPigment::BLUE, IrisPigment::GREEN, IrisPigment::HAZEL] {
            for i in 1..20 {
                let path = f64::from(i) * 0.12;
                assert!(at(&pigment, path, 0.5) > at(&pigment, path - 0.12, 0.5));
                let density = f64::from(i) * 0.05;
                assert!(at(&pigment, THICKNESS, density) < at(&pigment, THICKNESS, density - 0.05));
            }
        }
    }

    #[test]
    fn the_table_is_the_function() {
        let table = IrisReflectanceTable::new(&IrisPigment::GREEN, 64, 32);
        assert_eq!(table.rgb().len(), table.width() * table.height());
        let mut worst: f64 = 0.0;
        for i in 1..50 {
            for j in 1..50 {
                let (path, density) = (0.05 * f64::from(i), 0.02 * f64::from(j));
                let exact = iris_reflectance(&IrisPigment::GREEN, path, density);
                let read = table.sample(path, density);
                worst = (0..3).fold(worst, |w, c| w.max((read[c] - exact[c]).abs()));
            }
        }
        println!("64 × 32 table: worst error {worst:.1e}");
        // A quarter of the curvature of R = Sd/(1 + Sd) over 0.04 mm; half an 8-bit step is 2e-3.
        assert!(worst < 2e-3, "{worst}");
    }

    #[test]
    fn senseless_input_stays_a_colour() {
        let odd = IrisPigment {
            stroma_melanin_fraction: f64::NAN,
            border_layer_melanin_fraction: 7.0,
            eumelanin_ratio: -1.0,
        };
        for (path, density) in [
            (f64::NAN, 0.5),
            (-1.0, f64::NAN),
            (f64::INFINITY, 2.0),
            (0.0, 0.0),
        ] {
            for channel in iris_reflectance(&odd, path, density) {
                assert!((0.0..=1.0).contains(&channel));
            }
        }
        assert_eq!(
            IrisReflectanceTable::new(&IrisPigment::BLUE, 0, 0)
                .rgb()
                .len(),
            1
        );
        assert!(IrisReflectanceTable::new(&IrisPigment::BLUE, 1, 1).sample(f64::NAN, 9.0)[0] > 0.0);
    }
}
