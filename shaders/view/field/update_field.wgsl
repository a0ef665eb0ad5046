// A frame: how sharply every pixel is seen now, into its voxel, by one atomicMin.

@group(0) @binding(1) var view_vergence: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> pixel_slot: array<u32>;
@group(0) @binding(3) var<storage, read_write> sharpness_keys: array<atomic<u32>>;
#ifdef FIELD_LOSS
@group(#{FIELD_LOSS_GROUP}) @binding(0) var visual_field: texture_2d<f32>;
#endif

// Blur of a pixel at this moment: x its diameter, rad, of defocus, retina, and what disease adds, y its
// elongation.
fn blur_now(pixel: vec2<u32>) -> vec2<f32> {
    let ray = ray_of(pixel);
    let vergence = textureLoad(view_vergence, pixel, 0).x;
    let eccentricity = angle_between(ray, percept.fixation);
#ifdef ASTIGMATISM
    let error = percept.refraction_d + (vergence - percept.focus_vergence_d);
    let ellipse = astigmatic_blur(percept.pupil_m, error, length(vec2<f32>(percept.j0_d, percept.j45_d)));
    let defocus = ellipse.x;
#else
    let defocus = defocus_blur_angle(percept.pupil_m, vergence, percept.focus_vergence_d, percept.refraction_d);
#endif
    var neural = neural_blur(eccentricity, percept.neural_floor_rad, percept.eccentricity_e2_rad);
#ifdef FIELD_LOSS
    neural += percept.eccentricity_penalty * eccentricity;
    let seen = seen_fraction(visual_field, perimetric_angles(ray, percept.fixation));
    neural = combined_blur(neural, (1.0 - seen) * percept.loss_blur_rad);
#endif
    let all = combined_blur(defocus, neural);
    var elongation = 0.0;
#ifdef ASTIGMATISM
    // What else blurs is round.
    let share = defocus / max(all, 1e-12);
    elongation = share * share * ellipse.y;
#endif
    return vec2<f32>(min(all, percept.coc_cap_rad), elongation);
}

@compute @workgroup_size(8, 8)
fn update_field(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.xy;
    if any(pixel >= percept.size) {
        return;
    }
    let slot = pixel_slot[pixel.y * percept.size.x + pixel.x];
    if slot != NO_SLOT {
        let blur = blur_now(pixel);
        atomicMin(&sharpness_keys[slot], sharpness_key_encode(blur.x, blur.y, percept.starve_steps, percept.epoch));
    }
}
