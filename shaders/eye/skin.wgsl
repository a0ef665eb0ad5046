// The skin of the lids and around them, the wet lid margin and the caruncle.

struct Skin {
    // Linear sRGB.
    albedo: vec3<f32>,
    // Of its sheen.
    roughness: f32,
    // Colour of blood-rich, wet tissue (margin, caruncle).
    flesh: vec3<f32>,
    // How deep the pores are.
    pores: f32,
    // How it changes from place to place.
    blood: vec3<f32>,
    melanin: vec3<f32>,
    lid: vec3<f32>,
    // How deep the wrinkles of age are, mm, and -1 for a left eye, whose resting places are a right one's.
    wrinkles_mm: f32,
    mirror: f32,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> skin: Skin;

// One repeating tile: rg the slope of the skin, b broad and a fine noise.
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var skin_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var skin_sampler: sampler;

const TILE_MM: f32 = 16.0;
// Share of the slopes of pores and lines that light shows which has been under the skin: it travels about as far as they are wide.
const SKIN_SOFT: f32 = 0.6;

// The tile at a place: its texels hold numbers of -1 to 1 as 0 to 1.
fn skin_tile(uv: vec2<f32>, level: f32) -> vec4<f32> {
    return 2.0 * textureSampleLevel(skin_map, skin_sampler, uv, level) - 1.0;
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let p = in.position;
#ifdef WET
    let behind = in.tissue.r;
    let tissue = vec4(margin_wet(behind), in.tissue.gba);
#else
    let tissue = vec4(0.0, in.tissue.gba);
#endif
    // Pores and blotches stick to the skin: they are looked up where it rests.
    let q = in.rest;
    let v = normalize(in.camera - p);
    let footprint = footprint_at(distance(in.camera, p));
    let texel_mm = TILE_MM / f32(textureDimensions(skin_map).x);
    let fine = skin_tile(q.xy / TILE_MM, footprint_level(footprint, texel_mm));
    // A second, larger look at the same tile hides that it repeats.
    let coarse = skin_tile(q.yx / (TILE_MM * 2.7) + 0.37, footprint_level(footprint, 2.7 * texel_mm));
    var n = skin_normal(normalize(in.normal), v, tissue, skin.pores, fine, coarse);
    // Light that has been under the skin comes out of more than one of its little slopes.
    var soft = skin_normal(normalize(in.normal), v, tissue, SKIN_SOFT * skin.pores, fine, coarse);
#ifdef WRINKLED
    let wrinkles = vec2(skin.mirror, 1.0) * skin_wrinkles(q.xy, skin.wrinkles_mm);
    n = skin_tilted(n, wrinkles);
    soft = skin_tilted(soft, wrinkles);
#endif
    let mottling = Mottling(skin.blood, skin.melanin, skin.lid);
    var albedo = skin_albedo(skin.albedo, mottling, skin.flesh, tissue, fine, coarse);
#ifdef WET
    albedo = margin_albedo(albedo, skin.lid, behind, q.x, footprint);
#endif
    var light = ambient(soft) * skin_openness(tissue);
    var sheen = vec3(0.0);
    for (var i = 0; i < LAMPS; i++) {
        let lamp = lamp_at(i, p);
        light += lamp.color * skin_lamp(soft, tissue, lamp.direction);
        sheen += lamp.color * skin_lamp_sheen(n, v, tissue, skin.roughness, lamp.direction, lamp.radius);
    }
    let r = reflect(-v, n);
#ifdef WET
    // Towards the globe it mirrors what is as bright as itself.
    let free = past_head(r);
    let around = mix(albedo * light, mirrored(p, r, 0.10), free);
    let sky = mix(albedo * light, ambient(r), free);
#else
    let around = vec3(0.0);
    let sky = ambient(r);
#endif
    let radiance = albedo * light + skin_specular(sheen, sky, around, n, v, tissue);
    return vec4(shown(radiance), 1.0);
}
