//! Places that an eye may look at.
//!
//! Enters: a captured view ([`Percept`]), or a scene whose view nobody sees. Leaves: [`Candidate`]s, each
//! with its direction and the distance of what is there.

use super::view::Percept;
use crate::anatomy::gaze::GazeAngles;
use crate::anatomy::{Laterality, Patient};
use crate::motion::Candidate;
use crate::scene::catalog::LoadedScene;
use crate::scene::model::SceneModel;
use crate::scene::photo::PhotoScene;
use crate::scene::trace::{Tracer, Tree};
use bevy::math::{DVec3, UVec2, Vec2, Vec3};
use bevy::prelude::Transform;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::sync::Arc;

/// Places to look at in a view without corners.
const CHANCE_PLACES: usize = 160;
/// Corners below which an eye also looks at places by chance.
pub const FEWEST_CORNERS: usize = 8;
/// Of the angles that a scene spans from the eye, an unseen one is looked at within this tangent:
/// beyond it people turn their heads.
const LARGEST_TANGENT: f32 = 0.5;

/// The corners among which the eye chooses; in a view with hardly any, places by chance too (`seed`).
pub fn candidates_of(percept: &Percept, seed: u64) -> Vec<Candidate> {
    let captured = percept.captured();
    let size = captured.size;
    let half = percept.half_field();
    // Among a few corners an eye would soon have nowhere left to go.
    let chance = if captured.corners.len() < FEWEST_CORNERS {
        shares(seed)
            .map(|share| chance_candidate(percept.look_at(size.as_vec2() * share)))
            .collect()
    } else {
        Vec::new()
    };
    spread_out(&captured.corners, size)
        .into_iter()
        .map(|[x, y, score, vergence]| {
            let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let (azimuth_rad, elevation_rad) = direction_of(place, size, half);
            Candidate {
                azimuth_rad,
                elevation_rad,
                score: f64::from(score),
                distance_m: distance_m(f32::from_bits(vergence)),
            }
        })
        .chain(chance)
        .collect()
}

/// Places by chance in the middle of a view, where people look when nothing stands out, as shares of
/// its width and height.
fn shares(seed: u64) -> impl Iterator<Item = Vec2> {
    let mut random = Pcg64::seed_from_u64(seed ^ 0xb1a4);
    (0..CHANCE_PLACES).map(move |_| {
        let mut share = || random.random_range(0.15..0.85);
        Vec2::new(share(), share())
    })
}

fn chance_candidate((azimuth_rad, elevation_rad, distance_m): (f64, f64, f64)) -> Candidate {
    Candidate {
        azimuth_rad,
        elevation_rad,
        score: 1.0,
        distance_m,
    }
}

/// Where an eye looks whose view is not drawn, and the distance (m) straight ahead: directions by
/// chance, at the distances that the scene has there. `from` is where the head is, where that is not where a model
/// puts it, and the tree of that model.
pub fn unseen_places(
    scene: &LoadedScene,
    from: Option<(&Transform, Arc<Tree>)>,
    seed: u64,
) -> (Vec<Candidate>, f64) {
    match scene {
        LoadedScene::Model(model) => unseen(seed, half_model(model), distances_in(model, from)),
        LoadedScene::Photo(photo) => unseen(seed, half_photo(photo), distances_on(photo)),
    }
}

/// `distance_m` of a place given in tangents to the right and up.
fn unseen(seed: u64, half_field: Vec2, distance_m: impl Fn(Vec2) -> f64) -> (Vec<Candidate>, f64) {
    let half = half_field.min(Vec2::splat(LARGEST_TANGENT));
    let places = shares(seed).map(|share| {
        let tangents = (share * 2.0 - 1.0) * Vec2::new(half.x, -half.y);
        let (azimuth, elevation) = direction_of_tangents(tangents);
        chance_candidate((azimuth, elevation, distance_m(tangents)))
    });
    (places.collect(), distance_m(Vec2::ZERO))
}

fn half_model(model: &SceneModel) -> Vec2 {
    Vec2::splat((0.5 * model.eye.vertical_fov_deg.to_radians()).tan())
}

fn half_photo(photo: &PhotoScene) -> Vec2 {
    let up = (0.5 * photo.vertical_fov_deg.to_radians()).tan();
    Vec2::new(up * photo.width as f32 / photo.height as f32, up)
}

fn distances_in(model: &SceneModel, from: Option<(&Transform, Arc<Tree>)>) -> impl Fn(Vec2) -> f64 {
    let (tracer, eye, forward, right) = match from {
        Some((head, tree)) => (
            Tracer::with(model, tree),
            head.translation,
            *head.forward(),
            *head.right(),
        ),
        None => {
            let forward = Vec3::from(model.eye.forward).normalize_or(Vec3::NEG_Z);
            let up = Vec3::from(model.eye.up);
            (
                Tracer::new(model),
                Vec3::from(model.eye.position_m),
                forward,
                forward.cross(up).normalize_or(Vec3::X),
            )
        }
    };
    let up = right.cross(forward);
    move |tangents| {
        let ray = (forward + right * tangents.x + up * tangents.y).normalize_or(forward);
        tracer
            .cast(eye, ray, super::view::NEAR_M, f32::MAX)
            .map_or(f64::INFINITY, |hit| f64::from(hit.distance_m))
    }
}

fn distances_on(photo: &PhotoScene) -> impl Fn(Vec2) -> f64 {
    let half = half_photo(photo);
    move |tangents| {
        let share = (tangents / half * Vec2::new(0.5, -0.5) + 0.5).clamp(Vec2::ZERO, Vec2::ONE);
        let column = ((share.x * photo.width as f32) as u32).min(photo.width - 1);
        let row = ((share.y * photo.height as f32) as u32).min(photo.height - 1);
        f64::from(photo.depth_at_m(column, row))
    }
}

/// A place that one eye of a person has found, as her leading eye sees it.
pub fn from_the_other_eye(place: &Candidate, eye: Laterality, person: &Patient) -> Candidate {
    if !place.distance_m.is_finite() {
        return *place;
    }
    // From the leading eye to this one.
    let aside = eye.temporal_sign() * person.interpupillary_mm * 1e-3;
    let own = GazeAngles::new(place.azimuth_rad, place.elevation_rad).direction();
    let towards = own * place.distance_m + DVec3::X * aside;
    let angles = GazeAngles::of(towards);
    Candidate {
        azimuth_rad: angles.azimuth_rad,
        elevation_rad: angles.elevation_rad,
        distance_m: towards.length(),
        ..*place
    }
}

/// The strongest corners of every part of the view: a busy texture does not outvote the rest, and
/// the choice among them stays quick. Row by row, as the corners are.
fn spread_out(corners: &[[u32; 4]], size: UVec2) -> Vec<[u32; 4]> {
    const PARTS: u32 = 24;
    const PER_PART: usize = 2;
    let part = |corner: &[u32; 4]| {
        let column = corner[0] * PARTS / size.x.max(1);
        let row = corner[1] * PARTS / size.y.max(1);
        (row * PARTS + column) as usize
    };
    let mut best: Vec<Vec<usize>> = vec![Vec::new(); (PARTS * PARTS) as usize];
    for (index, corner) in corners.iter().enumerate() {
        let Some(kept) = best.get_mut(part(corner)) else {
            continue;
        };
        kept.push(index);
        // Stable: of equals the earlier one stays.
        kept.sort_by_key(|&index| std::cmp::Reverse(corners[index][2]));
        kept.truncate(PER_PART);
    }
    let mut kept: Vec<usize> = best.into_iter().flatten().collect();
    kept.sort_unstable();
    kept.into_iter().map(|index| corners[index]).collect()
}

/// Distance of a vergence; none or a negative one is infinitely far.
pub fn distance_m(vergence_d: f32) -> f64 {
    if vergence_d > 0.0 {
        1.0 / f64::from(vergence_d)
    } else {
        f64::INFINITY
    }
}

/// Azimuth and elevation (rad) of a place (pixels from the upper left) of a view.
pub fn direction_of(place: Vec2, size: UVec2, half_field: Vec2) -> (f64, f64) {
    let centred = (place / size.as_vec2().max(Vec2::ONE)) * 2.0 - 1.0;
    direction_of_tangents(centred * half_field * Vec2::new(1.0, -1.0))
}

/// Azimuth and elevation (rad) of tangents to the right and up.
fn direction_of_tangents(tangents: Vec2) -> (f64, f64) {
    let (x, y) = (f64::from(tangents.x), f64::from(tangents.y));
    (x.atan2(1.0), y.atan2(x.hypot(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::catalog::SceneSource;
    use crate::scene::photo::{PhotoDepth, PhotoScene};
    use std::sync::Arc;

    #[test]
    fn pixels_and_directions_agree() {
        let (size, half) = (UVec2::new(640, 480), Vec2::new(0.6, 0.45));
        let (azimuth, elevation) = direction_of(Vec2::new(320.0, 240.0), size, half);
        assert!(azimuth.abs() < 1e-12 && elevation.abs() < 1e-12);
        let (azimuth, elevation) = direction_of(Vec2::new(640.0, 240.0), size, half);
        // atan 0.6, to the rounding of the f32 field.
        assert!((azimuth - 0.6f64.atan()).abs() < 1e-7 && elevation.abs() < 1e-12);
        let (_, up) = direction_of(Vec2::new(320.0, 0.0), size, half);
        assert!(up > 0.4);
    }

    #[test]
    fn a_place_is_where_both_eyes_say_it_is() {
        let person = Patient::default();
        // Half a metre ahead of the left eye, which stands 63 mm to the left of the right one.
        let place = Candidate {
            azimuth_rad: 0.0,
            elevation_rad: 0.0,
            score: 7.0,
            distance_m: 0.5,
        };
        let found = from_the_other_eye(&place, Laterality::OS, &person);
        assert!((found.azimuth_rad + (0.063_f64 / 0.5).atan()).abs() < 1e-12);
        assert!((found.distance_m - 0.5_f64.hypot(0.063)).abs() < 1e-12 && found.score == 7.0);
        let far = Candidate {
            distance_m: f64::INFINITY,
            ..place
        };
        assert_eq!(
            from_the_other_eye(&far, Laterality::OS, &person).azimuth_rad,
            0.0
        );
    }

    fn photo(depth_m: PhotoDepth) -> LoadedScene {
        LoadedScene::Photo(Arc::new(PhotoScene {
            name: "p".into(),
            width: 40,
            height: 20,
            course: None,
            rgb16_srgb: vec![0; 2400],
            depth_m,
            vertical_fov_deg: 20.0,
            mean_luminance_cd_m2: 1.0,
            remarks: Vec::new(),
        }))
    }

    #[test]
    fn an_eye_alone_looks_at_what_is_there() {
        let (places, ahead_m) = unseen_places(&photo(PhotoDepth::Constant(0.4)), None, 1);
        let near = f64::from(0.4f32);
        assert_eq!((places.len(), ahead_m), (CHANCE_PLACES, near));
        // Upper and lower edge stand 10° from the middle, of which 0.7 are looked at.
        let largest = (0.7 * 10f64.to_radians().tan()).atan();
        let highest = places
            .iter()
            .map(|p| p.elevation_rad.abs())
            .fold(0.0, f64::max);
        assert!(
            highest < largest + 1e-6 && highest > 0.9 * largest,
            "{highest}"
        );
        assert!(places.iter().all(|place| place.distance_m == near));

        // Near on the left, far on the right.
        let map = (0..800)
            .map(|i| if i % 40 < 20 { 0.5 } else { f32::INFINITY })
            .collect();
        let (places, _) = unseen_places(&photo(PhotoDepth::Map(map)), None, 1);
        for place in places {
            let wanted = if place.azimuth_rad < 0.0 {
                0.5
            } else {
                f64::INFINITY
            };
            assert_eq!(place.distance_m, wanted, "{place:?}");
        }
        assert_ne!(
            unseen_places(&photo(PhotoDepth::Constant(0.4)), None, 2).0[0].azimuth_rad,
            unseen_places(&photo(PhotoDepth::Constant(0.4)), None, 1).0[0].azimuth_rad,
        );
    }

    #[test]
    fn an_eye_alone_in_a_room_looks_no_further_than_its_walls() {
        let room = SceneSource::resolve("room", None).expect("a built-in scene");
        let (places, ahead_m) = unseen_places(&room, None, 1);
        let LoadedScene::Model(model) = &room else {
            panic!("a model")
        };
        let eye = model.eye.position_m;
        let (low, high) = model.bounds().expect("a room");
        let largest = (0..3)
            .map(|k| f64::from((eye[k] - low[k]).max(high[k] - eye[k])).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(ahead_m < largest);
        assert!(
            places
                .iter()
                .all(|p| p.distance_m > 0.1 && p.distance_m < largest)
        );
        let nearest = places
            .iter()
            .map(|p| p.distance_m)
            .fold(f64::INFINITY, f64::min);
        let farthest = places.iter().map(|p| p.distance_m).fold(0.0, f64::max);
        assert!(farthest > 2.0 * nearest, "{nearest} to {farthest}");

        // A head that has turned round or gone up into the sky finds what is there.
        let tree = Tracer::new(model).tree();
        let seat = Transform::from_translation(Vec3::from(eye))
            .looking_to(Vec3::from(model.eye.forward), Vec3::from(model.eye.up));
        let (same, _) = unseen_places(&room, Some((&seat, tree.clone())), 1);
        for (one, other) in places.iter().zip(&same) {
            assert!((one.distance_m / other.distance_m - 1.0).abs() < 1e-4);
        }
        let sky = Transform::from_xyz(0.0, 50.0, 0.0).looking_to(Vec3::Y, Vec3::X);
        let (above, ahead_m) = unseen_places(&room, Some((&sky, tree)), 1);
        assert!(ahead_m == f64::INFINITY && above.iter().all(|p| p.distance_m == f64::INFINITY));
    }
}
