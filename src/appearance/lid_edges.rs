//! Where the lids' edges stand before the pupil: what they hide of the view.
//!
//! Enters: an eye, where it looks, how far its lids open. Leaves: [`LidEdges`], heights and distances from
//! the middle of the entrance pupil, for whoever sees through it. The margins are those that are drawn
//! (`lids`); a lid covers the view because it covers the pupil, and how sharply is the pupil's width.

use super::lids::{Fissure, Lid, LidPose};
use crate::anatomy::{Cornea, Eye, Gaze, Laterality};
use crate::optics::globe::{LIMBUS_BLEND_MM, globe_apex_distance, globe_radius_along};
use glam::{DVec2, Vec3};
use std::sync::LazyLock;

/// One edge from the middle of the entrance pupil, mm: up, and towards the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LidEdge {
    /// Up.
    pub height_mm: f64,
    /// Before it: the margin's posterior edge, which lies on the globe.
    pub ahead_mm: f64,
}

/// Both edges above and below the pupil.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LidEdges {
    /// Of the upper lid.
    pub upper: LidEdge,
    /// Of the lower lid.
    pub lower: LidEdge,
}

impl LidEdges {
    /// Do the lids leave anything open of a pupil of this radius, mm?
    pub fn leave_open(&self, pupil_radius_mm: f64) -> bool {
        let above = self.upper.height_mm.min(pupil_radius_mm);
        above > self.lower.height_mm.max(-pupil_radius_mm)
    }
}

/// The edges of an eye's lids; `aperture` from 0 (closed) to 1.2, 1 as at rest; `droop` of the upper lid alone, 0 to 1.
pub fn lid_edges(
    eye: &Eye,
    cornea: &Cornea,
    iris_depth_mm: f64,
    gaze: &Gaze,
    (aperture, droop): (f64, f64),
) -> LidEdges {
    static FISSURE: LazyLock<Fissure> = LazyLock::new(Fissure::default);
    // The lids are a right eye's; a left one is mirrored into it.
    let mirror = eye.laterality.temporal_sign();
    let mirrored = Gaze {
        azimuth_rad: gaze.azimuth_rad * mirror,
        torsion_rad: gaze.torsion_rad * mirror,
        ..*gaze
    };
    let right = Eye {
        laterality: Laterality::OD,
        ..eye.clone()
    };
    let axis = mirrored.globe_rotation(&right) * Vec3::NEG_Z;
    let surface = DVec2::new(cornea.anterior_radius_mm, cornea.anterior_p);
    let (sclera, limbus) = (eye.scleral_radius_mm, cornea.limbus_radius_mm);
    let globe_radius = |direction: Vec3| {
        let cosine = f64::from(axis.dot(direction)).clamp(-1.0, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        let direction = glam::DVec3::new(sine, 0.0, -cosine);
        globe_radius_along(direction, sclera, surface, limbus, LIMBUS_BLEND_MM) as f32
    };
    // The entrance pupil lies where the cornea's magnification shows it.
    let shown_mm = cornea.pupil_magnification(iris_depth_mm) * iris_depth_mm / cornea.aqueous_index;
    let apex = globe_apex_distance(sclera, surface, limbus);
    let pupil = axis * (apex - shown_mm) as f32;
    let pose = LidPose {
        aperture: aperture as f32,
        droop: droop as f32,
        gaze_azimuth_rad: mirrored.azimuth_rad as f32,
        gaze_elevation_rad: mirrored.elevation_rad as f32,
        squint: 0.0,
    };
    let edge = |lid: Lid| {
        let at = FISSURE.above(lid, pupil.x, &pose, &globe_radius);
        LidEdge {
            height_mm: f64::from(at.y - pupil.y),
            ahead_mm: f64::from(pupil.z - at.z),
        }
    };
    LidEdges {
        upper: edge(Lid::Upper),
        lower: edge(Lid::Lower),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(laterality: Laterality, gaze: Gaze, aperture: f64) -> LidEdges {
        hanging(laterality, gaze, (aperture, 0.0))
    }

    fn hanging(laterality: Laterality, gaze: Gaze, lids: (f64, f64)) -> LidEdges {
        let eye = Eye {
            laterality,
            scleral_radius_mm: 11.5,
            angle_alpha_deg: [5.45, 2.5],
        };
        let cornea = Cornea {
            anterior_radius_mm: 7.8,
            anterior_p: 0.75,
            posterior_radius_mm: 6.4,
            posterior_p: 0.725,
            thickness_mm: 0.55,
            index: 1.376,
            aqueous_index: 1.336,
            limbus_radius_mm: 5.85,
            lipid_thickness_nm: 55.0,
            tear_breakup_s: 20.0,
            arcus: None,
        };
        lid_edges(&eye, &cornea, 3.6, &gaze, lids)
    }

    #[test]
    fn the_upper_lid_stands_as_far_above_the_pupil_as_in_people() {
        for laterality in Laterality::BOTH {
            let open = edges(laterality, Gaze::default(), 1.0);
            // Margin reflex distances of adults: 4 to 5 mm above, 5 to 5.5 below.
            assert!((4.0..5.2).contains(&open.upper.height_mm), "{open:?}");
            assert!((-5.6..-4.3).contains(&open.lower.height_mm), "{open:?}");
            // One on the cornea's flank, 1 to 3 mm before the entrance pupil, the other near the limbus, which lies
            // half a millimetre before it.
            assert!((1.0..3.0).contains(&open.upper.ahead_mm), "{open:?}");
            assert!((0.4..1.2).contains(&open.lower.ahead_mm), "{open:?}");
            let closed = edges(laterality, Gaze::default(), 0.0);
            assert!(
                (closed.upper.height_mm - closed.lower.height_mm).abs() < 0.1,
                "{closed:?}"
            );
        }
        let [right, left] = Laterality::BOTH.map(|eye| edges(eye, Gaze::default(), 0.7));
        assert!((right.upper.height_mm - left.upper.height_mm).abs() < 1e-5);
    }

    #[test]
    fn a_hanging_lid_is_drawn_where_it_was_measured() {
        use crate::anatomy::{Iris, IrisColor, Lids, OcularMedia, Refraction, VisualField};
        use crate::conditions::{Affected, Condition, Ptosis};
        let iris = Iris {
            color: IrisColor::Brown,
            stroma_melanin_fraction: None,
            border_layer_melanin_fraction: None,
            collarette_melanin_fraction: None,
            eumelanin_ratio: None,
            depth_mm: 3.6,
            cone_deg: crate::anatomy::IRIS_CONE_DEG,
            bowing_mm: None,
            root_radius_mm: 6.05,
            freckles: 0.0,
            sector_deg: 0.0,
            sector_at_deg: 0.0,
            pupil_decentration_mm: [0.2, 0.0],
        };
        for mrd1_mm in [4.0, 3.0, 2.0, 1.0, 0.0, -1.0, -3.0] {
            let mut affected = Affected {
                field: VisualField::normal(Laterality::OD, 60.0),
                media: OcularMedia::healthy(60.0, 0.5),
                refraction: Refraction::default(),
                iris: iris.clone(),
                lids: Lids::default(),
            };
            Ptosis { mrd1_mm }.write(&mut affected);
            let lids = (affected.lids.opening, affected.lids.droop);
            let LidEdges { upper, lower } = hanging(Laterality::OD, Gaze::default(), lids);
            // The lower lid stays where it is.
            assert_eq!(lower, edges(Laterality::OD, Gaze::default(), 1.0).lower);
            // The reflex of a light beside the observer lies before the cornea's centre of curvature, the
            // edge is told from the entrance pupil behind it: both on an axis that points 2.5° down.
            let behind_mm = 7.8 - 1.13 * 3.6 / 1.336;
            let above_reflex = upper.height_mm - behind_mm * 2.5f64.to_radians().sin();
            println!(
                "MRD1 {mrd1_mm}: droop {:.3}, drawn {above_reflex:.2} mm above the reflex",
                lids.1
            );
            assert!(
                (above_reflex - mrd1_mm).abs() < 0.15,
                "{mrd1_mm}: {above_reflex}"
            );
        }
    }

    #[test]
    fn lids_follow_the_eye_down() {
        let down = Gaze {
            elevation_rad: -0.4,
            ..Gaze::default()
        };
        let edges = edges(Laterality::OD, down, 1.0);
        // The upper lid comes with it: it never uncovers much more than straight ahead.
        assert!((2.0..5.5).contains(&edges.upper.height_mm), "{edges:?}");
        assert!(edges.upper.height_mm.is_finite() && edges.lower.ahead_mm.is_finite());
    }
}
