//! Every number is where its shader reads it.

use super::*;
use crate::appearance::illumination::{Lamp, MOST_LAMPS};
use crate::frame::shaders;
use bevy::render::render_resource::encase::UniformBuffer;

/// Where a shader has the members of a struct, in bytes, as the program that runs it is parsed.
fn offsets(shader: &bevy::asset::Handle<bevy::shader::Shader>, name: &str) -> Vec<(String, u32)> {
    let source = shaders::SOURCES
        .iter()
        .find(|source| source.handle == *shader)
        .expect("a shader");
    // The structs alone: the stages need Bevy's own modules.
    let text = source.text();
    let begins = text.match_indices("struct ").map(|(at, _)| at);
    let text: String = begins
        .filter(|at| text[..*at].ends_with('\n'))
        .filter_map(|at| {
            let end = text[at..].find('}')?;
            let all = &text[at..=at + end];
            Some(
                all.replace("@builtin(position)", "")
                    .replace("@builtin(instance_index)", ""),
            )
        })
        .collect();
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{error}"));
    let found = module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, .. } if ty.name.as_deref() == Some(name) => {
            let member = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset);
            Some(members.iter().map(member).collect())
        }
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no {name}"))
}

macro_rules! same {
    ($uniform:ty, $shader:expr, $name:literal, $($field:ident = $value:expr),+ $(,)?) => {{
        let offsets = offsets(&$shader, $name);
        $({
            let mut own = <$uniform>::default();
            let empty = bytes(&own);
            own.$field = $value;
            let first = bytes(&own)
                .iter()
                .zip(&empty)
                .position(|(now, before)| now != before)
                .expect(stringify!($field));
            let wanted = offsets
                .iter()
                .find(|(name, _)| name == stringify!($field))
                .unwrap_or_else(|| panic!("no {} in {}", stringify!($field), $name));
            // A number's first byte may be the same in both.
            assert_eq!(first / 4 * 4, wanted.1 as usize, "{}.{}", $name, stringify!($field));
        })+
        let named = [$(stringify!($field)),+];
        for (name, _) in offsets {
            assert!(name == "lids" || named.contains(&name.as_str()), "{} has {name}", $name);
        }
    }};
}

fn bytes<U: ShaderType + bevy::render::render_resource::encase::internal::WriteInto>(
    uniform: &U,
) -> Vec<u8> {
    let mut buffer = UniformBuffer::new(Vec::new());
    buffer.write(uniform).expect("it is written");
    buffer.into_inner()
}

#[test]
fn every_number_is_where_its_shader_reads_it() {
    same!(
        Lamp,
        shaders::GLOBE,
        "Lamp",
        direction = Vec3::splat(9.0),
        radius = 9.0,
        color = Vec3::splat(9.0),
        hole = 9.0,
        vergence = 9.0
    );
    same!(
        Illumination,
        shaders::GLOBE,
        "Illumination",
        lamps = [Lamp {
            direction: Vec3::splat(9.0),
            ..Lamp::default()
        }; MOST_LAMPS],
        ambient = [Vec4::splat(9.0); 9],
        lids_lit = Vec3::splat(9.0),
        exposure = 9.0,
        is_luminance = 9.0
    );
    same!(
        GlobeUniform,
        shaders::GLOBE,
        "Globe",
        head_from_eye = Mat4::from_scale(Vec3::splat(9.0)),
        anterior_radius_mm = 9.0,
        anterior_p = 9.0,
        posterior_radius_mm = 9.0,
        posterior_p = 9.0,
        thickness_mm = 9.0,
        cornea_index = 9.0,
        aqueous_index = 9.0,
        apex_mm = 9.0,
        iris_depth_mm = 9.0,
        iris_shape = Vec2::splat(9.0),
        iris_light_mm = 9.0,
        iris_root_mm = 9.0,
        limbus_mm = 9.0,
        pupil_center_mm = Vec2::splat(9.0),
        sclera_radius_mm = 9.0,
        lipid_nm = 9.0,
        tear_breakup_s = 9.0,
        lens = Vec3::splat(9.0),
        cornea_haze = Vec3::splat(9.0),
        cortical_share = 9.0,
        nucleus = Vec3::splat(9.0),
        capsule_radius_mm = 9.0,
        capsule = Vec3::splat(9.0),
        relief = 9.0,
        lens_turn = 9.0,
        lids_color = Vec3::splat(9.0),
        flesh = Vec3::splat(9.0),
        above_vessels = Vec3::splat(9.0),
        iris_sky = [Vec4::splat(9.0); SKY_RADII],
        lens_front_radius_mm = 9.0,
        lens_front_p = 9.0,
        lens_back_radius_mm = 9.0,
        lens_back_p = 9.0,
        lens_thickness_mm = 9.0,
        lens_index = 9.0,
        lens_forward_mm = 9.0,
        lens_passes = Vec3::splat(9.0),
        pupil_magnification = 9.0,
        focus = Vec3::splat(9.0),
        fundus = Vec3::splat(9.0),
        arcus = 9.0,
        lamellae_reflect = [Vec4::splat(9.0); LAMELLAE],
        lamellae_pass = [Vec4::splat(9.0); LAMELLAE],
        tissue = IrisTissueUniform {
            border: Vec3::splat(9.0),
            ..IrisTissueUniform::default()
        },
        look = LookUniform {
            iris_brightness: 9.0,
            ..LookUniform::default()
        }
    );
    same!(
        LookUniform,
        shaders::GLOBE,
        "Look",
        iris_brightness = 9.0,
        iris_size = 9.0,
        refraction = 9.0,
        caustic_scale = 9.0,
        caustic_power = 9.0,
        cornea_roughness = 9.0,
        cornea_specularity = 9.0,
        limbus_dark = 9.0,
        limbus_power = 9.0,
        limbus_color_mm = 9.0,
        limbus_shading_mm = 9.0,
        white_brightness = 9.0,
        white_roughness = 9.0,
        white_specularity = 9.0,
        white_relief = 9.0,
        white_relief_size = 9.0,
        parallax = 9.0,
        matcap = 9.0
    );
    same!(
        IrisTissueUniform,
        shaders::GLOBE,
        "IrisTissue",
        border = Vec3::splat(9.0),
        border_melanin = Vec3::splat(9.0),
        border_scattering = Vec3::splat(9.0),
        border_fibrils = Vec3::splat(9.0),
        stroma = Vec3::splat(9.0),
        stroma_scattering = Vec3::splat(9.0),
        stroma_fibrils = Vec3::splat(9.0),
        weights = Mat3::from_cols(Vec3::splat(9.0), Vec3::Y, Vec3::Z)
    );
    same!(
        SkinUniform,
        shaders::SKIN,
        "Skin",
        albedo = Vec3::splat(9.0),
        roughness = 9.0,
        flesh = Vec3::splat(9.0),
        pores = 9.0,
        blood = Vec3::splat(9.0),
        melanin = Vec3::splat(9.0),
        lid = Vec3::splat(9.0),
        wrinkles_mm = 9.0,
        mirror = 9.0
    );
    same!(
        HairUniform,
        shaders::HAIR,
        "Hair",
        root = Vec3::splat(9.0),
        tip = Vec3::splat(9.0)
    );
    same!(
        MeniscusUniform,
        shaders::MENISCUS,
        "Meniscus",
        strength = 9.0,
        lids = Vec3::splat(9.0)
    );
}
