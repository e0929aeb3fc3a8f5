//! What the firmware finds out about itself: the time that work takes, and how much of the stack was used.

#![allow(unsafe_code)] // the stack's paint is no Rust object

use core::arch::asm;
use core::ptr::addr_of;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::STACK_PAINT_VALUE;

/// The core's own 24-bit timer. With QEMU's `-icount` it counts instructions, so many a tick.
pub struct Timer(#[allow(dead_code)] SYST);

impl Timer {
    pub fn new(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00FF_FFFF);
        timer.clear_current();
        timer.enable_counter();
        Self(timer)
    }

    /// What `work` gives, and its ticks. Nothing here takes the 2^24 ticks (0.6 thousand million instructions) after
    /// which the timer starts anew.
    pub fn measure<T>(&mut self, work: impl FnOnce() -> T) -> (T, u32) {
        let start = SYST::get_current();
        compiler_fence(Ordering::SeqCst);
        let result = work();
        compiler_fence(Ordering::SeqCst);
        // It counts down.
        (result, start.wrapping_sub(SYST::get_current()) & 0x00FF_FFFF)
    }
}

/// Takes so many instructions, to find out how many a tick is; `cortex_m::asm::delay` takes as many as its version likes.
pub fn spin(instructions: u32) {
    // SAFETY: it counts down in a register, by two instructions a round.
    unsafe {
        asm!("2:", "subs {rounds}, #1", "bne 2b", rounds = inout(reg) instructions / 2 => _, options(nomem, nostack));
    }
}

/// Bytes of stack that were used since the start, and that there are. cortex-m-rt has painted all of it.
pub fn stack() -> (u32, u32) {
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let (lowest, end) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let mut at = lowest;
    // SAFETY: the linker script places both symbols, aligned, around memory that is the stack's.
    while at < end && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let distance = |from: *const u32| (end as usize - from as usize) as u32;
    (distance(at), distance(lowest))
}
