//! A scene model as Bevy entities on a layer of their own.
//!
//! Enters: [`SceneModel`] (world metres, absolute photometry). Leaves: meshes
//! with standard materials and lights that only the view's camera sees.

use super::model::{
    Alpha, OnSecondUvs, SceneLight, SceneMaterial, SceneMesh, SceneModel, SceneTexture,
    UNLIT_WHITE_CD_M2, Wrap,
};
use super::motion::MovingMesh;
use super::playing::Rig;
use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers};
use bevy::ecs::system::SystemParam;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLight, PointLight};
use bevy::mesh::skinning::SkinnedMeshInverseBindposes;
use bevy::mesh::{Indices, PrimitiveTopology, UvChannel};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Extent3d, Face, TextureDimension, TextureFormat, TextureUsages,
};
use std::collections::HashMap;
use wgpu_types::DeviceType;

/// Layer of everything that is looked at.
pub const SCENE_LAYER: usize = 31;

/// Marks what belongs to the scene that is looked at.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component)]
pub struct ScenePart;

/// How many texels along a slanted surface one look at a texture may mean on this device.
///
/// Mesa's software rasteriser returns texels of other places where it filters anisotropically a
/// surface that it sees face on: a dashed line of them across a page, and strokes missing from
/// letters. There the scene's supersampling has to do.
pub fn anisotropy(device: DeviceType) -> u16 {
    if device == DeviceType::Cpu { 1 } else { 8 }
}

/// What a model is made of, as Bevy keeps it.
#[derive(SystemParam)]
pub struct SceneAssets<'w> {
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    images: ResMut<'w, Assets<Image>>,
    skins: ResMut<'w, Assets<SkinnedMeshInverseBindposes>>,
}

/// Spawns the whole model; its textures are looked up with this [`anisotropy`].
pub fn spawn_model(
    model: &SceneModel,
    anisotropy: u16,
    commands: &mut Commands,
    assets: &mut SceneAssets,
) {
    let SceneAssets {
        meshes,
        materials,
        images,
        skins,
    } = assets;
    let motion = model.motion.as_ref();
    let mut rig = motion.map(|motion| Rig::spawn(motion, commands, skins));
    let moved: HashMap<usize, &MovingMesh> = motion
        .iter()
        .flat_map(|motion| &motion.meshes)
        .map(|moving| (moving.mesh, moving))
        .collect();
    let textures: Vec<Handle<Image>> = model
        .textures
        .iter()
        .map(|texture| images.add(texture_image(texture, anisotropy)))
        .collect();
    let mean = mean_luminance(model);
    let handles: Vec<Handle<StandardMaterial>> = model
        .materials
        .iter()
        .map(|material| materials.add(standard_material(material, &textures, mean)))
        .collect();
    for (index, mesh) in model.meshes.iter().enumerate() {
        let material = &model.materials[mesh.material];
        let normal_map = material.normal_texture.map(|_| &material.on_second_uvs);
        let moving = rig.as_mut().zip(moved.get(&index).copied());
        let drawn = meshes.add(match &moving {
            Some((rig, moving)) => {
                rig.bend(bevy_mesh(&rig.unmoved(mesh, moving), normal_map), moving)
            }
            None => bevy_mesh(mesh, normal_map),
        });
        let mut entity = commands.spawn((
            ScenePart,
            Mesh3d(drawn.clone()),
            MeshMaterial3d(handles[mesh.material].clone()),
            NoFrustumCulling,
            RenderLayers::layer(SCENE_LAYER),
        ));
        if let Some((rig, moving)) = moving {
            rig.hang(moving, drawn, &mut entity);
        }
    }
    for (index, light) in model.lights.iter().enumerate() {
        let Some(mut entity) = spawn_light(light, commands) else {
            continue;
        };
        if let Some(rig) = &rig {
            rig.carry(index, &mut entity);
        }
    }
    if let Some(rig) = rig {
        rig.begin(commands);
    }
}

fn spawn_light<'a>(light: &SceneLight, commands: &'a mut Commands) -> Option<EntityCommands<'a>> {
    let layer = RenderLayers::layer(SCENE_LAYER);
    match *light {
        SceneLight::Point {
            position,
            color,
            intensity_lm,
            range,
            shadows,
        } => Some(commands.spawn((
            ScenePart,
            PointLight {
                color: linear(color),
                intensity: intensity_lm,
                range,
                shadow_maps_enabled: shadows,
                ..default()
            },
            Transform::from_translation(position.into()),
            layer,
        ))),
        SceneLight::Directional {
            direction,
            color,
            illuminance_lux,
            shadows,
        } => {
            let direction = Vec3::from(direction).normalize_or(Vec3::NEG_Y);
            Some(
                commands.spawn((
                    ScenePart,
                    DirectionalLight {
                        color: linear(color),
                        illuminance: illuminance_lux,
                        shadow_maps_enabled: shadows,
                        // A page held at a grazing angle to the sun would shade itself in stripes.
                        shadow_normal_bias: 3.0,
                        ..default()
                    },
                    CascadeShadowConfigBuilder {
                        // What is held near gets a map of its own; a browser may run on a software
                        // rasteriser, where every map is a wait.
                        num_cascades: if cfg!(target_arch = "wasm32") { 1 } else { 2 },
                        first_cascade_far_bound: 2.0,
                        maximum_distance: 12.0,
                        ..default()
                    }
                    .build(),
                    Transform::default().looking_to(direction, direction.any_orthonormal_vector()),
                    layer,
                )),
            )
        }
        // The camera carries the ambient light.
        SceneLight::Ambient { .. } => None,
    }
}

/// The sum of the scene's ambient lights as (linear colour, cd/m²).
pub fn ambient(model: &SceneModel) -> (Color, f32) {
    let total = model
        .lights
        .iter()
        .filter_map(|light| match light {
            SceneLight::Ambient { color, brightness } => Some(Vec3::from(*color) * *brightness),
            _ => None,
        })
        .sum::<Vec3>();
    let brightness = total.max_element().max(1e-6);
    (linear((total / brightness).into()), brightness)
}

fn linear(color: [f32; 3]) -> Color {
    Color::linear_rgb(color[0], color[1], color[2])
}

/// Mean luminance of the view, cd/m², over which the scene's picture is drawn.
pub fn mean_luminance(model: &SceneModel) -> f32 {
    model.mean_luminance_cd_m2.max(1e-3) as f32
}

fn bevy_mesh(mesh: &SceneMesh, normal_map: Option<&OnSecondUvs>) -> Mesh {
    let count = mesh.positions.len();
    // Every mesh has the same attributes, so that one pipeline draws them all.
    let mut out = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, mesh.positions.clone())
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, mesh.normals.clone())
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_UV_0,
        mesh.uvs.clone().unwrap_or_else(|| vec![[0.0; 2]; count]),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_COLOR,
        mesh.colors.clone().unwrap_or_else(|| vec![[1.0; 4]; count]),
    )
    .with_inserted_indices(Indices::U32(mesh.indices.clone()));
    let Some(on_second) = normal_map else {
        return with_second_uvs(out, mesh);
    };
    // Tangents are those of the map's own coordinates.
    let mut laid = out.clone();
    if let (true, Some(uvs)) = (on_second.normal, &mesh.second_uvs) {
        laid.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs.clone());
    }
    match laid.generate_tangents() {
        Ok(()) => {
            if let Some(tangents) = laid.remove_attribute(Mesh::ATTRIBUTE_TANGENT) {
                out.insert_attribute(Mesh::ATTRIBUTE_TANGENT, tangents);
            }
        }
        Err(error) => warn!(
            "mesh {:?} is drawn without its normal map: {error}",
            mesh.name
        ),
    }
    with_second_uvs(out, mesh)
}

fn with_second_uvs(mut out: Mesh, mesh: &SceneMesh) -> Mesh {
    if let Some(uvs) = &mesh.second_uvs {
        out.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs.clone());
    }
    out
}

fn standard_material(
    material: &SceneMaterial,
    textures: &[Handle<Image>],
    mean_cd_m2: f32,
) -> StandardMaterial {
    let texture = |index: Option<usize>| index.and_then(|index| textures.get(index).cloned());
    let [r, g, b, a] = material.base_color;
    // Bevy shows an unlit colour as it is, without exposure; the picture holds luminance over its mean.
    let unlit = if material.unlit {
        UNLIT_WHITE_CD_M2 / mean_cd_m2
    } else {
        1.0
    };
    let channel = |second: bool| {
        if second {
            UvChannel::Uv1
        } else {
            UvChannel::Uv0
        }
    };
    let on_second = material.on_second_uvs;
    StandardMaterial {
        base_color: Color::linear_rgba(unlit * r, unlit * g, unlit * b, a),
        unlit: material.unlit,
        emissive_channel: channel(on_second.emissive),
        metallic_roughness_channel: channel(on_second.metallic_roughness),
        normal_map_channel: channel(on_second.normal),
        base_color_texture: texture(material.base_color_texture),
        emissive: LinearRgba::rgb(
            material.emissive[0],
            material.emissive[1],
            material.emissive[2],
        ),
        emissive_exposure_weight: 1.0,
        emissive_texture: texture(material.emissive_texture),
        metallic: material.metallic,
        perceptual_roughness: material.roughness.clamp(0.089, 1.0),
        metallic_roughness_texture: texture(material.metallic_roughness_texture),
        normal_map_texture: texture(material.normal_texture),
        alpha_mode: match material.alpha {
            Alpha::Opaque => AlphaMode::Opaque,
            Alpha::Mask(cutoff) => AlphaMode::Mask(cutoff),
            Alpha::Blend => AlphaMode::Blend,
        },
        double_sided: material.double_sided,
        cull_mode: if material.double_sided {
            None
        } else {
            Some(Face::Back)
        },
        ..default()
    }
}

fn texture_image(texture: &SceneTexture, anisotropy: u16) -> Image {
    let mut data = texture.rgba8.clone();
    let mut levels = 1;
    for (_, _, level) in texture.mip_levels() {
        data.extend_from_slice(&level);
        levels += 1;
    }
    let mut image = Image::new_uninit(
        Extent3d {
            width: texture.width,
            height: texture.height,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        if texture.srgb {
            TextureFormat::Rgba8UnormSrgb
        } else {
            TextureFormat::Rgba8Unorm
        },
        RenderAssetUsages::RENDER_WORLD,
    );
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let address = texture.wrap.map(|wrap| match wrap {
        Wrap::Clamp => ImageAddressMode::ClampToEdge,
        Wrap::Repeat => ImageAddressMode::Repeat,
        Wrap::Mirror => ImageAddressMode::MirrorRepeat,
    });
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: address[0],
        address_mode_v: address[1],
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: anisotropy,
        ..default()
    });
    image
}
