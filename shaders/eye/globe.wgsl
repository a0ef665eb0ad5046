// The globe: sclera, limbus, and behind an exactly refracting cornea the iris
// and the pupil, in one opaque material (François et al. 2007, section 5).
//
// Every view ray is intersected with the conicoid of the cornea in closed
// form, refracted at both surfaces onto the iris, and marched through the
// relief; the light takes the two-point path (section 3), and its
// concentration by the cornea is the Jacobian of that path.

// An artist's changes: see src/anatomy/look.rs.
struct Look {
    iris_brightness: f32,
    iris_size: f32,
    refraction: f32,
    caustic_scale: f32,
    caustic_power: f32,
    cornea_roughness: f32,
    cornea_specularity: f32,
    limbus_dark: f32,
    limbus_power: f32,
    limbus_color_mm: f32,
    limbus_shading_mm: f32,
    white_brightness: f32,
    white_roughness: f32,
    white_specularity: f32,
    white_relief: f32,
    white_relief_size: f32,
    parallax: f32,
    matcap: f32,
};

struct Globe {
    lids: Lids,
    // Rotation from the eye frame to the head frame, columns.
    head_from_eye: mat4x4<f32>,
    // Apical radius and shape factor of front and back of the cornea.
    anterior_radius_mm: f32,
    anterior_p: f32,
    posterior_radius_mm: f32,
    posterior_p: f32,
    thickness_mm: f32,
    cornea_index: f32,
    aqueous_index: f32,
    // From the globe's centre to the corneal apex.
    apex_mm: f32,
    // Behind the apex: the pupil's edge.
    iris_depth_mm: f32,
    // Slope of the cone in which the iris falls back to its root, and how far its middle stands before that, four times, over its width.
    iris_shape: vec2<f32>,
    // Behind the apex: the plane of the iris' light.
    iris_light_mm: f32,
    iris_root_mm: f32,
    limbus_mm: f32,
    pupil_center_mm: vec2<f32>,
    sclera_radius_mm: f32,
    lipid_nm: f32,
    // How long after a blink the tear film begins to break, s.
    tear_breakup_s: f32,
    // What a lens of this age sends back.
    lens: vec3<f32>,
    // What the cornea sends back.
    cornea_haze: vec3<f32>,
    cortical_share: f32,
    // What a clouded nucleus sends back beyond it.
    nucleus: vec3<f32>,
    capsule_radius_mm: f32,
    // What a cloud at the capsule sends back.
    capsule: vec3<f32>,
    relief: f32,
    // What makes the clouds of its lens and the waves of its tears those of this eye, rad.
    lens_turn: f32,
    // Colour of what is thick and bloody of the conjunctiva.
    flesh: vec3<f32>,
    // Share of the white's light that deep vessels cannot dim.
    above_vessels: vec3<f32>,
    // Irradiance of the iris under an even sky at a place (`iris_sky_knot`), and at the next.
    iris_sky: array<vec4<f32>, 32>,
    // Apical radius and shape factor of the lens's front, and of its back, which bulges into the eye.
    lens_front_radius_mm: f32,
    lens_front_p: f32,
    lens_back_radius_mm: f32,
    lens_back_p: f32,
    lens_thickness_mm: f32,
    // That bends as the whole lens does.
    lens_index: f32,
    // How far its front stands behind the plane of the iris; negative before it.
    lens_forward_mm: f32,
    // What it leaves of light that crosses it twice.
    lens_passes: vec3<f32>,
    // Size of the entrance pupil against the hole in the iris.
    pupil_magnification: f32,
    // Vergence for which the eye is in focus now (1/mm), a power vector.
    focus: vec3<f32>,
    // Albedo of the lids' skin.
    lids_color: vec3<f32>,
    // What the fundus sends back, through the media.
    fundus: vec3<f32>,
    arcus: f32,
    // What lamellae of the sclera send back and pass, see lamellae_knot.
    lamellae_reflect: array<vec4<f32>, 8>,
    lamellae_pass: array<vec4<f32>, 8>,
    tissue: IrisTissue,
    look: Look,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> globe: Globe;
// Polar map: u the angle, v from the pupil's edge to the root. r: thickness mm, g: melanin of the border layer, b: height mm,
// a: depth of its furrows, mm.
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var iris_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var iris_sampler: sampler;
// Azimuthal equidistant map of the globe's front, to 100 degrees: albedo without vessels.
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var sclera_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(4) var sclera_sampler: sampler;
// Diffuse reflectance of the iris: u stromal path, v root of the melanin of the border layer, of all light and below of what is scattered
// more than once.
@group(#{MATERIAL_BIND_GROUP}) @binding(5) var reflectance_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(6) var reflectance_sampler: sampler;
// Light on a plane through the iris by its obliquity, see iris_light.
@group(#{MATERIAL_BIND_GROUP}) @binding(7) var light_table: texture_2d<f32>;
// In the same projection as the sclera's map. r: blood (mm) of conjunctival vessels, g: of deeper ones, b: height (mm).
@group(#{MATERIAL_BIND_GROUP}) @binding(8) var vessel_map: texture_2d<f32>;

#ifdef FIXED_STEPS
// The plain way, to be measured against: as many steps and segments everywhere, and nothing left out.
const MARCH = IRIS_MARCH_FIXED;
const SKIPS: bool = false;
#else
const SKIPS: bool = true;
#ifdef FULL
const MARCH = IRIS_MARCH_FULL;
#else
const MARCH = IRIS_MARCH_FAST;
#endif
#endif

#ifdef CORNEA
// Radius (mm) of the hole in the iris, which the mesh's tag holds: it is never at rest, and a material that changes is bound anew.
var<private> pupil_radius_mm: f32;
#endif

fn head_from_eye() -> mat3x3f {
    return mat3x3f(globe.head_from_eye[0].xyz, globe.head_from_eye[1].xyz, globe.head_from_eye[2].xyz);
}

// Radiance of the lids' skin.
fn lids_radiance() -> vec3f {
    return globe.lids_color * illumination.lids_lit;
}

// The surroundings' factors by degree.
fn around_factors() -> SkyFactors {
    return sky_factors(illumination.ambient[0].rgb, illumination.ambient[1].rgb, illumination.ambient[2].rgb, illumination.ambient[3].rgb, illumination.ambient[4].rgb, illumination.ambient[5].rgb, illumination.ambient[6].rgb, illumination.ambient[7].rgb, illumination.ambient[8].rgb);
}

// The lids' shade at a point p of the head frame.
fn lids_at(p: vec3f) -> LidShade {
    let at = lid_knot(p.x);
    return lid_shade(globe.lids.spans[at.below], at.part, p);
}

#ifdef CORNEA
// What of the sky's light reaches the iris `radius` mm from the axis.
fn sky_at(radius: f32) -> f32 {
    let at = iris_sky_knot(radius, globe.iris_root_mm);
    let values = globe.iris_sky[at.below];
    return mix(values.x, values.y, at.part);
}

// What this share of the sclera's lamellae leaves to see of the cornea.
fn lamellae_through(share: f32) -> vec3f {
    let at = lamellae_knot(share);
    let passed = mix(globe.lamellae_pass[at.below], globe.lamellae_pass[at.below + 1], at.part);
    return limbus_through(passed.rgb, globe.lamellae_pass[7].rgb);
}

// What it sends back.
fn lamellae_reflected(share: f32) -> vec3f {
    let at = lamellae_knot(share);
    return mix(globe.lamellae_reflect[at.below], globe.lamellae_reflect[at.below + 1], at.part).rgb;
}

fn mirror_eye() -> MirrorEye {
    return MirrorEye(vec2f(globe.anterior_radius_mm, globe.anterior_p), vec2f(globe.posterior_radius_mm, globe.posterior_p), vec2f(globe.lens_front_radius_mm, globe.lens_front_p), vec2f(globe.lens_back_radius_mm, globe.lens_back_p), globe.thickness_mm, globe.iris_depth_mm + globe.lens_forward_mm, globe.lens_thickness_mm, globe.cornea_index, globe.aqueous_index, globe.lens_index);
}

// How far (rad) the inner surfaces spread what they mirror: the grain of a lens's fibres blurs the third image most (choices).
const SECOND_IMAGE_BLUR: f32 = 0.012;
const THIRD_IMAGE_BLUR: f32 = 0.06;
const FOURTH_IMAGE_BLUR: f32 = 0.025;

// Radiance that a surface within the eye mirrors, where it comes from within `open` mm of the pupil's middle.
fn inner_image(image: LensMirrored, open: f32, blur: f32) -> vec3f {
    let comes = step(0.5, dot(image.direction, image.direction)) * step(distance(image.crossing, globe.pupil_center_mm), open) * step(length(image.exit.xy), globe.limbus_mm);
    let apex = vec3f(0.0, 0.0, -globe.apex_mm);
    let outside = normalize(image.direction + vec3f(0.0, 0.0, -1e-3));
    return mirrored(head_from_eye() * (image.exit + apex), head_from_eye() * outside, blur) * (image.share * comes);
}

// A lamp as it is where its light to a place of the iris enters the cornea, eye frame.
fn iris_lamp_at(i: i32, at: vec2f) -> Lamp {
    var lamp = illumination.lamps[i];
    // A row times the turn into the head is the column times the turn out of it.
    lamp.direction = lamp.direction * head_from_eye();
#ifdef NEAR_LAMPS
    let apex = vec3f(0.0, 0.0, -globe.apex_mm);
    let surface = vec2f(globe.anterior_radius_mm, globe.anterior_p);
    lamp = iris_near_lamp(light_table, reflectance_sampler, lamp, apex, vec3f(at, globe.iris_light_mm), surface, globe.aqueous_index, globe.iris_root_mm, globe.limbus_mm);
#endif
    return lamp;
}

// What a fundus of one sends back of the lamps through a place (mm) of the pupil's plane, against a view ray of this direction.
fn fundus_light(place: vec2f, direction: vec3f, shade: LidShade) -> vec3f {
    // Lamps are seen from the middle of the entrance pupil, which stands about as deep as the iris.
    let middle = vec3f(globe.pupil_center_mm, globe.iris_depth_mm - globe.apex_mm);
    let off = (place - globe.pupil_center_mm) * globe.pupil_magnification;
    var sum = vec3f(0.0);
    for (var i = 0; i < LAMPS; i++) {
        let lamp = lamp_at(i, head_from_eye() * middle);
        let passes = lid_lamp(shade, lamp.direction, lamp.radius);
        sum += lamp.color * (passes * fundus_reflex(lamp.direction * head_from_eye(), lamp.radius, lamp.hole, lamp.vergence, -direction, off, globe.focus, pupil_radius_mm * globe.pupil_magnification));
    }
    return sum;
}

// What is seen through the cornea: iris and pupil, dimmed by the two interfaces.
fn through_cornea(origin: vec3f, direction: vec3f, footprint: f32, shade: LidShade) -> vec3f {
#ifdef ARTISTIC
    let indices = mix(vec2f(1.0), vec2f(globe.cornea_index, globe.aqueous_index), globe.look.refraction);
    let size = globe.look.iris_size;
#else
    let indices = vec2f(globe.cornea_index, globe.aqueous_index);
    let size = 1.0;
#endif
    let iris = IrisFrame(globe.iris_root_mm, pupil_radius_mm, globe.limbus_mm, globe.relief, globe.pupil_center_mm, thicken(pupil_radius_mm, globe.iris_root_mm), furrow_depth(pupil_radius_mm), globe.iris_shape.x, globe.iris_shape.y);
    // To the plane of the root, which lies behind that of the pupil's edge, so that no ray is taken to end within the cornea before it.
    let root_mm = max(iris_base(1.0, iris).x, 0.0);
    var trace = cornea_trace(origin, direction, vec2f(globe.anterior_radius_mm, globe.anterior_p), vec2f(globe.posterior_radius_mm, globe.posterior_p), globe.thickness_mm, indices.x, indices.y, globe.iris_depth_mm + root_mm);
    if trace.valid < 0.5 {
        // What enters so far aside stays in the rim, where the sclera's lamellae begin.
        return lamellae_reflected(1.0) * lid_sky(around_factors(), shade, -head_from_eye()[2], lids_radiance());
    }
    trace.point -= trace.direction * (root_mm / max(trace.direction.z, 0.05));
#ifdef ARTISTIC
    // From the examiner's left, by the place of the iris that is really seen.
    if clamp(0.5 - 0.5 * trace.point.x / globe.iris_root_mm, 0.0, 0.999) < globe.look.parallax {
        trace.point = vec3f(parallax_place(trace.entry, direction, PARALLAX_SHARE * globe.iris_depth_mm), globe.iris_depth_mm);
        trace.direction = direction;
    }
#endif
    let at = iris_landing(trace.point.xy / size, trace.direction, iris);
    let place = iris_place(at, iris);
    // In the pupil there is no iris to be followed.
    let edge = pupil_edge(place.uv, footprint, iris_width(iris));
    var surface: IrisSurface;
    surface.at = at;
    if edge > 0.0 || !SKIPS {
        surface = iris_surface(iris_map, iris_sampler, iris, at, place, trace.direction, footprint, MARCH);
    }
    // The sky's light in the lids' shade where it comes from, before this place.
    let apex = vec3f(0.0, 0.0, -globe.apex_mm);
    let depth = globe.iris_depth_mm + surface.base;
    let before = lids_at(head_from_eye() * (vec3f(surface.at, depth) + apex));
    let around = mix(LIDS_SEND * lids_radiance(), ambient(-head_from_eye()[2]), lid_sky_within(before, depth, globe.aqueous_index));
    let sky = sky_at(length(surface.at));
    var falls = around * sky;
    var lit = vec3f(0.0);
    if edge > 0.0 || !SKIPS {
        lit = iris_ambient(reflectance_map, reflectance_sampler, surface, sky) * around;
    }
    var light = around;
    for (var i = 0; i < LAMPS; i++) {
        let lamp = iris_lamp_at(i, surface.at);
        // The table is of a plane, before and behind which the iris stands: once for the way there, once for what it brings.
        let over = globe.iris_light_mm - depth + surface.texel.height;
        let about = crosses_plane(surface.at, over, lamp.direction, globe.aqueous_index);
        let comes = iris_light(light_table, reflectance_sampler, lamp.direction, about, globe.iris_root_mm, globe.limbus_mm);
        let crosses = surface.at - comes.xy * (over / max(-comes.z, 0.25));
        var arrives = iris_light(light_table, reflectance_sampler, lamp.direction, crosses, globe.iris_root_mm, globe.limbus_mm);
        // In the lids' shade where it enters.
        let cornea = vec2f(globe.anterior_radius_mm, globe.anterior_p);
        let plane = vec3f(crosses, globe.iris_light_mm);
        let enters = light_entry(plane, arrives.xyz, cornea);
        var on = beam_on(beam_gathers(enters, plane, lamp.direction, cornea, globe.aqueous_index, lamp.vergence), (depth - globe.iris_light_mm) / max(-arrives.z, 0.25));
        arrives.w *= on.x;
        let lids = lids_at(head_from_eye() * (enters + apex));
        let color = lamp.color * lid_lamp(lids, head_from_eye() * lamp.direction, lamp.radius);
        var concentrated = 1.0;
#ifdef ARTISTIC
        concentrated = caustic_change(arrives.w, globe.look.caustic_scale, globe.look.caustic_power);
        on.y *= globe.look.caustic_scale;
#endif
        if edge > 0.0 || !SKIPS {
            lit += concentrated * color * iris_lamp(iris_map, iris_sampler, reflectance_map, reflectance_sampler, iris, globe.tissue, surface, arrives, on.y, MARCH);
        }
        falls += color * arrives.w;
        light += color * max(-lamp.direction.z, 0.0);
    }
    var lens = globe.lens;
    // What the nucleus and clouds leave of light that crosses the lens and comes back.
    var crosses = globe.lens_passes;
#ifdef CLOUDED
    let slope = trace.direction.xy / max(trace.direction.z, 0.2);
    lens += lens_cloud(globe.nucleus, globe.capsule, globe.capsule_radius_mm, globe.cortical_share, trace.point.xy, slope, globe.lens_turn);
    crosses *= lens_clear(globe.capsule_radius_mm, globe.cortical_share, trace.point.xy, slope, globe.lens_turn);
#endif
    // The second Purkinje image, of the cornea's back; the third and fourth, of the lens, come through the pupil alone.
    let eye = mirror_eye();
    let entered = snell_refract(direction, conicoid_normal(trace.entry, eye.anterior.x, eye.anterior.y), 1.0 / eye.n_cornea);
    let second = inner_image(mirror_cornea(trace.entry, entered.xyz, eye), globe.limbus_mm, SECOND_IMAGE_BLUR);
    // Past the root, where hardly any cornea lets it be seen, the sclera's inner wall.
    lit = mix(lit, lamellae_reflected(1.0) * falls, angle_share(place.uv.y));
    // Radiance spreads where it leaves the aqueous; what the lens sends back is as it is seen from outside.
    lit /= globe.aqueous_index * globe.aqueous_index;
#ifdef ARTISTIC
    lit *= globe.look.iris_brightness;
#endif
    var behind = light * lens;
    if edge < 1.0 || !SKIPS {
        // The fundus, before which the light has come in through the cornea too, and the lens's surfaces.
        behind += fundus_light(trace.point.xy, direction, before) * globe.fundus * trace.transmittance * crosses;
        behind += inner_image(mirror_lens_front(trace.point, trace.direction, eye), pupil_radius_mm, THIRD_IMAGE_BLUR);
        behind += crosses * inner_image(mirror_lens_back(trace.point, trace.direction, eye), pupil_radius_mm, FOURTH_IMAGE_BLUR);
    }
    let inside = mix(behind, lit, edge);
    // The cornea itself scatters a little of the light back.
    return (inside + second) * trace.transmittance + light * globe.cornea_haze;
}
#endif

// Roughness of the wet white.
const WHITE_ROUGHNESS: f32 = 0.2;

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
#ifdef CORNEA
    pupil_radius_mm = tagged_pupil(in.tag);
#endif
    var camera = in.camera;
    var p = in.position;
    var normal = normalize(in.normal);
#ifdef CONJUNCTIVA
    // It stands in the head, and is seen as the white that it covers is.
    let eye_from_head = transpose(head_from_eye());
    camera = eye_from_head * camera;
    p = eye_from_head * p;
    // Where it is thin it lies on the globe and has its shape.
    normal = normalize(mix(normalize(p), eye_from_head * normal, smoothstep(0.0, 0.9, in.tissue.b)));
#endif
    let direction = normalize(p - camera);
#ifdef WHITE
    var corneal = 0.0;
#else
    // Within the limbus nothing but the cornea is seen.
    let corneal = 1.0;
#endif
#ifdef CORNEA
    var sine = 0.0;
    var from_axis = 0.0;
#ifdef ARCUS
    var rim = 1.0;
#endif
    let apex = vec3f(0.0, 0.0, -globe.apex_mm);
    let origin = camera - apex;
    let t = conicoid_intersect(origin, direction, globe.anterior_radius_mm, globe.anterior_p);
    let met = origin + t * direction;
    // Beyond the limbus' radius the surface is the globe's, of which the conicoid knows nothing; but it may stand before it.
    let before = t > 0.0 && t < dot(p - camera, direction) && length(met.xy) < globe.limbus_mm;
    let beyond = length(p.xy) >= globe.limbus_mm && !before;
    if t > 0.0 || beyond {
        let hit = select(met, p - apex, beyond);
        let r = length(hit.xy);
        sine = hit.y / max(r, 1e-3);
        from_axis = r;
#ifdef ARCUS
        rim = limbus_width(hit.xy, globe.lens_turn);
#endif
        if !beyond { p = hit + apex; }
#ifdef WHITE
        let wide = limbus_width(hit.xy, globe.lens_turn);
#ifdef ARTISTIC
        corneal = limbus_share(limbus_place(r, globe.limbus_mm, wide * globe.look.limbus_color_mm), globe.limbus_mm);
        let shaped = limbus_shaped(r, globe.limbus_mm, wide * globe.look.limbus_shading_mm);
#else
        corneal = limbus_share(limbus_place(r, globe.limbus_mm, wide * LIMBUS_MM), globe.limbus_mm);
        let shaped = limbus_shaped(r, globe.limbus_mm, wide * LIMBUS_MM);
#endif
        normal = limbus_normal(normal, conicoid_normal(hit, globe.anterior_radius_mm, globe.anterior_p), shaped);
#else
        normal = conicoid_normal(hit, globe.anterior_radius_mm, globe.anterior_p);
#endif
    }
#endif
    let p_head = head_from_eye() * p;
    let shade = lids_at(p_head);
#ifdef ARTISTIC
    let white_roughness = globe.look.white_roughness;
#else
    let white_roughness = WHITE_ROUGHNESS;
#endif
    let footprint = footprint_at(distance(p, camera));
#ifdef CONJUNCTIVA
    // Where it is thick its own lumps, each of which is smooth, break what its wet surface mirrors; where it has none it is rough.
    let lumpy = lumps_at(vessel_map, sclera_sampler, p_head, footprint, globe.sclera_radius_mm);
    let uneven = in.tissue.b * mix(0.6, -0.55, lumpy.w);
#else
    let uneven = 0.0;
#endif
    let v_head = head_from_eye() * -direction;
    var diffuse = vec3f(0.0);
    var specular = vec3f(0.0);
    var wet_normal = normal;
    var white_blur = 0.0;
#ifdef WHITE
    if corneal < 1.0 {
        var sclera = sclera_surface(sclera_map, vessel_map, sclera_sampler, p, normal, -direction, footprint, globe.sclera_radius_mm, globe.above_vessels);
#ifdef ARTISTIC
        let aside = sclera_surface(sclera_map, vessel_map, sclera_sampler, relief_place(p, globe.look.white_relief_size), normal, -direction, footprint / globe.look.white_relief_size, globe.sclera_radius_mm, globe.above_vessels);
        sclera.normal = normalize(normal + (aside.normal - normal) * globe.look.white_relief);
        sclera.soft = normalize(normal + (aside.soft - normal) * globe.look.white_relief);
        sclera.unseen = aside.unseen * globe.look.white_relief * globe.look.white_relief;
        sclera.albedo *= globe.look.white_brightness;
#endif
        wet_normal = normalize(mix(sclera.normal, normal, corneal));
#ifdef CONJUNCTIVA
        let slope = eye_from_head * vec3f(lumpy.yz * in.tissue.b, 0.0);
        wet_normal = normalize(sclera.normal - slope);
        sclera.soft = normalize(sclera.soft - 0.6 * slope);
        sclera.albedo *= conjunctiva_filter(globe.flesh, sclera.albedo, in.tissue.b);
        sclera.albedo *= mix(vec3f(1.0), lump_color(lumpy.x), in.tissue.b * lumpy.w);
#endif
        let n_white = head_from_eye() * sclera.soft;
        let n_wet = head_from_eye() * wet_normal;
        let roughness = white_rough(white_roughness * (1.0 + uneven), sclera.unseen);
        white_blur = mirror_spread(roughness);
        var light = lid_sky(around_factors(), shade, n_white, lids_radiance());
#ifdef CONJUNCTIVA
        // Towards the corner it rises to the margins, and less hangs over it.
        light = mix(light, ambient(n_white) * in.tissue.a, 0.7 * in.tissue.b);
#endif
        for (var i = 0; i < LAMPS; i++) {
            let lamp = lamp_at(i, p_head);
            var left = lid_lamp(shade, lamp.direction, lamp.radius);
#ifdef CONJUNCTIVA
            left = mix(left, in.tissue.a, 0.7 * in.tissue.b);
#endif
            light += lamp.color * left * sclera_lamp(dot(n_white, lamp.direction));
            let alpha = lamp_alpha(roughness, 0.0625 * lamp.radius);
            specular += lamp.color * (lamp_lobe(n_wet, v_head, lamp.direction, alpha, 1.336, 1e-3) * left * (1.0 - corneal));
        }
        diffuse = sclera.albedo * light;
    }
#endif
#ifdef CORNEA
    if corneal > 0.0 {
#ifdef WHITE
#ifdef ARTISTIC
        let lies_over = 1.0 - pow(corneal, globe.look.limbus_power);
        let dims = pow(lamellae_through(lies_over), vec3f(globe.look.limbus_dark));
#else
        let lies_over = 1.0 - corneal;
        let dims = lamellae_through(lies_over);
#endif
#endif
        var through = through_cornea(origin, direction, footprint, shade);
#ifdef ARCUS
        // Lipid in the rim of the stroma, lit as the white is.
        let n_cornea = head_from_eye() * normal;
        var light = lid_sky(around_factors(), shade, n_cornea, lids_radiance());
        for (var i = 0; i < LAMPS; i++) {
            let lamp = lamp_at(i, p_head);
            light += lamp.color * lid_lamp(shade, lamp.direction, lamp.radius) * max(dot(n_cornea, lamp.direction), 0.0);
        }
        let lipid = ARCUS_DENSEST * arcus_share(from_axis, sine, globe.limbus_mm, globe.arcus, rim);
        // Its droplets are larger than fibrils: white, not blue.
        through = through * lamellae_through(lipid) + lamellae_reflected(lipid).g * light;
#endif
#ifdef WHITE
        diffuse = diffuse * limbus_white(lamellae_reflected(lies_over), globe.lamellae_reflect[7].rgb) + through * dims;
#else
        diffuse = through;
#endif
    }
#endif

    let tears = tear_layer(p_head.xy, tear_age(in.tag), globe.lipid_nm, globe.tear_breakup_s, globe.lens_turn);
    let n_head = normalize(head_from_eye() * wet_normal + vec3f(tears.tilt, 0.0));
#ifdef ARTISTIC
    let blur = mix(white_blur, globe.look.cornea_roughness, corneal);
    specular *= globe.look.white_specularity;
    let strength = mix(globe.look.white_specularity, globe.look.cornea_specularity, corneal);
    // By the normal as the camera has it: what is before a camera that looks at the face from the front.
    let along = normalize(head_from_eye() * camera);
    let beside = normalize(cross(along, vec3f(0.0, 1.0, 0.0)) + vec3f(1e-6, 0.0, 0.0));
    let turned = vec3f(dot(n_head, beside), dot(n_head, cross(beside, along)), -dot(n_head, along));
    specular += 0.25 * globe.look.matcap * mirrored(p_head, reflect(vec3f(0.0, 0.0, 1.0), turned), 0.05);
#else
    let blur = mix(white_blur, 0.012, corneal);
    let strength = 1.0;
#endif
    let around = mirrored(p_head, reflect(-v_head, n_head), blur + BROKEN_BLUR * tears.broken);
    specular += strength * tear_reflection(around, lids_radiance(), n_head, v_head, tears.lipid_nm, shade, footprint);
    return vec4f(shown(diffuse + specular), 1.0);
}
