//! What lights an eye: a studio of its own, or the lights of the world that it stands in.

use super::eye_camera::{EyeCamera, EyeOrbit};
use super::illumination::{Illumination, Lamp, MOST_LAMPS};
use super::model::{EyeAssets, EyeLight, EyeParts, EyeSurroundings, METRES_A_MM};
use super::studio::Studio;
use super::surroundings::Surroundings;
use bevy::camera::visibility::RenderLayers;
use bevy::light::GlobalAmbientLight;
use bevy::prelude::*;
use core::f32::consts::PI;
use std::sync::Arc;

/// A lamp further away than this is as good as at infinity, m: across the face its direction and its light are the same to a
/// fiftieth of a radian and a twentieth.
const NEAR_M: f32 = 2.0;
/// Smallest angular radius of a lamp that is mirrored, rad: of the sun, and of what looks like a point.
const SUN_RAD: f32 = 0.00465;

/// A light as it arrives at an eye.
#[derive(Clone, Copy, Debug)]
struct Arriving {
    /// Towards it, unit, in the head's frame.
    direction: Vec3,
    /// Irradiance on a plane across it over π, cd/m², linear sRGB.
    over_pi: Vec3,
    /// Angular radius, rad.
    radius_rad: f32,
    /// One over its distance, 1/mm of the eye's own; 0 far away.
    vergence: f32,
}

impl Arriving {
    fn strength(&self) -> f32 {
        self.over_pi.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }
}

/// The lights of the world.
#[derive(bevy::ecs::system::SystemParam)]
pub struct WorldLights<'w, 's> {
    suns: Query<
        'w,
        's,
        (
            &'static DirectionalLight,
            &'static GlobalTransform,
            Option<&'static RenderLayers>,
            Option<&'static InheritedVisibility>,
        ),
    >,
    points: Query<
        'w,
        's,
        (
            &'static PointLight,
            &'static GlobalTransform,
            Option<&'static RenderLayers>,
            Option<&'static InheritedVisibility>,
        ),
    >,
    spots: Query<
        'w,
        's,
        (
            &'static SpotLight,
            &'static GlobalTransform,
            Option<&'static RenderLayers>,
            Option<&'static InheritedVisibility>,
        ),
    >,
    ambient: Option<Res<'w, GlobalAmbientLight>>,
}

fn linear(color: Color) -> Vec3 {
    let [r, g, b, _] = color.to_linear().to_f32_array();
    Vec3::new(r, g, b)
}

fn shares(one: Option<&RenderLayers>, other: Option<&RenderLayers>) -> bool {
    let all = RenderLayers::default();
    one.unwrap_or(&all).intersects(other.unwrap_or(&all))
}

/// A light that is hidden gives none.
fn shines(visibility: Option<&InheritedVisibility>) -> bool {
    visibility.is_none_or(|visibility| visibility.get())
}

impl WorldLights<'_, '_> {
    /// The lights that shine on a place of the world, strongest first.
    fn at(&self, place: &GlobalTransform, layers: Option<&RenderLayers>) -> Vec<Arriving> {
        let (scale, head, eye) = place.to_scale_rotation_translation();
        let to_head = head.inverse();
        let suns = self
            .suns
            .iter()
            .filter(|sun| shines(sun.3) && shares(sun.2, layers));
        let suns = suns.map(|(sun, transform, ..)| Arriving {
            direction: to_head * -Vec3::from(transform.forward()),
            over_pi: linear(sun.color) * (sun.illuminance / PI),
            radius_rad: SUN_RAD,
            vergence: 0.0,
        });
        // Bevy's point and spot lights send Φ/4π in every direction.
        let near =
            |color: Color, lumen: f32, radius: f32, transform: &GlobalTransform, share: f32| {
                let towards = transform.translation() - eye;
                let distance = towards.length().max(1e-2);
                Arriving {
                    direction: to_head * (towards / distance),
                    over_pi: linear(color)
                        * (share * lumen / (4.0 * PI * distance * distance * PI)),
                    radius_rad: (radius / distance).atan().max(SUN_RAD),
                    vergence: if distance < NEAR_M {
                        scale.x.abs() * METRES_A_MM / distance
                    } else {
                        0.0
                    },
                }
            };
        let points = self.points.iter().filter(|point| {
            let reaches = point.1.translation().distance(eye) < point.0.range;
            reaches && shines(point.3) && shares(point.2, layers)
        });
        let points = points.map(|(point, transform, ..)| {
            near(point.color, point.intensity, point.radius, transform, 1.0)
        });
        let spots = self.spots.iter().filter(|spot| {
            let reaches = spot.1.translation().distance(eye) < spot.0.range;
            reaches && shines(spot.3) && shares(spot.2, layers)
        });
        let spots = spots.map(|(spot, transform, ..)| {
            let away = (eye - transform.translation()).normalize_or(Vec3::NEG_Z);
            let angle = away.dot(transform.forward().into()).clamp(-1.0, 1.0).acos();
            let width = (spot.outer_angle - spot.inner_angle).max(1e-3);
            let share = ((spot.outer_angle - angle) / width).clamp(0.0, 1.0);
            near(
                spot.color,
                spot.intensity,
                spot.radius,
                transform,
                share * share,
            )
        });
        let mut lights: Vec<Arriving> = suns
            .chain(points)
            .chain(spots)
            .filter(|light| light.strength() > 0.0 && light.strength().is_finite())
            .collect();
        lights.sort_by(|a, b| b.strength().total_cmp(&a.strength()));
        lights
    }

    /// The world's lights at a place as what surrounds an eye there: the strongest as lamps, the rest and the
    /// ambient light from everywhere.
    fn surroundings(&self, place: &GlobalTransform, layers: Option<&RenderLayers>) -> Surroundings {
        let lights = self.at(place, layers);
        let mut around = Vec3::ZERO;
        if let Some(ambient) = &self.ambient {
            around += linear(ambient.color) * ambient.brightness;
        }
        let mut found = Surroundings::even(around);
        found.is_luminance = true;
        found.lamps = lights
            .iter()
            .take(MOST_LAMPS)
            .map(|light| Lamp {
                direction: light.direction,
                radius: light.radius_rad,
                color: light.over_pi,
                hole: 0.0,
                vergence: light.vergence,
            })
            .collect();
        for light in lights.iter().skip(MOST_LAMPS) {
            found.spread(light.direction, light.over_pi);
        }
        found
    }
}

/// What surrounds an eye, and the map that it is drawn with.
#[derive(Clone, Debug)]
pub(super) struct Lit {
    of: LitBy,
    around: Arc<Surroundings>,
    pub(super) map: Handle<Image>,
    pub(super) illumination: Illumination,
}

/// By what it is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum LitBy {
    World,
    Studio(Studio),
    Own,
}

/// What of a model decides its light.
type Lightable<'a> = (
    Entity,
    &'a EyeLight,
    Option<&'a EyeSurroundings>,
    &'a GlobalTransform,
    &'a Visibility,
    Option<&'a RenderLayers>,
    &'a mut EyeParts,
);

/// Hands each eye the light that falls on it, where that has changed.
pub fn light_eyes(
    mut models: Query<Lightable>,
    cameras: Query<(&EyeCamera, &EyeOrbit)>,
    lights: WorldLights,
    mut assets: EyeAssets,
) {
    for (entity, light, own, place, visibility, layers, mut parts) in &mut models {
        if *visibility == Visibility::Hidden {
            continue;
        }
        let of = match light {
            EyeLight::Studio(studio) => LitBy::Studio(*studio),
            EyeLight::Surroundings if own.is_some() => LitBy::Own,
            EyeLight::Surroundings | EyeLight::World => LitBy::World,
        };
        let known = parts.lit.as_ref().filter(|lit| lit.of == of);
        let around = match (of, known) {
            (LitBy::Studio(_), Some(lit)) => lit.around.clone(),
            (LitBy::Studio(studio), None) => Arc::new(studio.surroundings()),
            (LitBy::Own, _) if let Some(own) = own => own.0.clone(),
            (LitBy::World | LitBy::Own, _) => Arc::new(lights.surroundings(place, layers)),
        };
        let mut illumination = around.illumination();
        if let LitBy::Studio(studio) = of
            && studio.light.is_on_the_lens()
            && let Some((_, orbit)) = cameras.iter().find(|(camera, _)| camera.0 == entity)
        {
            illumination.lamps[0] = studio.light.on_the_lens(orbit);
        }
        let map = match known {
            Some(lit)
                if Arc::ptr_eq(&lit.around, &around) || lit.around.levels == around.levels =>
            {
                lit.map.clone()
            }
            _ => assets.images.add(around.image()),
        };
        let is_lit = known.is_some_and(|lit| lit.illumination == illumination && lit.map == map);
        if is_lit {
            continue;
        }
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.illumination = illumination;
                material.around = map.clone();
            }
        }
        if let Some(mut material) = assets.skins.get_mut(&parts.skin_material) {
            material.illumination = illumination;
            material.around = map.clone();
        }
        if let Some(mut material) = assets.hairs.get_mut(&parts.hair_material) {
            material.illumination = illumination;
            material.around = map.clone();
        }
        if let Some(mut material) = assets.tears.get_mut(&parts.meniscus_material) {
            material.illumination = illumination;
            material.around = map.clone();
        }
        parts.lit = Some(Lit {
            of,
            around,
            map,
            illumination,
        });
    }
}
