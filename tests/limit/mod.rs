//! A limit to the time that a test waits for the program.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// Runs this in a thread. The test fails if it takes more than a minute, as it does if the program hangs.
pub fn within_a_minute<T: Send + 'static>(run: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || sender.send(run()));
    receiver
        .recv_timeout(Duration::from_secs(60))
        .expect("no panic above, and no program that hangs")
}
