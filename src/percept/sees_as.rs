//! A camera that sees as somebody does.
//!
//! Enters: [`SeesAs`] on any camera. Leaves: its target shows what that eye sees. Bevy draws the
//! camera's frame into a picture of ours, only when something in it has changed; from that
//! picture the view is drawn into the camera's own target as often as the eye moves.

use super::frame::PerceptFrame;
use super::view::{Percept, ViewOptions};
use crate::frame::Panel;
use crate::frame::panel::{LARGEST_SIDE, SMALLEST_SIDE, target_image};
use bevy::camera::visibility::RenderLayers;
use bevy::camera::{CameraMainTextureUsages, Hdr, RenderTarget, Viewport};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponent;
use bevy::render::render_resource::TextureUsages;
use bevy::window::{PrimaryWindow, WindowRef};

/// Makes a camera see as this eye does, or as the leading eye of this person.
///
/// The camera stands where the eye is and looks where the head faces. Its picture is linear and is
/// brought to the screen's range by our own output transform: exposure is the camera's.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
#[require(Hdr, ViewOptions, Percept, PerceptFrame)]
pub struct SeesAs(pub Entity);

/// What a camera was before it began to see as somebody does.
#[derive(Component, Clone, Debug)]
pub struct Worn {
    target: RenderTarget,
    viewport: Option<Viewport>,
    msaa: Option<Msaa>,
    tonemapping: Option<Tonemapping>,
    was_active: bool,
    /// Who hands the picture on to a window, or to a part of a target, and that picture.
    presenter: Option<(Entity, Handle<Image>)>,
    size: UVec2,
}

impl Worn {
    /// Size of what is drawn into, pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// The image that the view is drawn into, where there is one.
    pub(super) fn image(&self) -> Option<&Handle<Image>> {
        match &self.presenter {
            Some((_, image)) => Some(image),
            None => self.target.as_image(),
        }
    }
}

/// A camera that hands a view's picture on.
#[derive(Component, Clone, Debug, ExtractComponent)]
pub struct Presents(pub Handle<Image>);

/// The parts of a camera that change when it is worn.
type Wearer<'a> = (
    Entity,
    &'a mut Camera,
    &'a mut Camera3d,
    &'a mut RenderTarget,
    Option<&'a Msaa>,
    Option<&'a Tonemapping>,
);

/// Takes cameras that have begun to see as somebody does out of Bevy's hands.
pub(super) fn put_on(
    mut cameras: Query<Wearer, (With<SeesAs>, Without<Worn>)>,
    mut images: ResMut<Assets<Image>>,
    mut commands: Commands,
) {
    for (entity, mut camera, mut camera_3d, mut target, msaa, tonemapping) in &mut cameras {
        let usages = TextureUsages::from(camera_3d.depth_texture_usages);
        camera_3d.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
        let own = target.clone();
        let viewport = camera.viewport.take();
        let is_handed_on = viewport.is_some() || matches!(own, RenderTarget::Window(_));
        let presenter = is_handed_on.then(|| {
            let image = images.add(target_image(UVec2::splat(SMALLEST_SIDE)));
            let presenter = commands.spawn((
                Camera2d,
                Camera {
                    order: camera.order,
                    viewport: viewport.clone(),
                    clear_color: ClearColorConfig::Custom(Color::BLACK),
                    ..default()
                },
                own.clone(),
                Msaa::Off,
                Tonemapping::None,
                CameraMainTextureUsages::default().with(TextureUsages::COPY_DST),
                RenderLayers::none(),
                Presents(image.clone()),
            ));
            (presenter.id(), image)
        });
        // Into nothing, until it is known how large the picture has to be.
        *target = RenderTarget::None {
            size: UVec2::splat(SMALLEST_SIDE),
        };
        let was_active = std::mem::replace(&mut camera.is_active, false);
        // The picture has to be there before whoever draws into the same target comes.
        commands.entity(entity).insert((
            Worn {
                target: own,
                viewport,
                msaa: msaa.copied(),
                tonemapping: tonemapping.copied(),
                was_active,
                presenter,
                size: UVec2::ZERO,
            },
            Msaa::Off,
            Tonemapping::None,
        ));
    }
}

/// Gives cameras that no longer see as somebody does back to Bevy.
pub(super) fn take_off(
    mut cameras: Query<(Entity, &Worn, &mut Camera, &mut RenderTarget), Without<SeesAs>>,
    mut commands: Commands,
) {
    for (entity, worn, mut camera, mut target) in &mut cameras {
        *target = worn.target.clone();
        camera.viewport = worn.viewport.clone();
        camera.is_active = worn.was_active;
        let mut camera = commands.entity(entity);
        camera.remove::<(Worn, Percept, PerceptFrame)>();
        match worn.msaa {
            Some(msaa) => camera.insert(msaa),
            None => camera.remove::<Msaa>(),
        };
        match worn.tonemapping {
            Some(tonemapping) => camera.insert(tonemapping),
            None => camera.remove::<Tonemapping>(),
        };
    }
}

/// A camera's presenter goes with it.
pub(super) fn dismiss_presenters(
    removed: On<Remove, Worn>,
    worn: Query<&Worn>,
    mut commands: Commands,
) {
    if let Ok(worn) = worn.get(removed.entity)
        && let Some((presenter, _)) = worn.presenter
    {
        commands.entity(presenter).try_despawn();
    }
}

/// Learns how large the targets are.
pub(super) fn measure_targets(
    mut cameras: Query<(&mut Worn, Option<&Panel>)>,
    windows: Query<&Window>,
    primary: Query<Entity, With<PrimaryWindow>>,
    mut images: ResMut<Assets<Image>>,
) {
    for (mut worn, panel) in &mut cameras {
        let part = worn
            .viewport
            .as_ref()
            .map(|viewport| viewport.physical_size);
        let size = match (&worn.target, panel) {
            _ if part.is_some() => part,
            (_, Some(panel)) => Some(panel.size),
            (RenderTarget::Window(window), None) => {
                let window = match window {
                    WindowRef::Primary => primary.iter().next(),
                    WindowRef::Entity(window) => Some(*window),
                };
                window
                    .and_then(|window| windows.get(window).ok())
                    .map(Window::physical_size)
            }
            (RenderTarget::Image(image), None) => images.get(&image.handle).map(Image::size),
            (RenderTarget::TextureView(_) | RenderTarget::None { .. }, None) => None,
        };
        let Some(size) = size.filter(|size| size.min_element() > 0) else {
            continue;
        };
        let size = size.clamp(UVec2::ONE, UVec2::splat(LARGEST_SIDE));
        if worn.size == size {
            continue;
        }
        worn.size = size;
        if let Some((_, image)) = &worn.presenter {
            // Under the same handle, so that the presenter finds it.
            let _ = images.insert(image.id(), target_image(size));
        }
    }
}
