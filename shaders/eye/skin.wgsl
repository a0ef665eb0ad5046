// The skin of the lids and around them, the wet lid margin and the caruncle.
//
// Light scatters under the skin: red travels furthest, so terminators and
// shadows turn red, and thin lids glow a little. The sheen has two lobes
// (oil over a rough base); creases and pores break it.

struct Skin {
    studio: Studio,
    // Albedo of the skin, linear sRGB; w: roughness.
    albedo: vec4<f32>,
    // Colour of blood-rich, wet tissue (margin, caruncle); w: pore strength.
    flesh: vec4<f32>,
    // x: radius of the globe, mm.
    globe: vec4<f32>,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> skin: Skin;

// One repeating tile: rg the slope of the skin, b blotches of blood, a specks of pigment.
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var skin_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var skin_sampler: sampler;

const TILE_MM: f32 = 16.0;

fn sheen(n: vec3<f32>, v: vec3<f32>, l: vec3<f32>, roughness: f32, lamp: f32) -> f32 {
    let h = normalize(l + v);
    let nl = max(dot(n, l), 0.0);
    let nv = max(dot(n, v), 0.05);
    let alpha = clamp(roughness * roughness + 0.3 * lamp, 0.01, 1.0);
    let f = fresnel_dielectric(max(dot(v, h), 0.0), 1.0, 1.42);
    return 3.14159265 * ggx_ndf(max(dot(n, h), 0.0), alpha) * ggx_visibility_smith(nl, nv, alpha) * f * nl;
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let p = in.position;
    // Pores and blotches stick to the skin: they are looked up where it rests.
    let q = in.rest;
    let v = normalize(in.camera - p);
    let footprint = pixel_footprint(distance(in.camera, p));
    // tissue: r wet margin, g thinness of the lid, b caruncle and corner, a occlusion (1 open).
    let wet = clamp(in.tissue.r, 0.0, 1.0);
    let thin = clamp(in.tissue.g, 0.0, 1.0);
    let flesh = clamp(max(in.tissue.r * 0.75, in.tissue.b), 0.0, 1.0);
    let open = clamp(in.tissue.a, 0.0, 1.0);

    let rough_place = (1.0 - wet) * (1.0 - in.tissue.b) * skin.flesh.w;
    var n = normalize(in.normal);
    // Both sides of the thin mesh may be seen at a corner; light the one that faces the camera.
    n = select(n, -n, dot(n, v) < -0.35);
    let texel_mm = TILE_MM / f32(textureDimensions(skin_map).x);
    let fine = textureSampleLevel(skin_map, skin_sampler, q.xy / TILE_MM, log2(footprint / texel_mm));
    // A second, larger look at the same tile hides that it repeats.
    let coarse = textureSampleLevel(skin_map, skin_sampler, q.yx / (TILE_MM * 2.7) + 0.37, log2(footprint / (2.7 * texel_mm)));
    let gradient = vec3(fine.rg + 0.5 * coarse.gr, 0.0);
    n = normalize(n - rough_place * (gradient - n * dot(gradient, n)));

    // Colour: mottled by blood and by melanin, redder where the lid is thin, pink at the margin.
    let blotch = 0.6 * coarse.b + 0.4 * fine.b;
    let speck = 0.5 * fine.a;
    var albedo = skin.albedo.rgb * (1.0 + vec3(0.10, 0.16, 0.18) * blotch + vec3(0.05, 0.07, 0.07) * speck);
    albedo *= mix(vec3(1.0), vec3(0.97, 0.86, 0.86), thin);
    albedo = mix(albedo, skin.flesh.rgb * (1.0 + 0.3 * speck), flesh * 0.85);
    // Where wet tissue comes down onto the globe it is conjunctiva over sclera: pale, so that no
    // edge shows between the two.
    let onto_globe = wet * smoothstep(skin.globe.x + 1.7, skin.globe.x + 0.15, length(p));
    albedo = mix(albedo, vec3(0.70, 0.59, 0.54), onto_globe * (1.0 - 0.75 * in.tissue.b));

    let key = skin.studio.key_direction.xyz;
    let fill = skin.studio.fill_direction.xyz;
    let wrap = vec3(0.48, 0.28, 0.20);
    var light = studio_ambient(skin.studio, n) * mix(vec3(0.30, 0.20, 0.17), vec3(1.0), open);
    let shaded = mix(0.35, 1.0, open);
    for (var c = 0; c < 3; c++) {
        light[c] += skin.studio.key_color[c] * wrapped_cosine(dot(n, key), wrap[c]) * shaded;
        light[c] += skin.studio.fill_color[c] * wrapped_cosine(dot(n, fill), wrap[c]) * shaded;
    }
    // Light that passes through a thin lid from behind its edge.
    let through = max(dot(-n, key), 0.0) * thin * 0.35;
    light += skin.studio.key_color.rgb * through * vec3(1.0, 0.22, 0.12);
    var radiance = albedo * light;

    let rough = mix(skin.albedo.w, 0.14, wet);
    let grazing = 1.0 - max(dot(n, v), 0.0);
    var specular = skin.studio.key_color.rgb * (0.62 * sheen(n, v, key, rough, skin.studio.key_direction.w) + 0.38 * sheen(n, v, key, rough * 1.7, 0.2));
    specular += skin.studio.fill_color.rgb * sheen(n, v, fill, rough * 1.2, 0.3);
    specular += studio_ambient(skin.studio, reflect(-v, n)) * (0.022 + 0.16 * pow(grazing, 5.0));
    if wet > 0.02 {
        specular = mix(specular, studio_radiance(skin.studio, reflect(-v, n), 0.10) * fresnel_dielectric(max(dot(n, v), 0.0), 1.0, 1.337) * 0.8, wet * 0.7);
    }
    radiance += specular * mix(0.25, 1.0, open);
    return vec4(output_transform(radiance, skin.studio.key_color.w), 1.0);
}
