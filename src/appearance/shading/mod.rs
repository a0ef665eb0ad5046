//! How the eye's surfaces answer light, in f64: the twins of the shading functions in `shaders/lib`.
//!
//! Enters: geometry, maps and the light. Leaves: linear sRGB radiance, its parts, and the place in a
//! map that each needs. Each file bears the name of its twin; lengths in mm, angles in rad.

pub mod footprint;
pub mod fundus;
pub mod hair_shade;
pub mod iris_relief;
pub mod iris_shade;
pub mod knots;
pub mod lamp_lobe;
pub mod lash_comb;
pub mod lens_shade;
pub mod lid_shade;
pub mod limbus;
pub mod near_light;
pub mod sclera_shade;
pub mod skin_shade;
pub mod surroundings;
pub mod tear_layer;
pub mod tear_reflection;

fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}
