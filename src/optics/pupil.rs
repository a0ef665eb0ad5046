//! The pupil as it looks: the stop seen through the cornea (entrance pupil) or through the lens (exit
//! pupil), by real rays.
//!
//! In: a patient's cornea, the depth, size and place of the hole in the iris, and a viewer: a
//! direction or a camera. Out: the outline that the viewer sees, as points in a plane through the
//! stop's centre and square to the line of sight (mm), with its extents and its best ellipse.
//!
//! For every point of the stop's edge the ray from the viewer that passes through it is found by
//! Newton's method on the exact trace (François' two-point problem, for one surface or two). There
//! is no paraxial assumption, so that the outline at 80° is as exact as at 0°.
//!
//! **Axes of the view.** `u` points to the patient's right (+x) and `w` up as far as the line of sight
//! allows: azimuth turns the viewer to +x, elevation up (+y).

mod magnification;
pub(super) mod search;

pub use magnification::entrance_pupil_magnification;

use super::ray_trace::{Interface, Ray, trace_into, trace_out_of};
use super::schematic_eye::SchematicEye;
use super::surface::{Crossing, Placed, Quadric};
use core::f64::consts::TAU;
use glam::{DMat2, DVec2, DVec3};
use search::{find, search_start};
use thiserror::Error;

/// Points on an outline.
pub const OUTLINE_POINTS: usize = 64;

/// A patient's anterior eye, as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnteriorSegment {
    /// Anterior cornea: apical radius (mm, 4 to 15) and shape factor p = 1 + Q (−1 to 2).
    pub anterior: DVec2,
    /// Posterior cornea, the same; `None` lets one surface stand for the cornea.
    pub posterior: Option<DVec2>,
    /// Central thickness (mm, 0.1 to 1.5); not used with one surface.
    pub thickness_mm: f64,
    /// Index of the cornea (1 to 2); not used with one surface.
    pub cornea_index: f64,
    /// Index of the aqueous (1 to 2).
    pub aqueous_index: f64,
    /// Radius within which the cornea is clear (mm, 3 to 8).
    pub clear_radius_mm: f64,
    /// Plane of the pupil behind the corneal apex (mm, 1.5 to 6).
    pub iris_depth_mm: f64,
    /// Diameters of the hole along its own axes (mm, 0.2 to 10).
    pub pupil_diameters_mm: DVec2,
    /// Turn of those axes from x towards y (rad).
    pub pupil_axis_rad: f64,
    /// Centre of the hole from the corneal axis (mm, up to 2).
    pub pupil_centre_mm: DVec2,
}

impl Default for AnteriorSegment {
    /// The cornea of Escudero-Sanz & Navarro 1999 with a centred round hole of 3 mm.
    fn default() -> Self {
        Self {
            anterior: DVec2::new(7.72, 0.74),
            posterior: Some(DVec2::new(6.5, 1.0)),
            thickness_mm: 0.55,
            cornea_index: 1.376,
            aqueous_index: 1.3374,
            clear_radius_mm: 5.85,
            iris_depth_mm: 3.6,
            pupil_diameters_mm: DVec2::splat(3.0),
            pupil_axis_rad: 0.0,
            pupil_centre_mm: DVec2::ZERO,
        }
    }
}

/// Who looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewer {
    /// Someone far away. Azimuth to the patient's right and elevation (rad) of the direction from eye
    /// to viewer, from the corneal axis.
    Direction {
        /// To +x.
        azimuth: f64,
        /// To +y.
        elevation: f64,
    },
    /// A camera's entrance pupil, in the optics frame (mm), in front of the eye (z below 0).
    Camera(DVec3),
}

/// Why there is no outline.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PupilError {
    /// A measurement is impossible.
    #[error("{field} is {value}, which is not between {low} and {high}")]
    OutOfRange {
        /// Which.
        field: &'static str,
        /// What it was.
        value: f64,
        /// The least allowed.
        low: f64,
        /// The most allowed.
        high: f64,
    },
    /// The viewer is behind the eye, inside it, or not a place.
    #[error("nobody can look into the eye from there")]
    NoView,
    /// No ray from the viewer reaches the centre of the stop.
    #[error("the pupil cannot be seen from there")]
    NotVisible,
}

/// An ellipse in the plane of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Centre (mm).
    pub centre_mm: DVec2,
    /// Longer diameter (mm).
    pub major_mm: f64,
    /// Shorter diameter (mm).
    pub minor_mm: f64,
    /// Turn of the longer axis from u towards w (rad, −π/2 to π/2).
    pub axis_rad: f64,
    /// Root mean square distance of the outline's points from the ellipse's (mm).
    pub misfit_mm: f64,
}

/// The pupil in the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilView {
    /// Points of the outline along (u, w) from the place where the stop's centre would look to be
    /// without a cornea (mm): edge points of the stop at equal steps of its parameter angle.
    pub outline: [DVec2; OUTLINE_POINTS],
    /// Which of them a ray reaches through the clear cornea. The others would be seen through cornea
    /// that the limbus covers, or (no ray at all reaches them) stand in the outline at their neighbour.
    /// Extents and ellipse are those of the whole outline, so ask [`Self::is_whole`] first.
    pub visible: [bool; OUTLINE_POINTS],
    /// Where the centre of the stop looks to be (mm), in the same axes: its shift by refraction.
    pub stop_centre_mm: DVec2,
    /// Unit vector in the view along which the pupil is foreshortened; u for a viewer straight ahead.
    pub oblique: DVec2,
}

impl PupilView {
    /// Whether all of the edge is visible.
    pub fn is_whole(&self) -> bool {
        self.visible.iter().all(|&v| v)
    }

    /// Share of the edge that is visible.
    pub fn visible_share(&self) -> f64 {
        self.visible.iter().filter(|&&v| v).count() as f64 / OUTLINE_POINTS as f64
    }

    /// Extent of the outline along a unit vector of the view (mm), and the middle of it. The extreme
    /// is interpolated between points: exact for an ellipse, to 1e-5 of the extent otherwise.
    pub fn extent_along(&self, axis: DVec2) -> (f64, f64) {
        let value = |i: usize| self.outline[i % OUTLINE_POINTS].dot(axis);
        let extreme = |sign: f64| {
            let top = (0..OUTLINE_POINTS)
                .max_by(|&i, &j| (sign * value(i)).total_cmp(&(sign * value(j))))
                .unwrap_or(0);
            let (before, here, after) =
                (value(top + OUTLINE_POINTS - 1), value(top), value(top + 1));
            // The extreme of the cosine through three points at equal steps: exact for an ellipse.
            let (sin, cos) = parameter(1).sin_cos();
            let amplitude = (2.0 * here - before - after) / (2.0 * (1.0 - cos));
            let slope = (after - before) / (2.0 * sin);
            here - amplitude + sign * amplitude.hypot(slope)
        };
        let (high, low) = (extreme(1.0), extreme(-1.0));
        (high - low, 0.5 * (high + low))
    }

    /// Extent along u (mm).
    pub fn width_mm(&self) -> f64 {
        self.extent_along(DVec2::X).0
    }

    /// Extent along w (mm).
    pub fn height_mm(&self) -> f64 {
        self.extent_along(DVec2::Y).0
    }

    /// Extent in the direction of foreshortening over the extent square to it.
    pub fn ratio(&self) -> f64 {
        self.extent_along(self.oblique).0 / self.extent_along(self.oblique.perp()).0
    }

    /// The ellipse nearest to the outline: its first Fourier harmonic, which is the least-squares
    /// ellipse of points at equal steps of the parameter.
    pub fn ellipse(&self) -> Ellipse {
        let (mut mean, mut forward, mut backward) = (DVec2::ZERO, DVec2::ZERO, DVec2::ZERO);
        for (i, point) in self.outline.iter().enumerate() {
            let turn = DVec2::from_angle(-TAU * i as f64 / OUTLINE_POINTS as f64);
            mean += *point;
            forward += turn.rotate(*point);
            backward += DVec2::new(turn.x, -turn.y).rotate(*point);
        }
        let scale = 1.0 / OUTLINE_POINTS as f64;
        (mean, forward, backward) = (scale * mean, scale * forward, scale * backward);
        let misfit = self
            .outline
            .iter()
            .enumerate()
            .map(|(i, point)| {
                let turn = DVec2::from_angle(TAU * i as f64 / OUTLINE_POINTS as f64);
                let on_ellipse =
                    mean + turn.rotate(forward) + DVec2::new(turn.x, -turn.y).rotate(backward);
                point.distance_squared(on_ellipse)
            })
            .sum::<f64>();
        let (f, b) = (forward.length(), backward.length());
        let axis = if b > 0.0 {
            0.5 * (forward.to_angle() + backward.to_angle())
        } else {
            0.0
        };
        let half = 0.5 * core::f64::consts::PI;
        Ellipse {
            centre_mm: mean,
            major_mm: 2.0 * (f + b),
            minor_mm: 2.0 * (f - b).abs(),
            axis_rad: (axis + half).rem_euclid(2.0 * half) - half,
            misfit_mm: (scale * misfit).sqrt(),
        }
    }
}

/// The entrance pupil of `eye` as `viewer` sees it.
pub fn entrance_pupil(eye: &AnteriorSegment, viewer: Viewer) -> Result<PupilView, PupilError> {
    eye.check()?;
    let (surfaces, count) = eye.surfaces();
    let surfaces = &surfaces[..count];
    let z = eye.iris_depth_mm;
    let centre = eye.pupil_centre_mm.extend(z);
    let view = View::new(viewer, centre)?;
    let clear = eye.clear_radius_mm;
    let enters = |ray: Ray| {
        surfaces[0]
            .placed
            .crossing(ray.origin, ray.direction, Crossing::Inward)
            .is_some_and(|hit| hit.point.truncate().length() <= clear)
    };
    let to_stop = |at: DVec2| {
        let ray = view.ray(at)?;
        let inside = trace_into(surfaces, ray).ray()?;
        let forward = inside.direction.z > 0.0 && inside.origin.z <= z;
        forward.then(|| inside.at_depth(z)).flatten()
    };
    outline(
        &view,
        eye.edge(),
        |at| to_stop(at).map(|point| point.truncate()),
        |at| view.ray(at).is_some_and(enters),
    )
}

/// The exit pupil of a schematic eye with a round stop of `stop_radius_mm`, as the point `retina_mm`
/// of the optics frame sees it through the lens. The view's axes are those of a viewer there: u along
/// +x, w along +y as far as the line of sight allows.
pub fn exit_pupil(
    eye: &SchematicEye,
    stop_radius_mm: f64,
    retina_mm: DVec3,
) -> Result<PupilView, PupilError> {
    in_range("the radius of the stop", stop_radius_mm, 0.05, 6.0)?;
    let stop = eye.interfaces[eye.stop].placed.vertex;
    if !retina_mm.is_finite() || retina_mm.z <= stop.z {
        return Err(PupilError::NoView);
    }
    let view = View::towards(retina_mm, stop)?;
    let to_stop = |at: DVec2| {
        let inside = trace_out_of(eye.rear(), view.ray(at)?).ray()?;
        let forward = inside.direction.z < 0.0 && inside.origin.z >= stop.z;
        let point = forward.then(|| inside.at_depth(stop.z)).flatten()?;
        Some(point.truncate())
    };
    let edge = core::array::from_fn(|i| {
        stop.truncate() + stop_radius_mm * DVec2::from_angle(parameter(i))
    });
    outline(&view, (stop.truncate(), edge), to_stop, |_| true)
}

fn parameter(i: usize) -> f64 {
    TAU * i as f64 / OUTLINE_POINTS as f64
}

fn in_range(field: &'static str, value: f64, low: f64, high: f64) -> Result<(), PupilError> {
    // Also refuses what is not a number.
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(PupilError::OutOfRange {
            field,
            value,
            low,
            high,
        })
    }
}

impl AnteriorSegment {
    /// Whether the measurements are possible.
    pub fn check(&self) -> Result<(), PupilError> {
        in_range("the anterior corneal radius", self.anterior.x, 4.0, 15.0)?;
        in_range("the anterior shape factor", self.anterior.y, -1.0, 2.0)?;
        if let Some(posterior) = self.posterior {
            in_range("the posterior corneal radius", posterior.x, 3.0, 15.0)?;
            in_range("the posterior shape factor", posterior.y, -1.0, 2.0)?;
            in_range("the corneal thickness", self.thickness_mm, 0.1, 1.5)?;
            in_range("the corneal index", self.cornea_index, 1.0, 2.0)?;
        }
        in_range("the aqueous index", self.aqueous_index, 1.0, 2.0)?;
        in_range("the clear radius", self.clear_radius_mm, 3.0, 8.0)?;
        in_range("the depth of the iris", self.iris_depth_mm, 1.5, 6.0)?;
        in_range("a pupil diameter", self.pupil_diameters_mm.x, 0.2, 10.0)?;
        in_range("a pupil diameter", self.pupil_diameters_mm.y, 0.2, 10.0)?;
        in_range("the pupil's axis", self.pupil_axis_rad, -TAU, TAU)?;
        in_range(
            "the pupil's decentration",
            self.pupil_centre_mm.x,
            -2.0,
            2.0,
        )?;
        in_range(
            "the pupil's decentration",
            self.pupil_centre_mm.y,
            -2.0,
            2.0,
        )
    }

    /// The cornea as surfaces to trace, and how many there are.
    fn surfaces(&self) -> ([Interface; 2], usize) {
        let conicoid = |shape: DVec2, z| Placed::at(Quadric::conicoid(shape.x, shape.y), z);
        let single = Interface::uniform(conicoid(self.anterior, 0.0), 1.0, self.aqueous_index);
        match self.posterior {
            None => ([single; 2], 1),
            Some(posterior) => {
                let front = Interface::uniform(single.placed, 1.0, self.cornea_index);
                let back = Interface::uniform(
                    conicoid(posterior, self.thickness_mm),
                    self.cornea_index,
                    self.aqueous_index,
                );
                ([front, back], 2)
            }
        }
    }

    /// Centre and edge of the hole in the plane of the iris.
    fn edge(&self) -> (DVec2, [DVec2; OUTLINE_POINTS]) {
        let axis = DVec2::from_angle(self.pupil_axis_rad);
        let edge = core::array::from_fn(|i| {
            let on_circle = DVec2::from_angle(parameter(i));
            self.pupil_centre_mm + axis.rotate(0.5 * self.pupil_diameters_mm * on_circle)
        });
        (self.pupil_centre_mm, edge)
    }
}

/// The plane of view, through the stop's centre.
struct View {
    centre: DVec3,
    u: DVec3,
    w: DVec3,
    /// Direction from the viewer to the stop's centre.
    sight: DVec3,
    /// Where the viewer is, unless far away.
    from: Option<DVec3>,
}

impl View {
    fn new(viewer: Viewer, centre: DVec3) -> Result<Self, PupilError> {
        match viewer {
            Viewer::Camera(from) => {
                if !from.is_finite() || from.z >= 0.0 {
                    return Err(PupilError::NoView);
                }
                Self::towards(from, centre)
            }
            Viewer::Direction { azimuth, elevation } => {
                let limit = 0.5 * core::f64::consts::PI;
                if !(azimuth.abs() < limit && elevation.abs() < limit) {
                    return Err(PupilError::NoView);
                }
                let (sin_a, cos_a) = azimuth.sin_cos();
                let (sin_e, cos_e) = elevation.sin_cos();
                Ok(Self {
                    centre,
                    u: DVec3::new(cos_a, 0.0, sin_a),
                    w: DVec3::new(-sin_a * sin_e, cos_e, cos_a * sin_e),
                    sight: DVec3::new(-sin_a * cos_e, -sin_e, cos_a * cos_e),
                    from: None,
                })
            }
        }
    }

    fn towards(from: DVec3, centre: DVec3) -> Result<Self, PupilError> {
        let sight = (centre - from).try_normalize().ok_or(PupilError::NoView)?;
        let forward = if sight.z >= 0.0 { 1.0 } else { -1.0 };
        // Level, as for a direction: never along y, for the viewer is in front or behind.
        let u = forward
            * DVec3::Y
                .cross(sight)
                .try_normalize()
                .ok_or(PupilError::NoView)?;
        Ok(Self {
            centre,
            u,
            w: forward * sight.cross(u),
            sight,
            from: Some(from),
        })
    }

    /// The ray of the viewer through the point (u, w) of the plane of view.
    fn ray(&self, at: DVec2) -> Option<Ray> {
        let through = self.centre + at.x * self.u + at.y * self.w;
        match self.from {
            Some(from) => Ray::new(from, through - from),
            // In front of every cornea.
            None => Some(Ray {
                origin: through - 30.0 * self.sight,
                direction: self.sight,
            }),
        }
    }

    /// Direction in the view along which a disc square to the axis is foreshortened.
    fn oblique(&self) -> DVec2 {
        DVec2::new(self.u.z, self.w.z)
            .try_normalize()
            .unwrap_or(DVec2::X)
    }
}

/// Finds the whole outline: the centre of the stop first, then its edge, each point from its
/// neighbour.
fn outline(
    view: &View,
    (centre, edge): (DVec2, [DVec2; OUTLINE_POINTS]),
    to_stop: impl Fn(DVec2) -> Option<DVec2>,
    enters: impl Fn(DVec2) -> bool,
) -> Result<PupilView, PupilError> {
    let oblique = view.oblique();
    let start = search_start(centre, oblique, &to_stop).ok_or(PupilError::NotVisible)?;
    let (middle, slope) = find(centre, start, None, &to_stop).ok_or(PupilError::NotVisible)?;
    let mut outline = [middle; OUTLINE_POINTS];
    let mut visible = [false; OUTLINE_POINTS];
    let outwards = |target: DVec2| {
        let mut state = (middle, slope);
        for quarter in 1..=4 {
            let on_the_way = centre.lerp(target, 0.25 * f64::from(quarter));
            state = find(on_the_way, state.0, Some(state.1), &to_stop)?;
        }
        Some(state)
    };
    let mut last: Option<(DVec2, DMat2)> = None;
    for i in 0..OUTLINE_POINTS {
        // From the last point found by its Jacobian; from the centre where there is none.
        let found = last
            .and_then(|(at, slope)| {
                let along = slope.inverse() * (edge[i] - edge[i - 1]);
                find(edge[i], at + along, Some(slope), &to_stop)
            })
            .or_else(|| outwards(edge[i]));
        match found {
            Some((at, _)) => {
                outline[i] = at;
                visible[i] = enters(at);
            }
            None if i > 0 => outline[i] = outline[i - 1],
            None => {}
        }
        last = found;
    }
    Ok(PupilView {
        outline,
        visible,
        stop_centre_mm: middle,
        oblique,
    })
}

#[cfg(test)]
mod tests;
