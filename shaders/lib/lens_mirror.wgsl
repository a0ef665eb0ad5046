// needs: conicoid.wgsl, snell.wgsl, fresnel.wgsl
//
// What the inner surfaces of the eye mirror: the second, third and fourth Purkinje images, by the exact
// path of the view ray through them. Optics frame: origin at the corneal apex, +z into the eye,
// millimetres. A surface is vec2(apical radius R, shape factor p). Twin: src/optics/lens_mirror.rs.

// The eye's surfaces; the back of the lens bulges into the eye.
struct MirrorEye {
    anterior: vec2f,
    posterior: vec2f,
    lens_front: vec2f,
    lens_back: vec2f,
    // Of the cornea; from its apex to the lens's; of the lens.
    thickness: f32,
    lens_depth: f32,
    lens_thickness: f32,
    n_cornea: f32,
    n_aqueous: f32,
    // That bends light as the whole lens does.
    n_lens: f32,
};

// Index of the cortex just behind the capsule, which is what reflects; the rest of a lens only bends.
const LENS_EDGE_INDEX: f32 = 1.3726;

struct LensMirrored {
    // Unit direction in which light leaves the eye, or would have to come from; zero where there is none.
    direction: vec3f,
    // Where it leaves the cornea.
    exit: vec3f,
    // Where it crosses the front of the lens on its way out, or is mirrored by the cornea.
    crossing: vec2f,
    // Reflectance of the surface that mirrors.
    share: f32,
};

// From a place in the cornea out of the eye.
fn mirror_exit(back: vec3f, dir: vec3f, eye: MirrorEye, crossing: vec2f, share: f32) -> LensMirrored {
    let t = conicoid_intersect(back, dir, eye.anterior.x, eye.anterior.y);
    let front = back + t * dir;
    let outside = snell_refract(dir, conicoid_normal(front, eye.anterior.x, eye.anterior.y), eye.n_cornea);
    let leaves = t >= 0.0 && outside.w > 0.5 && outside.z < 0.0;
    return LensMirrored(select(vec3f(0.0), outside.xyz, leaves), front, crossing, share);
}

// From a place before the lens out of the eye; what it crossed and by how much it is mirrored is handed on.
fn mirror_leave(start: vec3f, dir: vec3f, eye: MirrorEye, crossing: vec2f, share: f32) -> LensMirrored {
    let back_apex = vec3f(0.0, 0.0, eye.thickness);
    let s = conicoid_intersect(start - back_apex, dir, eye.posterior.x, eye.posterior.y);
    let back = start + s * dir;
    let inside = snell_refract(dir, conicoid_normal(back - back_apex, eye.posterior.x, eye.posterior.y), eye.n_aqueous / eye.n_cornea);
    var image = mirror_exit(back, inside.xyz, eye, crossing, share);
    image.direction = select(vec3f(0.0), image.direction, s >= 0.0 && inside.w > 0.5);
    return image;
}

// Light mirrored by the back of the cornea (II) along a ray in it, from its entry.
fn mirror_cornea(entry: vec3f, dir: vec3f, eye: MirrorEye) -> LensMirrored {
    let back_apex = vec3f(0.0, 0.0, eye.thickness);
    let s = conicoid_intersect(entry - back_apex, dir, eye.posterior.x, eye.posterior.y);
    let back = entry + s * dir;
    let normal = conicoid_normal(back - back_apex, eye.posterior.x, eye.posterior.y);
    let share = fresnel_dielectric(abs(dot(dir, normal)), eye.n_cornea, eye.n_aqueous);
    var image = mirror_exit(back, reflect(dir, normal), eye, back.xy, share);
    image.direction = select(vec3f(0.0), image.direction, s >= 0.0);
    return image;
}

// Light mirrored by the front of the lens (III) along a ray in the aqueous through `point`.
fn mirror_lens_front(point: vec3f, dir: vec3f, eye: MirrorEye) -> LensMirrored {
    let apex = vec3f(0.0, 0.0, eye.lens_depth);
    let start = point - 2.0 * dir;
    let t = conicoid_intersect(start - apex, dir, eye.lens_front.x, eye.lens_front.y);
    let hit = start + t * dir;
    let normal = conicoid_normal(hit - apex, eye.lens_front.x, eye.lens_front.y);
    let share = fresnel_dielectric(abs(dot(dir, normal)), eye.n_aqueous, LENS_EDGE_INDEX);
    var image = mirror_leave(hit, reflect(dir, normal), eye, hit.xy, share);
    image.direction = select(vec3f(0.0), image.direction, t >= 0.0);
    return image;
}

// Light mirrored by the back of the lens (IV) along a ray in the aqueous through `point`.
fn mirror_lens_back(point: vec3f, dir: vec3f, eye: MirrorEye) -> LensMirrored {
    let apex = vec3f(0.0, 0.0, eye.lens_depth);
    let start = point - 2.0 * dir;
    let t = conicoid_intersect(start - apex, dir, eye.lens_front.x, eye.lens_front.y);
    let hit = start + t * dir;
    let into = snell_refract(dir, conicoid_normal(hit - apex, eye.lens_front.x, eye.lens_front.y), eye.n_aqueous / eye.n_lens);
    // The back is a front that is seen from behind.
    let flip = vec3f(1.0, 1.0, -1.0);
    let back_apex = vec3f(0.0, 0.0, eye.lens_depth + eye.lens_thickness);
    let s = conicoid_intersect((hit - back_apex) * flip, into.xyz * flip, eye.lens_back.x, eye.lens_back.y);
    let back = hit + s * into.xyz;
    let normal = conicoid_normal((back - back_apex) * flip, eye.lens_back.x, eye.lens_back.y) * flip;
    let away = reflect(into.xyz, normal);
    let u = conicoid_intersect(back - apex, away, eye.lens_front.x, eye.lens_front.y);
    let again = back + u * away;
    let out = snell_refract(away, conicoid_normal(again - apex, eye.lens_front.x, eye.lens_front.y), eye.n_lens / eye.n_aqueous);
    let share = fresnel_dielectric(abs(dot(into.xyz, normal)), LENS_EDGE_INDEX, eye.n_aqueous);
    var image = mirror_leave(again, out.xyz, eye, again.xy, share);
    let found = t >= 0.0 && s >= 0.0 && u >= 0.0 && into.w * out.w > 0.5;
    image.direction = select(vec3f(0.0), image.direction, found);
    return image;
}
