// Where to read a table of evenly spaced values. Twin: src/appearance/shading/knots.rs.
//
// A table that is handed to a function is copied there: on a software rasteriser two margins of 32 heights, read for each lamp, cost
// 80 of an eye's 188 ms. So whoever has the table reads it.

struct Knot { below: i32, part: f32 };

// The knot below this share (0 to 1) of a table of so many, and how far it is from there to the next.
fn knot_at(share: f32, knots: i32) -> Knot {
    let place = clamp(share, 0.0, 1.0) * f32(knots - 1);
    let below = min(i32(place), knots - 2);
    return Knot(below, place - f32(below));
}
