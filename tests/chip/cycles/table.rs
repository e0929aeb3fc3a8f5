//! Measures a lock and updates of each tracker on host-sim's recording `tiles`, which the firmware draws itself. All
//! chips' firmware includes this file.

use crate::scene;
use smr_core::{Frame, Paper, Rect, Robust, Target, Windows, paper, robust};

/// Size in bytes of the buffer that holds the search window and the sweep window (where a lost target is searched for).
const PIXELS: usize = 56 * 1024;
const UPDATES: usize = scene::FRAMES as usize - 1;

const TOO_LARGE: &str = "a window is too large";
const OUTSIDE: &str = "a window is outside of the frame";

/// The measured times of one tracker, in ticks of the clock.
pub struct Cycles {
    pub tracker: &'static str,
    pub lock: u32,
    pub median: u32,
    pub most: u32,
}

/// Measures each tracker, and passes its row to `tell`. `clock` counts up and may wrap. An error says what failed.
pub fn rows(clock: impl Fn() -> u32, mut tell: impl FnMut(Cycles)) -> Result<(), &'static str> {
    tell(measure::<Paper<4096, 33>>("paper's", paper::Config::camera_within(16), &clock)?);
    let (mut robust, mut refined) = (robust::Config::robust(), robust::Config::refined());
    (robust.sweep, refined.sweep) = (1, 1); // the pixels of four windows do not fit into the RAM of every chip here
    tell(measure::<Robust>("robust", robust, &clock)?);
    measure::<Robust>("robust with refiner", refined, &clock).map(tell)
}

#[inline(never)] // so that only one tracker is on the stack
fn measure<T: Target>(
    tracker: &'static str,
    config: T::Config,
    clock: &impl Fn() -> u32,
) -> Result<Cycles, &'static str> {
    let mut pixels = [0; PIXELS];
    // Uses a reference, because moving the target out of the result would put a second copy on the stack.
    let (mut made, mut workspace) = (T::with(config), T::Workspace::default());
    let Ok(target) = &mut made else { return Err("a configuration cannot be used") };
    let start = Rect::new(scene::START.0.into(), scene::START.1.into(), scene::SIDE, scene::SIDE);
    let bounds = Rect::new(0, 0, scene::WIDTH, scene::HEIGHT);
    let first = draw(0, target.lock_window(bounds, start).into(), &mut pixels)?;
    let begin = clock();
    let locked = target.lock(&mut workspace, &first, start);
    let lock = clock().wrapping_sub(begin);
    locked.map_err(|_| "a tracker does not lock")?;
    let mut counts = [0; UPDATES];
    for (number, count) in (1..).zip(&mut counts) {
        let windows = target.windows().ok_or("a target is not locked")?;
        let frame = draw(number, windows, &mut pixels)?;
        let begin = clock();
        let answer = target.update(&mut workspace, &frame);
        *count = clock().wrapping_sub(begin);
        answer.map_err(|_| "a tracker does not update")?;
    }
    counts.sort_unstable();
    Ok(Cycles { tracker, lock, median: counts[UPDATES / 2], most: counts[UPDATES - 1] })
}

/// A frame of which only the pixels in `windows` are in memory.
fn draw(number: u16, windows: Windows, pixels: &mut [u8; PIXELS]) -> Result<Frame<'_>, &'static str> {
    let mut rest = &mut pixels[..];
    for window in windows {
        let (part, others) = rest.split_at_mut_checked(area(window)).ok_or(TOO_LARGE)?;
        paint(number, window, part);
        rest = others;
    }
    Frame::of_windows(pixels, windows, (scene::WIDTH, scene::HEIGHT)).map_err(|_| OUTSIDE)
}

fn paint(number: u16, window: Rect, pixels: &mut [u8]) {
    let [left, top] = [window.x, window.y].map(|place| u16::try_from(place).unwrap_or(0));
    for (row, y) in pixels.chunks_exact_mut(window.width.max(1).into()).zip(top..) {
        row.iter_mut().zip(left..).for_each(|(pixel, x)| *pixel = scene::level(number, x, y));
    }
}

fn area(window: Rect) -> usize {
    usize::from(window.width) * usize::from(window.height)
}
