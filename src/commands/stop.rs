//! Ctrl-C: the first stops cleanly, the second at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a program ended by Ctrl-C (128 + SIGINT).
const INTERRUPTED: i32 = 130;

/// Raised when the user has asked to stop.
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Listens for Ctrl-C and for a request to terminate. Where the system refuses, Ctrl-C ends the
    /// program at once; finished points are safe then, too.
    pub fn listen() -> Self {
        let flag = Self::default();
        let raised = flag.0.clone();
        if let Err(error) = ctrlc::set_handler(move || interrupt(&raised)) {
            note!("Ctrl-C will end the program at once ({error}).");
        }
        flag
    }

    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// Raises the flag, or ends the program if it is already raised.
fn interrupt(raised: &AtomicBool) {
    if raised.swap(true, Ordering::SeqCst) {
        std::process::exit(INTERRUPTED);
    }
    note!("\nStopping after the current step; press Ctrl-C again to quit at once.");
}
