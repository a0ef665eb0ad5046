//! Can a window be opened here?

#[cfg(all(feature = "app", unix, not(target_os = "macos")))]
mod x11 {
    /// What is wrong with the X display, as the end of a clause; `None` where a window can be opened. The window
    /// library panics where it cannot.
    pub(crate) fn display_fault() -> Option<String> {
        let name = std::env::var_os("DISPLAY").filter(|name| !name.is_empty());
        let Some(name) = name else {
            return Some(String::new());
        };
        // What ./dev installs for a window, too; the window library loads them as it goes.
        let missing: Vec<&str> = WINDOW_LIBRARIES
            .into_iter()
            // SAFETY: these libraries do nothing as they are loaded.
            .filter(|name| unsafe { libloading::Library::new(name) }.is_err())
            .collect();
        if !missing.is_empty() {
            return Some(format!(": {} cannot be loaded", missing.join(", ")));
        }
        let xlib = x11_dl::xlib::Xlib::open().ok()?;
        // SAFETY: a null name means DISPLAY. It stays open: a display whose only guest leaves may start anew.
        let opened = !unsafe { (xlib.XOpenDisplay)(std::ptr::null()) }.is_null();
        (!opened).then(|| format!(": DISPLAY is {name:?}, and nothing answers there"))
    }

    /// Libraries that a window needs and that are loaded when it opens.
    const WINDOW_LIBRARIES: [&str; 5] = [
        "libX11.so.6",
        "libX11-xcb.so.1",
        "libXi.so.6",
        "libXcursor.so.1",
        "libxkbcommon-x11.so.0",
    ];
}
#[cfg(all(feature = "app", unix, not(target_os = "macos")))]
pub(crate) use x11::display_fault;

/// Is there a display that a window can be opened on? The window library panics where there is none.
///
/// # Errors
/// A sentence for the user, where there is none. Known with the feature `app` on systems with X; elsewhere it is
/// taken that there is one.
pub fn require_display() -> Result<(), String> {
    #[cfg(all(feature = "app", unix, not(target_os = "macos")))]
    if let Some(reason) = display_fault() {
        return Err(format!(
            "there is no display to open a window on{reason}; --frames N --out DIR records without one"
        ));
    }
    Ok(())
}
