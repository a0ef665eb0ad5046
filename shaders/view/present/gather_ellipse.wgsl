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

// A texel of a row: `along` is its place within the row, and which row.
fn row_texel(along: vec2<f32>, tall: bool, last: vec2<f32>, level: i32) -> vec4<f32> {
    return textureLoad(view_colour, vec2<i32>(clamp(select(along.yx, along, tall), vec2<f32>(0.0), last)), level);
}

// All texels alike. (Two by two in a bilinear tap is no faster where rows are three texels wide.)
fn gather_rows(rows: Rows, reach: vec2<f32>, texels: vec2<u32>, level: f32) -> Gathered {
    let last = vec2<f32>(texels) - 1.0;
    let mip = i32(level);
    let first = floor(rows.middle.y + 0.5);
    let deviation = sqrt(max(rows.variances.x, THREE_TEXELS_VARIANCE) / GAUSSIAN_WINDOW_VARIANCE);
    var out = Gathered(vec4<f32>(0.0), 0.0);
    for (var j = -reach.y; j <= reach.y; j += 1.0) {
        let down = first + j - rows.middle.y;
        let row = row_weight(down, rows.variances.y);
        let middle = rows.middle.x + rows.slope * down;
        let nearest = floor(middle + 0.5);
        if rows.variances.x <= THREE_TEXELS_VARIANCE {
            let before = row_weight(nearest - 1.0 - middle, rows.variances.x);
            let after = row_weight(nearest + 1.0 - middle, rows.variances.x);
            let one = row_texel(vec2<f32>(nearest - 1.0, first + j), rows.tall, last, mip);
            let two = row_texel(vec2<f32>(nearest, first + j), rows.tall, last, mip);
            let three = row_texel(vec2<f32>(nearest + 1.0, first + j), rows.tall, last, mip);
            let mean = before * one.rgb + (1.0 - before - after) * two.rgb + after * three.rgb;
            out.sum += row * vec4<f32>(mean, 1.0);
            out.nearest = max(out.nearest, max(max(one.a, two.a), three.a));
        } else {
            let begin = nearest - reach.x;
            let steps = gaussian_steps(begin - middle, deviation);
            var gaussian = steps.x;
            var factor = steps.y;
            for (var i = 0.0; i <= 2.0 * reach.x; i += 1.0) {
                let one = row_texel(vec2<f32>(begin + i, first + j), rows.tall, last, mip);
                let weight = row * gaussian_window(gaussian);
                out.sum += weight * vec4<f32>(one.rgb, 1.0);
                out.nearest = max(out.nearest, one.a);
                gaussian *= factor;
                factor *= steps.z;
            }
        }
    }
    return out;
}

// Every texel by itself, the nearer ones as far as their own blur reaches.
fn gather_rows_apart(rows: Rows, reach: vec2<f32>, pitch: vec2<f32>, texels: vec2<u32>, level: f32, at: vec2<f32>, vergence: f32, own: vec2<f32>) -> vec4<f32> {
    let last = vec2<f32>(texels) - 1.0;
    let first = floor(rows.middle.y + 0.5);
    let axis = axis_in_image();
    var sum = vec4<f32>(0.0);
    for (var j = -reach.y; j <= reach.y; j += 1.0) {
        let down = first + j - rows.middle.y;
        let row = row_weight(down, rows.variances.y);
        let middle = rows.middle.x + rows.slope * down;
        let nearest = floor(middle + 0.5);
        for (var i = -reach.x; i <= reach.x; i += 1.0) {
            let along = vec2<f32>(nearest + i, first + j);
            let texel = select(along.yx, along, rows.tall);
            let one = textureLoad(view_colour, vec2<i32>(clamp(texel, vec2<f32>(0.0), last)), i32(level));
            var weight = row * row_weight(nearest + i - middle, rows.variances.x);
            let near = nearness(one.a, vergence);
            if near > 0.0 {
                weight *= ellipse_share((texel + 0.5) * pitch, (texel - at) * pitch, axis, near, own);
            }
            sum += weight * vec4<f32>(one.rgb, 1.0);
        }
    }
    return sum;
}

fn gather_own(place: vec2<f32>, centre: vec4<f32>, blur: vec2<f32>) -> vec3<f32> {
    let own = ellipse_variances(blur.x, blur.y);
    let copied = 0.25 * COPY_DIAMETER_PX;
    if max(own.x, own.y) < copied * copied {
        return centre.rgb;
    }
    let level = min(ellipse_level(own), f32(textureNumLevels(view_colour) - 1u));
    let texels = max(percept.size >> vec2<u32>(u32(level)), vec2<u32>(1u));
    let pitch = vec2<f32>(percept.size) / vec2<f32>(texels);
    let at = place / pitch - 0.5;
    let rows = rows_of(own, level, at, axis_in_image());
    // On the last level, which a blur wider than the view asks for, every texel is the mean.
    let most = vec2<f32>(2.0 * ELLIPSE_ACROSS_MAX, ELLIPSE_ROWS_MAX);
    let reach = min(vec2<f32>(row_reach(rows.variances.x), row_reach(rows.variances.y)), most);
    let gathered = gather_rows(rows, reach, texels, level);
    var sum = gathered.sum;
    if nearness(gathered.nearest, centre.a) > 0.0 {
        sum = gather_rows_apart(rows, reach, pitch, texels, level, at, centre.a, own);
    }
    // All taps can be nearer and sharp: then the pixel keeps its own colour.
    let kept = 1e-3;
    return (sum.rgb + kept * centre.rgb) / (sum.a + kept);
}

// Light that a nearer tap spreads to an offset, per pixel. Narrower than the taps stand apart it would be
// drawn or not by chance.
fn spread_density(blur: vec2<f32>, off: vec2<f32>, spacing2: f32) -> f32 {
    let variances = max(ellipse_variances(blur.x, blur.y), vec2<f32>(0.25 * spacing2));
    let peak = 1.0 / (6.28318531 * sqrt(variances.x * variances.y));
    return peak * exp(ellipse_exponent(off, axis_in_image(), variances));
}
#endif
