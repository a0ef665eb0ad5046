// Where a pixel of the view looks.

fn ray_of(pixel: vec2<u32>) -> vec3<f32> {
    let tan_half_fov = vec2<f32>(percept.tan_half_fov_x, percept.tan_half_fov_y);
    return view_ray(vec2<f32>(pixel) + 0.5, vec2<f32>(percept.size), tan_half_fov);
}

// Unit direction of a pixel in the world.
fn direction_of(pixel: vec2<u32>) -> vec3<f32> {
    let ray = ray_of(pixel);
    return ray.x * percept.right + ray.y * percept.up + ray.z * percept.back;
}
