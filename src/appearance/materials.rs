//! The eye's materials: what their shaders read, kept in step with `shaders/eye/*.wgsl`.
//!
//! Enters: the patient's components, the lids' margins, the studio's lights.
//! Leaves: uniforms and textures of four Bevy materials ([`GlobeMaterial`],
//! [`SkinMaterial`], [`HairMaterial`], [`MeniscusMaterial`]), which any Bevy
//! app can put on the meshes of this folder.

use crate::frame::shaders;
use bevy::asset::{Asset, Handle};
use bevy::image::Image;
use bevy::math::{Mat4, Vec4};
use bevy::mesh::{Mesh, MeshVertexBufferLayoutRef};
use bevy::pbr::{Material, MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::AlphaMode;
use bevy::reflect::TypePath;
use bevy::render::render_resource::{
    AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError, TextureFormat,
};
use bevy::shader::ShaderRef;

/// The studio that lights an eye (struct `Studio` of `shaders/lib/studio.wgsl`).
#[derive(Clone, Copy, Debug, PartialEq, ShaderType)]
pub struct Studio {
    /// Direction towards the window, head frame; w: its angular half-width, rad.
    pub key_direction: Vec4,
    /// Its irradiance / π, linear sRGB; w: exposure.
    pub key_color: Vec4,
    /// Direction towards the lamp; w: its angular radius, rad.
    pub fill_direction: Vec4,
    /// Its irradiance / π.
    pub fill_color: Vec4,
    /// Radiance of the surroundings above; w: 1 where the key light is a four-paned window, 0 where it
    /// is a round lamp.
    pub ambient_up: Vec4,
    /// Radiance of the surroundings below; w: 1 where all of this is in cd/m² and the camera's exposure
    /// is still to come, 0 where the picture's own is all.
    pub ambient_down: Vec4,
}

impl Default for Studio {
    fn default() -> Self {
        Self {
            // The window stands up and to the viewer's left, the lamp low on the right.
            key_direction: bevy::math::Vec3::new(0.50, 0.52, -0.78)
                .normalize()
                .extend(0.15),
            key_color: Vec4::new(0.78, 0.80, 0.82, 1.0),
            fill_direction: bevy::math::Vec3::new(-0.72, -0.05, -0.62)
                .normalize()
                .extend(0.07),
            fill_color: Vec4::new(0.10, 0.088, 0.08, 0.0),
            ambient_up: Vec4::new(0.24, 0.245, 0.26, 1.0),
            ambient_down: Vec4::new(0.15, 0.135, 0.125, 0.0),
        }
    }
}

/// Samples of each lid margin's height (`LID_SAMPLES` of the shader).
pub const LID_SAMPLES: usize = 32;
/// Half of the width over which they are taken, mm (`LID_HALF_SPAN_MM`).
pub const LID_HALF_SPAN_MM: f32 = 20.0;

/// Heights of the lid margins over x, mm, head frame (struct `Lids`).
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct LidHeights {
    /// The upper margin.
    pub upper: [Vec4; LID_SAMPLES / 4],
    /// The lower margin.
    pub lower: [Vec4; LID_SAMPLES / 4],
}

impl Default for LidHeights {
    fn default() -> Self {
        Self {
            upper: [Vec4::splat(30.0); LID_SAMPLES / 4],
            lower: [Vec4::splat(-30.0); LID_SAMPLES / 4],
        }
    }
}

/// Struct `Globe` of `shaders/eye/globe.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct GlobeUniform {
    /// The lights.
    pub studio: Studio,
    /// The lids' margins.
    pub lids: LidHeights,
    /// Rotation of the globe in the head.
    pub head_from_eye: Mat4,
    /// Anterior (R, p), posterior (R, p).
    pub cornea: Vec4,
    /// Thickness, index of the cornea, of the aqueous, distance from apex to centre.
    pub cornea_inside: Vec4,
    /// Depth of the iris, radius of its root, of the pupil, of the limbus.
    pub iris: Vec4,
    /// Pupil's centre x, y; scleral radius; lipid thickness in nm.
    pub pupil: Vec4,
    /// Radius of a cloud at the lens's capsule (mm), canthal pinkness, side (+1 OD), strength of the relief.
    pub options: Vec4,
    /// What a lens of this age sends back, rgb.
    pub lens: Vec4,
    /// What a clouded nucleus sends back beyond it, rgb; w: share of the lens under clouded cortex.
    pub nucleus: Vec4,
}

/// Which part of the globe a material draws: the part is a pipeline of its own, because a sclera
/// needs none of the code that looks through a cornea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GlobePart {
    /// Everything outside the limbus.
    #[default]
    Sclera,
    /// Cornea, iris and pupil, and the limbus itself.
    Cornea,
}

/// Pipeline key of a [`GlobeMaterial`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GlobeKey(GlobePart, bool);

impl From<&GlobeMaterial> for GlobeKey {
    fn from(material: &GlobeMaterial) -> Self {
        Self(material.part, material.clouded)
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
    /// The numbers.
    #[uniform(0)]
    pub globe: GlobeUniform,
    /// Polar map of the iris: height, thickness, melanin.
    #[texture(1)]
    #[sampler(2)]
    pub iris_map: Handle<Image>,
    /// Map of the sclera: albedo and height.
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
}

/// Struct `Skin` of `shaders/eye/skin.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct SkinUniform {
    /// The lights.
    pub studio: Studio,
    /// Albedo; w: roughness.
    pub albedo: Vec4,
    /// Colour of wet flesh; w: strength of the pores.
    pub flesh: Vec4,
    /// x: radius of the globe, mm.
    pub globe: Vec4,
}

/// The skin of the eye region.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct SkinMaterial {
    /// The numbers.
    #[uniform(0)]
    pub skin: SkinUniform,
    /// The repeating tile of slope and colour; see [`super::skin_map`].
    #[texture(1)]
    #[sampler(2)]
    pub skin_map: Handle<Image>,
}

/// Struct `Hair` of `shaders/eye/hair.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct HairUniform {
    /// The lights.
    pub studio: Studio,
    /// Colour at the root.
    pub root: Vec4,
    /// Colour at the tip.
    pub tip: Vec4,
}

/// Lashes and brow.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct HairMaterial {
    /// The numbers.
    #[uniform(0)]
    pub hair: HairUniform,
}

/// Struct `Meniscus` of `shaders/eye/meniscus.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct MeniscusUniform {
    /// The lights.
    pub studio: Studio,
    /// x: strength of the reflections.
    pub options: Vec4,
}

/// The thread of tears along the lid margins.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct MeniscusMaterial {
    /// The numbers.
    #[uniform(0)]
    pub meniscus: MeniscusUniform,
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

macro_rules! eye_material {
    ($material:ty, $shader:expr, $alpha:expr, $define:expr) => {
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
                let define: fn(MaterialPipelineKey<Self>) -> Vec<&'static str> = $define;
                // A camera of high dynamic range is given radiance, and has its own way to the screen.
                let radiance = (key.mesh_key.target_format() == TextureFormat::Rgba16Float)
                    .then_some("RADIANCE");
                if let Some(fragment) = &mut descriptor.fragment {
                    let defines = define(key).into_iter().chain(radiance);
                    fragment.shader_defs.extend(defines.map(Into::into));
                }
                vertex_layout(descriptor, layout)
            }
        }
    };
}

// A mask that lets everything through: masked meshes are drawn after opaque ones, so that the lids
// have hidden most of the globe before its costly pixels are shaded.
eye_material!(GlobeMaterial, shaders::GLOBE, AlphaMode::Mask(0.0), |key| {
    match key.bind_group_data {
        GlobeKey(GlobePart::Sclera, _) => vec![],
        GlobeKey(GlobePart::Cornea, false) => vec!["CORNEA"],
        GlobeKey(GlobePart::Cornea, true) => vec!["CORNEA", "CLOUDED"],
    }
});
eye_material!(SkinMaterial, shaders::SKIN, AlphaMode::Opaque, |_| vec![]);
eye_material!(HairMaterial, shaders::HAIR, AlphaMode::Opaque, |_| vec![]);
eye_material!(MeniscusMaterial, shaders::MENISCUS, AlphaMode::Add, |_| {
    vec![]
});
