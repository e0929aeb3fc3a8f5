//! Prints the table of a board: cycles by the counter of the core (DWT), and updates a second at its clock.

use crate::table::{self, Row};
use cortex_m::Peripherals;
use cortex_m::peripheral::DWT;

/// Measures and prints, in the form of the README beside this file; `hertz` is the clock of the core.
pub fn print(chip: &str, hertz: u32) {
    let Some(mut core) = Peripherals::take() else { return };
    core.DCB.enable_trace();
    DWT::unlock();
    core.DWT.enable_cycle_counter();
    defmt::println!("chip: {=str}", chip);
    defmt::println!("clock: {=u32} Hz", hertz);
    defmt::println!("smr: {=str}", env!("CARGO_PKG_VERSION"));
    let done = table::rows(DWT::cycle_count, |row| {
        let Row { tracker, lock, median, most } = row;
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
