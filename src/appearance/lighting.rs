//! What lights an eye: a studio of its own, or the lights of the world that it stands in.

use super::materials::Studio;
use super::model::{EyeAssets, EyeLight, EyeParts};
use bevy::camera::visibility::RenderLayers;
use bevy::light::GlobalAmbientLight;
use bevy::prelude::*;
use core::f32::consts::PI;

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
        let (_, head, eye) = place.to_scale_rotation_translation();
        let to_head = head.inverse();
        let suns = self
            .suns
            .iter()
            .filter(|sun| shines(sun.3) && shares(sun.2, layers));
        let suns = suns.map(|(sun, transform, ..)| Arriving {
            direction: to_head * -Vec3::from(transform.forward()),
            over_pi: linear(sun.color) * (sun.illuminance / PI),
            radius_rad: SUN_RAD,
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

    /// The world's lights at a place as the studio that an eye there stands in.
    fn studio(&self, place: &GlobalTransform, layers: Option<&RenderLayers>) -> Studio {
        let lights = self.at(place, layers);
        let lamp = |index: usize| {
            lights.get(index).copied().unwrap_or(Arriving {
                direction: Vec3::new(0.0, 0.6, -0.8),
                over_pi: Vec3::ZERO,
                radius_rad: SUN_RAD,
            })
        };
        let (key, fill) = (lamp(0), lamp(1));
        let mut surroundings = [Vec3::ZERO; 2];
        if let Some(ambient) = &self.ambient {
            surroundings = [linear(ambient.color) * ambient.brightness; 2];
        }
        for light in lights.iter().skip(2) {
            // What falls on a surface that faces anywhere: a quarter of it, more from its own side.
            for (sign, half) in [1.0, -1.0].into_iter().zip(&mut surroundings) {
                *half += light.over_pi * (0.25 * (1.0 + sign * light.direction.y));
            }
        }
        Studio {
            key_direction: key.direction,
            key_radius: key.radius_rad,
            key_color: key.over_pi,
            exposure: 1.0,
            fill_direction: fill.direction,
            fill_radius: fill.radius_rad,
            fill_color: fill.over_pi,
            is_window: 0.0,
            ambient_up: surroundings[0],
            is_luminance: 1.0,
            ambient_down: surroundings[1],
            unused: 0.0,
        }
    }
}

/// Hands each eye the light that falls on it, where that has changed.
pub fn light_eyes(
    mut models: Query<(
        &EyeLight,
        &GlobalTransform,
        &Visibility,
        Option<&RenderLayers>,
        &mut EyeParts,
    )>,
    lights: WorldLights,
    mut assets: EyeAssets,
) {
    for (light, place, visibility, layers, mut parts) in &mut models {
        if *visibility == Visibility::Hidden {
            continue;
        }
        let studio = match light {
            EyeLight::Studio(studio) => *studio,
            EyeLight::World => lights.studio(place, layers),
        };
        if parts.studio == Some(studio) {
            continue;
        }
        parts.studio = Some(studio);
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.globe.studio = studio;
            }
        }
        if let Some(mut material) = assets.skins.get_mut(&parts.skin_material) {
            material.skin.studio = studio;
        }
        if let Some(mut material) = assets.hairs.get_mut(&parts.hair_material) {
            material.hair.studio = studio;
        }
        if let Some(mut material) = assets.tears.get_mut(&parts.meniscus_material) {
            material.meniscus.studio = studio;
        }
    }
}
