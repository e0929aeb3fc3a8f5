//! Writes flight records: logs of the calls on a tracker, which can be replayed.

use crate::pointer;
use crate::status::{SMR_ERROR_NULL, smr_status, status_of};
use crate::tracker::{Call, Event, Known, Tracked, borrow, each, smr_tracker};
use core::ffi::c_void;
use core::ops::Range;
use smr_core::record::Recorder;
use smr_core::{Frame, Rect, Windows};

/// The recorder of a tracker: see #smr_record. Fill in `write` and `context`; set all other fields to 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_recorder {
    /// Stores bytes in flash, a file or elsewhere. A call passes one row of pixels, one saved target or at most 64
    /// bytes. Returns 0 on success.
    pub write: Option<unsafe extern "C" fn(context: *mut c_void, bytes: *const u8, size: usize) -> i32>,
    /// The first argument of `write`.
    pub context: *mut c_void,
    /// The number of entries written.
    pub entries: u32,
    /// 1 once `write` has failed or an entry would have more than 4 GiB; then nothing more is written.
    pub failed: u8,
    /// The recorded tracker.
    pub tracker: *mut smr_tracker,
}

/// Starts a flight record of a tracker: passes each later lock, update, move and restored target to `write`. `host-sim
/// replay FILE` replays the record and reports where the replay first differs. smr_core::record documents every byte.
///
/// Call it before #smr_lock; for a tracker with a target call #smr_save, #smr_record, #smr_restore. `write` runs inside
/// the recorded calls. A call that fails is not recorded.
///
/// @param tracker   Made by #smr_init.
/// @param recorder  Must stay in place, for this tracker alone, while it is used. NULL or #smr_init ends the record.
/// @return          #SMR_OK, #SMR_ERROR_NULL (also `write`), #SMR_ERROR_MISALIGNED or #SMR_ERROR_NOT_INITIALISED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_record(tracker: *mut smr_tracker, recorder: *mut smr_recorder) -> smr_status {
    // SAFETY: by the header, nobody else uses `tracker` during the call, and `recorder` is NULL or points to a
    // recorder, which stays in place and nobody else uses.
    status_of(unsafe {
        borrow(tracker).and_then(|_| {
            let own = (*tracker).own;
            if recorder.is_null() {
                (*tracker).send_to(own);
                return Ok(());
            }
            pointer::check(recorder)?;
            if (*recorder).write.is_none() {
                return Err(SMR_ERROR_NULL);
            }
            *recorder = smr_recorder { entries: 0, failed: 0, tracker, ..*recorder };
            (*tracker).send_to(recorder);
            (*recorder).record(&Event::Begin);
            Ok(())
        })
    })
}

impl smr_recorder {
    fn own<'a>(&self) -> &'a mut dyn Tracked {
        // SAFETY: `smr_record` has set `tracker` to one that `smr_init` made. By the header, nobody else uses it in a
        // call.
        unsafe { &mut *(*self.tracker).own }
    }
}

impl Tracked for smr_recorder {
    fn known(&mut self) -> Known<'_> {
        self.own().known()
    }

    fn memory(&self) -> [Range<usize>; 2] {
        self.own().memory()
    }

    fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect {
        self.own().lock_window(bounds, bbox)
    }

    fn begin(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<bool, smr_status> {
        let begins = self.own().begin(frame, call, work)?;
        if begins && matches!(call, Call::Update(_)) {
            self.record(&Event::Window(frame));
        }
        Ok(begins)
    }

    fn step(&mut self, frame: &Frame<'_>, call: &Call, work: Option<u32>) -> Result<(), smr_status> {
        self.own().step(frame, call, work)?;
        self.record(&match call {
            Call::Lock(bbox) => Event::Lock(frame, *bbox),
            Call::Update(out) => Event::Answer(out),
        });
        Ok(())
    }

    fn record(&mut self, event: &Event<'_>) {
        let own = self.own();
        let (Some(write), 0) = (self.write, self.failed) else { return };
        let context = self.context;
        let write = move |bytes: &[u8]| {
            // SAFETY: by the header, `write` is a function that takes `context`, an address and a number of bytes.
            if unsafe { write(context, bytes.as_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(()) }
        };
        let mut to = Recorder::resume(self.entries, write);
        let _: Result<(), ()> = match *event {
            Event::Begin => {
                let begun = each!(own.known(), target => Recorder::begin(target, write));
                (self.failed, self.entries) = (begun.is_err().into(), 1);
                return;
            }
            Event::Lock(frame, bbox) => to.lock_of(frame, bbox, own.lock_window(frame.bounds(), bbox)),
            Event::Window(frame) => own.windows().map_or(Ok(()), |windows| to.window_of(frame, windows)),
            Event::Answer(answer) => to.answer(&answer.read().into()),
            Event::Moved(right, down) => to.moved(right, down),
            Event::Restored(saved) => to.restored(saved),
        };
        self.failed = (!to.is_whole()).into();
        self.entries = to.entries();
    }

    fn windows(&self) -> Option<Windows> {
        self.own().windows()
    }

    #[cfg(feature = "unstable")]
    fn work(&self) -> Result<u32, smr_status> {
        self.own().work()
    }

    #[cfg(feature = "unstable")]
    fn response_map(&mut self, frame: &Frame<'_>) -> Result<crate::tracker::ResponseMap, smr_status> {
        self.own().response_map(frame)
    }
}
