//! Lid margins, in the globe frame (mm, y up, gaze along −z, +x to the patient's right; right eye, so
//! +x is temporal).
//!
//! In: a [`LidPose`] and the globe's radius along a direction (cornea already turned). Out: points of
//! the palpebral margins and the height of the opening.
//!
//! A lid turns about the canthal axis (+x through the globe's centre), so a margin point keeps its
//! bearing `beta` from the sagittal plane and moves in elevation `phi`: it slides over the globe on a
//! circle and never cuts the chord. The figures are those of adult eyes: fissure 8–11 × 25–30 mm,
//! 9.7 mm high straight ahead, lateral canthus 2–4 mm above the medial, the upper lid covering 1–2 mm
//! of the iris; the upper lid follows vertical gaze (Becker & Fuchs 1988).

use glam::Vec3;

/// Where the lids are. Everything is clamped to its range when used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidPose {
    /// 0 closed … 1 open as for this gaze at rest, up to 1.2 wide open.
    pub aperture: f32,
    /// How far the upper lid alone hangs from there, 0 … 1 (closed).
    pub droop: f32,
    /// Globe azimuth, radians, positive to the patient's right, ±0.9.
    pub gaze_azimuth_rad: f32,
    /// Globe elevation, radians, positive up, ±0.7.
    pub gaze_elevation_rad: f32,
    /// Squint 0 … 1: narrows the fissure and lifts the cheek.
    pub squint: f32,
}

impl Default for LidPose {
    fn default() -> Self {
        Self {
            aperture: 1.0,
            droop: 0.0,
            gaze_azimuth_rad: 0.0,
            gaze_elevation_rad: 0.0,
            squint: 0.0,
        }
    }
}

impl LidPose {
    /// The nearest legal pose; what is not a number counts as the default's value.
    pub fn clamped(&self) -> Self {
        let fix =
            |x: f32, low: f32, high: f32, or: f32| if x.is_nan() { or } else { x.clamp(low, high) };
        Self {
            aperture: fix(self.aperture, 0.0, 1.2, 1.0),
            droop: fix(self.droop, 0.0, 1.0, 0.0),
            gaze_azimuth_rad: fix(self.gaze_azimuth_rad, -0.9, 0.9, 0.0),
            gaze_elevation_rad: fix(self.gaze_elevation_rad, -0.7, 0.7, 0.0),
            squint: fix(self.squint, 0.0, 1.0, 0.0),
        }
    }

    /// How far a lid is open, as [`LidPose::aperture`].
    pub fn aperture_of(&self, lid: Lid) -> f32 {
        match lid {
            Lid::Upper => self.aperture * (1.0 - self.droop),
            Lid::Lower => self.aperture,
        }
    }

    /// How far the upper lid is from its highest place, 0 (up) … 1 (closed), for folds.
    pub fn lowered(&self) -> f32 {
        let pose = self.clamped();
        let by_gaze = (-pose.gaze_elevation_rad).max(0.0) * 0.75;
        1.0 - pose.aperture_of(Lid::Upper).min(1.0) * (1.0 - by_gaze.min(0.8))
    }
}

/// Which lid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lid {
    /// The upper lid.
    Upper,
    /// The lower lid.
    Lower,
}

/// Upper margin (posterior edge) straight ahead, x and y in mm from the medial to the lateral canthus.
const UPPER: [[f32; 2]; 13] = [
    [-13.75, -2.00],
    [-13.50, -1.45],
    [-12.25, -0.50],
    [-10.40, 0.90],
    [-8.00, 2.50],
    [-5.20, 3.48],
    [-2.05, 3.85],
    [1.30, 3.62],
    [4.65, 3.05],
    [7.80, 2.42],
    [10.20, 1.75],
    [11.60, 1.18],
    [12.25, 0.75],
];
/// Lower margin, as [`UPPER`].
const LOWER: [[f32; 2]; 13] = [
    [-13.75, -2.00],
    [-13.45, -2.50],
    [-12.10, -2.95],
    [-10.00, -3.60],
    [-7.45, -4.60],
    [-4.30, -5.42],
    [-0.95, -5.84],
    [2.40, -5.70],
    [5.60, -4.75],
    [8.40, -2.95],
    [10.40, -1.22],
    [11.60, 0.02],
    [12.25, 0.75],
];
const TABLE: usize = 128;
/// Film between the globe and the posterior edge of the margin, mm.
pub const MARGIN_CLEARANCE_MM: f32 = 0.06;
/// Globe radius that the resting curves were drawn for, mm.
pub(crate) const REST_RADIUS_MM: f32 = 11.5 + MARGIN_CLEARANCE_MM;

/// A margin point that turns about the canthal axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bearing {
    /// Angle from the sagittal plane, radians, positive temporal.
    beta: f32,
    /// Elevation about the canthal axis, radians.
    phi: f32,
    /// Distance from the globe, mm, where the lid leaves it for a canthus.
    lift: f32,
}

impl Bearing {
    fn of(x: f32, y: f32) -> Self {
        let lift = lift_mm(x);
        let radius = REST_RADIUS_MM + lift;
        let beta = (x / radius).clamp(-1.0, 1.0).asin();
        let phi = (y / (radius * beta.cos())).clamp(-1.0, 1.0).asin();
        Self { beta, phi, lift }
    }

    fn mix(self, other: Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Self {
            beta: mix(self.beta, other.beta),
            phi: mix(self.phi, other.phi),
            lift: mix(self.lift, other.lift),
        }
    }

    fn direction(self) -> Vec3 {
        let (sb, cb) = self.beta.sin_cos();
        let (sp, cp) = self.phi.sin_cos();
        Vec3::new(sb, cb * sp, -cb * cp)
    }
}

/// How far the taut margin stands off the globe towards the canthi, mm.
fn lift_mm(x: f32) -> f32 {
    let medial = ((-6.8 - x) / 8.0).max(0.0).powf(1.6) * 5.7;
    let lateral = ((x - 7.5) / 5.7).max(0.0).powf(1.5) * 2.45;
    medial + lateral
}

/// The two resting margins, by arc length.
#[derive(Clone, Debug)]
pub struct Fissure {
    upper: Vec<Bearing>,
    lower: Vec<Bearing>,
}

/// A point of a posed margin.
#[derive(Clone, Copy, Debug)]
pub struct MarginPoint {
    /// Unit vector from the globe's centre.
    pub direction: Vec3,
    /// Distance from the globe's surface, mm, without the clearance.
    pub lift_mm: f32,
}

impl MarginPoint {
    /// The posterior edge itself.
    pub fn position(&self, globe_radius: &dyn Fn(Vec3) -> f32) -> Vec3 {
        self.direction * (globe_radius(self.direction) + self.lift_mm + MARGIN_CLEARANCE_MM)
    }
}

impl Default for Fissure {
    fn default() -> Self {
        Self {
            upper: by_arc_length(&UPPER),
            lower: by_arc_length(&LOWER),
        }
    }
}

impl Fissure {
    /// The posterior edge of a margin at `t` from the medial (0) to the lateral canthus (1).
    pub fn margin(&self, lid: Lid, t: f32, pose: &LidPose) -> MarginPoint {
        let pose = pose.clamped();
        let t = t.clamp(0.0, 1.0);
        let (mut upper, mut lower) = (lookup(&self.upper, t), lookup(&self.lower, t));
        // The canthi are tied down; the middle of the lid travels.
        let free = (std::f32::consts::PI * t).sin().max(0.0).powf(0.7);
        let elevation = pose.gaze_elevation_rad;
        let (up, down) = (elevation.max(0.0), elevation.min(0.0));
        // Upwards the lid runs out of room under the orbital rim: the gain falls off.
        upper.phi += free * (0.3 * (up * 2.6).tanh() + 0.75 * down);
        lower.phi += free * (0.24 * up + 0.44 * down);
        let sideways = 0.035 * pose.gaze_azimuth_rad * free;
        upper.beta += sideways;
        lower.beta += sideways;
        let gap = (upper.phi - lower.phi).max(0.0);
        upper.phi -= 0.14 * pose.squint * gap;
        lower.phi += 0.24 * pose.squint * gap;
        // The upper lid comes most of the way, the lower one rises and goes nasally.
        let mut closed = lower.mix(upper, 0.13);
        closed.beta -= 0.045 * free;
        closed.lift = 0.5 * (upper.lift + lower.lift);
        let (open, widening) = match lid {
            Lid::Upper => (upper, 0.55),
            Lid::Lower => (lower, 0.25),
        };
        let aperture = pose.aperture_of(lid);
        let beyond = (aperture - 1.0).max(0.0) * widening;
        let bearing = closed.mix(open, aperture.min(1.0) + beyond);
        MarginPoint {
            direction: bearing.direction(),
            lift_mm: bearing.lift,
        }
    }

    /// The posterior edge of a margin straight above or below a place `x` mm aside of the globe's middle;
    /// beyond a canthus the canthus.
    pub fn above(
        &self,
        lid: Lid,
        x: f32,
        pose: &LidPose,
        globe_radius: &dyn Fn(Vec3) -> f32,
    ) -> Vec3 {
        let (mut low, mut high) = (0.0, 1.0);
        // A margin runs from one canthus to the other: sixteen halvings leave half a micrometre.
        for _ in 0..16 {
            let middle = 0.5 * (low + high);
            if self.margin(lid, middle, pose).position(globe_radius).x < x {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.margin(lid, 0.5 * (low + high), pose)
            .position(globe_radius)
    }
}

fn lookup(table: &[Bearing], t: f32) -> Bearing {
    let at = t * (table.len() - 1) as f32;
    let i = (at as usize).min(table.len() - 2);
    table[i].mix(table[i + 1], at - i as f32)
}

/// Catmull–Rom through the points, resampled at equal steps of arc length.
fn by_arc_length(points: &[[f32; 2]]) -> Vec<Bearing> {
    let at = |i: isize| points[i.clamp(0, points.len() as isize - 1) as usize];
    let mut fine = Vec::new();
    for i in 0..points.len() - 1 {
        let p: [[f32; 2]; 4] = std::array::from_fn(|k| at(i as isize + k as isize - 1));
        for s in 0..32 {
            let u = s as f32 / 32.0;
            fine.push([0, 1].map(|c| catmull_rom([p[0][c], p[1][c], p[2][c], p[3][c]], u)));
        }
    }
    fine.push(points[points.len() - 1]);
    let mut length = vec![0.0_f32];
    for w in fine.windows(2) {
        length.push(length[length.len() - 1] + (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]));
    }
    let total = length[length.len() - 1];
    (0..=TABLE)
        .map(|i| {
            let want = total * i as f32 / TABLE as f32;
            let j = length
                .partition_point(|&l| l < want)
                .clamp(1, fine.len() - 1);
            let s =
                ((want - length[j - 1]) / (length[j] - length[j - 1]).max(1e-9)).clamp(0.0, 1.0);
            let mix = |c: usize| fine[j - 1][c] + (fine[j][c] - fine[j - 1][c]) * s;
            Bearing::of(mix(0), mix(1))
        })
        .collect()
}

fn catmull_rom(p: [f32; 4], u: f32) -> f32 {
    let (a, b) = (
        2.0 * p[0] - 5.0 * p[1] + 4.0 * p[2] - p[3],
        -p[0] + 3.0 * p[1] - 3.0 * p[2] + p[3],
    );
    0.5 * (2.0 * p[1] + (p[2] - p[0]) * u + a * u * u + b * u * u * u)
}
