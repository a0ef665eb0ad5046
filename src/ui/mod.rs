//! The window's controls: plain functions of (&mut Ui, &mut state), drawn with egui.
//!
//! Enters: the state of session, clock and motion; a user's own files; a link. Leaves: commands to
//! them; nothing is changed behind their backs.

mod arrangement;
mod controls;
pub mod host;
mod link;
pub mod link_state;
mod own;
pub mod own_files;
mod pictures;
mod power;
mod save;
mod state;
mod strip;
mod touch;
mod walk;

#[cfg(not(target_arch = "wasm32"))]
pub use link::link_of;
pub use link::{StartState, is_own, session_of};
pub use own::OwnScene;
pub use save::Saved;
use state::Shown;
pub use state::{Controlled, GazeMode, UiState};

use crate::frame::EyeSystems;
use crate::patients::PRESETS;
use crate::patients::PatientFile;
use crate::stage::{Panels, SessionCommand};
use arrangement::{ControlsPlace, arrange, has_room, zoom_for};
use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;
#[cfg(target_arch = "wasm32")]
use bevy::time::common_conditions::on_real_timer;
use bevy_egui::egui::{self, LayerId, UiBuilder};
use bevy_egui::{
    EguiContexts, EguiInputSet, EguiPreUpdateSet, EguiPrimaryContextPass, EguiTextureHandle,
    EguiUserTextures,
};
use host::Clipboard;
use own_files::Placement;

/// What the controls ask of the machine.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Let the user choose files.
    ChooseFiles,
    /// Copy the link of what is shown.
    CopyLink,
    /// Save what is seen.
    Save(Saved),
    /// Read the user's own scene again, to stand like this.
    ReadAgain(Placement),
}

/// The window's controls.
pub struct UiPlugin;

impl Plugin for UiPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<UiState>()
            .init_resource::<StartState>()
            .init_resource::<OwnScene>()
            .init_resource::<link::StandStill>()
            .init_resource::<save::Saving>()
            .init_non_send::<Clipboard>()
            .add_message::<Request>()
            .add_systems(Startup, (register_pictures, link::start))
            .add_systems(
                Update,
                (
                    keyboard,
                    walk::walk,
                    own::receive,
                    power::save_power,
                    power::choose_quality,
                )
                    .before(EyeSystems::Sense),
            )
            .add_systems(
                Update,
                (state::describe_patient, state::look_for_something).after(EyeSystems::Sense),
            )
            .add_systems(
                Update,
                (handle_requests, save::finish, link::keep_promises)
                    .chain()
                    .after(EyeSystems::Sense)
                    .before(EyeSystems::Decide),
            )
            .add_systems(
                PreUpdate,
                touch::keep_short_taps
                    .after(EguiInputSet::WriteEguiEvents)
                    .before(EguiPreUpdateSet::BeginPass),
            )
            .add_systems(EguiPrimaryContextPass, draw);
        #[cfg(not(target_arch = "wasm32"))]
        app.add_systems(Update, own::drop_files.before(own::receive));
        #[cfg(target_arch = "wasm32")]
        app.init_resource::<link::Written>().add_systems(
            Update,
            (link::read_page, link::write_page)
                .chain()
                // Browsers bear with two changes a second.
                .run_if(on_real_timer(std::time::Duration::from_millis(500)))
                .after(EyeSystems::Show),
        );
    }
}

fn register_pictures(panels: Panels, mut textures: ResMut<EguiUserTextures>) {
    for panel in [panels.eye(), panels.view()] {
        textures.add_image(EguiTextureHandle::Strong(panel.image.clone()));
    }
}

/// Which built-in patient is shown, if it is one.
fn preset_shown(shown: &PatientFile) -> Option<usize> {
    PRESETS.iter().position(|preset| {
        crate::patients::load_patient(preset.name).is_ok_and(|patient| patient == *shown)
    })
}

#[expect(
    clippy::too_many_arguments,
    reason = "one argument a thing that is asked for"
)]
fn handle_requests(
    mut requests: MessageReader<Request>,
    mut saving: ResMut<save::Saving>,
    mut own: ResMut<OwnScene>,
    mut state: ResMut<UiState>,
    mut clipboard: NonSendMut<Clipboard>,
    app: Shown,
    mut commands: Commands,
    _main_thread: NonSendMarker,
) {
    for request in requests.read() {
        match *request {
            Request::ChooseFiles => host::choose_files(),
            Request::Save(saved) => saving.begin(saved, &app.panels, &mut commands),
            Request::ReadAgain(placement) => {
                if let Some(files) = own.files.clone() {
                    own.read(files, placement);
                }
            }
            Request::CopyLink => {
                let text = copied_link(&state, &app);
                match host::copy_text(&mut clipboard, &text) {
                    Ok(()) => state.notify(copied_notice(&app)),
                    Err(sentence) => state.message = Some(sentence),
                }
            }
        }
    }
}

/// Space: pause. R: restart. H: hide the controls. 1, 2, B: eye, view, both. Period: one step. M: marker.
fn keyboard(
    keys: Res<ButtonInput<KeyCode>>,
    mut contexts: EguiContexts,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
) {
    // Keys that are typed into a field are not commands.
    if contexts
        .ctx_mut()
        .is_ok_and(|context| context.egui_wants_keyboard_input())
    {
        return;
    }
    let clock = &mut controlled.clock;
    if keys.just_pressed(KeyCode::Space) {
        clock.paused = !clock.paused;
    }
    if keys.just_pressed(KeyCode::Period) {
        clock.paused = true;
        clock.steps += 1;
    }
    if keys.just_pressed(KeyCode::KeyR) {
        let seed = controlled.seed();
        controlled
            .session_commands
            .write(SessionCommand::Restart(seed));
    }
    if keys.just_pressed(KeyCode::KeyH) {
        state.toggle_controls = true;
    }
    if keys.just_pressed(KeyCode::KeyM) {
        let marker = controlled.view.options().marker;
        controlled.set_marker(!marker);
    }
    for (key, shown) in [
        (KeyCode::Digit1, [true, false]),
        (KeyCode::Digit2, [false, true]),
        (KeyCode::KeyB, [true, true]),
    ] {
        if keys.just_pressed(key) {
            controlled.panels.show(shown);
        }
    }
}

/// The text that a link button copies: the page's address, or a command line that shows the same.
fn copied_link(state: &UiState, app: &Shown) -> String {
    let fragment = link::current(state, app).to_fragment();
    #[cfg(target_arch = "wasm32")]
    return host::address(&fragment);
    #[cfg(not(target_arch = "wasm32"))]
    format!("ocularium --link '{fragment}'")
}

fn copied_notice(app: &Shown) -> String {
    let what = if cfg!(target_arch = "wasm32") {
        "The link is copied"
    } else {
        "A command line that shows this is copied"
    };
    if link::built_in(&app.stage.scene).is_some() {
        format!("{what}.")
    } else {
        format!("{what}; your own scene is not in it, as it stays on this machine.")
    }
}

fn draw(
    mut contexts: EguiContexts,
    mut state: ResMut<UiState>,
    mut controlled: Controlled,
    mut own: ResMut<OwnScene>,
    time: Res<Time<Real>>,
    mut styled: Local<Option<bool>>,
) -> Result {
    let pictures = [
        contexts.image_id(&controlled.panels.eye().image),
        contexts.image_id(&controlled.panels.view().image),
    ];
    let context = contexts.ctx_mut()?.clone();
    state.touch |= context.input(|input| input.any_touches());
    if *styled != Some(state.touch) {
        *styled = Some(state.touch);
        style(&context, state.touch);
    }
    state.measure(&controlled.ledger, &time);
    state.places.clear();
    keep_glyphs(&context);
    let size = context.viewport_rect().size();
    state.zoom = context.zoom_factor();
    let pixels_a_point = context.pixels_per_point() / state.zoom;
    let fitting = zoom_for(size * state.zoom, pixels_a_point);
    if state.fitted_zoom != fitting {
        // What the user has enlarged stays so until the window is another.
        state.fitted_zoom = fitting;
        context.set_zoom_factor(fitting);
    }
    let open = state.controls_open.unwrap_or_else(|| has_room(size));
    let open = open ^ std::mem::take(&mut state.toggle_controls);
    if open != has_room(size) || state.controls_open.is_some() {
        state.controls_open = Some(open);
    }
    let arrangement = arrange(size, open);
    let mut root = egui::Ui::new(
        context.clone(),
        "root".into(),
        UiBuilder::new()
            .layer_id(LayerId::background())
            .max_rect(context.viewport_rect()),
    );
    let mut panel = match arrangement.controls {
        ControlsPlace::Hidden => None,
        ControlsPlace::Right(width) => Some(
            egui::Panel::right("controls beside")
                .resizable(true)
                .default_size(width)
                .max_size(0.6 * size.x),
        ),
        ControlsPlace::Below(height) => Some(
            egui::Panel::bottom("controls below")
                .resizable(false)
                .exact_size(height),
        ),
    };
    if let Some(panel) = panel.take() {
        panel.show(&mut root, |ui| {
            controls::head(ui, &mut state);
            egui::ScrollArea::vertical().show(ui, |ui| {
                // The bar lies over what it scrolls.
                ui.set_max_width(ui.available_width() - 10.0);
                controls::draw(ui, &mut state, &mut controlled, &mut own);
            });
        });
    }
    if arrangement.strip {
        egui::Panel::bottom("strip")
            .resizable(true)
            .default_size(126.0)
            .max_size(0.5 * size.y)
            .show(&mut root, |ui| strip::draw(ui, &controlled));
    }
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE.fill(egui::Color32::from_rgb(12, 12, 13)))
        .show(&mut root, |ui| {
            pictures::draw(ui, &mut state, &mut controlled, pictures);
            pictures::notices(ui, &mut state, time.elapsed_secs_f64());
            if !open {
                pictures::open_button(ui, &mut state);
            }
            if own.hovered || own.is_busy() {
                pictures::own_file(ui, own.is_busy());
            }
        });
    Ok(())
}

/// Lays out every character that a reading may need, in every font that is used. One that is drawn for the
/// first time reaches the device a frame late, and until then there is a hole in its place: a number
/// without its sign.
fn keep_glyphs(context: &egui::Context) {
    const GLYPHS: &str =
        "0123456789.,:;-−+±×°%…·µ–()/<>\"'=abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    let fonts: Vec<egui::FontId> = context
        .global_style()
        .text_styles
        .values()
        .cloned()
        .collect();
    context.fonts_mut(|view| {
        for font in fonts {
            // Laid out once and kept while it is asked for in every frame.
            let _ = view.layout_no_wrap(GLYPHS.into(), font, egui::Color32::WHITE);
        }
    });
}

/// Dark, with text that is read in a bright room.
fn visuals() -> egui::Visuals {
    let mut visuals = egui::Visuals::dark();
    visuals.widgets.noninteractive.fg_stroke.color = egui::Color32::from_gray(190);
    visuals.weak_text_color = Some(egui::Color32::from_gray(150));
    visuals.error_fg_color = egui::Color32::from_rgb(255, 140, 130);
    // One picture of each glyph, not four by where in a pixel it begins: see `keep_glyphs`.
    visuals.text_options.subpixel_binning = false;
    visuals
}

fn style(context: &egui::Context, touch: bool) {
    touch::take_slow_taps(context);
    context.set_visuals(visuals());
    // A browser enlarges its pages itself.
    context.options_mut(|options| options.zoom_with_keyboard = cfg!(not(target_arch = "wasm32")));
    context.all_styles_mut(|style| {
        // A bar that only a resting pointer brings up does not say that there is more below.
        style.spacing.scroll.dormant_handle_opacity = 0.5;
        style.spacing.item_spacing = egui::vec2(6.0, if touch { 9.0 } else { 5.0 });
        style.interaction.selectable_labels = false;
        if touch {
            // A finger needs about 9 mm.
            style.spacing.interact_size.y = 34.0;
            style.spacing.button_padding = egui::vec2(10.0, 6.0);
            style.spacing.slider_width = 130.0;
            style.spacing.icon_width = 22.0;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::Color32;

    /// Relative luminance and contrast as in WCAG 2.2.
    fn contrast(one: Color32, other: Color32) -> f32 {
        let luminance = |colour: Color32| {
            let [r, g, b, _] = egui::Rgba::from(colour).to_array();
            0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05
        };
        let (one, other) = (luminance(one), luminance(other));
        one.max(other) / one.min(other)
    }

    #[test]
    fn every_text_stands_out_from_its_ground() {
        let visuals = visuals();
        // Black on white, by definition.
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-3);
        for (text, least) in [
            (visuals.text_color(), 7.0),
            (visuals.weak_text_color(), 4.5),
            (visuals.error_fg_color, 4.5),
            (visuals.warn_fg_color, 4.5),
        ] {
            for ground in [visuals.panel_fill, visuals.window_fill] {
                let found = contrast(text, ground);
                assert!(found >= least, "{text:?} on {ground:?}: {found}");
            }
        }
    }

    #[test]
    fn no_reading_waits_for_its_glyphs() {
        // Does a number of the second frame need the font's texture anew?
        let late = |kept: bool| {
            let context = egui::Context::default();
            context.set_visuals(visuals());
            let frame = |reading: &str| {
                let output = context.run_ui(egui::RawInput::default(), |ui| {
                    if kept {
                        keep_glyphs(ui.ctx());
                    }
                    ui.label(reading);
                    ui.monospace(reading);
                });
                !output.textures_delta.set.is_empty()
            };
            assert!(frame("0"), "the first frame brings the texture");
            frame("−21.7° µm 98.6 ×")
        };
        assert!(late(false), "the test sees nothing");
        assert!(!late(true));
    }
}
