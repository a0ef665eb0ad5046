// The tear meniscus: a clear thread of fluid between lid margin and globe.
// Added to what lies below: only its reflections show.

struct Meniscus {
    // How strongly it mirrors (height of the meniscus against its mean).
    strength: f32,
    // What the lids' skin sends back.
    lids: vec3<f32>,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> meniscus: Meniscus;

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let v = normalize(in.camera - in.position);
    let n = normalize(in.normal);
    let footprint = footprint_at(distance(in.camera, in.position));
    let around = mirrored(in.position, reflect(-v, n), meniscus_blur(footprint));
    // How far below the upper lid's tears it is.
    let gap = in.tissue.r;
    // The lower lid does not hide what the thread on it mirrors, which looks up.
    let shade = LidShade(in.position.x, gap, 1e3);
    let radiance = meniscus_reflection(around, meniscus.lids * illumination.lids_lit, n, v, shade, footprint) * meniscus.strength;
    // Added in display space, so keep the tone curve's small-signal slope of one.
    return vec4(shown(radiance), 0.0);
}
