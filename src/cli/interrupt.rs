//! Interrupts: the first one asks the program to save what it has and end, the second one ends it at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[cfg(unix)]
use signal_hook::consts::signal::SIGXFSZ;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};

use super::failure::INTERRUPTED;

/// Lets a file that outgrows `ulimit -f` be an error of its write, with a message and the old file kept, and not the end.
pub fn outlive_limits_of_files() {
    // Where the system does not let the program listen, it ends as it would have.
    #[cfg(unix)]
    let _ = register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// Hears Ctrl-C and SIGTERM from when it is made; until then they end the program.
pub struct Interrupts {
    heard: Arc<AtomicBool>,
}

impl Interrupts {
    /// Begins to listen.
    ///
    /// # Errors
    /// When the system does not let the program listen.
    pub fn listen() -> io::Result<Self> {
        let heard = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal finds nothing heard yet, and the second one ends the program.
            register_conditional_shutdown(signal, i32::from(INTERRUPTED), Arc::clone(&heard))?;
            register(signal, Arc::clone(&heard))?;
        }
        Ok(Self { heard })
    }

    /// Whether there was one.
    pub fn heard(&self) -> bool {
        self.heard.load(Ordering::Relaxed)
    }
}
