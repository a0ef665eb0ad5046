//! Every shader, composed as Bevy composes it and validated, in every combination of its defines;
//! and every pipeline of the real app.

mod branches;

use crate::stage::{open, patient, session, settle, turn};
use bevy::app::{App, Plugin};
use bevy::asset::AssetPlugin;
use bevy::math::UVec2;
use bevy::pbr::MeshMaterial3d;
use bevy::prelude::{Assets, MinimalPlugins};
use bevy::render::render_resource::{CachedPipelineState, PipelineCache};
use bevy::shader::{Shader, Source as ShaderText};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};
use ocularium::appearance::{GlobeMaterial, HairMaterial, MeniscusMaterial, SkinMaterial};
use ocularium::frame::readiness::Readiness;
use ocularium::frame::shaders::{LIBRARY, SOURCES, ShadersPlugin, Source};
use ocularium::stage::SessionCommand;
use std::collections::{BTreeSet, HashMap};

/// What the eye's shaders take from Bevy, in as few words as they need: the real modules are
/// checked in the real app below.
const STUBS: [(&str, &str); 2] = [
    (
        "stub/mesh_view_bindings.wgsl",
        "#define_import_path bevy_pbr::mesh_view_bindings
struct View {
    clip_from_view: mat4x4<f32>,
    world_position: vec3<f32>,
    viewport: vec4<f32>,
    exposure: f32,
};
@group(0) @binding(0) var<uniform> view: View;
",
    ),
    (
        "stub/mesh_functions.wgsl",
        "#define_import_path bevy_pbr::mesh_functions
@group(2) @binding(0) var<storage, read> stub_matrices: array<mat4x4<f32>>;
fn get_world_from_local(instance_index: u32) -> mat4x4<f32> {
    return stub_matrices[instance_index];
}
fn get_local_from_world(instance_index: u32) -> mat4x4<f32> {
    return transpose(stub_matrices[instance_index]);
}
fn mesh_position_local_to_clip(world_from_local: mat4x4<f32>, vertex_position: vec4<f32>) -> vec4<f32> {
    return world_from_local * vertex_position;
}
fn get_tag(instance_index: u32) -> u32 {
    return instance_index;
}
",
    ),
];

/// Names that `#ifdef` and its kin ask for.
fn defines(text: &str) -> BTreeSet<String> {
    let asked = |line: &str| {
        ["#ifdef ", "#ifndef ", "#else ifdef ", "#else ifndef "]
            .into_iter()
            .find_map(|word| {
                line.trim()
                    .strip_prefix(word)
                    .map(|name| name.trim().to_owned())
            })
    };
    let conditions = text.lines().filter(|line| line.trim().starts_with("#if"));
    for line in conditions {
        assert!(
            asked(line).is_some(),
            "a condition that this test does not know: {line}"
        );
    }
    text.lines().filter_map(asked).collect()
}

fn composer() -> Result<Composer, String> {
    let mut composer = Composer::default();
    for (file_path, source) in STUBS {
        let module = ComposableModuleDescriptor {
            source,
            file_path,
            ..Default::default()
        };
        if let Err(error) = composer.add_composable_module(module) {
            return Err(error.emit_to_string(&composer));
        }
    }
    Ok(composer)
}

/// Composes a text under these defines and validates what comes out for any WebGPU device.
fn compose(text: &str, name: &str, set: &[&String]) -> Result<naga::Module, String> {
    let mut composer = composer()?;
    let mut shader_defs: HashMap<String, ShaderDefValue> = set
        .iter()
        .map(|define| ((*define).clone(), ShaderDefValue::Bool(true)))
        .collect();
    shader_defs.insert("MATERIAL_BIND_GROUP".into(), ShaderDefValue::UInt(3));
    shader_defs.insert("LAMPS".into(), ShaderDefValue::UInt(2));
    // The groups of what an eye has that a healthy one has not, as the passes count them.
    let effects = ["FIELD_LOSS", "MEDIA"];
    for (group, effect) in (1..).zip(effects.iter().filter(|e| set.iter().any(|d| d == *e))) {
        shader_defs.insert(format!("{effect}_GROUP"), ShaderDefValue::UInt(group));
    }
    let descriptor = NagaModuleDescriptor {
        source: text,
        file_path: name,
        shader_defs: shader_defs.into_iter().collect(),
        ..Default::default()
    };
    let module = match composer.make_naga_module(descriptor) {
        Ok(module) => module,
        Err(error) => return Err(error.emit_to_string(&composer)),
    };
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    match validator.validate(&module) {
        Ok(_) => Ok(module),
        Err(error) => Err(format!("{error:?}")),
    }
}

#[test]
fn every_shader_is_valid_in_every_define_combination() {
    let mut seen = BTreeSet::new();
    for Source { name, .. } in SOURCES {
        assert!(seen.insert(*name), "{name} twice");
    }
    let mut combinations = 0;
    for source in SOURCES {
        let text = source.text();
        let known: Vec<String> = defines(&text).into_iter().collect();
        for bits in 0..1_u32 << known.len() {
            let chosen = known.iter().enumerate().filter(|(i, _)| bits >> i & 1 == 1);
            let set: Vec<&String> = chosen.map(|(_, define)| define).collect();
            let module = compose(&text, source.name, &set)
                .unwrap_or_else(|why| panic!("{} with {set:?}: {why}", source.name));
            assert!(
                !module.entry_points.is_empty(),
                "{} has no entry point",
                source.name
            );
            combinations += 1;
        }
    }
    // Sixteen shaders, of which two have a define of their own and the gather two.
    assert!(combinations >= 16 + 2 + 3, "{combinations}");
}

#[test]
fn the_validation_can_fail() {
    let gather = SOURCES
        .iter()
        .find(|source| source.name.ends_with("gather.wgsl"));
    let text = gather.expect("the gather").text();
    let glaucoma = "FIELD_LOSS".to_owned();
    let broken = text.replace(
        "let lost = 1.0 - seen_fraction",
        "let lost = 1u - seen_fraction",
    );
    assert_ne!(broken, text);
    // Only the form that has the broken line is refused.
    assert!(compose(&broken, "broken.wgsl", &[]).is_ok());
    assert!(compose(&broken, "broken.wgsl", &[&glaucoma]).is_err());
    let unknown = text.replace(
        "gaussian_disc_level(sigma, gaussian",
        "gaussian_disc_leve(sigma, gaussian",
    );
    assert!(compose(&unknown, "unknown.wgsl", &[]).is_err());
}

/// Functions of a text, each with its own part of it, and comments left out.
fn functions(text: &str) -> Vec<(String, String)> {
    let code: Vec<&str> = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect();
    let code = code.join("\n");
    let named = |part: &str| {
        let name: String = part
            .chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect();
        (name, part.to_owned())
    };
    code.split("\nfn ").skip(1).map(named).collect()
}

/// Is `name` called in this text?
fn calls(text: &str, name: &str) -> bool {
    text.match_indices(name).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let is_part = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
        !is_part && text[at + name.len()..].starts_with('(')
    })
}

/// The names among `library` that the texts call, directly or through one another.
fn reached(texts: &str, library: &[(String, String)]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![texts.to_owned()];
    while let Some(text) = open.pop() {
        for (name, part) in library {
            if !found.contains(name) && calls(&text, name) {
                found.insert(name.clone());
                open.push(part[name.len()..].to_owned());
            }
        }
    }
    found
}

#[test]
fn every_function_of_the_library_is_called() {
    let entries: Vec<&str> = SOURCES.iter().flat_map(|s| s.entry).copied().collect();
    let all: Vec<(String, String)> = LIBRARY
        .iter()
        .flat_map(|(_, text)| functions(text))
        .collect();
    let called = reached(&entries.join("\n"), &all);
    // Directly, and through another.
    assert!(called.contains("cornea_trace") && called.contains("snell_refract"));
    let idle = |called: &BTreeSet<String>| -> Vec<String> {
        let names = all.iter().map(|(name, _)| name.clone());
        names.filter(|name| !called.contains(name)).collect()
    };
    assert_eq!(idle(&called), Vec::<String>::new(), "no shader calls these");
    // The globe's less, and what it alone calls is missed.
    let others: Vec<&str> = entries
        .iter()
        .copied()
        .filter(|text| !text.contains("through_cornea"))
        .collect();
    assert!(idle(&reached(&others.join("\n"), &all)).contains(&"cornea_trace".to_owned()));
}

/// Functions of a text that take a table by value.
fn takers_of_tables(text: &str) -> Vec<String> {
    let heads = text.lines().filter_map(|line| line.strip_prefix("fn "));
    heads
        .filter_map(|head| head.split_once('('))
        .filter(|(_, rest)| {
            let parameters = rest.split("->").next().unwrap_or_default();
            parameters.contains("array<") && !parameters.contains("ptr<")
        })
        .map(|(name, _)| name.to_owned())
        .collect()
}

/// A table that is handed over is copied before it is indexed: two lid margins cost 80 of an eye's 188 ms so. These read theirs at places that the compiler knows.
#[test]
fn no_table_is_handed_to_a_function() {
    let handed: Vec<String> = LIBRARY
        .iter()
        .map(|(_, text)| *text)
        .chain(SOURCES.iter().flat_map(|source| source.entry).copied())
        .flat_map(takers_of_tables)
        .collect();
    let known: BTreeSet<String> = handed.into_iter().collect();
    assert_eq!(
        known.iter().map(String::as_str).collect::<Vec<_>>(),
        ["ambient_light", "fast_strength_of"]
    );
    let margin = "fn lid_height(heights: array<vec4<f32>, 8>, x: f32) -> f32 {";
    assert_eq!(takers_of_tables(margin), ["lid_height"]);
    let gives = "fn tent_weights(i: u32) -> array<f32, 5> {";
    assert_eq!(takers_of_tables(gives), Vec::<String>::new());
}

/// The tests that run a function beside its twin.
const TWINS: [&str; 13] = [
    include_str!("shader_twins.rs"),
    include_str!("shader_twins/artistic.rs"),
    include_str!("shader_twins/error_map.rs"),
    include_str!("shader_twins/eye_light.rs"),
    include_str!("shader_twins/inner_light.rs"),
    include_str!("shader_twins/iris_light.rs"),
    include_str!("shader_twins/light.rs"),
    include_str!("shader_twins/percept.rs"),
    include_str!("shader_twins/refraction.rs"),
    include_str!("shader_twins/shading.rs"),
    include_str!("shader_twins/shading_maps.rs"),
    include_str!("shader_twins/shading_skin.rs"),
    include_str!("shader_twins/tissue.rs"),
];

#[test]
fn every_function_of_the_library_runs_beside_its_twin() {
    let library: Vec<(String, String)> = LIBRARY
        .iter()
        .flat_map(|(_, text)| functions(text))
        .collect();
    // A test that goes through a list of names puts the call together from them.
    let texts = |twins: &[&str]| twins.join("\n").replace("\",", "(");
    let tested = reached(&texts(&TWINS), &library);
    let without: Vec<&str> = library
        .iter()
        .map(|(name, _)| name.as_str())
        .filter(|name| !tested.contains(*name))
        .collect();
    assert!(
        without.is_empty(),
        "no test calls {without:?}, nor a function that calls them"
    );
    assert!(library.len() > 100, "{} functions", library.len());
    // A test less, and its functions are missed.
    assert!(reached(&texts(&TWINS[1..4]), &library).len() < tested.len());
}

#[test]
fn the_app_carries_the_texts_that_were_validated() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default()));
    app.world_mut().init_resource::<Assets<Shader>>();
    ShadersPlugin.build(&mut app);
    let shaders = app.world().resource::<Assets<Shader>>();
    for source in SOURCES {
        let shader = shaders.get(&source.handle).expect(source.name);
        let ShaderText::Wgsl(text) = &shader.source else {
            panic!("{} is no WGSL", source.name)
        };
        assert_eq!(text.as_ref(), source.text());
        for file in source.library {
            let carried = format!("{}.wgsl", file);
            let path = crate::gpu::library_folder().join(carried);
            let file = std::fs::read_to_string(path).expect("a library file");
            assert!(text.contains(&file), "{} lacks a library file", source.name);
        }
    }
}

#[test]
fn every_pipeline_of_the_app_is_built() {
    let _turn = turn();
    let size = UVec2::splat(96);
    let mut headless = open(session(patient("healthy-green"), 2), size, size, [true; 2]);
    settle(&mut headless);
    let glaucoma = patient("glaucoma-moderate");
    headless.command(SessionCommand::Patient(Box::new(glaucoma)));
    headless.go_to(0.0);
    settle(&mut headless);

    let world = headless.world();
    assert_eq!(world.resource::<Readiness>().errors(), Vec::<String>::new());
    // All four materials of the eye are on something that is drawn.
    assert!(
        world
            .query::<&MeshMaterial3d<GlobeMaterial>>()
            .iter(world)
            .count()
            > 0
    );
    assert!(
        world
            .query::<&MeshMaterial3d<SkinMaterial>>()
            .iter(world)
            .count()
            > 0
    );
    assert!(
        world
            .query::<&MeshMaterial3d<HairMaterial>>()
            .iter(world)
            .count()
            > 0
    );
    assert!(
        world
            .query::<&MeshMaterial3d<MeniscusMaterial>>()
            .iter(world)
            .count()
            > 0
    );

    let cache = headless.render_world().resource::<PipelineCache>();
    let mut built = 0;
    for pipeline in cache.pipelines() {
        assert!(
            matches!(pipeline.state, CachedPipelineState::Ok(_)),
            "{:?}",
            pipeline.descriptor
        );
        built += 1;
    }
    // Eleven passes of the view, three of them in a second form, four materials, and the scene's.
    assert!(built > 11 + 3 + 4, "{built} pipelines");
}
