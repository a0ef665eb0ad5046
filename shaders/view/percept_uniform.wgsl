// What every pass of the view reads. Keep in sync with src/percept/gpu_data.rs (240 bytes).
// View frame: +x right, +y up, looking along -z; image y runs down.
struct PerceptUniform {
    right: vec3<f32>,               // view +x in the world
    tan_half_fov_x: f32,            // tangent of half the horizontal field
    up: vec3<f32>,                  // view +y in the world
    tan_half_fov_y: f32,            // tangent of half the vertical field
    back: vec3<f32>,                // view +z in the world
    near_m: f32,                    // near plane
    eye_m: vec3<f32>,               // eye minus the field's origin
    voxel_size_m: f32,              // side of the voxels; 0: by distance
    fixation: vec3<f32>,            // unit direction in the view frame
    focus_vergence_d: f32,
    size: vec2<u32>,                // view, pixels
    supersampling: u32,             // scene texels a view pixel, along each axis
    slot_mask: u32,                 // slots in the voxel table minus one
    epoch: u32,                     // blinks, counted round from 0 to 15
    starve_steps: u32,              // R(now) in 1/4096
    rebase_steps: u32,              // for `rebase` only
    fast_threshold: u32,            // 0..=255
    pupil_m: f32,
    refraction_d: f32,
    neural_floor_rad: f32,
    eccentricity_e2_rad: f32,
    coc_cap_rad: f32,               // blur of what was not seen since the last blink
    pixels_per_radian: f32,         // at the middle of the view
    voxel_angle_rad: f32,
    exposure: f32,
    target_size: vec2<f32>,         // of the image that `present` draws, pixels
    marker: vec2<f32>,              // fixation marker, target pixels from the top left
    marker_radius_px: f32,          // 0: no marker
    upper_lid_mm: f32,              // its edge above the middle of the pupil
    upper_lid_ahead_mm: f32,        // and before it
    lower_lid_mm: f32,
    lower_lid_ahead_mm: f32,
    max_taps: u32,
    candidate_capacity: u32,
    eccentricity_penalty: f32,      // lost field: rad of blur per rad of eccentricity
    loss_blur_rad: f32,             // lost field: blur where the field is lost
    loss_darkening: f32,            // lost field: fraction of light missing where lost
    loss_desaturation: f32,         // lost field: fraction of colour missing where lost
    field_half_width_rad: f32,      // lost field: half the side of the visual-field map
    luma_exposure: f32,             // scene radiance that FAST calls white is 1 / this
    table_slots_old: u32,           // for `grow_table` only
    display_referred: u32,          // 1: the picture holds a display's colours, no shoulder
    j0_d: f32,                      // cross cylinder at 0 and 90 degrees in the view (+x right, +y up)
    j45_d: f32,                     // and at 45 and 135 degrees
};

@group(0) @binding(0) var<uniform> percept: PerceptUniform;
