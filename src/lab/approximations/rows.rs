//! What is written down of a measurement: a row a method, a task a thing that is approximated.

use serde::{Deserialize, Serialize};

/// Stands for an error that is not a number or not finite: it survives squaring and JSON.
const WORTHLESS: f64 = 1e100;

/// One method at one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorRow {
    /// How.
    pub method: String,
    /// Its setting: steps, nodes, the size of a table. Free of commas.
    pub parameter: String,
    /// Bytes of the tables that it reads at run time; 0 for formulas.
    pub bytes: usize,
    /// Nanoseconds of a call.
    pub ns_per_call: f64,
    /// Largest error.
    pub err_max: f64,
    /// The error that 999 of 1000 cases do not exceed.
    pub err_p999: f64,
    /// Root mean square error.
    pub err_rms: f64,
}

impl ErrorRow {
    /// A row from the errors of all cases; none count as worthless.
    pub fn new(
        method: &str,
        parameter: impl ToString,
        bytes: usize,
        ns_per_call: f64,
        mut errors: Vec<f64>,
    ) -> Self {
        for error in &mut errors {
            *error = if error.is_finite() {
                error.abs()
            } else {
                WORTHLESS
            };
        }
        if errors.is_empty() {
            errors.push(WORTHLESS);
        }
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let err_rms = (squares / errors.len() as f64).sqrt();
        let err_max = errors.iter().copied().fold(0.0, f64::max);
        // The smallest error with at most a thousandth of the cases above it.
        let place = errors.len() - 1 - errors.len() / 1000;
        let (_, err_p999, _) = errors.select_nth_unstable_by(place, f64::total_cmp);
        Self {
            method: method.to_owned(),
            parameter: parameter.to_string(),
            bytes,
            ns_per_call,
            err_max,
            err_p999: *err_p999,
            err_rms,
        }
    }
}

/// One thing that is approximated, and all ways to do it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Short name, part of file names: letters and hyphens.
    pub name: String,
    /// What is approximated.
    pub title: String,
    /// What one call is.
    pub call: String,
    /// On which cases the errors were found.
    pub domain: String,
    /// What the errors are counted from.
    pub reference: String,
    /// Unit of the errors.
    pub unit: String,
    /// The methods.
    pub rows: Vec<ErrorRow>,
}

impl Task {
    /// The row of a method at a setting.
    pub fn row(&self, method: &str, parameter: &str) -> Option<&ErrorRow> {
        let mut rows = self.rows.iter();
        rows.find(|row| row.method == method && row.parameter == parameter)
    }
}

/// First line of [`task_csv`].
const HEADER: &str = "method,parameter,bytes,ns_per_call,err_max,err_p999,err_rms,unit";

fn csv_row(task: &Task, row: &ErrorRow) -> String {
    format!(
        "{},{},{},{:.2},{:.3e},{:.3e},{:.3e},{}",
        row.method,
        row.parameter,
        row.bytes,
        row.ns_per_call,
        row.err_max,
        row.err_p999,
        row.err_rms,
        task.unit
    )
}

/// A task as CSV, a line a method; its domain and reference stand in [`report`].
pub fn task_csv(task: &Task) -> String {
    let mut text = format!("{HEADER}\n");
    for row in &task.rows {
        text += &format!("{}\n", csv_row(task, row));
    }
    text
}

/// All tasks as CSV, with the task's name in front and its domain at the end of every line.
pub fn joint_csv(tasks: &[Task]) -> String {
    let mut text = format!("task,{HEADER},domain\n");
    for task in tasks {
        for row in &task.rows {
            let domain = task.domain.replace('"', "'");
            text += &format!("{},{},\"{domain}\"\n", task.name, csv_row(task, row));
        }
    }
    text
}

/// All tasks as a Markdown page: domain, reference and table of each; `*` marks the rows that no
/// other beats in both time and root mean square error.
pub fn report(tasks: &[Task]) -> String {
    let mut text = String::from("# Error against time\n");
    for task in tasks {
        text += &format!(
            "\n## {} (`{}`)\n\nA call: {}. Domain: {}. Errors ({}) are counted from {}.\n\n",
            task.title, task.name, task.call, task.domain, task.unit, task.reference
        );
        text += "| | method | setting | bytes | ns a call | largest | 99.9 % | RMS |\n";
        text += "|---|---|---|---|---|---|---|---|\n";
        let front = super::pareto::front(&task.rows);
        for (index, row) in task.rows.iter().enumerate() {
            text += &format!(
                "| {} | {} | {} | {} | {} | {} | {} | {} |\n",
                if front.contains(&index) { "*" } else { "" },
                row.method,
                row.parameter,
                row.bytes,
                digits(row.ns_per_call),
                error_digits(row.err_max),
                error_digits(row.err_p999),
                error_digits(row.err_rms)
            );
        }
    }
    text
}

/// Two digits, with an exponent where they need one.
fn error_digits(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (0.0995..999.5).contains(&value) {
        let places = (1 - value.log10().floor() as i32).max(0);
        format!("{value:.*}", places as usize)
    } else {
        format!("{value:.1e}")
    }
}

/// Three digits, without an exponent.
fn digits(value: f64) -> String {
    let places = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 2);
    format!("{value:.*}", places as usize)
}
