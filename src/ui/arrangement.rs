//! Where things stand at every size of the window, from a small telephone to a large screen.

use bevy_egui::egui::Vec2;

/// Where the controls stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlsPlace {
    /// Put away.
    Hidden,
    /// Beside the pictures, this wide, points.
    Right(f32),
    /// Below the pictures, this high, points.
    Below(f32),
}

/// Where things stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrangement {
    /// The controls.
    pub controls: ControlsPlace,
    /// Is the strip of curves shown?
    pub strip: bool,
}

/// Width of the controls beside the pictures, points.
const CONTROLS_WIDTH: f32 = 264.0;
/// Height below which the strip would leave too little for the pictures, points.
const STRIP_FROM_HEIGHT: f32 = 520.0;

/// How much larger than usual text and controls are in a window of this size in points: on a large
/// screen that the system does not enlarge itself, they would be a finger's width in a corner; and with
/// less than a pixel a point, letters would melt.
pub fn zoom_for(size: Vec2, pixels_a_point: f32) -> f32 {
    let share = (size.x / 1920.0).min(size.y / 1080.0);
    // By quarters: text stays sharp, and a window that is drawn larger does not creep.
    let large = ((share * 4.0).floor() / 4.0).clamp(1.0, 2.0);
    large.max(pixels_a_point.recip().clamp(1.0, 1.25))
}

/// Is there room for the controls without asking?
pub fn has_room(size: Vec2) -> bool {
    size.x >= 860.0 && size.y >= 480.0
}

/// Arranges a window of this size in points, with or without its controls.
pub fn arrange(size: Vec2, controls: bool) -> Arrangement {
    let upright = size.y > size.x && size.x < 640.0;
    let controls = match (controls, upright) {
        (false, _) => ControlsPlace::Hidden,
        (true, true) => ControlsPlace::Below((0.46 * size.y).round()),
        (true, false) => ControlsPlace::Right(CONTROLS_WIDTH.min(0.6 * size.x)),
    };
    let strip = size.y >= STRIP_FROM_HEIGHT && !matches!(controls, ControlsPlace::Below(_));
    Arrangement { controls, strip }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::vec2;

    #[test]
    fn text_grows_with_large_screens_only() {
        for (size, zoom) in [
            (vec2(320.0, 480.0), 1.0),
            (vec2(1920.0, 1080.0), 1.0),
            (vec2(2560.0, 1440.0), 1.25),
            (vec2(3440.0, 1440.0), 1.25),
            (vec2(3840.0, 2160.0), 2.0),
            (vec2(7680.0, 4320.0), 2.0),
            (vec2(3840.0, 600.0), 1.0),
        ] {
            assert_eq!(zoom_for(size, 1.0), zoom, "{size:?}");
            assert_eq!(zoom_for(size, 3.0), zoom, "{size:?}");
            // What is left to the controls is never less than a plain screen.
            assert!(zoom == 1.0 || (size / zoom).min_elem() >= 1080.0);
        }
        assert_eq!(zoom_for(vec2(1280.0, 720.0), 0.8), 1.25);
        assert_eq!(zoom_for(vec2(1280.0, 720.0), 0.3), 1.25);
    }

    #[test]
    fn the_pictures_keep_most_of_every_window() {
        let sizes = [
            (320.0, 480.0),
            (390.0, 844.0),
            (844.0, 390.0),
            (480.0, 320.0),
            (768.0, 1024.0),
            (1280.0, 720.0),
            (3840.0, 2160.0),
        ];
        for (width, height) in sizes {
            let size = vec2(width, height);
            for open in [false, true] {
                let arrangement = arrange(size, open);
                let strip = if arrangement.strip { 130.0 } else { 0.0 };
                let left = match arrangement.controls {
                    ControlsPlace::Hidden => size.x * (size.y - strip),
                    ControlsPlace::Right(wide) => (size.x - wide) * (size.y - strip),
                    ControlsPlace::Below(high) => size.x * (size.y - high),
                };
                let share = left / (size.x * size.y);
                let least = if open { 0.4 } else { 0.75 };
                assert!(share >= least, "{width}×{height}: {share}");
            }
            assert_eq!(arrange(size, false).controls, ControlsPlace::Hidden);
        }
    }

    #[test]
    fn telephones_begin_with_the_pictures_alone() {
        for size in [vec2(320.0, 480.0), vec2(390.0, 844.0), vec2(844.0, 390.0)] {
            assert!(!has_room(size), "{size:?}");
        }
        assert!(has_room(vec2(1280.0, 720.0)) && has_room(vec2(900.0, 600.0)));
        // Controls that are called for stand below on an upright telephone, else beside.
        assert_eq!(
            arrange(vec2(390.0, 844.0), true).controls,
            ControlsPlace::Below(388.0)
        );
        assert_eq!(
            arrange(vec2(1280.0, 720.0), true).controls,
            ControlsPlace::Right(264.0)
        );
    }
}
