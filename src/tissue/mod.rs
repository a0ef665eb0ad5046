//! Pure tissue optics in f64, free of Bevy: what colours iris and sclera, and what makes them irregular.
//!
//! In: pigment fractions and thicknesses. Out, from the particles to the picture:
//!
//! - [`melanin`]: absorption and scattering spectra, equations 10 to 14 of François et al. 2007;
//! - [`phase`]: where a scattering event sends light, and draws from it;
//! - [`slab`]: one layer in closed form, scattered once or, by two fluxes, any number of times;
//! - [`layers`]: stacks of layers, scattered once, in closed form;
//! - [`many_flux`]: stacks of layers, scattered any number of times, without noise;
//! - [`random_walk`]: the same by random walks, with standard errors and orders of scattering: the
//!   reference for the others;
//! - [`spectrum`] and [`wavelengths`]: linear sRGB from 41 or from few reflectances;
//! - [`iris_layers`], [`iris_reflectance`]: the iris as layers, and its colour as a function or
//!   table;
//! - [`blood`], [`sclera`]: what haemoglobin takes, and the white of an eye as layers;
//! - [`media`]: what the clear media take and send back;
//! - [`noise`]: what is irregular in them;
//! - [`scattering_orders`] and `colour_difference` (not in the web build): how wrong each estimate
//!   is.
//!
//! Wavelengths in nm, coefficients in mm⁻¹, lengths in mm, phase functions in sr⁻¹.

pub mod blood;
#[cfg(not(target_arch = "wasm32"))]
pub mod colour_difference;
pub mod fundus;
pub mod iris_layers;
pub mod iris_reflectance;
pub mod layers;
pub mod many_flux;
pub mod media;
pub mod melanin;
pub mod noise;
pub mod phase;
pub mod random_walk;
pub mod scattering_orders;
pub mod sclera;
pub mod skin;
pub mod slab;
pub mod spectrum;
pub mod wavelengths;
