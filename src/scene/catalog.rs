//! From what a user asks for to a loaded scene.
//!
//! Enters: a built-in scene's name or a file's path, and perhaps a depth image. Leaves: a
//! [`LoadedScene`], or the sentence that says what is wrong.

use super::gltf_file::{Beside, load_gltf_among};
use super::model::{SceneError, SceneModel};
use super::photo::{PhotoOptions, PhotoScene, read_file, read_named_file};
use super::picture_file::{READABLE, foreign_format};
use super::pictures::{check_extent, load_pictures, pictures_in};
use super::room;
use crate::input_file::did_you_mean;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuiltIn {
    /// The furnished room.
    Room,
    /// The eye chart in a clinic's corridor.
    Chart,
}

impl BuiltIn {
    /// All of them, in the order of a list.
    pub const ALL: [Self; 2] = [Self::Room, Self::Chart];

    /// The name by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Room => "room",
            Self::Chart => "chart",
        }
    }

    /// The title under which it stands in lists.
    pub fn title(self) -> &'static str {
        match self {
            Self::Room => "Reading room",
            Self::Chart => "Eye chart",
        }
    }

    /// One line that says what is to be seen.
    pub fn description(self) -> &'static str {
        match self {
            Self::Room => {
                "a furnished reading room: things at 0.3, 0.6, 1, 3 and 6 m and a street outside the window"
            }
            Self::Chart => "an eye chart at 6 m at the end of a clinic's corridor",
        }
    }

    /// Builds it.
    pub fn build(self) -> Result<SceneModel, SceneError> {
        match self {
            Self::Room => room::room(),
            Self::Chart => room::chart(),
        }
    }
}

/// What a file holds, as its first bytes say, so that a wrong extension does no harm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A glTF model.
    Model,
    /// A picture, whether or not its format is read.
    Picture,
}

impl FileKind {
    /// Judges a file by its bytes and, where they say nothing, by its name's extension.
    pub fn of(name: impl AsRef<Path>, bytes: &[u8]) -> Option<Self> {
        let extension = name
            .as_ref()
            .extension()
            .map(|extension| extension.to_string_lossy().to_lowercase());
        let extension = extension.as_deref().unwrap_or("");
        if bytes.starts_with(b"glTF") {
            Some(Self::Model)
        } else if image::guess_format(bytes).is_ok() {
            Some(Self::Picture)
        } else if matches!(extension, "gltf" | "glb") {
            Some(Self::Model)
        } else if foreign_format(bytes).is_some() || matches!(extension, "png" | "jpg" | "jpeg") {
            Some(Self::Picture)
        } else {
            None
        }
    }
}

/// What a file of a format without a mark is, by its name, and what to do about it.
pub fn other_format(name: impl AsRef<Path>) -> Option<String> {
    let extension = name.as_ref().extension()?.to_string_lossy().to_lowercase();
    match &*extension {
        "obj" | "fbx" | "stl" | "ply" | "blend" | "dae" | "3ds" | "usd" | "usda" | "usdc"
        | "usdz" | "abc" | "x3d" | "wrl" | "step" | "stp" | "max" | "c4d" => Some(format!(
            "it is a model in another format (.{extension}), which is not read: export it as glTF (.glb)"
        )),
        "tga" | "pcx" | "eps" | "xcf" | "kra" | "cr2" | "nef" | "arw" | "dng" | "raf" | "orf"
        | "rw2" => Some(format!(
            "it is a picture in another format (.{extension}), which is not read: save it as PNG or JPEG"
        )),
        _ => None,
    }
}

/// Where a scene comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SceneSource {
    /// The program itself.
    BuiltIn(BuiltIn),
    /// A glTF file.
    Model {
        /// The file.
        path: PathBuf,
        /// What is in it.
        bytes: Vec<u8>,
    },
    /// A photograph, or several that follow one another, perhaps with a depth image.
    Photo {
        /// The photograph, or the folder in which they are.
        path: PathBuf,
        /// The files, in the order in which they are seen, and what is in them.
        files: Vec<(String, Vec<u8>)>,
        /// Its depth image.
        depth: Option<PathBuf>,
    },
}

/// A scene of either kind.
#[derive(Debug, Clone)]
pub enum LoadedScene {
    /// Triangles.
    Model(Box<SceneModel>),
    /// A photograph.
    Photo(Arc<PhotoScene>),
}

impl LoadedScene {
    /// Its name, for lists and reports.
    pub fn name(&self) -> &str {
        match self {
            Self::Model(model) => &model.name,
            Self::Photo(photo) => &photo.name,
        }
    }

    /// Mean luminance of what is seen of it, cd/m².
    pub fn mean_luminance_cd_m2(&self) -> f64 {
        match self {
            Self::Model(model) => model.mean_luminance_cd_m2,
            Self::Photo(photo) => photo.mean_luminance_cd_m2,
        }
    }

    /// Is it a photograph of which everything is infinitely far away?
    pub fn is_far(&self) -> bool {
        match self {
            Self::Model(_) => false,
            Self::Photo(photo) => photo.depth_m.is_far(),
        }
    }

    /// What a user should know about how it was read, one sentence each.
    pub fn remarks(&self) -> &[String] {
        match self {
            Self::Model(model) => &model.remarks,
            Self::Photo(photo) => &photo.remarks,
        }
    }
}

impl SceneSource {
    /// Decides what is meant: a built-in name wins; else the file's first bytes decide, so that a
    /// wrong extension does no harm.
    pub fn parse(name_or_path: impl AsRef<Path>, depth: Option<&Path>) -> Result<Self, SceneError> {
        let path = name_or_path.as_ref();
        let shown = path.display().to_string();
        let refuse_depth = |kind: &str| match depth {
            Some(_) => Err(SceneError::Content {
                source_name: shown.clone(),
                reason: format!("a depth image goes with a photograph, not with {kind}"),
            }),
            None => Ok(()),
        };
        if let Some(scene) = BuiltIn::ALL
            .into_iter()
            .find(|scene| path.as_os_str() == scene.name())
        {
            refuse_depth("a built-in scene")?;
            return Ok(Self::BuiltIn(scene));
        }
        if !path.exists() && path.extension().is_none() && path.components().count() <= 1 {
            let known: Vec<&str> = BuiltIn::ALL.into_iter().map(BuiltIn::name).collect();
            let end = match did_you_mean(&shown, &known) {
                none if none.is_empty() => ".".to_owned(),
                question => question,
            };
            return Err(SceneError::Unknown {
                end,
                name: shown,
                known: known.join(", "),
            });
        }
        if path.is_dir() {
            return Self::of_folder(path, depth);
        }
        let bytes = read_file(path)?;
        match FileKind::of(path, &bytes) {
            Some(FileKind::Model) => {
                refuse_depth("a glTF file")?;
                Ok(Self::Model {
                    path: path.into(),
                    bytes,
                })
            }
            Some(FileKind::Picture) => Ok(Self::Photo {
                path: path.into(),
                files: vec![(shown, bytes)],
                depth: depth.map(Into::into),
            }),
            None => Err(SceneError::Malformed {
                source_name: shown,
                kind: "scene",
                reason: other_format(path).unwrap_or_else(|| {
                    format!("it is neither glTF (.gltf, .glb) nor a {READABLE}")
                }),
            }),
        }
    }

    /// The pictures of a folder, one after the other.
    fn of_folder(folder: &Path, depth: Option<&Path>) -> Result<Self, SceneError> {
        let read = |path: PathBuf| Ok((path.display().to_string(), read_file(&path)?));
        let mut found = pictures_in(folder)?;
        let is_depth = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.to_lowercase().contains("depth")
        };
        // As in the window: the one picture that is called so.
        let mut depth = depth.map(Into::into);
        let depths = found.iter().filter(|path| is_depth(path)).count();
        // Among pictures they would be taken for pictures.
        if depths > 1 && depths < found.len() {
            return Err(SceneError::Content {
                source_name: folder.display().to_string(),
                reason: format!(
                    "{depths} of its {} pictures are called depth images, but one goes with all of a folder: \
                     leave the others out",
                    found.len()
                ),
            });
        }
        if depth.is_none() && found.len() > 1 && depths == 1 {
            depth = found.iter().position(is_depth).map(|at| found.remove(at));
        }
        // Before all of them are read.
        if let Ok(size) = image::image_dimensions(&found[0]) {
            check_extent(size, found.len(), &folder.display().to_string())?;
        }
        let files: Result<_, SceneError> = found.into_iter().map(read).collect();
        Ok(Self::Photo {
            path: folder.into(),
            files: files?,
            depth,
        })
    }

    /// Loads it: a photograph with these options, a model whose unit is `unit_m` metres.
    pub fn load(
        &self,
        options: &PhotoOptions,
        unit_m: Option<f32>,
    ) -> Result<LoadedScene, SceneError> {
        match self {
            Self::BuiltIn(scene) => Ok(LoadedScene::Model(Box::new(scene.build()?))),
            Self::Model { path, bytes } => {
                let folder = path.parent().unwrap_or(Path::new("."));
                let name = path.display().to_string();
                let model = load_gltf_among(bytes, &name, Beside::Folder(folder), unit_m)?;
                Ok(LoadedScene::Model(Box::new(model)))
            }
            Self::Photo { path, files, depth } => {
                let depth_bytes = depth
                    .as_deref()
                    .map(|depth| read_named_file(depth, "depth image"))
                    .transpose()?;
                let depth_name = depth.as_deref().map(|depth| depth.display().to_string());
                let files: Vec<(String, &[u8])> = files
                    .iter()
                    .map(|(name, bytes)| (name.clone(), &bytes[..]))
                    .collect();
                let name = path.display().to_string();
                let depth = depth_bytes.as_deref().zip(depth_name.as_deref());
                let photo = load_pictures(&files, &name, depth, options)?;
                Ok(LoadedScene::Photo(Arc::new(photo)))
            }
        }
    }

    /// [`SceneSource::parse`], then [`SceneSource::load`] with default [`PhotoOptions`].
    pub fn resolve(
        name_or_path: impl AsRef<Path>,
        depth: Option<&Path>,
    ) -> Result<LoadedScene, SceneError> {
        Self::parse(name_or_path, depth)?.load(&PhotoOptions::default(), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_names_resolve_and_unknown_ones_list_them() {
        for scene in BuiltIn::ALL {
            assert_eq!(
                SceneSource::parse(scene.name(), None),
                Ok(SceneSource::BuiltIn(scene))
            );
            assert!(!scene.description().is_empty());
        }
        let message = SceneSource::parse("kitchen", None).unwrap_err().to_string();
        assert!(
            message.contains("\"kitchen\"") && message.contains("room, chart"),
            "{message}"
        );
        assert!(SceneSource::parse("room", Some(Path::new("d.png"))).is_err());
        let message = SceneSource::parse("no/such.glb", None)
            .unwrap_err()
            .to_string();
        assert!(message.contains("does not exist"), "{message}");
    }

    #[test]
    fn several_depth_images_are_not_taken_for_pictures() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["1.png", "1_depth.png", "2.png", "2_depth.png"] {
            image::RgbImage::new(16, 16)
                .save(folder.path().join(name))
                .unwrap();
        }
        let error = SceneSource::parse(folder.path(), None).unwrap_err();
        assert!(error.to_string().contains("2 of its 4 pictures"), "{error}");
        std::fs::remove_file(folder.path().join("2_depth.png")).unwrap();
        let source = SceneSource::parse(folder.path(), None).unwrap();
        assert!(
            matches!(source, SceneSource::Photo { depth: Some(_), files, .. } if files.len() == 2)
        );
    }

    #[test]
    fn content_decides_over_the_extension() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path.display().to_string()
        };
        let photo = folder.path().join("photo.dat");
        image::RgbImage::from_pixel(32, 32, image::Rgb([1, 2, 3]))
            .save_with_format(&photo, image::ImageFormat::Png)
            .unwrap();
        let loaded = SceneSource::resolve(photo.display().to_string(), Some(&photo)).unwrap_err();
        assert!(
            loaded.to_string().contains("in colour"),
            "the photo itself is no depth image"
        );
        assert!(matches!(
            SceneSource::resolve(photo.display().to_string(), None),
            Ok(LoadedScene::Photo(_))
        ));
        let text = write("notes.txt", b"hello");
        assert!(
            SceneSource::parse(&text, None)
                .unwrap_err()
                .to_string()
                .contains("neither glTF")
        );
        let fake = write("fake.png", b"hello");
        assert!(
            SceneSource::resolve(&fake, None)
                .unwrap_err()
                .to_string()
                .contains("no known picture format")
        );
        let empty = write("empty.glb", b"");
        assert!(
            SceneSource::resolve(&empty, None)
                .unwrap_err()
                .to_string()
                .contains("is empty")
        );
        // Of a folder the pictures are taken, and one of them is none.
        let of_folder = SceneSource::resolve(folder.path(), None).unwrap_err();
        assert!(of_folder.to_string().contains("fake.png"), "{of_folder}");
        std::fs::remove_file(&fake).unwrap();
        for name in ["1.png", "2.png"] {
            std::fs::copy(&photo, folder.path().join(name)).unwrap();
        }
        let Ok(LoadedScene::Photo(pictures)) = SceneSource::resolve(folder.path(), None) else {
            panic!("two pictures")
        };
        assert_eq!(pictures.course.as_ref().map(|c| c.pictures.len()), Some(2));
    }
}
