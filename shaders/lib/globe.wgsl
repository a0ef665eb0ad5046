// needs: conicoid.wgsl
//
// The outer surface of the globe: scleral sphere and corneal conicoid, joined smoothly at the
// limbus. Globe frame: origin at the centre of rotation (the sphere's centre), gaze along −z,
// millimetres. Twin: src/optics/globe.rs.

// Distance from the globe's centre to its surface along the unit `direction` of the globe frame.
// `cornea` = (apical radius, shape factor), `blend` = the height (mm) over which the two surfaces
// merge at the limbus.
fn globe_radius_along(direction: vec3f, sclera_radius: f32, cornea: vec2f, limbus_radius: f32, blend: f32) -> f32 {
    let apex = globe_apex_distance(sclera_radius, cornea, limbus_radius);
    let reach = conicoid_intersect(vec3f(0.0, 0.0, apex), direction, cornea.x, cornea.y);
    // The smooth maximum of two heights: polynomial, one derivative continuous.
    let overlap = max(blend - abs(reach - sclera_radius), 0.0);
    return max(reach, sclera_radius) + overlap * overlap / (4.0 * blend);
}

// Distance from the globe's centre to the corneal apex: the two surfaces meet at `limbus_radius`.
fn globe_apex_distance(sclera_radius: f32, cornea: vec2f, limbus_radius: f32) -> f32 {
    let sclera_depth = sqrt(max(sclera_radius * sclera_radius - limbus_radius * limbus_radius, 0.0));
    return sclera_depth + conicoid_sag(limbus_radius, cornea.x, cornea.y);
}
