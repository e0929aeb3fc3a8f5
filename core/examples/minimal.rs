//! A first firmware: locks on a target in one frame, finds it in the next frames, and logs its box. In QEMU:
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin minimal
//! ```
//!
//! For your board, put your chip's addresses into `memory.x`, take the frames from your camera, and replace
//! `defmt-semihosting` by the logger of your debug probe (`defmt-rtt`).

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    // Linked only for its critical section, which the logger `defmt_semihosting` needs.
    use cortex_m as _;
    use cortex_m_rt::entry;
    use defmt::{error, info};
    use defmt_semihosting as _;
    use semihosting::process::exit;
    use smr_core::{Error, Frame, Image, Paper, Rect, State, Tracker};

    const WIDTH: u16 = 64;
    const HEIGHT: u16 = 48;
    const FRAME: usize = WIDTH as usize * HEIGHT as usize;

    /// The target's box in the first frame: 10x10 pixels.
    const START: Rect = Rect::new(20, 16, 10, 10);

    /// Three frames in flash in place of a camera, drawn at compile time. The target moves by a few pixels per frame.
    static FRAMES: [[u8; FRAME]; 3] = [draw(20, 16), draw(24, 15), draw(29, 17)];

    /// A tracker for at most 256 template pixels and 17 offsets per axis (a window of -8..=8). Both are small, because
    /// an update's work is offsets times pixels. The tracker contains all its memory, so it could also be a `static`.
    type Small = Tracker<Paper<256, 17>>;

    #[entry]
    fn main() -> ! {
        match follow(&mut Small::new()) {
            Ok(()) => exit(0),
            Err(what) => {
                error!("{}", defmt::Display2Format(&what));
                exit(1)
            }
        }
    }

    fn follow(tracker: &mut Small) -> Result<(), Error> {
        info!("a tracker takes {=usize} bytes", size_of::<Small>());

        let [first, others @ ..] = &FRAMES;
        tracker.lock(&frame(first)?, START)?;

        for (number, pixels) in (2u32..).zip(others) {
            // The tracker reads only this window. If the camera can read out a window, pass it by `Frame::of_windows`.
            let window = tracker.window().unwrap_or_default();
            info!("frame {=u32}: reads {=u16}x{=u16} pixels", number, window.width, window.height);

            let answer = tracker.update(&frame(pixels)?)?;
            let Rect { x, y, .. } = answer.bbox;
            match answer.state {
                // The ratio is the similarity of target and template; 65535 is 1.0.
                State::Tracking => info!("at ({=i32}, {=i32}), ratio {=u16} of 65535", x, y, answer.ratio),
                // The target is partly outside the frame, so the template is not updated.
                State::Leaving => info!("leaving at ({=i32}, {=i32})", x, y),
                // The box is the last accepted one. Keep updating, to find the target again. (`Paper` is never
                // uncertain.)
                _ => info!("lost, last seen at ({=i32}, {=i32})", x, y),
            }
        }
        Ok(())
    }

    /// Borrows the pixels as a frame, without a copy.
    fn frame(pixels: &[u8; FRAME]) -> Result<Frame<'_>, Error> {
        Ok(Frame::whole(Image::new(pixels, WIDTH, HEIGHT)?))
    }

    /// Draws the target, a pattern that does not repeat, at (`left`, `top`) on a flat background.
    const fn draw(left: usize, top: usize) -> [u8; FRAME] {
        let mut pixels = [60; FRAME];
        let mut i = 0;
        while i < 100 {
            let (x, y) = (i % 10, i / 10);
            pixels[(top + y) * WIDTH as usize + left + x] = (80 + (i * i * 7) % 170) as u8;
            i += 1;
        }
        pixels
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", defmt::Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
include!("host.rs");
