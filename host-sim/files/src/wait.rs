//! Waits that the caller of a reader can end from another thread, for example after Ctrl-C in Python.
//!
//! A reader waits in the thread that called it. [`Wanted::scope`] connects that thread with a flag, and every wait for
//! data looks at the flag. A wait that ends so fails like one that lasted too long.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Longest time between two looks at the flag.
const SLICE: Duration = Duration::from_millis(20);

/// A flag that ends the waits of one thread.
#[derive(Clone, Debug, Default)]
pub struct Wanted(Arc<AtomicBool>);

thread_local! {
    static OF_THREAD: RefCell<Wanted> = RefCell::default();
}

impl Wanted {
    /// Ends all present and later waits in scopes of this flag.
    pub fn end(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    pub fn has_ended(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }

    /// Runs `read`, whose waits this flag ends.
    pub fn scope<T>(&self, read: impl FnOnce() -> T) -> T {
        let former = OF_THREAD.replace(self.clone());
        let read = read();
        OF_THREAD.set(former);
        read
    }
}

/// True if the flag of this thread has ended its waits.
pub fn has_ended() -> bool {
    OF_THREAD.with_borrow(Wanted::has_ended)
}

/// Receives a value, like `recv_timeout`.
pub fn receive<T>(from: &Receiver<T>, patience: Duration) -> Result<T, RecvTimeoutError> {
    let begin = Instant::now();
    loop {
        let left = patience.saturating_sub(begin.elapsed());
        match from.recv_timeout(left.min(SLICE)) {
            Err(RecvTimeoutError::Timeout) if left > SLICE && !has_ended() => {}
            received => return received,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::thread;

    #[test]
    fn a_wait_ends_with_data_with_time_or_by_its_flag() {
        let (sender, receiver) = channel();
        let short = Duration::from_millis(50);
        assert_eq!(receive::<u8>(&receiver, short), Err(RecvTimeoutError::Timeout));
        sender.send(7).unwrap();
        assert_eq!(receive(&receiver, Duration::ZERO), Ok(7));
        let (wanted, begin) = (Wanted::default(), Instant::now());
        let other = wanted.clone();
        let waiting = thread::spawn(move || other.scope(|| receive(&receiver, Duration::from_secs(60)).is_err()));
        thread::sleep(short);
        wanted.end();
        assert!(waiting.join().unwrap() && begin.elapsed() < Duration::from_secs(5));
        assert!(!has_ended(), "the flag is that of a scope");
    }
}
