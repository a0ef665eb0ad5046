// The globe: sclera, limbus, and behind an exactly refracting cornea the iris
// and the pupil, in one opaque material (François et al. 2007, section 5).
//
// Every view ray is intersected with the conicoid of the cornea in closed
// form, refracted at both surfaces onto the iris, and marched through the
// relief; the light takes the two-point path (section 3), and its
// concentration by the cornea is the Jacobian of that path.

struct Globe {
    studio: Studio,
    lids: Lids,
    // Rotation from the eye frame to the head frame, columns.
    head_from_eye: mat4x4<f32>,
    // Anterior (R, p) and posterior (R, p), mm.
    cornea: vec4<f32>,
    // Thickness mm, index of the cornea, index of the aqueous, depth of the apex before the centre mm.
    cornea_inside: vec4<f32>,
    // Depth of the iris behind the apex, radius of its root, radius of the pupil, radius of the limbus; mm.
    iris: vec4<f32>,
    // Centre of the pupil (x, y) mm; radius of the scleral sphere mm; lipid thickness nm.
    pupil: vec4<f32>,
    // x: 1 where the lens behind the pupil scatters (age), y: pinkness of the canthi, z: +1 OD, -1 OS, w: relief.
    options: vec4<f32>,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> globe: Globe;
// Polar map: u the angle, v from the pupil's edge to the root. r: thickness mm, g: melanin of the border layer, b: height mm.
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var iris_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var iris_sampler: sampler;
// Azimuthal equidistant map of the globe's front, to 100 degrees. rgb: albedo, a: height.
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var sclera_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(4) var sclera_sampler: sampler;
// Diffuse reflectance of the iris: u stromal path, v melanin of the border layer.
@group(#{MATERIAL_BIND_GROUP}) @binding(5) var reflectance_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(6) var reflectance_sampler: sampler;
// Two lamps side by side over the iris plane: xy towards the light inside the eye, z irradiance,
// w radius (mm) at which the light enters the cornea.
@group(#{MATERIAL_BIND_GROUP}) @binding(7) var light_table: texture_2d<f32>;

const SCLERA_HALF_ANGLE: f32 = 1.7453293;
const PATH_MAX_MM: f32 = 2.5;

fn head(v: vec3<f32>) -> vec3<f32> {
    return (globe.head_from_eye * vec4(v, 0.0)).xyz;
}

fn eye_from_head(v: vec3<f32>) -> vec3<f32> {
    return (vec4(v, 0.0) * globe.head_from_eye).xyz;
}

struct IrisTexel { height: f32, thickness: f32, melanin: f32 };

// Place in the iris map: u the angle, v from the pupil's edge to the root, and how both change
// with a step on the iris plane, so that small steps need no arc tangent.
struct IrisPlace { uv: vec2<f32>, du: vec2<f32>, dv: vec2<f32> };

fn iris_place(p: vec2<f32>) -> IrisPlace {
    let q = p - globe.pupil.xy * (1.0 - length(p) / globe.iris.y);
    let r = max(length(q), 0.2);
    let width = max(globe.iris.y - globe.iris.z, 0.5);
    return IrisPlace(
        vec2(atan2(q.y, q.x) * 0.15915494 + 0.5, (r - globe.iris.z) / width),
        vec2(-q.y, q.x) * (0.15915494 / (r * r)),
        q / (r * width),
    );
}

fn iris_step(place: IrisPlace, step: vec2<f32>) -> vec2<f32> {
    return place.uv + vec2(dot(place.du, step), dot(place.dv, step));
}

fn iris_texel(uv: vec2<f32>, lod: f32) -> IrisTexel {
    let t = textureSampleLevel(iris_map, iris_sampler, vec2(uv.x, clamp(uv.y, 0.001, 0.999)), lod);
    return IrisTexel(t.b, t.r, t.g);
}

// How far (mm, on the iris plane) the refracted ray has moved where it meets the relief: the first
// place where the ray is below the surface, by linear steps and one secant.
fn relief(place: IrisPlace, direction: vec3<f32>, lod: f32) -> vec2<f32> {
    let slope = direction.xy / max(direction.z, 0.2);
    // From the highest ridges, above the mean plane, to the deepest crypts below it.
    let top = 0.20;
    let deepest = 0.40;
    var before = 0.0;
    var gap_before = -0.05;
    for (var i = 1; i <= 5; i++) {
        let depth = deepest * f32(i) / 5.0;
        let gap = depth - top + iris_texel(iris_step(place, slope * (depth - top)), lod).height;
        if gap >= 0.0 {
            return slope * (mix(before, depth, gap_before / (gap_before - gap)) - top);
        }
        before = depth;
        gap_before = gap;
    }
    return slope * (deepest - top);
}

// Light of a lamp (0 key, 1 fill) at a place of the iris plane: xyz towards where it enters the
// cornea, w irradiance relative to the lamp's. Solved exactly on the CPU, interpolated here.
fn iris_light(lamp: f32, p: vec2<f32>) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(light_table)) * vec2(0.5, 1.0);
    let at = clamp(p / (globe.iris.y * 1.04) * 0.5 + 0.5, vec2(0.0), vec2(1.0)) * (size - 1.0) + 0.5;
    let t = textureSampleLevel(light_table, reflectance_sampler, (at + vec2(lamp * size.x, 0.0)) / (size * vec2(2.0, 1.0)), 0.0);
    // Light that would have to enter outside the cornea meets the sclera instead.
    let inside = smoothstep(globe.iris.w + 0.5, globe.iris.w - 0.3, t.w);
    return vec4(t.xy, -sqrt(max(1.0 - dot(t.xy, t.xy), 0.04)), t.z * inside);
}

// What of a lamp's irradiance the relief takes up at this normal. Light that enters one fibre
// leaves through its neighbours, so that a part of the contrast is lost.
fn relief_gain(normal: vec3<f32>, towards: vec3<f32>) -> f32 {
    let cosine = max(dot(normal, towards), 0.0);
    return clamp(mix(1.0, cosine / max(-towards.z, 0.1), 0.75), 0.0, 2.2);
}

fn iris_shade(trace_point: vec3<f32>, trace_direction: vec3<f32>, start: IrisPlace, footprint: f32, shade: LidShade) -> vec3<f32> {
    let width = max(globe.iris.y - globe.iris.z, 0.5);
    let size = vec2<f32>(textureDimensions(iris_map));
    let texels = footprint * vec2(size.x / (6.2831853 * max(length(trace_point.xy), 1.0)), size.y / width);
    let lod = max(log2(max(texels.x, texels.y)) - 0.4, 0.0);
    let moved = relief(start, trace_direction, lod + 0.5);
    let place = IrisPlace(iris_step(start, moved), start.du, start.dv);
    let point = trace_point.xy + moved;
    let texel = iris_texel(place.uv, lod);

    // The slope of the relief, by differences one footprint wide.
    let e = max(footprint, 0.012);
    let hx = iris_texel(iris_step(place, vec2(e, 0.0)), lod).height - texel.height;
    let hy = iris_texel(iris_step(place, vec2(0.0, e)), lod).height - texel.height;
    let strength = globe.options.w / e;
    let normal = normalize(vec3(-hx * strength, -hy * strength, -1.0));
    let view_cosine = max(-dot(normal, trace_direction), 0.2);

    let key = iris_light(0.0, point);
    let fill = iris_light(1.0, point);
    // Two short steps towards the key light decide the relief's own shadow.
    var shadow = 1.0;
    for (var i = 1; i <= 2; i++) {
        let s = 0.09 * f32(i);
        let ridge = iris_texel(iris_step(place, key.xy * (s / max(-key.z, 0.25))), lod).height - texel.height;
        shadow *= 1.0 - 0.55 * smoothstep(0.0, 0.10, ridge - s);
    }
    let path = texel.thickness * 0.5 * (1.0 / max(-key.z, 0.35) + 1.0 / max(view_cosine, 0.35));
    let reflectance = textureSampleLevel(reflectance_map, reflectance_sampler, vec2(path / PATH_MAX_MM, texel.melanin), 0.0).rgb;

    var light = globe.studio.key_color.rgb * (key.w * relief_gain(normal, key.xyz) * shadow * shade.key);
    light += globe.studio.fill_color.rgb * (fill.w * relief_gain(normal, fill.xyz) * shade.sky);
    // Surroundings: over the dome they arrive nearly evenly; what is deep sees less of them.
    let open = clamp(0.80 + texel.height * 2.2, 0.35, 1.15);
    light += studio_ambient(globe.studio, head(vec3(0.0, 0.0, -1.0))) * (open * shade.sky * 0.92);
    var radiance = reflectance * light;

    // The root lies in the shade of the limbus; the ruff is pigment without stroma.
    let root = smoothstep(0.80, 1.02, place.uv.y);
    radiance *= mix(vec3(1.0), vec3(0.30, 0.33, 0.38), root);
    let ruff = smoothstep(0.035, 0.0, place.uv.y);
    radiance *= mix(vec3(1.0), vec3(0.16, 0.11, 0.08), ruff);
    return radiance;
}

// What shows through the pupil: nearly black; an old lens scatters a little.
fn pupil_radiance(shade: LidShade) -> vec3<f32> {
    let light = (globe.studio.key_color.rgb + globe.studio.fill_color.rgb) * shade.key;
    return vec3(0.0016, 0.0013, 0.0012) + light * globe.options.x * vec3(0.012, 0.010, 0.006);
}

fn sclera_uv(p: vec3<f32>) -> vec2<f32> {
    let n = normalize(p);
    let angle = acos(clamp(-n.z, -1.0, 1.0));
    let across = length(n.xy);
    let direction = select(vec2(0.0), n.xy / across, across > 1e-6);
    return 0.5 + 0.5 * direction * (angle / SCLERA_HALF_ANGLE);
}

struct ScleraShade { diffuse: vec3<f32>, normal: vec3<f32> };

fn sclera_shade(p: vec3<f32>, normal: vec3<f32>, footprint: f32, shade: LidShade) -> ScleraShade {
    let uv = sclera_uv(p);
    let texels = f32(textureDimensions(sclera_map).x);
    let texel_mm = 2.0 * SCLERA_HALF_ANGLE * globe.pupil.z / texels;
    let lod = max(log2(footprint / texel_mm), 0.0);
    let here = textureSampleLevel(sclera_map, sclera_sampler, uv, lod);
    let step = 1.5 / texels;
    let right = textureSampleLevel(sclera_map, sclera_sampler, uv + vec2(step, 0.0), lod).a;
    let above = textureSampleLevel(sclera_map, sclera_sampler, uv + vec2(0.0, step), lod).a;
    let bump = vec2(right - here.a, above - here.a) * 1.3;
    let n = normalize(normal - vec3(bump, 0.0));

    let key = eye_from_head(globe.studio.key_direction.xyz);
    let fill = eye_from_head(globe.studio.fill_direction.xyz);
    let n_head = head(n);
    // Light travels under the surface: red furthest.
    let wrap = vec3(0.42, 0.30, 0.24);
    let key_cosine = dot(n, key);
    let fill_cosine = dot(n, fill);
    var light = studio_ambient(globe.studio, n_head) * shade.sky;
    for (var c = 0; c < 3; c++) {
        light[c] += globe.studio.key_color[c] * wrapped_cosine(key_cosine, wrap[c]) * shade.key;
        light[c] += globe.studio.fill_color[c] * wrapped_cosine(fill_cosine, wrap[c]) * shade.sky;
    }
    // What the lids reflect back is warm, most of it near their margins.
    let near_lid = exp(-max(min(shade.upper_gap, shade.lower_gap), 0.0) / 1.1);
    let bounce = mix(vec3(1.0), vec3(1.05, 0.86, 0.80), near_lid * 0.8);
    return ScleraShade(here.rgb * light * bounce, n);
}

// GGX highlight of one lamp, its roughness widened by the lamp's size.
fn lamp_highlight(n: vec3<f32>, v: vec3<f32>, l: vec3<f32>, roughness: f32, lamp: f32, color: vec3<f32>) -> vec3<f32> {
    let h = normalize(l + v);
    let nl = max(dot(n, l), 0.0);
    let nv = max(dot(n, v), 1e-3);
    let alpha = clamp(roughness * roughness + 0.25 * lamp, 1e-3, 1.0);
    let d = ggx_ndf(max(dot(n, h), 0.0), alpha);
    let g = ggx_visibility_smith(nl, nv, alpha);
    let f = fresnel_dielectric(max(dot(v, h), 0.0), 1.0, 1.336);
    return color * 3.14159265 * (d * g * f * nl);
}

// Reflection of the surroundings in the tear film; the lids and lashes hide what lies above.
fn reflection(p_head: vec3<f32>, n_head: vec3<f32>, v_head: vec3<f32>, blur: f32, shade: LidShade) -> vec3<f32> {
    let r = reflect(-v_head, n_head);
    let cosine = clamp(dot(n_head, v_head), 0.0, 1.0);
    let f = tear_film_rgb(cosine, 1.48, 1.337, globe.pupil.w);
    // The reflected ray rises by r.y for each unit forward; it meets the upper lid when that is steeper than the gap allows.
    let rise = r.y / max(length(r.xz), 0.05);
    let lid = smoothstep(-0.35, 0.35, shade.upper_gap * 0.42 + 0.25 - rise);
    let outward = smoothstep(-0.05, 0.25, -r.z + 0.25);
    let skin = vec3(0.10, 0.06, 0.045);
    return f * mix(skin, studio_radiance(globe.studio, r, blur), lid * outward);
}

#ifdef CORNEA
// What is seen through the cornea: iris and pupil, dimmed by the two interfaces.
fn through_cornea(origin: vec3<f32>, direction: vec3<f32>, footprint: f32, shade: LidShade) -> vec3<f32> {
    let trace = cornea_trace(origin, direction, globe.cornea.xy, globe.cornea.zw, globe.cornea_inside.x, globe.cornea_inside.y, globe.cornea_inside.z, globe.iris.x);
    if trace.valid < 0.5 {
        return vec3(0.02, 0.018, 0.016);
    }
    let place = iris_place(trace.point.xy);
    let width = max(globe.iris.y - globe.iris.z, 0.5);
    // The pupil's margin is uneven and softened over a pixel.
    let uneven = 0.006 * sin(place.uv.x * 81.6814) + 0.005 * sin(place.uv.x * 37.6991 + 1.7);
    let soft = max(0.75 * footprint / width, 0.008);
    let edge = smoothstep(-soft, soft, place.uv.y - uneven);
    // Past the root the ray ends in the angle, behind the limbus.
    let beyond = smoothstep(1.0, 1.12, place.uv.y);
    let lit = iris_shade(trace.point, trace.direction, place, footprint, shade);
    let inside = mix(pupil_radiance(shade), mix(lit, vec3(0.03, 0.028, 0.027), beyond), edge);
    return inside * trace.transmittance;
}
#endif

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let direction = normalize(in.position - in.camera);
    var p = in.position;
    var normal = normalize(in.normal);
#ifdef CORNEA
    let apex = vec3(0.0, 0.0, -globe.cornea_inside.w);
    let origin = in.camera - apex;
    let t = conicoid_intersect(origin, direction, globe.cornea.x, globe.cornea.y);
    var corneal = 0.0;
    if t > 0.0 {
        let hit = origin + t * direction;
        // The cornea ends at the limbus, softly.
        let r = length(hit.xy);
        corneal = smoothstep(globe.iris.w + 0.30, globe.iris.w - 0.75, r);
        if r < globe.iris.w { p = hit + apex; }
        let n = conicoid_normal(hit, globe.cornea.x, globe.cornea.y);
        normal = normalize(mix(normal, n, smoothstep(0.0, 0.35, corneal)));
    }
#else
    let corneal = 0.0;
#endif
    let p_head = head(p);
    let shade = lid_shade(globe.lids, p_head);
    let footprint = pixel_footprint(distance(p, in.camera));
    let v_head = head(-direction);

    let sclera = sclera_shade(p, normal, footprint, shade);
    var diffuse = sclera.diffuse;
    var wet_normal = sclera.normal;
#ifdef CORNEA
    diffuse = mix(diffuse, through_cornea(origin, direction, footprint, shade), corneal);
    wet_normal = normalize(mix(sclera.normal, normal, corneal));
    // The limbus: a blue-grey ring where the sclera thins over the dark angle.
    let ring = corneal * (1.0 - corneal) * 4.0;
    diffuse *= mix(vec3(1.0), vec3(0.62, 0.66, 0.72), ring * 0.75);
#endif

    let n_head = normalize(head(wet_normal));
    var specular = reflection(p_head, n_head, v_head, mix(0.16, 0.012, corneal), shade);
    let broken = lamp_highlight(n_head, v_head, globe.studio.key_direction.xyz, 0.24, globe.studio.key_direction.w * 0.25, globe.studio.key_color.rgb);
    specular += broken * shade.key * (1.0 - corneal);
    return vec4(output_transform(diffuse + specular, globe.studio.key_color.w), 1.0);
}
