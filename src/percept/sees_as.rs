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
use bevy::camera::{CameraMainTextureUsages, Hdr, ImageRenderTarget, RenderTarget, Viewport};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::ecs::reflect::ReflectComponent;
use bevy::prelude::*;
use bevy::render::extract_component::ExtractComponent;
use bevy::render::render_resource::TextureUsages;
use bevy::render::texture::ManualTextureViews;
use bevy::window::{PrimaryWindow, WindowRef};

/// Makes a camera see as this eye does, or as the leading eye of this person.
///
/// The camera stands where the eye is and looks where the head faces. Its picture is linear and is
/// brought to the screen's range by our own output transform: exposure is the camera's.
///
/// The camera may be given another target, viewport or order at any time, as ever; a viewport is taken
/// away again by one of the whole target. `Camera::is_active` is ours while it is worn: it says whether
/// the scene is drawn in this frame. [`ViewOptions::is_shown`] puts a view to sleep. Of a person or eye
/// that is gone nothing is seen: the picture is black.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component)]
#[require(Hdr, ViewOptions, Percept, PerceptFrame)]
pub struct SeesAs(#[entities] pub Entity);

/// What a camera was before it began to see as somebody does, and has been given since.
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(opaque, Component)]
pub struct Worn {
    target: RenderTarget,
    viewport: Option<Viewport>,
    msaa: Option<Msaa>,
    tonemapping: Option<Tonemapping>,
    was_active: bool,
    depth_usages: TextureUsages,
    /// Who hands the picture on to a window, a texture view, or to a part of a target, and that picture.
    presenter: Option<(Entity, Handle<Image>)>,
    /// What Bevy draws the scene into for us; none before its size is known.
    picture: Option<ImageRenderTarget>,
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

    /// Lets Bevy draw the scene into this picture.
    pub(super) fn draw_into(
        &mut self,
        picture: Handle<Image>,
        scale_factor: f32,
        target: &mut RenderTarget,
    ) {
        let picture = ImageRenderTarget {
            handle: picture,
            scale_factor,
        };
        *target = RenderTarget::Image(picture.clone());
        self.picture = Some(picture);
    }

    /// Is this target the one that we gave the camera?
    fn is_ours(&self, target: &RenderTarget) -> bool {
        match (target, &self.picture) {
            (RenderTarget::Image(image), Some(picture)) => image.handle == picture.handle,
            (RenderTarget::None { .. }, None) => true,
            _ => false,
        }
    }

    /// Does somebody else have to bring the picture to where it is to be seen?
    fn is_handed_on(&self) -> bool {
        let is_elsewhere = matches!(
            self.target,
            RenderTarget::Window(_) | RenderTarget::TextureView(_)
        );
        self.viewport.is_some() || is_elsewhere
    }
}

/// Into nothing, until it is known how large the picture has to be.
const NOTHING: RenderTarget = RenderTarget::None {
    size: UVec2::splat(SMALLEST_SIDE),
};

/// A camera that hands a view's picture on.
#[derive(Component, Clone, Debug, ExtractComponent, Reflect)]
#[reflect(opaque, Component)]
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
pub(super) fn attach(
    mut cameras: Query<Wearer, (With<SeesAs>, Without<Worn>)>,
    mut images: ResMut<Assets<Image>>,
    mut commands: Commands,
) {
    for (entity, mut camera, mut camera_3d, mut target, msaa, tonemapping) in &mut cameras {
        let usages = TextureUsages::from(camera_3d.depth_texture_usages);
        camera_3d.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
        let mut worn = Worn {
            target: std::mem::replace(&mut *target, NOTHING),
            viewport: camera.viewport.take(),
            msaa: msaa.copied(),
            tonemapping: tonemapping.copied(),
            was_active: std::mem::replace(&mut camera.is_active, false),
            depth_usages: usages,
            presenter: None,
            picture: None,
            size: UVec2::ZERO,
        };
        spawn_presenter(&mut worn, camera.order, &mut images, &mut commands);
        commands
            .entity(entity)
            .insert((worn, Msaa::Off, Tonemapping::None));
    }
}

/// Gives a view a presenter, where it needs one.
fn spawn_presenter(
    worn: &mut Worn,
    order: isize,
    images: &mut Assets<Image>,
    commands: &mut Commands,
) {
    if !worn.is_handed_on() {
        return;
    }
    let image = images.add(target_image(UVec2::splat(SMALLEST_SIDE)));
    let presenter = commands.spawn((
        Camera2d,
        Camera {
            order,
            viewport: worn.viewport.clone(),
            clear_color: ClearColorConfig::Custom(Color::BLACK),
            ..default()
        },
        worn.target.clone(),
        Msaa::Off,
        Tonemapping::None,
        CameraMainTextureUsages::default().with(TextureUsages::COPY_DST),
        RenderLayers::none(),
        Presents(image.clone()),
    ));
    worn.presenter = Some((presenter.id(), image));
    // The size is that of the new image.
    worn.size = UVec2::ZERO;
}

/// A presenter's camera.
type Presenter = (With<Presents>, Without<SeesAs>);

/// Follows what a worn camera is given: another target, a viewport, an order.
pub(super) fn follow_changes(
    mut cameras: Query<(&mut Camera, &mut RenderTarget, &mut Worn), With<SeesAs>>,
    mut presenters: Query<(&mut Camera, &mut RenderTarget), Presenter>,
    mut images: ResMut<Assets<Image>>,
    mut commands: Commands,
) {
    for (mut camera, mut target, mut worn) in &mut cameras {
        let mut is_another = false;
        if camera.viewport.is_some() {
            worn.viewport = camera.viewport.take();
            is_another = true;
        }
        if !worn.is_ours(&target) {
            let ours = match &worn.picture {
                Some(picture) => RenderTarget::Image(picture.clone()),
                None => NOTHING,
            };
            worn.target = std::mem::replace(&mut *target, ours);
            // Laid out again, with the picture's own scale.
            worn.size = UVec2::ZERO;
            is_another = true;
        }
        let presenter = worn.presenter.as_ref().map(|(entity, _)| *entity);
        match presenter {
            Some(presenter) if !worn.is_handed_on() => {
                commands.entity(presenter).try_despawn();
                worn.presenter = None;
            }
            Some(presenter) => {
                if let Ok((mut own, mut own_target)) = presenters.get_mut(presenter) {
                    if own.order != camera.order {
                        own.order = camera.order;
                    }
                    if is_another {
                        own.viewport = worn.viewport.clone();
                        *own_target = worn.target.clone();
                    }
                }
            }
            None => spawn_presenter(&mut worn, camera.order, &mut images, &mut commands),
        }
    }
}

/// The parts of a camera that is given back.
type Worner<'a> = (
    Entity,
    &'a Worn,
    &'a mut Camera,
    &'a mut Camera3d,
    &'a mut RenderTarget,
);

/// Gives cameras that no longer see as somebody does back to Bevy.
pub(super) fn detach(mut cameras: Query<Worner, Without<SeesAs>>, mut commands: Commands) {
    for (entity, worn, mut camera, mut camera_3d, mut target) in &mut cameras {
        camera_3d.depth_texture_usages = worn.depth_usages.into();
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
pub(super) fn despawn_presenters(
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
    manual: Option<Res<ManualTextureViews>>,
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
            (RenderTarget::TextureView(view), None) => manual
                .as_ref()
                .and_then(|views| views.get(view))
                .map(|view| view.size),
            (RenderTarget::None { .. }, None) => None,
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
