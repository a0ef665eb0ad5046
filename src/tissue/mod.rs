//! Pure tissue optics in f64, free of Bevy: what colours an iris.
//!
//! In: pigment fractions and thicknesses. Out: absorption and scattering spectra
//! ([`melanin`]), the light that a homogeneous layer passes and returns ([`slab`]), linear sRGB from
//! a reflectance spectrum ([`spectrum`]), and the iris's reflectance as a table
//! ([`iris_reflectance`]).
//!
//! The coefficients are equations 10 to 14 of François et al. 2007; wavelengths in nm, coefficients
//! in mm⁻¹, lengths in mm.

#[cfg(not(target_arch = "wasm32"))]
pub mod colour_difference;
pub mod iris_layers;
pub mod iris_reflectance;
pub mod layers;
pub mod many_flux;
pub mod melanin;
pub mod phase;
pub mod random_walk;
pub mod scattering_orders;
pub mod slab;
pub mod spectrum;
pub mod wavelengths;
