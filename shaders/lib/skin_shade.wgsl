// needs: studio.wgsl, fresnel.wgsl, lamp_lobe.wgsl
//
// The skin of the lids and around them, the wet lid margin and the caruncle. Light scatters under the
// skin: red travels furthest, so terminators and shadows turn red, and thin lids glow a little. The
// sheen has two lobes (oil over a rough base); creases and pores break it.
//
// `tissue`: r wet margin, g thinness of the lid, b caruncle and corner, a occlusion (1 open). `fine` and
// `coarse`: two readings of the skin's tile, rg slope, b blotches of blood, a specks of pigment. Head
// frame, millimetres, unit vectors. Twin: src/appearance/shading/skin_shade.rs.

// The normal that faces the eye that looks, with the slope of pores and creases where skin is dry.
fn skin_normal(normal: vec3f, v: vec3f, tissue: vec4f, pores: f32, fine: vec4f, coarse: vec4f) -> vec3f {
    let roughness = (1.0 - clamp(tissue.r, 0.0, 1.0)) * (1.0 - tissue.b) * pores;
    // Both sides of the thin mesh may be seen at a corner; light the one that faces the camera.
    let n = select(normal, -normal, dot(normal, v) < -0.35);
    let gradient = vec3f(fine.rg + 0.5 * coarse.gr, 0.0);
    return normalize(n - roughness * (gradient - n * dot(gradient, n)));
}

// Colour: mottled by blood and by melanin, redder where the lid is thin, pink at the margin.
// `distance_mm` is the distance from the globe's centre, `globe_mm` its radius.
fn skin_albedo(skin: vec3f, flesh: vec3f, tissue: vec4f, fine: vec4f, coarse: vec4f, distance_mm: f32, globe_mm: f32) -> vec3f {
    let wet = clamp(tissue.r, 0.0, 1.0);
    let thin = clamp(tissue.g, 0.0, 1.0);
    let share = clamp(max(tissue.r * 0.75, tissue.b), 0.0, 1.0);
    let blotch = 0.6 * coarse.b + 0.4 * fine.b;
    let speck = 0.5 * fine.a;
    var albedo = skin * (1.0 + vec3f(0.10, 0.16, 0.18) * blotch + vec3f(0.05, 0.07, 0.07) * speck);
    albedo *= mix(vec3f(1.0), vec3f(0.97, 0.86, 0.86), thin);
    albedo = mix(albedo, flesh * (1.0 + 0.3 * speck), share * 0.85);
    // Where wet tissue comes down onto the globe it is conjunctiva over sclera: pale, so that no
    // edge shows between the two.
    let onto_globe = wet * smoothstep(globe_mm + 1.7, globe_mm + 0.15, distance_mm);
    return mix(albedo, vec3f(0.70, 0.59, 0.54), onto_globe * (1.0 - 0.75 * tissue.b));
}

// Irradiance / pi, and what passes through a thin lid from behind its edge.
fn skin_light(studio: Studio, n: vec3f, tissue: vec4f) -> vec3f {
    let thin = clamp(tissue.g, 0.0, 1.0);
    let open = clamp(tissue.a, 0.0, 1.0);
    let key = studio.key_direction;
    let fill = studio.fill_direction;
    let wrap = vec3f(0.48, 0.28, 0.20);
    var light = studio_ambient(studio, n) * mix(vec3f(0.30, 0.20, 0.17), vec3f(1.0), open);
    let shaded = mix(0.35, 1.0, open);
    for (var c = 0; c < 3; c++) {
        light[c] += studio.key_color[c] * wrapped_cosine(dot(n, key), wrap[c]) * shaded;
        light[c] += studio.fill_color[c] * wrapped_cosine(dot(n, fill), wrap[c]) * shaded;
    }
    let through = max(dot(-n, key), 0.0) * thin * 0.35;
    return light + studio.key_color * through * vec3f(1.0, 0.22, 0.12);
}

// Highlight of one lamp on dry skin.
fn skin_sheen(n: vec3f, v: vec3f, l: vec3f, roughness: f32, lamp: f32) -> f32 {
    return lamp_lobe(n, v, l, lamp_alpha(roughness, 0.3 * lamp), 1.42, 0.05);
}

// Radiance of the sheen of skin and of the wet film on the margin.
fn skin_specular(studio: Studio, n: vec3f, v: vec3f, tissue: vec4f, roughness: f32) -> vec3f {
    let wet = clamp(tissue.r, 0.0, 1.0);
    let key = studio.key_direction;
    let fill = studio.fill_direction;
    let rough = mix(roughness, 0.14, wet);
    let grazing = 1.0 - max(dot(n, v), 0.0);
    var specular = studio.key_color * (0.62 * skin_sheen(n, v, key, rough, studio.key_radius) + 0.38 * skin_sheen(n, v, key, rough * 1.7, 0.2));
    specular += studio.fill_color * skin_sheen(n, v, fill, rough * 1.2, 0.3);
    specular += studio_ambient(studio, reflect(-v, n)) * (0.022 + 0.16 * pow(grazing, 5.0));
    if wet > 0.02 {
        specular = mix(specular, studio_radiance(studio, reflect(-v, n), 0.10) * fresnel_dielectric(max(dot(n, v), 0.0), 1.0, 1.337) * 0.8, wet * 0.7);
    }
    return specular * mix(0.25, 1.0, clamp(tissue.a, 0.0, 1.0));
}
