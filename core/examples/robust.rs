//! Answers the vectors of the robust tracker on the target, and says whether every answer is the one that they want; and how
//! many instructions and how much stack that took.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-core --example robust
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
    use smr_core::robust::{Config, Tracker};
    use smr_core::{Frame, Image};
    use smr_tests::{Hex, ROBUST, ROBUST_FRAME_PIXELS, RobustExpected, RobustLine, RobustReader};

    const CALIBRATION: u32 = 2_000_000;

    #[entry]
    fn main() -> ! {
        static mut BUFFER: [u8; ROBUST_FRAME_PIXELS] = [0; ROBUST_FRAME_PIXELS];
        let Some(peripherals) = Peripherals::take() else { exit(1) };
        // On the stack: of a static that is not all zeroes every byte would be in flash, too.
        let mut tracker = Tracker::new(Config::robust());
        let mut timer = Timer::new(peripherals.SYST);
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        let mut run = Run {
            buffer: BUFFER,
            size: (0, 0),
            case: "",
            tracker: &mut tracker,
            timer,
            answered: None,
            answers: 0,
            most: 0,
            sum: 0,
        };
        let mut reader = RobustReader::new(ROBUST);
        while let Some(line) = reader.next() {
            if let Err(what) = run.follow(line, &reader) {
                error!("case {=str}, answer {=u32}: {=str}", run.case, run.answers, what);
                exit(1);
            }
        }
        info!("{=u32} answers of the robust tracker, all as the vectors say", run.answers);
        let mean = run.sum / run.answers.max(1);
        info!("instructions of an update: {=u32} on average, at most {=u32}", mean * tick, run.most * tick);
        let beside = stack().0 as usize - size_of::<Tracker>();
        info!("tracker {=usize} bytes, stack {=usize} bytes beside it", size_of::<Tracker>(), beside);
        exit(i32::from(run.answers == 0))
    }

    struct Run<'v> {
        buffer: &'static mut [u8],
        size: (u16, u16),
        case: &'v str,
        tracker: &'v mut Tracker,
        timer: Timer,
        answered: Option<RobustExpected<'v>>,
        answers: u32,
        /// Ticks of updates: the most, and of all.
        most: u32,
        sum: u32,
    }

    impl<'v> Run<'v> {
        fn follow(
            &mut self,
            line: Result<RobustLine<'v>, &'v str>,
            reader: &RobustReader<'v>,
        ) -> Result<(), &'static str> {
            match line.map_err(|_| "a line is not understood")? {
                RobustLine::Case(case) => self.case = case,
                RobustLine::Size(width, height) => self.size = (width, height),
                RobustLine::Part => {}
                RobustLine::Lock(target, pixels) => {
                    *self.tracker = Tracker::new(reader.config);
                    self.tracker.lock(&frame(self.buffer, pixels, self.size)?, target).map_err(|_| "no lock")?;
                }
                RobustLine::Frame(pixels) => {
                    let frame = frame(self.buffer, pixels, self.size)?;
                    let (answer, ticks) = self.timer.measure(|| self.tracker.update(&frame));
                    let answer = answer.map_err(|_| "no update")?;
                    (self.most, self.sum) = (self.most.max(ticks), self.sum.saturating_add(ticks));
                    self.answered = Some(RobustExpected::of(&answer, self.tracker));
                }
                RobustLine::Answer(expected) => {
                    self.answers += 1;
                    if self.answered != Some(expected) {
                        return Err("another answer than the one expected");
                    }
                }
            }
            Ok(())
        }
    }

    fn frame<'b>(buffer: &'b mut [u8], pixels: Hex<'_>, size: (u16, u16)) -> Result<Frame<'b>, &'static str> {
        let pixels = pixels.decode(buffer).ok_or("a frame that does not fit")?;
        Image::new(pixels, size.0, size.1).map(Frame::whole).map_err(|_| "a frame of another size")
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-core --example robust");
}
