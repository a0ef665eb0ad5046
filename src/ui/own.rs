//! A user's own files: dropped, chosen, read beside the frames, and shown.

use super::host::{self, Arrival};
use super::own_files::{Own, OwnFile, Placement, read_own_files};
use super::state::UiState;
use crate::motion::MotionCommand;
use crate::stage::SessionCommand;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};
use std::sync::Arc;

/// What the user has brought.
#[derive(Resource, Default)]
pub struct OwnScene {
    /// The scene's files, so that they can be read again in another unit.
    pub(super) files: Option<Arc<Vec<OwnFile>>>,
    /// How they were read.
    pub(super) placement: Placement,
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
    /// The scene that is shown at first was read from these files.
    pub fn of(files: Vec<OwnFile>, placement: Placement) -> Self {
        Self {
            files: Some(Arc::new(files)),
            placement,
            ..Self::default()
        }
    }

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
            Arrival::Said(sentence) => state.notify(sentence),
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
            own.files = Some(reading.files);
            own.placement = reading.placement;
            session_commands.write(SessionCommand::Scene(Arc::new(scene)));
        }
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::scene::catalog::LoadedScene;
    use bevy::window::FileDragAndDrop;
    use std::path::{Path, PathBuf};

    /// What is commanded, and what is said, after these files were dropped.
    fn dropped(paths: &[PathBuf]) -> (Vec<SessionCommand>, Option<String>) {
        let mut app = App::new();
        app.add_plugins(TaskPoolPlugin::default())
            .init_resource::<OwnScene>()
            .init_resource::<UiState>()
            .add_message::<FileDragAndDrop>()
            .add_message::<SessionCommand>()
            .add_message::<MotionCommand>()
            .add_systems(Update, (drop_files, receive).chain());
        let window = app.world_mut().spawn_empty().id();
        for path_buf in paths.iter().cloned() {
            app.world_mut()
                .write_message(FileDragAndDrop::DroppedFile { window, path_buf });
        }
        for _ in 0..1000 {
            app.update();
            let commands: Vec<_> = app
                .world_mut()
                .resource_mut::<Messages<SessionCommand>>()
                .drain()
                .collect();
            let state = app.world().resource::<UiState>();
            let notice = state.notice.as_ref().map(|(sentence, _)| sentence.clone());
            let said = state.message.clone().or(notice);
            if !commands.is_empty() || said.is_some() {
                return (commands, said);
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("nothing happened within ten seconds");
    }

    // One test: whatever arrives is for the window, and a process has one.
    #[test]
    fn files_that_are_dropped_are_shown_or_refused() {
        let data = |name: &str| {
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("tests/data")
                .join(name)
        };
        let (commands, _) = dropped(&[data("page.png")]);
        let [SessionCommand::Scene(scene)] = &commands[..] else {
            panic!("{} commands", commands.len());
        };
        assert!(matches!(**scene, LoadedScene::Photo(_)));
        assert_eq!(scene.name(), "page.png");
        let folder = tempfile::tempdir().expect("a folder");
        let patient = folder.path().join("ann.ron");
        std::fs::write(&patient, "(name: \"Ann\", sphere_d: -2.5)").expect("written");
        let (commands, _) = dropped(&[patient]);
        let [SessionCommand::Patient(patient)] = &commands[..] else {
            panic!("{} commands", commands.len());
        };
        assert_eq!((patient.name.as_str(), patient.sphere_d), ("Ann", -2.5));
        let (commands, said) = dropped(&[folder.path().join("gone.png")]);
        assert!(commands.is_empty());
        assert!(said.is_some_and(|sentence| sentence.contains("\"gone.png\" cannot be read")));
    }
}
