//! What moves keeps its own sharpness.
//!
//! Enters: places of meshes, and their boxes. Leaves: those that have moved, for the pass that finds each
//! pixel's voxel. What was seen of such a thing is kept in the frame in which it stood before it ever
//! moved, under its own name: its sharpness rides with it, and where it stood nothing is left for what
//! comes there next. A point belongs to the smallest box that it lies in. A mesh that joints bend is as many
//! things as it has joints, each with the box of what that joint holds. What gives a mesh another shape,
//! morphs, moves nothing here: what is seen of it stays where it was seen.

use bevy::camera::visibility::RenderLayers;
use bevy::math::{DAffine3, DVec3};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// A thing that may move: a mesh, or what one of its joints holds.
pub(in crate::percept) type Part = (Entity, Option<u16>);

/// Things that are kept track of; of more, those that moved last. Enough for a skeleton.
const MOST: usize = 96;
/// Frames after which what has stood still makes room for what moves.
const STILL_FRAMES: u64 = 60;
/// What a box is wider than its mesh, m: depth is not exact, and a sheet has no thickness.
const MARGIN_M: f64 = 0.003;

/// A mesh that has moved.
#[derive(Clone, Debug)]
pub(in crate::percept) struct Mover {
    part: Part,
    /// From 1, never used again.
    name: u32,
    layers: RenderLayers,
    center: DVec3,
    half_size: DVec3,
    /// World from its own frame, before it ever moved and now.
    rest: DAffine3,
    now: DAffine3,
    moved_at: u64,
}

/// [`Mover`] as the pass reads it (struct `Mover` of `shaders/view/field/movers.wgsl`), 128 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MoverData {
    own: [[f32; 4]; 3],
    rest: [[f32; 4]; 3],
    center: [f32; 3],
    name: u32,
    half_size: [f32; 3],
    is_new: u32,
}

const _: () = assert!(size_of::<MoverData>() == 128);

impl MoverData {
    /// Its name.
    pub(in crate::percept) fn name(&self) -> u32 {
        self.name
    }
}

/// Everything that has moved, and where everything is.
#[derive(Debug, Default)]
pub(in crate::percept) struct Movers {
    list: Vec<Mover>,
    places: HashMap<Part, DAffine3>,
    frame: u64,
    named: u32,
}

fn affine(place: &GlobalTransform) -> DAffine3 {
    let affine = place.affine();
    DAffine3::from_cols(
        affine.x_axis.as_dvec3(),
        affine.y_axis.as_dvec3(),
        affine.z_axis.as_dvec3(),
        affine.translation.as_dvec3(),
    )
}

/// A map as rows of four numbers.
fn rows(map: DAffine3) -> [[f32; 4]; 3] {
    let columns = [
        map.x_axis.to_array(),
        map.y_axis.to_array(),
        map.z_axis.to_array(),
        map.translation.to_array(),
    ];
    std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row] as f32))
}

impl Movers {
    /// A frame begins.
    pub(in crate::percept) fn begin(&mut self) {
        self.frame += 1;
    }

    /// Is it where it was, turned at most?
    pub(in crate::percept) fn only_turns(&self, entity: Entity, place: &GlobalTransform) -> bool {
        let now = affine(place).translation;
        self.places
            .get(&(entity, None))
            .is_some_and(|before| before.translation == now)
    }

    /// Is it known where it is?
    pub(in crate::percept) fn knows(&self, part: Part) -> bool {
        self.places.contains_key(&part)
    }

    /// Takes in where a part is, and middle and half size of its box in its own frame, if that is known
    /// yet.
    pub(in crate::percept) fn place(
        &mut self,
        part: Part,
        place: &GlobalTransform,
        shape: Option<(Vec3, Vec3)>,
        layers: Option<&RenderLayers>,
    ) {
        let now = affine(place);
        let Some(before) = self.places.insert(part, now).filter(|old| *old != now) else {
            return;
        };
        // Of what is flattened to nothing no point can be found again.
        if !now.is_finite() || now.matrix3.determinant().abs() < 1e-12 {
            return;
        }
        let frame = self.frame;
        if let Some(mover) = self.list.iter_mut().find(|mover| mover.part == part) {
            mover.now = now;
            mover.moved_at = frame;
            return;
        }
        let Some((center, half_size)) =
            shape.filter(|_| before.matrix3.determinant().abs() > 1e-12)
        else {
            return;
        };
        if self.list.len() == MOST {
            // Where more move at once, those that came first stay.
            let oldest = (0..MOST).min_by_key(|&k| self.list[k].moved_at);
            match oldest.filter(|&k| self.list[k].moved_at + STILL_FRAMES < frame) {
                Some(oldest) => drop(self.list.swap_remove(oldest)),
                None => return,
            }
        }
        self.named += 1;
        self.list.push(Mover {
            part,
            name: self.named,
            layers: layers.cloned().unwrap_or_default(),
            center: center.as_dvec3(),
            half_size: half_size.as_dvec3(),
            rest: before,
            now,
            moved_at: frame,
        });
        let volume = |mover: &Mover| {
            let size = mover.half_size.max(DVec3::splat(1e-3));
            size.element_product() * mover.now.matrix3.determinant().abs()
        };
        self.list.sort_by(|a, b| volume(a).total_cmp(&volume(b)));
    }

    /// It is no more.
    pub(in crate::percept) fn forget(&mut self, entity: Entity) {
        self.places.retain(|part, _| part.0 != entity);
        self.list.retain(|mover| mover.part.0 != entity);
    }

    /// Those that a camera of these layers may see, for a memory with this origin (m); `knows` says of
    /// which the camera has kept something under their names.
    pub(in crate::percept) fn seen_by(
        &self,
        layers: Option<&RenderLayers>,
        origin: Vec3,
        knows: impl Fn(u32) -> bool,
    ) -> Moved {
        let all = RenderLayers::default();
        let layers = layers.unwrap_or(&all);
        let world = DAffine3::from_translation(origin.as_dvec3());
        let seen = || {
            let of_these = |mover: &&Mover| mover.layers.intersects(layers);
            self.list.iter().filter(of_these)
        };
        let data = |mover: &Mover, place: DAffine3, is_new: bool| {
            let own = place.inverse() * world;
            // The margin in its own frame.
            let scale = DVec3::new(
                place.matrix3.x_axis.length(),
                place.matrix3.y_axis.length(),
                place.matrix3.z_axis.length(),
            );
            let half_size = mover.half_size + MARGIN_M / scale;
            MoverData {
                own: rows(own),
                rest: rows(world.inverse() * mover.rest * own),
                center: mover.center.as_vec3().to_array(),
                name: mover.name,
                half_size: half_size.as_vec3().to_array(),
                is_new: u32::from(is_new),
            }
        };
        Moved {
            here: seen()
                .map(|mover| data(mover, mover.now, !knows(mover.name)))
                .collect(),
            left: seen()
                .filter(|mover| !knows(mover.name))
                .map(|mover| data(mover, mover.rest, true))
                .collect(),
        }
    }
}

/// What has moved, as the passes are told.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// Where it is.
    pub(in crate::percept) here: Arc<[MoverData]>,
    /// Where that was of which nothing stands under a name yet.
    pub(in crate::percept) left: Arc<[MoverData]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_movers_numbers_are_where_its_shader_reads_them() {
        let wgsl = include_str!("../../../shaders/view/field/movers.wgsl");
        let (found, span) = crate::percept::gpu_data::tests::laid_out(wgsl, "Mover");
        macro_rules! same {
            ($($name:ident),*) => {
                vec![$((stringify!($name).to_owned(), std::mem::offset_of!(MoverData, $name))),*]
            };
        }
        assert_eq!(found, same!(own, rest, center, name, half_size, is_new));
        assert_eq!(span, size_of::<MoverData>());
    }

    fn mapped(rows: [[f32; 4]; 3], point: Vec3) -> Vec3 {
        let [x, y, z] = rows.map(|row| Vec4::from(row).dot(point.extend(1.0)));
        Vec3::new(x, y, z)
    }

    #[test]
    fn a_point_of_it_is_found_where_it_was_before_it_moved() {
        let mut movers = Movers::default();
        let mut world = World::new();
        let entity = world.spawn_empty().id();
        let unit = Some((Vec3::ZERO, Vec3::splat(0.5)));
        let rest = Transform::from_xyz(1.0, 2.0, -3.0).with_scale(Vec3::splat(0.4));
        let now = Transform::from_xyz(-1.0, 0.0, -2.0)
            .with_scale(Vec3::splat(0.4))
            .with_rotation(Quat::from_rotation_y(0.7));
        movers.begin();
        movers.place((entity, None), &rest.into(), unit, None);
        let origin = Vec3::new(0.3, 0.4, 0.5);
        assert!(movers.seen_by(None, origin, |_| false).here.is_empty());
        for _ in 0..2 {
            movers.begin();
            movers.place((entity, None), &now.into(), unit, None);
        }
        let moved = movers.seen_by(None, origin, |_| false);
        let found = moved.here;
        assert_eq!((found.len(), found[0].name, found[0].is_new), (1, 1, 1));
        assert!(movers.only_turns(entity, &now.with_rotation(Quat::IDENTITY).into()));
        assert!(!movers.only_turns(entity, &rest.into()));
        let corner = Vec3::new(0.5, -0.2, 0.1);
        let point = now.transform_point(corner) - origin;
        // Single precision of metres.
        assert!((mapped(found[0].own, point) - corner).length() < 1e-5);
        let was = rest.transform_point(corner) - origin;
        assert!((mapped(found[0].rest, point) - was).length() < 1e-5);
        // Three millimetres are 7.5 thousandths of it.
        assert!((found[0].half_size[0] - 0.5075).abs() < 1e-6);
        assert_eq!(
            movers.seen_by(None, origin, |name| name == 1).here[0].is_new,
            0
        );
        // It left the place where it was, as far as is known.
        assert!((mapped(moved.left[0].own, was) - corner).length() < 1e-5);
        assert!(movers.seen_by(None, origin, |_| true).left.is_empty());
        let elsewhere = RenderLayers::layer(3);
        assert!(
            movers
                .seen_by(Some(&elsewhere), origin, |_| false)
                .here
                .is_empty()
        );
        movers.forget(entity);
        assert!(movers.seen_by(None, origin, |_| false).here.is_empty());
    }

    #[test]
    fn of_many_those_are_kept_that_move_the_smallest_first() {
        let mut movers = Movers::default();
        let mut world = World::new();
        let things: Vec<Entity> = (0..MOST + 8).map(|_| world.spawn_empty().id()).collect();
        let step = |movers: &mut Movers, things: &[Entity], x: f32| {
            movers.begin();
            for (k, thing) in things.iter().enumerate() {
                let half = Vec3::splat(1.0 + k as f32 % 7.0);
                let place = Transform::from_xyz(x, 0.0, k as f32);
                movers.place(
                    (*thing, None),
                    &place.into(),
                    Some((Vec3::ZERO, half)),
                    None,
                );
            }
        };
        let names = |movers: &Movers| {
            let found = movers.seen_by(None, Vec3::ZERO, |_| false).here;
            assert!(found.is_sorted_by(|a, b| a.half_size[0] <= b.half_size[0]));
            let mut names: Vec<u32> = found.iter().map(MoverData::name).collect();
            names.sort_unstable();
            names
        };
        // All of them move for a while: the first of them keep their names.
        for x in 0..9 {
            step(&mut movers, &things, x as f32);
        }
        assert_eq!(names(&movers), (1..=MOST as u32).collect::<Vec<u32>>());
        // A second later only the last ones do: they take the places of what stands still.
        for x in 0..70 {
            step(&mut movers, &things[MOST..], 100.0 + x as f32);
        }
        let found = names(&movers);
        assert_eq!(found.len(), MOST);
        let last = MOST as u32 + 1..=MOST as u32 + 8;
        assert_eq!(found[MOST - 8..], last.collect::<Vec<u32>>());
        // Flat or without end, it is left alone and nothing breaks.
        for scale in [Vec3::new(0.0, 1.0, 1.0), Vec3::splat(f32::NAN)] {
            let place = Transform::from_scale(scale);
            for thing in &things {
                movers.place(
                    (*thing, None),
                    &place.into(),
                    Some((Vec3::ZERO, Vec3::ONE)),
                    None,
                );
            }
        }
        let found = movers.seen_by(None, Vec3::ZERO, |_| false).here;
        assert!(
            found
                .iter()
                .flat_map(|mover| mover.own)
                .flatten()
                .all(f32::is_finite)
        );
    }
}
