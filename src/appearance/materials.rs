//! The eye's materials: what their shaders read, kept in step with `shaders/eye/*.wgsl`.
//!
//! Enters: the patient's components, the lids' margins, the light.
//! Leaves: uniforms and textures of four Bevy materials ([`GlobeMaterial`],
//! [`SkinMaterial`], [`HairMaterial`], [`MeniscusMaterial`]), which any Bevy
//! app can put on the meshes of this folder.

use super::eye_camera::EyeShading;
use super::illumination::{Illumination, LightKey};
use super::light_table::SKY_RADII;
use super::look_uniform::LookUniform;
use crate::frame::shaders;
use crate::tissue::iris_reflectance::IrisTissue;
use crate::tissue::sclera::LAMELLAE;
use bevy::asset::{Asset, Handle};
use bevy::image::Image;
use bevy::math::{Mat3, Mat4, Vec2, Vec3, Vec4};
use bevy::mesh::{Mesh, MeshVertexBufferLayoutRef};
use bevy::pbr::{Material, MaterialPipeline, MaterialPipelineKey, MeshPipelineKey};
use bevy::prelude::AlphaMode;
use bevy::reflect::TypePath;
use bevy::render::render_resource::{
    AsBindGroup, Face, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
    TextureFormat,
};
use bevy::shader::{ShaderDefVal, ShaderRef};

/// Samples of each lid margin's height (`LID_SAMPLES` of the shader).
pub const LID_SAMPLES: usize = 32;
/// Half of the width over which they are taken, mm (`LID_HALF_SPAN_MM`).
pub const LID_HALF_SPAN_MM: f32 = 20.0;

/// Heights of the lid margins from one place to the next, mm, head frame (struct `LidSpan`).
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct LidSpan {
    /// Of the upper margin at the place.
    pub upper: f32,
    /// And at the next.
    pub upper_next: f32,
    /// Of the lower margin at the place.
    pub lower: f32,
    /// And at the next.
    pub lower_next: f32,
}

/// Heights of the lid margins over x (struct `Lids`).
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct LidMargins {
    /// From each of the places to the next.
    pub spans: [LidSpan; LID_SAMPLES],
}

impl LidMargins {
    /// Margins of these heights at [`LID_SAMPLES`] places evenly over twice [`LID_HALF_SPAN_MM`].
    pub fn new(upper: [f32; LID_SAMPLES], lower: [f32; LID_SAMPLES]) -> Self {
        Self {
            spans: core::array::from_fn(|i| {
                let next = (i + 1).min(LID_SAMPLES - 1);
                LidSpan {
                    upper: upper[i],
                    upper_next: upper[next],
                    lower: lower[i],
                    lower_next: lower[next],
                }
            }),
        }
    }
}

impl Default for LidMargins {
    fn default() -> Self {
        Self::new([30.0; LID_SAMPLES], [-30.0; LID_SAMPLES])
    }
}

/// Struct `Globe` of `shaders/eye/globe.wgsl`. Lengths in mm.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct GlobeUniform {
    /// The lids' margins.
    pub lids: LidMargins,
    /// Rotation of the globe in the head.
    pub head_from_eye: Mat4,
    /// Apical radius of the cornea's front.
    pub anterior_radius_mm: f32,
    /// Its shape factor.
    pub anterior_p: f32,
    /// Apical radius of the cornea's back.
    pub posterior_radius_mm: f32,
    /// Its shape factor.
    pub posterior_p: f32,
    /// Thickness of the cornea.
    pub thickness_mm: f32,
    /// Its index.
    pub cornea_index: f32,
    /// Index of the aqueous.
    pub aqueous_index: f32,
    /// From the globe's centre to the corneal apex.
    pub apex_mm: f32,
    /// Iris behind the apex.
    pub iris_depth_mm: f32,
    /// Slope of the cone in which it falls back to its root, and how far its middle stands before that, four times, over its width.
    pub iris_shape: Vec2,
    /// Behind the apex: the plane of the iris' light ([`super::light_table`]).
    pub iris_light_mm: f32,
    /// Radius of its root.
    pub iris_root_mm: f32,
    /// Radius of the limbus.
    pub limbus_mm: f32,
    /// Middle of the pupil.
    pub pupil_center_mm: Vec2,
    /// Radius of the scleral sphere.
    pub sclera_radius_mm: f32,
    /// Lipid layer of the tears, nm.
    pub lipid_nm: f32,
    /// How long after a blink the tear film begins to break, s.
    pub tear_breakup_s: f32,
    /// What a lens of this age sends back of the irradiance / π, linear sRGB.
    pub lens: Vec3,
    /// What the cornea sends back of it.
    pub cornea_haze: Vec3,
    /// Share of the lens's disc under clouded cortex.
    pub cortical_share: f32,
    /// What a clouded nucleus sends back beyond that.
    pub nucleus: Vec3,
    /// Radius of a cloud at the posterior capsule.
    pub capsule_radius_mm: f32,
    /// What such a cloud sends back through the nucleus.
    pub capsule: Vec3,
    /// How much of the iris's relief shows.
    pub relief: f32,
    /// What makes the clouds of a lens and the waves of the tears those of this eye, rad.
    pub lens_turn: f32,
    /// Colour of what is thick and bloody of the conjunctiva.
    pub flesh: Vec3,
    /// Share of the white's light that deep vessels cannot dim, linear sRGB.
    pub above_vessels: Vec3,
    /// Irradiance of the iris under an even sky at a place ([`super::light_table::iris_sky_knot`]), and at the next.
    pub iris_sky: [Vec4; SKY_RADII],
    /// Apical radius of the lens's front, mm.
    pub lens_front_radius_mm: f32,
    /// Its shape factor.
    pub lens_front_p: f32,
    /// Apical radius of its back, which bulges into the eye, mm.
    pub lens_back_radius_mm: f32,
    /// Its shape factor.
    pub lens_back_p: f32,
    /// Of the lens.
    pub lens_thickness_mm: f32,
    /// Its equivalent index.
    pub lens_index: f32,
    /// How far its front stands behind the plane of the iris; negative before it.
    pub lens_forward_mm: f32,
    /// What it leaves of light that crosses it twice, linear sRGB.
    pub lens_passes: Vec3,
    /// Size of the entrance pupil against the hole in the iris.
    pub pupil_magnification: f32,
    /// Vergence for which the eye is in focus now, 1/mm: a power vector of the eye frame.
    pub focus: Vec3,
    /// Albedo of the lids' skin, linear sRGB.
    pub lids_color: Vec3,
    /// Equivalent reflectance of the fundus, linear sRGB.
    pub fundus: Vec3,
    /// Lipid in the rim of the cornea, 0 to 1.
    pub arcus: f32,
    /// What lamellae of the sclera send back, by [`crate::tissue::sclera::lamellae`], linear sRGB.
    pub lamellae_reflect: [Vec4; LAMELLAE],
    /// What they pass.
    pub lamellae_pass: [Vec4; LAMELLAE],
    /// What the iris is made of.
    pub tissue: IrisTissueUniform,
    /// What an artist has changed.
    pub look: LookUniform,
}

/// Struct `IrisTissue` of `shaders/lib/iris_shade.wgsl`, in f32.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct IrisTissueUniform {
    /// Extinction of the border layer without melanin.
    pub border: Vec3,
    /// What its melanin adds where it is densest.
    pub border_melanin: Vec3,
    /// Its scattering.
    pub border_scattering: Vec3,
    /// Share of that after Rayleigh.
    pub border_fibrils: Vec3,
    /// Extinction of the stroma.
    pub stroma: Vec3,
    /// Its scattering.
    pub stroma_scattering: Vec3,
    /// Share of that after Rayleigh.
    pub stroma_fibrils: Vec3,
    /// Weights of the wavelengths in linear sRGB.
    pub weights: Mat3,
}

impl From<&IrisTissue> for IrisTissueUniform {
    fn from(tissue: &IrisTissue) -> Self {
        Self {
            border: tissue.border.as_vec3(),
            border_melanin: tissue.border_melanin.as_vec3(),
            border_scattering: tissue.border_scattering.as_vec3(),
            border_fibrils: tissue.border_fibrils.as_vec3(),
            stroma: tissue.stroma.as_vec3(),
            stroma_scattering: tissue.stroma_scattering.as_vec3(),
            stroma_fibrils: tissue.stroma_fibrils.as_vec3(),
            weights: tissue.weights.as_mat3(),
        }
    }
}

/// Which part of the globe a material draws: the part is a pipeline of its own, because a sclera
/// needs none of the code that looks through a cornea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GlobePart {
    /// Everything outside the limbus.
    #[default]
    Sclera,
    /// The cornea within the limbus, iris and pupil behind it, and no white.
    Cornea,
    /// The ring in which cornea and white go over into each other.
    Limbus,
    /// Plica, caruncle and what joins the lids at the outer corner: it does not turn with the globe.
    Conjunctiva,
}

impl GlobePart {
    /// Is the inside of the eye seen through it?
    pub fn is_corneal(self) -> bool {
        matches!(self, Self::Cornea | Self::Limbus)
    }
}

/// Pipeline key of a [`GlobeMaterial`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GlobeKey {
    part: GlobePart,
    clouded: bool,
    artistic: bool,
    arcus: bool,
    shading: EyeShading,
    light: LightKey,
}

impl From<&GlobeMaterial> for GlobeKey {
    fn from(material: &GlobeMaterial) -> Self {
        Self {
            part: material.part,
            clouded: material.clouded,
            artistic: material.artistic,
            arcus: material.globe.arcus > 0.0,
            shading: material.shading,
            light: material.illumination.key(),
        }
    }
}

/// Sclera, limbus, cornea, iris and pupil in one opaque material.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
#[bind_group_data(GlobeKey)]
pub struct GlobeMaterial {
    /// The part that it draws.
    pub part: GlobePart,
    /// Is there anything in the lens that a healthy one has not?
    pub clouded: bool,
    /// Has an artist changed anything?
    pub artistic: bool,
    /// How it is computed.
    pub shading: EyeShading,
    /// The numbers.
    #[uniform(0)]
    pub globe: GlobeUniform,
    /// Polar map of the iris: height, thickness, melanin.
    #[texture(1)]
    #[sampler(2)]
    pub iris_map: Handle<Image>,
    /// Map of the sclera: albedo without vessels.
    #[texture(3)]
    #[sampler(4)]
    pub sclera_map: Handle<Image>,
    /// Reflectance of the iris by stromal path and melanin.
    #[texture(5)]
    #[sampler(6)]
    pub reflectance_map: Handle<Image>,
    /// Where the lamps' light enters the eye; see [`super::light_table`].
    #[texture(7)]
    pub light_table: Handle<Image>,
    /// Its vessels as columns of blood, and its relief; read by the sclera's sampler.
    #[texture(8)]
    pub vessel_map: Handle<Image>,
    /// The light.
    #[uniform(10)]
    pub illumination: Illumination,
    /// What surrounds the eye; see [`super::surroundings`].
    #[texture(11)]
    #[sampler(12)]
    pub around: Handle<Image>,
}

/// Struct `Skin` of `shaders/eye/skin.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct SkinUniform {
    /// Albedo, linear sRGB.
    pub albedo: Vec3,
    /// Roughness of its sheen.
    pub roughness: f32,
    /// Colour of wet flesh.
    pub flesh: Vec3,
    /// How deep the pores are.
    pub pores: f32,
    /// By which power of its blood reflectance falls.
    pub blood: Vec3,
    /// The same of melanin.
    pub melanin: Vec3,
    /// Reflectance of a lid against the face's.
    pub lid: Vec3,
    /// How deep the wrinkles of age are, mm.
    pub wrinkles_mm: f32,
    /// −1 for a left eye, whose resting places are a right one's.
    pub mirror: f32,
}

/// Pipeline key of a [`SkinMaterial`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SkinKey {
    wet: bool,
    wrinkled: bool,
    light: LightKey,
}

/// The skin of the eye region.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
#[bind_group_data(SkinKey)]
pub struct SkinMaterial {
    /// Does it draw the lid margins, which tears wet, or what is dry?
    pub wet: bool,
    /// The numbers.
    #[uniform(0)]
    pub skin: SkinUniform,
    /// The repeating tile of slope and colour; see [`super::skin_map`].
    #[texture(1)]
    #[sampler(2)]
    pub skin_map: Handle<Image>,
    /// The light.
    #[uniform(10)]
    pub illumination: Illumination,
    /// What surrounds the eye; see [`super::surroundings`].
    #[texture(11)]
    #[sampler(12)]
    pub around: Handle<Image>,
}

/// Struct `Hair` of `shaders/eye/hair.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct HairUniform {
    /// Colour at the root.
    pub root: Vec3,
    /// Colour at the tip.
    pub tip: Vec3,
}

/// Lashes and brow.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
#[bind_group_data(LightKey)]
pub struct HairMaterial {
    /// The numbers.
    #[uniform(0)]
    pub hair: HairUniform,
    /// The light.
    #[uniform(10)]
    pub illumination: Illumination,
    /// What surrounds the eye; see [`super::surroundings`].
    #[texture(11)]
    #[sampler(12)]
    pub around: Handle<Image>,
}

/// Struct `Meniscus` of `shaders/eye/meniscus.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct MeniscusUniform {
    /// How strongly it mirrors, 0 to 1.
    pub strength: f32,
    /// Albedo of the lids' skin, linear sRGB.
    pub lids: Vec3,
}

/// The thread of tears along the lid margins.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
#[bind_group_data(LightKey)]
pub struct MeniscusMaterial {
    /// The numbers.
    #[uniform(0)]
    pub meniscus: MeniscusUniform,
    /// The light.
    #[uniform(10)]
    pub illumination: Illumination,
    /// What surrounds the eye; see [`super::surroundings`].
    #[texture(11)]
    #[sampler(12)]
    pub around: Handle<Image>,
}

/// All four read the same vertices: position, normal, resting place (in the
/// tangent), and four tissue weights (in the colour).
fn vertex_layout(
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
) -> Result<(), SpecializedMeshPipelineError> {
    let vertex_layout = layout.0.get_layout(&[
        Mesh::ATTRIBUTE_POSITION.at_shader_location(0),
        Mesh::ATTRIBUTE_NORMAL.at_shader_location(1),
        Mesh::ATTRIBUTE_TANGENT.at_shader_location(2),
        Mesh::ATTRIBUTE_COLOR.at_shader_location(3),
    ])?;
    descriptor.vertex.buffers = vec![vertex_layout];
    Ok(())
}

/// Makes a pipeline of Bevy's that of an eye's material: with these defines, under this light.
fn specialize(
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    mesh_key: MeshPipelineKey,
    defines: Vec<&'static str>,
    light: LightKey,
) -> Result<(), SpecializedMeshPipelineError> {
    // A camera of high dynamic range is given radiance, and has its own way to the screen.
    let is_radiance = mesh_key.target_format() == TextureFormat::Rgba16Float;
    let radiance = is_radiance.then_some("RADIANCE");
    let bare = light.has_bare.then_some("BARE_LAMPS");
    let near = light.has_near.then_some("NEAR_LAMPS");
    let defines = defines.into_iter().chain(radiance).chain(bare).chain(near);
    let lamps = ShaderDefVal::UInt("LAMPS".into(), light.lamps);
    let defines: Vec<ShaderDefVal> = defines.map(Into::into).chain([lamps]).collect();
    // Both stages with the same ones: then they are one module.
    if let Some(fragment) = &mut descriptor.fragment {
        fragment.shader_defs.extend(defines.iter().cloned());
    }
    descriptor.vertex.shader_defs.extend(defines);
    vertex_layout(descriptor, layout)
}

macro_rules! eye_material {
    ($material:ty, $shader:expr, $alpha:expr, $culled:expr, $define:expr, $light:expr) => {
        impl Material for $material {
            fn vertex_shader() -> ShaderRef {
                $shader.into()
            }
            fn fragment_shader() -> ShaderRef {
                $shader.into()
            }
            fn alpha_mode(&self) -> AlphaMode {
                $alpha
            }
            fn enable_prepass() -> bool {
                false
            }
            fn enable_shadows() -> bool {
                false
            }
            fn specialize(
                _pipeline: &MaterialPipeline,
                descriptor: &mut RenderPipelineDescriptor,
                layout: &MeshVertexBufferLayoutRef,
                key: MaterialPipelineKey<Self>,
            ) -> Result<(), SpecializedMeshPipelineError> {
                let define: fn(&MaterialPipelineKey<Self>) -> Vec<&'static str> = $define;
                let light: fn(&MaterialPipelineKey<Self>) -> LightKey = $light;
                let (defines, light) = (define(&key), light(&key));
                descriptor.primitive.cull_mode = $culled;
                specialize(descriptor, layout, key.mesh_key, defines, light)
            }
        }
    };
}

/// The define of what is wet.
const WET: &str = "WET";

// A mask that lets everything through: masked meshes are drawn after opaque ones, so that the lids
// have hidden most of the globe before its costly pixels are shaded.
eye_material!(
    GlobeMaterial,
    shaders::GLOBE,
    AlphaMode::Mask(0.0),
    Some(Face::Back),
    |key| {
        let key = &key.bind_group_data;
        let mut defines = match key.part {
            GlobePart::Sclera => vec!["WHITE"],
            GlobePart::Conjunctiva => vec!["WHITE", "CONJUNCTIVA"],
            // An artist's limbus may be as wide as the cornea.
            GlobePart::Cornea if !key.artistic => vec!["CORNEA"],
            GlobePart::Cornea | GlobePart::Limbus => vec!["WHITE", "CORNEA"],
        };
        if key.part.is_corneal() && key.clouded {
            defines.push("CLOUDED");
        }
        if key.part.is_corneal() && key.arcus {
            defines.push("ARCUS");
        }
        if key.artistic {
            defines.push("ARTISTIC");
        }
        match key.shading {
            EyeShading::Full if key.part.is_corneal() => defines.push("FULL"),
            EyeShading::FixedSteps if key.part.is_corneal() => defines.push("FIXED_STEPS"),
            _ => {}
        }
        defines
    },
    |key| key.bind_group_data.light
);
impl From<&SkinMaterial> for SkinKey {
    fn from(material: &SkinMaterial) -> Self {
        Self {
            wet: material.wet,
            wrinkled: material.skin.wrinkles_mm > 0.0,
            light: material.illumination.key(),
        }
    }
}

eye_material!(
    SkinMaterial,
    shaders::SKIN,
    AlphaMode::Opaque,
    Some(Face::Back),
    |key| {
        let SkinKey { wet, wrinkled, .. } = key.bind_group_data;
        let wrinkled = (wrinkled && !wet).then_some("WRINKLED");
        wet.then_some(WET).into_iter().chain(wrinkled).collect()
    },
    |key| key.bind_group_data.light
);
impl From<&HairMaterial> for LightKey {
    fn from(material: &HairMaterial) -> Self {
        material.illumination.key()
    }
}

eye_material!(
    HairMaterial,
    shaders::HAIR,
    // Its edges cover shares of pixels.
    AlphaMode::Blend,
    // A ribbon has no back.
    None,
    |_| vec![],
    |key| key.bind_group_data
);
impl From<&MeniscusMaterial> for LightKey {
    fn from(material: &MeniscusMaterial) -> Self {
        material.illumination.key()
    }
}

eye_material!(
    MeniscusMaterial,
    shaders::MENISCUS,
    AlphaMode::Add,
    Some(Face::Back),
    |_| vec![],
    |key| key.bind_group_data
);

#[cfg(test)]
mod tests;
