use super::super::model::luminance;
use super::*;
use std::sync::LazyLock;

static ROOM: LazyLock<SceneModel> = LazyLock::new(|| room().unwrap());

fn check_targets(scene: &SceneModel, targets: &[Target]) {
    let tracer = Tracer::new(scene);
    for target in targets {
        let sight = Vec3::from(target.direction());
        let hit = tracer.cast(EYE_M.into(), sight, 1e-3, 1e3).unwrap();
        let name = &scene.meshes[hit.mesh].name;
        // f32 positions at 40 m resolve 4 µm; the shift to a target is one exact step.
        let tolerance = 1e-4 * target.distance_m;
        assert!(
            (hit.distance_m - target.distance_m).abs() < tolerance,
            "{}: {} m, {name}",
            target.name,
            hit.distance_m
        );
    }
}

#[test]
fn targets_are_at_their_exact_distances() {
    check_targets(&ROOM, &ROOM_TARGETS);
    check_targets(&chart().unwrap(), &CHART_TARGETS);
    let all = ROOM_TARGETS.map(|t| t.distance_m);
    for distance in [0.3, 0.6, 1.0, 3.0, 6.0, 12.0, 40.0] {
        assert!(all.contains(&distance));
    }
}

#[test]
fn targets_are_met_on_the_thing_they_name() {
    let tracer = Tracer::new(&ROOM);
    let names = [
        "telephone screen",
        "letter",
        "vase",
        "mug",
        "clock dial",
        "face",
        "book spines",
        "eye chart",
        "street sign",
        "tree",
        "houses",
    ];
    for (target, name) in ROOM_TARGETS.iter().zip(names) {
        let hit = tracer
            .cast(EYE_M.into(), target.direction().into(), 1e-3, 1e3)
            .unwrap();
        assert!(
            ROOM.meshes[hit.mesh].name.contains(name),
            "{} meets {}",
            target.name,
            ROOM.meshes[hit.mesh].name
        );
        // Inside the square view about the head's forward direction.
        let sight = Vec3::from(target.direction());
        let (forward, up) = (Vec3::from(ROOM.eye.forward), Vec3::from(ROOM.eye.up));
        let depth = sight.dot(forward);
        let (x, y) = (sight.dot(forward.cross(up)) / depth, sight.dot(up) / depth);
        assert!(
            x.abs().max(y.abs()) < 25f32.to_radians().tan(),
            "{}",
            target.name
        );
    }
}

#[test]
fn the_room_is_valid_and_within_its_budget() {
    assert_eq!(ROOM.validate(), Ok(()));
    assert!(
        (20_000..=60_000).contains(&ROOM.triangle_count()),
        "{}",
        ROOM.triangle_count()
    );
    assert!(
        (30.0..400.0).contains(&ROOM.mean_luminance_cd_m2),
        "{}",
        ROOM.mean_luminance_cd_m2
    );
    assert_eq!(ROOM.lights.len(), 3);
}

#[test]
fn textured_triangles_have_area_in_the_picture_too() {
    for mesh in &ROOM.meshes {
        if ROOM.materials[mesh.material].textures().next().is_none() {
            continue;
        }
        let uvs = mesh.uvs.as_ref().unwrap();
        for t in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| glam::Vec2::from(uvs[t[k] as usize]));
            assert!(
                (b - a).perp_dot(c - a).abs() > 1e-12,
                "{} {a} {b} {c}",
                mesh.name
            );
        }
    }
}

#[test]
fn the_same_room_is_built_every_time_and_scaled_rooms_keep_their_things() {
    let again = room().unwrap();
    for (a, b) in ROOM.meshes.iter().zip(&again.meshes) {
        assert!(
            a.positions == b.positions && a.colors == b.colors,
            "{}",
            a.name
        );
    }
    let large = room_scaled(8.0).unwrap();
    check_targets(&large, &ROOM_TARGETS);
    let volume_m3 = |scene: &SceneModel| {
        let part = |name: &str| {
            let meshes = scene.meshes.iter().filter(|mesh| mesh.name == name);
            SceneModel {
                meshes: meshes.cloned().collect(),
                ..SceneModel::default()
            }
        };
        let (low, high) = part("ceiling").bounds().unwrap();
        let (foot, head) = part("left wall").bounds().unwrap();
        (high[0] - low[0]) * (high[2] - low[2]) * (head[1] - foot[1])
    };
    let ratio = volume_m3(&large) / volume_m3(&ROOM);
    assert!((ratio / 8.0 - 1.0).abs() < 1e-3, "{ratio}");
    // Its wallpaper is no larger than before.
    let texels_per_m = |scene: &SceneModel| {
        let wall = scene.meshes.iter().find(|m| m.name == "far wall").unwrap();
        let uvs = wall.uvs.as_ref().unwrap();
        let along = |values: &mut dyn Iterator<Item = f32>| {
            let (low, high) = values.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        along(&mut uvs.iter().map(|uv| uv[0])) / along(&mut wall.positions.iter().map(|p| p[0]))
    };
    assert!((texels_per_m(&large) / texels_per_m(&ROOM) - 1.0).abs() < 1e-3);
    for factor in [0.5, f32::NAN, 1e6] {
        assert!(
            room_scaled(factor)
                .unwrap_err()
                .to_string()
                .contains("1 to 1000")
        );
    }
}

#[test]
fn the_window_is_much_brighter_than_the_room_and_the_room_is_not_dark() {
    let tracer = Tracer::new(&ROOM);
    let seen =
        |target: &Target| luminance(tracer.radiance(EYE_M.into(), target.direction().into()));
    let sky = Target::new("sky", 3.0, 7.5, 40.0);
    assert!(
        seen(&sky) > 3.0 * seen(&Target::CHART),
        "{} {}",
        seen(&sky),
        seen(&Target::CHART)
    );
    assert!(seen(&Target::FACE) > 20.0 && seen(&Target::CHART) > 20.0);
}
