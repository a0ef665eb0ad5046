//! Ptosis: an upper lid that hangs.
//!
//! Enters: the margin reflex distance (MRD1), from the light's reflection on the cornea to the margin of
//! the upper lid. Leaves: how far the upper lid hangs; the lower one stays.

use super::{Affected, Condition, Control, short};
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::Component;
use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

/// MRD1 of an eye whose lids open as usual, mm: 4 to 5 in adults (Putterman 1980); here what the resting
/// margin of the face has.
const USUAL_MM: f64 = 4.0;
/// The largest that is written down, mm.
const MOST_MM: f64 = 4.4;
/// How far the upper margin travels between open and closed, mm: what puts it where it was measured, within 0.15 mm, over the globe
/// and cornea on which it slides (a test of where lids are drawn).
const TRAVEL_MM: f64 = 8.8;

/// Ptosis of an eye, or of both eyes of a person.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Component)]
#[serde(deny_unknown_fields)]
pub struct Ptosis {
    /// Margin reflex distance MRD1, mm, −4 to 4.4: from 4.0 on there is none, 3 is mild, 2 moderate, 0 and below severe: the lid
    /// covers the middle of the pupil.
    pub mrd1_mm: f64,
}

impl Condition for Ptosis {
    const TITLE: &'static str = "Ptosis";

    fn onset() -> Self {
        Self { mrd1_mm: 2.0 }
    }

    fn controls() -> &'static [Control<Self>] {
        &[Control {
            name: "mrd1_mm",
            range: (-4.0, MOST_MM),
            meaning: "upper lid margin above the corneal reflex (MRD1, mm)",
            get: |own| Some(own.mrd1_mm),
            set: |own, value| own.mrd1_mm = value,
        }]
    }

    fn write(&self, affected: &mut Affected) {
        if self.mrd1_mm >= USUAL_MM {
            return;
        }
        let drop_mm = (USUAL_MM - self.mrd1_mm).clamp(0.0, TRAVEL_MM);
        let lids = &mut affected.lids;
        // Where the margin is, however wide the lids would open without it.
        let share = (1.0 - drop_mm / TRAVEL_MM) / lids.opening.max(f64::MIN_POSITIVE);
        lids.droop = lids.droop.max(1.0 - share).clamp(0.0, 1.0);
    }

    fn caption(&self) -> String {
        if self.mrd1_mm >= USUAL_MM {
            return format!("No ptosis (MRD1 {} mm).", short(self.mrd1_mm));
        }
        format!("Ptosis, MRD1 {} mm.", short(self.mrd1_mm))
    }

    fn remark(&self, without: &Affected) -> Option<String> {
        let own_mm = USUAL_MM - (1.0 - without.lids.opening) * TRAVEL_MM;
        (own_mm < self.mrd1_mm.min(USUAL_MM)).then(|| {
            format!(
                "lids that open to {} of usual leave the margin at {} mm, below mrd1_mm = {}",
                short(without.lids.opening),
                short(own_mm),
                short(self.mrd1_mm)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::Laterality;

    /// How far the upper lid opens.
    fn opening(mrd1_mm: f64) -> f64 {
        opening_of(1.0, mrd1_mm)
    }

    fn opening_of(own: f64, mrd1_mm: f64) -> f64 {
        let mut affected = Affected::healthy(Laterality::OD, 60.0);
        affected.lids.opening = own;
        Ptosis { mrd1_mm }.write(&mut affected);
        affected.lids.opening * (1.0 - affected.lids.droop)
    }

    #[test]
    fn a_lid_opens_as_far_as_it_is_measured() {
        assert_eq!((opening(4.0), opening(9.0)), (1.0, 1.0));
        // 2 and 8 of 8.8 mm lower.
        assert!((opening(2.0) - 0.7727).abs() < 1e-3);
        assert!((opening(-4.0) - 0.0909).abs() < 1e-3);
        assert!(opening(3.9) < 1.0);
        // The margin is where it was measured, whatever the lids would do; unless they open less.
        assert!((opening_of(1.2, 2.0) - opening(2.0)).abs() < 1e-12);
        // From 4 mm on it is no ptosis, and lids open as they would.
        assert_eq!((opening_of(1.2, 4.4), opening_of(1.2, 4.0)), (1.2, 1.2));
        assert_eq!((opening_of(0.3, 2.0), opening_of(0.0, 2.0)), (0.3, 0.0));
        assert_eq!(opening(f64::NAN), 1.0);
        assert_eq!(opening(f64::NEG_INFINITY), 0.0);
    }
}
