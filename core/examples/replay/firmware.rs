//! The firmware: locks, then reads a window, updates and answers, frame after frame.

use crate::host_file::HostFile;
use crate::measure::{Timer, spin, stack};
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m_rt::entry;
use semihosting::process::exit;
use smr_core::{Answer, Config, Frame, Image, Radius, Rect, State, Tracker};

const VERSION: u32 = 2;
/// The window, to each side. It does not grow: there would be no room for what it would read.
const RADIUS: u16 = 16;
const SPAN: usize = 2 * RADIUS as usize + 1;
/// The largest box: 64x64, or another shape of as many pixels whose window fits the buffer.
const TEMPLATE_PIXELS: usize = 64 * 64;
const BUFFER_PIXELS: usize = (64 + 2 * RADIUS as usize) * (64 + 2 * RADIUS as usize);
const HEADER: usize = 9 * 4;
const CALIBRATION: u32 = 2_000_000;

type Replayed = Tracker<TEMPLATE_PIXELS, SPAN>;

/// Why the firmware does not go on. The numbers are the protocol's.
#[derive(Clone, Copy)]
enum Refusal {
    /// `frames.smr` is not there, ends early, or is not of this version.
    BadInput = 1,
    /// The box has more pixels than the template.
    BoxTooLarge = 2,
    /// The pixels of the search window are more than the buffer.
    WindowTooLarge = 3,
    /// The tracker does not lock, for another reason.
    NoLock = 4,
    /// The tracker does not search the frame.
    NoUpdate = 5,
    /// `answers.smr` cannot be written.
    NoOutput = 6,
}

#[entry]
fn main() -> ! {
    static mut BUFFER: [u8; BUFFER_PIXELS] = [0; BUFFER_PIXELS];
    let (Some(peripherals), Some(mut answers)) = (Peripherals::take(), HostFile::create(c"answers.smr")) else {
        exit(1)
    };
    let mut frame = 0;
    let end = replay(BUFFER, peripherals.SYST, &mut answers, &mut frame);
    let record = match end {
        Ok(()) => {
            let (used, room) = stack();
            [3, frame, used, room]
        }
        Err(refusal) => [4, frame, refusal as u32, 0],
    };
    let written = write(&mut answers, &record);
    exit(i32::from(end.is_err() || written.is_err()))
}

/// `at` is the frame that it is busy with, from 1.
fn replay(buffer: &mut [u8], timer: SYST, answers: &mut HostFile, at: &mut u32) -> Result<(), Refusal> {
    let mut timer = Timer::new(timer);
    let ticks = timer.measure(|| spin(CALIBRATION)).1;
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let [pixels, span, room, size] =
        [TEMPLATE_PIXELS as u32, SPAN as u32, BUFFER_PIXELS as u32, size_of::<Replayed>() as u32];
    write(answers, &[1, VERSION, pixels, span, RADIUS.into(), room, size, CALIBRATION, ticks])?;

    let mut recording = Recording::open()?;
    let mut config = Config::camera();
    config.window = Radius { x: RADIUS, y: RADIUS };
    config.window_limit = config.window;
    let mut tracker = Replayed::new(config).map_err(|_| Refusal::NoLock)?;

    *at = 1;
    if recording.target.area() > pixels {
        return Err(Refusal::BoxTooLarge);
    }
    let first = recording.read(0, recording.target, buffer)?;
    tracker.lock(&first, recording.target).map_err(|_| Refusal::NoLock)?;
    for index in 1..recording.frames {
        *at = index + 1;
        let window = tracker.window().ok_or(Refusal::NoUpdate)?;
        let frame = recording.read(index, window, buffer)?;
        let (answer, ticks) = timer.measure(|| tracker.update(&frame));
        let answer = answer.map_err(|_| Refusal::NoUpdate)?;
        write(answers, &record(*at, &answer, hash(&tracker), ticks))?;
    }
    Ok(())
}

/// `frames.smr`, of which single rows of a window are read.
struct Recording {
    file: HostFile,
    width: u16,
    height: u16,
    frames: u32,
    target: Rect,
}

impl Recording {
    fn open() -> Result<Self, Refusal> {
        let mut file = HostFile::open(c"frames.smr").ok_or(Refusal::BadInput)?;
        let mut header = [0; HEADER];
        file.read(0, &mut header).ok_or(Refusal::BadInput)?;
        let mut words = header.chunks_exact(4).filter_map(|word| Some(u32::from_le_bytes(word.try_into().ok()?)));
        let mut word = || words.next().unwrap_or(0);
        if (word(), word()) != (u32::from_le_bytes(*b"SMRF"), VERSION) {
            return Err(Refusal::BadInput);
        }
        let (width, height, frames) = (size(word())?, size(word())?, word());
        let (x, y) = (size(word())?.into(), size(word())?.into());
        let target = Rect::new(x, y, size(word())?, size(word())?);
        Ok(Self { file, width, height, frames, target })
    }

    /// The part of frame `index` (from 0) in `rect`, which lies inside it.
    fn read<'b>(&mut self, index: u32, rect: Rect, buffer: &'b mut [u8]) -> Result<Frame<'b>, Refusal> {
        // A box smaller than the padding can be wholly outside. Nothing is read then, but a frame has a pixel.
        let rect = if rect.is_empty() { Rect::new(0, 0, 1, 1) } else { rect };
        let (x, y) = (size(rect.x.cast_unsigned())?, size(rect.y.cast_unsigned())?);
        let width = usize::from(rect.width);
        let part = buffer.get_mut(..width * usize::from(rect.height)).ok_or(Refusal::WindowTooLarge)?;
        let first_row = u64::from(index) * u64::from(self.height) + u64::from(y);
        for (row, pixels) in (first_row..).zip(part.chunks_exact_mut(width.max(1))) {
            let start = HEADER as u64 + row * u64::from(self.width) + u64::from(x);
            self.file.read(start, pixels).ok_or(Refusal::BadInput)?;
        }
        let image = Image::new(part, rect.width, rect.height).map_err(|_| Refusal::BadInput)?;
        Frame::part(image, x, y, self.width, self.height).map_err(|_| Refusal::BadInput)
    }
}

fn size(word: u32) -> Result<u16, Refusal> {
    u16::try_from(word).map_err(|_| Refusal::BadInput)
}

fn record(frame: u32, answer: &Answer, hash: u32, ticks: u32) -> [u32; 15] {
    let Answer { bbox, ratio, alpha, found, .. } = *answer;
    let state = match answer.state {
        State::Tracking => 0,
        State::Leaving => 1,
        State::Lost => 2,
    };
    let [left, top, peak_x, peak_y] = [bbox.x, bbox.y, found.peak.x, found.peak.y].map(i32::cast_unsigned);
    let [ratio, runner_up_ratio, alpha] = [ratio, answer.runner_up_ratio.unwrap_or(0), alpha].map(u32::from);
    let (score, runner_up, asked) = (found.peak.score, found.runner_up.unwrap_or(0), found.runner_up.is_some().into());
    [2, frame, left, top, state, ratio, runner_up_ratio, alpha, peak_x, peak_y, score, runner_up, asked, hash, ticks]
}

/// FNV-1a over the template's bytes.
fn hash(tracker: &Replayed) -> u32 {
    let template = tracker.template();
    let pixels = template.iter().flat_map(|template| template.rows().flatten());
    pixels.fold(0x811C_9DC5, |hash, &pixel| (hash ^ u32::from(pixel)).wrapping_mul(0x0100_0193))
}

fn write(answers: &mut HostFile, numbers: &[u32]) -> Result<(), Refusal> {
    let mut bytes = [0; 64];
    for (bytes, number) in bytes.chunks_exact_mut(4).zip(numbers) {
        for (byte, value) in bytes.iter_mut().zip(number.to_le_bytes()) {
            *byte = value;
        }
    }
    answers.write(&bytes).ok_or(Refusal::NoOutput)
}

/// Must be there to compile, and is never linked: `.ci/targets` checks it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(101)
}
