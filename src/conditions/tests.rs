//! Conditions on entities: written, changed, taken away, several at once, and of other crates.

use super::*;
use crate::anatomy::{Effective, Eye, EyeOf, Laterality, Patient, Sclera};

/// A condition that no list of ours names: every dioptre of it is one of short sight, and it turns the
/// iris blue.
#[derive(Component, Clone, PartialEq)]
struct Borrowed(f64);

impl Condition for Borrowed {
    const TITLE: &'static str = "Borrowed";

    fn onset() -> Self {
        Self(1.0)
    }

    fn controls() -> &'static [Control<Self>] {
        &[]
    }

    fn write(&self, affected: &mut Affected) {
        affected.refraction.sphere_d -= self.0;
        affected.iris.color = crate::anatomy::IrisColor::Blue;
        affected.lids.opening *= 0.5;
    }

    fn caption(&self) -> String {
        String::new()
    }
}

pub(super) fn iris() -> Iris {
    Iris {
        color: crate::anatomy::IrisColor::Brown,
        stroma_melanin_fraction: None,
        border_layer_melanin_fraction: None,
        collarette_melanin_fraction: None,
        eumelanin_ratio: None,
        depth_mm: 3.6,
        cone_deg: crate::anatomy::IRIS_CONE_DEG,
        bowing_mm: None,
        root_radius_mm: 6.05,
        freckles: 0.0,
        sector_deg: 0.0,
        sector_at_deg: 0.0,
        pupil_decentration_mm: [0.0; 2],
    }
}

/// An app with somebody who has two eyes.
fn app() -> (App, Entity, [Entity; 2]) {
    let mut app = App::new();
    app.add_plugins(ConditionsPlugin)
        .add_condition::<Borrowed>();
    // Twice is once.
    app.add_condition::<Borrowed>();
    let world = app.world_mut();
    let patient = world.spawn(Patient::default()).id();
    let eyes = Laterality::BOTH.map(|laterality| {
        world
            .spawn((
                EyeOf(patient),
                Eye {
                    laterality,
                    scleral_radius_mm: 11.5,
                    angle_alpha_deg: [0.0; 2],
                },
                iris(),
                Refraction::default(),
                Lids::default(),
                Sclera::default(),
            ))
            .id()
    });
    app.update();
    (app, patient, eyes)
}

fn effective<C: Component + Clone>(app: &App, eye: Entity) -> C {
    let found = app.world().get::<Effective<C>>(eye);
    found.expect("what an eye has").0.clone()
}

fn sphere_d(app: &App, eye: Entity) -> f64 {
    effective::<Refraction>(app, eye).sphere_d
}

#[test]
fn a_condition_of_another_crate_changes_an_eye_and_gives_it_back() {
    let (mut app, _, [right, left]) = app();
    app.world_mut().entity_mut(right).insert(Borrowed(2.0));
    app.update();
    assert_eq!((sphere_d(&app, right), sphere_d(&app, left)), (-2.0, 0.0));
    assert_eq!(effective::<Lids>(&app, right).opening, 0.5);
    assert_eq!(
        effective::<Iris>(&app, right).color,
        crate::anatomy::IrisColor::Blue
    );
    // Its own error is changed as it always was, in steps too; the condition adds to it and never adds up.
    for step in 1..=4 {
        let mut own = app
            .world_mut()
            .get_mut::<Refraction>(right)
            .expect("refraction");
        own.sphere_d += 0.25;
        own.axis_deg = f64::from(step);
        app.update();
        assert_eq!(sphere_d(&app, right), 0.25 * f64::from(step) - 2.0);
    }
    app.update();
    assert_eq!(sphere_d(&app, right), -1.0);
    app.world_mut().entity_mut(right).insert(Borrowed(0.5));
    app.update();
    assert_eq!(sphere_d(&app, right), 0.5);
    app.world_mut().entity_mut(right).remove::<Borrowed>();
    app.update();
    assert_eq!(sphere_d(&app, right), 1.0);
    assert_eq!(effective::<Lids>(&app, right).opening, 1.0);
    assert_eq!(app.world().get::<Iris>(right), Some(&iris()));
}

#[test]
fn several_conditions_write_into_one_eye() {
    let (mut app, patient, [right, left]) = app();
    app.world_mut()
        .entity_mut(patient)
        .insert(Glaucoma::from(GlaucomaStage::Severe));
    app.world_mut()
        .entity_mut(left)
        .insert((Cataract::nuclear(4.0), Borrowed(1.0)));
    app.update();
    let is = |app: &App, eye: Entity| {
        let world = app.world();
        (
            world.get::<VisualField>(eye).expect("a field").is_whole(),
            world.get::<OcularMedia>(eye).expect("media").is_clear(),
        )
    };
    assert_eq!(
        (is(&app, right), is(&app, left)),
        ((false, true), (false, false))
    );
    // A nucleus of grade 4 makes an eye short-sighted, and the other adds to it.
    assert!(sphere_d(&app, left) < -1.5 && sphere_d(&app, right) == 0.0);
    app.world_mut().entity_mut(patient).remove::<Glaucoma>();
    app.world_mut()
        .entity_mut(left)
        .remove::<(Cataract, Borrowed)>();
    app.update();
    assert_eq!(
        (is(&app, right), is(&app, left)),
        ((true, true), (true, true))
    );
    assert_eq!(sphere_d(&app, left), 0.0);
}

#[test]
fn an_eye_without_change_is_not_written() {
    let (mut app, _, [right, _]) = app();
    app.world_mut().entity_mut(right).insert(Borrowed(2.0));
    app.update();
    app.update();
    let tick = app
        .world()
        .entity(right)
        .get_ref::<Effective<Refraction>>()
        .expect("one")
        .last_changed();
    app.update();
    let now = app
        .world()
        .entity(right)
        .get_ref::<Effective<Refraction>>()
        .expect("one")
        .last_changed();
    assert_eq!(tick, now);
}

#[test]
fn what_conditions_write_comes_back_if_it_is_taken_away() {
    let (mut app, patient, [right, _]) = app();
    app.world_mut()
        .entity_mut(patient)
        .insert(Cataract::nuclear(4.0));
    app.update();
    let media = |app: &App| app.world().get::<OcularMedia>(right).cloned();
    let clouded = media(&app).expect("media");
    assert!(!clouded.is_clear());
    app.world_mut().entity_mut(right).remove::<OcularMedia>();
    app.update();
    app.update();
    assert_eq!(media(&app), Some(clouded));
}
