//! What is looked at: the built-in room and chart, glTF models and photographs.
//!
//! Enters: a name or a file. Leaves: plain data ([`model::SceneModel`] or
//! [`photo::PhotoScene`]) in world metres, y up, right-handed, luminances in cd/m²; nothing here
//! knows of Bevy or of a GPU.
//!
//! - [`model`]: the data and its invariants, [`model::SceneError`]
//! - [`motion`]: what of it moves by itself, and its course
//! - [`catalog`]: from a name or a path to a loaded scene
//! - [`room`]: the furnished room and the clinic corridor with the eye chart
//! - [`gltf_file`], [`photo`] with [`picture_file`] and [`depth_file`]: the user's own scenes
//! - [`paint`]: the drawn part of the built-in scenes' textures
//! - [`trace`]: rays into a scene: distances, mean luminance

pub mod catalog;
pub mod depth_file;
pub mod gltf_file;
pub mod model;
pub mod motion;
pub mod paint;
pub mod photo;
pub(crate) mod photo_view;
pub mod picture_file;
pub mod pictures;
pub(crate) mod playing;
pub mod room;
pub(crate) mod spawn;
pub mod trace;
