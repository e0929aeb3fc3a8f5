//! Measures the turns of a task: the time from when the executor runs it until it yields.

use crate::clock::cycles;
use core::arch::asm;

pub struct Turns {
    since: u64,
    longest: u64,
}

impl Turns {
    pub fn begin() -> Self {
        Self { since: cycles(), longest: 0 }
    }

    /// Ends the turn: other tasks run now, if they are ready.
    pub async fn yield_now(&mut self) {
        self.longest = self.longest.max(cycles() - self.since);
        embassy_futures::yield_now().await;
        self.since = cycles();
    }

    pub fn longest_cycles(&self) -> u32 {
        u32::try_from(self.longest).unwrap_or(u32::MAX)
    }
}

/// Measures the instructions of a cycle of the board's clock. In QEMU with `-icount` this number is fixed.
pub fn instructions_a_cycle() -> u32 {
    const INSTRUCTIONS: u32 = 2_000_000;
    let start = cycles();
    // SAFETY: two instructions a round count down a register.
    unsafe {
        asm!("2:", "subs {rounds}, #1", "bne 2b", rounds = inout(reg) INSTRUCTIONS / 2 => _, options(nomem, nostack));
    }
    // Rounded: the measurement has instructions of its own, so the quotient is a little too small.
    let cycles = u32::try_from(cycles() - start).unwrap_or(u32::MAX);
    (INSTRUCTIONS + cycles / 2) / cycles.max(1)
}
