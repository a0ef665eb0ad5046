//! The house: which part may know which, read from the sources themselves.

use std::fs;
use std::path::{Path, PathBuf};

/// The parts from the ground up. One may use what stands before it, and nothing beside or after it.
const STOREYS: &[&[&str]] = &[
    &["input_file", "output_file"],
    &["tissue"],
    &["optics"],
    &["anatomy"],
    &["frame"],
    &["conditions", "scene", "motion", "appearance"],
    &["percept"],
    &["patients"],
    &["plugins"],
    &["stage"],
    &["lab", "ui"],
    &["app"],
];

fn storey(part: &str) -> Option<usize> {
    STOREYS.iter().position(|storey| storey.contains(&part))
}

/// The program's own text: without comments, and without what only tests compile.
fn code(text: &str) -> String {
    let text = match text.find("#[cfg(test)]\nmod tests {") {
        Some(end) => &text[..end],
        None => text,
    };
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Parts that a text names by `crate::`.
fn used(text: &str) -> Vec<String> {
    text.split("crate::")
        .skip(1)
        .map(|rest| {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'));
            rest[..end.unwrap_or(rest.len())].to_owned()
        })
        .collect()
}

/// What is wrong with a text of this part, if anything.
fn faults(part: &str, text: &str) -> Vec<String> {
    let Some(own) = storey(part) else {
        return vec![format!("{part} stands on no storey")];
    };
    used(&code(text))
        .into_iter()
        .filter(|other| other != part)
        .filter(|other| storey(other).is_none_or(|other| other >= own))
        // Types at the root are the plugins together.
        .filter(|other| !(other == "OculariumPlugins" && own > storey("plugins").unwrap_or(0)))
        .map(|other| format!("{part} uses {other}"))
        .collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn no_part_knows_what_stands_above_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 100, "the sources were not found");
    let mut all = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&root).expect("within");
        let name = inside.to_string_lossy().into_owned();
        let part = name.split(['/', '.']).next().unwrap_or_default();
        if matches!(part, "lib" | "main") || name.ends_with("tests.rs") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a text");
        all.extend(
            faults(part, &text)
                .into_iter()
                .map(|fault| format!("{name}: {fault}")),
        );
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn an_arrow_upwards_is_seen() {
    assert_eq!(
        faults("anatomy", "use crate::optics::pupil;"),
        Vec::<String>::new()
    );
    assert_eq!(
        faults("anatomy", "let x = crate::app::run();\n// crate::lab"),
        ["anatomy uses app"]
    );
    assert_eq!(
        faults("motion", "use crate::scene::model;"),
        ["motion uses scene"]
    );
    assert_eq!(faults("attic", ""), ["attic stands on no storey"]);
    assert!(faults("scene", "a\n#[cfg(test)]\nmod tests {\nuse crate::app;").is_empty());
}

/// The mathematics alone brings no engine, no window and no command line.
#[test]
fn the_library_without_features_is_mathematics() {
    let tree = |arguments: &[&str]| {
        let said = std::process::Command::new(env!("CARGO"))
            .args(["tree", "--offline", "-e", "normal", "--prefix", "none"])
            .args(arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("cargo");
        assert!(
            said.status.success(),
            "{}",
            String::from_utf8_lossy(&said.stderr)
        );
        String::from_utf8_lossy(&said.stdout).into_owned()
    };
    let has = |tree: &str, name: &str| tree.lines().any(|line| line.starts_with(name));
    let alone = tree(&["--no-default-features"]);
    for name in ["bevy", "wgpu", "egui", "clap", "plotters", "image"] {
        assert!(!has(&alone, name), "{name} in {alone}");
    }
    assert!(has(&alone, "glam"), "the tree was not read: {alone}");
    let plugins = tree(&["--no-default-features", "--features", "bevy"]);
    for name in ["egui", "bevy_egui", "clap", "plotters", "criterion"] {
        assert!(!has(&plugins, name), "{name} beside the plugins");
    }
    assert!(has(&plugins, "bevy_pbr"), "the tree was not read");
}

/// The README's table of a patient file is that of the program.
#[test]
fn the_readme_knows_every_field_of_a_patient_file() {
    use ocularium::conditions::{Cataract, Condition, Glaucoma, Ptosis};
    use ocularium::patients::{CONDITIONS, FIELDS, PRESETS, PatientFile};
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let readme = fs::read_to_string(readme).expect("the README");
    let row = |name: &str| {
        readme
            .lines()
            .find(|line| line.starts_with(&format!("| `{name}`")))
            .unwrap_or_else(|| panic!("no row of {name}"))
    };
    let shown = |value: f64| format!("{value}").replace('-', "−");
    for field in FIELDS {
        let (low, high) = field.range;
        let range = format!("{} to {}", shown(low), shown(high));
        assert!(row(field.name).contains(&range), "{}: {range}", field.name);
        // What it is without the file's word; a pair stands in its own brackets.
        let usual = row(field.name).split('|').nth(3).unwrap_or_default().trim();
        match (field.get)(&PatientFile::default()) {
            Some(value) => {
                let mut numbers = usual
                    .trim_matches(|c| "`()".contains(c))
                    .split(',')
                    .map(str::trim);
                let number = numbers
                    .nth(field.index)
                    .unwrap_or_default()
                    .replace('−', "-");
                assert_eq!(number.parse(), Ok(value), "{}: {usual}", field.name);
            }
            None => assert!(usual.parse::<f64>().is_err(), "{}: {usual}", field.name),
        }
        if !field.unit.is_empty() {
            assert!(
                row(field.name).contains(field.unit),
                "{}: {}",
                field.name,
                field.unit
            );
        }
    }
    for (name, meaning) in CONDITIONS {
        let ranges: Vec<(f64, f64)> = match *name {
            "glaucoma" => Glaucoma::controls().iter().map(|own| own.range).collect(),
            "cataract" => Cataract::controls().iter().map(|own| own.range).collect(),
            "ptosis" => Ptosis::controls().iter().map(|own| own.range).collect(),
            other => panic!("{other} has no row here"),
        };
        for (low, high) in ranges {
            for text in [row(name), meaning] {
                let is_there = [(low, high), (high, low)]
                    .iter()
                    .any(|(from, to)| text.contains(&format!("{from} to {to}")));
                assert!(is_there, "{name}: {low} to {high} is not in {text}");
            }
        }
    }
    // What no single eye may have is listed, and nothing else is.
    let (_, alone) = readme
        .split_once("The person alone has ")
        .expect("the list");
    let (alone, _) = alone.split_once(';').expect("its end");
    for field in FIELDS {
        let is_listed = alone.contains(&format!("`{}`", field.name));
        assert_eq!(is_listed, !field.per_eye, "{}", field.name);
    }
    for preset in PRESETS {
        assert!(
            readme.contains(&format!("`{}`", preset.name)),
            "{}",
            preset.name
        );
    }
}

/// Paths in the documents' code spans: words that begin with a folder of the project.
fn named_paths(text: &str) -> Vec<&str> {
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter(|span| {
            let top = span.split('/').next().unwrap_or_default();
            let folders = [
                "src", "tests", "shaders", "examples", "web", "assets", "docs",
            ];
            span.contains('/') && folders.contains(&top)
        })
        // What is built is not in a clone.
        .filter(|span| !span.starts_with("web/dist"))
        .filter(|span| !span.contains([' ', '\n', '<']))
        .collect()
}

/// A path with each of what it has in braces.
fn each_of(path: &str) -> Vec<String> {
    let parts = path.split_once('{').and_then(|(before, rest)| {
        rest.split_once('}')
            .map(|(list, after)| (before, list, after))
    });
    match parts {
        Some((before, list, after)) => list
            .split(',')
            .map(|one| format!("{before}{one}{after}"))
            .collect(),
        None => vec![path.to_owned()],
    }
}

/// Is there a file of this name, in whose last part a star stands for anything?
fn is_there(root: &Path, path: &str) -> bool {
    let Some((before, after)) = path.split_once('*') else {
        return root.join(path).exists();
    };
    let (folder, start) = before.rsplit_once('/').unwrap_or(("", before));
    let names = fs::read_dir(root.join(folder)).into_iter().flatten();
    let mut names = names.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.any(|name| name.starts_with(start) && name.ends_with(after))
}

#[test]
fn a_path_with_braces_or_a_star_is_looked_for() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(each_of("src/{lib,main}.rs"), ["src/lib.rs", "src/main.rs"]);
    assert!(is_there(root, "src/li*.rs") && is_there(root, "tests/shader_twins*"));
    assert!(!is_there(root, "src/nothing*.rs") && !is_there(root, "src/nothing.rs"));
}

#[test]
fn the_documents_name_files_that_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut documents = vec![root.join("README.md")];
    let docs = fs::read_dir(root.join("docs")).expect("docs");
    documents.extend(docs.map(|entry| entry.expect("an entry").path()));
    documents.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    let mut count = 0;
    for document in documents {
        let text = fs::read_to_string(&document).expect("text");
        for path in named_paths(&text) {
            count += 1;
            for one in each_of(path) {
                assert!(is_there(root, &one), "{} names {one}", document.display());
            }
        }
    }
    assert!(count > 20, "{count} paths");
    assert_eq!(named_paths("a `src/no.rs` b `cargo run`"), ["src/no.rs"]);
}
