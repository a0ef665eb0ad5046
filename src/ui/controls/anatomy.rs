//! The patient's numbers as sliders, from the table of a patient file's fields, and her conditions.

use super::super::state::{Controlled, UiState};
use crate::conditions::{Condition, with_conditions};
use crate::patients::{FIELDS, Field, PatientFile};
use crate::stage::SessionCommand;
use bevy_egui::egui::{self, Ui};

/// Draws the sliders of everything that a patient file may say.
pub fn anatomy(ui: &mut Ui, state: &mut UiState, controlled: &mut Controlled) {
    let header = egui::CollapsingHeader::new("Conditions and anatomy").show(ui, |ui| {
        let Some(shown) = controlled.patient() else {
            return;
        };
        // What is being dragged is kept until it is let go: some of it takes long to build.
        let id = egui::Id::new("patient being changed");
        let mut wanted = ui
            .data(|data| data.get_temp::<(PatientFile, PatientFile)>(id))
            .filter(|(before, _)| *before == shown)
            .map_or_else(|| shown.clone(), |(_, wanted)| wanted);
        let mut settled = conditions(ui, state, &mut wanted);
        ui.add_space(4.0);
        for field in FIELDS.iter().filter(|field| field.name != "pupil") {
            settled |= slider(ui, field, &mut wanted);
        }
        ui.data_mut(|data| data.insert_temp(id, (shown.clone(), wanted.clone())));
        if settled && wanted != shown && wanted.check("The patient").is_ok() {
            controlled
                .session_commands
                .write(SessionCommand::Change(Box::new(wanted)));
        } else if settled && let Err(error) = wanted.check("The patient") {
            state.message = Some(format!("{error}."));
            ui.data_mut(|data| data.remove::<(PatientFile, PatientFile)>(id));
        }
    });
    state.places.insert("anatomy", header.header_response.rect);
}

/// Is this number to be taken as it is now?
fn is_settled(slider: &egui::Response) -> bool {
    slider.drag_stopped() || slider.lost_focus() || (slider.changed() && !slider.dragged())
}

fn slider(ui: &mut Ui, field: &Field, wanted: &mut PatientFile) -> bool {
    let (low, high) = field.range;
    let Some(mut value) = (field.get)(wanted) else {
        // Worked out from something else, until somebody sets it.
        let asked = ui.button(format!("set {}", field.name.replace('_', " ")));
        if asked.on_hover_text(field.meaning).clicked() {
            (field.set)(wanted, 0.5 * (low + high));
            return true;
        }
        return false;
    };
    let unit = match field.unit {
        "" => String::new(),
        "°" | "′" => field.unit.into(),
        unit => format!(" {unit}"),
    };
    let slider = egui::Slider::new(&mut value, low..=high).suffix(unit);
    let slider = ui
        .add(slider.max_decimals(3).text(field.meaning))
        .on_hover_text(field.name);
    if slider.changed() {
        (field.set)(wanted, value);
    }
    // Lenses are changed at once, whatever is built.
    let is_quick = matches!(field.name, "sphere_d" | "cylinder_d" | "axis_deg");
    is_settled(&slider) || (is_quick && slider.changed())
}

/// One condition: whether she has it, and its numbers.
fn condition<C: Condition>(
    ui: &mut Ui,
    state: &mut UiState,
    name: &'static str,
    own: &mut Option<C>,
) -> bool {
    let mut has = own.is_some();
    let toggle = ui.checkbox(&mut has, C::TITLE);
    state.places.insert(name, toggle.rect);
    let mut settled = toggle.changed();
    if settled {
        *own = has.then(C::onset);
    }
    let Some(own) = own else {
        return settled;
    };
    for control in C::controls() {
        let mut value = (control.get)(own);
        let (low, high) = control.range;
        let slider = egui::Slider::new(&mut value, low..=high).max_decimals(1);
        let slider = ui
            .add(slider.text(control.name))
            .on_hover_text(control.meaning);
        if slider.changed() {
            (control.set)(own, value);
        }
        settled |= is_settled(&slider);
    }
    ui.weak(own.caption());
    settled
}

macro_rules! conditions {
    (conditions { $($name:ident: $condition:ty, $meaning:literal;)+ }) => {
        /// Every condition.
        fn conditions(ui: &mut Ui, state: &mut UiState, wanted: &mut PatientFile) -> bool {
            [$(condition::<$condition>(ui, state, stringify!($name), &mut wanted.$name)),+]
                .contains(&true)
        }
    };
}
with_conditions! { conditions! {} }
