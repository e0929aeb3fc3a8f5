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
    use smr_core::record::{ReplayError, replay};

    #[cfg(not(feature = "robust"))]
    type Run = smr_core::Paper<128, 121>;
    #[cfg(feature = "robust")]
    type Run = smr_core::Robust;

    #[cfg(not(feature = "robust"))]
    const RECORD: &[u8] = include_bytes!("../../tests/vectors/paper.smr");
    #[cfg(all(feature = "robust", not(feature = "refiner")))]
    const RECORD: &[u8] = include_bytes!("../../tests/vectors/robust.smr");
    #[cfg(feature = "refiner")]
    const RECORD: &[u8] = include_bytes!("../../tests/vectors/refined.smr");

    const CALIBRATION: u32 = 2_000_000;
    /// The work of a step.
    const STEP: u32 = 100_000;

    #[entry]
    fn main() -> ! {
        static mut TRACKER: Tracker<Run> = Tracker::new();
        exit(i32::from(!answers(TRACKER)))
    }

    /// Replays the vectors and logs the cost. Returns true if all answers are right.
    fn answers(tracker: &mut Tracker<Run>) -> bool {
        let Some(peripherals) = Peripherals::take() else { return false };
        let timer = &mut Timer::new(peripherals.SYST);
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        let (mut most, mut sum, mut longest) = (0, 0_u32, 0);
        let failed = |error: ReplayError| error!("{}", defmt::Display2Format(&error));
        let whole = replay(RECORD, tracker, |tracker, frame| {
            let (answer, ticks) = timer.measure(|| tracker.update(frame));
            (most, sum) = (most.max(ticks), sum.saturating_add(ticks));
            answer
        });
        let Ok(answers) = whole.map(|whole| whole.answers).map_err(failed) else { return false };
        let steps = replay(RECORD, tracker, |tracker, frame| {
            loop {
                let (step, ticks) = timer.measure(|| tracker.update_step(frame, STEP));
                longest = longest.max(ticks);
                if let Some(answer) = step? {
                    return Ok(answer);
                }
            }
        });
        let Ok(()) = steps.map(|_| ()).map_err(failed) else { return false };
        let mean = sum / answers.max(1);
        info!("{=u32} answers, at once and in steps, all as the vectors say", answers);
        info!("instructions of an update: {=u32} on average, at most {=u32}", mean * tick, most * tick);
        info!("instructions of a step of {=u32}: at most {=u32}", STEP, longest * tick);
        info!("tracker {=usize} bytes, stack {=u32} bytes beside it", size_of::<Tracker<Run>>(), stack().0);
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
