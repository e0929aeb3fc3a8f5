//! Runs the conformance vectors of a tracker on the chip, at once and in steps. Logs whether all answers are right, and the instructions and
//! bytes of stack that they took. The tracker is the paper's, with the feature `robust` or `refiner` the robust one.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin conformance --features robust
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "replay/measure.rs"]
mod measure;

#[cfg(target_os = "none")]
mod firmware {
    use crate::measure::{Timer, spin, stack};
    use cortex_m::Peripherals;
    use cortex_m_rt::entry;
    use defmt::{error, info};
    use defmt_semihosting as _;
    use semihosting::process::exit;
    use smr_core::Tracker;
    use smr_tests::{Passed, Vectors, follow};

    #[cfg(feature = "robust")]
    use smr_core::Robust as Run;
    #[cfg(feature = "refiner")]
    use smr_tests::REFINER as TEXT;
    #[cfg(all(feature = "robust", not(feature = "refiner")))]
    use smr_tests::ROBUST as TEXT;
    #[cfg(not(feature = "robust"))]
    use smr_tests::{PAPER as TEXT, SmallPaper as Run};

    const CALIBRATION: u32 = 2_000_000;
    /// The work of a step.
    const STEP: u32 = 100_000;

    #[entry]
    fn main() -> ! {
        static mut BUFFER: [u8; smr_tests::FRAME_PIXELS] = [0; smr_tests::FRAME_PIXELS];
        let name = if cfg!(feature = "robust") { "robust" } else { "paper" };
        exit(i32::from(!answers::<Run>(name, TEXT, BUFFER)))
    }

    /// Runs the vectors in `text` and logs the cost. Returns true if all answers are right.
    fn answers<T: Vectors>(name: &str, text: &str, buffer: &mut [u8]) -> bool {
        let Some(peripherals) = Peripherals::take() else { return false };
        let timer = &mut Timer::new(peripherals.SYST);
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        // Works through a reference: moving the tracker out of the result would put a second copy on the stack.
        let mut made = Tracker::<T>::with(T::default_config());
        let Ok(tracker) = &mut made else { return false };
        let (mut most, mut sum, mut longest) = (0, 0_u32, 0);
        let whole = follow(tracker, text, buffer, |tracker, frame| {
            let (answer, ticks) = timer.measure(|| tracker.update(frame));
            (most, sum) = (most.max(ticks), sum.saturating_add(ticks));
            answer.ok()
        });
        let Ok(Passed { answers, .. }) = whole.inspect_err(|what| {
            error!("{=str}: case {=str}, answer {=u32}: {=str}", name, what.case, what.answer, what.what);
        }) else {
            return false;
        };
        let steps = follow(tracker, text, buffer, |tracker, frame| {
            loop {
                let (step, ticks) = timer.measure(|| tracker.update_step(frame, STEP));
                longest = longest.max(ticks);
                if let Some(answer) = step.ok()? {
                    return Some(answer);
                }
            }
        });
        if steps.is_err() {
            error!("{=str}: in steps another answer than at once", name);
            return false;
        }
        let mean = sum / answers.max(1);
        info!("{=u32} answers of the {=str} tracker, at once and in steps, all as the vectors say", answers, name);
        info!("instructions of an update: {=u32} on average, at most {=u32}", mean * tick, most * tick);
        info!("instructions of a step of {=u32}: at most {=u32}", STEP, longest * tick);
        let size = size_of::<Tracker<T>>();
        info!("tracker {=usize} bytes, stack {=usize} bytes beside it", size, stack().0 as usize - size);
        answers > 0
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-examples --bin conformance");
}
