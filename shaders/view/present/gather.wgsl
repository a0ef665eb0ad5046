// The view as it is shown: a Gaussian gather as wide as each pixel's blur, lids, output transform.

@group(0) @binding(1) var view_colour: texture_2d<f32>;     // rgb linear radiance, a vergence in D
@group(0) @binding(2) var view_sampler: sampler;            // linear, mips nearest, clamp to edge
#ifdef ASTIGMATISM
@group(0) @binding(3) var<storage, read> blur_px: array<u32>; // bits of the diameter, the last seven of its elongation
#else
@group(0) @binding(3) var<storage, read> blur_px: array<f32>;
#endif
@group(0) @binding(4) var<storage, read> tile_near: array<vec2<f32>>;
#ifdef FIELD_LOSS
@group(#{FIELD_LOSS_GROUP}) @binding(0) var visual_field: texture_2d<f32>;
#endif
#ifdef MEDIA
@group(#{MEDIA_GROUP}) @binding(0) var veil: texture_2d<f32>;
@group(#{MEDIA_GROUP}) @binding(1) var<uniform> media: MediaUniform;
#endif

struct FullScreen {
    @builtin(position) position: vec4<f32>,
};

@vertex
fn fullscreen(@builtin(vertex_index) index: u32) -> FullScreen {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return FullScreen(vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0));
}

fn sample_view(place_px: vec2<f32>, level: f32) -> vec4<f32> {
    return textureSampleLevel(view_colour, view_sampler, place_px / vec2<f32>(percept.size), level);
}

// Diameter of the blur (pixels) and its elongation.
fn blur_at(place_px: vec2<f32>) -> vec2<f32> {
    let pixel = vec2<u32>(clamp(place_px, vec2<f32>(0.0), vec2<f32>(percept.size) - 1.0));
    let blur = blur_px[pixel.y * percept.size.x + pixel.x];
#ifdef ASTIGMATISM
    return vec2<f32>(bitcast<f32>(blur & 0xFFFFFF80u), elongation_decode(blur & 0x7Fu));
#else
    return vec2<f32>(blur, 0.0);
#endif
}

// 0 where a tap lies at the pixel's depth or behind, 1 where it is clearly nearer; a slanted
// surface's own slope stays below the ramp.
fn nearness(tap_vergence: f32, vergence: f32) -> f32 {
    return smoothstep(0.05, 0.15, (tap_vergence - vergence) / (tap_vergence + 0.2));
}

// What was gathered, and its weight, rgb and w; and the nearest vergence among it.
struct Gathered {
    sum: vec4<f32>,
    nearest: f32,
};

#ifndef ASTIGMATISM
// Share of its weight that a tap at `distance2` keeps for a pixel of this sigma: a nearer tap
// reaches only as far as its own blur does.
fn tap_share(place: vec2<f32>, distance2: f32, tap_vergence: f32, vergence: f32, sigma: f32) -> f32 {
    let near = nearness(tap_vergence, vergence);
    if near == 0.0 {
        return 1.0;
    }
    let tap_sigma = clamp(0.25 * blur_at(place).x, min(0.3, sigma), sigma);
    let shorter = 1.0 / (tap_sigma * tap_sigma) - 1.0 / (sigma * sigma);
    return mix(1.0, exp(-0.5 * distance2 * shorter), near);
}

// Where a gather stands: the place, in texels of its level, those texels, and what it is wide.
struct Gather {
    at: vec2<f32>,
    texels: vec2<u32>,
    level: f32,
    deviation: f32,
    pairs: u32,
};

// Two texels in one bilinear tap: x how far it lies beyond the first, y both weights, z and w the
// Gaussian and its factor (see `gaussian_steps`) two texels on.
fn pair(gaussian: f32, factor: f32, fall: f32) -> vec4<f32> {
    let first = gaussian_window(gaussian);
    let second = gaussian * factor;
    let both = first + gaussian_window(second);
    let next = factor * fall;
    return vec4<f32>(1.0 - first / max(both, 1e-20), both, second * next, next * fall);
}

// All texels alike, two by two in a tap.
fn gather_pairs(g: Gather) -> Gathered {
    // The pairs begin this far before the texel whose centre is at the place or before it.
    let begin = floor(g.at) - f32(g.pairs - 1u);
    let along_x = gaussian_steps(begin.x - g.at.x, g.deviation);
    let along_y = gaussian_steps(begin.y - g.at.y, g.deviation);
    let pitch = vec2<f32>(percept.size) / vec2<f32>(g.texels);
    var out = Gathered(vec4<f32>(0.0), 0.0);
    var first = begin;
    var row_steps = along_y.xy;
    for (var j = 0u; j < g.pairs; j++) {
        let row = pair(row_steps.x, row_steps.y, along_y.z);
        first.x = begin.x;
        var column_steps = along_x.xy;
        for (var i = 0u; i < g.pairs; i++) {
            let column = pair(column_steps.x, column_steps.y, along_x.z);
            let tap = sample_view((first + vec2<f32>(column.x, row.x) + 0.5) * pitch, g.level);
            out.sum += row.y * column.y * vec4<f32>(tap.rgb, 1.0);
            out.nearest = max(out.nearest, tap.a);
            column_steps = column.zw;
            first.x += 2.0;
        }
        row_steps = row.zw;
        first.y += 2.0;
    }
    return out;
}

// Four taps around the place.
fn gather_four(place: vec2<f32>, sigma: f32) -> Gathered {
    let a = sigma * sigma;
    var out = Gathered(vec4<f32>(0.0), 0.0);
    for (var k = 0u; k < 4u; k++) {
        let corner = 2.0 * vec2<f32>(f32(k & 1u), f32(k >> 1u)) - 1.0;
        let tap = sample_view(place + a * corner, 0.0);
        out.sum += vec4<f32>(tap.rgb, 1.0);
        out.nearest = max(out.nearest, tap.a);
    }
    return out;
}

// Weight of a texel at a distance along one axis: of four taps' bilinear feet, or of the window.
fn texel_weight(distance: f32, sigma: f32, deviation: f32) -> f32 {
    let a = sigma * sigma;
    let feet = max(1.0 - abs(distance - a), 0.0) + max(1.0 - abs(distance + a), 0.0);
    let u = distance / deviation;
    return select(gaussian_window(exp(-0.5 * u * u)), feet, sigma <= SMALL_DISC_SIGMA_PX);
}

// Every texel by itself, the nearer ones as far as their own blur reaches: a tap of two by two would
// keep or drop a texel for its neighbour's depth.
fn gather_apart(g: Gather, vergence: f32, sigma: f32) -> vec4<f32> {
    let pitch = vec2<f32>(percept.size) / vec2<f32>(g.texels);
    let begin = floor(g.at) - f32(g.pairs - 1u);
    var sum = vec4<f32>(0.0);
    for (var j = 0u; j < 2u * g.pairs; j++) {
        let y = begin.y + f32(j);
        let row = texel_weight(y - g.at.y, sigma, g.deviation);
        for (var i = 0u; i < 2u * g.pairs; i++) {
            let texel = vec2<f32>(begin.x + f32(i), y);
            let off = (texel - g.at) * pitch;
            let inside = clamp(texel, vec2<f32>(0.0), vec2<f32>(g.texels) - 1.0);
            let one = textureLoad(view_colour, vec2<i32>(inside), i32(g.level));
            let share = tap_share((texel + 0.5) * pitch, dot(off, off), one.a, vergence, sigma);
            let column = texel_weight(texel.x - g.at.x, sigma, g.deviation);
            sum += row * column * share * vec4<f32>(one.rgb, 1.0);
        }
    }
    return sum;
}

// Weighted mean around a place for its blur.
fn gather_own(place: vec2<f32>, centre: vec4<f32>, blur: vec2<f32>) -> vec3<f32> {
    let sigma = 0.25 * blur.x;
    let taps = gaussian_disc_taps(sigma, percept.max_taps);
    if taps == 0u {
        return centre.rgb;
    }
    var g = Gather(place - 0.5, percept.size, 0.0, 1.0, 2u);
    var gathered: Gathered;
    if sigma <= SMALL_DISC_SIGMA_PX {
        gathered = gather_four(place, sigma);
    } else {
        let level = gaussian_disc_level(sigma, gaussian_disc_budget(percept.max_taps));
        g.level = min(level, f32(textureNumLevels(view_colour) - 1u));
        // Not asked of the texture: llvmpipe answers every pixel of a block for the level of one.
        g.texels = max(percept.size >> vec2<u32>(u32(g.level)), vec2<u32>(1u));
        g.at = place * vec2<f32>(g.texels) / vec2<f32>(percept.size) - 0.5;
        g.deviation = gaussian_disc_deviation(sigma, g.level);
        // On the last level, which a blur wider than the view asks for, every texel is the mean.
        g.pairs = min(gaussian_disc_pairs(g.deviation), GAUSSIAN_PAIRS_MAX);
        gathered = gather_pairs(g);
    }
    var sum = gathered.sum;
    if nearness(gathered.nearest, centre.a) > 0.0 {
        sum = gather_apart(g, centre.a, sigma);
    }
    // All taps can be nearer and sharp: then the pixel keeps its own colour.
    let own = 1e-3;
    return (sum.rgb + own * centre.rgb) / (sum.a + own);
}

// Light that a nearer tap spreads to an offset, per pixel.
fn spread_density(blur: vec2<f32>, off: vec2<f32>, spacing2: f32) -> f32 {
    let variance = 0.0625 * blur.x * blur.x;
    return exp(-0.5 * dot(off, off) / variance) / (6.28318531 * variance);
}
#endif

// Largest blur of clearly nearer tiles around a place, as a sigma in pixels (0: none). Tiles are 16
// pixels wide, so a spread beyond 16 pixels (sigma 6.7) is cut.
fn near_sigma(place: vec2<f32>, vergence: f32) -> f32 {
    let tiles = (percept.size + 15u) / 16u;
    let tile = vec2<i32>(place / 16.0);
    var widest = 0.0;
    for (var k = 0; k < 9; k++) {
        let at = clamp(tile + vec2<i32>(k % 3, k / 3) - 1, vec2<i32>(0), vec2<i32>(tiles) - 1);
        let extremes = tile_near[u32(at.y) * tiles.x + u32(at.x)];
        widest = max(widest, select(0.0, extremes.x, nearness(extremes.y, vergence) > 0.0));
    }
    return min(0.25 * widest, 6.7);
}

// Blurred nearer surfaces over the pixel's own colour: each tap spreads its light over its own
// Gaussian, and what they cover is covered.
fn spread_near(place: vec2<f32>, centre: vec4<f32>, own: vec3<f32>, own_sigma: f32, sigma: f32) -> vec3<f32> {
    let taps = spread_taps(sigma, percept.max_taps);
    let level = spread_level(sigma, taps);
    let step2 = SPREAD_RADIUS * SPREAD_RADIUS * sigma * sigma / f32(taps);
    var covered = vec4<f32>(0.0);
    var distance2 = 0.5 * step2;
    var direction = vec2<f32>(1.0, 0.0);
    for (var k = 0u; k < taps; k++) {
        let at = place + direction * sqrt(distance2);
        let tap = sample_view(at, level);
        let near = nearness(tap.a, centre.a);
        let blur = blur_at(at);
        if near > 0.0 && 0.25 * blur.x > own_sigma {
            // The tap stands for an area of pi step2.
            let area = 3.14159265 * step2;
            let w = min(near * area * spread_density(blur, at - place, area), 1.0);
            covered += w * vec4<f32>(tap.rgb, 1.0);
        }
        distance2 += step2;
        direction = vec2<f32>(
            GOLDEN_ANGLE_COS * direction.x - GOLDEN_ANGLE_SIN * direction.y,
            GOLDEN_ANGLE_SIN * direction.x + GOLDEN_ANGLE_COS * direction.y,
        );
    }
    let alpha = min(covered.a, 1.0);
    return mix(own, covered.rgb / max(covered.a, 1e-6), alpha);
}

// Linear radiance that reaches the retina from a place of the view.
fn retinal_radiance(place: vec2<f32>) -> vec3<f32> {
    let centre = sample_view(place, 0.0);
    let blur = blur_at(place);
    let sigma = 0.25 * blur.x;
    var colour = gather_own(place, centre, blur);
    let near = near_sigma(place, centre.a);
    if near > max(sigma, 0.5) {
        colour = spread_near(place, centre, colour, max(sigma, 0.5), near);
    }
#ifdef MEDIA
    let veiled = textureSampleLevel(veil, view_sampler, place / vec2<f32>(percept.size), 0.0).rgb;
    let scattered = media.near * colour + (1.0 - media.near) * veiled;
    colour = media.transmittance * mix(colour, scattered, media.scattered);
#endif
    return colour;
}

// What is seen of it.
fn seen_radiance(place: vec2<f32>) -> vec3<f32> {
    var colour = retinal_radiance(place);
#ifdef FIELD_LOSS
    let tan_half_fov = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    let ray = view_ray(place, vec2<f32>(percept.size), tan_half_fov);
    let lost = 1.0 - seen_fraction(visual_field, perimetric_angles(ray, percept.fixation));
    let grey = dot(colour, vec3<f32>(0.2126, 0.7152, 0.0722));
    colour = mix(colour, vec3<f32>(grey), lost * percept.loss_desaturation);
    colour *= 1.0 - lost * percept.loss_darkening;
#endif
    return colour;
}

// Light through closed lids: little, and red, because blood takes the rest.
const EYELID_TINT = vec3<f32>(0.010, 0.0016, 0.0008);

fn marker_coverage(position: vec2<f32>) -> f32 {
    let off = abs(length(position - percept.marker) - percept.marker_radius_px);
    return select(0.0, clamp(1.5 - off, 0.0, 1.0), percept.marker_radius_px > 0.0);
}

// Light through the lids from the whole view: the last level of the mips is its mean.
fn eyelid_glow() -> vec3<f32> {
    let mean = sample_view(0.5 * vec2<f32>(percept.size), 31.0).rgb;
    return EYELID_TINT * dot(mean, vec3<f32>(0.2126, 0.7152, 0.0722));
}

fn shown(radiance: vec3<f32>, position: vec2<f32>) -> vec4<f32> {
    // A photograph has been through its camera's shoulder.
    var colour = clamp(radiance * percept.exposure, vec3<f32>(0.0), vec3<f32>(1.0));
    if percept.display_referred == 0u {
        colour = output_transform(radiance, percept.exposure);
    }
#ifdef MEDIA
    // A veil is so smooth that the codes of a picture show as contours.
    colour = dithered(colour, position);
#endif
    return vec4<f32>(mix(colour, vec3<f32>(0.02, 0.85, 0.25), 0.85 * marker_coverage(position)), 1.0);
}

// Where a place of the panel lies in the view. Until a panel of another shape has a view of its own,
// the old one fills its height.
fn view_uv(position: vec2<f32>) -> vec2<f32> {
    let uv = position / percept.target_size;
    let size = vec2<f32>(percept.size);
    let wider = (percept.target_size.x * size.y) / (percept.target_size.y * size.x);
    return vec2<f32>(select(0.5 + (uv.x - 0.5) * wider, uv.x, wider == 1.0), uv.y);
}

@fragment
fn present(input: FullScreen) -> @location(0) vec4<f32> {
    let uv = view_uv(input.position.xy);
    if abs(uv.x - 0.5) > 0.5 {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let slope = (1.0 - 2.0 * uv.y) * percept.tan_half_fov_y;
    let upper = vec2<f32>(percept.upper_lid_mm, percept.upper_lid_ahead_mm);
    let lower = vec2<f32>(percept.lower_lid_mm, percept.lower_lid_ahead_mm);
    let open = eyelid_transmission(slope, upper, lower, 500.0 * percept.pupil_m);
    var radiance = (1.0 - open) * eyelid_glow();
    if open > 0.0 {
        radiance += open * seen_radiance(uv * vec2<f32>(percept.size));
    }
    return shown(radiance, input.position.xy);
}
