//! The page around the app: its file chooser, clipboard, downloads and link.

use super::super::own_files::OwnFile;
use super::{Arrival, arrive};
use js_sys::{Array, Uint8Array};
use wasm_bindgen::prelude::wasm_bindgen;

#[wasm_bindgen(js_namespace = oculariumHost)]
extern "C" {
    #[wasm_bindgen(js_name = chooseFiles)]
    fn choose();
    #[wasm_bindgen(js_name = copyText)]
    fn copy(text: &str);
    #[wasm_bindgen(js_name = saveFile)]
    fn save(name: &str, bytes: &[u8]);
    /// The link's fragment without `#`.
    pub fn fragment() -> String;
    /// Writes the link's fragment without a step in the browser's history.
    #[wasm_bindgen(js_name = replaceFragment)]
    pub fn replace_fragment(fragment: &str);
    /// The page's address with this fragment.
    pub fn address(fragment: &str) -> String;
    /// Says that the graphics device is lost, and loads the page again.
    #[wasm_bindgen(js_name = deviceLost)]
    pub fn device_lost(reason: &str);
    /// Does the machine have no keyboard but one on its screen?
    #[wasm_bindgen(js_name = isTelephone)]
    pub fn is_telephone() -> bool;
    /// Is the screen meant for fingers?
    #[wasm_bindgen(js_name = isTouch)]
    pub fn is_touch() -> bool;
}

/// The browser has its own.
#[derive(Default)]
pub struct Clipboard;

/// Copies text; the page says so when it cannot.
pub fn copy_text(_: &mut Clipboard, text: &str) -> Result<(), String> {
    copy(text);
    Ok(())
}

/// Lets the user choose files; they arrive.
pub fn choose_files() {
    choose();
}

/// Downloads a file.
pub fn save_file(name: &str, bytes: Vec<u8>) {
    save(name, &bytes);
    arrive(Arrival::Said(format!(
        "Saved as {name} among your downloads."
    )));
}

/// Called by the page with files that were chosen or dropped together: names and contents.
#[wasm_bindgen(js_name = openFiles)]
pub fn open_files(names: &Array, contents: &Array) {
    let files = names
        .iter()
        .zip(contents.iter())
        .map(|(name, content)| OwnFile {
            name: name.as_string().unwrap_or_default(),
            bytes: Uint8Array::new(&content).to_vec(),
            folder: None,
            is_depth: false,
        });
    arrive(Arrival::Files(files.collect()));
}

/// Called by the page with a sentence for the user.
#[wasm_bindgen(js_name = say)]
pub fn say(sentence: String) {
    arrive(Arrival::Said(sentence));
}
