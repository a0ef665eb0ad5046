//! Conditions into anatomy, where either has changed.

use super::{Affected, Condition};
use crate::anatomy::{
    Effective, Eye, EyeOf, Eyes, Iris, Lids, OcularMedia, Patient, Refraction, VisualField,
};
use crate::frame::EyeSystems;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use core::any::TypeId;

/// Gives an entity a component, which is news only where it differs from the one that is there.
pub(crate) fn put<C: Component + PartialEq>(entity: &mut EntityWorldMut, component: C) {
    if entity.get::<C>() != Some(&component) {
        entity.insert(component);
    }
}

/// What a kind of condition does to an eye, if the eye or its owner has it.
type Writer = fn(EntityRef, EntityRef, &mut Affected);

/// Every kind of condition, in the order in which they write.
#[derive(Resource, Default)]
struct Writers(Vec<(TypeId, Writer)>);

/// Eyes, and people, whose conditions or anatomy have changed.
#[derive(Resource, Default)]
struct Stale(EntityHashSet);

/// The steps of the work, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Step {
    Notice,
    Write,
}

/// Adds conditions to an app.
pub trait AddCondition {
    /// Makes eyes and people with this component have this condition. To be called after
    /// [`super::ConditionsPlugin`] was added; conditions write in the order in which they were added.
    fn add_condition<C: Condition>(&mut self) -> &mut Self;
}

impl AddCondition for App {
    fn add_condition<C: Condition>(&mut self) -> &mut Self {
        let writer: Writer = |eye, owner, affected| {
            if let Some(condition) = eye.get::<C>().or_else(|| owner.get::<C>()) {
                condition.write(affected);
            }
        };
        let mut writers = self.world_mut().get_resource_or_init::<Writers>();
        if writers.0.iter().any(|(of, _)| *of == TypeId::of::<C>()) {
            return self;
        }
        writers.0.push((TypeId::of::<C>(), writer));
        self.add_systems(Update, notice::<C>.in_set(Step::Notice))
    }
}

/// Whose condition of this kind is new, changed or gone.
fn notice<C: Condition>(
    changed: Query<Entity, Changed<C>>,
    mut gone: RemovedComponents<C>,
    mut stale: ResMut<Stale>,
) {
    if !changed.is_empty() || !gone.is_empty() {
        stale.0.extend(changed.iter().chain(gone.read()));
    }
}

/// What of an eye or its owner its anatomy depends on.
type AnatomyChanged = Or<(
    Changed<Eye>,
    Changed<EyeOf>,
    Changed<Iris>,
    Changed<Refraction>,
    Changed<Lids>,
    Changed<Patient>,
)>;

/// What has been taken out of eyes: what is written of it, or was written, is found again.
#[derive(SystemParam)]
struct TakenOut<'w, 's> {
    irides: RemovedComponents<'w, 's, Iris>,
    refractions: RemovedComponents<'w, 's, Refraction>,
    lids: RemovedComponents<'w, 's, Lids>,
    media: RemovedComponents<'w, 's, OcularMedia>,
    fields: RemovedComponents<'w, 's, VisualField>,
    effective_irides: RemovedComponents<'w, 's, Effective<Iris>>,
    effective_refractions: RemovedComponents<'w, 's, Effective<Refraction>>,
    effective_lids: RemovedComponents<'w, 's, Effective<Lids>>,
}

impl TakenOut<'_, '_> {
    fn eyes(&mut self) -> impl Iterator<Item = Entity> {
        let own = self.irides.read().chain(self.refractions.read());
        let own = own.chain(self.lids.read());
        // What is written here comes back, if it is taken away.
        let written = self.media.read().chain(self.fields.read());
        let effective = self
            .effective_irides
            .read()
            .chain(self.effective_refractions.read())
            .chain(self.effective_lids.read());
        own.chain(written).chain(effective)
    }
}

fn notice_anatomy(
    changed: Query<Entity, AnatomyChanged>,
    mut gone: TakenOut,
    mut stale: ResMut<Stale>,
) {
    if !changed.is_empty() {
        stale.0.extend(&changed);
    }
    stale.0.extend(gone.eyes());
}

/// Writes what every stale eye has.
fn write_anatomy(world: &mut World) {
    if world.resource::<Stale>().0.is_empty() {
        return;
    }
    let stale = core::mem::take(&mut world.resource_mut::<Stale>().0);
    let mut eyes = EntityHashSet::default();
    for entity in stale {
        let Ok(entity) = world.get_entity(entity) else {
            continue;
        };
        if entity.contains::<Eye>() {
            eyes.insert(entity.id());
        }
        if let Some(own) = entity.get::<Eyes>() {
            eyes.extend(own.entities());
        }
    }
    world.resource_scope(|world, writers: Mut<Writers>| {
        for eye in eyes {
            write_eye(world, eye, &writers.0);
        }
    });
}

/// Writes what one eye has. What is made of its own parts goes with them.
fn write_eye(world: &mut World, entity: Entity, writers: &[(TypeId, Writer)]) {
    let found = affected(world, entity, writers);
    let Ok(mut eye) = world.get_entity_mut(entity) else {
        return;
    };
    let Some(found) = found else {
        eye.remove::<(Effective<Refraction>, Effective<Iris>, Effective<Lids>)>();
        return;
    };
    put(&mut eye, found.field);
    put(&mut eye, found.media);
    put(&mut eye, Effective(found.refraction));
    put(&mut eye, Effective(found.iris));
    put(&mut eye, Effective(found.lids));
}

/// What an eye has with all of its conditions; `None` of one that is not whole.
fn affected(world: &World, entity: Entity, writers: &[(TypeId, Writer)]) -> Option<Affected> {
    let eye = world.get_entity(entity).ok()?;
    let owner = world.get_entity(eye.get::<EyeOf>()?.0).ok()?;
    let age_years = owner.get::<Patient>()?.age_years;
    let iris = eye.get::<Iris>()?;
    let mut affected = Affected {
        field: VisualField::normal(eye.get::<Eye>()?.laterality, age_years),
        media: OcularMedia::healthy(age_years, iris.color.glare_pigment()),
        refraction: *eye.get::<Refraction>()?,
        iris: iris.clone(),
        lids: *eye.get::<Lids>()?,
    };
    for (_, writer) in writers {
        writer(eye, owner, &mut affected);
    }
    Some(affected)
}

pub(super) fn build(app: &mut App) {
    app.init_resource::<Writers>()
        .init_resource::<Stale>()
        .configure_sets(
            Update,
            (Step::Notice, Step::Write)
                .chain()
                .in_set(EyeSystems::Sense)
                .after(crate::frame::EyeCommands),
        )
        .add_systems(
            Update,
            (
                notice_anatomy.in_set(Step::Notice),
                write_anatomy.in_set(Step::Write),
            ),
        );
}
