//! Gaze, pupil, lens and lid over the last seconds.

use super::Controlled;
use crate::motion::trace::TraceRow;
use bevy_egui::egui::{Color32, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};

/// Seconds shown.
const SPAN_S: f64 = 10.0;

/// Name, colour and value of a curve.
type Series = (&'static str, Color32, fn(&TraceRow) -> f64);

/// Draws the strip.
pub fn draw(ui: &mut Ui, controlled: &Controlled) {
    let Some(controller) = controlled.view.controller() else {
        return;
    };
    let now = controlled.clock.time_s;
    let series: [Series; 5] = [
        ("azimuth °", Color32::from_rgb(110, 170, 255), |row| {
            row.gaze_azimuth_deg
        }),
        ("elevation °", Color32::from_rgb(120, 220, 160), |row| {
            row.gaze_elevation_deg
        }),
        ("pupil mm", Color32::from_rgb(240, 200, 90), |row| {
            row.pupil_mm
        }),
        ("lens D", Color32::from_rgb(230, 120, 200), |row| {
            row.accommodation_d
        }),
        ("lid ×10", Color32::from_rgb(235, 120, 90), |row| {
            row.lid_aperture * 10.0
        }),
    ];
    // The names stand above the curves and not over them.
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        for (name, colour, value) in &series {
            let value = controller.strip().back().map(value);
            let value = value.map_or_else(String::new, |value| format!(" {value:.1}"));
            ui.label(
                RichText::new(format!("{name}{value}"))
                    .color(*colour)
                    .small(),
            );
        }
    });
    Plot::new("strip")
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_x(false)
        .include_x(now - SPAN_S)
        .include_x(now.max(SPAN_S * 0.01))
        .include_y(-12.0)
        .include_y(12.0)
        .x_axis_formatter(|mark, _| match mark.value {
            before if before < 0.0 => String::new(),
            time_s => format!("{time_s:.0} s"),
        })
        .height(ui.available_height())
        .show(ui, |plot| {
            for (name, color, value) in series {
                let points: PlotPoints<'_> = controller
                    .strip()
                    .iter()
                    .filter(|row| row.time_s >= now - SPAN_S)
                    .map(|row| [row.time_s, value(row)])
                    .collect();
                plot.line(Line::new(name, points).color(color).width(1.4));
            }
        });
}
