//! Keeps the compiler from unrolling small loops, which saves flash.
//!
//! For Arm's microcontrollers the compiler unrolls a small loop four times and adds a loop for the rest. That is
//! several times the code and saves few instructions. It does not unroll a loop that contains assembly, even if that is
//! empty, unless the number of rounds is constant.

/// Returns the same iterator, but its loop is not unrolled. Does nothing for Helium, where assembly would keep the
/// compiler from vectorizing.
#[inline(always)]
pub(crate) fn rolled<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(not(smr_helium))]
        nothing();
    })
}

/// As [`rolled`], for a plain loop that hardly ever runs because the target has a faster one. Elsewhere the compiler
/// may unroll it.
#[inline(always)]
pub(crate) fn rolled_if_spare<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(any(smr_dsp, smr_helium, smr_swar))]
        nothing();
    })
}

/// Executes empty assembly.
#[inline(always)]
#[allow(dead_code)] // not every target needs it
fn nothing() {
    #[cfg(any(target_arch = "arm", target_arch = "riscv32"))]
    // SAFETY: the assembly is empty.
    unsafe {
        core::arch::asm!("", options(nomem, nostack, preserves_flags));
    }
}

/// Returns the same number, computed before the code that follows. Without it the compiler mixes the order of
/// independent sums until it has no register left. Does nothing except for RV32.
#[inline(always)]
#[allow(dead_code)] // not every target needs it
pub(crate) fn in_order(number: i32) -> i32 {
    #[cfg(all(smr_swar, target_arch = "riscv32"))]
    let number = {
        let mut number = number;
        // SAFETY: the assembly is empty.
        unsafe {
            core::arch::asm!("/* {0} */", inout(reg) number, options(nomem, nostack, preserves_flags));
        }
        number
    };
    number
}
