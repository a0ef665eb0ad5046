//! Where to read a table of evenly spaced values. Twin: `shaders/lib/knots.wgsl`.

/// A place between two knots of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The knot below it.
    pub below: usize,
    /// How far it is from there to the next, 0 to 1.
    pub part: f64,
}

impl Knot {
    /// The value there of a table.
    pub fn read(self, table: &[f64]) -> f64 {
        super::mix(table[self.below], table[self.below + 1], self.part)
    }
}

/// The knot below this share (0 to 1; others count as the nearest of these) of a table of so many, two or more.
pub fn knot_at(share: f64, knots: usize) -> Knot {
    let place = share.clamp(0.0, 1.0) * (knots - 1) as f64;
    let below = (place as usize).min(knots - 2);
    Knot {
        below,
        part: place - below as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_table_is_read_as_the_line_that_it_is() {
        let table: Vec<f64> = (0..9).map(|i| 3.0 - 0.25 * f64::from(i)).collect();
        for share in [-2.0, 0.0, 0.01, 0.3, 0.875, 0.99, 1.0, 7.0] {
            let line = 3.0 - 2.0 * f64::clamp(share, 0.0, 1.0);
            // A few roundings of numbers up to 3.
            assert!(
                (knot_at(share, 9).read(&table) - line).abs() < 4e-15,
                "{share}"
            );
        }
    }
}
