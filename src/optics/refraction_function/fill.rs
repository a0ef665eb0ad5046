//! Nodes of the grid that no shortest path reaches, filled so that the cells at the domain's edge go on
//! smoothly.

use glam::DVec2;

/// Fills nodes without a path from their neighbours' by `solve(node, near)`, outwards from those that
/// have one, until it fails.
pub(super) fn extend(column: &mut [Option<DVec2>], solve: impl Fn(usize, DVec2) -> Option<DVec2>) {
    let Some(first) = column.iter().position(Option::is_some) else {
        return;
    };
    for node in (0..first).rev() {
        column[node] = column[node + 1].and_then(|near| solve(node, near));
    }
    for node in first + 1..column.len() {
        if column[node].is_none() {
            column[node] = column[node - 1].and_then(|near| solve(node, near));
        }
    }
}

/// Fills nodes without a path from those that have one, along `w` by the parabola through the
/// nearest three, then across by the line through the nearest two: cells at the domain's edge need
/// them.
pub(super) fn complete(sheet: &[Vec<Option<DVec2>>], sites: &[f64], limbus_mm: f64) -> Vec<DVec2> {
    let farthest = 1.5 * limbus_mm;
    let mut columns: Vec<Option<Vec<DVec2>>> = sheet
        .iter()
        .map(|column| {
            let known: Vec<(f64, DVec2)> = column
                .iter()
                .zip(sites)
                .filter_map(|(value, &site)| value.map(|k| (site, k)))
                .collect();
            if known.len() < 3 {
                return None;
            }
            let filled = column.iter().zip(sites).map(|(value, &site)| {
                value.unwrap_or_else(|| {
                    let near = if site < known[0].0 {
                        &known[..3]
                    } else {
                        &known[known.len() - 3..]
                    };
                    parabola(near, site).clamp_length_max(farthest)
                })
            });
            Some(filled.collect())
        })
        .collect();
    for index in 0..columns.len() {
        if columns[index].is_some() {
            continue;
        }
        let before = |back: usize| index.checked_sub(back).and_then(|i| columns[i].clone());
        let filled = match (before(1), before(2)) {
            (Some(one), Some(two)) => one
                .iter()
                .zip(&two)
                .map(|(one, two)| (2.0 * *one - *two).clamp_length_max(farthest))
                .collect(),
            (Some(one), None) => one,
            _ => vec![DVec2::ZERO; sites.len()],
        };
        columns[index] = Some(filled);
    }
    columns.into_iter().flatten().flatten().collect()
}

fn parabola(points: &[(f64, DVec2)], at: f64) -> DVec2 {
    let mut sum = DVec2::ZERO;
    for (i, (site, value)) in points.iter().enumerate() {
        let mut weight = 1.0;
        for (j, (other, _)) in points.iter().enumerate() {
            if i != j {
                weight *= (at - other) / (site - other);
            }
        }
        sum += weight * *value;
    }
    sum
}
