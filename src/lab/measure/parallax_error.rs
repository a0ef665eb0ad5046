//! Where the iris is seen through the cornea: what simpler pictures of an eye make of it, beside real
//! rays through both surfaces.
//!
//! In: an eye. Leaves: one row a method and viewing angle, and one a method over all angles: the error
//! of the place on the iris that a ray lands on, as a share of the iris' radius.
//!
//! Painted: the iris lies on the front of the eye, as a texture on a ball does. Parallax: the eye-shading
//! notes' mapping, the unrefracted ray down to a plane whose depth is the one that errs least (their
//! depth scale, tuned as an artist would). The rest refract: at a sphere or at the front surface alone,
//! with the aqueous' index behind it or with the cornea's (as François et al. 2007 print it).

use super::MeasuredEye;
use crate::optics::cornea::{cornea_trace, cornea_trace_single, parallax_place};
use crate::optics::ray_trace::{Interface, Ray, trace_into};
use crate::optics::surface::{Placed, Quadric};
use glam::{DVec2, DVec3};
use serde::Serialize;

/// Citations.
pub const SOURCE: &[&str] = &[
    "François, Gautron, Breton & Bouatouch 2007, section 5.4 (refraction at one surface of index 1.376)",
    "eye-shading notes: parallax mapping by a depth scale",
    "reference: the patient's cornea, by real rays through both surfaces (crate::optics::ray_trace)",
];

/// Conventions.
pub const NOTES: &[&str] = &[
    "angle_deg counts from the corneal axis to a distant viewer; null in rows over all angles, 0 to 60 by 5.",
    "rms and largest are distances on the plane of the iris between where a method and where the \
     reference puts the same ray, over the limbus radius, in per cent; over rays on a grid that enter within \
     the limbus, meet the front of the eye and land within the limbus radius.",
    "methods: painted (the texture lies on the cornea), parallax (straight on to a plane at depth_mm, which is \
     fitted), sphere (a ball of the apical radius, index of the aqueous), one_surface_cornea (the true front, \
     index of the cornea), one_surface_aqueous (the true front, index of the aqueous), two_surfaces (what the \
     picture does, in 64 bits; in 32 bits on a device it is off by 1e-6 mm and less, as the tests of the twins \
     show). The rays that all are compared with are traced by another implementation, through the general quadrics of the \
     optics. A ray that a method loses errs by 100 %.",
];

/// Viewing angles (degrees), and rays along each side of the grid.
const ANGLES_DEG: [f64; 13] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0,
];
const RAYS: i32 = 81;
/// Steps of the search for the depth of a parallax mapping.
const DEPTH_STEPS: i32 = 400;

/// How a ray is taken to the iris.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    Painted,
    Parallax,
    Sphere,
    OneSurfaceCornea,
    OneSurfaceAqueous,
    TwoSurfaces,
}

const METHODS: [(Method, &str); 6] = [
    (Method::Painted, "painted"),
    (Method::Parallax, "parallax"),
    (Method::Sphere, "sphere"),
    (Method::OneSurfaceCornea, "one_surface_cornea"),
    (Method::OneSurfaceAqueous, "one_surface_aqueous"),
    (Method::TwoSurfaces, "two_surfaces"),
];

/// A method from one angle, or from all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParallaxRow {
    /// How the ray is taken to the iris.
    pub method: &'static str,
    /// Angle of the viewer (degrees); `null` for all of them.
    pub angle_deg: Option<f64>,
    /// Root mean square error, per cent of the limbus radius.
    pub rms_percent: f64,
    /// Largest error, per cent of the limbus radius.
    pub largest_percent: f64,
    /// Depth of the plane of a parallax mapping (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// Rays that were compared.
    pub rays: usize,
    /// Why something is `null`.
    #[serde(skip_serializing_if = "super::NullReasons::is_empty")]
    pub null_reasons: super::NullReasons,
}

/// A ray of the grid, where it enters, and where it really lands.
struct Looked {
    origin: DVec3,
    direction: DVec3,
    entry: DVec3,
    place: DVec2,
}

/// Rays from a distant viewer at this angle that really land on the iris.
fn looked(eye: &MeasuredEye, angle_deg: f64) -> Vec<Looked> {
    let (sine, cosine) = angle_deg.to_radians().sin_cos();
    // The optics frame: +z into the eye, the viewer towards +x.
    let direction = DVec3::new(-sine, 0.0, cosine);
    let across = DVec3::new(cosine, 0.0, sine);
    let surface = |radius, p, z| Placed::at(Quadric::conicoid(radius, p), z);
    let front = surface(eye.anterior_radius_mm, eye.anterior_shape_factor, 0.0);
    let back = surface(
        eye.posterior_radius_mm,
        eye.posterior_shape_factor,
        eye.corneal_thickness_mm,
    );
    let interfaces = [
        Interface::uniform(front, 1.0, eye.cornea_index),
        Interface::uniform(back, eye.cornea_index, eye.aqueous_index),
    ];
    let reach = 1.3 * eye.limbus_radius_mm;
    let mut found = Vec::new();
    for i in 0..RAYS {
        for j in 0..RAYS {
            let [u, v] = [i, j].map(|k| (2.0 * f64::from(k) / f64::from(RAYS - 1) - 1.0) * reach);
            let origin = across * u + DVec3::Y * v - direction * 30.0;
            let Some(ray) = Ray::new(origin, direction) else {
                continue;
            };
            let Some(out) = trace_into(&interfaces, ray).ray() else {
                continue;
            };
            let single = cornea_trace_single(
                origin,
                direction,
                eye.anterior(),
                eye.cornea_index,
                eye.iris_depth_mm,
            );
            let enters = single.valid > 0.5
                && single.entry.truncate().length() <= eye.limbus_radius_mm
                && out.origin.z < eye.iris_depth_mm;
            let place = out.at_depth(eye.iris_depth_mm).map(DVec3::truncate);
            if let (true, Some(place)) = (enters, place)
                && place.length() <= eye.limbus_radius_mm
            {
                found.push(Looked {
                    origin,
                    direction,
                    entry: single.entry,
                    place,
                });
            }
        }
    }
    found
}

/// Where a method puts a ray on the plane of the iris, mm.
fn place(eye: &MeasuredEye, method: Method, looked: &Looked, depth_mm: f64) -> Option<DVec2> {
    let single = |surface, index| {
        let (origin, direction) = (looked.origin, looked.direction);
        let trace = cornea_trace_single(origin, direction, surface, index, eye.iris_depth_mm);
        (trace.valid > 0.5).then(|| trace.point.truncate())
    };
    match method {
        Method::Painted => Some(looked.entry.truncate()),
        Method::Parallax => Some(parallax_place(looked.entry, looked.direction, depth_mm)),
        Method::Sphere => single(DVec2::new(eye.anterior_radius_mm, 1.0), eye.aqueous_index),
        Method::OneSurfaceCornea => single(eye.anterior(), eye.cornea_index),
        Method::OneSurfaceAqueous => single(eye.anterior(), eye.aqueous_index),
        Method::TwoSurfaces => {
            let trace = cornea_trace(
                looked.origin,
                looked.direction,
                eye.anterior(),
                eye.posterior(),
                eye.corneal_thickness_mm,
                eye.cornea_index,
                eye.aqueous_index,
                eye.iris_depth_mm,
            );
            (trace.valid > 0.5).then(|| trace.point.truncate())
        }
    }
}

/// Sum of squares, largest and number of the errors, in limbus radii. A ray that a method loses errs by one.
fn errors(eye: &MeasuredEye, method: Method, rays: &[Looked], depth_mm: f64) -> (f64, f64, usize) {
    let error = |ray: &Looked| {
        place(eye, method, ray, depth_mm).map_or(1.0, |found| {
            found.distance(ray.place) / eye.limbus_radius_mm
        })
    };
    let errors = rays.iter().map(error);
    errors.fold((0.0, 0.0, 0), |(sum, largest, count), error| {
        (sum + error * error, f64::max(largest, error), count + 1)
    })
}

/// All methods, each over all angles first.
pub fn rows(eye: &MeasuredEye) -> Vec<ParallaxRow> {
    let views: Vec<(f64, Vec<Looked>)> = ANGLES_DEG
        .iter()
        .map(|angle_deg| (*angle_deg, looked(eye, *angle_deg)))
        .collect();
    let over_all = |method, depth_mm| {
        let parts = views
            .iter()
            .map(|(_, rays)| errors(eye, method, rays, depth_mm));
        parts.fold((0.0, 0.0, 0), |(sum, largest, count), part| {
            (sum + part.0, f64::max(largest, part.1), count + part.2)
        })
    };
    // The depth at which a parallax mapping errs least.
    let depth_mm = (0..=DEPTH_STEPS)
        .map(|step| eye.iris_depth_mm * f64::from(step) / f64::from(DEPTH_STEPS))
        .min_by(|a, b| {
            let sum = |depth_mm: &f64| over_all(Method::Parallax, *depth_mm).0;
            sum(a).total_cmp(&sum(b))
        })
        .unwrap_or(eye.iris_depth_mm);
    let mut rows = Vec::new();
    for (method, name) in METHODS {
        let row = |angle_deg: Option<f64>, (sum, largest, rays): (f64, f64, usize)| {
            let mut null_reasons = super::NullReasons::new();
            if angle_deg.is_none() {
                null_reasons.insert("angle_deg", "over all angles".into());
            }
            ParallaxRow {
                method: name,
                angle_deg,
                rms_percent: 100.0 * (sum / rays.max(1) as f64).sqrt(),
                largest_percent: 100.0 * largest,
                depth_mm: (method == Method::Parallax).then_some(depth_mm),
                rays,
                null_reasons,
            }
        };
        rows.push(row(None, over_all(method, depth_mm)));
        for (angle_deg, rays) in &views {
            rows.push(row(Some(*angle_deg), errors(eye, method, rays, depth_mm)));
        }
    }
    rows
}
