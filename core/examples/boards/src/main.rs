//! Follows a drawn target in frames from flash, and sends a flight record by the board's UART, as text that `host-sim replay` reads.

#![no_std]
#![no_main]

mod stack;
mod uart;

use core::fmt::Write;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use smr_core::record::{Recorded, Recorder};
use smr_core::{Frame, Image, Paper, Rect, Tracker, paper};
#[cfg(feature = "netduinoplus2")]
use smr_core::{Robust, robust};
use uart::Uart;

const WIDTH: u16 = 64;
const HEIGHT: u16 = 48;
static FRAMES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/frames.raw"));

/// The target's box in the first frame.
const START: Rect = Rect::new(6, 4, 12, 12);

/// Boxes up to 16x16 in a window of +-8: all that 8 KB of RAM hold beside the stack.
#[cfg(feature = "stm32vldiscovery")]
type OwnPaper = Paper<256, 17>;
/// Boxes up to 32x32 in a window of +-16.
#[cfg(not(feature = "stm32vldiscovery"))]
type OwnPaper = Paper<1024, 33>;

#[cfg(feature = "stm32vldiscovery")]
const RADIUS: u16 = 8;
#[cfg(not(feature = "stm32vldiscovery"))]
const RADIUS: u16 = 16;

#[entry]
fn main() -> ! {
    static mut PAPER: Tracker<OwnPaper> = Tracker::new();
    #[cfg(feature = "netduinoplus2")]
    static mut ROBUST: Tracker<Robust<robust::Small>> = Tracker::new();
    let mut uart = Uart::new();
    let said = PAPER
        .configure(paper::Config::camera_within(RADIUS))
        .map_err(|_| "the configuration cannot be used")
        .and_then(|()| follow("paper", PAPER, &mut uart));
    #[cfg(feature = "netduinoplus2")]
    let said = said.and_then(|()| follow("robust, small", ROBUST, &mut uart));
    let (used, size) = stack::used();
    let _ = match said {
        Ok(()) => write!(uart, "stack: {used} of {size} bytes\r\nend\r\n"),
        Err(what) => write!(uart, "error: {what}\r\nend\r\n"),
    };
    loop {}
}

#[inline(never)]
fn follow<T: Recorded>(name: &str, tracker: &mut Tracker<T>, uart: &mut Uart) -> Result<(), &'static str> {
    const NOT_SENT: &str = "the record cannot be sent";
    let _ = write!(uart, "{name}: {} bytes\r\n", size_of_val(tracker));
    let mut frames = FRAMES.chunks_exact(usize::from(WIDTH) * usize::from(HEIGHT));
    let first = frame(frames.next().unwrap_or_default())?;
    let mut recorder = Recorder::begin(tracker.target(), |bytes| {
        write!(uart, "smr-record [")?;
        for (number, byte) in bytes.iter().enumerate() {
            write!(uart, "{}{byte:02x}", if number > 0 { ", " } else { "" })?;
        }
        write!(uart, "]\r\n")
    })
    .map_err(|_| NOT_SENT)?;
    tracker.lock(&first, START).map_err(|_| "cannot lock on the box")?;
    recorder.lock(tracker.target(), &first, START).map_err(|_| NOT_SENT)?;
    for pixels in frames {
        let frame = frame(pixels)?;
        recorder.window(tracker.target(), &frame).map_err(|_| NOT_SENT)?;
        let answer = tracker.update(&frame).map_err(|_| "cannot search the frame")?;
        recorder.answer(&answer).map_err(|_| NOT_SENT)?;
    }
    Ok(())
}

fn frame(pixels: &[u8]) -> Result<Frame<'_>, &'static str> {
    Image::new(pixels, WIDTH, HEIGHT).map(Frame::whole).map_err(|_| "a frame has WIDTH * HEIGHT pixels")
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
