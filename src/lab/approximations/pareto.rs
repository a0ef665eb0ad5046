//! Which methods are worth having: those that no other beats.

use super::rows::ErrorRow;

/// Indices, by rising time, of the rows that no other row dominates in time and root mean square
/// error: to dominate is to be no worse in both and better in one. Equal rows do not dominate each
/// other.
pub fn front(rows: &[ErrorRow]) -> Vec<usize> {
    let points: Vec<[f64; 2]> = rows
        .iter()
        .map(|row| [row.ns_per_call, row.err_rms])
        .collect();
    let mut front: Vec<usize> = (0..points.len())
        .filter(|&index| !points.iter().any(|&other| dominates(other, points[index])))
        .collect();
    front.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    front
}

/// Whether `a` is no worse than `b` in every number and better in one.
fn dominates(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1])
}
