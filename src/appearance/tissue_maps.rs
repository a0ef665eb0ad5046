//! A patient's tissues as textures, colours and the globe's numbers.

use super::build::Anatomy;
use super::images::{byte_map_image, map_image};
use super::iris_map::{DESIGN_PUPIL_RADIUS_MM, IrisMapSettings, IrisStroma};
use super::light_table::{LightTableSettings, LightTableSize, SKY_RADII};
use super::materials::{GlobeUniform, LidMargins};
use super::model::side;
use super::sclera_map::{ScleraMap, ScleraMapSettings};
use super::shading::iris_relief::{IrisFrame, iris_base};
use super::shading::sclera_shade::EPISCLERAL_DEPTH_MM;
use crate::anatomy::{Iris, Sclera, Skin};
use crate::frame::ledger::WorkLedger;
use crate::frame::mips::chain;
use crate::optics::fresnel::diffuse_surface;
use crate::optics::globe::GlobeShape;
use crate::optics::smoothstep::smoothstep;
use crate::tissue::fundus::fundus_color;
use crate::tissue::iris_reflectance::{IRIS_TABLE, IrisPigment, IrisReflectanceTable, IrisTissue};
use crate::tissue::media::cornea_backscatter;
use crate::tissue::noise::unit_hash;
use crate::tissue::sclera::{
    LAMELLAE, SCLERA_INDEX, ScleralTissue, epithelium_passes, lamellae, returned_above,
    sclera_reflectance,
};
use crate::tissue::skin::{SKIN_INDEX, SkinTissue, SkinVariation};
use bevy::asset::{Assets, Handle};
use bevy::ecs::resource::Resource;
use bevy::image::Image;
use bevy::math::{DVec2, Mat4, Vec3, Vec4};

/// Albedo (linear sRGB) of skin from very light (0) to very dark (1).
pub(super) fn skin_albedo(tone: f64) -> Vec3 {
    let light = Vec3::new(0.72, 0.47, 0.36);
    let middle = Vec3::new(0.42, 0.225, 0.135);
    let dark = Vec3::new(0.085, 0.042, 0.026);
    let tone = tone.clamp(0.0, 1.0) as f32;
    if tone < 0.5 {
        light.lerp(middle, tone * 2.0)
    } else {
        middle.lerp(dark, tone * 2.0 - 1.0)
    }
}

/// How deep wrinkles are at this age, mm: none to be seen before the thirties (a choice: what is printed counts and grades them).
pub(super) fn wrinkles_mm(age_years: f64) -> f32 {
    0.11 * smoothstep(32.0, 80.0, age_years) as f32
}

/// How such skin changes from place to place. Dark skin holds its melanin more evenly: what varies by a share of it is as
/// much of its light as in light skin.
pub(super) fn skin_variation(tone: f64) -> SkinVariation {
    let surface = diffuse_surface(SKIN_INDEX);
    let own = SkinVariation::new(tone, surface);
    let light = SkinVariation::melanin(0.0, surface);
    let evenness = (light[1] / own.melanin[1].max(1e-3)).min(1.0);
    SkinVariation {
        melanin: own.melanin.map(|power| power * evenness),
        ..own
    }
}

/// The images of an eye's tissues, each with what it was made of: what another anatomy leaves as it is is kept.
#[derive(Clone, Debug, Default)]
pub(super) struct TissueMaps {
    iris: Kept<(IrisMapSettings, bool), 1>,
    sclera: Kept<(ScleraMapSettings, bool), 2>,
    reflectance: Kept<IrisPigment, 1>,
    light: Kept<LightTableSettings, 1>,
    skin: Kept<u64, 1>,
}

/// The stromas that were grown last, the last first: while their pigment is changed they need not grow again.
#[derive(Resource, Debug, Default)]
pub struct LastStromas(pub(super) Vec<IrisStroma>);

/// As many as one person has.
const STROMAS: usize = 2;

/// Images and what they were made of.
type Kept<K, const N: usize> = Option<(K, [Handle<Image>; N])>;

/// Where images are put, and where it is counted.
pub(super) struct ImageStore<'a> {
    pub(super) images: &'a mut Assets<Image>,
    pub(super) ledger: &'a WorkLedger,
    pub(super) stromas: &'a mut Vec<IrisStroma>,
}

impl ImageStore<'_> {
    /// The images that are made of `key`: those that are there, or new ones.
    fn kept<K: PartialEq, const N: usize>(
        &mut self,
        kept: &mut Kept<K, N>,
        key: K,
        make: impl FnOnce(&K) -> [Image; N],
    ) -> [Handle<Image>; N] {
        if let Some((of, handles)) = kept
            && *of == key
        {
            return handles.clone();
        }
        let handles = make(&key).map(|image| {
            let bytes = image.data.as_ref().map_or(0, Vec::len) as u64;
            self.ledger.bytes_uploaded(bytes);
            self.images.add(image)
        });
        *kept = Some((key, handles.clone()));
        handles
    }
}

impl TissueMaps {
    pub(super) fn iris(
        &mut self,
        anatomy: &Anatomy<'_>,
        fine: bool,
        store: &mut ImageStore<'_>,
    ) -> Handle<Image> {
        let key = (
            iris_settings(anatomy.iris, seed_of(anatomy), anatomy.patient.seed),
            fine,
        );
        // Out of the store, so that both can be lent.
        let mut grown = core::mem::take(store.stromas);
        let [map] = store.kept(&mut self.iris, key, |(settings, fine)| {
            [iris_image(&mut grown, settings, *fine)]
        });
        *store.stromas = grown;
        map
    }

    /// The white's colour, and its vessels with its relief.
    pub(super) fn sclera(
        &mut self,
        anatomy: &Anatomy<'_>,
        fine: bool,
        store: &mut ImageStore<'_>,
    ) -> [Handle<Image>; 2] {
        let key = (sclera_settings(anatomy), fine);
        store.kept(&mut self.sclera, key, |(settings, fine)| {
            sclera_images(settings, *fine)
        })
    }

    /// Reflectance of the iris of all light, and below of what is scattered more than once.
    pub(super) fn reflectance(
        &mut self,
        anatomy: &Anatomy<'_>,
        store: &mut ImageStore<'_>,
    ) -> Handle<Image> {
        let pigment = map_pigment(anatomy.iris, anatomy.patient.seed);
        let [map] = store.kept(&mut self.reflectance, pigment, |pigment| {
            [reflectance_image(pigment)]
        });
        map
    }

    /// Where light of every obliquity enters this cornea and how strongly it arrives at its iris.
    pub(super) fn light(
        &mut self,
        anatomy: &Anatomy<'_>,
        store: &mut ImageStore<'_>,
    ) -> Handle<Image> {
        let key = light_settings(anatomy);
        let [table] = store.kept(&mut self.light, key, |settings| [light_image(settings)]);
        table
    }

    pub(super) fn skin(&mut self, seed: u64, store: &mut ImageStore<'_>) -> Handle<Image> {
        let [tile] = store.kept(&mut self.skin, seed, |seed| [skin_image(*seed)]);
        tile
    }
}

fn iris_image(grown: &mut Vec<IrisStroma>, settings: &IrisMapSettings, fine: bool) -> Image {
    let (width, height) = if fine { (2048, 512) } else { (1024, 256) };
    let known = grown
        .iter()
        .position(|own| own.fits(settings, width, height));
    let stroma = match known {
        Some(at) => grown.remove(at),
        None => IrisStroma::new(settings, width, height),
    };
    let map = stroma.pigmented(settings);
    grown.insert(0, stroma);
    grown.truncate(STROMAS);
    map_image(&map.levels(), true)
}
/// What the fundus sends back through clear media, linear sRGB.
fn fundus() -> Vec3 {
    Vec3::from(fundus_color().map(|channel| channel as f32))
}

/// What makes an iris the one of this eye.
fn seed_of(anatomy: &Anatomy<'_>) -> u64 {
    anatomy.patient.iris_seed(anatomy.eye.laterality)
}

/// A map's 32-bit seed from a patient's 64-bit one.
fn fold(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}
/// The pigment that the map's melanin is a share of: as dense as the densest of it.
fn map_pigment(iris: &Iris, person: u64) -> IrisPigment {
    let own = iris.pigment();
    let has_dense = iris.freckles >= 0.5 || iris.sector_deg > 0.0;
    let dense = if has_dense {
        IrisPigment::BROWN.border_layer_melanin_fraction
    } else {
        0.0
    };
    let densest = dense.max(ring_melanin(iris, person));
    IrisPigment {
        border_layer_melanin_fraction: own.border_layer_melanin_fraction.max(densest),
        ..own
    }
}

/// Most melanin that gathers about the collarette of a light iris (a choice: hazel's).
const RING_MELANIN: f64 = 0.28;

/// Melanin (volume fraction) about the collarette of this iris: in light ones some people have more of it there than anywhere else, some none; it
/// is told from the rest the less, the darker that is, and where there is none at all there is none here.
fn ring_melanin(iris: &Iris, person: u64) -> f64 {
    let own = iris.pigment().border_layer_melanin_fraction;
    let light = IrisPigment::BLUE.border_layer_melanin_fraction;
    let drawn = f64::from(unit_hash(0, 3, fold(person)));
    let usual = RING_MELANIN * drawn * (own / light).min(1.0) * (1.0 - own / COVERS_ALL).max(0.0);
    iris.collarette_melanin_fraction.unwrap_or(usual)
}

/// Melanin in the border layer from which it covers the stroma as far as it does in any iris (a choice, a little above hazel).
const COVERS_ALL: f64 = 0.30;

/// The border layer covers the stroma of a dark iris and leaves that of a light one bare.
fn iris_settings(iris: &Iris, seed: u64, person: u64) -> IrisMapSettings {
    let light = IrisPigment::BLUE.border_layer_melanin_fraction;
    let share = (iris.pigment().border_layer_melanin_fraction - light) / (COVERS_ALL - light);
    let share = share.clamp(0.0, 1.0) as f32;
    // A little pigment gathers about the collarette first: hazel and green eyes.
    let ring = 4.0 * share * (1.0 - share);
    let sector_deg = iris.sector_deg.clamp(0.0, 360.0);
    let densest = map_pigment(iris, person)
        .border_layer_melanin_fraction
        .max(1e-9);
    IrisMapSettings {
        seed: fold(seed),
        freckle_count: iris.freckles.clamp(0.0, 80.0).round() as u32,
        own_melanin: (iris.pigment().border_layer_melanin_fraction / densest) as f32,
        ring_melanin: (ring_melanin(iris, person) / densest) as f32,
        // The map begins opposite +x, the patient's right, which is the examiner's left; both go counter-clockwise as seen from
        // within, and axes as seen by the examiner.
        sector: [
            (1.0 - iris.sector_at_deg / 360.0).rem_euclid(1.0) as f32,
            (0.5 * sector_deg / 360.0) as f32,
        ],
        border_layer_cover: 0.15 + 0.3 * share,
        central_heterochromia: 0.45 + 0.15 * ring,
        ..IrisMapSettings::default()
    }
}
fn skin_image(seed: u64) -> Image {
    let side = super::skin_map::SIDE;
    let tile = super::skin_map::skin_tile(fold(seed));
    let range = super::skin_map::RANGE;
    let mut image = byte_map_image(&chain((side, side), tile), range, true);
    if let bevy::image::ImageSampler::Descriptor(sampler) = &mut image.sampler {
        sampler.address_mode_v = bevy::image::ImageAddressMode::Repeat;
    }
    image
}
/// A thick, bloody place of the conjunctiva, as of plica, caruncle and the lids' wet margins.
const FLESH: ScleralTissue = ScleralTissue {
    sclera_mm: 0.5,
    covering_mm: 1.5,
    blood_share: 0.022,
    yellowing: 1.0,
    bilirubin_mg_dl: 0.6,
};
/// Melanin in the epithelium of lid margins, of plica and caruncle and of the white, against that of the same person's skin (choices:
/// in dark people all three are seen to be brown, the last in patches about the limbus).
const MARGIN_MELANIN: f64 = 0.35;
const CARUNCLE_MELANIN: f64 = 0.2;
const WHITE_MELANIN: f64 = 0.1;
/// Colour, linear sRGB, of flesh whose epithelium has this share of the skin's melanin.
fn pigmented(flesh: Vec3, skin: &Skin, of_skin: f64) -> Vec3 {
    let melanin = of_skin * SkinTissue::face(skin.tone).melanin_share;
    flesh * color(epithelium_passes(melanin))
}
/// Colour of somebody's lid margins where tears wet them.
pub(super) fn margin_flesh(sclera: &Sclera, skin: &Skin) -> Vec3 {
    pigmented(flesh(sclera), skin, MARGIN_MELANIN)
}
/// Its colour, linear sRGB.
fn flesh(sclera: &Sclera) -> Vec3 {
    let tissue = ScleralTissue {
        blood_share: FLESH.blood_share * (1.0 + sclera.redness),
        bilirubin_mg_dl: sclera.bilirubin_mg_dl,
        ..FLESH
    };
    color(sclera_reflectance(&tissue, diffuse_surface(SCLERA_INDEX)))
}
/// Share of the white's light that returns from above its deeper vessels.
fn above_vessels(sclera: &Sclera) -> Vec3 {
    let tissue = ScleralTissue {
        bilirubin_mg_dl: sclera.bilirubin_mg_dl,
        ..ScleralTissue::default()
    };
    color(returned_above(
        &tissue,
        EPISCLERAL_DEPTH_MM,
        diffuse_surface(SCLERA_INDEX),
    ))
}
pub(super) fn color(rgb: [f64; 3]) -> Vec3 {
    bevy::math::DVec3::from(rgb).as_vec3()
}
/// What the light table of this cornea and iris is made of.
/// The plane is that of the middle of the iris, but for its bulge, which changes with age.
pub(super) fn light_settings(anatomy: &Anatomy<'_>) -> LightTableSettings {
    let (cornea, iris) = (anatomy.cornea, anatomy.iris);
    LightTableSettings {
        surface: DVec2::new(cornea.anterior_radius_mm, cornea.anterior_p),
        index: cornea.aqueous_index,
        iris_z: iris.depth_mm
            + 0.5 * mean_frame(anatomy).width() * iris.cone_deg.to_radians().tan(),
        root_mm: iris.root_radius_mm,
        limbus_mm: cornea.limbus_radius_mm,
    }
}
/// The iris without its relief, by the pupil for which its map is made.
pub(super) fn mean_frame(anatomy: &Anatomy<'_>) -> IrisFrame {
    let iris = anatomy.iris;
    let pupil = f64::from(DESIGN_PUPIL_RADIUS_MM);
    let mut frame = IrisFrame {
        root: iris.root_radius_mm,
        pupil,
        limbus: anatomy.cornea.limbus_radius_mm,
        relief: 0.0,
        center: DVec2::ZERO,
        thicken: 1.0,
        furrows: 0.0,
        cone: iris.cone_deg.to_radians().tan(),
        bow: 0.0,
    };
    frame.bow = 4.0 * iris.bowing_at(anatomy.patient.age_years) / frame.width();
    frame
}
/// Irradiance of an iris under an even sky, by [`super::light_table::iris_sky_knot`].
fn iris_sky(anatomy: &Anatomy<'_>) -> [f64; SKY_RADII] {
    let (frame, settings) = (mean_frame(anatomy), light_settings(anatomy));
    settings.sky(|radius| {
        let base = iris_base((radius - frame.pupil) / frame.width(), &frame);
        DVec2::new(anatomy.iris.depth_mm + base.x, base.y)
    })
}
fn light_image(settings: &LightTableSettings) -> Image {
    map_image(&[settings.table(LightTableSize::PICTURE)], false)
}
fn sclera_settings(anatomy: &Anatomy<'_>) -> ScleraMapSettings {
    let eye = anatomy.eye;
    ScleraMapSettings {
        seed: fold(anatomy.patient.vessel_seed(eye.laterality)),
        age_years: anatomy.patient.age_years as f32,
        redness: anatomy.sclera.redness as f32,
        bilirubin_mg_dl: anatomy.sclera.bilirubin_mg_dl as f32,
        pinguecula: anatomy.sclera.pinguecula as f32,
        nasal_sign: -side(eye.laterality),
        flush_radius: anatomy.look.flush_radius as f32,
        flush_hardness: anatomy.look.flush_hardness as f32,
        melanin: (WHITE_MELANIN * SkinTissue::face(anatomy.skin.tone).melanin_share) as f32,
    }
}
fn sclera_images(settings: &ScleraMapSettings, fine: bool) -> [Image; 2] {
    let map = ScleraMap::new(settings, if fine { 2048 } else { 512 });
    [map.levels(), map.vessel_levels()].map(|levels| map_image(&levels, false))
}
fn reflectance_image(pigment: &IrisPigment) -> Image {
    let [width, height] = IRIS_TABLE;
    let [all, again] = IrisReflectanceTable::seen(pigment, width, height);
    let texels = all.rgb().iter().chain(again.rgb());
    let texels = texels.map(|rgb| [rgb[0] as f32, rgb[1] as f32, rgb[2] as f32, 1.0]);
    map_image(
        &[(width as u32, 2 * height as u32, texels.collect())],
        false,
    )
}
/// What the lamellae of a sclera that end over the cornea send back and pass.
fn lamellae_of(sclera: &Sclera) -> [[Vec4; LAMELLAE]; 2] {
    let tissue = ScleralTissue {
        bilirubin_mg_dl: sclera.bilirubin_mg_dl,
        ..ScleralTissue::default()
    };
    let knots = lamellae(&tissue, diffuse_surface(SCLERA_INDEX));
    [0, 1].map(|which| knots.map(|knot| color(knot[which]).extend(1.0)))
}
pub(super) fn static_uniform(anatomy: &Anatomy<'_>, shape: &GlobeShape) -> GlobeUniform {
    let Anatomy {
        eye, cornea, iris, ..
    } = anatomy;
    let [lamellae_reflect, lamellae_pass] = lamellae_of(anatomy.sclera);
    let frame = mean_frame(anatomy);
    GlobeUniform {
        lids: LidMargins::default(),
        head_from_eye: Mat4::IDENTITY,
        anterior_radius_mm: cornea.anterior_radius_mm as f32,
        anterior_p: cornea.anterior_p as f32,
        posterior_radius_mm: cornea.posterior_radius_mm as f32,
        posterior_p: cornea.posterior_p as f32,
        thickness_mm: cornea.thickness_mm as f32,
        cornea_index: cornea.index as f32,
        aqueous_index: cornea.aqueous_index as f32,
        apex_mm: shape.apex_distance_mm() as f32,
        iris_depth_mm: iris.depth_mm as f32,
        iris_shape: DVec2::new(frame.cone, frame.bow).as_vec2(),
        iris_light_mm: light_settings(anatomy).iris_z as f32,
        iris_root_mm: iris.root_radius_mm as f32,
        limbus_mm: cornea.limbus_radius_mm as f32,
        sclera_radius_mm: eye.scleral_radius_mm as f32,
        lipid_nm: cornea.lipid_thickness_nm as f32,
        tear_breakup_s: cornea.tear_breakup_s as f32,
        relief: 1.0,
        flesh: pigmented(flesh(anatomy.sclera), anatomy.skin, CARUNCLE_MELANIN),
        above_vessels: above_vessels(anatomy.sclera),
        iris_sky: {
            let sky = iris_sky(anatomy).map(|value| value as f32);
            core::array::from_fn(|i| {
                let next = sky[(i + 1).min(SKY_RADII - 1)];
                Vec4::new(sky[i], next, 0.0, 0.0)
            })
        },
        tissue: (&IrisTissue::new(&map_pigment(iris, anatomy.patient.seed))).into(),
        lamellae_reflect,
        lamellae_pass,
        arcus: cornea.arcus_at(anatomy.patient.age_years) as f32,
        pupil_magnification: cornea.pupil_magnification(iris.depth_mm) as f32,
        lids_color: skin_albedo(anatomy.skin.tone),
        fundus: fundus(),
        cornea_haze: color(cornea_backscatter()),
        lens_passes: Vec3::ONE,
        lens_turn: (anatomy.patient.iris_seed(anatomy.eye.laterality) % 997) as f32 * 0.0063,
        // The lens is filled in by its media and by what it is focused for, the pupil's place by who moves it.
        ..GlobeUniform::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::Laterality;
    use crate::patients::PatientFile;

    fn iris_of(change: impl Fn(&mut Iris)) -> Iris {
        let (_, _, mut iris, ..) = PatientFile::default().eye_components(Laterality::OD);
        change(&mut iris);
        iris
    }

    /// What a map holds is a share of what its pigment has where it is densest: with freckles and without, in either eye of whom it may be.
    #[test]
    fn shares_of_melanin_are_of_the_densest_that_the_map_has() {
        for (own, ring, freckles) in [
            (0.035, None, 0.0),
            (0.035, Some(0.4), 0.0),
            (0.2, None, 0.0),
            (0.035, None, 5.0),
            (0.5, Some(0.0), 0.0),
        ] {
            let iris = iris_of(|iris| {
                iris.border_layer_melanin_fraction = Some(own);
                iris.collarette_melanin_fraction = ring;
                iris.freckles = freckles;
            });
            for person in 0..20 {
                let densest = map_pigment(&iris, person).border_layer_melanin_fraction;
                for eye in [person, person ^ 0x5c1e_4a00] {
                    let settings = iris_settings(&iris, eye, person);
                    let found = f64::from(settings.own_melanin) * densest;
                    assert!((found - own).abs() < 1e-7, "{own} {ring:?}: {found}");
                    let found = f64::from(settings.ring_melanin) * densest;
                    let wanted = ring_melanin(&iris, person);
                    assert!((found - wanted).abs() < 1e-7, "{own} {ring:?}: {found}");
                    assert!(settings.own_melanin <= 1.0 && settings.ring_melanin <= 1.0);
                }
            }
        }
        // Where a border layer has none there is none about the collarette either, unless a file says so.
        let bare = iris_of(|iris| iris.border_layer_melanin_fraction = Some(0.0));
        assert!((0..20).all(|person| ring_melanin(&bare, person) == 0.0));
    }
}
