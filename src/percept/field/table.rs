//! The voxel table of a view's memory on the GPU.

use super::super::gpu_data::{TABLE_COUNTERS, table_slots};
use super::super::resources::{STORAGE, buffer};
use bevy::render::render_resource::Buffer;
use bevy::render::renderer::RenderDevice;

/// The voxel table: one tag, home and key a slot.
pub(in crate::percept) struct Table {
    pub(in crate::percept) slots: u32,
    pub(in crate::percept) tag: Buffer,
    pub(in crate::percept) home: Buffer,
    pub(in crate::percept) keys: Buffer,
    pub(in crate::percept) counters: Buffer,
}

impl Table {
    pub(in crate::percept) fn new(device: &RenderDevice, slots: u32) -> Self {
        let words = u64::from(slots) * 4;
        Self {
            slots,
            tag: buffer(device, "voxel_tag", words, STORAGE),
            home: buffer(device, "voxel_home", words, STORAGE),
            keys: buffer(device, "sharpness_keys", words, STORAGE),
            counters: buffer(device, "table_counters", TABLE_COUNTERS as u64 * 4, STORAGE),
        }
    }
}

/// Slots of a memory above which it begins anew rather than grow: 12 bytes each, so 200 MB.
const MOST_SLOTS: u32 = 1 << 24;

/// What a view remembers.
#[derive(Default)]
pub(in crate::percept) struct Memory {
    pub(in crate::percept) table: Option<Table>,
    /// Voxels in the table at most.
    pub(in crate::percept) occupied: u32,
}

impl Memory {
    /// Nothing is remembered any more.
    fn clear(&mut self) {
        self.table = None;
        self.occupied = 0;
    }

    /// Is nothing in the table yet?
    pub(in crate::percept) fn is_new(&self) -> bool {
        self.occupied == 0
    }

    /// Slots of the table, less one.
    pub(in crate::percept) fn slot_mask(&self) -> u32 {
        self.table.as_ref().map_or(0, |table| table.slots - 1)
    }

    /// A table with room for another view of so many pixels; the old one, if its voxels have to move into
    /// it.
    pub(in crate::percept) fn make_room(
        &mut self,
        device: &RenderDevice,
        pixels: u32,
        forget: bool,
    ) -> Option<Table> {
        if forget {
            self.clear();
        }
        if table_slots(self.occupied, pixels) > MOST_SLOTS {
            // Who walks on and on forgets where she began.
            self.clear();
        }
        let slots = table_slots(self.occupied, pixels);
        match self.table.take() {
            Some(table) if table.slots >= slots => {
                self.table = Some(table);
                None
            }
            old => {
                self.table = Some(Table::new(device, slots));
                old
            }
        }
    }
}
