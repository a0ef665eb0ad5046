//! What lights an eye: a studio of its own, or the lights of the world that it stands in.

use super::eye_camera::{EyeCamera, EyeOrbit};
use super::illumination::{Illumination, Lamp, MOST_LAMPS};
use super::model::{EyeAssets, EyeLight, EyeParts, EyeSurroundings, METRES_A_MM};
use super::probe::Probed;
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
        // Bevy's point and spot lights send Φ/4π in every direction, and fade out towards their range.
        let near = |color: Color,
                    lumen: f32,
                    [radius, range]: [f32; 2],
                    transform: &GlobalTransform,
                    share: f32| {
            let towards = transform.translation() - eye;
            let distance = towards.length().max(1e-2);
            let share = share * (1.0 - (distance / range).powi(4)).max(0.0).powi(2);
            Arriving {
                direction: to_head * (towards / distance),
                over_pi: linear(color) * (share * lumen / (4.0 * PI * distance * distance * PI)),
                radius_rad: (radius / distance).atan().max(SUN_RAD),
                vergence: if distance < NEAR_M {
                    scale.x.abs() * METRES_A_MM / distance
                } else {
                    0.0
                },
            }
        };
        let points = self
            .points
            .iter()
            .filter(|point| shines(point.3) && shares(point.2, layers));
        let points = points.map(|(point, transform, ..)| {
            let size = [point.radius, point.range];
            near(point.color, point.intensity, size, transform, 1.0)
        });
        let spots = self
            .spots
            .iter()
            .filter(|spot| shines(spot.3) && shares(spot.2, layers));
        let spots = spots.map(|(spot, transform, ..)| {
            let away = (eye - transform.translation()).normalize_or(Vec3::NEG_Z);
            let angle = away.dot(transform.forward().into()).clamp(-1.0, 1.0).acos();
            let width = (spot.outer_angle - spot.inner_angle).max(1e-3);
            let share = ((spot.outer_angle - angle) / width).clamp(0.0, 1.0);
            near(
                spot.color,
                spot.intensity,
                [spot.radius, spot.range],
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

    /// The ambient light of the world, from everywhere.
    fn even(&self) -> Surroundings {
        let ambient = self.ambient.as_ref();
        let around = ambient.map_or(Vec3::ZERO, |own| linear(own.color) * own.brightness);
        Surroundings {
            is_luminance: true,
            ..Surroundings::even(around)
        }
    }

    /// Adds the world's lights at a place to what surrounds an eye there: the strongest as lamps, the rest from around.
    fn shine(
        &self,
        place: &GlobalTransform,
        layers: Option<&RenderLayers>,
        mut found: Surroundings,
    ) -> Surroundings {
        let lights = self.at(place, layers);
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
    Option<&'a Probed>,
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
    for (entity, light, own, probed, place, visibility, layers, mut parts) in &mut models {
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
            // The lamps of the world are added below, as they move more often than the map changes.
            (LitBy::World | LitBy::Own, _) => match probed.and_then(Probed::around) {
                Some(around) => around.clone(),
                None => Arc::new(lights.even()),
            },
        };
        let mut illumination = match of {
            LitBy::Studio(_) => around.illumination(),
            LitBy::Own if own.is_some() => around.illumination(),
            LitBy::World | LitBy::Own => {
                let bare = around.without_map();
                lights.shine(place, layers, bare).illumination()
            }
        };
        if let LitBy::Studio(studio) = of
            && studio.light.is_on_the_lens()
            && let Some((_, orbit)) = cameras.iter().find(|(camera, _)| camera.0 == entity)
        {
            illumination.lamps[0] = studio.light.on_the_lens(orbit);
            illumination = illumination.lighting_lids();
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
            if let Some(lit) = &mut parts.bypass_change_detection().lit {
                lit.around = around;
            }
            continue;
        }
        for (_, material) in &parts.globe {
            if let Some(mut material) = assets.globes.get_mut(material) {
                material.illumination = illumination;
                material.around = map.clone();
            }
        }
        for material in &parts.skin_materials {
            if let Some(mut material) = assets.skins.get_mut(material) {
                material.illumination = illumination;
                material.around = map.clone();
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::ecs::system::RunSystemOnce;

    /// As Bevy marks what nothing hides.
    const SEEN: InheritedVisibility = InheritedVisibility::VISIBLE;

    /// What arrives at the world's middle on a head that is turned like this.
    fn arriving(world: &mut World, head: Quat) -> Vec<Arriving> {
        world
            .run_system_once(move |lights: WorldLights| {
                lights.at(&GlobalTransform::from(Transform::from_rotation(head)), None)
            })
            .expect("it runs")
    }

    fn point(range: f32) -> PointLight {
        PointLight {
            intensity: 1000.0,
            range,
            radius: 0.1,
            color: Color::WHITE,
            ..default()
        }
    }

    /// A lamp of Φ lumen has Φ/4πd² lux at d metres; Bevy's fades out towards its range.
    #[test]
    fn a_lamp_of_the_world_shines_by_the_inverse_square_from_where_it_is() {
        let mut world = World::new();
        let lamp = world
            .spawn((point(1e6), GlobalTransform::from_xyz(0.0, 0.0, -1.0), SEEN))
            .id();
        let one = arriving(&mut world, Quat::IDENTITY)[0];
        assert!((one.over_pi - Vec3::splat(1000.0 / (4.0 * PI * PI))).length() < 1e-3);
        assert!((one.direction - Vec3::NEG_Z).length() < 1e-6);
        assert!((one.radius_rad - 0.1_f32.atan()).abs() < 1e-6);
        let put = |world: &mut World, range: f32, z: f32| {
            world
                .entity_mut(lamp)
                .insert((point(range), GlobalTransform::from_xyz(0.0, 0.0, z)));
        };
        put(&mut world, 1e6, -2.0);
        let two = arriving(&mut world, Quat::IDENTITY)[0];
        assert!((two.over_pi * 4.0 - one.over_pi).length() < 1e-3);
        // The head turns to its left: the lamp comes to its right.
        let turned = arriving(&mut world, Quat::from_rotation_y(PI / 2.0))[0];
        assert!(
            (turned.direction - Vec3::X).length() < 1e-6,
            "{}",
            turned.direction
        );
        // (1 − (d/range)⁴)² of it, and nothing from beyond the range.
        put(&mut world, 4.0, -2.0);
        let faded = arriving(&mut world, Quat::IDENTITY)[0];
        let share = (15.0_f32 / 16.0).powi(2);
        assert!((faded.over_pi - share * two.over_pi).length() < 1e-4);
        put(&mut world, 2.0, -2.01);
        assert!(arriving(&mut world, Quat::IDENTITY).is_empty());
    }

    /// A near lamp has the vergence of its place, in the eye's millimetres; a spot shines within its cone, the
    /// sun without distance, and the strongest is first.
    #[test]
    fn spots_and_suns_arrive_too() {
        let mut world = World::new();
        world.spawn((point(1e6), GlobalTransform::from_xyz(0.0, 0.0, -0.5), SEEN));
        let near = arriving(&mut world, Quat::IDENTITY)[0].vergence;
        assert!((near - METRES_A_MM / 0.5).abs() < 1e-9, "{near}");
        let spot = |outer: f32| SpotLight {
            intensity: 1e6,
            range: 1e6,
            inner_angle: 0.1,
            outer_angle: outer,
            ..default()
        };
        // It stands aside and shines past the eye, 0.3 rad from its axis.
        let aside = Transform::from_xyz(2.0, 0.0, 0.0)
            .looking_to(Vec3::new(-(0.3_f32.cos()), 0.3_f32.sin(), 0.0), Vec3::Y);
        let lamp = world
            .spawn((spot(0.2), GlobalTransform::from(aside), SEEN))
            .id();
        assert_eq!(arriving(&mut world, Quat::IDENTITY).len(), 1);
        world.entity_mut(lamp).insert(spot(0.5));
        let both = arriving(&mut world, Quat::IDENTITY);
        assert_eq!(both.len(), 2);
        // Half of the way through its edge: a quarter.
        let expected = 0.25 * 1e6 / (4.0 * PI * 4.0 * PI);
        let found = both[0].over_pi.x / linear(Color::WHITE).x;
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        world.spawn((
            DirectionalLight {
                illuminance: 1e5,
                ..default()
            },
            GlobalTransform::from(Transform::default().looking_to(Vec3::NEG_Y, Vec3::Z)),
            SEEN,
        ));
        let all = arriving(&mut world, Quat::IDENTITY);
        assert!((all[0].direction - Vec3::Y).length() < 1e-6 && all[0].vergence == 0.0);
    }
}
