//! The trace: one row of the eye's state per frame, as CSV.
//!
//! What enters: [`OculomotorState`]s. What leaves: text with a fixed header and fixed decimals,
//! byte-identical for the same states. Angles are in degrees and never "−0"; infinity is `inf`.

use std::io::{self, Write};

use super::engine::OculomotorState;

/// The columns, in order.
pub const HEADER: &str = "time_s,gaze_azimuth_deg,gaze_elevation_deg,gaze_torsion_deg,pupil_mm,\
accommodation_d,lid_aperture,blinking,fixation_distance_m,fixation_azimuth_deg,\
fixation_elevation_deg,in_saccade,fixation_index,blink_epoch";

/// One row of the trace, in the units of the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceRow {
    /// Time, s.
    pub time_s: f64,
    /// Gaze to the patient's right, °.
    pub gaze_azimuth_deg: f64,
    /// Gaze up, °.
    pub gaze_elevation_deg: f64,
    /// Top of the eye to the patient's right, °.
    pub gaze_torsion_deg: f64,
    /// Pupil diameter, mm.
    pub pupil_mm: f64,
    /// Lens response above its relaxed state, D.
    pub accommodation_d: f64,
    /// Opening of the lids, 0–1.
    pub lid_aperture: f64,
    /// Whether the lids are less than open.
    pub blinking: bool,
    /// Distance of the fixated point, m; may be infinite.
    pub fixation_distance_m: f64,
    /// Target to the patient's right, °.
    pub fixation_azimuth_deg: f64,
    /// Target up, °.
    pub fixation_elevation_deg: f64,
    /// Whether the eye is in a saccade.
    pub in_saccade: bool,
    /// Number of the fixation.
    pub fixation_index: u64,
    /// Number of full closures so far.
    pub blink_epoch: u64,
}

impl From<&OculomotorState> for TraceRow {
    fn from(state: &OculomotorState) -> Self {
        Self {
            time_s: state.time_s,
            gaze_azimuth_deg: state.gaze_azimuth_rad.to_degrees(),
            gaze_elevation_deg: state.gaze_elevation_rad.to_degrees(),
            gaze_torsion_deg: state.gaze_torsion_rad.to_degrees(),
            pupil_mm: state.pupil_mm,
            accommodation_d: state.accommodation_d,
            lid_aperture: state.lid_aperture,
            blinking: state.blinking,
            fixation_distance_m: state.fixation_distance_m,
            fixation_azimuth_deg: state.fixation_azimuth_rad.to_degrees(),
            fixation_elevation_deg: state.fixation_elevation_rad.to_degrees(),
            in_saccade: state.in_saccade,
            fixation_index: state.fixation_index,
            blink_epoch: state.blink_epoch,
        }
    }
}

impl TraceRow {
    /// Writes the row with nine decimals and a line feed.
    ///
    /// # Errors
    /// Whatever the writer reports.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let numbers = [
            self.time_s,
            self.gaze_azimuth_deg,
            self.gaze_elevation_deg,
            self.gaze_torsion_deg,
            self.pupil_mm,
            self.accommodation_d,
            self.lid_aperture,
        ];
        for value in numbers {
            write!(out, "{},", decimal(value))?;
        }
        writeln!(
            out,
            "{},{},{},{},{},{},{}",
            u8::from(self.blinking),
            decimal(self.fixation_distance_m),
            decimal(self.fixation_azimuth_deg),
            decimal(self.fixation_elevation_deg),
            u8::from(self.in_saccade),
            self.fixation_index,
            self.blink_epoch
        )
    }
}

/// Writes the header line.
///
/// # Errors
/// Whatever the writer reports.
pub fn write_header(out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")
}

/// Writes a whole trace, header included.
///
/// # Errors
/// Whatever the writer reports.
pub fn write_trace<'a>(
    rows: impl IntoIterator<Item = &'a TraceRow>,
    out: &mut impl Write,
) -> io::Result<()> {
    write_header(out)?;
    rows.into_iter().try_for_each(|row| row.write_to(out))
}

fn decimal(value: f64) -> String {
    let text = format!("{value:.9}");
    // A value that rounds to zero loses its sign, so equal rows are equal bytes.
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| matches!(b, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> TraceRow {
        TraceRow {
            time_s: 0.1,
            gaze_azimuth_deg: -1.5,
            gaze_elevation_deg: -1e-12,
            gaze_torsion_deg: -0.0,
            pupil_mm: 4.25,
            accommodation_d: 1.0 / 3.0,
            lid_aperture: 1.0,
            blinking: false,
            fixation_distance_m: f64::INFINITY,
            fixation_azimuth_deg: -1.5,
            fixation_elevation_deg: 2.0,
            in_saccade: true,
            fixation_index: 7,
            blink_epoch: 2,
        }
    }

    #[test]
    fn the_bytes_are_fixed() {
        let mut out = Vec::new();
        write_trace(&[row()], &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let expected = "time_s,gaze_azimuth_deg,gaze_elevation_deg,gaze_torsion_deg,pupil_mm,\
             accommodation_d,lid_aperture,blinking,fixation_distance_m,fixation_azimuth_deg,\
             fixation_elevation_deg,in_saccade,fixation_index,blink_epoch\n\
             0.100000000,-1.500000000,0.000000000,0.000000000,4.250000000,0.333333333,\
             1.000000000,0,inf,-1.500000000,2.000000000,1,7,2\n"
            .replace(",\\\n", ",");
        assert_eq!(text, expected);
    }

    #[test]
    fn every_row_has_as_many_columns_as_the_header() {
        let mut out = Vec::new();
        row().write_to(&mut out).unwrap();
        let columns = out.iter().filter(|b| **b == b',').count() + 1;
        assert_eq!(columns, HEADER.split(',').count());
        assert_eq!(HEADER.split(',').count(), 14);
    }
}
