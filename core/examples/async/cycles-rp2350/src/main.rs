//! Measures the cycles of both trackers on a RP2350 at its usual clock of 150 MHz. Built, but not yet run on a board.
//!
//! ```text
//! cargo run --release --target thumbv8m.main-none-eabihf -p cycles-rp2350
//! ```
//!
//! The code runs from flash through the cache of 16 KB; target, workspace and pixels lie in SRAM without waits.

#![no_std]
#![no_main]

#[path = "../../../cycles/board.rs"]
mod board;
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
    let _chip = embassy_rp::init(embassy_rp::config::Config::default());
    board::print("RP2350", embassy_rp::clocks::clk_sys_freq());
    loop {
        cortex_m::asm::wfi();
    }
}
