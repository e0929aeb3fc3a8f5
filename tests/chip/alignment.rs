//! Makes unaligned accesses fault as on a Cortex-M0+. QEMU emulates a larger Arm processor, which allows such accesses.

#![allow(unsafe_code)] // writes a register of the processor

use cortex_m::peripheral::SCB;
use smr_core::similarity::Backend;

/// Makes unaligned word accesses fault if the best backend is SWAR. Other backends may use such accesses.
pub fn require(processor: &SCB) {
    const UNALIGN_TRP: u32 = 1 << 3;
    if Backend::best() == Backend::Swar {
        // SAFETY: sets a bit of a register. An access that now faults would also fault on Cortex-M0+.
        unsafe { processor.ccr.modify(|control| control | UNALIGN_TRP) };
    }
}
