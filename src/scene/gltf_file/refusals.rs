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
    for required in &json.extensions_required {
        if let Some((_, what)) = COMPRESSIONS.iter().find(|(name, _)| name == required) {
            return Err(malformed(
                name,
                format!(
                    "it needs {what} ({required}), which is not read: export it again with compression switched off"
                ),
            ));
        }
    }
    Ok(())
}
