//! Bakes the built-in scenes, `assets/scenes/room.glb` and `chart.glb`, and the one that the examples load,
//! `assets/examples/clinic.glb`.
//!
//! ```text
//! cargo run --release --example bake_rooms              # writes the files
//! cargo run --release --example bake_rooms -- --check   # says whether they are what would be written
//! ```

mod rooms;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.as_slice() {
        [] => false,
        [only] if only == "--check" => true,
        _ => {
            eprintln!("bake_rooms takes no argument but --check.");
            return ExitCode::FAILURE;
        }
    };
    match bake(check) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bake_rooms: {error}");
            ExitCode::FAILURE
        }
    }
}

fn bake(check: bool) -> Result<(), Box<dyn Error>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for (name, build) in rooms::ALL {
        let path = assets.join("scenes").join(name).with_extension("glb");
        put(&path, &rooms::glb::write(&build()?)?, check)?;
    }
    put(
        &assets.join(rooms::clinic::PATH),
        &rooms::clinic::write()?,
        check,
    )
}

/// Writes a file, or says whether it is this already.
fn put(path: &Path, wanted: &[u8], check: bool) -> Result<(), Box<dyn Error>> {
    if check {
        if std::fs::read(path)? != wanted {
            let sentence = "is not what this program writes: run it without --check";
            return Err(format!("{} {sentence}.", path.display()).into());
        }
        return Ok(());
    }
    std::fs::create_dir_all(path.parent().ok_or("a file has no folder")?)?;
    std::fs::write(path, wanted)?;
    println!("{} {} bytes", path.display(), wanted.len());
    Ok(())
}
