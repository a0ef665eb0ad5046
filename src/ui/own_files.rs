//! A user's own files in the window and on the page: dropped or chosen, read in memory, never sent.
//!
//! Enters: files with their names, as they came together. Leaves: a patient or a scene, or the
//! sentence that says what is wrong with them.

use crate::patients::{PatientFile, parse_patient};
use crate::scene::catalog::{FileKind, LoadedScene, other_format};
use crate::scene::gltf_file::{Beside, load_gltf_among};
use crate::scene::photo::PhotoOptions;
use crate::scene::pictures::{by_number, load_pictures};
use std::path::PathBuf;
use std::sync::Arc;

/// One file of a user's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnFile {
    /// Its name, for lists and sentences.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// The folder in which it lies, where that can be known.
    pub folder: Option<PathBuf>,
    /// It was given as a photograph's depth image; others are told by their names.
    pub is_depth: bool,
}

/// What a user's files turned out to be.
#[derive(Clone, Debug)]
pub enum Own {
    /// A patient.
    Patient(Box<PatientFile>),
    /// A scene.
    Scene(LoadedScene),
}

/// How a user's own scene stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Of a photograph.
    pub photo: PhotoOptions,
    /// Metres in one unit of a model; `None`: as glTF says, with a question where the size is odd.
    pub unit_m: Option<f32>,
}

/// Reads what came together: a patient file, or a model with the files that it names, or a
/// photograph, perhaps with its depth image (the name with `depth` in it), or three and more pictures
/// that follow one another by their names.
///
/// # Errors
/// One sentence about the file that cannot be read.
pub fn read_own_files(files: &[OwnFile], placement: &Placement) -> Result<Own, String> {
    let Some(first) = files.first() else {
        return Err("No file was chosen.".into());
    };
    let of_kind = |kind: FileKind| {
        let is_such = move |file: &&OwnFile| FileKind::of(&file.name, &file.bytes) == Some(kind);
        files.iter().filter(is_such)
    };
    if let Some(model) = of_kind(FileKind::Model).next() {
        let beside: Vec<(String, Vec<u8>)> = files
            .iter()
            .filter(|file| !std::ptr::eq(*file, model))
            .map(|file| (file.name.clone(), file.bytes.clone()))
            .collect();
        let beside = match &model.folder {
            Some(folder) => Beside::Folder(folder),
            None => Beside::Files(&beside),
        };
        let scene = load_gltf_among(&model.bytes, &model.name, beside, placement.unit_m);
        return scene
            .map(|scene| Own::Scene(LoadedScene::Model(Box::new(scene))))
            .map_err(|error| error.to_string());
    }
    let pictures: Vec<&OwnFile> = of_kind(FileKind::Picture).collect();
    if pictures.is_empty() {
        return read_patient(first, files.len());
    }
    let (mut pictures, depth) = told_apart(pictures)?;
    pictures.sort_by(|a, b| by_number(&a.name, &b.name));
    let depth = depth.map(|depth| (depth.bytes.as_slice(), depth.name.as_str()));
    let named: Vec<(String, &[u8])> = pictures
        .iter()
        .map(|picture| (picture.name.clone(), &picture.bytes[..]))
        .collect();
    let name = match &pictures[..] {
        [first, .., last] => format!("{} … {}", first.name, last.name),
        _ => pictures[0].name.clone(),
    };
    load_pictures(&named, &name, depth, &placement.photo)
        .map(|photo| Own::Scene(LoadedScene::Photo(Arc::new(photo))))
        .map_err(|error| error.to_string())
}

/// Pictures to be seen, and the depth image among them: that which was given as such, or else the one of a
/// few that is called so.
fn told_apart(pictures: Vec<&OwnFile>) -> Result<(Vec<&OwnFile>, Option<&OwnFile>), String> {
    let is_said = pictures.iter().any(|file| file.is_depth);
    let is_depth =
        |file: &OwnFile| file.is_depth || (!is_said && file.name.to_lowercase().contains("depth"));
    let is_pair = pictures.len() == 2;
    if pictures.len() == 1 {
        return Ok((pictures, None));
    }
    let (depths, seen): (Vec<&OwnFile>, Vec<&OwnFile>) =
        pictures.iter().copied().partition(|file| is_depth(file));
    match (&depths[..], &seen[..]) {
        ([depth], [_, ..]) => Ok((seen, Some(*depth))),
        ([], [one, other]) if is_pair => Err(neither_is_depth(one, other)),
        ([one, other], []) => Err(neither_is_depth(one, other)),
        ([], _) => Ok((seen, None)),
        ([first, ..], _) => Err(format!(
            "{} pictures came together, of which {} are called depth, such as \"{}\": one depth image is that of all.",
            pictures.len(),
            depths.len(),
            first.name
        )),
    }
}

fn neither_is_depth(one: &OwnFile, other: &OwnFile) -> String {
    format!(
        "Two pictures came together, \"{}\" and \"{}\", and neither or both are called depth: choose one, a photograph and its depth image, or three and more that follow one another.",
        one.name, other.name
    )
}

fn read_patient(file: &OwnFile, count: usize) -> Result<Own, String> {
    let name = &file.name;
    if count > 1 {
        return Err(format!(
            "{count} files came together and none is a model or a picture: choose one patient file."
        ));
    }
    let text = std::str::from_utf8(&file.bytes)
        .ok()
        .filter(|text| !text.contains('\0'));
    if let Some(reason) = other_format(name) {
        return Err(format!("\"{name}\" cannot be shown: {reason}."));
    }
    let Some(text) = text else {
        return Err(format!(
            "\"{name}\" is neither a picture, nor a glTF model, nor a patient file (RON)."
        ));
    };
    if text.trim().is_empty() {
        return Err(format!("\"{name}\" is empty."));
    }
    parse_patient(text, name)
        .map(|patient| Own::Patient(Box::new(patient)))
        .map_err(|error| format!("{error}."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
    use std::io::Cursor;

    fn file(name: &str, bytes: impl Into<Vec<u8>>) -> OwnFile {
        OwnFile {
            name: name.into(),
            bytes: bytes.into(),
            folder: None,
            is_depth: false,
        }
    }

    fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn read(files: &[OwnFile]) -> Result<Own, String> {
        read_own_files(files, &Placement::default())
    }

    #[test]
    fn each_kind_of_file_is_known_by_its_content() {
        let photo = png(RgbImage::new(32, 24));
        assert!(matches!(
            read(&[file("odd.name", photo.clone())]),
            Ok(Own::Scene(LoadedScene::Photo(_)))
        ));
        let Ok(Own::Patient(patient)) = read(&[file("ann.txt", "(name: \"Ann\", sphere_d: -2)")])
        else {
            panic!("a patient")
        };
        assert_eq!((patient.name.as_str(), patient.sphere_d), ("Ann", -2.0));
        let depth = png(GrayImage::from_pixel(32, 24, image::Luma([255])));
        let with_depth = read(&[file("a_depth.png", depth), file("a.png", photo)]);
        let Ok(Own::Scene(LoadedScene::Photo(photo))) = with_depth else {
            panic!("a photograph")
        };
        assert!((photo.depth_at_m(3, 3) - 0.5).abs() < 1e-6, "white is near");
    }

    #[test]
    fn pictures_that_come_together_follow_one_another_by_their_numbers() {
        let shaded = |shade: u8| png(RgbImage::from_pixel(32, 24, image::Rgb([shade; 3])));
        let depth = png(GrayImage::from_pixel(32, 24, image::Luma([255])));
        let files = [
            file("f10.png", shaded(30)),
            file("f9.png", shaded(20)),
            file("f_depth.png", depth),
            file("f8.png", shaded(10)),
        ];
        let Ok(Own::Scene(LoadedScene::Photo(photo))) = read(&files) else {
            panic!("pictures")
        };
        let shade = |index| photo.picture(index)[0] / 257;
        assert_eq!([0, 1, 2].map(shade), [10, 20, 30]);
        assert_eq!(photo.name, "f8.png … f10.png");
        assert!((photo.depth_at_m(3, 3) - 0.5).abs() < 1e-6, "white is near");
        // As from 25 a second.
        assert_eq!(photo.picture_at(0.05), 1);
    }

    #[test]
    fn a_model_finds_the_files_that_came_with_it() {
        let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "buffers":[{"byteLength":36,"uri":"parts/tri.bin"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
        let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let corners: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
        let (model, buffer) = (file("m.gltf", text), file("tri.bin", corners));
        for files in [[buffer.clone(), model.clone()], [model.clone(), buffer]] {
            let Ok(Own::Scene(LoadedScene::Model(scene))) = read(&files) else {
                panic!("a model")
            };
            assert_eq!(scene.triangle_count(), 1);
        }
        let error = read(&[model]).unwrap_err();
        assert!(
            error.contains("parts/tri.bin") && error.contains("together"),
            "{error}"
        );
    }

    #[test]
    fn what_is_nothing_of_these_gets_a_sentence_with_its_name() {
        let picture = png(RgbImage::new(32, 24));
        for (files, parts) in [
            (vec![], &["No file"][..]),
            (vec![file("a.bin", [0u8, 159, 1])], &["a.bin", "neither"]),
            (vec![file("a.ron", "  \n")], &["a.ron", "empty"]),
            (
                vec![file("a.ron", "(age_years: 300)")],
                &["a.ron", "age_years", "1 to 110"],
            ),
            (vec![file("a.ron", "()"), file("b.ron", "()")], &["2 files"]),
            (
                vec![
                    file("a.png", picture.clone()),
                    file("b.png", picture.clone()),
                ],
                &["a.png", "b.png"],
            ),
            (
                vec![
                    file("a.png", picture.clone()),
                    file("b.png", picture.clone()),
                    file("depth1.png", picture.clone()),
                    file("depth2.png", picture),
                ],
                &["4 pictures", "2 are called depth", "depth1.png"],
            ),
            (
                vec![file("a.heic", &b"\0\0\0\x18ftypheic"[..])],
                &["a.heic", "HEIC", "PNG or JPEG"],
            ),
            (vec![file("a.glb", &b"glTF"[..])], &["a.glb", "glTF"]),
        ] {
            let sentence = read(&files).unwrap_err();
            for part in parts {
                assert!(sentence.contains(part), "{part} is not in {sentence}");
            }
            assert!(
                sentence.ends_with('.') && !sentence.contains('\n'),
                "{sentence}"
            );
        }
    }

    #[test]
    fn what_was_given_as_depth_is_depth_whatever_it_is_called() {
        let picture = file("depth of field.png", png(RgbImage::new(16, 16)));
        let grey = file(
            "b.png",
            png(GrayImage::from_pixel(16, 16, image::Luma([255]))),
        );
        let given = OwnFile {
            is_depth: true,
            ..grey
        };
        for files in [[picture.clone(), given.clone()], [given, picture]] {
            let Ok(Own::Scene(LoadedScene::Photo(photo))) = read(&files) else {
                panic!("a photograph")
            };
            assert_eq!(photo.name, "depth of field.png");
            assert_eq!(photo.depth_at_m(8, 8), 0.5);
        }
    }
}
