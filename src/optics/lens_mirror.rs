//! What the inner surfaces of the eye mirror: the second, third and fourth Purkinje images, by the exact
//! path of a view ray through them.
//!
//! In: a ray inside the eye (optics frame, mm, unit direction), the eye's surfaces and indices. Out: the
//! direction outside from which a light is mirrored along that ray, and how much of it.
//!
//! Twin: `shaders/lib/lens_mirror.wgsl`.

use super::conicoid::{conicoid_intersect, conicoid_normal};
use super::fresnel::fresnel_dielectric;
use super::ray_trace::Interface;
use super::schematic_eye::{SODIUM_NM, SchematicEye};
use super::snell::snell_refract;
use glam::{DVec2, DVec3};

/// The eye's surfaces, each `DVec2(apical radius in mm, shape factor p)`; the back of the lens bulges into
/// the eye and its radius is positive here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorEye {
    /// Front of the cornea.
    pub anterior: DVec2,
    /// Back of the cornea.
    pub posterior: DVec2,
    /// Front of the lens.
    pub lens_front: DVec2,
    /// Back of the lens.
    pub lens_back: DVec2,
    /// Of the cornea, mm.
    pub thickness: f64,
    /// From the cornea's apex to the lens's, mm.
    pub lens_depth: f64,
    /// Of the lens, mm.
    pub lens_thickness: f64,
    /// Index of the cornea.
    pub n_cornea: f64,
    /// Index of the aqueous, and of the vitreous.
    pub n_aqueous: f64,
    /// Index that bends light as the whole lens does.
    pub n_lens: f64,
}

/// The surfaces of a lens, as in [`MirrorEye`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensShape {
    /// Apical radius (mm) and shape factor of its front.
    pub front: DVec2,
    /// Those of its back.
    pub back: DVec2,
    /// Its thickness, mm.
    pub thickness_mm: f64,
    /// Its equivalent index.
    pub index: f64,
    /// How far its front has moved from where it stands relaxed, mm; negative towards the cornea.
    pub forward_mm: f64,
}

/// Depth of the front of Navarro's relaxed lens behind the corneal apex, mm.
const RELAXED_DEPTH_MM: f64 = 3.6;

impl LensShape {
    /// The lens of Navarro, Santamaría and Bescós 1985, accommodated by 0 to 10 D; anything else is taken to the
    /// nearer end, NaN to 0.
    pub fn accommodated(accommodation_d: f64) -> Self {
        let eye = SchematicEye::navarro(accommodation_d, SODIUM_NM);
        let [front, back] = [&eye.rear()[0], &eye.rear()[1]];
        let shape = |of: &Interface| {
            let curvature = of.placed.surface.curvature;
            DVec2::new(1.0 / curvature.x.abs(), curvature.z / curvature.x)
        };
        Self {
            front: shape(front),
            back: shape(back),
            thickness_mm: back.placed.vertex.z - front.placed.vertex.z,
            index: front.back.at(front.placed.vertex),
            forward_mm: front.placed.vertex.z - RELAXED_DEPTH_MM,
        }
    }
}

/// Index of the cortex just behind the capsule, which is what reflects; the rest of a lens only bends
/// (Le Grand's images are five times brighter, of a lens of 1.42 throughout).
pub const LENS_EDGE_INDEX: f64 = 1.3726;

/// What a surface mirrors along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensMirrored {
    /// Unit direction outside, away from the eye, from which the light comes; zero where there is none.
    pub direction: DVec3,
    /// Where it leaves the cornea, mm.
    pub exit: DVec3,
    /// Where it crosses the front of the lens on its way out, or is mirrored by the cornea, mm.
    pub crossing: DVec2,
    /// Reflectance of the surface.
    pub share: f64,
}

fn reflect(dir: DVec3, normal: DVec3) -> DVec3 {
    dir - 2.0 * dir.dot(normal) * normal
}

/// The same where `found`; elsewhere without a direction.
fn only_if(found: bool, mut image: LensMirrored) -> LensMirrored {
    if !found {
        image.direction = DVec3::ZERO;
    }
    image
}

/// From a place in the cornea out of the eye.
pub fn mirror_exit(
    back: DVec3,
    dir: DVec3,
    eye: &MirrorEye,
    crossing: DVec2,
    share: f64,
) -> LensMirrored {
    let t = conicoid_intersect(back, dir, eye.anterior.x, eye.anterior.y);
    let front = back + t * dir;
    let normal = conicoid_normal(front, eye.anterior.x, eye.anterior.y);
    let outside = snell_refract(dir, normal, eye.n_cornea);
    let image = LensMirrored {
        direction: outside.truncate(),
        exit: front,
        crossing,
        share,
    };
    only_if(t >= 0.0 && outside.w > 0.5 && outside.z < 0.0, image)
}

/// From a place before the lens out of the eye; what it crossed and by how much it is mirrored is handed on.
pub fn mirror_leave(
    start: DVec3,
    dir: DVec3,
    eye: &MirrorEye,
    crossing: DVec2,
    share: f64,
) -> LensMirrored {
    let back_apex = DVec3::new(0.0, 0.0, eye.thickness);
    let s = conicoid_intersect(start - back_apex, dir, eye.posterior.x, eye.posterior.y);
    let back = start + s * dir;
    let normal = conicoid_normal(back - back_apex, eye.posterior.x, eye.posterior.y);
    let inside = snell_refract(dir, normal, eye.n_aqueous / eye.n_cornea);
    let image = mirror_exit(back, inside.truncate(), eye, crossing, share);
    only_if(s >= 0.0 && inside.w > 0.5, image)
}

/// Light mirrored by the back of the cornea (II) along a ray in it, from its `entry`.
pub fn mirror_cornea(entry: DVec3, dir: DVec3, eye: &MirrorEye) -> LensMirrored {
    let back_apex = DVec3::new(0.0, 0.0, eye.thickness);
    let s = conicoid_intersect(entry - back_apex, dir, eye.posterior.x, eye.posterior.y);
    let back = entry + s * dir;
    let normal = conicoid_normal(back - back_apex, eye.posterior.x, eye.posterior.y);
    let share = fresnel_dielectric(dir.dot(normal).abs(), eye.n_cornea, eye.n_aqueous);
    let image = mirror_exit(back, reflect(dir, normal), eye, back.truncate(), share);
    only_if(s >= 0.0, image)
}

/// Light mirrored by the front of the lens (III) along a ray in the aqueous through `point`.
pub fn mirror_lens_front(point: DVec3, dir: DVec3, eye: &MirrorEye) -> LensMirrored {
    let apex = DVec3::new(0.0, 0.0, eye.lens_depth);
    let start = point - 2.0 * dir;
    let t = conicoid_intersect(start - apex, dir, eye.lens_front.x, eye.lens_front.y);
    let hit = start + t * dir;
    let normal = conicoid_normal(hit - apex, eye.lens_front.x, eye.lens_front.y);
    let share = fresnel_dielectric(dir.dot(normal).abs(), eye.n_aqueous, LENS_EDGE_INDEX);
    let image = mirror_leave(hit, reflect(dir, normal), eye, hit.truncate(), share);
    only_if(t >= 0.0, image)
}

/// Light mirrored by the back of the lens (IV) along a ray in the aqueous through `point`.
pub fn mirror_lens_back(point: DVec3, dir: DVec3, eye: &MirrorEye) -> LensMirrored {
    let apex = DVec3::new(0.0, 0.0, eye.lens_depth);
    let (front, back) = (eye.lens_front, eye.lens_back);
    let start = point - 2.0 * dir;
    let t = conicoid_intersect(start - apex, dir, front.x, front.y);
    let hit = start + t * dir;
    let normal = conicoid_normal(hit - apex, front.x, front.y);
    let into = snell_refract(dir, normal, eye.n_aqueous / eye.n_lens);
    // The back is a front that is seen from behind.
    let flip = DVec3::new(1.0, 1.0, -1.0);
    let back_apex = DVec3::new(0.0, 0.0, eye.lens_depth + eye.lens_thickness);
    let inside = into.truncate();
    let s = conicoid_intersect((hit - back_apex) * flip, inside * flip, back.x, back.y);
    let turned = hit + s * inside;
    let normal = conicoid_normal((turned - back_apex) * flip, back.x, back.y) * flip;
    let away = reflect(inside, normal);
    let u = conicoid_intersect(turned - apex, away, front.x, front.y);
    let again = turned + u * away;
    let out = snell_refract(
        away,
        conicoid_normal(again - apex, front.x, front.y),
        eye.n_lens / eye.n_aqueous,
    );
    let share = fresnel_dielectric(inside.dot(normal).abs(), LENS_EDGE_INDEX, eye.n_aqueous);
    let image = mirror_leave(again, out.truncate(), eye, again.truncate(), share);
    let found = t >= 0.0 && s >= 0.0 && u >= 0.0 && into.w * out.w > 0.5;
    only_if(found, image)
}

#[cfg(test)]
mod tests {
    use super::super::cornea::{cornea_trace, cornea_trace_single};
    use super::*;
    use proptest::prelude::*;

    /// Le Grand's theoretical eye.
    const LE_GRAND: MirrorEye = MirrorEye {
        anterior: DVec2::new(7.8, 1.0),
        posterior: DVec2::new(6.5, 1.0),
        lens_front: DVec2::new(10.2, 1.0),
        lens_back: DVec2::new(6.0, 1.0),
        thickness: 0.55,
        lens_depth: 3.6,
        lens_thickness: 4.0,
        n_cornea: 1.3771,
        n_aqueous: 1.3374,
        n_lens: 1.42,
    };

    /// Which image, along a view ray from far away that meets the plane of the apex `height` mm off the axis with this slope.
    fn seen(image: usize, height: f64, slope: f64, eye: &MirrorEye) -> LensMirrored {
        let dir = DVec3::new(slope, 0.0, 1.0).normalize();
        let origin = DVec3::new(height, 0.0, 0.0) - dir * (20.0 / dir.z);
        let e = eye;
        if image == 2 {
            let t = cornea_trace_single(origin, dir, e.anterior, e.n_cornea, e.lens_depth);
            return mirror_cornea(t.entry, t.direction, e);
        }
        let t = cornea_trace(
            origin,
            dir,
            e.anterior,
            e.posterior,
            e.thickness,
            e.n_cornea,
            e.n_aqueous,
            e.lens_depth,
        );
        assert_eq!(t.valid, 1.0);
        if image == 3 {
            mirror_lens_front(t.point, t.direction, e)
        } else {
            mirror_lens_back(t.point, t.direction, e)
        }
    }

    /// Depth of an image of a light far ahead, mm, and how far off the axis that of a light 1 rad aside
    /// would be, in that of the first image, R/2.
    fn image(number: usize, eye: &MirrorEye) -> [f64; 2] {
        let (h, slope) = (1e-4, 1e-4);
        // What is mirrored is linear near the axis: direction = a·height + b·slope.
        let a = seen(number, h, 0.0, eye).direction.x / h;
        let b = seen(number, 0.0, slope, eye).direction.x / slope;
        // A light ahead is seen along rays of a·height + b·slope = 0, which cross the axis at −height/slope.
        // One aside by θ: there a·height + b·slope = θ, so height + depth·slope = θ/a.
        [b / a, (1.0 / a) / (0.5 * eye.anterior.x)]
    }

    /// Le Grand's images: depth (mm) and size against the first one's.
    #[test]
    fn the_images_stand_where_le_grand_has_them() {
        for (number, depth, size) in [(2, 3.61, 0.82), (3, 10.7, 1.97), (4, 4.34, -0.76)] {
            let [found_depth, found_size] = image(number, &LE_GRAND);
            println!("{number}: depth {found_depth:.3} mm, size {found_size:.3}");
            // Half of the last figure that is printed, and what the printed indices leave open.
            assert!(
                (found_depth - depth).abs() < 0.06,
                "{number}: {found_depth}"
            );
            assert!((found_size - size).abs() < 0.011, "{number}: {found_size}");
        }
        // A lens nearer by half a millimetre has other images.
        let nearer = MirrorEye {
            lens_depth: 3.1,
            ..LE_GRAND
        };
        assert!((image(3, &nearer)[0] - 10.7).abs() > 0.3);
    }

    #[test]
    fn a_lens_that_accommodates_is_navarros() {
        let relaxed = LensShape::accommodated(0.0);
        assert!((relaxed.front - DVec2::new(10.2, -2.1316)).length() < 1e-12);
        assert!((relaxed.back - DVec2::new(6.0, 0.0)).length() < 1e-12);
        assert!((relaxed.thickness_mm - 4.0).abs() < 1e-12 && (relaxed.index - 1.42).abs() < 1e-12);
        // The third image of an eye that looks near is smaller and nearer to the cornea.
        let of = |accommodation_d| {
            let lens = LensShape::accommodated(accommodation_d);
            image(
                3,
                &MirrorEye {
                    lens_front: lens.front,
                    lens_back: lens.back,
                    lens_thickness: lens.thickness_mm,
                    lens_depth: LE_GRAND.lens_depth + lens.forward_mm,
                    n_lens: lens.index,
                    ..LE_GRAND
                },
            )
        };
        assert!(of(6.0)[1] < 0.8 * of(0.0)[1] && of(6.0)[0] < of(0.0)[0]);
        // The chamber is shallower by 0.05 ln(1 + A).
        assert!(relaxed.forward_mm.abs() < 1e-12);
        let moved = LensShape::accommodated(6.0).forward_mm;
        assert!((moved + 0.05 * 7f64.ln()).abs() < 1e-12, "{moved}");
        assert!(LensShape::accommodated(f64::NAN) == relaxed);
    }

    #[test]
    fn they_are_as_faint_as_their_indices_say() {
        // Le Grand's second image: 0.021 %; III and IV of a cortex of 1.3726: 0.017 %.
        let share = |number| seen(number, 0.0, 0.0, &LE_GRAND).share;
        assert!((share(2) - 2.1e-4).abs() < 0.06e-4, "{}", share(2));
        for number in [3, 4] {
            assert!(
                (share(number) - 1.7e-4).abs() < 0.06e-4,
                "{}",
                share(number)
            );
        }
        // Of a lens of 1.42 throughout they would be 0.09 %.
        assert!((fresnel_dielectric(1.0, 1.3374, 1.42) - 9.0e-4).abs() < 0.2e-4);
    }

    proptest! {
        #[test]
        fn no_eye_mirrors_anything_but_numbers(
            point in prop::array::uniform2(-6.0..6.0_f64), aside in prop::array::uniform2(-3.0..3.0_f64),
            radii in prop::array::uniform4(2.0..20.0_f64), shapes in prop::array::uniform4(-5.0..2.0_f64),
            depths in prop::array::uniform3(0.2..6.0_f64), indices in prop::array::uniform3(1.0..1.6_f64),
        ) {
            let eye = MirrorEye {
                anterior: DVec2::new(radii[0], shapes[0]),
                posterior: DVec2::new(radii[1], shapes[1]),
                lens_front: DVec2::new(radii[2], shapes[2]),
                lens_back: DVec2::new(radii[3], shapes[3]),
                thickness: depths[0],
                lens_depth: depths[1],
                lens_thickness: depths[2],
                n_cornea: indices[0],
                n_aqueous: indices[1],
                n_lens: indices[2],
            };
            let at = DVec3::new(point[0], point[1], depths[1]);
            let dir = DVec3::new(aside[0], aside[1], 1.0).normalize();
            for found in [mirror_cornea(at, dir, &eye), mirror_lens_front(at, dir, &eye), mirror_lens_back(at, dir, &eye)] {
                prop_assert!(found.direction.is_finite() && found.crossing.is_finite(), "{found:?}");
                let length = found.direction.length();
                prop_assert!(length == 0.0 || (length - 1.0).abs() < 1e-9, "{found:?}");
                prop_assert!((0.0..=1.0).contains(&found.share), "{found:?}");
            }
        }
    }
}
