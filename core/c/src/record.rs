//! Flight records, written as a tracker is called.

use crate::pointer;
use crate::status::{SMR_ERROR_NULL, smr_status, status_of};
use crate::tracker::{Event, Hook, Known, Tracked, borrow, each, smr_tracker};
use core::ffi::{c_int, c_void};
use smr_core::record::Recorder;

/// Where a flight record goes: see #smr_record. Set `write` and `context`, and the rest to 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_recorder {
    /// Stores bytes (in flash, a file, over a serial line), at most a row of pixels or 64 bytes at a time. Returns 0 if
    /// that succeeds.
    pub write: Option<unsafe extern "C" fn(context: *mut c_void, bytes: *const u8, size: usize) -> c_int>,
    /// The first argument of `write`.
    pub context: *mut c_void,
    /// The entries so far.
    pub entries: u32,
    /// 1 once `write` has failed: nothing more is written.
    pub failed: u8,
}

/// Records a tracker from now on: every lock, update, move and restored target, as `write` of the recorder is given
/// them. `host-sim replay FILE` runs the bytes through the same code again and names the first difference. The
/// documentation of smr_core::record describes every byte.
///
/// Call it before #smr_lock. A tracker that has a target already continues in the record with #smr_restore.
/// #smr_init ends it. What `write` does takes place within the calls that are recorded.
///
/// @param tracker   Made by #smr_init.
/// @param recorder  Stays where it is, and belongs to this tracker alone, while the tracker is used. NULL ends the record.
/// @return          #SMR_OK, #SMR_ERROR_NULL (also `write`), #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_record(tracker: *mut smr_tracker, recorder: *mut smr_recorder) -> smr_status {
    // SAFETY: as the header demands of the caller.
    status_of(unsafe {
        borrow(tracker).and_then(|tracker| {
            if recorder.is_null() {
                tracker.record(None);
                return Ok(());
            }
            pointer::check(recorder)?;
            if (*recorder).write.is_none() {
                return Err(SMR_ERROR_NULL);
            }
            ((*recorder).entries, (*recorder).failed) = (0, 0);
            tracker.record(Some(Hook { recorder, call: told }));
            tracker.tell(&Event::Begin);
            Ok(())
        })
    })
}

/// Adds an event to the record.
///
/// # Safety
/// As `smr_record` demands.
unsafe fn told(recorder: *mut smr_recorder, tracker: &mut dyn Tracked, event: &Event<'_>) {
    // SAFETY: as the caller ensures.
    let recorder = unsafe { &mut *recorder };
    let (Some(write), 0) = (recorder.write, recorder.failed) else { return };
    let context = recorder.context;
    let write = |bytes: &[u8]| {
        // SAFETY: as the caller ensures: C's function takes these bytes.
        if unsafe { write(context, bytes.as_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(()) }
    };
    let mut to = Recorder::resume(recorder.entries, write);
    let result = match *event {
        Event::Begin => each!(tracker.known(), target => to.beginning(target)),
        Event::Lock(frame, bbox) => to.lock_of(frame, bbox, tracker.lock_window(frame.bounds(), bbox)),
        Event::Window(frame) => {
            let [window, sweep] = [tracker.window(), tracker.sweep_window()].map(Option::unwrap_or_default);
            // Else the update fails.
            if !frame.covers(window) || !sweep.is_empty() && !frame.covers(sweep) {
                return;
            }
            to.window_of(frame, window, sweep)
        }
        Event::Answer(answer) => to.answer(&answer.read().into()),
        Event::Moved(right, down) => to.moved(right, down),
        Event::Restored(saved) => to.restored(saved),
    };
    recorder.entries = to.entries();
    recorder.failed = result.is_err().into();
}
