//! The built-in patients: RON files in `assets/patients`, carried inside the program.

/// A built-in patient.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The name by which it is asked for.
    pub name: &'static str,
    /// The file's text.
    pub text: &'static str,
}

macro_rules! presets {
    ($($name:literal),+ $(,)?) => {
        &[$(Preset {
            name: $name,
            text: include_str!(concat!("../../assets/patients/", $name, ".ron")),
        }),+]
    };
}

/// All built-in patients, in the order in which they are listed.
pub const PRESETS: &[Preset] = presets![
    "healthy-brown",
    "healthy-blue",
    "healthy-green",
    "myope-3d",
    "astigmat",
    "presbyope-60",
    "glaucoma-moderate",
    "cataract-nuclear",
    "cataract-posterior",
    "ptosis-left",
];

/// The built-in patient of this name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}
