// Irradiance / pi of the lids' edges, lamps and all.
fn lids_lit() -> vec3<f32> {
    var light = ambient(LIDS_FACE);
    for (var i = 0; i < LAMPS; i++) {
        light += illumination.lamps[i].color * lids_take(illumination.lamps[i].direction);
    }
    return light;
}
