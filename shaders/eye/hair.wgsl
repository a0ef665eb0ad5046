// Lashes and brow hairs: dark fibres with the two highlights of Kajiya and Kay.

struct Hair {
    studio: Studio,
    // Colour at the root, linear sRGB; w unused.
    root: vec4<f32>,
    // Colour at the tip.
    tip: vec4<f32>,
};

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> hair: Hair;

@fragment
fn fragment(in: Surface) -> @location(0) vec4<f32> {
    let v = normalize(in.camera - in.position);
    // tissue: xyz the direction of the fibre, w 0 at the root and 1 at the tip.
    let along = normalize(in.tissue.xyz + vec3(0.0, 1e-5, 0.0));
    let color = mix(hair.root.rgb, hair.tip.rgb, in.tissue.w);
    let key = hair.studio.key_direction.xyz;
    let sine = sqrt(max(1.0 - dot(along, key) * dot(along, key), 0.0));
    let half_way = normalize(key + v);
    let s = sqrt(max(1.0 - dot(along, half_way) * dot(along, half_way), 0.0));
    var radiance = color * (hair.studio.key_color.rgb * (0.20 + 0.55 * sine) + 0.8 * studio_ambient(hair.studio, vec3(0.0, 0.3, -0.9)));
    radiance += hair.studio.key_color.rgb * (0.035 * pow(s, 60.0) + color * 0.35 * pow(s, 14.0));
    return vec4(output_transform(radiance, hair.studio.key_color.w), 1.0);
}
