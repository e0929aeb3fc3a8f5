//! Measures the cycles of both trackers on an RP2350 at 150 MHz or an STM32H743 at 400 MHz. Not yet run on a board.
//!
//! Code runs from flash through a cache of 16 KB. All data lies in RAM without wait states (STM32H743: the DTCM).

#![no_std]
#![no_main]

#[path = "../../../../../host-sim/scene/src/tiles.rs"]
#[allow(dead_code)] // the host needs more of it
mod scene;
#[path = "../../../../../tests/chip/cycles/table.rs"]
mod table;

use cortex_m::Peripherals;
use cortex_m::peripheral::DWT;
use cortex_m_rt::entry;
use defmt_rtt as _;
use panic_halt as _;
use table::Cycles;

#[entry]
fn main() -> ! {
    if let Some(mut core) = Peripherals::take() {
        let (chip, hertz) = start(&mut core);
        print(core, chip, hertz);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

/// Sets the core clock. Returns the chip's name and the clock in hertz.
#[cfg(rp2350)]
fn start(_: &mut Peripherals) -> (&'static str, u32) {
    let _chip = embassy_rp::init(embassy_rp::config::Config::default());
    ("RP2350", embassy_rp::clocks::clk_sys_freq())
}

/// Sets the core clock from the internal 64 MHz oscillator. Enables caches. Returns the chip's name and clock in Hz.
#[cfg(not(rp2350))]
fn start(core: &mut Peripherals) -> (&'static str, u32) {
    use embassy_stm32::rcc::{
        AHBPrescaler, APBPrescaler, HSIPrescaler, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk, VoltageScale,
    };
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    let mut config = embassy_stm32::Config::default();
    config.rcc.hsi = Some(HSIPrescaler::DIV1);
    config.rcc.pll1 = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL50,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV2;
    config.rcc.apb1_pre = APBPrescaler::DIV2;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config.rcc.apb3_pre = APBPrescaler::DIV2;
    config.rcc.apb4_pre = APBPrescaler::DIV2;
    config.rcc.voltage_scale = VoltageScale::Scale1;
    let _chip = embassy_stm32::init(config);
    ("STM32H743", 400_000_000)
}

/// Measures with the core's cycle counter (DWT), and prints in the format of `tests/chip/cycles/README.md`.
fn print(mut core: Peripherals, chip: &str, hertz: u32) {
    core.DCB.enable_trace();
    DWT::unlock();
    core.DWT.enable_cycle_counter();
    defmt::println!("chip: {=str}", chip);
    defmt::println!("clock: {=u32} Hz", hertz);
    defmt::println!("smr: {=str}", env!("CARGO_PKG_VERSION"));
    let done = table::rows(DWT::cycle_count, |row| {
        let Cycles { tracker, lock, median, most } = row;
        defmt::println!(
            "{=str}: lock {=u32}, update median {=u32}, at most {=u32} cycles; {=u32} updates a second",
            tracker,
            lock,
            median,
            most,
            hertz / median.max(1)
        );
    });
    match done {
        Ok(()) => defmt::println!("end"),
        Err(what) => defmt::println!("error: {=str}", what),
    }
}
