// A clouded lens behind the pupil. Twin: src/appearance/shading/lens_shade.rs.

// Radius of the lens's disc, of its nucleus, mm; what clouded cortex sends back.
const LENS_RADIUS_MM: f32 = 3.75;
const NUCLEUS_RADIUS_MM: f32 = 2.75;
// Behind the plane of the iris, mm: clouded cortex, the middle of the nucleus, the posterior capsule.
const CORTEX_DEPTH_MM: f32 = 0.6;
const NUCLEUS_DEPTH_MM: f32 = 1.8;
const CAPSULE_DEPTH_MM: f32 = 3.8;
// Share of light that a cloud takes out of its way.
const LENS_OPAQUE: f32 = 0.9;
const CORTEX_COLOR = vec3<f32>(0.13, 0.135, 0.14);

// Share of a place that wedges of clouded cortex cover, which cover this share of the lens. They begin at
// its rim and point to its middle, and `turn` (rad) makes them those of this eye.
fn cortical_wedges(place_mm: vec2<f32>, share: f32, turn: f32) -> f32 {
    let angle = atan2(place_mm.y, place_mm.x + 1e-9);
    let depth = 0.5 + 0.2 * sin(7.0 * angle + turn) + 0.15 * sin(11.0 * angle + 2.3 * turn) + 0.15 * sin(17.0 * angle + 4.1 * turn);
    let covered = clamp(2.0 * share * depth, 0.0, 1.0);
    let begins = LENS_RADIUS_MM * sqrt(1.0 - covered);
    return smoothstep(-0.25, 0.25, length(place_mm) - begins);
}

// Share of a place that a cloud of this radius in the middle of the capsule covers: grains with gaps.
fn capsule_cloud(place_mm: vec2<f32>, radius_mm: f32) -> f32 {
    let grain = sin(7.1 * place_mm.x + 2.3 * sin(4.7 * place_mm.y)) * sin(6.3 * place_mm.y + 1.9 * sin(5.9 * place_mm.x));
    let edge = radius_mm * (0.9 + 0.1 * grain) - length(place_mm);
    return smoothstep(-0.2, 0.2, edge) * (0.75 + 0.25 * grain);
}

// Share of light that crosses a clouded lens on its way out, as it is seen against a bright fundus: what is opaque scatters
// nearly all of it aside. The arguments are those of `lens_cloud`.
fn lens_clear(capsule_radius_mm: f32, cortical_share: f32, place_mm: vec2<f32>, slope: vec2<f32>, turn: f32) -> f32 {
    var clear = 1.0;
    let behind = place_mm + slope * CAPSULE_DEPTH_MM;
    if capsule_radius_mm * (LENS_RADIUS_MM - length(behind)) > 0.0 {
        clear *= 1.0 - LENS_OPAQUE * clamp(capsule_cloud(behind, capsule_radius_mm), 0.0, 1.0);
    }
    let before = place_mm + slope * CORTEX_DEPTH_MM;
    if cortical_share * length(before) > 0.0 {
        clear *= 1.0 - LENS_OPAQUE * cortical_wedges(before, cortical_share, turn);
    }
    return clear;
}

// What a clouded lens sends back of the irradiance / pi on it, linear sRGB: `nucleus` that of the nucleus,
// `capsule` that of a cloud of this radius behind it, whose light has passed the nucleus; clouded cortex
// covers a share of the disc before both. `place_mm` is where the view crosses the plane of the iris,
// `slope` how far aside it goes with each mm inwards; `turn` is of this eye.
fn lens_cloud(nucleus: vec3<f32>, capsule: vec3<f32>, capsule_radius_mm: f32, cortical_share: f32, place_mm: vec2<f32>, slope: vec2<f32>, turn: f32) -> vec3<f32> {
    let middle = 1.0 - smoothstep(0.7, 1.25, length(place_mm + slope * NUCLEUS_DEPTH_MM) / NUCLEUS_RADIUS_MM);
    var color = nucleus * (0.25 + 0.75 * middle);
    // Not by the uniforms alone, as `lamp_radiance` says.
    let behind = place_mm + slope * CAPSULE_DEPTH_MM;
    if capsule_radius_mm * (LENS_RADIUS_MM - length(behind)) > 0.0 {
        color += capsule * capsule_cloud(behind, capsule_radius_mm);
    }
    let before = place_mm + slope * CORTEX_DEPTH_MM;
    if cortical_share * length(before) > 0.0 {
        color = mix(color, CORTEX_COLOR, cortical_wedges(before, cortical_share, turn));
    }
    return color;
}
