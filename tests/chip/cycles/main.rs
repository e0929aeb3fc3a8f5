//! Prints the table of cycles (README.md) in QEMU, which counts instructions in place of cycles.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-chip --features refiner --bin cycles
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../../../core/examples/record/measure.rs"]
#[allow(dead_code)] // this firmware does not measure the stack
mod measure;
#[cfg(target_os = "none")]
#[allow(dead_code)] // the host needs more of it
#[path = "../../../host-sim/scene/src/tiles.rs"]
mod scene;
#[cfg(target_os = "none")]
mod table;

#[cfg(target_os = "none")]
mod firmware {
    use crate::measure::{Timer, smr_ticks, spin};
    use crate::table::{self, Cycles};
    use cortex_m::Peripherals;
    use cortex_m_rt::entry;
    use defmt::{error, info};
    use defmt_semihosting as _;
    use semihosting::process::exit;

    const CALIBRATION: u32 = 2_000_000;

    #[entry]
    fn main() -> ! {
        let Some(peripherals) = Peripherals::take() else { exit(1) };
        let mut timer = Timer::new(peripherals.SYST);
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        // The timer counts down, so its value is inverted. Its 24 bits, shifted up by 8, wrap just as a `u32`.
        let done = table::rows(
            || !smr_ticks() << 8,
            |row| {
                let Cycles { tracker, lock, median, most } = row;
                let [lock, median, most] = [lock, median, most].map(|count| (count >> 8) * tick);
                info!(
                    "{=str}: lock {=u32}, update median {=u32}, at most {=u32} instructions",
                    tracker, lock, median, most
                );
            },
        );
        if let Err(what) = done {
            error!("{=str}", what);
        }
        exit(i32::from(done.is_err()))
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
include!("../host.rs");
