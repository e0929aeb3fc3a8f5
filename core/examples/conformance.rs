//! Answers the conformance vectors on the target, and says whether every answer is the one that they want.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-core --example conformance
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use cortex_m as _;
    use cortex_m_rt::entry;
    use defmt::{error, info};
    use defmt_semihosting as _;
    use semihosting::process::exit;
    use smr_core::{Frame, Image};
    use smr_tests::{CONFORMANCE, Expected, FRAME_PIXELS, Hex, Line, Reader, SmallTracker};

    #[entry]
    fn main() -> ! {
        static mut BUFFER: [u8; FRAME_PIXELS] = [0; FRAME_PIXELS];
        let mut run = Run { buffer: BUFFER, size: (0, 0), case: "", tracker: None, answered: None, answers: 0 };
        let mut reader = Reader::new(CONFORMANCE);
        while let Some(line) = reader.next() {
            if let Err(what) = run.follow(line, &reader) {
                error!("case {=str}, answer {=u32}: {=str}", run.case, run.answers, what);
                exit(1);
            }
        }
        info!("{=u32} answers, all as the vectors say", run.answers);
        exit(i32::from(run.answers == 0))
    }

    struct Run<'v> {
        buffer: &'static mut [u8],
        size: (u16, u16),
        case: &'v str,
        tracker: Option<SmallTracker>,
        answered: Option<Expected<'v>>,
        answers: u32,
    }

    impl<'v> Run<'v> {
        fn follow(&mut self, line: Result<Line<'v>, &'v str>, reader: &Reader<'v>) -> Result<(), &'static str> {
            match line.map_err(|_| "a line is not understood")? {
                Line::Case(case) => self.case = case,
                Line::Size(width, height) => self.size = (width, height),
                Line::Number => {}
                Line::Lock(target, pixels) => {
                    let mut tracker = SmallTracker::new(reader.config).map_err(|_| "the configuration is refused")?;
                    tracker.lock(&frame(self.buffer, pixels, self.size)?, target).map_err(|_| "no lock")?;
                    self.tracker = Some(tracker);
                }
                Line::Frame(pixels) => {
                    let tracker = self.tracker.as_mut().ok_or("a frame before a lock")?;
                    let answer = tracker.update(&frame(self.buffer, pixels, self.size)?).map_err(|_| "no update")?;
                    self.answered = Some(Expected::of(&answer, tracker));
                }
                Line::Answer(expected) => {
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
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-core --example conformance");
}
