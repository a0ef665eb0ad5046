//! File dialogs and clipboard of a desktop.

use super::super::own_files::OwnFile;
use super::{Arrival, arrive};
use crate::input_file::read_input_file;
use crate::output_file::write_whole;
use crate::scene::photo::MAX_FILE_BYTES;
use crate::scene::pictures::pictures_in;
use bevy::tasks::IoTaskPool;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Nobody dismisses a dialog so quickly: it did not open.
const UNSEEN: Duration = Duration::from_millis(150);

/// The system's clipboard; whoever copies to it has to stay there while others paste.
#[derive(Default)]
pub struct Clipboard(Option<arboard::Clipboard>);

/// Copies text.
///
/// # Errors
/// One sentence where there is no clipboard.
pub fn copy_text(clipboard: &mut Clipboard, text: &str) -> Result<(), String> {
    let sentence = |error: arboard::Error| format!("There is no clipboard here: {error}.");
    if clipboard.0.is_none() {
        clipboard.0 = Some(arboard::Clipboard::new().map_err(sentence)?);
    }
    match &mut clipboard.0 {
        Some(open) => open.set_text(text).map_err(sentence),
        None => Ok(()),
    }
}

/// Is the screen meant for fingers? A desktop says so only when it is touched.
pub fn is_touch() -> bool {
    false
}

/// Lets the user choose files; they arrive. To be called from the main thread.
pub fn choose_files() {
    let opened = Instant::now();
    let dialog = rfd::AsyncFileDialog::new()
        .set_title("A photograph, a model or a patient file")
        .add_filter(
            "photographs, models, patients",
            &[
                "png", "jpg", "jpeg", "webp", "gif", "tif", "tiff", "bmp", "gltf", "glb", "bin",
                "ron",
            ],
        )
        .add_filter("all files", &["*"])
        .pick_files();
    let wait = async move {
        match dialog.await {
            Some(chosen) => {
                let paths: Vec<PathBuf> = chosen.iter().map(|file| file.path().into()).collect();
                read_paths(&paths);
            }
            None if opened.elapsed() < UNSEEN => arrive(Arrival::Said(
                "No file dialog could be opened here: drop the file on the window instead, or name it with --scene or --patient."
                    .into(),
            )),
            None => {}
        }
    };
    IoTaskPool::get().spawn(wait).detach();
}

/// Reads files and lets them arrive together; one that cannot be read is said.
pub fn read_paths(paths: &[PathBuf]) {
    let read = |path: &PathBuf| {
        let name = path.file_name().map_or_else(
            || path.display().to_string(),
            |name| name.to_string_lossy().into(),
        );
        match read_input_file(path, MAX_FILE_BYTES) {
            Ok(bytes) => Ok(OwnFile {
                name,
                bytes,
                folder: Some(path.parent().unwrap_or(Path::new(".")).into()),
                is_depth: false,
            }),
            Err(error) => Err(format!("\"{name}\" cannot be read: {error}.")),
        }
    };
    // Of a folder its pictures.
    let mut files = Vec::new();
    for path in paths {
        match path.is_dir().then(|| pictures_in(path)) {
            Some(Ok(pictures)) => files.extend(pictures),
            Some(Err(error)) => return arrive(Arrival::Said(error.to_string())),
            None => files.push(path.clone()),
        }
    }
    match files.iter().map(read).collect::<Result<Vec<_>, _>>() {
        Ok(files) => arrive(Arrival::Files(files)),
        Err(sentence) => arrive(Arrival::Said(sentence)),
    }
}

/// Keeps a file where the user wants it, or beside the program's folder where nobody can ask; says
/// where. To be called from the main thread.
pub fn save_file(name: &str, bytes: Vec<u8>) {
    let opened = Instant::now();
    let dialog = rfd::AsyncFileDialog::new()
        .set_title("Save what is seen")
        .set_file_name(name)
        .add_filter("PNG image", &["png"])
        .save_file();
    let name = name.to_owned();
    let wait = async move {
        let chosen = match dialog.await {
            Some(chosen) => chosen.path().to_owned(),
            None if opened.elapsed() < UNSEEN => free_path(&name),
            None => return,
        };
        arrive(Arrival::Said(match write_whole(&chosen, &bytes) {
            Ok(()) => format!("Saved as {}.", chosen.display()),
            Err(error) => format!("{error}."),
        }));
    };
    IoTaskPool::get().spawn(wait).detach();
}

/// A path of this name in the current folder that does not exist yet: name.png, name-2.png, …
fn free_path(name: &str) -> PathBuf {
    let folder = std::env::current_dir().unwrap_or_default();
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "png"));
    let numbered = (2..).map(|number| format!("{stem}-{number}.{extension}"));
    std::iter::once(name.to_owned())
        .chain(numbered)
        .map(|name| folder.join(name))
        .find(|path| !path.exists())
        .unwrap_or_else(|| folder.join(name))
}
