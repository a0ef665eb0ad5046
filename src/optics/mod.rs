//! Pure optics of the eye in f64, free of Bevy.
//!
//! In: surfaces, indices, rays, pupils, distances. Out: where light goes, how much of it, and how
//! wide it blurs. Each file with a `shaders/lib` twin holds the same functions in the same order of
//! arguments; one test runs both on the same seeded inputs.
//!
//! **Optics frame** (François et al. 2007): origin at the corneal apex, +z into the eye,
//! millimetres. **Globe frame**: origin at the globe's centre of rotation, y up, gaze along −z, +x
//! the patient's right; the same axes moved along z ([`globe::GlobeShape::optics_from_globe`]).
//! A refracting surface of the shaders is `DVec2(apical radius R in mm, shape factor p)`; whole eyes
//! are built of [`surface::Quadric`]s.
//!
//! Whole eyes, from surfaces to images: [`surface`] → [`ray_trace`] → [`schematic_eye`] → [`reference::paraxial`],
//! [`pupil`], [`reference::wavefront`] → [`reference::psf`]; [`reference::traced_blur`] holds the blur disc of [`defocus`] against them.

pub mod accommodation;
pub mod caustic;
pub mod conicoid;
pub mod cornea;
pub mod defocus;
pub mod fermat;
pub mod fresnel;
pub mod glare;
pub mod globe;
pub mod lens_mirror;
pub mod media;
pub mod microfacet;
pub mod output;
pub mod pupil;
pub mod ray_trace;
pub mod reference;
pub mod refraction_function;
pub mod root;
pub mod schematic_eye;
pub mod smoothstep;
pub mod snell;
pub mod surface;
pub mod tear_film;
