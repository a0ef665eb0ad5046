//! What the passes of the view share with the CPU: the uniform, the sizes of textures, buffers and
//! dispatches, and the layout of the counters.
//!
//! Keep in sync with `shaders/view/percept_uniform.wgsl`, `features.wgsl` and `field`.

use crate::anatomy::USUAL_PUPIL_MM;
use bytemuck::{Pod, Zeroable};

/// Pixels along each side of a workgroup of the per-pixel passes.
pub const WORKGROUP: u32 = 8;
/// Pixels along each side of a workgroup of `read_blur`, which is also its tile.
pub const TILE: u32 = 16;
/// Slots of a workgroup of `rebase` and `grow_table`.
pub const SLOT_WORKGROUP: u32 = 64;
/// Corners that the candidate buffer holds, 16 bytes each.
pub const CANDIDATE_CAPACITY: u32 = 16_384;
/// Words of the feature counters: 0 listed, 1 corners after suppression, 2 lowest score listed,
/// from 4 the number of corners of each score 0..=255.
pub const FEATURE_COUNTERS: usize = 260;
/// Words of the table counters: 0 voxels in the table, 1 insertions that found no slot.
pub const TABLE_COUNTERS: usize = 4;
/// `rebase_steps` that makes `rebase` forget everything.
pub const FORGET: u32 = u32::MAX;
/// Largest workgroup count along one axis that every WebGPU device takes.
const MAX_GROUPS: u32 = 65_535;

/// The uniform of every pass of the view, 240 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PerceptUniform {
    /// View +x in the world (unit).
    pub right: [f32; 3],
    /// Tangent of half the horizontal field.
    pub tan_half_fov_x: f32,
    /// View +y in the world (unit).
    pub up: [f32; 3],
    /// Tangent of half the vertical field.
    pub tan_half_fov_y: f32,
    /// View +z in the world (unit), against the direction of looking.
    pub back: [f32; 3],
    /// Near plane, m.
    pub near_m: f32,
    /// Eye minus the field's origin, m. The origin is fixed for the life of the table.
    pub eye_m: [f32; 3],
    /// Side of the voxels, m; 0 for voxels in proportion to distance.
    pub voxel_size_m: f32,
    /// Unit direction of the fixation in the view's frame (+x right, +y up, looking along −z).
    pub fixation: [f32; 3],
    /// Vergence on which the eye is focused, D.
    pub focus_vergence_d: f32,
    /// Size of the view, pixels.
    pub size: [u32; 2],
    /// Scene texels a view pixel along each axis, ≥ 1.
    pub supersampling: u32,
    /// Slots of the voxel table (a power of two) minus one.
    pub slot_mask: u32,
    /// Blinks, counted round from 0 to 15 ([`super::sharpness_field::SharpnessClock::epoch`]).
    pub epoch: u32,
    /// Starvation now, in 1/4096 nat ([`super::sharpness_field::SharpnessClock::starve_steps`]).
    pub starve_steps: u32,
    /// Starvation before a rebase, or [`FORGET`]; read by `rebase` alone.
    pub rebase_steps: u32,
    /// FAST threshold, 0..=255.
    pub fast_threshold: u32,
    /// Pupil diameter, m.
    pub pupil_m: f32,
    /// Spectacle refraction, D.
    pub refraction_d: f32,
    /// Diameter of the blur of a perfectly focused fovea, rad (about one minute of arc).
    pub neural_floor_rad: f32,
    /// Eccentricity at which that blur has doubled, rad (about 2.5°).
    pub eccentricity_e2_rad: f32,
    /// Blur of what has not been seen since the last blink, rad; the largest blur shown.
    pub coc_cap_rad: f32,
    /// View pixels a radian at the middle of the view ([`pixels_per_radian`]).
    pub pixels_per_radian: f32,
    /// Largest angle that a voxel subtends at the field's origin, rad ([`default_voxel_angle_rad`]).
    pub voxel_angle_rad: f32,
    /// Factor on radiance before the output transform.
    pub exposure: f32,
    /// Size of the image that `present` draws into, pixels.
    pub target_size: [f32; 2],
    /// Fixation marker, target pixels from the top left corner.
    pub marker: [f32; 2],
    /// Radius of the marker's ring, target pixels; 0 draws none.
    pub marker_radius_px: f32,
    /// Edge of the upper lid above the middle of the entrance pupil, mm.
    pub upper_lid_mm: f32,
    /// And before it, mm.
    pub upper_lid_ahead_mm: f32,
    /// Edge of the lower lid above the middle of the entrance pupil, mm: below 0 where it is open.
    pub lower_lid_mm: f32,
    /// And before it, mm.
    pub lower_lid_ahead_mm: f32,
    /// Most taps a gather may take, ≥ 20 (48 is the quality limit, 20 the fast one).
    pub max_taps: u32,
    /// Corners that the candidate buffer holds.
    pub candidate_capacity: u32,
    /// Lost field: blur added per radian of eccentricity, rad/rad.
    pub eccentricity_penalty: f32,
    /// Lost field: blur where the field is wholly lost, rad.
    pub loss_blur_rad: f32,
    /// Lost field: fraction of the light missing where the field is wholly lost, 0..1.
    pub loss_darkening: f32,
    /// Lost field: fraction of the colour missing where the field is wholly lost, 0..1.
    pub loss_desaturation: f32,
    /// Lost field: half the side of the visual-field map, rad (40°).
    pub field_half_width_rad: f32,
    /// Factor on radiance before FAST's luma: white is 1/this.
    pub luma_exposure: f32,
    /// Slots of the old table; read by `grow_table` alone.
    pub table_slots_old: u32,
    /// 1 where the picture holds a display's colours already, as a photograph does: no shoulder.
    pub display_referred: u32,
    /// Cross cylinder with axes at 0 and 90° in the view (+x right, +y up), D.
    pub j0_d: f32,
    /// Cross cylinder with axes at 45 and 135° in the view, D.
    pub j45_d: f32,
    /// Fills the shader's struct.
    pub unused: [f32; 3],
}

const _: () = assert!(size_of::<PerceptUniform>() == 240);

impl Default for PerceptUniform {
    /// A healthy eye looking straight ahead at infinity, 320 × 320 over 60°.
    fn default() -> Self {
        let tan_half_fov = 30_f32.to_radians().tan();
        let pixels_per_radian = pixels_per_radian(320, tan_half_fov);
        Self {
            right: [1.0, 0.0, 0.0],
            tan_half_fov_x: tan_half_fov,
            up: [0.0, 1.0, 0.0],
            tan_half_fov_y: tan_half_fov,
            back: [0.0, 0.0, 1.0],
            near_m: 0.05,
            eye_m: [0.0; 3],
            voxel_size_m: 0.0,
            fixation: [0.0, 0.0, -1.0],
            focus_vergence_d: 0.0,
            size: [320; 2],
            supersampling: 1,
            slot_mask: table_slots(0, 320 * 320) - 1,
            epoch: 0,
            starve_steps: 0,
            rebase_steps: FORGET,
            fast_threshold: 20,
            pupil_m: 1e-3 * USUAL_PUPIL_MM as f32,
            refraction_d: 0.0,
            neural_floor_rad: (1.0_f32 / 60.0).to_radians(),
            eccentricity_e2_rad: 2.5_f32.to_radians(),
            coc_cap_rad: 2.0_f32.to_radians(),
            pixels_per_radian,
            voxel_angle_rad: default_voxel_angle_rad(pixels_per_radian),
            exposure: 1.0,
            target_size: [320.0; 2],
            marker: [0.0; 2],
            marker_radius_px: 0.0,
            upper_lid_mm: 4.6,
            upper_lid_ahead_mm: 1.7,
            lower_lid_mm: -5.0,
            lower_lid_ahead_mm: 1.8,
            max_taps: 48,
            candidate_capacity: CANDIDATE_CAPACITY,
            eccentricity_penalty: 0.0,
            loss_blur_rad: 0.0,
            loss_darkening: 0.0,
            loss_desaturation: 0.0,
            field_half_width_rad: 40_f32.to_radians(),
            luma_exposure: 1.0,
            table_slots_old: 0,
            display_referred: 0,
            j0_d: 0.0,
            j45_d: 0.0,
            unused: [0.0; 3],
        }
    }
}

/// What clouded media do to the light (struct `MediaUniform` of `shaders/view/present/media.wgsl`), 112 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MediaUniform {
    /// Share of the scattered light on each level of the veil's source
    /// ([`crate::optics::glare::Veil::kernel`]).
    pub weights: [[f32; 4]; 4],
    /// Transmittance, linear sRGB.
    pub transmittance: [f32; 3],
    /// Share of the light that is scattered.
    pub scattered: f32,
    /// Size of the source, texels ([`crate::optics::glare::VeilSource`]).
    pub source_size: [u32; 2],
    /// Texels of the source a radian in the middle.
    pub texels_per_radian: f32,
    /// Last level of the source that counts.
    pub last_level: u32,
    /// Share of the scattered light that stays where it is.
    pub near: f32,
    /// Nothing.
    pub unused: [f32; 3],
}

const _: () = assert!(size_of::<MediaUniform>() == 112);

/// View pixels along a side of a pixel of the veil.
pub const VEIL_SCALE: u32 = 2;

/// View pixels a radian at the middle of a view of `width_px` pixels whose half field has the
/// tangent `tan_half_fov`.
pub fn pixels_per_radian(width_px: u32, tan_half_fov: f32) -> f32 {
    width_px as f32 / (2.0 * tan_half_fov)
}

/// Voxel angle at which a voxel spans between one and two pixels: small enough that its edge does
/// not show, large enough that a head that turns finds the voxels it left.
pub fn default_voxel_angle_rad(pixels_per_radian: f32) -> f32 {
    2.0 / pixels_per_radian
}

/// Levels of the whole mip chain of a view, down to one texel.
pub fn mip_levels(width: u32, height: u32) -> u32 {
    width.max(height).max(1).ilog2() + 1
}

/// Workgroups of a per-pixel pass ([`WORKGROUP`], or [`TILE`] for `read_blur`).
pub fn pixel_groups(width: u32, height: u32, workgroup: u32) -> [u32; 2] {
    [width.div_ceil(workgroup), height.div_ceil(workgroup)]
}

/// Workgroups of `rebase` or `grow_table` over a table of `slots`.
pub fn slot_groups(slots: u32) -> [u32; 2] {
    let groups = slots.div_ceil(SLOT_WORKGROUP).max(1);
    let x = groups.min(MAX_GROUPS);
    [x, groups.div_ceil(x)]
}

/// Where a view is in the frame of its photograph (struct `PhotoUniform` of
/// `shaders/view/capture/capture_photo.wgsl`), 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PhotoUniform {
    /// View +x.
    pub right: [f32; 3],
    /// 0: the view is the photograph's own.
    pub has_moved: u32,
    /// View +y.
    pub up: [f32; 3],
    /// Distance of all of it, m; 0: by its map.
    pub flat_m: f32,
    /// View +z.
    pub back: [f32; 3],
    /// Of its distance, by how much a surface may step over one texel and still be one.
    pub step_share: f32,
    /// The eye, m.
    pub eye_m: [f32; 3],
    /// Nothing.
    pub unused: f32,
}

/// Slots (a power of two) that keep the table's load at or under 60 % when a view of `pixels` is
/// added to `occupied` voxels: a view adds at most one voxel a pixel. 12 bytes a slot.
pub fn table_slots(occupied: u32, pixels: u32) -> u32 {
    let wanted = (u64::from(occupied) + u64::from(pixels)) * 5 / 3 + 1;
    u32::try_from(wanted.clamp(1024, 1 << 30).next_power_of_two()).unwrap_or(1 << 30)
}

#[cfg(test)]
pub(in crate::percept) mod tests {
    use super::*;

    #[test]
    fn the_wgsl_struct_has_the_same_fields_in_the_same_places() {
        let wgsl = include_str!("../../shaders/view/percept_uniform.wgsl");
        let module = naga::front::wgsl::parse_str(wgsl).unwrap();
        let (members, span) = module
            .types
            .iter()
            .find_map(|(_, ty)| match &ty.inner {
                naga::TypeInner::Struct { members, span } => Some((members, *span)),
                _ => None,
            })
            .unwrap();
        assert_eq!(span as usize, size_of::<PerceptUniform>());
        let offset = |name: &str| {
            members
                .iter()
                .find(|m| m.name.as_deref() == Some(name))
                .unwrap_or_else(|| panic!("no {name}"))
                .offset as usize
        };
        macro_rules! same {
            ($($name:ident),* $(,)?) => {
                $(assert_eq!(offset(stringify!($name)), std::mem::offset_of!(PerceptUniform, $name));)*
            };
        }
        same!(
            right,
            tan_half_fov_x,
            up,
            tan_half_fov_y,
            back,
            near_m,
            eye_m,
            voxel_size_m,
            fixation,
            focus_vergence_d,
            size,
            supersampling,
            slot_mask,
            epoch,
            starve_steps,
            rebase_steps,
            fast_threshold,
            pupil_m,
            refraction_d,
            neural_floor_rad,
            eccentricity_e2_rad,
            coc_cap_rad,
            pixels_per_radian,
            voxel_angle_rad,
            exposure,
            target_size,
            marker,
            marker_radius_px,
            upper_lid_mm,
            upper_lid_ahead_mm,
            lower_lid_mm,
            lower_lid_ahead_mm,
            max_taps,
            candidate_capacity,
            eccentricity_penalty,
            loss_blur_rad,
            loss_darkening,
            loss_desaturation,
            field_half_width_rad,
            luma_exposure,
            table_slots_old,
            display_referred,
            j0_d,
            j45_d,
        );
        assert_eq!(members.len(), 44);
    }

    /// Members of a struct of a shader, where they are, and its size.
    pub(in crate::percept) fn laid_out(wgsl: &str, name: &str) -> (Vec<(String, usize)>, usize) {
        let (_, rest) = wgsl.split_once(&format!("struct {name} ")).unwrap();
        let (body, _) = rest.split_once("};").unwrap();
        let module = naga::front::wgsl::parse_str(&format!("struct {name} {body}}};")).unwrap();
        let (_, ty) = module.types.iter().last().unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else {
            panic!("no struct")
        };
        let member = |m: &naga::StructMember| (m.name.clone().unwrap(), m.offset as usize);
        (members.iter().map(member).collect(), *span as usize)
    }

    #[test]
    fn the_medias_numbers_are_in_the_same_places() {
        let wgsl = include_str!("../../shaders/view/present/media.wgsl");
        let (found, span) = laid_out(wgsl, "MediaUniform");
        macro_rules! same {
            ($($name:ident),*) => {
                vec![$((stringify!($name).to_owned(), std::mem::offset_of!(MediaUniform, $name))),*]
            };
        }
        assert_eq!(
            found,
            same!(
                weights,
                transmittance,
                scattered,
                source_size,
                texels_per_radian,
                last_level,
                near
            )
        );
        assert_eq!(span, size_of::<MediaUniform>());
    }

    #[test]
    fn a_photographs_numbers_are_in_the_same_places() {
        let wgsl = include_str!("../../shaders/view/capture/capture_photo.wgsl");
        let (found, span) = laid_out(wgsl, "PhotoUniform");
        macro_rules! same {
            ($($name:ident),*) => {
                vec![$((stringify!($name).to_owned(), std::mem::offset_of!(PhotoUniform, $name))),*]
            };
        }
        assert_eq!(
            found,
            same!(
                right, has_moved, up, flat_m, back, step_share, eye_m, unused
            )
        );
        assert_eq!(span, size_of::<PhotoUniform>());
    }

    #[test]
    fn a_first_view_fits_and_stays_under_sixty_percent() {
        for (occupied, pixels) in [(0, 320 * 320), (102_400, 320 * 320), (5, 1), (0, 4_000_000)] {
            let slots = table_slots(occupied, pixels);
            assert!(slots.is_power_of_two());
            assert!(f64::from(occupied + pixels) <= 0.6 * f64::from(slots));
        }
        assert_eq!(table_slots(0, 320 * 320), 262_144);
        assert_eq!(table_slots(u32::MAX, u32::MAX), 1 << 30);
    }

    #[test]
    fn groups_cover_every_pixel_and_slot() {
        assert_eq!(pixel_groups(1, 1, WORKGROUP), [1, 1]);
        assert_eq!(pixel_groups(321, 320, TILE), [21, 20]);
        let [x, y] = slot_groups(1 << 30);
        assert!(x <= MAX_GROUPS && y <= MAX_GROUPS);
        assert!(u64::from(x) * u64::from(y) * u64::from(SLOT_WORKGROUP) >= 1 << 30);
        assert_eq!(mip_levels(320, 200), 9);
        assert_eq!(mip_levels(1, 1), 1);
    }
}
