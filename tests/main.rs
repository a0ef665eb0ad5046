//! The integration tests: one binary, so that Bevy links once.

mod gpu;
mod shader_twins;
