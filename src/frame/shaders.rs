//! The shaders, carried inside the program: each entry file behind the
//! library files that it calls, as one text.
//!
//! `shaders/lib` is plain WGSL without imports or conditionals, so that joining
//! texts is all the composition it needs, here and under any later composer.

use bevy::app::{App, Plugin};
use bevy::asset::{Assets, Handle, uuid_handle};
use bevy::shader::Shader;

macro_rules! library {
    ($name:literal) => {
        include_str!(concat!("../../shaders/lib/", $name, ".wgsl"))
    };
}

/// Every file of `shaders/lib` as (name, text), for tests and for other programs.
pub const LIBRARY: &[(&str, &str)] = &[
    ("conicoid", library!("conicoid")),
    ("snell", library!("snell")),
    ("fresnel", library!("fresnel")),
    ("cornea", library!("cornea")),
    ("defocus", library!("defocus")),
    ("gaussian_ellipse", library!("gaussian_ellipse")),
    ("tear_film", library!("tear_film")),
    ("tear_layer", library!("tear_layer")),
    ("microfacet", library!("microfacet")),
    ("output", library!("output")),
    ("phase", library!("phase")),
    ("layers", library!("layers")),
    ("retinal_blur", library!("retinal_blur")),
    ("fast_strength", library!("fast_strength")),
    ("sharpness_key", library!("sharpness_key")),
    ("sharpness_voxel", library!("sharpness_voxel")),
    ("gaussian_disc", library!("gaussian_disc")),
    ("eyelid_view", library!("eyelid_view")),
    ("veil", library!("veil")),
    ("lens_shade", library!("lens_shade")),
    ("lens_mirror", library!("lens_mirror")),
    ("near_light", library!("near_light")),
    ("fundus", library!("fundus")),
    ("iris_light", library!("iris_light")),
    ("footprint", library!("footprint")),
    ("surroundings", library!("surroundings")),
    ("knots", library!("knots")),
    ("lash_comb", library!("lash_comb")),
    ("lid_shade", library!("lid_shade")),
    ("lamp_lobe", library!("lamp_lobe")),
    ("limbus", library!("limbus")),
    ("tear_reflection", library!("tear_reflection")),
    ("hair_shade", library!("hair_shade")),
    ("sclera_shade", library!("sclera_shade")),
    ("iris_relief", library!("iris_relief")),
    ("iris_shade", library!("iris_shade")),
    ("skin_shade", library!("skin_shade")),
];

/// One shader: its handle, its name, its library files and its entry files.
pub struct Source {
    /// The handle under which the materials and pipelines find it.
    pub handle: Handle<Shader>,
    /// Its name in messages.
    pub name: &'static str,
    /// The library files, in order.
    pub library: &'static [&'static str],
    /// The entry texts, in order.
    pub entry: &'static [&'static str],
}

impl Source {
    /// The whole text.
    pub fn text(&self) -> String {
        let library = self.library.iter().filter_map(|wanted| {
            LIBRARY
                .iter()
                .find(|(name, _)| name == wanted)
                .map(|(_, text)| *text)
        });
        // WGSL does not care for order; the entry leads because composers read imports from the top.
        let mut text = String::new();
        for part in self.entry.iter().copied().chain(library) {
            text.push_str(part);
            text.push('\n');
        }
        text
    }
}

/// The globe's shader.
pub const GLOBE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0001");
/// The skin's shader.
pub const SKIN: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0002");
/// The hair's shader.
pub const HAIR: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0003");
/// The meniscus' shader.
pub const MENISCUS: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0004");
/// A camera's picture into the static view.
pub const CAPTURE_SCENE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0005");
/// A photograph into the static view.
pub const CAPTURE_PHOTO: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000a");
/// The static view's mips.
pub const DOWNSAMPLE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000b");
/// The corners.
pub const FEATURES: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0006");
/// The voxel of every pixel.
pub const ASSIGN_SLOTS: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0007");
/// What is forgotten of what moved away.
pub const FORGET_LEFT: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000c");
/// What a view before remembers of what a view sees in other voxels.
pub const CARRY_OVER: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0012");
/// A table of voxels into a larger one.
pub const GROW_TABLE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000d");
/// The keys of a table, set back.
pub const REBASE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000e");
/// The sharpness field's own step.
pub const UPDATE_FIELD: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b000f");
/// The blur that is shown.
pub const READ_BLUR: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0010");
/// The veil of clouded media.
pub const VEIL: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0009");
/// The picture in which that veil is spread.
pub const VEIL_SOURCE: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0011");
/// The picture of the view.
pub const GATHER: Handle<Shader> = uuid_handle!("3f0c3a3e-5e8e-4ad8-9d5f-6a0a4a1b0008");

const PERCEPT: &str = include_str!("../../shaders/view/percept_uniform.wgsl");
const VISUAL_FIELD: &str = include_str!("../../shaders/view/visual_field.wgsl");
const MEDIA: &str = include_str!("../../shaders/view/present/media.wgsl");
const STATIC_VIEW: &str = include_str!("../../shaders/view/capture/static_view.wgsl");
const VOXEL_TABLE: &str = include_str!("../../shaders/view/field/voxel_table.wgsl");
const VOXEL_FIND: &str = include_str!("../../shaders/view/field/voxel_find.wgsl");
const VOXEL_INSERT: &str = include_str!("../../shaders/view/field/voxel_insert.wgsl");
const RAYS: &str = include_str!("../../shaders/view/field/rays.wgsl");
const MOVERS: &str = include_str!("../../shaders/view/field/movers.wgsl");
const COMMON: &str = include_str!("../../shaders/eye/common.wgsl");
const MESH: &str = include_str!("../../shaders/eye/mesh.wgsl");

/// Every shader of the program.
pub const SOURCES: &[Source] = &[
    Source {
        handle: GLOBE,
        name: "ocularium/globe.wgsl",
        library: &[
            "conicoid",
            "snell",
            "fresnel",
            "tear_film",
            "tear_layer",
            "cornea",
            "microfacet",
            "lamp_lobe",
            "footprint",
            "surroundings",
            "knots",
            "lash_comb",
            "lid_shade",
            "limbus",
            "tear_reflection",
            "sclera_shade",
            "phase",
            "layers",
            "iris_light",
            "iris_relief",
            "iris_shade",
            "lens_shade",
            "lens_mirror",
            "near_light",
            "fundus",
            "output",
        ],
        entry: &[COMMON, MESH, include_str!("../../shaders/eye/globe.wgsl")],
    },
    Source {
        handle: SKIN,
        name: "ocularium/skin.wgsl",
        library: &[
            "fresnel",
            "microfacet",
            "lamp_lobe",
            "footprint",
            "surroundings",
            "skin_shade",
            "output",
        ],
        entry: &[COMMON, MESH, include_str!("../../shaders/eye/skin.wgsl")],
    },
    Source {
        handle: HAIR,
        name: "ocularium/hair.wgsl",
        library: &["footprint", "surroundings", "hair_shade", "output"],
        entry: &[COMMON, include_str!("../../shaders/eye/hair.wgsl")],
    },
    Source {
        handle: MENISCUS,
        name: "ocularium/meniscus.wgsl",
        library: &[
            "fresnel",
            "tear_film",
            "footprint",
            "surroundings",
            "knots",
            "lash_comb",
            "lid_shade",
            "tear_reflection",
            "output",
        ],
        entry: &[
            COMMON,
            MESH,
            include_str!("../../shaders/eye/meniscus.wgsl"),
        ],
    },
    Source {
        handle: CAPTURE_SCENE,
        name: "ocularium/capture_scene.wgsl",
        library: &["retinal_blur", "output"],
        entry: &[
            PERCEPT,
            STATIC_VIEW,
            include_str!("../../shaders/view/capture/capture_scene.wgsl"),
        ],
    },
    Source {
        handle: CAPTURE_PHOTO,
        name: "ocularium/capture_photo.wgsl",
        library: &["retinal_blur", "output"],
        entry: &[
            PERCEPT,
            STATIC_VIEW,
            include_str!("../../shaders/view/capture/capture_photo.wgsl"),
        ],
    },
    Source {
        handle: DOWNSAMPLE,
        name: "ocularium/downsample.wgsl",
        library: &[],
        entry: &[include_str!("../../shaders/view/capture/downsample.wgsl")],
    },
    Source {
        handle: FEATURES,
        name: "ocularium/features.wgsl",
        library: &["fast_strength"],
        entry: &[
            PERCEPT,
            include_str!("../../shaders/view/capture/features.wgsl"),
        ],
    },
    Source {
        handle: ASSIGN_SLOTS,
        name: "ocularium/assign_slots.wgsl",
        library: &["retinal_blur", "sharpness_key", "sharpness_voxel"],
        entry: &[
            PERCEPT,
            RAYS,
            MOVERS,
            VOXEL_TABLE,
            VOXEL_FIND,
            VOXEL_INSERT,
            include_str!("../../shaders/view/field/assign_slots.wgsl"),
        ],
    },
    Source {
        handle: FORGET_LEFT,
        name: "ocularium/forget_left.wgsl",
        library: &["retinal_blur", "sharpness_key", "sharpness_voxel"],
        entry: &[
            PERCEPT,
            RAYS,
            MOVERS,
            VOXEL_TABLE,
            VOXEL_FIND,
            include_str!("../../shaders/view/field/forget_left.wgsl"),
        ],
    },
    Source {
        handle: CARRY_OVER,
        name: "ocularium/carry_over.wgsl",
        library: &["retinal_blur", "sharpness_key", "sharpness_voxel"],
        entry: &[
            PERCEPT,
            RAYS,
            VOXEL_TABLE,
            VOXEL_FIND,
            include_str!("../../shaders/view/field/carry_over.wgsl"),
        ],
    },
    Source {
        handle: GROW_TABLE,
        name: "ocularium/grow_table.wgsl",
        library: &[],
        entry: &[
            PERCEPT,
            VOXEL_TABLE,
            VOXEL_INSERT,
            include_str!("../../shaders/view/field/grow_table.wgsl"),
        ],
    },
    Source {
        handle: REBASE,
        name: "ocularium/rebase.wgsl",
        library: &["sharpness_key"],
        entry: &[
            PERCEPT,
            include_str!("../../shaders/view/field/rebase.wgsl"),
        ],
    },
    Source {
        handle: UPDATE_FIELD,
        name: "ocularium/update_field.wgsl",
        library: &["retinal_blur", "defocus", "sharpness_key"],
        entry: &[
            PERCEPT,
            VISUAL_FIELD,
            RAYS,
            VOXEL_TABLE,
            include_str!("../../shaders/view/field/update_field.wgsl"),
        ],
    },
    Source {
        handle: READ_BLUR,
        name: "ocularium/read_blur.wgsl",
        library: &["retinal_blur", "sharpness_key"],
        entry: &[
            PERCEPT,
            VISUAL_FIELD,
            RAYS,
            VOXEL_TABLE,
            include_str!("../../shaders/view/present/read_blur.wgsl"),
        ],
    },
    Source {
        handle: VEIL,
        name: "ocularium/veil.wgsl",
        library: &["veil"],
        entry: &[
            PERCEPT,
            MEDIA,
            include_str!("../../shaders/view/present/veil.wgsl"),
        ],
    },
    Source {
        handle: VEIL_SOURCE,
        name: "ocularium/veil_source.wgsl",
        library: &["veil"],
        entry: &[
            PERCEPT,
            MEDIA,
            include_str!("../../shaders/view/present/veil_source.wgsl"),
        ],
    },
    Source {
        handle: GATHER,
        name: "ocularium/gather.wgsl",
        library: &[
            "retinal_blur",
            "gaussian_disc",
            "gaussian_ellipse",
            "sharpness_key",
            "eyelid_view",
            "output",
        ],
        entry: &[
            PERCEPT,
            VISUAL_FIELD,
            MEDIA,
            include_str!("../../shaders/view/present/gather.wgsl"),
            include_str!("../../shaders/view/present/gather_ellipse.wgsl"),
        ],
    },
];

/// Puts every shader into the app.
pub struct ShadersPlugin;

impl Plugin for ShadersPlugin {
    fn build(&self, app: &mut App) {
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        for source in SOURCES {
            // A handle by UUID can always be inserted under.
            let _ = shaders.insert(
                source.handle.id(),
                Shader::from_wgsl(source.text(), source.name),
            );
        }
    }
}
