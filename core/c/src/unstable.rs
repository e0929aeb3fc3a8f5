//! Calls for JavaScript (`core/web`) that `smr.h` does not declare and that may change in any version: internals of a
//! tracker, a flight record in memory, and checks of the build.

use crate::frame::smr_frame;
use crate::pointer::Out;
use crate::record::{smr_record, smr_recorder};
use crate::status::{smr_status, status_of};
use crate::tracker::{ResponseMap, smr_tracker, with_frame, write_result};
use core::ffi::c_void;

/// Sets `work` to the work of the present or last update or lock in the workspace of `tracker`, even by another
/// tracker, plus that of any later `smr_response_map`, in the units of `smr_update_step`.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker during the call. A `work` that is neither NULL nor misaligned points to memory for a
/// number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_work(tracker: *const smr_tracker, work: *mut u32) -> smr_status {
    // SAFETY: `tracker` is a handle that nobody else uses during the call, and `work` points to memory for a number.
    status_of(unsafe { write_result(tracker, work, |tracker| tracker.work()) })
}

/// Sets `responses[reach + y][reach + x]` to the robust tracker's filter response in `frame` at (x, y) cells from the
/// middle of the next update's search window, in units of 1/16384, without the distance penalty. `reach` is the
/// tracker's setting; entries with an index above 2 * `reach` are 0. Cancels an update under way.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker during the call. If they are neither NULL nor misaligned, `frame` points to a frame
/// whose pixels can be read and stay unchanged during the call, and `responses` to memory for a map.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_response_map(
    tracker: *mut smr_tracker,
    frame: *const smr_frame,
    responses: *mut ResponseMap,
) -> smr_status {
    // SAFETY: `tracker` is a handle that nobody else uses during the call, the pixels of `frame` can be read, and
    // `responses` points to memory for a map.
    status_of(unsafe {
        with_frame(tracker, frame, |tracker, frame| {
            let out = Out::new(responses)?;
            out.write(tracker.response_map(frame)?);
            Ok(())
        })
    })
}

/// Memory for a flight record. JavaScript, which reads the bytes, resets `used` to 0.
#[repr(C)]
pub struct Sink {
    recorder: smr_recorder,
    bytes: *mut u8,
    size: usize,
    used: usize,
}

/// Calls [`smr_record`] with a `write` that stores into the memory of `sink`: JavaScript cannot pass a C function.
///
/// # Safety
/// A `tracker` that is not NULL points to a handle that `smr_init` made, or to memory of that size without its mark.
/// Nobody else uses the tracker during the call. `sink` is not NULL, and points to a [`Sink`] that stays in place, for
/// this tracker alone, while it records. `size` bytes can be written at its `bytes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_record_to_memory(tracker: *mut smr_tracker, sink: *mut Sink) -> smr_status {
    // SAFETY: `sink` points to a sink, which nobody else uses and which stays in place, as `smr_record` demands of its
    // recorder.
    unsafe {
        (*sink).recorder.write = Some(to_memory);
        (*sink).recorder.context = sink.cast();
        smr_record(tracker, &raw mut (*sink).recorder)
    }
}

/// # Safety
/// `sink` points to a [`Sink`] that nobody else uses, with `size` bytes that can be written at its `bytes`. `count`
/// bytes can be read at the argument `bytes`, outside of them.
unsafe extern "C" fn to_memory(sink: *mut c_void, bytes: *const u8, count: usize) -> i32 {
    // SAFETY: `sink` points to a sink. At most the bytes from `used` on are written of its `size` bytes.
    unsafe {
        let sink = &mut *sink.cast::<Sink>();
        if count > sink.size - sink.used.min(sink.size) {
            return 1;
        }
        sink.bytes.add(sink.used).copy_from_nonoverlapping(bytes, count);
        sink.used += count;
    }
    0
}

/// 1 if the library uses the vectors of WebAssembly (SIMD128), else 0.
#[unsafe(no_mangle)]
pub extern "C" fn smr_simd() -> u8 {
    cfg!(target_feature = "simd128").into()
}

/// Compares all kernels of the best backend with formulas or plain loops. Panics if a result differs.
#[cfg(feature = "check")]
#[unsafe(no_mangle)]
pub extern "C" fn smr_check_kernels() {
    use smr_core::{similarity::Backend, unstable::check};
    let [mut end, mut other_end, mut start] = [[0; check::ROOM]; 3];
    check::all(Backend::best(), &mut check::Areas { end: &mut end, other_end: &mut other_end, start: &mut start });
}
