// needs: surroundings.wgsl, fresnel.wgsl, lamp_lobe.wgsl
//
// The skin of the lids and around them, the wet lid margin and the caruncle. Light scatters under the
// skin: red travels furthest, so terminators and shadows turn red, and thin lids glow a little. The
// sheen has two lobes (oil over a rough base); creases and pores break it.
//
// `tissue`: r wet margin, g thinness of the lid, b caruncle and corner, a occlusion (1 open). `fine` and
// `coarse`: two readings of the skin's tile, rg slope, b broad noise, a fine noise: of blood in one of them and of pigment in the other. Head
// frame, millimetres, unit vectors. Twin: src/appearance/shading/skin_shade.rs.

// The normal that faces the eye that looks, with the slope of pores and creases where skin is dry.
fn skin_normal(normal: vec3f, v: vec3f, tissue: vec4f, pores: f32, fine: vec4f, coarse: vec4f) -> vec3f {
    let roughness = (1.0 - clamp(tissue.r, 0.0, 1.0)) * (1.0 - tissue.b) * pores;
    // Both sides of the thin mesh may be seen at a corner; light the one that faces the camera.
    let n = select(normal, -normal, dot(normal, v) < -0.35);
    let gradient = vec3f(fine.rg + 0.5 * coarse.gr, 0.0);
    return normalize(n - roughness * (gradient - n * dot(gradient, n)));
}

// How skin changes from place to place: by which powers of its blood and of its melanin reflectance falls, and what a lid sends
// back against the face.
struct Mottling {
    blood: vec3f,
    melanin: vec3f,
    lid: vec3f,
};

// Colour: mottled by blood and by melanin, that of a lid where skin is thin, pink at the margin.
fn skin_albedo(skin: vec3f, mottling: Mottling, flesh: vec3f, tissue: vec4f, fine: vec4f, coarse: vec4f) -> vec3f {
    let thin = clamp(tissue.g, 0.0, 1.0);
    let share = clamp(max(tissue.r * 0.75, tissue.b), 0.0, 1.0);
    // Logarithms of how much more than the mean there is, a fifth of it either way. Photographs vary by 1.7 in a* and 1.9 in b*
    // over 2 to 20 mm, some of it by their light.
    let blood = coarse.b + 0.4 * fine.a;
    let melanin = 0.7 * fine.b + 0.4 * coarse.a;
    let mottled = skin * exp(-(mottling.blood * blood + mottling.melanin * melanin));
    let own = mottled * mix(vec3f(1.0), mottling.lid, thin);
    return mix(own, flesh * (1.0 + 0.15 * fine.a), share * 0.85);
}

// What skin takes up of a lamp with an irradiance / pi of one from the unit direction l, and what passes
// through a thin lid from behind its edge.
fn skin_lamp(n: vec3f, tissue: vec4f, l: vec3f) -> vec3f {
    let thin = clamp(tissue.g, 0.0, 1.0);
    let cosine = dot(n, l);
    // Of what is not thin hardly anything passes.
    let through = max(-cosine, 0.0) * pow(thin, 4.0) * 0.35;
    let shaded = mix(0.35, 1.0, clamp(tissue.a, 0.0, 1.0));
    return wrapped_cosines(cosine, vec3f(0.48, 0.28, 0.20)) * shaded + through * vec3f(1.0, 0.22, 0.12);
}

// What of the surroundings' irradiance reaches skin that is hidden: red goes furthest into a fold.
fn skin_openness(tissue: vec4f) -> vec3f {
    return mix(vec3f(0.30, 0.20, 0.17), vec3f(1.0), clamp(tissue.a, 0.0, 1.0));
}

// Highlight of one lamp on dry skin.
fn skin_sheen(n: vec3f, v: vec3f, l: vec3f, roughness: f32, lamp: f32) -> f32 {
    return lamp_lobe(n, v, l, lamp_alpha(roughness, 0.3 * lamp), 1.42, 0.05);
}

// Roughness of skin, smooth where its margin is wet.
fn skin_roughness(tissue: vec4f, roughness: f32) -> f32 {
    return mix(roughness, 0.14, clamp(tissue.r, 0.0, 1.0));
}

// The two lobes of one lamp's sheen.
fn skin_lamp_sheen(n: vec3f, v: vec3f, tissue: vec4f, roughness: f32, l: vec3f, radius: f32) -> f32 {
    let rough = skin_roughness(tissue, roughness);
    return 0.62 * skin_sheen(n, v, l, rough, radius) + 0.38 * skin_sheen(n, v, l, rough * 1.7, 0.2);
}

// Radiance of the sheen of skin and of the wet film on the margin: `lamps` the lamps' sheen, `ambient` the
// irradiance / pi about where a mirror looks, `mirrored` the radiance from there.
fn skin_specular(lamps: vec3f, ambient: vec3f, mirrored: vec3f, n: vec3f, v: vec3f, tissue: vec4f) -> vec3f {
    let wet = clamp(tissue.r, 0.0, 1.0);
    let cosine = max(dot(n, v), 0.0);
    let dry = lamps + ambient * (0.022 + 0.16 * pow(1.0 - cosine, 5.0));
    let film = mirrored * (fresnel_dielectric(cosine, 1.0, 1.337) * 0.8);
    return mix(dry, film, wet * 0.7) * mix(0.25, 1.0, clamp(tissue.a, 0.0, 1.0));
}
