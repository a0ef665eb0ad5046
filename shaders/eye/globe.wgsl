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
// Polar map: u the angle, v from the pupil's edge to the root. r: height mm, g: thickness mm, b: melanin of the border layer.
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var iris_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var iris_sampler: sampler;
// Azimuthal equidistant map of the globe's front, to 100 degrees. rgb: albedo, a: height.
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var sclera_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(4) var sclera_sampler: sampler;
// Diffuse reflectance of the iris: u stromal path, v melanin of the border layer.
@group(#{MATERIAL_BIND_GROUP}) @binding(5) var reflectance_map: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(6) var reflectance_sampler: sampler;

const SCLERA_HALF_ANGLE: f32 = 1.7453293;
const PATH_MAX_MM: f32 = 2.5;

fn head(v: vec3<f32>) -> vec3<f32> {
    return (globe.head_from_eye * vec4(v, 0.0)).xyz;
}

fn eye_from_head(v: vec3<f32>) -> vec3<f32> {
    return (vec4(v, 0.0) * globe.head_from_eye).xyz;
}

struct IrisTexel { height: f32, thickness: f32, melanin: f32 };

fn iris_coordinates(p: vec2<f32>) -> vec2<f32> {
    let q = p - globe.pupil.xy * (1.0 - length(p) / globe.iris.y);
    let r = length(q);
    let v = (r - globe.iris.z) / max(globe.iris.y - globe.iris.z, 0.5);
    return vec2(atan2(q.y, q.x) * 0.15915494 + 0.5, v);
}

fn iris_texel(uv: vec2<f32>, lod: f32) -> IrisTexel {
    let t = textureSampleLevel(iris_map, iris_sampler, vec2(uv.x, clamp(uv.y, 0.001, 0.999)), lod);
    return IrisTexel(t.r, t.g, t.b);
}

// Follows the refracted ray from the iris plane into the relief: the first
// place where the ray is below the surface, by linear steps and one secant.
fn relief(point: vec3<f32>, direction: vec3<f32>, lod: f32) -> vec3<f32> {
    let deepest = 0.42;
    let slope = direction / max(direction.z, 0.2);
    // The ray starts on the plane of the highest ridges, above the mean plane.
    let start = point - slope * 0.20;
    var before = 0.0;
    var gap_before = -1.0;
    for (var i = 1; i <= 8; i++) {
        let depth = deepest * f32(i) / 8.0;
        let p = start + slope * depth;
        let gap = depth - (0.20 - iris_texel(iris_coordinates(p.xy), lod).height);
        if gap >= 0.0 {
            let s = mix(before, depth, gap_before / (gap_before - gap));
            return start + slope * s;
        }
        before = depth;
        gap_before = gap;
    }
    return start + slope * deepest;
}

struct IrisShade { radiance: vec3<f32>, opacity: f32 };

fn lamp_on_iris(point: vec3<f32>, normal: vec3<f32>, towards: vec3<f32>, texel: IrisTexel, view_cosine: f32, color: vec3<f32>, lod: f32) -> vec3<f32> {
    // In the optics frame light comes from -z.
    if towards.z > -0.06 { return vec3(0.0); }
    let lit = vec3(point.xy, globe.iris.x);
    let entered = fermat_entry(lit, towards, globe.cornea.xy, globe.cornea_inside.z, FERMAT_STEPS);
    if entered.w < 0.5 { return vec3(0.0); }
    let entry = entered.xyz;
    // Light that would have to enter outside the cornea meets the sclera instead.
    let through_limbus = smoothstep(globe.iris.w + 0.5, globe.iris.w - 0.3, length(entry.xy));
    let irradiance = through_limbus * caustic_irradiance_at(entry, towards, globe.cornea.xy, globe.cornea_inside.z, globe.iris.x);
    let inside = normalize(entry - lit);
    // Two short steps towards the light decide the relief's own shadow.
    var shadow = 1.0;
    let here = iris_coordinates(point.xy);
    for (var i = 1; i <= 2; i++) {
        let s = 0.09 * f32(i);
        let q = point + inside * (s / max(-inside.z, 0.25));
        let ridge = iris_texel(iris_coordinates(q.xy), lod).height - texel.height;
        shadow *= 1.0 - 0.55 * smoothstep(0.0, 0.10, ridge - s);
    }
    let cosine = max(dot(normal, inside), 0.0);
    let flat_cosine = max(-inside.z, 0.1);
    let path = texel.thickness * 0.5 * (1.0 / max(cosine, 0.35) + 1.0 / max(view_cosine, 0.35));
    let reflectance = textureSampleLevel(reflectance_map, reflectance_sampler, vec2(path / PATH_MAX_MM, texel.melanin), 0.0).rgb;
    // Light that enters one fibre leaves through its neighbours: half of the relief's contrast stays.
    let relief_gain = mix(1.0, cosine / flat_cosine, 0.75);
    return color * reflectance * irradiance * clamp(relief_gain, 0.0, 2.2) * shadow;
}

fn iris_shade(trace_point: vec3<f32>, trace_direction: vec3<f32>, footprint: f32, shade: LidShade) -> vec3<f32> {
    let width = max(globe.iris.y - globe.iris.z, 0.5);
    let size = vec2<f32>(textureDimensions(iris_map));
    let texels = footprint * vec2(size.x / (6.2831853 * max(length(trace_point.xy), 1.0)), size.y / width);
    let lod = max(log2(max(texels.x, texels.y)) - 0.3, 0.0);
    let point = relief(trace_point, trace_direction, lod + 0.5);
    let uv = iris_coordinates(point.xy);
    let texel = iris_texel(uv, lod);

    // The slope of the relief, by differences one footprint wide.
    let e = max(footprint, 0.012);
    let hx = iris_texel(iris_coordinates(point.xy + vec2(e, 0.0)), lod).height - iris_texel(iris_coordinates(point.xy - vec2(e, 0.0)), lod).height;
    let hy = iris_texel(iris_coordinates(point.xy + vec2(0.0, e)), lod).height - iris_texel(iris_coordinates(point.xy - vec2(0.0, e)), lod).height;
    let strength = globe.options.w;
    let normal = normalize(vec3(-hx * strength / (2.0 * e), -hy * strength / (2.0 * e), -1.0));

    let view_cosine = max(-dot(normal, trace_direction), 0.2);
    let key = eye_from_head(globe.studio.key_direction.xyz);
    let fill = eye_from_head(globe.studio.fill_direction.xyz);
    var radiance = lamp_on_iris(point, normal, key, texel, view_cosine, globe.studio.key_color.rgb * shade.key, lod);
    radiance += lamp_on_iris(point, normal, fill, texel, view_cosine, globe.studio.fill_color.rgb * shade.sky, lod);

    // Surroundings: over the dome they arrive nearly evenly; what is deep sees less of them.
    let path = texel.thickness / max(view_cosine, 0.35);
    let reflectance = textureSampleLevel(reflectance_map, reflectance_sampler, vec2(path / PATH_MAX_MM, texel.melanin), 0.0).rgb;
    let open = clamp(0.75 + texel.height * 2.2, 0.35, 1.1);
    radiance += reflectance * studio_ambient(globe.studio, head(vec3(0.0, 0.0, -1.0))) * open * shade.sky * 0.92;

    // The root lies in the shade of the limbus; the ruff is pigment without stroma.
    let root = smoothstep(0.80, 1.02, uv.y);
    radiance *= mix(vec3(1.0), vec3(0.30, 0.33, 0.38), root);
    let ruff = smoothstep(0.035, 0.0, uv.y);
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
    let f = fresnel_thin_film_rgb(cosine, 1.48, 1.337, globe.pupil.w);
    // The reflected ray rises by r.y for each unit forward; it meets the upper lid when that is steeper than the gap allows.
    let rise = r.y / max(length(r.xz), 0.05);
    let lid = smoothstep(-0.35, 0.35, shade.upper_gap * 0.42 + 0.25 - rise);
    let outward = smoothstep(-0.05, 0.25, -r.z + 0.25);
    let skin = vec3(0.10, 0.06, 0.045);
    return f * mix(skin, studio_radiance(globe.studio, r, blur), lid * outward);
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let apex = vec3(0.0, 0.0, -globe.cornea_inside.w);
    let direction = normalize(in.position - in.camera);
    let origin = in.camera - apex;
    let t = conicoid_intersect(origin, direction, globe.cornea.x, globe.cornea.y);
    var p = in.position;
    var corneal = 0.0;
    if t > 0.0 {
        let hit = origin + t * direction;
        // The cornea ends at the limbus, softly.
        let r = length(hit.xy);
        corneal = smoothstep(globe.iris.w + 0.30, globe.iris.w - 0.75, r);
        if r < globe.iris.w { p = hit + apex; }
    }
    let p_head = head(p);
    let shade = lid_shade(globe.lids, p_head);
    let distance_mm = distance(p, in.camera);
    let footprint = pixel_footprint(distance_mm);
    let v_head = head(-direction);

    var diffuse = vec3(0.0);
    var normal = normalize(in.normal);
    if t > 0.0 {
        let n = conicoid_normal(origin + t * direction, globe.cornea.x, globe.cornea.y);
        normal = normalize(mix(normal, n, smoothstep(0.0, 0.35, corneal)));
    }
    var wet_normal = normal;
    if corneal < 1.0 {
        let sclera = sclera_shade(p, normal, footprint, shade);
        diffuse = sclera.diffuse;
        wet_normal = normalize(mix(sclera.normal, normal, corneal));
    }
    if corneal > 0.0 {
        let trace = cornea_trace(origin, direction, globe.cornea.xy, globe.cornea.zw, globe.cornea_inside.x, globe.cornea_inside.y, globe.cornea_inside.z, globe.iris.x);
        var inside = vec3(0.02, 0.018, 0.016);
        if trace.valid > 0.5 {
            let coordinates = iris_coordinates(trace.point.xy);
            let width = max(globe.iris.y - globe.iris.z, 0.5);
            // The pupil's margin is uneven and softened over a pixel.
            let uneven = 0.006 * sin(coordinates.x * 81.0) + 0.005 * sin(coordinates.x * 38.0 + 1.7);
            let soft = max(0.75 * footprint / width, 0.008);
            let edge = smoothstep(-soft, soft, coordinates.y - uneven);
            let dark = pupil_radiance(shade);
            inside = dark;
            if edge > 0.0 {
                // Past the root the ray ends in the angle, behind the limbus.
                let beyond = smoothstep(1.0, 1.12, coordinates.y);
                let lit = iris_shade(trace.point, trace.direction, footprint, shade);
                inside = mix(dark, mix(lit, vec3(0.03, 0.028, 0.027), beyond), edge);
            }
            inside *= trace.transmittance;
        }
        diffuse = mix(diffuse, inside, corneal);
    }
    // The limbus: a blue-grey ring where the sclera thins over the dark angle.
    let ring = corneal * (1.0 - corneal) * 4.0;
    diffuse *= mix(vec3(1.0), vec3(0.62, 0.66, 0.72), ring * 0.75);

    let n_head = normalize(head(wet_normal));
    let blur = mix(0.16, 0.012, corneal);
    var specular = reflection(p_head, n_head, v_head, blur, shade);
    if corneal < 0.98 {
        let broken = lamp_highlight(n_head, v_head, globe.studio.key_direction.xyz, 0.24, globe.studio.key_direction.w * 0.25, globe.studio.key_color.rgb);
        specular += broken * shade.key * (1.0 - corneal);
    }
    return vec4(output_transform(diffuse + specular, globe.studio.key_color.w), 1.0);
}
