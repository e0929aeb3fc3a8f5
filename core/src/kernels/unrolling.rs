//! Loops that stay loops. For Arm's microcontrollers a compiler writes four rounds of a small loop out, and again those that are left:
//! several times the code for a few instructions less. It does not where a round holds assembly, even if that is empty.

/// The same, in a loop that is not written out. Nothing changes where there are vectors: it could not be made of them either.
#[inline(always)]
pub(crate) fn rolled<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(not(smr_helium))]
        nothing();
    })
}

/// The same for a plain loop beside a faster one, which hardly ever runs. Where there is no faster one, it may be written out.
#[inline(always)]
pub(crate) fn rolled_if_spare<I: Iterator>(iterator: I) -> impl Iterator<Item = I::Item> {
    iterator.inspect(|_| {
        #[cfg(any(smr_dsp, smr_helium))]
        nothing();
    })
}

/// Assembly that is empty.
#[inline(always)]
#[allow(dead_code)] // for those above
fn nothing() {
    #[cfg(target_arch = "arm")]
    // SAFETY: it is empty.
    unsafe {
        core::arch::asm!("", options(nomem, nostack, preserves_flags));
    }
}
