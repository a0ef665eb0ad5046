//! What pictures are held against: whole eyes followed ray by ray, from surfaces to images.
//!
//! Nothing here makes a pixel. `ocularium measure` prints it, `ocularium bench` and the tests compare with
//! it what does.
//!
//! [`paraxial`] → [`wavefront`] ([`zernike`]) → [`psf`], [`mean_mtf`]; [`traced_blur`] holds the blur disc of
//! [`defocus`](super::defocus) against them, [`chromatic`] is the eye's difference of focus by wavelength,
//! [`descent`] the published way to the two-point problem that [`fermat`](super::fermat) solves.

pub mod chromatic;
pub mod descent;
pub mod mean_mtf;
pub mod paraxial;
pub mod psf;
pub mod traced_blur;
pub mod wavefront;
pub mod zernike;
