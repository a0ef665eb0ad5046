//! What a glTF file asks for that is not there or not read, before its library says so less clearly.

use super::super::model::SceneError;
use super::malformed;
use crate::input_file::one_clause;

/// Compressions that are not read, and how to export without them.
const COMPRESSIONS: [(&str, &str); 5] = [
    ("KHR_draco_mesh_compression", "Draco mesh compression"),
    ("EXT_meshopt_compression", "meshopt compression"),
    ("KHR_meshopt_compression", "meshopt compression"),
    (
        "KHR_texture_basisu",
        "KTX2 (Basis Universal) texture compression",
    ),
    ("EXT_texture_avif", "AVIF textures"),
];

/// Is this extension read, here or by the library?
fn is_read(extension: &str) -> bool {
    // Read here ([`super::accessors`]), though the library does not know it.
    extension == "KHR_mesh_quantization"
        || gltf::json::extensions::ENABLED_EXTENSIONS.contains(&extension)
}

pub(super) fn check_extensions(json: &gltf::json::Root, name: &str) -> Result<(), SceneError> {
    let required = &json.extensions_required;
    if let Some(refusal) = required.iter().find_map(refusal_of(name)) {
        return Err(refusal);
    }
    match required.iter().find(|extension| !is_read(extension)) {
        Some(extension) => Err(malformed(
            name,
            format!(
                "it cannot do without {}, which is not read: export it again without this extension",
                one_clause(extension)
            ),
        )),
        None => Ok(()),
    }
}

/// What a file uses and could do without, and is not read.
pub(super) fn unread(json: &gltf::json::Root, name: &str) -> Option<String> {
    let unread = json.extensions_used.iter().filter(|used| !is_read(used));
    let mut names: Vec<String> = unread.map(|used| one_clause(used)).collect();
    if names.len() > 4 {
        let more = names.split_off(4).len();
        names.push(format!("{more} more"));
    }
    (!names.is_empty()).then(|| {
        format!(
            "\"{name}\": it uses extensions that are not read ({}); what they describe is left out.",
            names.join(", ")
        )
    })
}

/// The refusal of a file that its library finds invalid, where it uses a compression: a texture that is
/// only there compressed has no plain picture to name.
pub(super) fn compression_used(json: &gltf::json::Root, name: &str) -> Option<SceneError> {
    json.extensions_used.iter().find_map(refusal_of(name))
}

/// The sentence for an extension that is a compression.
fn refusal_of<E: AsRef<str>>(name: &str) -> impl Fn(E) -> Option<SceneError> {
    move |extension| {
        let extension = extension.as_ref();
        let (_, what) = COMPRESSIONS.iter().find(|(known, _)| *known == extension)?;
        Some(malformed(
            name,
            format!(
                "it needs {what} ({extension}), which is not read: export it again with compression switched off"
            ),
        ))
    }
}
