//! Keeps the compiler from unrolling small loops, which saves flash.
//!
//! For Arm's microcontrollers the compiler unrolls a small loop four times and adds a loop for the remainder: several
//! times the code, for few saved instructions. It does not unroll a loop that contains assembly, even empty assembly,
//! unless the number of iterations is constant.

/// Returns the same iterator, but keeps the compiler from unrolling its loop. Does nothing for Helium, where its `asm!`
/// would prevent vectorization.
#[inline(always)]
pub(crate) fn rolled<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(not(smr_helium))]
        nothing();
    })
}

/// Like [`rolled`], but only on targets with a faster loop, where the plain loop hardly ever runs.
#[inline(always)]
pub(crate) fn rolled_if_rare<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(any(smr_dsp, smr_helium, smr_swar))]
        nothing();
    })
}

#[inline(always)]
#[allow(dead_code)] // not every target needs it
fn nothing() {
    #[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64"))]
    // SAFETY: the assembly is empty.
    unsafe {
        core::arch::asm!("", options(nomem, nostack, preserves_flags));
    }
}

/// Returns `number`, and computes it before the code that follows (RISC-V only). Without this the compiler interleaves
/// independent sums until it runs out of registers.
#[inline(always)]
#[allow(dead_code)] // not every target needs it
pub(crate) fn in_order(number: i32) -> i32 {
    #[cfg(all(smr_swar, any(target_arch = "riscv32", target_arch = "riscv64")))]
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
