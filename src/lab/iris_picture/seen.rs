//! What a pixel of an eye's picture shows of its iris, from the numbers and maps that its shader has.

use crate::appearance::GlobeMaterial;
use crate::appearance::illumination::{Illumination, Lamp};
use crate::appearance::images::MapView;
use crate::appearance::light_table::{iris_light, iris_sky_knot};
use crate::appearance::materials::{GlobePart, GlobeUniform};
use crate::appearance::shading::footprint::pixel_footprint;
use crate::appearance::shading::iris_relief::{
    IrisFrame, IrisMarch, IrisPlace, furrow_depth, iris_base, iris_landing, iris_place,
    tagged_pupil, thicken,
};
use crate::appearance::shading::iris_shade::{
    IrisMaps, IrisSurface, iris_ambient, iris_lamp, iris_surface, pupil_edge,
};
use crate::appearance::shading::lid_shade::{
    LIDS_SEND, LidShade, lid_lamp, lid_sky_within, lids_at,
};
use crate::appearance::shading::limbus::{LIMBUS_MM, limbus_place, limbus_share, limbus_width};
use crate::appearance::shading::near_light::{
    beam_gathers, beam_on, crosses_plane, iris_near_lamp, light_entry,
};
use crate::appearance::shading::surroundings::{
    ambient_light, lamp_from, lamp_radiance, surroundings_radiance,
};
use crate::appearance::shading::tear_layer::{BROKEN_BLUR, tear_age, tear_layer};
use crate::appearance::shading::tear_reflection::tear_reflection;
use crate::lab::headless::{Headless, HeadlessError};
use crate::optics::conicoid::conicoid_normal;
use crate::optics::cornea::{CorneaTrace, cornea_trace};
use crate::optics::lens_mirror::{MirrorEye, mirror_cornea};
use crate::optics::snell::snell_refract;
use crate::tissue::iris_reflectance::IrisTissue;
use bevy::camera::Projection;
use bevy::math::{DMat3, DVec2, DVec3, DVec4, UVec2};
use bevy::mesh::MeshTag;
use bevy::prelude::*;

/// How far (rad) the cornea and its back spread what they mirror (`CORNEA`'s and `SECOND_IMAGE_BLUR` of `shaders/eye/globe.wgsl`).
const CORNEA_BLUR: f64 = 0.012;
const SECOND_IMAGE_BLUR: f64 = 0.012;
/// Most of the way from the pupil to the root that is compared: behind it the dark angle begins.
const OUTERMOST: f64 = 0.97;

/// An eye's picture, as its shader is given it; eye frame, mm.
pub struct IrisPicture {
    pub(super) globe: GlobeUniform,
    pub(super) tissue: IrisTissue,
    pub(super) maps: IrisMaps,
    pub(super) frame: IrisFrame,
    illumination: Illumination,
    around: MapView,
    head_from_eye: DMat3,
    camera: DVec3,
    /// Age of the tear film, s.
    tears_s: f64,
    /// To the right, up and ahead of the camera.
    axes: [DVec3; 3],
    /// Tangent of half its field.
    half_field: f64,
    size: UVec2,
}

/// What is seen in a pixel that shows nothing but iris, behind the cornea.
pub struct SeenIris {
    pub(super) trace: CorneaTrace,
    /// Where the ray meets the mean iris, mm.
    pub(super) landing: DVec2,
    /// Place in the iris' map of that.
    pub(super) start: IrisPlace,
    /// Size of the pixel on the cornea, mm.
    pub(super) footprint: f64,
    direction: DVec3,
    shade: LidShade,
}

impl IrisPicture {
    /// What the stage's camera shows.
    ///
    /// # Errors
    /// Where the device does not hand over its maps.
    pub fn of(headless: &mut Headless, size: UVec2) -> Result<Self, HeadlessError> {
        let missing = || HeadlessError::ReadBack("there is no eye yet".into());
        let camera = headless.stage().eye;
        let world = headless.world();
        let mut globes =
            world.query::<(&MeshMaterial3d<GlobeMaterial>, &GlobalTransform, &MeshTag)>();
        let materials = world.resource::<Assets<GlobeMaterial>>();
        let cornea = globes.iter(world).find_map(|(material, place, tag)| {
            let material = materials.get(&material.0)?;
            (material.part == GlobePart::Cornea).then(|| (material.clone(), *place, tag.0))
        });
        let (material, place, tag) = cornea.ok_or_else(missing)?;
        let pupil = tagged_pupil(tag);
        let half_field = match world.get::<Projection>(camera) {
            Some(Projection::Perspective(own)) => (0.5 * f64::from(own.fov)).tan(),
            _ => return Err(missing()),
        };
        let camera = *world.get::<GlobalTransform>(camera).ok_or_else(missing)?;
        let eye_from_world = place.affine().inverse();
        let eye_from_camera = eye_from_world * camera.affine();
        let axis = |v: Vec3| eye_from_camera.transform_vector3(v).as_dvec3().normalize();
        let globe = material.globe;
        let tissue = &globe.tissue;
        let maps = IrisMaps {
            relief: headless.map(&material.iris_map, true)?,
            reflectance: headless.map(&material.reflectance_map, false)?,
            light: headless.map(&material.light_table, false)?,
        };
        Ok(Self {
            tissue: IrisTissue {
                border: tissue.border.as_dvec3(),
                border_melanin: tissue.border_melanin.as_dvec3(),
                border_scattering: tissue.border_scattering.as_dvec3(),
                border_fibrils: tissue.border_fibrils.as_dvec3(),
                stroma: tissue.stroma.as_dvec3(),
                stroma_scattering: tissue.stroma_scattering.as_dvec3(),
                stroma_fibrils: tissue.stroma_fibrils.as_dvec3(),
                weights: tissue.weights.as_dmat3(),
            },
            frame: IrisFrame {
                root: f64::from(globe.iris_root_mm),
                pupil,
                limbus: f64::from(globe.limbus_mm),
                relief: f64::from(globe.relief),
                center: globe.pupil_center_mm.as_dvec2(),
                thicken: thicken(pupil, f64::from(globe.iris_root_mm)),
                furrows: furrow_depth(pupil),
                cone: f64::from(globe.iris_shape.x),
                bow: f64::from(globe.iris_shape.y),
            },
            maps,
            illumination: material.illumination,
            around: headless.map(&material.around, false)?,
            head_from_eye: Mat3::from_mat4(globe.head_from_eye).as_dmat3(),
            camera: eye_from_camera.translation.as_dvec3(),
            tears_s: tear_age(tag),
            axes: [axis(Vec3::X), axis(Vec3::Y), axis(Vec3::NEG_Z)],
            half_field,
            size,
            globe,
        })
    }

    /// From the globe's centre to the corneal apex.
    fn apex(&self) -> DVec3 {
        DVec3::new(0.0, 0.0, -f64::from(self.globe.apex_mm))
    }

    pub(super) fn anterior(&self) -> DVec2 {
        DVec2::new(
            f64::from(self.globe.anterior_radius_mm),
            f64::from(self.globe.anterior_p),
        )
    }

    fn posterior(&self) -> DVec2 {
        DVec2::new(
            f64::from(self.globe.posterior_radius_mm),
            f64::from(self.globe.posterior_p),
        )
    }

    pub(super) fn aqueous(&self) -> f64 {
        f64::from(self.globe.aqueous_index)
    }

    pub(super) fn iris_depth(&self) -> f64 {
        f64::from(self.globe.iris_depth_mm)
    }

    /// What a pixel, counted row by row, shows of the iris; `None` where it shows anything else.
    pub fn seen(&self, pixel: usize) -> Option<SeenIris> {
        let size = self.size.as_dvec2();
        let at = UVec2::new(pixel as u32 % self.size.x, pixel as u32 / self.size.x);
        let ndc = (at.as_dvec2() + 0.5) / size * 2.0 - 1.0;
        let [right, up, ahead] = self.axes;
        let aside = DVec2::new(ndc.x * size.x / size.y, -ndc.y) * self.half_field;
        let direction = (ahead + right * aside.x + up * aside.y).normalize();
        // To the plane of the root, as the shader does.
        let root_mm = iris_base(1.0, &self.frame).x.max(0.0);
        let mut trace = cornea_trace(
            self.camera - self.apex(),
            direction,
            self.anterior(),
            self.posterior(),
            f64::from(self.globe.thickness_mm),
            f64::from(self.globe.cornea_index),
            self.aqueous(),
            self.iris_depth() + root_mm,
        );
        if trace.valid < 0.5 {
            return None;
        }
        trace.point -= trace.direction * (root_mm / trace.direction.z.max(0.05));
        let r = trace.entry.truncate().length();
        let own = f64::from(self.globe.lens_turn);
        let wide = LIMBUS_MM * limbus_width(trace.entry.truncate(), own);
        let limbus = self.frame.limbus;
        let landing = iris_landing(trace.point.truncate(), trace.direction, &self.frame);
        let start = iris_place(landing, &self.frame);
        let p = trace.entry + self.apex();
        let footprint = pixel_footprint(p.distance(self.camera), 1.0 / self.half_field, size.y);
        // Within a pixel of where the cornea turns away it shows what lies behind it too.
        let anterior = self.anterior();
        let turns = -conicoid_normal(trace.entry, anterior.x, anterior.y).dot(direction);
        let is_iris = turns > (2.0 * footprint / anterior.x).sqrt()
            && limbus_share(limbus_place(r, limbus, wide), limbus) >= 1.0
            && pupil_edge(start.uv, footprint, self.frame.width()) >= 1.0
            && start.uv.y < OUTERMOST;
        is_iris.then(|| SeenIris {
            shade: lids_at(&self.globe.lids, self.head_from_eye * p),
            trace,
            landing,
            start,
            footprint,
            direction,
        })
    }

    /// Radiance from a direction of the head frame, as it is seen from the place `p` of it.
    fn mirrored(&self, p: DVec3, d: DVec3, blur: f64) -> DVec3 {
        let mut radiance = surroundings_radiance(&self.around, d, blur);
        for own in &self.illumination.lamps {
            let (direction, nearer) = lamp_from(own, p);
            let lamp = Lamp {
                direction: direction.as_vec3(),
                radius: own.radius * nearer as f32,
                color: own.color * (nearer * nearer) as f32,
                ..*own
            };
            radiance += lamp_radiance(&lamp, d, blur);
        }
        radiance
    }

    /// What the cornea's back mirrors (`inner_image` of the shader).
    fn second_image(&self, seen: &SeenIris) -> DVec3 {
        let pair = |radius_mm: f32, p: f32| DVec2::new(radius_mm.into(), p.into());
        let eye = MirrorEye {
            anterior: self.anterior(),
            posterior: self.posterior(),
            lens_front: pair(self.globe.lens_front_radius_mm, self.globe.lens_front_p),
            lens_back: pair(self.globe.lens_back_radius_mm, self.globe.lens_back_p),
            thickness: f64::from(self.globe.thickness_mm),
            lens_depth: self.iris_depth() + f64::from(self.globe.lens_forward_mm),
            lens_thickness: f64::from(self.globe.lens_thickness_mm),
            n_cornea: f64::from(self.globe.cornea_index),
            n_aqueous: self.aqueous(),
            n_lens: f64::from(self.globe.lens_index),
        };
        let normal = conicoid_normal(seen.trace.entry, eye.anterior.x, eye.anterior.y);
        let entered = snell_refract(seen.direction, normal, 1.0 / eye.n_cornea);
        let image = mirror_cornea(seen.trace.entry, entered.truncate(), &eye);
        let comes = image.direction.length_squared() >= 0.5
            && image.crossing.distance(self.frame.center) <= self.frame.limbus
            && image.exit.truncate().length() <= self.frame.limbus;
        if !comes {
            return DVec3::ZERO;
        }
        let outside = (image.direction + DVec3::new(0.0, 0.0, -1e-3)).normalize();
        let place = self.head_from_eye * (image.exit + self.apex());
        image.share * self.mirrored(place, self.head_from_eye * outside, SECOND_IMAGE_BLUR)
    }

    /// What the camera gets of a pixel whose iris sends `lit` towards it, in this light (irradiance / π), of which the cornea
    /// scatters a little back.
    pub(super) fn shown(&self, seen: &SeenIris, lit: DVec3, light: DVec3) -> DVec3 {
        let aqueous = self.aqueous();
        let inside = lit / (aqueous * aqueous) + self.second_image(seen);
        let normal = conicoid_normal(seen.trace.entry, self.anterior().x, self.anterior().y);
        let v = self.head_from_eye * -seen.direction;
        let p = self.head_from_eye * (seen.trace.entry + self.apex());
        let globe = &self.globe;
        let [lipid, breakup, own] =
            [globe.lipid_nm, globe.tear_breakup_s, globe.lens_turn].map(f64::from);
        let tears = tear_layer(p.truncate(), self.tears_s, lipid, breakup, own);
        let n = (self.head_from_eye * normal + tears.tilt.extend(0.0)).normalize();
        let blur = CORNEA_BLUR + BROKEN_BLUR * tears.broken;
        let around = self.mirrored(p, 2.0 * n.dot(v) * n - v, blur);
        let specular = tear_reflection(
            around,
            self.lids_radiance(),
            [n, v],
            tears.lipid_nm,
            &seen.shade,
            seen.footprint,
        );
        let haze = light * self.globe.cornea_haze.as_dvec3();
        (inside * seen.trace.transmittance + haze + specular)
            * f64::from(self.illumination.exposure)
    }

    /// What the sky sends back from this surface.
    pub(super) fn sky(&self, surface: &IrisSurface) -> [DVec3; 2] {
        let sky = self.globe.iris_sky.map(|values| f64::from(values.x));
        let arrives = iris_sky_knot(surface.at.length(), self.frame.root).read(&sky);
        let depth = self.iris_depth() + surface.base;
        let place = surface.at.extend(depth) + self.apex();
        let before = lids_at(&self.globe.lids, self.head_from_eye * place);
        let around = ambient_light(&self.illumination.ambient, -self.head_from_eye.z_axis);
        let left = lid_sky_within(&before, depth, self.aqueous());
        let around = (LIDS_SEND * self.lids_radiance()).lerp(around, left);
        [iris_ambient(&self.maps, surface, arrives) * around, around]
    }

    /// Radiance of the lids' skin.
    fn lids_radiance(&self) -> DVec3 {
        self.globe.lids_color.as_dvec3() * self.illumination.lids_lit.as_dvec3()
    }

    /// The lamps that give light, their directions in the eye frame.
    pub(super) fn lamps(&self) -> impl Iterator<Item = Lamp> + '_ {
        let lit = |lamp: &&Lamp| lamp.color.max_element() > 0.0;
        self.illumination.lamps.iter().filter(lit).map(|own| Lamp {
            direction: (self.head_from_eye.transpose() * own.direction.as_dvec3()).as_vec3(),
            ..*own
        })
    }

    /// What lids leave of a lamp of this radius (rad) that is seen in this direction (eye frame) from where its light enters.
    pub(super) fn lids_leave(&self, enters: DVec3, direction: DVec3, radius: f64) -> f64 {
        let lids = lids_at(
            &self.globe.lids,
            self.head_from_eye * (enters + self.apex()),
        );
        lid_lamp(&lids, self.head_from_eye * direction, radius)
    }

    /// Where a lamp (eye frame) stands from the corneal apex, mm; `None` where it is far.
    pub(super) fn lamp_place(&self, lamp: &Lamp) -> Option<DVec3> {
        let place = lamp.direction.as_dvec3() / f64::from(lamp.vergence) - self.apex();
        (lamp.vergence > 0.0).then_some(place)
    }

    /// What the camera gets, by the shader's own closed forms.
    pub fn by_closed_forms(&self, seen: &SeenIris, march: &IrisMarch) -> DVec3 {
        let (maps, frame) = (&self.maps, &self.frame);
        let surface = iris_surface(
            maps,
            frame,
            seen.landing,
            &seen.start,
            seen.trace.direction,
            seen.footprint,
            march,
        );
        let [mut lit, mut light] = self.sky(&surface);
        let light_mm = f64::from(self.globe.iris_light_mm);
        let behind = self.iris_depth() + surface.base - light_mm;
        let place = surface.at.extend(light_mm);
        let (surface_of, root, limbus) = (self.anterior(), frame.root, frame.limbus);
        for lamp in self.lamps() {
            let (mut direction, mut stronger) = (lamp.direction.as_dvec3(), 1.0);
            let mut radius = f64::from(lamp.radius);
            if lamp.vergence > 0.0 {
                let (table, n) = (&maps.light, self.aqueous());
                (direction, stronger) = iris_near_lamp(
                    table,
                    &lamp,
                    self.apex(),
                    place,
                    surface_of,
                    n,
                    root,
                    limbus,
                );
            }
            let height = surface.texel.height - behind;
            let about = crosses_plane(surface.at, height, direction, self.aqueous());
            let comes = iris_light(&maps.light, direction, about, root, limbus);
            let crosses =
                surface.at - comes.truncate().truncate() * (height / (-comes.z).max(0.25));
            let mut arrives: DVec4 = iris_light(&maps.light, direction, crosses, root, limbus);
            let plane = crosses.extend(light_mm);
            let enters = light_entry(plane, arrives.truncate(), surface_of);
            let nearer = lamp_from(&lamp, self.apex() + enters).1;
            radius *= nearer;
            let vergence = f64::from(lamp.vergence) * nearer;
            let converges = beam_gathers(
                enters,
                plane,
                direction,
                surface_of,
                self.aqueous(),
                vergence,
            );
            let on = beam_on(converges, behind / (-arrives.z).max(0.25));
            arrives.w *= on.x;
            let passes = stronger * self.lids_leave(enters, direction, radius);
            light += lamp.color.as_dvec3() * (passes * (-direction.z).max(0.0));
            lit += lamp.color.as_dvec3()
                * passes
                * iris_lamp(maps, frame, &self.tissue, &surface, arrives, on.y, march);
        }
        self.shown(seen, lit, light)
    }
}
