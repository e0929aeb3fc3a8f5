//! Measurements on RV32, as in `measure.rs` on Cortex-M: the time of a computation, and the used stack.

#![allow(unsafe_code)] // reads a counter, and the stack by its address

use core::arch::asm;
use core::ptr::{addr_of, addr_of_mut};
use core::sync::atomic::{Ordering, compiler_fence};

const PAINT: u32 = 0xCCCC_CCCC;

unsafe extern "C" {
    // The ends of the stack, from the linker script of riscv-rt.
    static mut __estack: u32;
    static _stack_start: u32;
}

/// The core's counter of executed instructions.
pub struct Timer(());

impl Timer {
    pub const fn new() -> Self {
        Self(())
    }

    /// Runs `work`, which must take less than 2^32 instructions; returns its result and the number of its instructions.
    pub fn measure<T>(&mut self, work: impl FnOnce() -> T) -> (T, u32) {
        let start = instructions();
        compiler_fence(Ordering::SeqCst);
        let result = work();
        compiler_fence(Ordering::SeqCst);
        (result, instructions().wrapping_sub(start))
    }
}

fn instructions() -> u32 {
    let counted;
    // SAFETY: the register may be read in machine mode, in which the firmware runs.
    unsafe { asm!("csrr {}, minstret", out(reg) counted, options(nomem, nostack)) };
    counted
}

/// Executes this many instructions, to calibrate the timer.
pub fn spin(instructions: u32) {
    // SAFETY: two instructions per round count down a register.
    unsafe {
        asm!("2:", "addi {rounds}, {rounds}, -1", "bnez {rounds}, 2b", rounds = inout(reg) instructions / 2 => _,
             options(nomem, nostack));
    }
}

/// Fills the unused part of the stack, so that [`stack`] can later find the used part.
pub fn paint_stack() {
    let lowest = addr_of_mut!(__estack);
    // SAFETY: from the stack's lowest word up to the stack pointer nothing is in use.
    unsafe {
        asm!("2:", "bgeu {at}, sp, 3f", "sw {paint}, 0({at})", "addi {at}, {at}, 4", "j 2b", "3:",
             at = inout(reg) lowest => _, paint = in(reg) PAINT, options(nostack));
    }
}

/// Returns the most bytes of stack used so far (with those before [`paint_stack`]) and the stack's size in bytes.
pub fn stack() -> (u32, u32) {
    let (lowest, end) = (addr_of!(__estack), addr_of!(_stack_start));
    let mut at = lowest;
    // SAFETY: the linker script places both symbols, aligned, at the ends of the stack.
    while at < end && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let distance = |from: *const u32| (end as usize - from as usize) as u32;
    (distance(at), distance(lowest))
}

/// Bytes of stack in use in the caller: its own frame and those of the functions that called it.
#[inline(always)] // else they are those of this function
pub fn depth() -> u32 {
    let now: u32;
    // SAFETY: reads the stack pointer.
    unsafe { asm!("mv {}, sp", out(reg) now, options(nomem, nostack)) };
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let start = addr_of!(_stack_start) as usize as u32;
    start - now
}
