//! Cameras and eyes in an app of somebody else's: targets, layers and people that come and go.

use crate::people::{SIDE, difference, seen, world, world_with};
use crate::stage::{mean, turn};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{ClearColorConfig, Exposure, Hdr, RenderTarget, Viewport};
use bevy::math::UVec2;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::pbr::{DistanceFog, ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::{AsBindGroup, Extent3d, TextureDimension, TextureFormat};
use image::RgbaImage;
use ocularium::frame::panel::target_image;
use ocularium::lab::headless::Headless;
use ocularium::prelude::*;

/// A world with somebody and a camera that sees as she does into a part of a target of its own.
fn worn(
    headless: &mut Headless,
    ann: Entity,
    target: Image,
    part: Option<Viewport>,
) -> (Entity, Handle<Image>) {
    let world = headless.world();
    // Bevy clears the rest of a target.
    world.insert_resource(ClearColor(Color::BLACK));
    let image = world.resource_mut::<Assets<Image>>().add(target);
    let camera = world
        .spawn((
            Camera3d::default(),
            Camera {
                viewport: part,
                ..default()
            },
            Hdr,
            RenderTarget::Image(image.clone().into()),
            SeesAs(ann),
        ))
        .id();
    (camera, image)
}

fn frames(headless: &mut Headless, count: usize) {
    for _ in 0..count {
        headless.stand_still();
        headless.finish_frame();
    }
}

fn somebody(headless: &mut Headless) -> Entity {
    let world = headless.world();
    let mut people = world.query_filtered::<Entity, With<Patient>>();
    people.iter(world).next().expect("somebody")
}

/// Mean of a square of 16 × 16 pixels.
fn part_mean(picture: &RgbaImage, x: u32, y: u32) -> f64 {
    mean(&image::imageops::crop_imm(picture, x, y, 16, 16).to_image())
}

#[test]
fn a_worn_camera_follows_the_target_and_viewport_that_it_is_given() {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let side = UVec2::splat(2 * SIDE);
    let left = Viewport {
        physical_size: UVec2::new(SIDE, 2 * SIDE),
        ..default()
    };
    let (camera, image) = worn(&mut headless, ann, target_image(side), Some(left));
    headless.go_to(0.2);
    frames(&mut headless, 8);
    let picture = headless.picture(&image).expect("a picture");
    assert!(part_mean(&picture, 8, 100) > 5.0, "the left half shows it");
    assert_eq!(
        part_mean(&picture, 100, 100),
        0.0,
        "the right half does not"
    );

    // It moves to the right half.
    headless
        .world()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .viewport = Some(Viewport {
        physical_position: UVec2::new(SIDE, 0),
        physical_size: UVec2::new(SIDE, 2 * SIDE),
        ..default()
    });
    frames(&mut headless, 8);
    let picture = headless.picture(&image).expect("a picture");
    assert!(part_mean(&picture, 100, 100) > 5.0);

    // Another target, of another size, as a whole: no viewport is left but one of all of it.
    let other = headless
        .world()
        .resource_mut::<Assets<Image>>()
        .add(target_image(UVec2::splat(SIDE)));
    let world = headless.world();
    *world.get_mut::<RenderTarget>(camera).expect("a target") =
        RenderTarget::Image(other.clone().into());
    world.get_mut::<Camera>(camera).expect("a camera").viewport = Some(Viewport {
        physical_size: UVec2::splat(SIDE),
        ..default()
    });
    frames(&mut headless, 8);
    let picture = headless.picture(&other).expect("a picture");
    assert!(part_mean(&picture, 8, 40) > 5.0 && part_mean(&picture, 40, 40) > 5.0);

    // Asleep it draws nothing, and awake it draws again.
    let before = headless.work();
    let set = |headless: &mut Headless, is_shown: bool| {
        headless
            .world()
            .get_mut::<ViewOptions>(camera)
            .expect("options")
            .is_shown = is_shown;
    };
    set(&mut headless, false);
    for step in 1..=5 {
        headless.go_to(0.2 + 0.1 * f64::from(step));
    }
    assert_eq!(headless.work().since(before).view_passes, 0);
    set(&mut headless, true);
    headless.go_to(0.9);
    assert!(headless.work().since(before).view_passes > 0);
}

#[test]
fn a_part_of_a_target_of_any_format_shows_the_view() {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let mut targets = Vec::new();
    for format in [TextureFormat::Bgra8UnormSrgb, TextureFormat::Rgba8Unorm] {
        let mut target = target_image(UVec2::splat(2 * SIDE));
        target.texture_descriptor.format = format;
        let part = Viewport {
            physical_position: UVec2::splat(SIDE),
            physical_size: UVec2::splat(SIDE),
            ..default()
        };
        targets.push((format, worn(&mut headless, ann, target, Some(part)).1));
    }
    headless.go_to(0.2);
    frames(&mut headless, 8);
    for (format, target) in targets {
        let picture = headless.picture(&target).expect("a picture");
        assert!(part_mean(&picture, 100, 100) > 5.0, "{format:?}");
        assert_eq!(part_mean(&picture, 8, 8), 0.0, "{format:?}");
    }
}

#[test]
fn of_somebody_who_is_gone_nothing_is_seen_and_nothing_stays() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(1);
    let ann = somebody(&mut headless);
    let model = headless
        .world()
        .spawn((EyeModel(ann), Transform::default()))
        .id();
    let other = headless
        .world()
        .spawn((EyeModel(ann), Transform::default()))
        .id();
    headless.go_to(0.2);
    frames(&mut headless, 4);
    let parts = |headless: &mut Headless, model: Entity| {
        let children = headless.world().get::<Children>(model);
        children.map_or(0, |children| children.len())
    };
    // Cornea, limbus, white, what covers it in the corners, skin, lashes, brow, and the tears along the lids.
    assert_eq!(parts(&mut headless, model), 9);
    // One is no eye any more.
    headless.world().entity_mut(other).remove::<EyeModel>();
    frames(&mut headless, 2);
    assert_eq!(parts(&mut headless, other), 0);
    assert!(mean(&seen(&mut headless, cameras[0])) > 5.0);
    // Then she goes.
    headless.world().entity_mut(ann).despawn();
    frames(&mut headless, 3);
    assert_eq!(parts(&mut headless, model), 0);
    assert_eq!(mean(&seen(&mut headless, cameras[0])), 0.0, "nobody sees");
    let before = headless.work();
    frames(&mut headless, 3);
    let work = headless.work().since(before);
    assert_eq!(
        (work.scene_passes, work.view_passes),
        (0, 0),
        "and nothing is drawn"
    );
    assert!(
        !headless
            .world()
            .get::<Camera>(cameras[0])
            .expect("a camera")
            .is_active
    );
    // Somebody else is seen through by the same camera.
    let ben = headless
        .world()
        .spawn(Patient::preset("healthy-brown"))
        .id();
    headless.world().entity_mut(cameras[0]).insert(SeesAs(ben));
    frames(&mut headless, 8);
    assert!(mean(&seen(&mut headless, cameras[0])) > 5.0);
    let places = headless
        .world()
        .get::<ocularium::motion::Candidates>(ben)
        .expect("places to look at");
    assert!(!places.list.is_empty(), "he knows where he may look");
}

#[test]
fn another_person_at_a_camera_is_told_what_it_sees() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(1);
    headless.go_to(0.2);
    frames(&mut headless, 6);
    let ben = headless
        .world()
        .spawn(Patient::preset("healthy-brown"))
        .id();
    headless.world().entity_mut(cameras[0]).insert(SeesAs(ben));
    let before = headless.work();
    frames(&mut headless, 3);
    assert_eq!(
        headless.work().since(before).view_captures,
        0,
        "the picture is the same"
    );
    let places = headless.world().get::<ocularium::motion::Candidates>(ben);
    assert!(!places.expect("places").list.is_empty());
}

/// Changes of a camera and its options that its picture follows.
type Retaking = (&'static str, fn(&mut World, Entity));

#[test]
fn a_view_is_taken_again_when_what_its_camera_draws_with_changes() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(1);
    headless.go_to(0.2);
    frames(&mut headless, 8);
    let changes: &[Retaking] = &[
        ("exposure of the camera", |w, c| {
            w.entity_mut(c)
                .insert(bevy::camera::Exposure { ev100: 8.0 });
        }),
        ("ambient light of the camera", |w, c| {
            w.entity_mut(c).insert(AmbientLight {
                brightness: 900.0,
                ..default()
            });
        }),
        ("its loss", |w, c| {
            w.entity_mut(c).remove::<AmbientLight>();
        }),
        ("fog", |w, c| {
            w.entity_mut(c).insert(DistanceFog::default());
        }),
        ("background of the camera", |w, c| {
            w.get_mut::<Camera>(c).expect("a camera").clear_color =
                ClearColorConfig::Custom(Color::linear_rgb(0.2, 0.1, 0.1));
        }),
        ("background of the world", |w, _| {
            w.insert_resource(ClearColor(Color::linear_rgb(0.1, 0.2, 0.1)));
        }),
        ("threshold of the corners", |w, c| {
            w.get_mut::<ViewOptions>(c).expect("options").threshold = 60;
        }),
        ("exposure of the view", |w, c| {
            w.get_mut::<ViewOptions>(c).expect("options").exposure = 0.5;
        }),
        ("edge of a voxel", |w, _| {
            let mut fields = w.query::<&mut SharpnessField>();
            for mut field in fields.iter_mut(w) {
                field.voxel_m = 0.03;
            }
        }),
        ("somebody's word", |w, c| {
            w.get_mut::<ocularium::percept::Percept>(c)
                .expect("a view")
                .take_again();
        }),
    ];
    for (name, change) in changes {
        let before = headless.work();
        frames(&mut headless, 2);
        assert_eq!(
            headless.work().since(before).view_captures,
            0,
            "before {name}"
        );
        change(headless.world(), cameras[0]);
        frames(&mut headless, 6);
        let captures = headless.work().since(before).view_captures;
        assert!((1..=2).contains(&captures), "{name}: {captures}");
        frames(&mut headless, 6);
    }
}

#[test]
fn an_eye_model_moves_with_what_it_hangs_on_and_changes_its_layers() {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let world = headless.world();
    let head = world
        .spawn((Transform::from_xyz(0.0, 2.0, 0.0), Visibility::default()))
        .id();
    let model = world
        .spawn((
            EyeModel(ann),
            Transform::from_xyz(0.03, 0.0, 0.0),
            ChildOf(head),
        ))
        .id();
    let panel = Panel::new(
        &mut world.resource_mut::<Assets<Image>>(),
        UVec2::splat(SIDE),
        true,
    );
    let camera = world
        .spawn(ocularium::appearance::eye_camera(
            model,
            panel,
            RenderLayers::default(),
        ))
        .id();
    headless.go_to(0.1);
    frames(&mut headless, 2);
    let place = headless
        .world()
        .get::<Transform>(camera)
        .expect("a place")
        .translation;
    // 95 mm before the target, which lies 10.5 mm before the globe's middle.
    assert!(
        (place - Vec3::new(0.03, 2.0, -0.1055)).length() < 1e-5,
        "{place}"
    );
    headless
        .world()
        .entity_mut(model)
        .insert(RenderLayers::layer(5));
    frames(&mut headless, 2);
    let world = headless.world();
    let children = world.get::<Children>(model).expect("parts").to_vec();
    for part in children {
        assert_eq!(
            world.get::<RenderLayers>(part),
            Some(&RenderLayers::layer(5))
        );
    }
}

/// How much neighbouring pixels of a square differ, in codes squared: an edge over four pixels counts a
/// quarter of one over one.
fn contrast(picture: &RgbaImage, [x, y]: [u32; 2], side: u32) -> f64 {
    let at = |x: u32, y: u32| f64::from(picture.get_pixel(x, y)[1]);
    let mut sum = 0.0;
    for j in y..y + side {
        for i in x..x + side {
            sum += (at(i + 1, j) - at(i, j)).powi(2) + (at(i, j + 1) - at(i, j)).powi(2);
        }
    }
    sum / f64::from(side * side)
}

/// A board of black and white squares, 8 × 8, on a cuboid.
fn board(world: &mut World, place: Transform) -> Entity {
    let texel = |k: usize| {
        if (k / 8 + k % 8).is_multiple_of(2) {
            20
        } else {
            235
        }
    };
    let mut image = Image::new(
        Extent3d {
            width: 8,
            height: 8,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        (0..64)
            .flat_map(|k| [texel(k), texel(k), texel(k), 255])
            .collect(),
        TextureFormat::Rgba8UnormSrgb,
        bevy::asset::RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = bevy::image::ImageSampler::nearest();
    let texture = world.resource_mut::<Assets<Image>>().add(image);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(texture),
            unlit: true,
            ..default()
        });
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(0.05, 0.05, 0.004));
    world
        .spawn((Mesh3d(mesh), MeshMaterial3d(material), place))
        .id()
}

/// The same, held by a joint, which is what moves.
fn bent_board(world: &mut World, place: Transform) -> Entity {
    let board = board(world, Transform::IDENTITY);
    let joint = world.spawn(place).id();
    let mesh = world.get::<Mesh3d>(board).expect("a mesh").0.clone();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(&mesh).expect("a board");
    let count = mesh.count_vertices();
    let joints = VertexAttributeValues::Uint16x4(vec![[0; 4]; count]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
    let weights = vec![[1.0f32, 0.0, 0.0, 0.0]; count];
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    mesh.generate_skinned_mesh_bounds()
        .expect("a joint holds it");
    drop(mesh);
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(vec![Mat4::IDENTITY]);
    let joints = vec![joint];
    world.entity_mut(board).insert((
        SkinnedMesh {
            inverse_bindposes,
            joints,
        },
        bevy::camera::visibility::NoFrustumCulling,
    ));
    joint
}

#[test]
fn what_moves_takes_its_sharpness_along() {
    sharpness_rides(board);
}

#[test]
fn what_a_joint_moves_takes_its_sharpness_along() {
    sharpness_rides(bent_board);
}

/// What was seen of a thing sharply rides with it, and where it stood nothing is left of it.
fn sharpness_rides(make: fn(&mut World, Transform) -> Entity) {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let (_, image) = worn(&mut headless, ann, target_image(UVec2::splat(256)), None);
    let place = |x: f32| Transform::from_xyz(x, 0.0, -0.25);
    let thing = make(headless.world(), place(-0.05));
    let world = headless.world();
    world.get_mut::<PupilControl>(ann).expect("pupils").fixed_mm = Some(7.0);
    let gaze = |headless: &mut Headless, azimuth_deg: f64, distance_m: f64| {
        headless
            .world()
            .write_message(MotionCommand::Gaze(GazeCommand::Fixed {
                azimuth_rad: azimuth_deg.to_radians(),
                elevation_rad: 0.0,
                distance_m,
            }));
    };
    headless.go_to(0.1);
    {
        let mut controller = headless
            .world()
            .get_mut::<GazeController>(ann)
            .expect("a controller");
        let mut settings = controller.engine().settings().clone();
        settings.blinks = false;
        controller.set_settings(settings).expect("sound settings");
    }
    // At the board, then at the wall behind it.
    gaze(&mut headless, -11.3, 0.25);
    for step in 1..=20 {
        headless.go_to(0.1 + 0.1 * f64::from(step));
    }
    gaze(&mut headless, 12.0, 5.0);
    for step in 1..=10 {
        headless.go_to(2.1 + 0.1 * f64::from(step));
    }
    let shown = |headless: &mut Headless| {
        frames(headless, 4);
        headless.picture(&image).expect("a picture")
    };
    // The board spans 62 pixels about a place that lies 62 aside of the middle.
    let (left, right) = ([52, 114], [176, 114]);
    let remembered = contrast(&shown(&mut headless), left, 28);

    let go = |headless: &mut Headless, thing: Entity, x: f32| {
        *headless
            .world()
            .get_mut::<Transform>(thing)
            .expect("a place") = place(x);
    };
    go(&mut headless, thing, 0.05);
    let picture = shown(&mut headless);
    let moved = contrast(&picture, right, 28);
    // And again, now that it has a name.
    go(&mut headless, thing, 0.0505);
    let again = contrast(&shown(&mut headless), right, 28);
    // Another one comes where it stood: it has not been seen yet.
    make(headless.world(), place(-0.05));
    let unseen = contrast(&shown(&mut headless), left, 28);
    println!("{remembered:.1} remembered, {moved:.1} moved, {again:.1} again, {unseen:.1} unseen");
    assert!(remembered > 10.0 && unseen < 0.5 * remembered);
    assert!((moved - remembered).abs() < 0.1 * remembered);
    assert!((again - remembered).abs() < 0.1 * remembered);
    headless
        .world()
        .get_mut::<SharpnessField>(ann)
        .expect("a memory")
        .restart();
    let forgotten = contrast(&shown(&mut headless), right, 28);
    println!("{forgotten:.1} forgotten");
    assert!(forgotten < 0.5 * remembered, "{forgotten}");
}

/// What changes while a view is put away is seen when it is shown again.
#[test]
fn a_change_behind_a_hidden_view_is_seen_later() {
    let _turn = turn();
    let (mut headless, cameras, _) = world(1);
    headless.go_to(0.2);
    frames(&mut headless, 8);
    let show = |headless: &mut Headless, is_shown: bool| {
        let mut options = headless.world().get_mut::<ViewOptions>(cameras[0]);
        options.as_mut().expect("options").is_shown = is_shown;
        frames(headless, 4);
    };
    let before = headless.work();
    show(&mut headless, false);
    show(&mut headless, true);
    assert_eq!(
        headless.work().since(before).view_captures,
        0,
        "nothing has changed"
    );
    show(&mut headless, false);
    board(headless.world(), Transform::from_xyz(0.0, 0.0, -0.4));
    frames(&mut headless, 4);
    assert_eq!(
        headless.work().since(before).view_captures,
        0,
        "nobody looks"
    );
    show(&mut headless, true);
    assert_eq!(headless.work().since(before).view_captures, 1);
}

/// A screen that fills the view and shows what `image` holds.
fn screen(world: &mut World, image: Handle<Image>) {
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color_texture: Some(image),
            unlit: true,
            ..default()
        });
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(6.0, 6.0, 0.01));
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, 0.0, -1.5),
    ));
}

/// A video is an image that somebody writes: each of its pictures is seen, and costs one capture.
#[test]
fn a_video_is_taken_picture_by_picture() {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let (_, seen) = worn(&mut headless, ann, target_image(UVec2::splat(64)), None);
    let picture_of = |code: u8| -> Vec<u8> { [code, code, code, 255].repeat(16) };
    let world = headless.world();
    let video = world.resource_mut::<Assets<Image>>().add(Image::new(
        Extent3d {
            width: 4,
            height: 4,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        picture_of(60),
        TextureFormat::Rgba8UnormSrgb,
        bevy::asset::RenderAssetUsages::default(),
    ));
    screen(world, video.clone());
    headless.go_to(0.1);
    frames(&mut headless, 12);
    for code in [90, 130, 70, 150, 110] {
        let before = headless.work();
        {
            let mut images = headless.world().resource_mut::<Assets<Image>>();
            let mut image = images.get_mut(&video).expect("the video");
            image.data = Some(picture_of(code));
        }
        frames(&mut headless, 3);
        let captures = headless.work().since(before).view_captures;
        assert_eq!(captures, 1, "captures of a picture");
        let found = mean(&headless.picture(&seen).expect("a picture"));
        assert!(
            (found - f64::from(code)).abs() < 2.0,
            "{found:.1} is seen of {code}"
        );
    }
    // A video that stands costs nothing.
    let before = headless.work();
    frames(&mut headless, 5);
    assert_eq!(headless.work().since(before).view_captures, 0);
}

/// A texture that an app has made itself, as a headset's is, has a size too and is drawn into.
#[test]
fn a_texture_view_of_somebody_elses_shows_what_is_seen() {
    use bevy::camera::ManualTextureViewHandle;
    use bevy::render::render_resource::{TextureDescriptor, TextureUsages};
    use bevy::render::renderer::RenderDevice;
    use bevy::render::texture::{ManualTextureView, ManualTextureViews};
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let world = headless.world();
    let size = UVec2::new(96, 64);
    let texture = world
        .resource::<RenderDevice>()
        .create_texture(&TextureDescriptor {
            label: Some("a headset's"),
            size: Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::Rgba8UnormSrgb,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
    let view = texture.create_view(&default());
    let handle = ManualTextureViewHandle(7);
    let view = ManualTextureView::with_default_format(view, size);
    world
        .resource_mut::<ManualTextureViews>()
        .insert(handle, view);
    let camera = world
        .spawn((
            Camera3d::default(),
            Hdr,
            RenderTarget::TextureView(handle),
            SeesAs(ann),
        ))
        .id();
    headless.go_to(0.2);
    frames(&mut headless, 8);
    let percept = headless.world().get::<Percept>(camera).expect("a view");
    assert_eq!(percept.captured().size, size);
    let shown = headless
        .texture(&texture, texture.size())
        .expect("a picture");
    assert!(mean(&shown) > 5.0, "{}", mean(&shown));
}

/// Bevy draws a mesh in the shape of its morph targets one frame late; what is seen is its shape all the same.
#[test]
fn a_mesh_is_seen_in_the_shape_that_its_morph_weights_give_it() {
    use bevy::asset::RenderAssetUsages;
    use bevy::mesh::morph::{MeshMorphWeights, MorphAttributes};
    use bevy::mesh::{Indices, PrimitiveTopology};
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let (camera, image) = worn(&mut headless, ann, target_image(UVec2::splat(64)), None);
    let layer = RenderLayers::layer(9);
    let world = headless.world();
    let corners = [
        [-0.9f32, -0.6, 0.0],
        [-0.3, -0.6, 0.0],
        [-0.3, 0.6, 0.0],
        [-0.9, 0.6, 0.0],
    ];
    let aside = MorphAttributes::new(Vec3::X * 1.2, Vec3::ZERO, Vec3::ZERO);
    let mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec())
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0f32, 0.0, 1.0]; 4])
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0f32; 2]; 4])
    .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]))
    .with_morph_targets(vec![aside; 4]);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let white = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color: Color::WHITE,
            unlit: true,
            ..default()
        });
    let card = world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(white),
            MeshMorphWeights::Value { weights: vec![1.0] },
            Transform::from_xyz(0.0, 0.0, -2.0),
            layer.clone(),
        ))
        .id();
    world
        .entity_mut(camera)
        .insert((layer, Transform::default()));
    headless.go_to(0.2);
    let sides = |headless: &mut Headless| {
        frames(headless, 10);
        let picture = headless.picture(&image).expect("a picture");
        [part_mean(&picture, 6, 24), part_mean(&picture, 42, 24)]
    };
    let [left, right] = sides(&mut headless);
    assert!(
        right > left + 30.0,
        "shaped to the right: {left} and {right}"
    );
    let weights = vec![0.0];
    headless
        .world()
        .entity_mut(card)
        .insert(MeshMorphWeights::Value { weights });
    let [left, right] = sides(&mut headless);
    assert!(left > right + 30.0, "and back: {left} and {right}");
}

/// What a camera's exposure leaves of a luminance is its share of 1.2 × 2^EV cd/m².
#[test]
fn a_pupil_answers_to_the_light_that_its_camera_sees() {
    let _turn = turn();
    let (mut headless, _, _) = world(0);
    let ann = somebody(&mut headless);
    let (camera, _) = worn(&mut headless, ann, target_image(UVec2::new(96, 64)), None);
    // Nothing but sky, and later a black wall before a half of it.
    let exposure = Exposure { ev100: 6.0 };
    let wall = {
        let world = headless.world();
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Rectangle::new(100.0, 200.0));
        let black = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: Color::BLACK,
                unlit: true,
                ..default()
            });
        (
            Mesh3d(mesh),
            MeshMaterial3d(black),
            Transform::from_xyz(-50.0, 0.0, -20.0),
            RenderLayers::layer(7),
        )
    };
    headless
        .world()
        .entity_mut(camera)
        .insert((RenderLayers::layer(7), exposure));
    let under = |headless: &mut Headless, sky: f32, time_s: f64| {
        let world = headless.world();
        world
            .get_mut::<Camera>(camera)
            .expect("a camera")
            .clear_color = ClearColorConfig::Custom(Color::linear_rgb(sky, sky, sky));
        for step in 0..8 {
            headless.go_to(time_s + 0.4 * f64::from(step));
        }
        let world = headless.world();
        let light = world
            .get::<Adaptation>(ann)
            .expect("somebody")
            .luminance_cd_m2;
        let mut pupils = world.query::<&Pupil>();
        let pupil = pupils.iter(world).next().expect("an eye").diameter_mm;
        (light, pupil)
    };
    // Bright, dim, and bright again, as the codes of a half float say it.
    let full = 1.2 * 64.0;
    let (bright, narrow) = under(&mut headless, 0.5, 0.2);
    assert!((bright / (0.5 * full) - 1.0).abs() < 1e-3, "{bright}");
    let (dim, wide) = under(&mut headless, 0.002, 4.0);
    assert!((dim / (0.002 * full) - 1.0).abs() < 1e-3, "{dim}");
    assert!(wide > 1.3 * narrow, "{wide} and {narrow} mm");
    let (again, _) = under(&mut headless, 0.5, 8.0);
    assert!((again / bright - 1.0).abs() < 1e-6, "{again}");
    // The mean, and not a place of it.
    headless.world().spawn(wall);
    let (half, _) = under(&mut headless, 0.5, 12.0);
    println!("before a wall {:.4} of the light", half / bright);
    assert!((half / bright - 0.5).abs() < 1e-3, "{half} of {bright}");
    // What an app says is not overruled.
    let said = Adaptation {
        luminance_cd_m2: 3.0,
        is_measured: false,
    };
    headless.world().entity_mut(ann).insert(said);
    let world = headless.world();
    world
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .clear_color = ClearColorConfig::Custom(Color::linear_rgb(0.1, 0.1, 0.1));
    for step in 0..4 {
        headless.go_to(16.0 + 0.2 * f64::from(step));
    }
    assert_eq!(headless.world().get::<Adaptation>(ann), Some(&said));
}

/// A material of a kind that nobody knows.
type Foreign = ExtendedMaterial<StandardMaterial, Nothing>;

#[derive(Asset, AsBindGroup, TypePath, Clone, Debug, Default)]
struct Nothing {}

impl MaterialExtension for Nothing {}

#[test]
fn a_material_of_another_kind_is_seen_to_change() {
    let _turn = turn();
    let (mut headless, cameras, _) = world_with(1, |app| {
        app.add_plugins(MaterialPlugin::<Foreign>::default());
    });
    let world = headless.world();
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::new(0.5, 0.5, 0.5));
    let green = Foreign {
        base: Color::srgb(0.0, 1.0, 0.0).into(),
        extension: Nothing {},
    };
    let material = world.resource_mut::<Assets<Foreign>>().add(green);
    world.spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material.clone()),
        Transform::from_xyz(-0.3, 0.0, -1.5),
    ));
    headless.go_to(0.2);
    frames(&mut headless, 8);
    let before = headless.work();
    frames(&mut headless, 2);
    assert_eq!(headless.work().since(before).view_captures, 0);
    let was = seen(&mut headless, cameras[0]);
    headless
        .world()
        .resource_mut::<Assets<Foreign>>()
        .get_mut(&material)
        .expect("the material")
        .base
        .base_color = Color::srgb(1.0, 0.0, 0.0);
    frames(&mut headless, 6);
    assert_eq!(headless.work().since(before).view_captures, 1);
    assert!(difference(&was, &seen(&mut headless, cameras[0])) > 3.0);
}
