#ifdef ASTIGMATISM
// The gather for an eye whose blur has a direction: every texel of an ellipse, row by row.

// Direction of the axis of the minus cylinder in the image, whose y runs down.
fn axis_in_image() -> vec2<f32> {
    let turn = 0.5 * atan2(-percept.j45_d, percept.j0_d);
    return vec2<f32>(cos(turn), sin(turn));
}

// Minus half the square of an offset (pixels) in units of these deviations along and across the axis.
fn ellipse_exponent(off: vec2<f32>, axis: vec2<f32>, variances: vec2<f32>) -> f32 {
    let along = dot(off, axis);
    let across = off.x * axis.y - off.y * axis.x;
    return -0.5 * (along * along / variances.x + across * across / variances.y);
}

// Share of its weight that a tap keeps, as `tap_share` does for discs.
fn ellipse_share(place: vec2<f32>, off: vec2<f32>, axis: vec2<f32>, near: f32, own: vec2<f32>) -> f32 {
    let blur = blur_at(place);
    let wider = max(own, vec2<f32>(1e-3));
    let narrow = clamp(ellipse_variances(blur.x, blur.y), min(vec2<f32>(0.09), wider), wider);
    return mix(1.0, exp(ellipse_exponent(off, axis, narrow) - ellipse_exponent(off, axis, wider)), near);
}

// Rows of texels: where their middles are, and how they are wide.
struct Rows {
    tall: bool,           // rows follow each other down the image, and else across it
    middle: vec2<f32>,    // of the kernel, texels, within a row and along the rows
    variances: vec2<f32>, // within a row and along the rows, texels^2
    slope: f32,           // texels by which a row's middle moves from row to row
};

fn rows_of(own: vec2<f32>, level: f32, at: vec2<f32>, axis: vec2<f32>) -> Rows {
    let left = ellipse_on_level(own, level);
    let mean = 0.5 * (left.x + left.y);
    let more = 0.5 * (left.x - left.y);
    // cos and sin of twice the axis.
    let turned = vec2<f32>(axis.x * axis.x - axis.y * axis.y, 2.0 * axis.x * axis.y);
    let across = more * turned.y;
    let tall = more * turned.x <= 0.0;
    let along = mean + abs(more * turned.x);
    let slope = across / max(along, 1e-9);
    let within = max(mean - abs(more * turned.x) - slope * across, 0.0);
    return Rows(tall, select(at.yx, at, tall), vec2<f32>(within, along), slope);
}

fn gather_own(place: vec2<f32>, centre: vec4<f32>, blur: vec2<f32>) -> vec3<f32> {
    let own = ellipse_variances(blur.x, blur.y);
    let copied = 0.25 * COPY_DIAMETER_PX;
    if max(own.x, own.y) < copied * copied {
        return centre.rgb;
    }
    let level = min(ellipse_level(own), f32(textureNumLevels(view_colour) - 1u));
    let texels = max(percept.size >> vec2<u32>(u32(level)), vec2<u32>(1u));
    let last = vec2<f32>(texels) - 1.0;
    let pitch = vec2<f32>(percept.size) / vec2<f32>(texels);
    let at = place / pitch - 0.5;
    let axis = axis_in_image();
    let rows = rows_of(own, level, at, axis);
    let reach = vec2<f32>(row_reach(rows.variances.x), row_reach(rows.variances.y));
    // On the last level, which a blur wider than the view asks for, every texel is the mean.
    let most = min(reach, vec2<f32>(2.0 * ELLIPSE_ACROSS_MAX, ELLIPSE_ROWS_MAX));
    let first = floor(rows.middle.y + 0.5);
    var sum = 1e-3 * vec4<f32>(centre.rgb, 1.0);
    for (var j = -most.y; j <= most.y; j += 1.0) {
        let down = first + j - rows.middle.y;
        let row = row_weight(down, rows.variances.y);
        let middle = rows.middle.x + rows.slope * down;
        let nearest = floor(middle + 0.5);
        for (var i = -most.x; i <= most.x; i += 1.0) {
            let along = vec2<f32>(nearest + i, first + j);
            let texel = select(along.yx, along, rows.tall);
            let one = textureLoad(view_colour, vec2<i32>(clamp(texel, vec2<f32>(0.0), last)), i32(level));
            var weight = row * row_weight(nearest + i - middle, rows.variances.x);
            let near = nearness(one.a, centre.a);
            if near > 0.0 {
                weight *= ellipse_share((texel + 0.5) * pitch, (texel - at) * pitch, axis, near, own);
            }
            sum += weight * vec4<f32>(one.rgb, 1.0);
        }
    }
    return sum.rgb / sum.a;
}

// Light that a nearer tap spreads to an offset, per pixel. Narrower than the taps stand apart it would be
// drawn or not by chance.
fn spread_density(blur: vec2<f32>, off: vec2<f32>, spacing2: f32) -> f32 {
    let variances = max(ellipse_variances(blur.x, blur.y), vec2<f32>(0.25 * spacing2));
    let peak = 1.0 / (6.28318531 * sqrt(variances.x * variances.y));
    return peak * exp(ellipse_exponent(off, axis_in_image(), variances));
}
#endif
