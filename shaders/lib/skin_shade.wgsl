// needs: surroundings.wgsl, fresnel.wgsl, lamp_lobe.wgsl
//
// The skin of the lids and around them, the wet lid margin and the caruncle. Light scatters under the
// skin: red travels furthest, so terminators and shadows turn red, and thin lids glow a little. The
// sheen has three lobes (oil and smooth points over a rough base); creases and pores break it.
//
// `tissue`: r how wet the margin is, g thinness of the lid, b caruncle and corner, a occlusion (1 open). `fine` and
// `coarse`: two readings of the skin's tile, rg slope, b broad noise, a fine noise: of blood in one of them and of pigment in the other. Head
// frame, millimetres, unit vectors. Twin: src/appearance/shading/skin_shade.rs.

// The normal that faces the eye that looks, with the slope of pores and creases where skin is dry.
fn skin_normal(normal: vec3f, v: vec3f, tissue: vec4f, pores: f32, fine: vec4f, coarse: vec4f) -> vec3f {
    let roughness = (1.0 - clamp(tissue.r, 0.0, 1.0)) * (1.0 - tissue.b) * pores;
    // Both sides of the thin mesh may be seen at a corner; light the one that faces the camera.
    let n = select(normal, -normal, dot(normal, v) < -0.35);
    let gradient = vec3f(fine.rg + 0.25 * coarse.gr, 0.0);
    return normalize(n - roughness * (gradient - n * dot(gradient, n)));
}

// Slope of the wrinkles of age at a place q (mm, head frame, at rest) of the skin of a right eye, `depth` mm deep: crow's feet, which
// fan out from the outer canthus, and creases that run along below the lower lid.
fn skin_wrinkles(q: vec2f, depth: f32) -> vec2f {
    let off = q - CROWS_FEET_MM;
    // At the very place from which they come no direction is any line's.
    let away = select(off, vec2f(1e-3, 0.0), dot(off, off) < 1e-6);
    let r = max(length(away), 1.0);
    let angle = atan2(away.y, away.x);
    let fan = angle * CROWS_FEET_A_RAD + 0.35 * sin(0.5 * r);
    let there = smoothstep(2.0, 7.0, r) * (1.0 - smoothstep(13.0, 27.0, r)) * (1.0 - smoothstep(0.7, 1.35, abs(angle)));
    let feet = vec2f(-away.y, away.x) / r * (CROWS_FEET_A_RAD / r) * groove(fan) * there;
    let below = q.y + 8.6 - 0.022 * q.x * q.x;
    let under = (1.0 - smoothstep(-1.5, 0.5, below)) * smoothstep(-9.0, -5.0, below) * (1.0 - smoothstep(9.0, 15.0, abs(q.x)));
    let creases = vec2f(-0.044 * q.x, 1.0) / LID_CREASE_MM * groove(below / LID_CREASE_MM + 0.2 * sin(0.6 * q.x)) * under;
    return depth * (feet + 0.6 * creases);
}

// Where crow's feet come from, how many there are to a radian, and how far apart the lid's creases are.
const CROWS_FEET_MM = vec2f(11.5, -0.5);
const CROWS_FEET_A_RAD: f32 = 5.0;
const LID_CREASE_MM: f32 = 2.1;

// Slope of grooves of depth one, one to a unit of x.
fn groove(x: f32) -> f32 {
    let s = (x - floor(x) - 0.5) / 0.13;
    return 2.0 / 0.13 * s * exp(-s * s);
}

// The normal n with this slope of the surface along x and y added.
fn skin_tilted(n: vec3f, slope: vec2f) -> vec3f {
    let gradient = vec3f(slope, 0.0);
    return normalize(n - (gradient - n * dot(gradient, n)));
}

// How skin changes from place to place: by which powers of its blood and of its melanin reflectance falls, and what a lid sends
// back against the face.
struct Mottling {
    blood: vec3f,
    melanin: vec3f,
    lid: vec3f,
};

// How wet the margin is where it is this near its posterior edge (1 there, 0 at the anterior one): tears reach to the line of Marx,
// before which skin begins.
fn margin_wet(behind: f32) -> f32 {
    return smoothstep(0.5, 0.9, behind);
}

// Share of a pixel of this footprint (mm) that the openings of Meibom's glands cover on the margin, this near its posterior edge
// and `along` it (mm towards the temple, at rest): x their pale rims, y the holes in them. There are none beyond the punctum.
fn margin_glands(behind: f32, along: f32, footprint: f32) -> vec2f {
    let place = along / GLAND_SPACING_MM;
    let cell = floor(place);
    let odd = fract(cell * 0.7548777);
    let row = 0.5 + 0.09 * (odd - 0.5);
    let off = vec2f((place - cell - 0.5 - 0.4 * (odd - 0.5)) * GLAND_SPACING_MM, (behind - row) * MARGIN_MM);
    let from_middle = length(off);
    let soft = max(0.05, 0.7 * footprint);
    let rim = smoothstep(GLAND_RIM_MM + soft, GLAND_RIM_MM - soft, from_middle);
    let hole = smoothstep(GLAND_HOLE_MM + soft, GLAND_HOLE_MM - soft, from_middle);
    // Openings are oil or not, and where a pixel is wider than one of them they are a paler line.
    let lids = smoothstep(-9.5, -8.0, along) * (1.0 - smoothstep(10.0, 11.5, along));
    let seen = lids * (0.5 + 0.5 * odd) * min(GLAND_RIM_MM / max(footprint, 1e-3), 1.0);
    return vec2f(rim, hole) * seen;
}

// Twenty to thirty of them open on a lower lid, in a row before the line of Marx.
const GLAND_SPACING_MM: f32 = 1.05;
const GLAND_RIM_MM: f32 = 0.17;
const GLAND_HOLE_MM: f32 = 0.06;
// Thickness of a lid's edge.
const MARGIN_MM: f32 = 1.75;

// Darkness of the grey line, where the muscle reaches the surface before the glands.
fn margin_grey_line(behind: f32, footprint: f32) -> f32 {
    let off = (behind - 0.3) * MARGIN_MM;
    let half_width = max(0.09, footprint);
    return exp(-(off * off) / (half_width * half_width)) * min(0.09 / half_width, 1.0);
}

// Colour of the margin from that of its skin: before its wet edge it differs from the lid's as that does from the face's, and has glands
// and the grey line.
fn margin_albedo(own: vec3f, lid: vec3f, behind: f32, along: f32, footprint: f32) -> vec3f {
    let glands = margin_glands(behind, along, footprint);
    let flushed = own * mix(vec3f(1.0), lid, smoothstep(0.0, 0.4, behind) * (1.0 - margin_wet(behind)));
    let pale = mix(flushed, sqrt(max(flushed, vec3f(0.0))) * vec3f(0.78, 0.74, 0.66), 0.14 * glands.x);
    return pale * (1.0 - 0.12 * glands.y) * (vec3f(1.0) - vec3f(0.10, 0.08, 0.05) * margin_grey_line(behind, footprint));
}

// Colour: mottled by blood and by melanin, that of a lid where skin is thin, pink at the margin.
fn skin_albedo(skin: vec3f, mottling: Mottling, flesh: vec3f, tissue: vec4f, fine: vec4f, coarse: vec4f) -> vec3f {
    let thin = clamp(tissue.g, 0.0, 1.0);
    let share = clamp(max(tissue.r * 0.75, tissue.b), 0.0, 1.0);
    // Logarithms of how much more than the mean there is, a quarter of it either way of blood and a third of melanin: as much as photographs
    // vary over 2 to 20 mm in light skin (1.7 in a*, 1.9 in b*; `measure looks`).
    let blood = 1.4 * coarse.b + 0.6 * fine.a;
    let melanin = 1.45 * fine.b + 0.8 * coarse.a + 0.9 * fine.a;
    let mottled = skin * exp(-(mottling.blood * blood + mottling.melanin * melanin));
    let own = mottled * mix(vec3f(1.0), mottling.lid, thin);
    return mix(own, flesh * (1.0 + 0.15 * fine.a), share * 0.85);
}

// What skin takes up of a lamp with an irradiance / pi of one from the unit direction l, and what passes
// through a thin lid from behind its edge.
fn skin_lamp(n: vec3f, tissue: vec4f, l: vec3f) -> vec3f {
    let thin = clamp(tissue.g, 0.0, 1.0);
    let cosine = dot(n, l);
    // Of what is not thin hardly anything passes, and nothing where the lids end in the corner.
    let through = max(-cosine, 0.0) * pow(thin, 4.0) * (0.35 * (1.0 - clamp(tissue.b, 0.0, 1.0)));
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

// The three lobes of one lamp's sheen: of dry skin, of the oil on it, and of the points that are smooth, which sparkle one by one.
fn skin_lamp_sheen(n: vec3f, v: vec3f, tissue: vec4f, roughness: f32, l: vec3f, radius: f32) -> f32 {
    let rough = skin_roughness(tissue, roughness);
    let broad = 0.5 * skin_sheen(n, v, l, rough, radius) + 0.37 * skin_sheen(n, v, l, rough * 1.7, 0.2);
    return broad + 0.13 * skin_sheen(n, v, l, rough * 0.5, radius);
}

// Radiance of the sheen of skin and of the wet film on the margin: `lamps` the lamps' sheen, `ambient` the
// irradiance / pi about where a mirror looks, `mirrored` the radiance from there.
fn skin_specular(lamps: vec3f, ambient: vec3f, mirrored: vec3f, n: vec3f, v: vec3f, tissue: vec4f) -> vec3f {
    let wet = clamp(tissue.r, 0.0, 1.0);
    // Rounding may make it more than one, of whose rest no power is a number.
    let cosine = clamp(dot(n, v), 0.0, 1.0);
    let dry = lamps + ambient * (0.022 + 0.16 * pow(1.0 - cosine, 5.0));
    let film = mirrored * (fresnel_dielectric(cosine, 1.0, 1.337) * 0.8);
    return mix(dry, film, wet * 0.7) * mix(0.25, 1.0, clamp(tissue.a, 0.0, 1.0));
}
