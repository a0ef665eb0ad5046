// What clouded media do to the light, for the view. Keep in sync with src/percept/gpu_data.rs.
struct MediaUniform {
    weights: array<vec4<f32>, 4>,   // of each level of the source, in the veil
    transmittance: vec3<f32>,       // linear sRGB
    scattered: f32,                 // share of the light that is scattered
    source_size: vec2<u32>,         // texels
    texels_per_radian: f32,         // of the source
    last_level: u32,                // of the source
    near: f32,                      // share of the scattered light that stays where it is
};
