// needs: conicoid.wgsl, fresnel.wgsl, surroundings.wgsl, iris_light.wgsl
//
// Light of a lamp that is near, on the iris: its rays are those of distant lamps, each of its own direction, and spread from a
// point. Optics frame: origin at the corneal apex, +z into the eye, millimetres. A surface is vec2(apical radius R, shape
// factor p). Twin: src/appearance/shading/near_light.rs.

// Where light that arrives at `point` from the unit direction `towards` entered the cornea.
fn light_entry(point: vec3f, towards: vec3f, surface: vec2f) -> vec3f {
    return point + max(conicoid_intersect(point, towards, surface.x, surface.y), 0.0) * towards;
}

// Irradiance by a lamp that is 1/`vergence` mm from where its light enters, over that by a distant one from the same side
// (`light`, unit), which is `concentrated` times its own across the beam; `n` is the index behind the surface. The beam of the
// distant one is narrowed alike in both of its principal sections.
fn near_concentration(concentrated: f32, entry: vec3f, point: vec3f, light: vec3f, surface: vec2f, n: f32, vergence: f32) -> f32 {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let path = distance(entry, point);
    let towards = (entry - point) / max(path, 1e-6);
    let outside = clamp(dot(light, normal), 0.05, 1.0);
    let inside = clamp(dot(towards, normal), 0.05, 1.0);
    let passed = 1.0 - fresnel_dielectric(outside, 1.0, n);
    // What is left of the beam's width along a principal section.
    let narrowed = clamp(sqrt(outside * passed * max(-towards.z, 0.0) / (inside * max(concentrated, 1e-3))), 0.2, 1.0);
    let spread = path * vergence / n;
    let slant = outside / inside;
    return narrowed * narrowed / ((narrowed + spread) * (narrowed + spread * slant * slant));
}

// Where light from the unit direction `light` before the cornea that reaches a place `height` mm before the plane of the table would cross
// that, mm; about, as a level cornea would turn it.
fn crosses_plane(at: vec2f, height: f32, light: vec3f, n: f32) -> vec2f {
    let slant = light.xy / n;
    return at - slant * (height * inverseSqrt(max(1.0 - dot(slant, slant), 0.1)));
}

// How a beam that has entered at `entry` converges at `point`, 1/mm, across the meridian and along it: the cornea focuses it (Coddington's
// equations, the plane of incidence taken for the meridian's). `vergence` (1/mm) is that of a near lamp.
fn beam_gathers(entry: vec3f, point: vec3f, light: vec3f, surface: vec2f, n: f32, vergence: f32) -> vec2f {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let path = distance(entry, point);
    let towards = (entry - point) / max(path, 1e-6);
    let outside = clamp(dot(light, normal), 0.05, 1.0);
    let inside = clamp(dot(towards, normal), 0.05, 1.0);
    // Radii of curvature across the meridian and along it.
    let across = sqrt(surface.x * surface.x + (1.0 - surface.y) * dot(entry.xy, entry.xy));
    let along = across * across * across / (surface.x * surface.x);
    let power = n * inside - outside;
    let sagittal = (power / across - vergence) / n;
    let tangential = (power / along - vergence * outside * outside) / (n * inside * inside);
    let focus = vec2f(sagittal, tangential);
    // Light that found no entry has no way of its own.
    return select(vec2f(0.0), focus / max(1.0 - focus * path, vec2f(0.2)), path > 1e-6);
}

// How many times as strong a beam that converges so (1/mm, `beam_gathers`) is `way` mm on, and by which share of itself (1/mm) it grows
// there.
fn beam_on(converges: vec2f, way: f32) -> vec2f {
    let left = max(1.0 - converges * way, vec2f(0.3));
    return vec2f(1.0 / (left.x * left.y), dot(converges, 1.0 / left));
}

// A lamp (its direction in the eye frame) as it is where its light to `point` of the iris enters the cornea, with the light that
// its own beam brings there instead of a distant one's. `apex` is the corneal one's place from the globe's centre; `n`, `surface`
// are the cornea's, the rest is the table's.
fn iris_near_lamp(table: texture_2d<f32>, linear: sampler, own: Lamp, apex: vec3f, point: vec3f, surface: vec2f, n: f32, root_mm: f32, limbus_mm: f32) -> Lamp {
    var lamp = lamp_from(own, apex);
    var entry = vec3f(0.0);
    var light = vec3f(0.0);
    var concentrated = 0.0;
    for (var again = 0; again < 2; again++) {
        light = lamp.direction;
        let arrives = iris_light(table, linear, light, point.xy, root_mm, limbus_mm);
        entry = light_entry(point, arrives.xyz, surface);
        concentrated = arrives.w;
        lamp = lamp_from(own, apex + entry);
    }
    lamp.color *= near_concentration(concentrated, entry, point, light, surface, n, lamp.vergence);
    return lamp;
}
