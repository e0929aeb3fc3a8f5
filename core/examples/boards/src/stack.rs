//! The stack that a program has used.

use core::ptr::addr_of;
use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_end: u32;
    static _stack_start: u32;
}

/// The bytes of stack used since cortex-m-rt painted the whole stack at the start, and the size of the stack in bytes.
pub fn used() -> (usize, usize) {
    let (lowest, end) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let mut at = lowest;
    // SAFETY: the linker script places both symbols, aligned, at the ends of the stack.
    while at < end && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    (end.addr() - at.addr(), end.addr() - lowest.addr())
}
