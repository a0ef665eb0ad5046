// What clouded media do to the light, for the view. Keep in sync with src/percept/gpu_data.rs.
struct MediaUniform {
    weights: array<vec4<f32>, 4>,   // of each mip level, in the veil
    transmittance: vec3<f32>,       // linear sRGB
    scattered: f32,                 // share of the light that is scattered
    rest: f32,                      // weight of what lies around the picture in the veil
    first_level: u32,
    last_level: u32,
    unused: u32,
};
