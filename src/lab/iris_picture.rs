//! How far the drawn iris is from paths in f64, for `ocularium measure iris-picture`.
//!
//! In: a patient. Out: one JSON object with a row for each view, pupil, light and way of computing it: how far apart (pixels) and how different
//! (share of the mean radiance) the device's picture and [`paths`] of the same eye are, and how much of that is left when
//! the shader's own closed forms are computed in f64.
//!
//! The paths go through the same maps, cornea, lamps and layers, without what makes a picture quick: the view meets the relief by
//! steps of 4 µm; what is scattered once is summed along it in steps of 4 to 10 µm; the light of each step is solved by Fermat's
//! principle at its own place and depth, and goes there through all of the tissue in its way. What is scattered more than
//! once, the light of the sky, what surfaces mirror and how lids shade are the shader's own terms.

mod paths;
mod seen;

use super::headless::{Headless, HeadlessError};
use crate::appearance::{
    EyeOrbit, EyeQuality, EyeShading, GlobeMaterial, HairMaterial, MeniscusMaterial, SkinMaterial,
    StudioLight,
};
use crate::motion::MotionCommand;
use crate::motion::engine::GazeCommand;
use crate::patients::{FIELDS, PatientFile, PupilSetting};
use crate::scene::catalog::{BuiltIn, LoadedScene};
use crate::stage::{PanelLight, Session};
use bevy::math::{DVec2, DVec3, UVec2};
use bevy::prelude::*;
pub use seen::IrisPicture;
use seen::SeenIris;
use serde::Serialize;
use std::time::Instant;

/// Pixels along a side, and the camera's distance, mm: an iris is 148 pixels wide.
const SIDE: u32 = 256;
const DISTANCE_MM: f32 = 45.0;
/// From where it is looked at, degrees to the temple.
pub const ANGLES_DEG: [f32; 3] = [0.0, 30.0, 60.0];
/// Entrance pupils, mm.
pub const PUPILS_MM: [f64; 3] = [2.0, 4.0, 8.0];
/// A light that is far and one that is near.
pub const LIGHTS: [StudioLight; 2] = [StudioLight::Window, StudioLight::Penlight];
/// How the iris is computed.
pub const SHADINGS: [EyeShading; 2] = [EyeShading::Fast, EyeShading::Full];
/// Tiles along a side in which the two are laid over each other.
const TILES: usize = 4;
/// Fewest pixels of a tile that say where it is.
const TILE_PIXELS: usize = 150;

/// What the table holds.
pub const MEANING: &str = "How far the drawn iris is from paths of light in f64 through the same eye: place and radiance, at three \
                           views, three pupils, in distant and near light";

/// A picture beside its paths.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PictureRow {
    /// Of the camera from the face's direction, degrees to the temple.
    pub angle_deg: f32,
    /// Diameter of the entrance pupil, mm.
    pub pupil_mm: f64,
    /// The light.
    pub light: &'static str,
    /// How the picture was computed.
    pub shading: &'static str,
    /// How it differs.
    #[serde(flatten)]
    pub difference: PictureDifference,
}

/// The table.
#[derive(Clone, Debug, Serialize)]
pub struct IrisPictures {
    table: &'static str,
    version: &'static str,
    meaning: &'static str,
    notes: &'static [&'static str],
    patient: String,
    device: String,
    /// The pictures.
    pub rows: Vec<PictureRow>,
}

/// An app that shows the iris alone, as radiance.
pub struct IrisStage {
    headless: Headless,
    image: Handle<Image>,
    time_s: f64,
}

/// Everything about an eye but its globe.
type NotGlobe = Or<(
    With<MeshMaterial3d<SkinMaterial>>,
    With<MeshMaterial3d<HairMaterial>>,
    With<MeshMaterial3d<MeniscusMaterial>>,
)>;

impl IrisStage {
    /// The leading eye of a patient, in this light.
    ///
    /// # Errors
    /// Without a device, or where its picture cannot be made.
    pub fn new(patient: &PatientFile, light: StudioLight) -> Result<Self, HeadlessError> {
        super::headless::require_device()?;
        let scene = BuiltIn::Chart.build();
        let scene = scene.map_err(|error| HeadlessError::ReadBack(error.to_string()))?;
        let session = Session {
            light: PanelLight::Studio(light),
            ..Session::new(patient.clone(), LoadedScene::Model(Box::new(scene)), 1)
        };
        let (mut headless, image) = Headless::with_radiance(session, UVec2::splat(SIDE))?;
        let world = headless.world();
        let mut parts = world.query_filtered::<Entity, NotGlobe>();
        let mut hidden: Vec<Entity> = parts.iter(world).collect();
        // The conjunctiva hangs over the limbus.
        let mut globes = world.query::<(Entity, &MeshMaterial3d<GlobeMaterial>)>();
        let materials = world.resource::<Assets<GlobeMaterial>>();
        let is_cornea = |part: &MeshMaterial3d<GlobeMaterial>| {
            materials
                .get(&part.0)
                .is_some_and(|own| own.part.is_corneal())
        };
        let others = globes.iter(world).filter(|(_, part)| !is_cornea(part));
        hidden.extend(others.map(|(entity, _)| entity));
        for part in hidden {
            world.entity_mut(part).insert(Visibility::Hidden);
        }
        world.write_message(MotionCommand::Gaze(GazeCommand::Fixed {
            azimuth_rad: 0.0,
            elevation_rad: 0.0,
            distance_m: 1000.0,
        }));
        Ok(Self {
            headless,
            image,
            time_s: 0.0,
        })
    }

    /// What draws.
    pub fn device(&self) -> String {
        self.headless.adapter()
    }

    /// Goes to this side of it, a little later.
    ///
    /// # Errors
    /// Where the device cannot draw it.
    pub fn look_from(&mut self, angle_deg: f32) -> Result<(), HeadlessError> {
        self.headless.set_orbit(EyeOrbit {
            azimuth_deg: angle_deg,
            elevation_deg: 0.0,
            distance_mm: DISTANCE_MM,
        });
        for _ in 0..3 {
            self.time_s += 0.5;
            self.headless.go_to(self.time_s);
            self.headless.warm_up()?;
        }
        Ok(())
    }

    /// Draws it in this way: what is needed to do the same in f64, and the radiances of the device, row by row.
    ///
    /// # Errors
    /// Where the device does not hand them over.
    pub fn picture(
        &mut self,
        shading: EyeShading,
    ) -> Result<(IrisPicture, Vec<DVec3>), HeadlessError> {
        self.headless.set_quality(EyeQuality {
            shading,
            ..EyeQuality::PLAIN
        });
        // Another light or way may want a pipeline of its own.
        for _ in 0..3 {
            self.headless.warm_up()?;
        }
        let radiances = self.headless.radiances(&self.image)?;
        let picture = IrisPicture::of(&mut self.headless, UVec2::splat(SIDE))?;
        Ok((picture, radiances))
    }
}

fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Root mean square of the difference of all channels, and its mean, over the mean of `truth`.
fn difference(found: &[DVec3], truth: &[DVec3]) -> (f64, f64) {
    let all = || found.iter().zip(truth);
    let count = truth.len().max(1) as f64;
    let mean = truth.iter().map(|c| c.element_sum()).sum::<f64>() / (3.0 * count);
    let squares = all().map(|(a, b)| (*a - *b).length_squared()).sum::<f64>() / (3.0 * count);
    let off = all().map(|(a, b)| (*a - *b).element_sum()).sum::<f64>() / (3.0 * count);
    (squares.sqrt() / mean.max(1e-12), off / mean.max(1e-12))
}

/// How far (pixels) the part of a picture in these pixels lies from the same in another: the step that makes both most alike, by
/// the gradient of the other (Lucas and Kanade 1981). `None` where too little is there to say.
fn step_between(at: &[usize], found: &[f64], truth: &[f64]) -> Option<DVec2> {
    let side = SIDE as usize;
    let (mut xx, mut xy, mut yy, mut right) = (0.0, 0.0, 0.0, DVec2::ZERO);
    // What is brighter all over is not elsewhere.
    let mean = |values: &[f64]| at.iter().map(|&i| values[i]).sum::<f64>() / at.len() as f64;
    let level = mean(found) / mean(truth).max(1e-12);
    let mut count = 0;
    for &i in at {
        let around = [i - 1, i + 1, i - side, i + side];
        if around.iter().any(|j| !truth[*j].is_finite()) {
            continue;
        }
        let slope = 0.5
            * DVec2::new(
                truth[around[1]] - truth[around[0]],
                truth[around[3]] - truth[around[2]],
            );
        let off = found[i] / level.max(1e-12) - truth[i];
        xx += slope.x * slope.x;
        xy += slope.x * slope.y;
        yy += slope.y * slope.y;
        right -= slope * off;
        count += 1;
    }
    let determinant = xx * yy - xy * xy;
    (count >= TILE_PIXELS && determinant > 1e-3 * (xx + yy).powi(2))
        .then(|| DVec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant)
}

/// How a picture differs from its paths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureDifference {
    /// Pixels that show nothing but iris.
    pub pixels: usize,
    /// Largest distance (pixels) between a part of the iris in the picture and the same by paths.
    pub place_px: f64,
    /// Root mean square of the difference of radiances, % of their mean.
    pub rms_percent: f64,
    /// By how much the picture is brighter than the paths, %.
    pub bias_percent: f64,
    /// The root mean square between the picture and the shader's closed forms in f64, %.
    pub rounding_percent: f64,
    /// Time of the paths, microseconds a pixel on one thread.
    pub paths_us_a_pixel: f64,
}

/// The paths of all pixels of a picture that show nothing but iris.
pub struct IrisPaths<'a> {
    picture: &'a IrisPicture,
    pixels: Vec<(usize, SeenIris)>,
    radiances: Vec<DVec3>,
    us_a_pixel: f64,
}

impl<'a> IrisPaths<'a> {
    /// Follows them, on all processors.
    pub fn of(picture: &'a IrisPicture) -> Self {
        let started = Instant::now();
        let pixels: Vec<(usize, SeenIris)> = (0..(SIDE * SIDE) as usize)
            .filter_map(|i| Some((i, picture.seen(i)?)))
            .collect();
        let workers = std::thread::available_parallelism().map_or(1, |count| count.get());
        let share = pixels.len().div_ceil(workers).max(1);
        let radiances = std::thread::scope(|scope| {
            let parts = pixels.chunks(share).map(|part| {
                scope.spawn(move || {
                    let of = |(_, seen): &(usize, SeenIris)| picture.by_paths(seen);
                    part.iter().map(of).collect::<Vec<_>>()
                })
            });
            let parts: Vec<_> = parts.collect();
            // A thread that panics has a defect, which is passed on.
            let join = |part: std::thread::ScopedJoinHandle<'_, Vec<DVec3>>| match part.join() {
                Ok(radiances) => radiances,
                Err(defect) => std::panic::resume_unwind(defect),
            };
            parts.into_iter().flat_map(join).collect()
        });
        let took_us = started.elapsed().as_secs_f64() * 1e6 * workers as f64;
        Self {
            picture,
            us_a_pixel: took_us / pixels.len().max(1) as f64,
            pixels,
            radiances,
        }
    }

    /// Largest distance (pixels) between a tile of a picture and the same by paths.
    fn place_px(&self, found: &[DVec3]) -> f64 {
        let side = SIDE as usize;
        let spread = |of: &[DVec3]| {
            let mut values = vec![f64::NAN; side * side];
            for ((i, _), c) in self.pixels.iter().zip(of) {
                values[*i] = luminance(*c);
            }
            values
        };
        let (found, paths) = (spread(found), spread(&self.radiances));
        let (mut low, mut high) = ((side, side), (0, 0));
        for (i, _) in &self.pixels {
            let (x, y) = (i % side, i / side);
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x + 1), high.1.max(y + 1));
        }
        let mut tiles = vec![Vec::new(); TILES * TILES];
        for (i, _) in &self.pixels {
            let tile = |at: usize, low: usize, high: usize| TILES * (at - low) / (high - low);
            let (x, y) = (tile(i % side, low.0, high.0), tile(i / side, low.1, high.1));
            tiles[y * TILES + x].push(*i);
        }
        let steps = tiles
            .iter()
            .filter_map(|at| step_between(at, &found, &paths));
        steps.map(DVec2::length).fold(0.0, f64::max)
    }

    /// How what a device has drawn in this way (linear, row by row) differs from them.
    pub fn beside(&self, drawn: &[DVec3], shading: EyeShading) -> PictureDifference {
        let march = shading.march();
        let pixels = self.pixels.iter();
        let found: Vec<DVec3> = pixels.clone().map(|(i, _)| drawn[*i]).collect();
        let closed: Vec<DVec3> = pixels
            .map(|(_, seen)| self.picture.by_closed_forms(seen, &march))
            .collect();
        let (rms, bias) = difference(&found, &self.radiances);
        PictureDifference {
            pixels: self.pixels.len(),
            place_px: self.place_px(&found),
            rms_percent: 100.0 * rms,
            bias_percent: 100.0 * bias,
            rounding_percent: 100.0 * difference(&found, &closed).0,
            paths_us_a_pixel: self.us_a_pixel,
        }
    }
}

/// The patient without what an artist has changed and without an arcus, which lies before the iris.
fn plain(patient: &PatientFile) -> PatientFile {
    let (mut file, neutral) = (patient.clone(), PatientFile::default());
    for field in FIELDS {
        if field.name == "arcus" {
            (field.set)(&mut file, 0.0);
        } else if let Some(own) = (field.get)(&neutral).filter(|_| field.name.starts_with("look_"))
        {
            (field.set)(&mut file, own);
        }
    }
    file
}

/// All views, pupils and lights of a patient's leading eye.
///
/// # Errors
/// Without a device, or where a picture cannot be made.
pub fn iris_pictures(
    patient: &PatientFile,
    mut done: impl FnMut(&PictureRow, usize, usize),
) -> Result<IrisPictures, HeadlessError> {
    let all = LIGHTS.len() * PUPILS_MM.len() * ANGLES_DEG.len() * SHADINGS.len();
    let (mut rows, mut device) = (Vec::new(), String::new());
    for light in LIGHTS {
        for pupil_mm in PUPILS_MM {
            let mut file = plain(patient);
            file.pupil = PupilSetting::Fixed(pupil_mm);
            let mut stage = IrisStage::new(&file, light)?;
            device = stage.device();
            for angle_deg in ANGLES_DEG {
                stage.look_from(angle_deg)?;
                // Time stands, so that they are of one eye.
                let mut drawn = Vec::new();
                let mut seen = None;
                for shading in SHADINGS {
                    let (picture, radiances) = stage.picture(shading)?;
                    drawn.push((shading, radiances));
                    seen = Some(picture);
                }
                let Some(picture) = seen else { continue };
                let paths = IrisPaths::of(&picture);
                for (shading, radiances) in drawn {
                    rows.push(PictureRow {
                        angle_deg,
                        pupil_mm,
                        light: light.name(),
                        shading: shading.name(),
                        difference: paths.beside(&radiances, shading),
                    });
                    done(&rows[rows.len() - 1], rows.len(), all);
                }
            }
        }
    }
    Ok(IrisPictures {
        table: "iris-picture",
        version: env!("CARGO_PKG_VERSION"),
        meaning: MEANING,
        notes: &[
            "Both are of the same eye: the maps, the lamps and the numbers are read back from the device.",
            "What is scattered more than once, the sky's light, what surfaces mirror and how lids shade are the shader's own terms in both; measure tissue has what is scattered more than once beside random walks.",
            "Without an artist's choices and an arcus.",
            "place: the iris in 16 tiles, each laid over the same by paths.",
        ],
        patient: patient.name.clone(),
        device,
        rows,
    })
}
