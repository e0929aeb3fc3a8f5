//! Cortex-M0+ is emulated by a larger processor of Arm, which would load words from any address.

#![allow(unsafe_code)] // writes a register of the processor

use cortex_m::peripheral::SCB;
use smr_core::similarity::Backend;

/// Lets unaligned words fault where the best backend must not load any.
pub fn require(processor: &SCB) {
    const UNALIGN_TRP: u32 = 1 << 3;
    if Backend::best() == Backend::Swar {
        // SAFETY: an access that then faults would fault on Cortex-M0+, too.
        unsafe { processor.ccr.modify(|control| control | UNALIGN_TRP) };
    }
}
