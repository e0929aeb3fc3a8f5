//! Measures the cycles of both trackers on a STM32H743 at 400 MHz. Built, but not yet run on a board.
//!
//! ```text
//! cargo run --release --target thumbv7em-none-eabihf -p cycles-stm32h7
//! ```
//!
//! The code runs from flash through the cache of 16 KB; target, workspace and pixels lie in the DTCM without waits.

#![no_std]
#![no_main]

#[path = "../../../cycles/board.rs"]
mod board;
#[path = "../../embassy-stm32h7/src/clocks.rs"]
mod clocks;
#[path = "../../../../../host-sim/recordings/src/tiles/scene.rs"]
#[allow(dead_code)] // the host needs more of it
mod scene;
#[path = "../../../cycles/table.rs"]
mod table;

use cortex_m_rt::entry;
use defmt_rtt as _;
use panic_halt as _;

#[entry]
fn main() -> ! {
    // SAFETY: only the caches are turned on, before anything else has the core's registers.
    let mut core = unsafe { cortex_m::Peripherals::steal() };
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    let _chip = embassy_stm32::init(clocks::clocks());
    board::print("STM32H743", 400_000_000);
    loop {
        cortex_m::asm::wfi();
    }
}
