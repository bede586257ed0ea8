//! Ctrl-C, and the other polite ways to end a program (SIGTERM, SIGHUP).

use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first signal.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on the first signal sets the flag that is given back, and the second ends the program at once.
pub(super) fn listen() -> &'static AtomicBool {
    let listening = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(super::INTERRUPTED.into());
        }
    });
    if let Err(error) = listening {
        super::say(format_args!(
            "warning: Ctrl-C will end the render without an image ({error})"
        ));
    }
    &STOP
}
