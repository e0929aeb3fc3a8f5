//! Measurements on Cortex-M: the time of a computation, and the used stack.

#![allow(unsafe_code)] // reads the stack by its address, and names a function

use core::arch::asm;
use core::ptr::addr_of;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::STACK_PAINT_VALUE;

/// The core's 24-bit timer. With QEMU's `-icount`, a tick is a fixed number of instructions.
pub struct Timer(#[allow(dead_code)] SYST);

impl Timer {
    pub fn new(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00FF_FFFF);
        timer.clear_current();
        timer.enable_counter();
        Self(timer)
    }

    /// Runs `work`, which must take less than 2^24 ticks (600 million instructions); returns its result and ticks.
    pub fn measure<T>(&mut self, work: impl FnOnce() -> T) -> (T, u32) {
        let start = smr_ticks();
        compiler_fence(Ordering::SeqCst);
        let result = work();
        compiler_fence(Ordering::SeqCst);
        // The timer counts down.
        (result, start.wrapping_sub(smr_ticks()) & 0x00FF_FFFF)
    }
}

/// Returns the timer's value, which counts down from 2^24 - 1 to 0 and starts again. `smr-qemu --cycles` finds the
/// calls of this function in QEMU's trace by its name.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
#[inline(never)]
pub extern "C" fn smr_ticks() -> u32 {
    SYST::get_current()
}

/// Executes this many instructions, to calibrate the timer. (In `cortex_m::asm::delay`, the number varies by version.)
pub fn spin(instructions: u32) {
    // SAFETY: two instructions per round count down a register.
    unsafe {
        asm!("2:", "subs {rounds}, #1", "bne 2b", rounds = inout(reg) instructions / 2 => _, options(nomem, nostack));
    }
}

/// The bytes of stack used since cortex-m-rt painted the whole stack at the start, and the size of the stack in bytes.
pub fn stack() -> (u32, u32) {
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let (lowest, end) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let mut at = lowest;
    // SAFETY: the linker script places both symbols, aligned, at the ends of the stack.
    while at < end && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let distance = |from: *const u32| (end as usize - from as usize) as u32;
    (distance(at), distance(lowest))
}

/// Bytes of stack in use in the caller: its own frame and those of the functions that called it.
#[inline(always)] // else they are those of this function
pub fn depth() -> u32 {
    unsafe extern "C" {
        static _stack_start: u32;
    }
    let now: u32;
    // SAFETY: reads the stack pointer.
    unsafe { asm!("mov {}, sp", out(reg) now, options(nomem, nostack)) };
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let start = addr_of!(_stack_start) as usize as u32;
    start - now
}
