// What the eye's materials share. Entry files follow it; all that is computed stands
// in shaders/lib, the entry files bind, call and write.
//
// Spaces: local = millimetres with the globe's centre of rotation at the
// origin, y up, gaze along -z. The globe's mesh turns with gaze (its local
// space is the eye frame); skin and lashes do not (theirs is the head frame).

#import bevy_pbr::mesh_functions::{get_world_from_local, get_local_from_world, mesh_position_local_to_clip, get_tag}
#import bevy_pbr::mesh_view_bindings::view

struct VertexIn {
    @builtin(instance_index) instance: u32,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rest: vec4<f32>,
    @location(3) tissue: vec4<f32>,
};

struct Surface {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) rest: vec3<f32>,
    @location(3) tissue: vec4<f32>,
    @location(4) @interpolate(flat) camera: vec3<f32>,
    @location(5) @interpolate(flat) tag: u32,
};

// Where the camera stands in the local space.
fn camera_from(instance: u32) -> vec3<f32> {
    return (get_local_from_world(instance) * vec4(view.world_position, 1.0)).xyz;
}

// What the fragment stage gets of a vertex that stands at this place.
fn surface_at(in: VertexIn, position: vec3<f32>, camera: vec3<f32>) -> Surface {
    var out: Surface;
    out.clip = mesh_position_local_to_clip(get_world_from_local(in.instance), vec4(position, 1.0));
    out.position = position;
    out.normal = in.normal;
    out.rest = in.rest.xyz;
    out.tissue = in.tissue;
    out.camera = camera;
    out.tag = get_tag(in.instance);
    return out;
}

// Size (mm) of this view's pixel at a distance (mm).
fn footprint_at(distance_mm: f32) -> f32 {
    return pixel_footprint(distance_mm, view.clip_from_view[1][1], view.viewport.w);
}

// The light, the same for every part of an eye.
@group(#{MATERIAL_BIND_GROUP}) @binding(10) var<uniform> illumination: Illumination;
// Radiance by direction, see `surroundings_uv`.
@group(#{MATERIAL_BIND_GROUP}) @binding(11) var around_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(12) var around_sampler: sampler;

// How many lamps are looked at: a number of the pipeline, so that software rasterisers unroll what is done
// for each. Those that are not there give no light.
const LAMPS: i32 = i32(#{LAMPS});

// A lamp as it is from the place p (mm) of the head frame.
fn lamp_at(i: i32, p: vec3<f32>) -> Lamp {
#ifdef NEAR_LAMPS
    return lamp_from(illumination.lamps[i], p);
#else
    return illumination.lamps[i];
#endif
}

// Radiance from the unit direction d of the head frame, as it is seen from the place p (mm).
fn mirrored(p: vec3<f32>, d: vec3<f32>, blur: f32) -> vec3<f32> {
    var radiance = surroundings_radiance(around_map, around_sampler, d, blur);
#ifdef BARE_LAMPS
    // Some stand in no map.
    for (var i = 0; i < LAMPS; i++) {
        radiance += lamp_radiance(lamp_at(i, p), d, blur);
    }
#endif
    return radiance;
}

// Irradiance / pi from the surroundings on a surface of normal n of the head frame.
fn ambient(n: vec3<f32>) -> vec3<f32> {
    return ambient_light(illumination.ambient, n);
}

// Radiance as this camera wants it: under its exposure, and through the output transform where it has
// none of its own.
fn shown(radiance: vec3<f32>) -> vec3<f32> {
    let exposure = illumination.exposure * mix(1.0, view.exposure, illumination.is_luminance);
#ifdef RADIANCE
    return radiance * exposure;
#else
    return output_transform(radiance, exposure);
#endif
}
