// What the lids leave of the view. Twin: src/percept/gather.rs.

// Transmitted fraction at height `v` (0 top, 1 bottom of the view) for a lid aperture of 0 (closed)
// to 1 (open). The lids are far inside the near point, so their edges are wide and soft; the upper
// lid does most of the travel.
fn eyelid_transmission(v: f32, aperture: f32) -> f32 {
    let a = clamp(aperture, 0.0, 1.0);
    let upper = mix(0.7, -0.2, a);
    let lower = mix(0.8, 1.2, a);
    let open = smoothstep(upper - 0.2, upper + 0.2, v) * (1.0 - smoothstep(lower - 0.2, lower + 0.2, v));
    return open * smoothstep(0.0, 0.1, a);
}
