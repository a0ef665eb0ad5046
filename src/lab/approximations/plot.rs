//! A task as a picture: error against time, both logarithmic.
//!
//! Enters: a task. Leaves: an SVG 900 pixels wide. A circle is a method's root mean square error, the
//! dash above it its largest; filled circles, joined by a line, are those that no other beats in time
//! and root mean square error. A method has a colour, a setting a label. What has no error (where the
//! reference itself is a method) stands on a line of its own at the bottom, marked 0.

mod labels;

use super::pareto::front;
use super::rows::{ErrorRow, Task};
use labels::{Frame, Mark, place};
use std::fmt::Write;

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 22.0;
const BOTTOM: f64 = 54.0;
/// Title, then lines of the legend.
const TITLE: f64 = 34.0;
const LEGEND_LINE: f64 = 20.0;
/// Errors smaller than this count as rounding.
const ROUNDING: f64 = 1e-17;

/// Colours that the colour-blind tell apart (Okabe & Ito 2008), the darkest first.
const COLOURS: [&str; 9] = [
    "#0072b2", "#d55e00", "#009e73", "#aa3377", "#8a6d00", "#333333", "#56a0d3", "#b5179e",
    "#6a994e",
];

/// A logarithmic axis.
struct Axis {
    /// Decades at its ends.
    low: f64,
    high: f64,
    /// Pixels there.
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that holds all values, at least a decade long, its ends at whole decades or, where
    /// that wastes too much, at room for a label.
    fn new(values: impl Iterator<Item = f64>, [from, to]: [f64; 2], whole: bool) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values {
            let decade = value.max(1e-300).log10();
            (low, high) = (low.min(decade), high.max(decade));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if whole {
            (low, high) = ((low - 0.15).floor(), (high + 0.15).ceil());
        } else {
            (low, high) = (low - 0.15, high + 0.25);
        }
        if high - low < 1.0 {
            let middle = 0.5 * (low + high);
            (low, high) = (middle - 0.5, middle + 0.5);
        }
        Self {
            low,
            high,
            from,
            to,
        }
    }

    fn pixel(&self, value: f64) -> f64 {
        let share = (value.max(1e-300).log10() - self.low) / (self.high - self.low);
        self.from + share * (self.to - self.from)
    }

    /// Values with a grid line: decades, and 2 and 5 where there are few.
    fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = if self.high - self.low < 2.5 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        // No more than a dozen.
        let stride = ((self.high - self.low) / 12.0).ceil().max(1.0) as i32;
        let mut out = Vec::new();
        let mut decade = self.low.floor() as i32;
        while f64::from(decade) <= self.high {
            for step in steps {
                let at = f64::from(decade) + step.log10();
                if at >= self.low - 1e-9 && at <= self.high + 1e-9 {
                    out.push(step * 10.0_f64.powi(decade));
                }
            }
            decade += stride;
        }
        out
    }
}

/// Where a row's two errors stand on the vertical axis, and the place of those that vanish: the decade
/// below the least that does not, if there are any.
fn heights(rows: &[ErrorRow]) -> (Vec<[f64; 2]>, Option<f64>) {
    let errors = || rows.iter().flat_map(|row| [row.err_rms, row.err_max]);
    let least = errors()
        .filter(|error| *error > ROUNDING)
        .fold(f64::INFINITY, f64::min);
    let nothing = if least.is_finite() {
        10.0_f64.powf((least.log10() - 0.3).floor())
    } else {
        ROUNDING
    };
    let stand = |error: f64| if error > ROUNDING { error } else { nothing };
    let heights = rows
        .iter()
        .map(|row| [stand(row.err_rms), stand(row.err_max)])
        .collect();
    let vanish = errors().any(|error| error <= ROUNDING);
    (heights, vanish.then_some(nothing))
}

/// The plot of a task, as SVG.
pub fn plot(task: &Task) -> String {
    let mut methods: Vec<&str> = Vec::new();
    for row in &task.rows {
        if !methods.contains(&row.method.as_str()) {
            methods.push(&row.method);
        }
    }
    let legend = legend(&methods);
    let lines = legend.last().map_or(1.0, |(_, line, _)| line + 1.0);
    let top = TITLE + lines * LEGEND_LINE + 12.0;
    let (heights, nothing) = heights(&task.rows);
    let x = Axis::new(
        task.rows.iter().map(|row| row.ns_per_call),
        [LEFT, WIDTH - RIGHT],
        false,
    );
    let mut y = Axis::new(
        heights.iter().flatten().copied(),
        [HEIGHT - BOTTOM, top],
        true,
    );
    if let Some(nothing) = nothing {
        // There is nothing below it.
        y.low = (nothing.log10() - 0.4).max(y.low);
    }
    let mut svg = String::new();
    // Writing to a String cannot fail.
    let _ = draw(&mut svg, task, &legend, (&heights, nothing), &x, &y);
    svg
}

/// Methods with their place in the legend: x in pixels, line, and the method.
fn legend<'a>(methods: &[&'a str]) -> Vec<(f64, f64, &'a str)> {
    let (mut at, mut line) = (LEFT, 0.0);
    let mut out = Vec::new();
    for method in methods {
        let width = labels::width(method, 13.0) + 34.0;
        if at + width > WIDTH - RIGHT && at > LEFT {
            (at, line) = (LEFT, line + 1.0);
        }
        out.push((at, line, *method));
        at += width;
    }
    out
}

fn draw(
    svg: &mut String,
    task: &Task,
    legend: &[(f64, f64, &str)],
    (heights, nothing): (&[[f64; 2]], Option<f64>),
    x: &Axis,
    y: &Axis,
) -> std::fmt::Result {
    let colour = |method: &str| {
        let index = legend.iter().position(|(_, _, one)| *one == method);
        COLOURS[index.unwrap_or(0) % COLOURS.len()]
    };
    writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">"##
    )?;
    let title = escape(&task.title);
    writeln!(svg, "<title>{title}: error against time</title>")?;
    writeln!(
        svg,
        r##"<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>"##
    )?;
    writeln!(
        svg,
        r#"<text x="{LEFT}" y="23" font-size="16" font-weight="bold">{title}</text>"#
    )?;
    writeln!(
        svg,
        r##"<text x="{:.1}" y="23" font-size="12" text-anchor="end" fill="#555555">circle: RMS; dash: largest; filled and joined: beaten by none</text>"##,
        WIDTH - RIGHT
    )?;
    for (at, line, method) in legend {
        let height = TITLE + line * LEGEND_LINE + 10.0;
        writeln!(
            svg,
            r##"<circle cx="{:.1}" cy="{height:.1}" r="5" fill="{c}" stroke="{c}"/><text x="{:.1}" y="{:.1}" font-size="13">{}</text>"##,
            at + 6.0,
            at + 16.0,
            height + 4.5,
            escape(method),
            c = colour(method),
        )?;
    }
    axes(svg, task, nothing, x, y)?;

    let places: Vec<[f64; 3]> = task
        .rows
        .iter()
        .zip(heights)
        .map(|(row, [rms, largest])| [x.pixel(row.ns_per_call), y.pixel(*rms), y.pixel(*largest)])
        .collect();
    let front = front(&task.rows);
    let path: Vec<String> = front
        .iter()
        .map(|&i| format!("{:.1},{:.1}", places[i][0], places[i][1]))
        .collect();
    writeln!(
        svg,
        r##"<polyline points="{}" fill="none" stroke="#888888" stroke-width="1.5" stroke-dasharray="5 3"/>"##,
        path.join(" ")
    )?;
    let marks: Vec<Mark> = task
        .rows
        .iter()
        .zip(&places)
        .map(|(row, [x, rms, largest])| Mark {
            x: *x,
            y: *rms,
            top: *largest,
            label: row.parameter.clone(),
        })
        .collect();
    let frame = Frame {
        left: x.from,
        right: x.to,
        top: y.to,
        bottom: y.from,
    };
    for (index, ((row, mark), label)) in task
        .rows
        .iter()
        .zip(&marks)
        .zip(place(&marks, frame))
        .enumerate()
    {
        let c = colour(&row.method);
        let fill = if front.contains(&index) { c } else { "#ffffff" };
        writeln!(svg, "<g>")?;
        writeln!(
            svg,
            "<title>{} {}: {:.1} ns, {:.2e} RMS, {:.2e} largest ({}), {} bytes</title>",
            escape(&row.method),
            escape(&row.parameter),
            row.ns_per_call,
            row.err_rms,
            row.err_max,
            escape(&task.unit),
            row.bytes
        )?;
        writeln!(
            svg,
            r#"<path d="M{x:.1} {y:.1}V{t:.1}M{l:.1} {t:.1}h8" stroke="{c}" fill="none" opacity="0.7"/>"#,
            x = mark.x,
            y = mark.y,
            t = mark.top,
            l = mark.x - 4.0,
        )?;
        if let Some([from, to]) = label.leader {
            writeln!(
                svg,
                r##"<path d="M{:.1} {:.1}L{:.1} {:.1}" stroke="#999999" stroke-width="0.7"/>"##,
                from[0], from[1], to[0], to[1]
            )?;
        }
        writeln!(
            svg,
            r#"<circle cx="{:.1}" cy="{:.1}" r="4.5" fill="{fill}" stroke="{c}" stroke-width="1.6"/>"#,
            mark.x, mark.y
        )?;
        writeln!(
            svg,
            r##"<text x="{:.1}" y="{:.1}" font-size="{}" text-anchor="middle" fill="{c}" stroke="#ffffff" stroke-width="2.5" paint-order="stroke">{}</text>"##,
            0.5 * (label.rect.left + label.rect.right),
            label.rect.bottom - 3.0,
            labels::FONT_PX,
            escape(&mark.label)
        )?;
        writeln!(svg, "</g>")?;
    }
    writeln!(svg, "</svg>")
}

fn axes(
    svg: &mut String,
    task: &Task,
    nothing: Option<f64>,
    x: &Axis,
    y: &Axis,
) -> std::fmt::Result {
    for tick in x.ticks() {
        let at = x.pixel(tick);
        writeln!(
            svg,
            r##"<path d="M{at:.1} {:.1}V{:.1}" stroke="#e4e4e4"/><text x="{at:.1}" y="{:.1}" text-anchor="middle">{}</text>"##,
            y.from,
            y.to,
            y.from + 17.0,
            time(tick)
        )?;
    }
    if let Some(nothing) = nothing {
        let at = y.pixel(nothing);
        writeln!(
            svg,
            r##"<path d="M{:.1} {at:.1}H{:.1}" stroke="#bbbbbb" stroke-dasharray="2 3"/><text x="{:.1}" y="{:.1}" text-anchor="end">0</text>"##,
            x.from,
            x.to,
            x.from - 7.0,
            at + 4.0
        )?;
    }
    // Below the line of those without an error there is nothing to read off.
    let least = nothing.map_or(0.0, |nothing| 1.5 * nothing);
    for tick in y.ticks().into_iter().filter(|tick| *tick > least) {
        let at = y.pixel(tick);
        writeln!(
            svg,
            r##"<path d="M{:.1} {at:.1}H{:.1}" stroke="#e4e4e4"/><text x="{:.1}" y="{:.1}" text-anchor="end">{}</text>"##,
            x.from,
            x.to,
            x.from - 7.0,
            at + 4.0,
            power(tick)
        )?;
    }
    writeln!(
        svg,
        r##"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="none" stroke="#888888"/>"##,
        x.from,
        y.to,
        x.to - x.from,
        y.from - y.to
    )?;
    writeln!(
        svg,
        r#"<text x="{:.1}" y="{:.1}" text-anchor="middle" font-size="13">time of a call, one thread</text>"#,
        0.5 * (x.from + x.to),
        HEIGHT - 14.0
    )?;
    let middle = 0.5 * (y.from + y.to);
    writeln!(
        svg,
        r#"<text x="18" y="{middle:.1}" text-anchor="middle" font-size="13" transform="rotate(-90 18 {middle:.1})">error, {}</text>"#,
        escape(&task.unit)
    )
}

/// Nanoseconds in a unit that suits.
fn time(ns: f64) -> String {
    let units = [(1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns")];
    let (size, unit) = units
        .into_iter()
        .find(|(size, _)| ns >= size * 0.999)
        .unwrap_or((1.0, "ns"));
    let value = format!("{:.3}", ns / size);
    let value = value.trim_end_matches('0').trim_end_matches('.');
    format!("{value} {unit}")
}

/// A tick of the errors: 0.01 to 100 plain, else a power of ten.
fn power(value: f64) -> String {
    if (0.0099..=1001.0).contains(&value) {
        let text = format!("{value:.2}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let exponent = (value.log10() + 1e-9).floor();
    let digit = (value / 10.0_f64.powf(exponent)).round();
    let mut text = String::new();
    if digit != 1.0 {
        text = format!("{digit}·");
    }
    text + "10" + &superscript(exponent as i32)
}

fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let sign = if number < 0 { "⁻" } else { "" };
    let digits: String = number
        .unsigned_abs()
        .to_string()
        .bytes()
        .map(|digit| DIGITS[usize::from(digit - b'0')])
        .collect();
    format!("{sign}{digits}")
}

/// Text as XML holds it.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests;
