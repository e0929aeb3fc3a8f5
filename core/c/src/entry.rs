//! Reads a flight record entry by entry.

use crate::answer::smr_answer;
use crate::capacity::SmallTarget;
use crate::config::{smr_paper_config, smr_robust_config};
use crate::frame::{smr_frame, smr_part, smr_rect};
use crate::pointer::{self, Out};
use crate::status::{SMR_ERROR_DAMAGED, SMR_ERROR_OTHER_CONFIG, SMR_ERROR_OTHER_VERSION, smr_status, status_of};
use core::mem::MaybeUninit;
use core::ptr;
use smr_core::record::{Entry, Flaw, Recorded, first};
use smr_core::{Frame, Rect, Robust, paper, robust};

/// The letters of the robust tracker of both sizes.
const STANDARD: u8 = <Robust>::TRACKER;
const SMALL: u8 = SmallTarget::TRACKER;

/// The kind of an entry of a flight record, the log that #smr_record writes.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_entry_kind {
    /// The end of the record.
    SMR_ENTRY_END = 0,
    /// A tracker begins. Its configuration is `robust` if `is_robust` is 1, else `paper`.
    SMR_ENTRY_BEGIN = 1,
    /// A lock on `bbox` in `frame`.
    SMR_ENTRY_LOCK = 2,
    /// A turn of the camera, which moved the picture by `right` and `down`.
    SMR_ENTRY_MOVED = 3,
    /// An update with `frame` begins.
    SMR_ENTRY_WINDOW = 4,
    /// The update ended with `answer`.
    SMR_ENTRY_ANSWER = 5,
    /// The tracker continues with a `saved` target.
    SMR_ENTRY_RESTORED = 6,
}

/// An entry of a flight record. Only the fields that belong to its kind are set; the others are 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_entry {
    /// The kind of this entry; it determines which fields are set.
    pub kind: smr_entry_kind,
    /// The frame of a lock or an update. Its parts are the windows that the tracker read.
    pub frame: smr_frame,
    /// The box of a lock.
    pub bbox: smr_rect,
    /// Motion of the picture to the right, in units of 1/256 pixel.
    pub right: i32,
    /// Motion of the picture downwards, in units of 1/256 pixel.
    pub down: i32,
    /// The result of an update.
    pub answer: smr_answer,
    /// Address of a saved target inside the record.
    pub saved: *const u8,
    /// Size of the saved target in bytes.
    pub saved_size: usize,
    /// The tracker of #SMR_ENTRY_BEGIN: 1 for the robust one, 0 for the paper's.
    pub is_robust: u8,
    /// The size of the robust tracker: 1 for that of #smr_config_small, else 0.
    pub is_small: u8,
    /// Settings of the paper tracker.
    pub paper: smr_paper_config,
    /// Settings of the robust tracker.
    pub robust: smr_robust_config,
}

/// Reads the next entry of a flight record in memory. With these entries, a test of firmware can replay the record and
/// compare answers.
///
/// @param record  The bytes of the record.
/// @param size    The number of bytes.
/// @param at      Offset of the entry in bytes, at first 0. Is set to that of the next one; unchanged after an error.
/// @param entry   Is set to the entry, which points into the record; unchanged after an error.
/// @return        #SMR_OK (also at the end), #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED, #SMR_ERROR_MEMORY_TOO_LARGE,
///                #SMR_ERROR_DAMAGED (no whole entry begins at `at`: the record was cut off), #SMR_ERROR_OTHER_VERSION
///                or #SMR_ERROR_OTHER_CONFIG (a table of similarities other than the paper's).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_next_entry(
    record: *const u8,
    size: usize,
    at: *mut usize,
    entry: *mut smr_entry,
) -> smr_status {
    // SAFETY: by the header, `size` bytes can be read at `record`, and `at` and `entry` point to memory of their types.
    status_of(unsafe { next_entry(record, size, at, entry) })
}

/// # Safety
/// If it is not NULL, `size` bytes at `record` can be read, and stay unchanged while the entry is used. An `at` that
/// passes `pointer::check` points to a number, such an `entry` to memory for an entry.
unsafe fn next_entry(record: *const u8, size: usize, at: *mut usize, entry: *mut smr_entry) -> Result<(), smr_status> {
    const NOWHERE: [core::ops::Range<usize>; 2] = [0..0, 0..0];
    pointer::check_bytes(record, size, &NOWHERE)?;
    // SAFETY: `at` points to a number, and `entry` to memory for an entry, if they pass `pointer::check`.
    let (start, next, out) = unsafe { (pointer::read(at)?, Out::new(at)?, Out::new(entry)?) };
    // SAFETY: `record` is not NULL, and has `size` initialised bytes, at most isize::MAX, which nobody changes.
    let record = unsafe { core::slice::from_raw_parts(record, size) };
    let rest = record.get(start..).ok_or(SMR_ERROR_DAMAGED)?;
    if rest.is_empty() {
        out.write(smr_entry::of(smr_entry_kind::SMR_ENTRY_END));
        return Ok(());
    }
    let found = first(rest).map_err(|damage| match damage.flaw {
        Flaw::OtherVersion(_) => SMR_ERROR_OTHER_VERSION,
        _ => SMR_ERROR_DAMAGED,
    })?;
    // SAFETY: `entry` passed `pointer::check`, so there is memory for an entry, which nobody else uses. It may be
    // uninitialised.
    fill(unsafe { &mut *entry.cast() }, &found.entry)?;
    next.write(start + found.size);
    Ok(())
}

impl smr_entry {
    const fn of(kind: smr_entry_kind) -> Self {
        // SAFETY: zeroes are a NULL pointer, numbers of 0 and the first state.
        Self { kind, ..unsafe { core::mem::zeroed() } }
    }
}

/// Begins an entry in place, with fields of 0: a copy on the stack would be as large as both configurations.
fn begun(of: &mut MaybeUninit<smr_entry>, kind: smr_entry_kind) -> &mut smr_entry {
    *of = MaybeUninit::zeroed();
    // SAFETY: zeroes are the first kind, a NULL pointer, numbers of 0 and the first state.
    let entry = unsafe { of.assume_init_mut() };
    entry.kind = kind;
    entry
}

/// Converts an entry to its struct in C. Writes nothing if it fails.
#[inline(never)] // keeps its stack out of that of the reader
fn fill(of: &mut MaybeUninit<smr_entry>, entry: &Entry<'_>) -> Result<(), smr_status> {
    use smr_entry_kind as Kind;
    match *entry {
        Entry::Begin(begin) if matches!(begin.tracker, STANDARD | SMALL) => {
            let config = begin.config(&robust::Config::robust()).ok_or(SMR_ERROR_OTHER_CONFIG)?;
            let of = begun(of, Kind::SMR_ENTRY_BEGIN);
            (of.is_robust, of.is_small, of.robust) = (1, (begin.tracker == SMALL).into(), (&config).into());
        }
        Entry::Begin(begin) => {
            let config = begin.config(&paper::Config::paper()).ok_or(SMR_ERROR_OTHER_CONFIG)?;
            let of = begun(of, Kind::SMR_ENTRY_BEGIN);
            of.paper = (&config).into();
        }
        Entry::Lock { ref frame, window, bbox } => {
            let of = begun(of, Kind::SMR_ENTRY_LOCK);
            (of.frame, of.bbox) = (smr_frame::of(frame, [Some(window), None]), bbox.into());
        }
        Entry::Moved { right, down } => {
            let of = begun(of, Kind::SMR_ENTRY_MOVED);
            (of.right, of.down) = (right, down);
        }
        Entry::Window { ref frame, window, sweep } => {
            let of = begun(of, Kind::SMR_ENTRY_WINDOW);
            of.frame = smr_frame::of(frame, [Some(window), sweep]);
        }
        Entry::Answer(answer) => {
            let of = begun(of, Kind::SMR_ENTRY_ANSWER);
            of.answer = answer.into();
        }
        Entry::Restored(saved) => {
            let of = begun(of, Kind::SMR_ENTRY_RESTORED);
            (of.saved, of.saved_size) = (saved.as_ptr(), saved.len());
        }
    }
    Ok(())
}

impl smr_frame {
    /// Converts a frame to C, with `windows` as its parts. The pixels of the windows must be in memory.
    fn of(frame: &Frame<'_>, windows: [Option<Rect>; 2]) -> Self {
        let part = |window: Option<Rect>| {
            let image = window.and_then(|window| frame.patch(window));
            smr_part::of(image.map_or(ptr::null(), |image| image.row(0).as_ptr()), window.unwrap_or_default())
        };
        let Rect { width, height, .. } = frame.bounds();
        Self { width, height, parts: windows.map(part) }
    }
}
