//! How an eye looks beside photographs of eyes, for `ocularium measure looks`: numbers of rendered pixels, and the same
//! of real pictures.
//!
//! In: a patient and a light. Out: one JSON object whose rows hold a quantity, what our picture has, and the middle and
//! spread of photographs. The photographs' numbers are those of REFERENCE ("Looks": 34 macro pictures and portraits without a
//! grey card, so that ratios are the target and colours a guide).

use super::headless::{Headless, HeadlessError, Which};
use crate::anatomy::Laterality;
use crate::appearance::materials::LidMargins;
use crate::appearance::shading::lid_shade::lids_at;
use crate::appearance::{EyeOrbit, GlobeMaterial};
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::optics::output::{linear_to_srgb, srgb_decode};
use crate::patients::PatientFile;
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::stage::Session;
use crate::tissue::colour_difference::linear_srgb_to_lab;
use bevy::camera::Projection;
use bevy::math::{DMat3, DVec2, DVec3, UVec2};
use bevy::prelude::{Assets, MeshMaterial3d, World};
use image::RgbaImage;
use serde::Serialize;
use std::collections::BTreeMap;

/// Pixels along a side of the picture, and the camera's distance, mm: an iris is 410 pixels wide.
const SIDE: u32 = 1024;
const DISTANCE_MM: f32 = 85.0;

/// A quantity, here and in photographs.
#[derive(Clone, Debug, Serialize)]
pub struct LookRow {
    /// What it is.
    pub quantity: &'static str,
    /// Its unit; `1` is a ratio.
    pub unit: &'static str,
    /// Of the rendered picture.
    pub ours: Option<f64>,
    /// The middle of photographs.
    pub photographs: f64,
    /// Their spread.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Does ours lie within it?
    pub within: Option<bool>,
    /// Why there is none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub null_reasons: BTreeMap<&'static str, &'static str>,
}

/// The table.
#[derive(Clone, Debug, Serialize)]
pub struct Looks {
    table: &'static str,
    version: &'static str,
    meaning: &'static str,
    source: &'static str,
    notes: &'static [&'static str],
    patient: String,
    light: &'static str,
    /// Mean of the iris's ring, sRGB codes.
    iris_srgb: [f64; 3],
    /// Median of the white between limbus and corner, sRGB codes.
    sclera_srgb: [f64; 3],
    /// The quantities.
    pub rows: Vec<LookRow>,
}

/// What it holds.
pub const MEANING: &str = "How the patient's eye looks beside photographs of eyes: colours, brightnesses and widths of rendered \
                           pixels, and the middle and spread of 34 photographs";

/// A picture in linear light about a pupil.
struct Picture {
    size: u32,
    linear: Vec<DVec3>,
    /// Is it between the lids?
    open: Vec<bool>,
    center: DVec2,
    /// Radius of the pupil, pixels; not a number where none is seen.
    pupil_px: f64,
    /// Radius of the limbus, pixels.
    limbus_px: f64,
    /// +1 where the nose is to the right of the picture.
    nose: f64,
}

fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Not a number where there are none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Median of each channel.
fn middle_of(own: &[DVec3]) -> DVec3 {
    DVec3::from([0, 1, 2].map(|k| median(own.iter().map(|c| c[k]).collect())))
}

impl Picture {
    /// `open` says what is between the lids: a place by limbus radii to the right of the middle and down.
    fn new(picture: &RgbaImage, limbus_px: f64, nose: f64, open: impl Fn(DVec2) -> bool) -> Self {
        let size = picture.width();
        let decode = |code: u8| srgb_decode(f64::from(code) / 255.0);
        let pixels = picture.pixels();
        let linear: Vec<DVec3> = pixels
            .map(|p| DVec3::new(decode(p.0[0]), decode(p.0[1]), decode(p.0[2])))
            .collect();
        // That of the cornea, from which a pupil's may be a few tenths of a millimetre off.
        let center = DVec2::splat(f64::from(size) * 0.5);
        let off = |i: usize| (place(i, size) - center) / limbus_px;
        let open = (0..linear.len()).map(|i| open(off(i))).collect();
        let mut own = Self {
            size,
            linear,
            open,
            center,
            pupil_px: f64::NAN,
            limbus_px,
            nose,
        };
        // The pupil: what is dark around the middle, to where most of a ring is not.
        let is_dark = |c: &DVec3| luminance(*c) < 0.02;
        let ring = |from: f64| {
            let ring = own.where_is(|r, _| (from..from + 0.02).contains(&r));
            2 * ring.iter().filter(|c| is_dark(c)).count() >= ring.len()
        };
        let edge = (0..50)
            .map(|step| 0.02 * f64::from(step))
            .find(|from| !ring(*from));
        // A black iris has no such edge.
        if let Some(edge) = edge
            && own.where_is(|r, _| r < 0.1).iter().any(is_dark)
        {
            let around = own.where_is(|r, _| r < (1.25 * edge).max(0.45));
            let count = around.iter().filter(|c| is_dark(c)).count() as f64;
            own.pupil_px = f64::sqrt(count / core::f64::consts::PI);
        }
        own
    }

    /// Linear light where `chosen` takes a place: radius over the limbus's, angle (rad) from the nose's side, downwards.
    fn anywhere(&self, chosen: impl Fn(f64, f64) -> bool) -> Vec<(bool, DVec3)> {
        let all = self.open.iter().copied().zip(self.linear.iter().copied());
        all.enumerate()
            .filter(|(i, _)| {
                let off = place(*i, self.size) - self.center;
                let radius = off.length() / self.limbus_px;
                chosen(radius, off.y.atan2(self.nose * off.x))
            })
            .map(|(_, own)| own)
            .collect()
    }

    /// The same between the lids; nothing where they cover most of it.
    fn where_is(&self, chosen: impl Fn(f64, f64) -> bool) -> Vec<DVec3> {
        let all = self.anywhere(chosen);
        let seen: Vec<DVec3> = all.iter().filter(|own| own.0).map(|own| own.1).collect();
        if 2 * seen.len() < all.len() {
            return Vec::new();
        }
        seen
    }

    /// Median colour of a round patch of the eye at (towards the nose, down) limbus radii.
    fn patch(&self, nasal: f64, down: f64, radius: f64) -> DVec3 {
        let at = DVec2::new(nasal, down);
        middle_of(&self.where_is(|r, angle| at.distance(r * DVec2::from_angle(angle)) < radius))
    }

    /// That of one of the skin.
    fn skin(&self, nasal: f64, down: f64, radius: f64) -> DVec3 {
        let at = DVec2::new(nasal, down);
        let own = self.anywhere(|r, angle| at.distance(r * DVec2::from_angle(angle)) < radius);
        middle_of(&own.into_iter().map(|own| own.1).collect::<Vec<_>>())
    }

    /// Median luminance by radius (limbus radii) on the nose's side (1) or the temple's (−1), in steps of a hundredth from 0.7 to 1.4.
    fn profile(&self, side: f64) -> Vec<(f64, f64)> {
        (0..70)
            .map(|step| {
                let from = 0.7 + 0.01 * f64::from(step);
                let ring = self.where_is(|r, angle| {
                    (from..from + 0.01).contains(&r)
                        && side * angle.cos() > 0.0
                        && angle.sin().abs() < 0.3
                        && angle.sin() > -0.1
                });
                (
                    from + 0.005,
                    median(ring.iter().map(|c| luminance(*c)).collect()),
                )
            })
            .collect()
    }
}

fn place(index: usize, size: u32) -> DVec2 {
    let [x, y] = [index as u32 % size, index as u32 / size];
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// Where 10 and 90 % of the step of luminance from iris to white are, in limbus radii: the means of both sides, whose irides and whites may
/// differ.
fn limbal_step(picture: &Picture) -> [f64; 2] {
    let pupil = 1.1 * picture.pupil_px / picture.limbus_px;
    let [nasal, temporal] = [1.0, -1.0].map(|side| step_of(&picture.profile(side), pupil));
    [0, 1].map(|k| 0.5 * (nasal[k] + temporal[k]))
}

/// The same of one side's profile, outside a pupil: not a number where lids or pupil leave less of it.
fn step_of(profile: &[(f64, f64)], pupil: f64) -> [f64; 2] {
    let first = profile.iter().position(|p| p.0 > pupil);
    let Some(first) = first.filter(|first| *first < 20) else {
        return [f64::NAN; 2];
    };
    if profile[first..60].iter().any(|p| p.1.is_nan()) {
        return [f64::NAN; 2];
    }
    let darkest = (first..35).min_by(|a, b| profile[*a].1.total_cmp(&profile[*b].1));
    let from = &profile[darkest.unwrap_or(first)..];
    let dark = from.first().map_or(f64::NAN, |p| p.1);
    let white = from
        .iter()
        .filter(|p| p.0 < 1.3)
        .map(|p| p.1)
        .fold(0.0, f64::max);
    let crossing = |share: f64| {
        let level = dark + share * (white - dark);
        from.iter().find(|p| p.1 >= level).map_or(f64::NAN, |p| p.0)
    };
    [0.1, 0.9].map(crossing)
}

/// Dips of green along arcs of the white on both sides: how many an iris diameter of arc, and their median depth.
fn vessels(picture: &Picture) -> (f64, f64) {
    let (mut depths, mut length) = (Vec::new(), 0.0);
    for radius in [1.35, 1.5] {
        for side in [0.0, core::f64::consts::PI] {
            let steps = 240;
            let green: Vec<Option<f64>> = (0..steps)
                .map(|i| {
                    let angle = side + 0.45 * (2.0 * f64::from(i) / f64::from(steps) - 1.0);
                    let at = picture.center
                        + radius
                            * picture.limbus_px
                            * DVec2::new(picture.nose * angle.cos(), angle.sin());
                    let index = at.y as usize * picture.size as usize + at.x as usize;
                    let is_open = picture.open.get(index).copied().unwrap_or(false);
                    is_open.then(|| picture.linear[index].y)
                })
                .collect();
            // What of the arc is between the lids, in one piece.
            let green: Vec<f64> = green.into_iter().flatten().collect();
            length += 0.9 * radius / 2.0 * green.len() as f64 / f64::from(steps);
            // What is darker than both sides of it, a fiftieth of an iris away.
            let step = (0.02 * 2.0 / (0.9 * radius / f64::from(steps))) as usize;
            let mut i = step;
            while i + step < green.len() {
                let around = 0.5 * (green[i - step] + green[i + step]);
                let part = green[i - step..=i + step].iter().copied();
                if green[i] == part.fold(f64::MAX, f64::min) && green[i] < 0.96 * around {
                    depths.push(1.0 - green[i] / around);
                    // A dip counts once.
                    i += step;
                }
                i += 1;
            }
        }
    }
    (depths.len() as f64 / length, median(depths))
}

/// How skin below the eye varies: standard deviations of L*, a* and b* between patches of a tenth of an iris diameter
/// about the plane that fits them best, and that of L* between dots of a hundredth within a patch.
fn skin_varies(picture: &Picture) -> (DVec3, f64) {
    let (patch, dot) = (0.2 * picture.limbus_px, 0.02 * picture.limbus_px);
    let mean = |at: DVec2, side: f64| {
        let [low, high] =
            [at, at + side].map(|at| at.clamp(DVec2::ZERO, DVec2::splat(f64::from(picture.size))));
        let (low, high) = (low.as_uvec2(), high.as_uvec2());
        let pixels = (low.y..high.y)
            .flat_map(|y| (low.x..high.x).map(move |x| (y * picture.size + x) as usize));
        let (sum, count) = pixels.fold((DVec3::ZERO, 0.0), |(sum, count), i| {
            (sum + picture.linear[i], count + 1.0)
        });
        DVec3::from(linear_srgb_to_lab((sum / f64::max(count, 1.0)).to_array()))
    };
    let corner = picture.center + DVec2::new(-1.6, 1.7) * picture.limbus_px;
    let (columns, rows) = (
        16,
        ((f64::from(picture.size) - 1.0 - corner.y) / patch).clamp(0.0, 4.0) as u32,
    );
    let dots = (patch / dot) as u32;
    let (mut patches, mut fine) = (Vec::new(), Vec::new());
    for row in 0..rows {
        for column in 0..columns {
            let at = corner + DVec2::new(column.into(), row.into()) * patch;
            let own = mean(at, patch);
            patches.push((DVec3::new(column.into(), row.into(), 1.0), own));
            let offsets =
                (0..dots * dots).map(|k| DVec2::new((k % dots).into(), (k / dots).into()));
            fine.extend(offsets.map(|off| (mean(at + off * dot, dot).x - own.x).powi(2)));
        }
    }
    let root = |squares: f64, count: usize| f64::sqrt(squares / count.max(1) as f64);
    let normal = patches.iter().fold(DMat3::ZERO, |sum, (at, _)| {
        sum + DMat3::from_cols(*at * at.x, *at * at.y, *at * at.z)
    });
    let coarse = [0, 1, 2].map(|channel| {
        let plane = normal.inverse()
            * patches
                .iter()
                .map(|(at, lab)| *at * lab[channel])
                .sum::<DVec3>();
        let squares = patches
            .iter()
            .map(|(at, lab)| (lab[channel] - plane.dot(*at)).powi(2));
        root(squares.sum(), patches.len())
    });
    (DVec3::from(coarse), root(fine.iter().sum(), fine.len()))
}

fn rows(picture: &Picture) -> ([DVec3; 2], Vec<LookRow>) {
    let row = |quantity, unit, ours: f64, photographs, (from, to): (f64, f64)| {
        let ours = Some(ours).filter(|ours| ours.is_finite());
        let within = ours.map(|ours| (from..=to).contains(&ours));
        let null_reasons = match ours {
            Some(_) => BTreeMap::new(),
            None => ["ours", "within"]
                .map(|key| (key, "nothing of it is seen in the picture"))
                .into(),
        };
        LookRow {
            quantity,
            unit,
            ours,
            photographs,
            from,
            to,
            within,
            null_reasons,
        }
    };
    let pupil_share = picture.pupil_px / picture.limbus_px;
    // Below the middle, where neither lids nor lamps are.
    let below = |angle: f64| (0.45..2.7).contains(&angle);
    let ring = picture.where_is(|r, angle| r > 1.15 * pupil_share && r < 0.85 && below(angle));
    // Not a number where a pupil leaves nothing of it.
    let mean = |all: &[DVec3]| all.iter().sum::<DVec3>() / all.len() as f64;
    let iris = mean(&ring);
    let lightness: Vec<f64> = ring
        .iter()
        .map(|c| linear_srgb_to_lab(c.to_array())[0])
        .collect();
    let count = lightness.len() as f64;
    let middle = lightness.iter().sum::<f64>() / count;
    let deviation = f64::sqrt(lightness.iter().map(|l| (l - middle).powi(2)).sum::<f64>() / count);
    let within = |from: f64, to: f64| {
        // Aside, below the lamps, where no lid covers it.
        let aside = |angle: f64| angle.sin() > 0.05 && angle.sin() < 0.5;
        let from = from.max(1.15 * pupil_share);
        let part = picture.where_is(|r, angle| (from..to).contains(&r) && aside(angle));
        luminance(mean(&part))
    };
    let sclera = 0.5 * (picture.patch(1.3, 0.1, 0.07) + picture.patch(-1.3, 0.1, 0.07));
    let corner = picture.patch(1.75, 0.0, 0.08);
    let skin = picture.skin(0.0, 1.75, 0.15);
    let lab = |c: DVec3| linear_srgb_to_lab(c.to_array());
    let cornea = picture.where_is(|r, _| r < 1.0);
    let lit = match cornea.len() {
        0 => f64::NAN,
        _ => cornea.iter().filter(|c| luminance(**c) > 0.75).count() as f64,
    };
    let area = core::f64::consts::PI * picture.limbus_px.powi(2);
    let (crossings, contrast) = vessels(picture);
    let pupil = luminance(picture.patch(0.0, 0.0, 0.5 * pupil_share));
    let (varies, fine) = skin_varies(picture);
    let [limbus_from, limbus_to] = limbal_step(picture);
    let rows = vec![
        row(
            "iris, standard deviation of L*",
            "L*",
            deviation,
            6.5,
            (4.4, 12.7),
        ),
        row(
            "iris Y against the white's",
            "1",
            luminance(iris) / luminance(sclera),
            0.21,
            (0.03, 0.6),
        ),
        row(
            "outer iris 0.88 to 0.97 R against mid-iris, Y",
            "1",
            within(0.88, 0.97) / within(0.5, 0.75),
            0.9,
            (0.15, 4.8),
        ),
        row(
            "limbus, 10 to 90 % of the step",
            "R",
            limbus_to - limbus_from,
            0.123,
            (0.104, 0.158),
        ),
        row(
            "limbus, middle of that step",
            "R",
            0.5 * (limbus_from + limbus_to),
            1.011,
            (0.949, 1.073),
        ),
        row(
            "white, red over green (linear)",
            "1",
            sclera.x / sclera.y,
            1.20,
            (1.05, 1.35),
        ),
        row(
            "white, blue over red (linear)",
            "1",
            sclera.z / sclera.x,
            0.67,
            (0.58, 0.85),
        ),
        row(
            "white Y against the skin's",
            "1",
            luminance(sclera) / luminance(skin),
            1.06,
            (0.3, 2.5),
        ),
        row(
            "white, less red than the skin (a)",
            "a",
            lab(skin)[1] - lab(sclera)[1],
            14.0,
            (2.0, 24.0),
        ),
        row(
            "white, less yellow than the skin (b)",
            "b",
            lab(skin)[2] - lab(sclera)[2],
            11.0,
            (-9.0, 23.0),
        ),
        row(
            "white near the inner corner, Y against its middle",
            "1",
            luminance(corner) / luminance(sclera),
            0.67,
            (0.14, 0.81),
        ),
        row(
            "white near the inner corner, redder (a)",
            "a",
            lab(corner)[1] - lab(sclera)[1],
            11.0,
            (-1.0, 20.0),
        ),
        row(
            "vessels that cross an arc",
            "per D",
            crossings,
            11.0,
            (4.0, 18.0),
        ),
        row("vessels, loss of green", "1", contrast, 0.10, (0.05, 0.36)),
        row("pupil, Y", "1", pupil, 0.009, (0.0, 0.043)),
        row("pupil over iris", "1", pupil_share, 0.29, (0.19, 0.47)),
        row(
            "catch-lights, equivalent diameter",
            "D",
            f64::sqrt(lit / area),
            0.095,
            (0.036, 0.15),
        ),
        row(
            "skin over 0.2 to 2 D, standard deviation of L*",
            "L*",
            varies.x,
            3.4,
            (2.7, 4.7),
        ),
        row(
            "skin over 0.2 to 2 D, standard deviation of a*",
            "a*",
            varies.y,
            1.7,
            (1.0, 2.9),
        ),
        row(
            "skin over 0.2 to 2 D, standard deviation of b*",
            "b*",
            varies.z,
            1.9,
            (1.2, 5.0),
        ),
        row(
            "skin over 0.02 to 0.1 D, standard deviation of L*",
            "L*",
            fine,
            2.8,
            (2.3, 5.6),
        ),
    ];
    ([iris, sclera], rows)
}

/// The lids' margins, as the shaders have them.
fn margins(world: &mut World) -> LidMargins {
    let mut parts = world.query::<&MeshMaterial3d<GlobeMaterial>>();
    let materials = world.resource::<Assets<GlobeMaterial>>();
    let first = parts.iter(world).find_map(|part| materials.get(&part.0));
    first.map_or_else(Default::default, |material| material.globe.lids)
}

/// Renders the patient's eye from the front in a window's light and measures it.
///
/// # Errors
/// Without a device, or where its picture cannot be made.
pub fn looks(patient: &PatientFile) -> Result<Looks, HeadlessError> {
    super::headless::require_device()?;
    let scene = BuiltIn::Chart.build();
    let scene = scene.map_err(|error| HeadlessError::ReadBack(error.to_string()))?;
    let scene = LoadedScene::Model(Box::new(scene));
    let mut file = patient.clone();
    // What is shown is the middle of the cornea.
    file.angle_alpha_deg = [0.0, 0.0];
    let light = crate::stage::PanelLight::default();
    let session = Session {
        light,
        ..Session::new(file, scene, 1)
    };
    let mut headless = Headless::new(
        session,
        [UVec2::splat(SIDE), UVec2::splat(16)],
        [true, false],
    )?;
    headless.set_orbit(EyeOrbit {
        azimuth_deg: 0.0,
        elevation_deg: 0.0,
        distance_mm: DISTANCE_MM,
    });
    headless
        .world()
        .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
            azimuth_rad: 0.0,
            elevation_rad: 0.0,
            distance_m: 1000.0,
        }));
    headless.go_to(0.05);
    headless.go_to(0.5);
    let drawn = headless.panel(Which::Eye)?;
    let camera = headless.stage().eye;
    let fov = match headless.world().get::<Projection>(camera) {
        Some(Projection::Perspective(own)) => f64::from(own.fov),
        _ => 0.5,
    };
    let px_per_mm = f64::from(SIDE) / (2.0 * (0.5 * fov).tan() * f64::from(DISTANCE_MM));
    // A right eye's nose is to the right of who looks at it.
    let nose = if patient.eye == Laterality::OD {
        1.0
    } else {
        -1.0
    };
    let lids = margins(headless.world());
    let limbus_mm = patient.limbus_radius_mm;
    // The head's x goes to its left.
    let open = |at: DVec2| {
        let shade = lids_at(&lids, DVec3::new(-at.x, -at.y, 0.0) * limbus_mm);
        shade.upper_gap > 0.0 && shade.lower_gap > 0.0
    };
    let picture = Picture::new(&drawn, limbus_mm * px_per_mm, nose, open);
    let ([iris, sclera], rows) = rows(&picture);
    let codes = |c: DVec3| (linear_to_srgb(c) * 255.0).to_array().map(f64::round);
    Ok(Looks {
        table: "looks",
        version: env!("CARGO_PKG_VERSION"),
        meaning: MEANING,
        source: "34 photographs of eyes, light to deep brown skin, 20 to 80 years",
        notes: &[
            "R and D are radius and diameter of the limbus. Photographs had no grey card: ratios are the target, colours a guide.",
            "Their means: iris sRGB 90 91 89 (blue-grey), 80 89 74 and 94 113 89 (green), 102 64 41 (hazel), 91 62 52 (brown), \
             45 31 25 (dark); white 202 186 169.",
            "white, red over green and blue over red: spread of the neutral ones among them; iris Y: from dark to pale eyes.",
            "limbus, middle of that step: from and to are where 10 and 90 % of the photographs' step are. Not measured here: lids and lashes; how far lids cover the iris. Skin is that below the eye.",
        ],
        patient: patient.name.clone(),
        light: light.name(),
        iris_srgb: codes(iris),
        sclera_srgb: codes(sclera),
        rows,
    })
}

#[cfg(test)]
mod tests;
