//! The sharpness field: what was seen sharply since the last blink (Nießner et al. 2013, section 4).
//!
//! Once a view the voxel of every pixel is found; once a frame one `atomicMin` a pixel keeps the sharpest
//! that each was seen.

mod memory;
pub(super) mod movers;
pub mod sharpness_field;
mod table;

pub use memory::SharpnessField;
pub(super) use memory::remember;
pub(super) use table::{Memory, Table};

use super::capture::ViewImages;
use super::frame::CaptureRequest;
use super::gpu_data::{PerceptUniform, WORKGROUP, pixel_groups, slot_groups};
use super::pass::{ComputePass, EffectInputs, Effects, Recorder, view_numbers};
use crate::frame::shaders;
use bevy::render::render_resource::binding_types::{
    storage_buffer_read_only_sized, storage_buffer_sized, texture_2d,
};
use bevy::render::render_resource::{
    BindGroupEntries, BindGroupLayoutEntries, Buffer, BufferInitDescriptor, BufferUsages,
    PipelineCache, ShaderStages, TextureSampleType,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use movers::MoverData;

/// The passes of the memory.
pub(super) struct FieldPasses {
    assign_slots: ComputePass,
    forget_left: ComputePass,
    carry_over: [ComputePass; 2],
    grow_table: ComputePass,
    rebase: ComputePass,
    update: ComputePass,
}

impl Default for FieldPasses {
    fn default() -> Self {
        let texel = || texture_2d(TextureSampleType::Float { filterable: false });
        let reads = || storage_buffer_read_only_sized(false, None);
        let changes = || storage_buffer_sized(false, None);
        let plain = Effects::default();
        let blurs = Effects {
            field_loss: true,
            astigmatism: true,
            ..plain
        };
        let stage = ShaderStages::COMPUTE;
        let numbers = view_numbers;
        Self {
            assign_slots: ComputePass::new(
                "assign_slots",
                shaders::ASSIGN_SLOTS,
                plain,
                &BindGroupLayoutEntries::sequential(
                    stage,
                    (
                        numbers(),
                        texel(),
                        changes(),
                        changes(),
                        changes(),
                        changes(),
                        changes(),
                        reads(),
                    ),
                ),
            ),
            forget_left: ComputePass::new(
                "forget_left",
                shaders::FORGET_LEFT,
                plain,
                &BindGroupLayoutEntries::sequential(
                    stage,
                    (numbers(), texel(), changes(), changes(), reads()),
                ),
            ),
            carry_over: ["carry_over", "take_carried"].map(|name| {
                ComputePass::new(
                    name,
                    shaders::CARRY_OVER,
                    plain,
                    &BindGroupLayoutEntries::sequential(
                        stage,
                        (
                            numbers(),
                            texel(),
                            reads(),
                            changes(),
                            changes(),
                            numbers(),
                            texel(),
                            changes(),
                            reads(),
                        ),
                    ),
                )
            }),
            grow_table: ComputePass::new(
                "grow_table",
                shaders::GROW_TABLE,
                plain,
                &BindGroupLayoutEntries::sequential(
                    stage,
                    (
                        numbers(),
                        changes(),
                        changes(),
                        changes(),
                        changes(),
                        reads(),
                        reads(),
                        reads(),
                    ),
                ),
            ),
            rebase: ComputePass::new(
                "rebase",
                shaders::REBASE,
                plain,
                &BindGroupLayoutEntries::sequential(stage, (numbers(), changes())),
            ),
            update: ComputePass::new(
                "update_field",
                shaders::UPDATE_FIELD,
                blurs,
                &BindGroupLayoutEntries::sequential(
                    stage,
                    (numbers(), texel(), reads(), changes()),
                ),
            ),
        }
    }
}

impl FieldPasses {
    /// Asks for what every frame needs; says whether it is built.
    pub(super) fn frame_is_ready(&mut self, cache: &PipelineCache, effects: Effects) -> bool {
        self.update.is_ready(cache, effects) & self.rebase.is_ready(cache, effects)
    }

    /// Asks for what a capture needs; says whether it is built.
    pub(super) fn capture_is_ready(&mut self, cache: &PipelineCache) -> bool {
        let mut is_ready = true;
        let [carry, take] = &mut self.carry_over;
        for pass in [
            carry,
            take,
            &mut self.assign_slots,
            &mut self.forget_left,
            &mut self.grow_table,
            &mut self.rebase,
        ] {
            is_ready &= pass.is_ready(cache, Effects::default());
        }
        is_ready
    }

    /// Sets the keys of a table back, or forgets them, as the numbers in `uniform` say.
    pub(super) fn shift_keys(&mut self, uniform: &Buffer, table: &Table, recorder: &mut Recorder) {
        let entries = BindGroupEntries::sequential((
            uniform.as_entire_binding(),
            table.keys.as_entire_binding(),
        ));
        let groups = slot_groups(table.slots);
        self.rebase
            .run(recorder, &EffectInputs::default(), &entries, groups);
    }

    /// The voxel of every pixel of a view that has just been taken. `old` is the table that has become too
    /// small, `before` the view before it.
    pub(super) fn assign(
        &mut self,
        request: &CaptureRequest,
        memory: &Memory,
        old: Option<&Table>,
        (view, before): (&ViewImages, Option<&ViewImages>),
        queue: &RenderQueue,
        recorder: &mut Recorder,
    ) {
        let Some(table) = &memory.table else { return };
        let plain = EffectInputs::default();
        if old.is_some() || request.forget || memory.is_new() {
            self.shift_keys(&view.uniform, table, recorder);
        }
        if let Some(old) = old {
            let entries = BindGroupEntries::sequential((
                view.uniform.as_entire_binding(),
                table.tag.as_entire_binding(),
                table.home.as_entire_binding(),
                table.keys.as_entire_binding(),
                table.counters.as_entire_binding(),
                old.tag.as_entire_binding(),
                old.home.as_entire_binding(),
                old.keys.as_entire_binding(),
            ));
            self.grow_table
                .run(recorder, &plain, &entries, slot_groups(old.slots));
        }
        let movers = movers_buffer(recorder.device, &request.moved.here);
        let entries = BindGroupEntries::sequential((
            view.uniform.as_entire_binding(),
            &view.vergence_view,
            view.pixel_slot.as_entire_binding(),
            table.tag.as_entire_binding(),
            table.home.as_entire_binding(),
            table.keys.as_entire_binding(),
            table.counters.as_entire_binding(),
            movers.as_entire_binding(),
        ));
        let groups = pixel_groups(view.size.x, view.size.y, WORKGROUP);
        self.assign_slots.run(recorder, &plain, &entries, groups);
        if let Some(before) = before.filter(|_| !request.moved.left.is_empty()) {
            // In the table as it is now.
            let data = PerceptUniform {
                slot_mask: view.data.slot_mask,
                ..before.data
            };
            queue.write_buffer(&before.uniform, 0, bytemuck::bytes_of(&data));
            let left = movers_buffer(recorder.device, &request.moved.left);
            let entries = BindGroupEntries::sequential((
                before.uniform.as_entire_binding(),
                &before.vergence_view,
                table.tag.as_entire_binding(),
                table.keys.as_entire_binding(),
                left.as_entire_binding(),
            ));
            let groups = pixel_groups(before.size.x, before.size.y, WORKGROUP);
            self.forget_left.run(recorder, &plain, &entries, groups);
        }
        // Of what moved away nothing is left to be handed on.
        if let Some(before) = before.filter(|before| !request.forget && is_elsewhere(view, before))
        {
            let entries = BindGroupEntries::sequential((
                view.uniform.as_entire_binding(),
                &view.vergence_view,
                view.pixel_slot.as_entire_binding(),
                table.tag.as_entire_binding(),
                table.keys.as_entire_binding(),
                before.uniform.as_entire_binding(),
                &before.vergence_view,
                // The strengths have been read: their place is free.
                view.strengths.as_entire_binding(),
                before.pixel_slot.as_entire_binding(),
            ));
            for pass in &mut self.carry_over {
                pass.run(recorder, &plain, &entries, groups);
            }
        }
    }

    /// How sharply every pixel is seen now, into its voxel.
    pub(super) fn update(
        &mut self,
        uniform: &Buffer,
        view: &ViewImages,
        table: &Table,
        inputs: &EffectInputs,
        recorder: &mut Recorder,
    ) {
        let entries = BindGroupEntries::sequential((
            uniform.as_entire_binding(),
            &view.vergence_view,
            view.pixel_slot.as_entire_binding(),
            table.keys.as_entire_binding(),
        ));
        let groups = pixel_groups(view.size.x, view.size.y, WORKGROUP);
        if self.update.run(recorder, inputs, &entries, groups) {
            recorder.ledger.field_updates(1);
            recorder
                .ledger
                .field_pixels(u64::from(view.size.x) * u64::from(view.size.y));
        }
    }
}

/// Does a view look from elsewhere, elsewhither or at another size than the one before it? Else its pixels lie in the same voxels.
fn is_elsewhere(view: &ViewImages, before: &ViewImages) -> bool {
    let of = |view: &ViewImages| {
        let data = view.data;
        let tangents = [data.tan_half_fov_x, data.tan_half_fov_y];
        (
            data.size,
            data.eye_m,
            [data.right, data.up, data.back],
            tangents,
        )
    };
    of(view) != of(before)
}

/// What has moved, behind the number of it.
fn movers_buffer(device: &RenderDevice, movers: &[MoverData]) -> Buffer {
    let mut bytes = vec![0; 32];
    bytes[..4].copy_from_slice(&(movers.len() as u32).to_le_bytes());
    bytes.extend_from_slice(bytemuck::cast_slice(movers));
    // The list has room for one where there is none.
    bytes.resize(bytes.len().max(32 + size_of::<MoverData>()), 0);
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("movers"),
        contents: &bytes,
        usage: BufferUsages::STORAGE,
    })
}
