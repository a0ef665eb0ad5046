//! What a glTF file asks for that is not there or not read, before its library says so less clearly.

use super::super::model::SceneError;
use super::malformed;

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

pub(super) fn check_extensions(json: &gltf::json::Root, name: &str) -> Result<(), SceneError> {
    match json.extensions_required.iter().find_map(refusal_of(name)) {
        Some(refusal) => Err(refusal),
        None => Ok(()),
    }
}

/// The refusal of a file that its library cannot even parse, where it uses a compression: a texture of
/// one has no plain picture to name.
pub(super) fn unparsed(bytes: &[u8], name: &str) -> Option<SceneError> {
    let binary = gltf::Glb::from_slice(bytes).ok();
    let text = binary.as_ref().map_or(bytes, |binary| &binary.json);
    let json: serde_json::Value = serde_json::from_slice(text).ok()?;
    ["extensionsRequired", "extensionsUsed"]
        .into_iter()
        .filter_map(|list| json.get(list)?.as_array())
        .flatten()
        .filter_map(serde_json::Value::as_str)
        .find_map(refusal_of(name))
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
