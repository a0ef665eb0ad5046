//! Where the labels of a plot go: beside their marks, and not on one another.
//!
//! Greedy: each label takes the first of a list of places, nearest to its mark first, that is free of
//! marks and of labels before it, and a thin line leads to it where it is not near.

/// Size of a label's letters (px).
pub const FONT_PX: f64 = 12.0;
/// Height of a label (px).
const LINE: f64 = 14.0;
/// Half the room that a mark takes (px).
const MARK: f64 = 6.0;
/// Distances of a label from its mark (px).
const DISTANCES: [f64; 7] = [8.0, 13.0, 20.0, 30.0, 44.0, 62.0, 84.0];
/// Beyond this distance (px) a line leads to the label.
const NEAR: f64 = 14.0;
/// Directions that are tried at each distance (degrees, clockwise from the right): beside the mark
/// before above and below it.
const DIRECTIONS: [f64; 16] = [
    0.0, 180.0, -30.0, 30.0, 210.0, 150.0, -60.0, 60.0, 240.0, 120.0, -15.0, 15.0, 195.0, 165.0,
    -90.0, 90.0,
];

/// A mark, its largest error above it, and what is to be written.
pub struct Mark {
    /// Across (px).
    pub x: f64,
    /// Down (px).
    pub y: f64,
    /// The dash's place down (px), at or above `y`.
    pub top: f64,
    /// The label.
    pub label: String,
}

/// Where labels may stand (px).
#[derive(Clone, Copy)]
pub struct Frame {
    /// Left edge.
    pub left: f64,
    /// Right edge.
    pub right: f64,
    /// Upper edge.
    pub top: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Frame {
    /// Area (px²) shared with another.
    pub fn overlap(&self, other: &Self) -> f64 {
        let across = self.right.min(other.right) - self.left.max(other.left);
        let down = self.bottom.min(other.bottom) - self.top.max(other.top);
        across.max(0.0) * down.max(0.0)
    }

    fn outside(&self, of: &Self) -> f64 {
        let area = (self.right - self.left) * (self.bottom - self.top);
        area - self.overlap(of)
    }
}

/// A label in its place.
pub struct Label {
    /// What it covers.
    pub rect: Frame,
    /// Ends of the line that leads to it.
    pub leader: Option<[[f64; 2]; 2]>,
}

/// Width (px) of a text in a sans-serif face: on the generous side, since faces differ.
pub fn width(text: &str, font_px: f64) -> f64 {
    text.chars().count() as f64 * 0.64 * font_px
}

/// Places all labels, in the order of the marks.
pub fn place(marks: &[Mark], frame: Frame) -> Vec<Label> {
    let mut taken: Vec<Frame> = Vec::with_capacity(3 * marks.len());
    for mark in marks {
        taken.push(around(mark.x, mark.y, MARK, MARK));
        taken.push(around(mark.x, mark.top, 4.0, 2.0));
    }
    let stems: Vec<Frame> = marks
        .iter()
        .map(|mark| Frame {
            left: mark.x - 1.0,
            right: mark.x + 1.0,
            top: mark.top,
            bottom: mark.y,
        })
        .collect();
    let mut labels = Vec::with_capacity(marks.len());
    for mark in marks {
        let width = width(&mark.label, FONT_PX);
        let cost = |rect: &Frame| {
            // A stem may be crossed where nothing else is free.
            let crossed: f64 = stems.iter().map(|stem| stem.overlap(rect)).sum();
            let covered: f64 = taken.iter().map(|other| other.overlap(rect)).sum();
            covered + 10.0 * rect.outside(&frame) + 0.2 * crossed
        };
        let mut best: Option<(f64, f64, Frame)> = None;
        'search: for distance in DISTANCES {
            for direction in DIRECTIONS {
                let rect = beside(mark, width, distance, direction.to_radians());
                let cost = cost(&rect);
                if best.as_ref().is_none_or(|(least, _, _)| cost < *least) {
                    best = Some((cost, distance, rect));
                }
                if cost == 0.0 {
                    break 'search;
                }
            }
        }
        let Some((_, distance, rect)) = best else {
            continue;
        };
        let near_x = mark.x.clamp(rect.left, rect.right);
        let near_y = mark.y.clamp(rect.top, rect.bottom);
        labels.push(Label {
            leader: (distance > NEAR).then_some([[mark.x, mark.y], [near_x, near_y]]),
            rect,
        });
        taken.push(rect);
    }
    labels
}

fn around(x: f64, y: f64, across: f64, down: f64) -> Frame {
    Frame {
        left: x - across,
        right: x + across,
        top: y - down,
        bottom: y + down,
    }
}

/// A label's place in a direction from its mark: its nearest edge at the distance.
fn beside(mark: &Mark, width: f64, distance: f64, direction: f64) -> Frame {
    let (sin, cos) = direction.sin_cos();
    // Its middle moves from beside to above the mark as the direction turns.
    let aside = (2.0 * cos).clamp(-1.0, 1.0);
    let x = mark.x + distance * cos + 0.5 * width * aside;
    let y = mark.y + (distance + 0.5 * LINE) * sin;
    around(x, y, 0.5 * width, 0.5 * LINE)
}
