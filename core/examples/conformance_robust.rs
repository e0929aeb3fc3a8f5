//! Runs the conformance vectors of the robust tracker on the chip, at once and in steps. Logs whether all answers are
//! right, and the instructions and bytes of stack that they took. With the feature `refiner` the vectors are those with
//! the refiner.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin conformance_robust
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "vectors/answers.rs"]
mod answers;
#[cfg(target_os = "none")]
#[path = "replay/measure.rs"]
mod measure;

#[cfg(target_os = "none")]
mod firmware {
    use crate::answers::answers;
    use cortex_m as _;
    use cortex_m_rt::entry;
    use defmt::error;
    use defmt_semihosting as _;
    use semihosting::process::exit;
    use smr_core::Robust;
    #[cfg(feature = "refiner")]
    use smr_tests::REFINER as TEXT;
    #[cfg(not(feature = "refiner"))]
    use smr_tests::ROBUST as TEXT;

    #[entry]
    fn main() -> ! {
        static mut BUFFER: [u8; smr_tests::FRAME_PIXELS] = [0; smr_tests::FRAME_PIXELS];
        exit(i32::from(!answers::<Robust>("robust", TEXT, BUFFER)))
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-examples --bin conformance_robust");
}
