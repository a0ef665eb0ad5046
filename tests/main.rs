//! The integration tests: one binary, so that Bevy links once.

mod cli;
mod clouded;
mod drawn_blur;
mod examples;
mod eyes_in_sight;
mod gpu;
mod house;
mod iris_picture;
mod ledger;
mod legal_eyes;
mod models_in_view;
mod moving_models;
mod people;
mod percept_gpu;
mod photographs;
mod render;
mod resized_view;
mod rooms;
mod scene_light;
mod shader_twins;
mod shaders;
mod stage;
mod veil;
mod view_textures;
mod worn;
