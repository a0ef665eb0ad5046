//! Published schematic eyes, as lists of surfaces to trace through.
//!
//! In: which eye, its accommodation or refraction, the wavelength. Out: a [`SchematicEye`]: its
//! refracting surfaces with a stop among them, and its retina, in the optics frame (origin at the
//! corneal apex, +z into the eye, mm). Sources stand with each eye.
//!
//! Every eye returns its printed indices at its own reference wavelength, and disperses elsewhere
//! by [`dispersion`].

pub mod dispersion;
mod published;

use super::ray_trace::gradient::LensGradient;
use super::ray_trace::{IndexField, Interface, Ray, Traced, trace_into};
use super::surface::{Crossing, Placed, Quadric};
use glam::DVec3;

/// Wavelength (nm) of the eyes quoted for the sodium line: Gullstrand, Le Grand, Navarro 1985.
pub const SODIUM_NM: f64 = 589.3;
/// Wavelength (nm) of the eyes quoted for the peak of photopic vision: Liou & Brennan, Atchison.
pub const PHOTOPIC_NM: f64 = 555.0;

/// Wavelength (nm) at which Escudero-Sanz & Navarro's eye is in focus.
pub const GREEN_NM: f64 = 543.0;

/// An eye to trace through.
///
/// The constructors keep two promises that the optics of this crate rely on, and so must whoever
/// assembles one by hand: there is at least one interface, and `stop` counts one of them.
#[derive(Clone, Debug, PartialEq)]
pub struct SchematicEye {
    /// Refracting surfaces from the cornea to the back of the lens, and among them the stop: a plane
    /// between equal indices.
    pub interfaces: Vec<Interface>,
    /// Where the stop stands in `interfaces`.
    pub stop: usize,
    /// The retina, concave towards the lens.
    pub retina: Placed,
}

/// One refracting surface of a table: radius (mm), shape factor `p = 1 + Q`, the distance to the next
/// (mm) and the index of what lies between.
struct Row(f64, f64, f64, IndexField);

impl SchematicEye {
    /// Assembles a table; the stop stands at the vertex of row `stop`, in front of it, wide open.
    fn from_rows(rows: &[Row], stop: usize, retina: Quadric) -> Self {
        let mut interfaces = Vec::with_capacity(rows.len() + 1);
        let mut z = 0.0;
        let mut front = IndexField::Uniform(1.0);
        for (i, &Row(radius, p, behind, mut back)) in rows.iter().enumerate() {
            if i == stop {
                interfaces.push(Interface {
                    placed: Placed::at(Quadric::PLANE, z),
                    front,
                    back: front,
                });
            }
            // A table gives a gradient by the depth from its own surface.
            if let IndexField::Gradient(gradient) = &mut back {
                gradient.z_mm += z;
            }
            interfaces.push(Interface {
                placed: Placed::at(Quadric::conicoid(radius, p), z),
                front,
                back,
            });
            z += behind;
            front = back;
        }
        Self {
            interfaces,
            stop,
            retina: Placed::at(retina, z),
        }
    }

    /// Distance from the corneal apex to the retina along the axis (mm).
    pub fn axial_length_mm(&self) -> f64 {
        self.retina.vertex.z
    }

    /// The same eye with a circular stop of this radius (mm). Zero, negative or NaN closes it.
    pub fn with_stop_radius(mut self, radius_mm: f64) -> Self {
        let placed = &mut self.interfaces[self.stop].placed;
        *placed = placed.with_aperture(radius_mm, radius_mm);
        self
    }

    /// The surfaces in front of the stop.
    pub fn front(&self) -> &[Interface] {
        &self.interfaces[..self.stop]
    }

    /// The surfaces behind the stop.
    pub fn rear(&self) -> &[Interface] {
        &self.interfaces[self.stop + 1..]
    }

    /// Depth of the stop (mm).
    pub fn stop_z_mm(&self) -> f64 {
        self.interfaces[self.stop].placed.vertex.z
    }

    /// Index in front of the retina, on the axis.
    pub fn vitreous_index(&self) -> f64 {
        let last = self.interfaces.len() - 1;
        self.interfaces[last].back.at(self.retina.vertex)
    }

    /// Traces a ray from in front of the eye to the retina. `Missed` with a surface number equal to
    /// the number of interfaces means that it passed all of them but not the retina's near half.
    pub fn trace_to_retina(&self, ray: Ray) -> Traced {
        match trace_into(&self.interfaces, ray) {
            Traced::Through {
                ray,
                optical_path_mm,
            } => {
                let hit = self
                    .retina
                    .crossing(ray.origin, ray.direction, Crossing::Inward)
                    .filter(|hit| hit.distance >= 0.0);
                match hit {
                    Some(hit) => Traced::Through {
                        ray: Ray {
                            origin: hit.point,
                            direction: ray.direction,
                        },
                        optical_path_mm: optical_path_mm + self.vitreous_index() * hit.distance,
                    },
                    None => Traced::Missed {
                        surface: self.interfaces.len(),
                    },
                }
            }
            stopped => stopped,
        }
    }

    /// Where a ray meets the plane of the stop, disregarding its aperture.
    pub fn trace_to_stop(&self, ray: Ray) -> Option<DVec3> {
        let inside = trace_into(self.front(), ray).ray()?;
        inside
            .at_depth(self.stop_z_mm())
            .filter(|point| (point.z - inside.origin.z) * inside.direction.z >= 0.0)
    }
}

/// A uniform medium.
const fn uniform(n: f64) -> IndexField {
    IndexField::Uniform(n)
}

/// A gradient whose ζ counts from the surface of its row.
const fn gradient(axial: [f64; 3], radial: f64) -> IndexField {
    IndexField::Gradient(LensGradient {
        z_mm: 0.0,
        axial,
        radial,
    })
}

#[cfg(test)]
mod tests;
