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

/// In QEMU with `-icount` a cycle of the board's clock is a fixed number of instructions. Measures how many.
pub fn instructions_a_cycle() -> u32 {
    const INSTRUCTIONS: u32 = 2_000_000;
    let start = cycles();
    // SAFETY: two instructions a round count down a register.
    unsafe {
        asm!("2:", "subs {rounds}, #1", "bne 2b", rounds = inout(reg) INSTRUCTIONS / 2 => _, options(nomem, nostack));
    }
    // A little less than a whole number, because the measurement has instructions of its own.
    let cycles = u32::try_from(cycles() - start).unwrap_or(u32::MAX);
    (INSTRUCTIONS + cycles / 2) / cycles.max(1)
}
