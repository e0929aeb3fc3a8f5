//! The cost of the kernels: instructions per call, and 1/1000 instruction per pixel.

use crate::measure::{Timer, spin};
use crate::memory::Memory;
use core::hint::black_box;
use defmt::{Debug2Format, info};
use smr_core::readout::{Format, Readout};
use smr_core::similarity::{Backend, CutTable, Scorer, Table};
use smr_core::unstable::spread;
use smr_core::{Image, Rect};

const CALIBRATION: u32 = 2_000_000;
const REPEATED: u32 = 1000;
/// The usual threshold of the paper's tracker.
const THRESHOLD: u16 = 13;

/// Counts instructions. It repeats the work, because a tick of the timer is many instructions.
pub struct Counter {
    timer: Timer,
    ticks: u32,
}

impl Counter {
    pub fn new(mut timer: Timer) -> Self {
        let ticks = timer.measure(|| spin(CALIBRATION)).1.max(1);
        Self { timer, ticks }
    }

    /// The instructions of `work`, including its call.
    fn count<T>(&mut self, mut work: impl FnMut() -> T) -> u32 {
        let ((), ticks) = self.timer.measure(|| (0..REPEATED).for_each(|_| drop(black_box(work()))));
        let instructions = u64::from(ticks) * u64::from(CALIBRATION) / u64::from(self.ticks);
        u32::try_from(instructions).unwrap_or(u32::MAX) / REPEATED
    }
}

/// Logs one line for each backend, kernel and size.
pub fn print(counter: &mut Counter, memory: &mut Memory) {
    for backend in Backend::available() {
        for (width, height) in [(24, 8), (64, 8), (64, 64)] {
            if compared(counter, memory, backend, width, height).is_none() {
                info!("no room for {=u16}x{=u16}", width, height);
            }
        }
    }
    if read_out(counter, memory).is_none() {
        info!("no room for a row");
    }
}

/// Logs one line for each format of a camera: the cost of a row of 64 gray pixels.
fn read_out(counter: &mut Counter, memory: &mut Memory) -> Option<()> {
    const WIDTH: u16 = 64;
    let (line, row) = (memory.end.get(..256)?, memory.start.get_mut(..WIDTH.into())?);
    for format in Format::ALL {
        let window = Rect::new(0, 0, WIDTH, 1);
        let lines = 2 / format.gray_size((2, 2)).1;
        let taken = counter.count(|| {
            let mut readout = Readout::new(black_box(format), (2 * WIDTH, 2), window, row).ok()?;
            (0..lines).try_for_each(|y| readout.push_line(y, black_box(line))).ok()
        });
        info!("read-out {}: {=u32}, {=u32}", Debug2Format(&format), taken, taken * 1000 / u32::from(WIDTH));
    }
    Some(())
}

fn compared(counter: &mut Counter, memory: &mut Memory, backend: Backend, width: u16, height: u16) -> Option<()> {
    // The pictures differ only in the last pixel. So no loop can stop before the last row.
    let last = usize::from(height - 1) * 96 + usize::from(width) - 1;
    memory.end.fill(7);
    memory.other_end.fill(7);
    *memory.end.get_mut(1 + last)? = 255;
    let patch = Image::with_stride(memory.end.get(1..)?, width, height, 96).ok()?;
    let template = Image::with_stride(memory.other_end, width, height, 96).ok()?;
    let table = CutTable::new(&Table::PAPER, THRESHOLD);
    let scorer = Scorer::new(backend, &table);
    let pixels = u32::from(width) * u32::from(height);
    let line = |what: &str, taken| {
        info!(
            "{} {=str} {=u16}x{=u16}: {=u32}, {=u32}",
            Debug2Format(&backend),
            what,
            width,
            height,
            taken,
            taken * 1000 / pixels
        )
    };

    line("distance", counter.count(|| scorer.distance(black_box(patch), black_box(template), u32::MAX)));
    let floor = (pixels - 1) * u32::from(Table::ONE) + 1;
    line(
        "score below the floor",
        counter.count(|| scorer.score_at_least(black_box(patch), black_box(template), floor)),
    );
    line("score", counter.count(|| scorer.score(black_box(patch), black_box(template))));
    line(
        "score between",
        counter.count(|| scorer.score_between_at_least(black_box(patch), black_box(patch), black_box(template), 0)),
    );
    if height == 8 {
        let mut rows = patch.rows();
        let rows: [&[u8]; 4] = core::array::from_fn(|_| rows.next().unwrap_or_default());
        let (low, high) = memory.start.split_at_mut_checked(usize::from(width) - 3)?;
        line("spread (of eight rows)", 8 * counter.count(|| spread(&scorer, black_box(&rows), low, black_box(high))));
    }
    Some(())
}
