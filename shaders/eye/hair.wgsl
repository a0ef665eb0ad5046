// Lashes and brow hairs: dark fibres with the two highlights of Kajiya and Kay.

struct Hair {
    // Colour at the root, linear sRGB.
    root: vec3<f32>,
    // Colour at the tip.
    tip: vec3<f32>,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> hair: Hair;

// Both edges of a ribbon stand on the hair's centre line: normal its chord, rest.x the half width, tissue.xyz its direction.
@vertex
fn vertex(in: VertexIn) -> Surface {
    let camera = camera_from(in.instance);
    let drawn = hair_drawn(in.rest.x, footprint_at(distance(in.position, camera)));
    let edge = hair_ribbon(in.position, in.tissue.xyz, in.normal, camera, drawn);
    var out = surface_at(in, edge, camera);
    // The fragment stage gets how wide the hair is, and how far aside of its middle it stands.
    out.rest = vec3(abs(in.rest.x), drawn, 0.0);
    return out;
}

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let v = normalize(in.camera - in.position);
    // tissue: xyz the direction of the fibre, w 0 at the root and 1 at the tip.
    let along = normalize(in.tissue.xyz + vec3(0.0, 1e-5, 0.0));
    let color = mix(hair.root, hair.tip, in.tissue.w);
    var radiance = hair_ambient(color, ambient(vec3(0.0, 0.3, -0.9)));
    for (var i = 0; i < LAMPS; i++) {
        let lamp = lamp_at(i, in.position);
        radiance += lamp.color * hair_lamp(color, along, v, lamp.direction);
    }
    let pixel = footprint_at(distance(in.camera, in.position));
    return vec4(shown(radiance), hair_coverage(in.rest.x, pixel, in.rest.y) * hair_rooted(in.tissue.w));
}
