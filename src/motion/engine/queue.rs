//! The events of the engine, in the order of their times.
//!
//! What enters: events with a time. What leaves: the earliest one that is due. Events at the same
//! time come in the order of their kind (commands first), then of their entry, so the order does
//! not depend on how often the engine was asked to advance.

use crate::anatomy::gaze::GazeAngles;

use super::GazeCommand;

/// A point to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    pub gaze: GazeAngles,
    pub distance_m: f64,
}

/// What can happen at a time.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Event {
    /// Somebody tells the eye where to look.
    Command(GazeCommand),
    /// A followed target has become visible to the pursuit system.
    Pursue(Target),
    /// A blink on demand.
    VoluntaryBlink,
    /// A spontaneous blink.
    SpontaneousBlink,
    /// The next target is chosen; the saccade is due at `onset_s`.
    Decide { onset_s: f64 },
    /// The eye leaves for a target that was chosen at `decided_s`.
    Depart { target: Target, decided_s: f64 },
    /// The eye arrives.
    Land,
    /// The lens starts towards a distance, and the pupil with it.
    Accommodate { distance_m: f64 },
    /// The pupil starts towards what the light demands.
    Light,
}

impl Event {
    fn rank(&self) -> u8 {
        match self {
            Self::Command(_) => 1,
            Self::Pursue(_) => 2,
            Self::VoluntaryBlink => 3,
            Self::SpontaneousBlink => 4,
            // Arriving comes before leaving again at the same time.
            Self::Land => 5,
            Self::Decide { .. } => 6,
            Self::Depart { .. } => 7,
            Self::Accommodate { .. } => 8,
            Self::Light => 9,
        }
    }
}

#[derive(Clone, Debug)]
struct Scheduled {
    time_s: f64,
    order: u64,
    event: Event,
}

/// A short list; there are seldom more than a dozen events ahead.
#[derive(Clone, Debug, Default)]
pub(super) struct EventQueue {
    events: Vec<Scheduled>,
    entered: u64,
}

impl EventQueue {
    pub fn push(&mut self, time_s: f64, event: Event) {
        self.entered += 1;
        self.events.push(Scheduled {
            time_s,
            order: self.entered,
            event,
        });
    }

    /// Takes out the earliest event that is due at `until_s`.
    pub fn pop_due(&mut self, until_s: f64) -> Option<(f64, Event)> {
        let (index, first) = self.events.iter().enumerate().min_by(|(_, a), (_, b)| {
            a.time_s
                .total_cmp(&b.time_s)
                .then(a.event.rank().cmp(&b.event.rank()))
                .then(a.order.cmp(&b.order))
        })?;
        if first.time_s > until_s {
            return None;
        }
        let first = self.events.swap_remove(index);
        Some((first.time_s, first.event))
    }

    /// Drops the events for which `keep` is false.
    pub fn retain(&mut self, keep: impl Fn(&Event) -> bool) {
        self.events.retain(|scheduled| keep(&scheduled.event));
    }

    pub fn any(&self, wanted: impl Fn(&Event) -> bool) -> bool {
        self.events.iter().any(|scheduled| wanted(&scheduled.event))
    }

    /// Changes the events in place.
    pub fn for_each(&mut self, mut change: impl FnMut(&mut Event)) {
        for scheduled in &mut self.events {
            change(&mut scheduled.event);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_by_time_then_kind_then_entry() {
        let mut queue = EventQueue::default();
        let decide = |onset_s| Event::Decide { onset_s };
        queue.push(2.0, Event::Light);
        queue.push(1.0, decide(1.0));
        queue.push(1.0, decide(2.0));
        queue.push(1.0, Event::Land);
        queue.push(1.0, Event::Command(GazeCommand::Auto));
        assert_eq!(queue.pop_due(0.5), None);
        assert_eq!(
            queue.pop_due(1.5),
            Some((1.0, Event::Command(GazeCommand::Auto)))
        );
        assert_eq!(queue.pop_due(1.5), Some((1.0, Event::Land)));
        assert_eq!(queue.pop_due(1.5), Some((1.0, decide(1.0))));
        queue.retain(|event| *event != decide(2.0));
        assert!(queue.any(|event| *event == Event::Light));
        assert_eq!(queue.pop_due(1.5), None);
        assert_eq!(queue.pop_due(2.0), Some((2.0, Event::Light)));
    }
}
