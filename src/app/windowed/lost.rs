//! When the graphics device goes away: the state is kept, and the app begins anew with it.

use bevy::prelude::*;
use bevy::render::error_handler::{ErrorType, RenderError, RenderErrorPolicy};

#[cfg(not(target_arch = "wasm32"))]
static FATE: std::sync::Mutex<Option<super::WindowError>> = std::sync::Mutex::new(None);

/// Why the window ended, if it was not closed.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn take() -> Option<super::WindowError> {
    let mut fate = FATE
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    fate.take()
}

/// A lost device ends the window with the link of what it showed, so that it can be opened again; in a
/// browser the page loads itself again. Bevy calls this each frame until the app has ended.
pub(super) fn on_render_error(
    error: &RenderError,
    main_world: &mut World,
    _: &mut World,
) -> RenderErrorPolicy {
    if main_world.contains_resource::<Reported>() {
        return RenderErrorPolicy::StopRendering;
    }
    main_world.insert_resource(Reported);
    let description = error
        .description
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    let is_lost = matches!(error.ty, ErrorType::DeviceLost);
    #[cfg(target_arch = "wasm32")]
    if is_lost {
        crate::ui::host::device_lost(&description);
    } else {
        crate::app::web::fail(&format!("Drawing failed: {description}"));
    }
    #[cfg(not(target_arch = "wasm32"))]
    {
        let fate = if is_lost {
            super::WindowError::DeviceLost {
                reason: description,
                link: crate::ui::link_of(main_world),
                own_scene: main_world
                    .get_resource::<crate::stage::Stage>()
                    .filter(|stage| crate::ui::is_own(&stage.scene))
                    .map(|stage| stage.scene.name().to_owned()),
            }
        } else {
            super::WindowError::Drawing(description)
        };
        *FATE
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner) = Some(fate);
        main_world.write_message(AppExit::error());
    }
    RenderErrorPolicy::StopRendering
}

/// The end has been reported.
#[derive(Resource)]
struct Reported;
