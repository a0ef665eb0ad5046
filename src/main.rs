//! The program: reads the command line, or the page's link, and calls one function.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    ocularium::app::cli::run()
}

#[cfg(target_arch = "wasm32")]
fn main() {
    ocularium::app::web::run();
}
