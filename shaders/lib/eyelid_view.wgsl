// What the lids leave of the view. Twin: src/percept/present/gather.rs.

// How far the anterior edge of a lid's margin stands before the posterior one, mm: the margin is about
// 2 mm thick.
const LID_MARGIN_MM: f32 = 2.0;

// Share of a disc of radius 1 that lies below a line at this height.
fn disc_below(height: f32) -> f32 {
    let u = clamp(height, -1.0, 1.0);
    return 0.5 + (asin(u) + u * sqrt(1.0 - u * u)) * 0.31830987;
}

// Share of the light of a direction that passes between the lids to a pupil of this radius (mm): the
// direction rises by `slope`; `upper` and `lower` are the posterior edges of the margins, mm up and
// ahead of the pupil's middle.
fn eyelid_transmission(slope: f32, upper: vec2<f32>, lower: vec2<f32>, pupil_mm: f32) -> f32 {
    let r = max(pupil_mm, 0.05);
    let thick = LID_MARGIN_MM * slope;
    let above = (upper.x - upper.y * slope - max(thick, 0.0)) / r;
    let below = (lower.x - lower.y * slope - min(thick, 0.0)) / r;
    return max(disc_below(above) - disc_below(below), 0.0);
}
