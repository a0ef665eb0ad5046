//! The patient's numbers as sliders, from the table of a patient file's fields, and her conditions.

use super::super::state::{Controlled, UiState};
use crate::anatomy::Laterality;
use crate::conditions::{Condition, with_conditions};
use crate::patients::{FIELDS, Field, PatientFile};
use crate::stage::SessionCommand;
use bevy_egui::egui::{self, Ui};

/// Which eyes the sliders are about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Chosen(Option<Laterality>);

impl Chosen {
    const ALL: [Self; 3] = [
        Self(None),
        Self(Some(Laterality::OD)),
        Self(Some(Laterality::OS)),
    ];

    fn name(self) -> &'static str {
        match self.0 {
            None => "both eyes",
            Some(Laterality::OD) => "right eye",
            Some(Laterality::OS) => "left eye",
        }
    }
}

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
        let chosen = choose_eye(ui, state);
        // The one that leads stands for both.
        let mut one = wanted.of_eye(chosen.0.unwrap_or(wanted.eye));
        let before = one.clone();
        let mut settled = conditions(ui, state, &mut one);
        for remark in remarks(ui, &one) {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{remark}."));
        }
        ui.add_space(4.0);
        for field in FIELDS.iter().filter(|field| field.name != "pupil") {
            if field.name == "look_iris_brightness" {
                ui.add_space(6.0);
                ui.strong("Artist's choices")
                    .on_hover_text("what programs for drawing eyes offer; none of it is anatomy");
            }
            if field.per_eye || chosen.0.is_none() {
                settled |= slider(ui, field, &mut one);
            }
        }
        if one != before {
            wanted = wanted.with_change(chosen.0, |eye| take_changes(eye, &before, &one));
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

/// What should be known of a patient, worked out when she has changed: a visual field takes its time.
fn remarks(ui: &Ui, patient: &PatientFile) -> Vec<String> {
    let id = egui::Id::new("remarks on the patient");
    let known = ui.data(|data| data.get_temp::<(PatientFile, Vec<String>)>(id));
    if let Some((of, remarks)) = known
        && of == *patient
    {
        return remarks;
    }
    let remarks = patient.remarks();
    ui.data_mut(|data| data.insert_temp(id, (patient.clone(), remarks.clone())));
    remarks
}

/// Both eyes, or one of them.
fn choose_eye(ui: &mut Ui, state: &mut UiState) -> Chosen {
    let id = egui::Id::new("eyes being changed");
    let mut chosen = ui
        .data(|data| data.get_temp::<Chosen>(id))
        .unwrap_or_default();
    ui.horizontal(|ui| {
        for one in Chosen::ALL {
            let button = ui.selectable_value(&mut chosen, one, one.name());
            state.places.insert(one.name(), button.rect);
        }
    });
    ui.data_mut(|data| data.insert_temp(id, chosen));
    chosen
}

/// Gives an eye what was changed between two states of another, and nothing else of it.
fn take_changes(eye: &mut PatientFile, before: &PatientFile, after: &PatientFile) {
    for field in FIELDS {
        let (was, is) = ((field.get)(before), (field.get)(after));
        if let Some(value) = is
            && was != is
        {
            (field.set)(eye, value);
        }
    }
    take_changed_conditions(eye, before, after);
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
    let slider = labelled(ui, slider.max_decimals(3), field.meaning).on_hover_text(field.name);
    if slider.changed() {
        (field.set)(wanted, value);
    }
    // Lenses are changed at once, whatever is built.
    let is_quick = matches!(field.name, "sphere_d" | "cylinder_d" | "axis_deg")
        || (field.name.starts_with("look_") && !field.name.starts_with("look_flush"));
    is_settled(&slider) || (is_quick && slider.changed())
}

/// A slider below its label, which takes as many lines as it needs: beside it a long one would widen the
/// controls.
fn labelled(ui: &mut Ui, slider: egui::Slider<'_>, label: &str) -> egui::Response {
    let label = ui.small(label);
    ui.add(slider).labelled_by(label.id)
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
        let (low, high) = control.range;
        // What may stand in place of others, until somebody sets it.
        let Some(mut value) = (control.get)(own) else {
            let asked = ui.button(format!("set {}", control.name.replace('_', " ")));
            if asked.on_hover_text(control.meaning).clicked() {
                (control.set)(own, 0.5 * (low + high));
                settled = true;
            }
            continue;
        };
        let slider = egui::Slider::new(&mut value, low..=high).max_decimals(1);
        let slider = labelled(ui, slider, control.meaning).on_hover_text(control.name);
        state.places.insert(control.name, slider.rect);
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
        fn take_changed_conditions(eye: &mut PatientFile, before: &PatientFile, after: &PatientFile) {
            $(if before.$name != after.$name { eye.$name = after.$name.clone(); })+
        }

        /// Every condition.
        fn conditions(ui: &mut Ui, state: &mut UiState, wanted: &mut PatientFile) -> bool {
            [$(condition::<$condition>(ui, state, stringify!($name), &mut wanted.$name)),+]
                .contains(&true)
        }
    };
}
with_conditions! { conditions! {} }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::Cataract;

    #[test]
    fn a_change_of_one_eye_leaves_the_other_as_it_was() {
        let file = PatientFile {
            eye: Laterality::OS,
            sphere_d: -1.0,
            ..PatientFile::default()
        };
        let change = |of: Option<Laterality>, file: &PatientFile, sphere_d: f64| {
            let before = file.of_eye(of.unwrap_or(file.eye));
            let after = PatientFile {
                sphere_d,
                cataract: Some(Cataract::nuclear(3.0)),
                ..before.clone()
            };
            file.with_change(of, |eye| take_changes(eye, &before, &after))
        };
        let [right, left] = Laterality::BOTH;
        for one in [right, left] {
            let changed = change(Some(one), &file, -3.0);
            assert_eq!(changed.of_eye(one).sphere_d, -3.0);
            assert!(changed.of_eye(one).cataract.is_some());
            assert_eq!(changed.of_eye(one.other()), file.of_eye(one.other()));
        }
        // Of two that differ only what was changed becomes alike.
        let mut differing = change(Some(right), &file, -3.0);
        differing.right.redness = Some(0.9);
        let both = change(None, &differing, -2.0);
        for eye in [right, left] {
            assert_eq!(both.of_eye(eye).sphere_d, -2.0);
        }
        assert_eq!(both.of_eye(right).redness, 0.9);
        assert_ne!(both.of_eye(left).redness, 0.9);
    }
}
