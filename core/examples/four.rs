//! Four targets with one workspace, on a chip or on the host, with the same answers. Prints memory and cost.
//!
//! ```text
//! cargo run -p smr-examples --bin four
//! cargo run --target thumbv7em-none-eabihf -p smr-examples --bin four
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

use core::fmt;
use smr_core::robust::{Small, Workspace};
use smr_core::{Error, Frame, Image, Rect, Robust, Steps, Target};

const WIDTH: u16 = 160;
const HEIGHT: u16 = 96;
const FRAMES: i32 = 20;
const SIDE: u16 = 20;

/// All memory: a target takes 9.2 KB, the workspace for any number of them 34.2 KB.
struct Four {
    targets: [Robust<Small>; 4],
    workspace: Workspace<Small>,
    pixels: [u8; WIDTH as usize * HEIGHT as usize],
}

impl Four {
    const fn new() -> Self {
        Self {
            targets: [const { Robust::new() }; 4],
            workspace: Workspace::new(),
            pixels: [0; WIDTH as usize * HEIGHT as usize],
        }
    }

    /// Follows the targets and returns by how many pixels the worst box is wrong in the last frame.
    fn follow(&mut self, mut say: impl FnMut(fmt::Arguments<'_>)) -> Result<u32, Error> {
        let Self { targets, workspace, pixels } = self;
        let (each, shared) = (size_of::<Robust<Small>>(), size_of::<Workspace<Small>>());
        say(format_args!("4 targets of {each} bytes, and a workspace of {shared}"));
        let mut worst = 0;
        for number in 0..FRAMES {
            draw(pixels, number);
            let frame = Frame::whole(Image::new(pixels, WIDTH, HEIGHT)?);
            let mut work = 0;
            worst = 0;
            // One after another: each finishes before the next one takes the workspace.
            for (target, place) in targets.iter_mut().zip(places(number)) {
                if number == 0 {
                    target.lock(workspace, &frame, place)?;
                    continue;
                }
                let found = target.update(workspace, &frame)?.bbox;
                work += <Robust<Small> as Steps>::work(workspace);
                worst = worst.max(found.x.abs_diff(place.x)).max(found.y.abs_diff(place.y));
            }
            say(format_args!("frame {number}: {work} units of work, at most {worst} pixels wrong"));
        }
        Ok(worst)
    }
}

/// The boxes in a frame.
fn places(number: i32) -> [Rect; 4] {
    [(10 + number, 10), (130 - number, 14), (14, 66 - number / 2), (124, 44 + number)]
        .map(|(x, y)| Rect::new(x, y, SIDE, SIDE))
}

/// Draws blocks of random levels, finer ones in the targets.
fn draw(pixels: &mut [u8], number: i32) {
    let level = |x: i32, y: i32, kind: i32| {
        let mixed = (x + 100 * y + 10_000 * kind).unsigned_abs().wrapping_mul(0x9E37_79B1);
        (mixed ^ mixed >> 15).wrapping_mul(0x85EB_CA6B).to_be_bytes()[0]
    };
    for (y, row) in (0..).zip(pixels.chunks_exact_mut(WIDTH.into())) {
        for (x, pixel) in (0..).zip(row) {
            *pixel = 96 + level(x / 5, y / 5, 0) / 8;
            for (kind, place) in (1..).zip(places(number)) {
                let (inner_x, inner_y) = (x - place.x, y - place.y);
                if (0..i32::from(SIDE)).contains(&inner_x) && (0..i32::from(SIDE)).contains(&inner_y) {
                    *pixel = level(inner_x / 3, inner_y / 3, kind);
                }
            }
        }
    }
}

#[cfg(target_os = "none")]
mod firmware {
    use super::Four;
    // Linked only for its critical section, which the logger `defmt_semihosting` needs.
    use cortex_m as _;
    use defmt::{Display2Format, error, println};
    use defmt_semihosting as _;
    use semihosting::process::exit;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut FOUR: Four = Four::new();
        match FOUR.follow(|line| println!("{}", Display2Format(&line))) {
            Ok(0..=2) => exit(0),
            Ok(_) => exit(1),
            Err(why) => {
                error!("{}", Display2Format(&why));
                exit(1)
            }
        }
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        error!("{}", Display2Format(info));
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    if let Err(why) = Four::new().follow(|line| println!("{line}")) {
        eprintln!("error: {why}");
    }
}

#[cfg(test)]
#[test]
fn four_targets_are_followed() {
    assert!(Four::new().follow(|_| {}).unwrap() <= 2);
}
