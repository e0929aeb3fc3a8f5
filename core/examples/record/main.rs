//! A flight recorder on the chip: follows a drawn target with both trackers, writes a flight record, and logs how many
//! instructions an update and its recording take on average.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin record
//! cargo run --release -p host-sim -- replay record.smr
//! ```
//!
//! The first command runs the firmware in QEMU and writes `record.smr` to the working folder. The second replays that
//! record and compares every answer. The log also contains the paper tracker's record, which `host-sim replay` can
//! read. On a board, write to flash, an SD card, a serial line, or the debug probe's log.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[allow(dead_code)] // this firmware only writes
mod host_file;
#[cfg(target_os = "none")]
#[allow(dead_code)] // this firmware does not measure the stack
mod measure;

#[cfg(target_os = "none")]
mod firmware {
    use crate::host_file::HostFile;
    use crate::measure::{Timer, spin};
    use cortex_m::Peripherals;
    use cortex_m_rt::entry;
    use defmt::{error, info};
    use defmt_semihosting as _;
    use semihosting::process::exit;
    use smr_core::paper;
    use smr_core::record::{Recorded, Recorder};
    use smr_core::{Frame, Image, Paper, Rect, Robust, Tracker, robust};

    const WIDTH: u16 = 96;
    const HEIGHT: u16 = 72;
    const PIXELS: usize = WIDTH as usize * HEIGHT as usize;
    const FRAMES: u16 = 30;
    const START: Rect = Rect::new(20, 16, 16, 16);
    const CALIBRATION: u32 = 2_000_000;

    type Small = Paper<256, 25>;

    #[entry]
    fn main() -> ! {
        static mut FRAME: [u8; PIXELS] = [0; PIXELS];
        let Some(peripherals) = Peripherals::take() else { exit(1) };
        let mut timer = Timer::new(peripherals.SYST);
        let Some(mut file) = HostFile::create(c"record.smr") else {
            error!("record.smr cannot be written");
            exit(1)
        };
        let config = paper::Config::camera_within(12);

        let mut to_file = |bytes: &[u8]| file.write(bytes).ok_or(());
        let to_log = |bytes: &[u8]| -> Result<(), ()> {
            defmt::println!("smr-record {=[u8]:02x}", bytes);
            Ok(())
        };
        let done = follow::<Small>("paper", config, FRAME, &mut timer, &mut to_file)
            .and_then(|()| follow::<Robust>("robust", robust::Config::robust(), FRAME, &mut timer, &mut to_file))
            .and_then(|()| follow::<Small>("paper, to the log", config, FRAME, &mut timer, to_log));
        match done {
            Ok(()) => exit(0),
            Err(what) => {
                error!("{=str}", what);
                exit(1)
            }
        }
    }

    #[inline(never)] // so that only one tracker is on the stack
    fn follow<T: Recorded>(
        name: &str,
        config: T::Config,
        pixels: &mut [u8; PIXELS],
        timer: &mut Timer,
        write: impl FnMut(&[u8]) -> Result<(), ()>,
    ) -> Result<(), &'static str> {
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        // Uses a reference, because moving the tracker out of the result would put a second copy on the stack.
        let mut made = Tracker::<T>::with(config);
        let Ok(tracker) = &mut made else { return Err("the configuration cannot be used") };
        let not_written = |()| "the record cannot be written";
        let mut recorder = Recorder::begin(tracker.target(), write).map_err(not_written)?;

        draw(pixels, 0);
        let first = frame(pixels)?;
        tracker.lock(&first, START).map_err(|_| "cannot lock on the box")?;
        recorder.lock(tracker.target(), &first, START).map_err(not_written)?;
        let (mut updates, mut records) = (0_u32, 0_u32);
        for number in 1..FRAMES {
            draw(pixels, number);
            let frame = frame(pixels)?;
            let (written, before) = timer.measure(|| recorder.window(tracker.target(), &frame));
            written.map_err(not_written)?;
            let (answer, ticks) = timer.measure(|| tracker.update(&frame));
            let answer = answer.map_err(|_| "cannot search the frame")?;
            let (written, after) = timer.measure(|| recorder.answer(&answer));
            written.map_err(not_written)?;
            (updates, records) = (updates + ticks, records + before + after);
        }
        let frames = u32::from(FRAMES) - 1;
        let [update, record] = [updates, records].map(|ticks| ticks / frames * tick);
        info!("{=str}: {=u32} instructions an update, {=u32} to record it, on average", name, update, record);
        Ok(())
    }

    fn frame(pixels: &[u8; PIXELS]) -> Result<Frame<'_>, &'static str> {
        Image::new(pixels, WIDTH, HEIGHT).map(Frame::whole).map_err(|_| "a frame has WIDTH * HEIGHT pixels")
    }

    /// Draws low-contrast tiles, and a high-contrast target that moves 2 pixels per frame and hides for eight frames.
    fn draw(pixels: &mut [u8; PIXELS], number: u16) {
        let hash = |x: u16, y: u16| (u32::from(x) * 73 + u32::from(y) * 179 + 7).wrapping_mul(2_654_435_761) >> 24;
        let (left, top) = (20 + 2 * (number % 24), 16 + number % 24);
        let hidden = (12..20).contains(&number);
        let mut place = (0, 0);
        for pixel in pixels.iter_mut() {
            let (x, y) = place;
            let inside = !hidden && (left..left + 16).contains(&x) && (top..top + 16).contains(&y);
            let level = if inside { hash((x - left) / 4, (y - top) / 4) } else { 90 + hash(x / 8, y / 8 + 40) / 6 };
            *pixel = u8::try_from(level).unwrap_or(u8::MAX);
            place = if x + 1 == WIDTH { (0, y + 1) } else { (x + 1, y) };
        }
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
include!("../host.rs");
