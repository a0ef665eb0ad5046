//! A user's own files: dropped, chosen, read beside the frames, and shown.

use super::state::UiState;
use crate::app::SessionCommand;
use crate::app::host::{self, Arrival};
use crate::app::own_files::{Own, OwnFile, Placement, read_own_files};
use crate::motion::MotionCommand;
use crate::scene::catalog::LoadedScene;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};
use std::sync::Arc;

/// What the user has brought.
#[derive(Resource, Default)]
pub struct OwnScene {
    /// The model's files, so that they can be read again in another unit.
    pub(super) model: Option<Arc<Vec<OwnFile>>>,
    /// The unit in which the model was read, m.
    pub(super) unit_m: Option<f32>,
    /// A file hovers over the window.
    pub(super) hovered: bool,
    reading: Option<Reading>,
}

struct Reading {
    files: Arc<Vec<OwnFile>>,
    placement: Placement,
    task: Task<Result<Own, String>>,
}

impl OwnScene {
    /// Is something being read?
    pub(super) fn is_busy(&self) -> bool {
        self.reading.is_some()
    }

    /// Reads these files beside the frames.
    pub(super) fn read(&mut self, files: Arc<Vec<OwnFile>>, placement: Placement) {
        let asked = files.clone();
        let task =
            AsyncComputeTaskPool::get().spawn(async move { read_own_files(&asked, &placement) });
        self.reading = Some(Reading {
            files,
            placement,
            task,
        });
    }
}

/// Files that were dropped on the window go the way of those that were chosen.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn drop_files(
    mut dropped: MessageReader<bevy::window::FileDragAndDrop>,
    mut own: ResMut<OwnScene>,
) {
    use bevy::window::FileDragAndDrop::{DroppedFile, HoveredFile, HoveredFileCanceled};
    let mut paths = Vec::new();
    for event in dropped.read() {
        match event {
            DroppedFile { path_buf, .. } => {
                paths.push(path_buf.clone());
                own.hovered = false;
            }
            HoveredFile { .. } => own.hovered = true,
            HoveredFileCanceled { .. } => own.hovered = false,
        }
    }
    if !paths.is_empty() {
        bevy::tasks::IoTaskPool::get()
            .spawn(async move { host::read_paths(&paths) })
            .detach();
    }
}

/// Takes what has come in, and shows what has been read.
pub(super) fn receive(
    mut own: ResMut<OwnScene>,
    mut state: ResMut<UiState>,
    mut session_commands: MessageWriter<SessionCommand>,
    mut motion_commands: MessageWriter<MotionCommand>,
) {
    for arrival in host::take() {
        match arrival {
            Arrival::Files(files) => own.read(Arc::new(files), Placement::default()),
            Arrival::Said(sentence) => state.tell(sentence),
        }
    }
    let Some(mut reading) = own.reading.take() else {
        return;
    };
    match block_on(poll_once(&mut reading.task)) {
        None => own.reading = Some(reading),
        Some(Err(sentence)) => state.message = Some(sentence),
        Some(Ok(Own::Patient(patient))) => {
            state.message = None;
            state.held_pupil_mm = None;
            motion_commands.write(MotionCommand::Pupil(None));
            session_commands.write(SessionCommand::Patient(patient));
        }
        Some(Ok(Own::Scene(scene))) => {
            state.message = None;
            let is_model = matches!(scene, LoadedScene::Model(_));
            own.model = is_model.then_some(reading.files);
            own.unit_m = reading.placement.unit_m;
            session_commands.write(SessionCommand::Scene(Arc::new(scene)));
        }
    }
}
