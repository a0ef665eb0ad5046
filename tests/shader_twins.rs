//! The functions of `shaders/lib` against its f64 twin, on thousands of seeded inputs;
//! and the proof that the comparison can fail.
//!
//! Tolerances: f32 carries 6e-8 of a number. A function of a dozen operations on eye-sized numbers
//! (10 mm) is good to about 1e-5 mm; WGSL allows `sqrt`, `exp`, `cos` and `pow` a few roundings
//! more. Where a function is steep or jumps (grazing rays, the edge of total reflection), a result
//! may be as far off as the rounding of its inputs explains, for the share of inputs given.

use crate::gpu::{Gpu, Twin, joined_library, library_folder, library_text};
mod artistic;
mod error_map;
mod eye_light;
mod inner_light;
mod iris_light;
mod light;
mod percept;
mod refraction;
mod shading;
mod shading_maps;
mod shading_skin;
mod tissue;

use glam::{DVec2, DVec3};
use ocularium::frame::shaders::LIBRARY;
use ocularium::optics::{fresnel, snell};
use rand::RngExt;
use rand_pcg::Pcg64;

fn between(rng: &mut Pcg64, low: f32, high: f32) -> f32 {
    low + (high - low) * rng.random::<f32>()
}

fn unit(rng: &mut Pcg64) -> [f32; 3] {
    let z = between(rng, -1.0, 1.0);
    let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    [r * cos, r * sin, z]
}

/// Corneas from keratoconus to flat, hyperboloids to oblate ellipsoids.
fn surface(rng: &mut Pcg64) -> [f32; 2] {
    [between(rng, 6.5, 9.0), between(rng, -0.3, 1.2)]
}

/// A direction towards a light up to `degrees` off the axis in front of the eye.
fn light(rng: &mut Pcg64, degrees: f32) -> [f32; 3] {
    let (s, c) = between(rng, 0.0, degrees).to_radians().sin_cos();
    let (sin, cos) = between(rng, 0.0, core::f32::consts::TAU).sin_cos();
    [s * cos, s * sin, -c]
}

/// A ray towards a point of the cornea's disc from up to a metre away.
fn ray(rng: &mut Pcg64) -> [f32; 6] {
    let to = light(rng, 80.0);
    let distance = 10.0_f32.powf(between(rng, 0.9, 3.0));
    let aim = [between(rng, -6.0, 6.0), between(rng, -6.0, 6.0), 1.5];
    let origin: [f32; 3] = core::array::from_fn(|i| aim[i] + distance * to[i]);
    [origin[0], origin[1], origin[2], -to[0], -to[1], -to[2]]
}

fn v3(x: &[f64]) -> DVec3 {
    DVec3::new(x[0], x[1], x[2])
}

fn v2(x: &[f64]) -> DVec2 {
    DVec2::new(x[0], x[1])
}

fn pass(twin: &Twin) {
    if let Err(why) = twin.compare() {
        panic!("{why}");
    }
}

const SNELL_CALL: &str = "let r = snell_refract(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]), x[6]); \
                          y[0] = r.x; y[1] = r.y; y[2] = r.z; y[3] = r.w;";

fn draw_snell(rng: &mut Pcg64) -> Vec<f32> {
    [&unit(rng)[..], &unit(rng), &[between(rng, 0.6, 1.6)]].concat()
}

#[test]
fn the_comparison_can_fail() {
    let snell_against = |exact: &dyn Fn(&[f64]) -> Vec<f64>, call: &str| {
        Twin {
            name: "a wrong snell_refract",
            library: &["snell"],
            call,
            draw: &draw_snell,
            exact,
            absolute: 3e-6,
            relative: 0.0,
            steep_share: 0.01,
        }
        .compare()
    };
    let right = |x: &[f64]| {
        snell::snell_refract(v3(x), v3(&x[3..]), x[6])
            .to_array()
            .to_vec()
    };
    let off_by_a_hundred_thousandth = |x: &[f64]| {
        snell::snell_refract(v3(x), v3(&x[3..]), x[6] * 1.00002)
            .to_array()
            .to_vec()
    };
    assert!(snell_against(&right, SNELL_CALL).is_ok());
    assert!(snell_against(&off_by_a_hundred_thousandth, SNELL_CALL).is_err());
    let inverted = SNELL_CALL.replace("x[6]", "1.0 / x[6]");
    assert!(snell_against(&right, &inverted).is_err());
    let nothing = "y[0] = 0.0; y[1] = 0.0; y[2] = 0.0; y[3] = 0.0;";
    assert!(snell_against(&right, nothing).is_err());
    let nan = format!("{SNELL_CALL} y[2] = bitcast<f32>(0x7fc00000u + u32(x[6]));");
    assert!(snell_against(&right, &nan).is_err());

    // Schlick's approximation is not Fresnel's formula.
    let schlick = Twin {
        name: "Schlick for fresnel_dielectric",
        library: &["fresnel"],
        call: "let f = (x[1] - 1.0) / (x[1] + 1.0); y[0] = f * f + (1.0 - f * f) * pow(1.0 - x[0], 5.0);",
        draw: &|rng| vec![between(rng, 0.0, 1.0), between(rng, 1.3, 1.5)],
        exact: &|x| vec![fresnel::fresnel_dielectric(x[0], 1.0, x[1])],
        absolute: 1e-6,
        relative: 0.0,
        steep_share: 0.03,
    };
    assert!(schlick.compare().is_err());
}

#[test]
fn every_library_file_is_valid_plain_wgsl() {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(library_folder()).expect("shaders/lib exists") {
        let name = entry
            .expect("readable")
            .file_name()
            .into_string()
            .expect("plain name");
        names.push(name.strip_suffix(".wgsl").expect("only WGSL").to_owned());
    }
    assert!(names.len() >= 11, "{names:?}");
    for name in &names {
        let own = library_text(name);
        for line in own
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            for banned in [
                "#",
                "@group",
                "@binding",
                "var<",
                "@fragment",
                "@vertex",
                "@compute",
            ] {
                assert!(!line.contains(banned), "{name}.wgsl has {banned}: {line}");
            }
        }
        let text = joined_library(&[name]);
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{name}.wgsl: {}", error.emit_to_string(&text)));
        let mut validator = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        );
        if let Err(error) = validator.validate(&module) {
            panic!("{name}.wgsl: {}", error.emit_to_string(&text));
        }
    }
    println!(
        "{} files valid; adapter {}",
        names.len(),
        Gpu::shared().name
    );
}

#[test]
fn no_library_file_goes_without_a_twin() {
    let mut names: Vec<String> = std::fs::read_dir(library_folder())
        .expect("shaders/lib exists")
        .map(|entry| {
            entry
                .expect("readable")
                .file_name()
                .into_string()
                .expect("plain name")
        })
        .map(|name| name.strip_suffix(".wgsl").expect("only WGSL").to_owned())
        .collect();
    names.sort();
    let mut carried: Vec<&str> = LIBRARY.iter().map(|(name, _)| *name).collect();
    carried.sort_unstable();
    assert_eq!(
        names, carried,
        "the program carries every file of the library"
    );

    // The calls of the twin tests, as they stand in these sources.
    let tests = [
        include_str!("shader_twins/refraction.rs"),
        include_str!("shader_twins/light.rs"),
        include_str!("shader_twins/eye_light.rs"),
        include_str!("shader_twins/inner_light.rs"),
        include_str!("shader_twins/iris_light.rs"),
        include_str!("shader_twins/percept.rs"),
        include_str!("shader_twins/shading.rs"),
        include_str!("shader_twins/shading_maps.rs"),
        include_str!("shader_twins/shading_skin.rs"),
        include_str!("shader_twins/tissue.rs"),
    ]
    .concat();
    for (name, text) in LIBRARY {
        let functions: Vec<&str> = text
            .lines()
            .filter_map(|line| line.strip_prefix("fn "))
            .filter_map(|line| line.split('(').next())
            .collect();
        assert!(!functions.is_empty(), "{name}.wgsl has no function");
        let called = |function: &&str| {
            tests.contains(&format!("\"{function}\"")) || tests.contains(&format!("= {function}("))
        };
        assert!(
            functions.iter().any(called),
            "{name}.wgsl: none of {functions:?} has a twin test"
        );
    }
}

#[test]
fn the_eyes_entry_files_bind_and_call() {
    let folder = library_folder().with_file_name("eye");
    let mut functions = Vec::new();
    for entry in std::fs::read_dir(folder).expect("shaders/eye exists") {
        let text = std::fs::read_to_string(entry.expect("readable").path()).expect("a text");
        let names = text.lines().filter_map(|line| line.strip_prefix("fn "));
        functions.extend(names.filter_map(|line| Some(line.split_once('(')?.0.to_owned())));
    }
    functions.sort();
    // The stages, and what hands a binding of this file to the library: whatever computes goes there,
    // where it has a twin.
    assert_eq!(
        functions,
        [
            "ambient",
            "around_factors",
            "camera_from",
            "footprint_at",
            "fragment",
            "fragment",
            "fragment",
            "fragment",
            "fundus_light",
            "head_from_eye",
            "inner_image",
            "iris_lamp_at",
            "lamellae_reflected",
            "lamellae_through",
            "lamp_at",
            "lids_at",
            "lids_radiance",
            "mirror_eye",
            "mirrored",
            "shown",
            "skin_tile",
            "sky_at",
            "surface_at",
            "through_cornea",
            "vertex",
            "vertex"
        ]
    );
}
