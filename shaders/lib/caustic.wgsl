// needs: conicoid.wgsl, snell.wgsl, fresnel.wgsl, fermat.wgsl
//
// The caustic that the cornea throws on the iris. For a distant light of irradiance E₀ (on a
// plane across its beam) the irradiance of the iris plane at P is
//     E(P) = E₀ cos θ_K T(θ_K) / (|N_z| |J|),    J = det ∂(P_x, P_y)/∂(K_x, K_y),
// with K the entry point of the light (fermat.wgsl), N the corneal normal there and T the Fresnel
// transmittance; J comes from differentiating Snell's law. Optics frame, millimetres.
// Twin: src/optics/caustic.rs.

// Where |J| vanishes a point source focuses to a point; a real one, like the sun or a window, is
// wider than this floor.
const CAUSTIC_SMALLEST_JACOBIAN: f32 = 1e-3;

// det ∂(P_x, P_y)/∂(K_x, K_y): the area on the plane z = iris_z lit through a unit of
// cross-section of the cornea at the surface point `entry`. Negative past a focus; 0 where the
// light does not enter or its ray misses the plane.
fn caustic_jacobian(entry: vec3f, light_dir: vec3f, surface: vec2f, n: f32, iris_z: f32) -> f32 {
    let gradient = vec3f(entry.xy, surface.y * entry.z - surface.x);
    let inverse_length = inverseSqrt(max(dot(gradient, gradient), 1e-12));
    let normal = gradient * inverse_length;
    let cos_in = dot(light_dir, normal);
    let eta = 1.0 / n;
    let cos_out = sqrt(max(1.0 - eta * eta * (1.0 - cos_in * cos_in), 1e-12));
    let gain = eta * cos_in - cos_out;
    let ray = gain * normal - eta * light_dir;
    if cos_in <= 0.0 || ray.z <= 0.0 || gradient.z >= 0.0 {
        return 0.0;
    }
    // d(gain)/d(cos_in): the refracted ray is γ N − η L with γ = η cos_in − cos_out.
    let gain_slope = eta - eta * eta * cos_in / cos_out;
    let height = iris_z - entry.z;
    let per_z = 1.0 / ray.z;
    let surface_slope = -entry.xy / gradient.z;

    var columns = mat2x2f(1.0, 0.0, 0.0, 1.0);
    for (var axis = 0; axis < 2; axis++) {
        // How the gradient, the normal and the ray turn as K moves along this axis.
        let d_gradient = vec3f(columns[axis], surface.y * surface_slope[axis]);
        let d_normal = (d_gradient - normal * dot(normal, d_gradient)) * inverse_length;
        let d_ray = gain_slope * dot(light_dir, d_normal) * normal + gain * d_normal;
        let d_tangent = (d_ray.xy - ray.xy * (d_ray.z * per_z)) * per_z;
        columns[axis] += height * d_tangent - surface_slope[axis] * ray.xy * per_z;
    }
    return determinant(columns);
}

// Irradiance at the iris point whose light enters at `entry`, relative to E₀.
fn caustic_irradiance_at(entry: vec3f, light_dir: vec3f, surface: vec2f, n: f32, iris_z: f32) -> f32 {
    let normal = conicoid_normal(entry, surface.x, surface.y);
    let cos_in = dot(light_dir, normal);
    let jacobian = abs(caustic_jacobian(entry, light_dir, surface, n, iris_z));
    if cos_in <= 0.0 || jacobian == 0.0 {
        return 0.0;
    }
    let transmitted = 1.0 - fresnel_dielectric(cos_in, 1.0, n);
    return cos_in * transmitted / (abs(normal.z) * max(jacobian, CAUSTIC_SMALLEST_JACOBIAN));
}

// Irradiance of the iris plane at `iris_point`, relative to E₀; 0 where no light arrives. The
// limbus is not considered: to stop light there, solve fermat_entry, test its radius and call
// caustic_irradiance_at.
fn caustic_irradiance(iris_point: vec3f, light_dir: vec3f, surface: vec2f, n: f32) -> f32 {
    let entry = fermat_entry(iris_point, light_dir, surface, n, FERMAT_STEPS);
    if entry.w == 0.0 {
        return 0.0;
    }
    return caustic_irradiance_at(entry.xyz, light_dir, surface, n, iris_point.z);
}
