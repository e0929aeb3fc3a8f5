//! The firmware: locks, then for each frame reads the windows that the tracker needs, updates, and writes the answer.

use crate::host_file::HostFile;
use crate::measure::{Timer, spin, stack};
use semihosting::process::exit;
use smr_core::similarity::Backend;
use smr_core::{Answer, Frame, Image, Paper, Rect, Robust, Target, calls, paper, robust};

const VERSION: u32 = 4;
const HEADER: usize = 11 * 4;
const CALIBRATION: u32 = 2_000_000;
/// The numbers of a record.
const RECORD: usize = 20;
/// The value of a number that is missing.
const NONE: u32 = u32::MAX;

/// The radius of the window of `smr`. The window does not grow: the buffer could not hold its pixels.
const RADIUS: u16 = 16;
/// The largest box of `smr`: 64x64, or another shape with as many pixels if its window fits the buffer.
const TEMPLATE_PIXELS: usize = 64 * 64;
const SMR_BUFFER: usize = (64 + 2 * RADIUS as usize) * (64 + 2 * RADIUS as usize);
/// Two windows of `robust`, for a target that has up to 48x48 pixels at the lock.
const ROBUST_BUFFER: usize = 48 * 1024;

/// The backend: the plain loops with the feature `plain`, else the fastest one.
const BACKEND: Option<Backend> = if cfg!(feature = "plain") { Some(Backend::Scalar) } else { None };

type Smr = Paper<TEMPLATE_PIXELS, { 2 * RADIUS as usize + 1 }>;

/// A tracker that can be replayed. All its memory is on the stack, so the measured stack includes it.
trait Replayed: Target {
    const METHOD: u32;
    /// The most pixels of a box, and the radius of the window; 0 if there is no such bound.
    const BOUNDS: (u32, u16);
    /// The buffer for pixels. It is also large enough for a saved target.
    type Buffer: AsMut<[u8]>;

    fn numbers() -> Self::Config;

    fn buffer() -> Self::Buffer;
}

impl Replayed for Smr {
    const METHOD: u32 = 0;
    #[allow(clippy::cast_possible_truncation)] // it is small
    const BOUNDS: (u32, u16) = (TEMPLATE_PIXELS as u32, RADIUS);
    type Buffer = [u8; SMR_BUFFER];

    fn numbers() -> paper::Config {
        let mut config = paper::Config::camera_within(RADIUS);
        config.backend = BACKEND;
        config
    }

    #[inline(always)]
    fn buffer() -> Self::Buffer {
        [0; SMR_BUFFER]
    }
}

impl Replayed for Robust {
    const METHOD: u32 = if cfg!(feature = "refiner") { 2 } else { 1 };
    const BOUNDS: (u32, u16) = (0, 0);
    type Buffer = [u8; ROBUST_BUFFER];

    fn numbers() -> robust::Config {
        #[cfg(feature = "refiner")]
        let mut config = robust::Config::refined();
        #[cfg(not(feature = "refiner"))]
        let mut config = robust::Config::robust();
        config.backend = BACKEND;
        config
    }

    #[inline(always)]
    fn buffer() -> Self::Buffer {
        [0; ROBUST_BUFFER]
    }
}

/// Why the firmware stops. The numbers are part of the protocol.
#[derive(Clone, Copy)]
enum Refusal {
    /// `frames.smr` ends early, or has another version.
    BadInput = 1,
    /// The box has more pixels than the template.
    BoxTooLarge = 2,
    /// The tracker needs more pixels than the buffer holds.
    WindowTooLarge = 3,
    /// The tracker does not lock for another reason.
    NoLock = 4,
    /// The update fails.
    NoUpdate = 5,
    /// `answers.smr` cannot be written.
    NoOutput = 6,
}

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    let timer = start();
    // Without a recording there is nothing to answer, and no file is left behind.
    let answers = HostFile::open(c"frames.smr").and_then(|_| HostFile::create(c"answers.smr"));
    let (Some(timer), Some(mut answers)) = (timer, answers) else { exit(1) };
    let mut frame = 0;
    let end = choose(timer, &mut answers, &mut frame);
    let record = match end {
        Ok(lock) => {
            let (used, room) = stack();
            [3, frame, used, room, lock]
        }
        Err(refusal) => [4, frame, refusal as u32, 0, 0],
    };
    let written = write(&mut answers, &record);
    exit(i32::from(end.is_err() || written.is_err()))
}

/// Prepares the processor. cortex-m-rt has painted the stack before.
#[cfg(target_arch = "arm")]
fn start() -> Option<Timer> {
    let peripherals = cortex_m::Peripherals::take()?;
    crate::alignment::require(&peripherals.SCB);
    Some(Timer::new(peripherals.SYST))
}

/// Prepares the processor.
#[cfg(target_arch = "riscv32")]
fn start() -> Option<Timer> {
    crate::measure::paint_stack();
    Some(Timer::new())
}

/// Replays the recording with the tracker that it names. The result is the ticks of the lock.
fn choose(timer: Timer, answers: &mut HostFile, at: &mut u32) -> Result<u32, Refusal> {
    let recording = Recording::open()?;
    match recording.method {
        Smr::METHOD => replay::<Smr>(recording, timer, answers, at),
        Robust::METHOD => replay::<Robust>(recording, timer, answers, at),
        _ => Err(Refusal::BadInput),
    }
}

/// Sets `at` to the number of the current frame, from 1. The result is the ticks of the lock.
#[inline(never)] // so that the measured stack contains only the tracker that runs
fn replay<T: Replayed>(
    mut recording: Recording,
    mut timer: Timer,
    answers: &mut HostFile,
    at: &mut u32,
) -> Result<u32, Refusal> {
    let mut buffer = T::buffer();
    let buffer = buffer.as_mut();
    // References: moving the objects would put second copies on the stack.
    let (mut made, mut workspace) = (T::with(T::numbers()), T::Workspace::default());
    let Ok(target) = &mut made else { return Err(Refusal::NoLock) };
    let ticks = timer.measure(|| spin(CALIBRATION)).1;
    #[allow(clippy::cast_possible_truncation)] // usize is u32 here
    let [room, target_size, workspace_size] =
        [buffer.len() as u32, size_of::<T>() as u32, size_of::<T::Workspace>() as u32];
    let (pixels, radius) = T::BOUNDS;
    write(
        answers,
        &[1, VERSION, T::METHOD, pixels, radius.into(), room, target_size, workspace_size, CALIBRATION, ticks],
    )?;

    *at = 1;
    if pixels > 0 && recording.target.area() > pixels {
        return Err(Refusal::BoxTooLarge);
    }
    let bounds = Rect::new(0, 0, recording.width, recording.height);
    let first = recording.read(0, target.lock_window(bounds, recording.target), None, buffer)?;
    let (locked, lock) = timer.measure(|| target.lock(&mut workspace, &first, recording.target));
    locked.map_err(|_| Refusal::NoLock)?;
    for index in 1..recording.frames {
        *at = index + 1;
        let window = target.window().ok_or(Refusal::NoUpdate)?;
        let frame = recording.read(index, window, target.sweep_window(), buffer)?;
        let (answer, ticks, longest) = update((target, &mut workspace), &frame, recording.step, &mut timer)?;
        let work = T::work(&workspace);
        // The update is done, so the buffer is free.
        let saved = target.save(buffer).ok().and_then(|size| buffer.get(..size)).ok_or(Refusal::NoUpdate)?;
        write(answers, &record(*at, &answer, fnv(saved), [work, ticks, longest]))?;
    }
    Ok(lock)
}

/// The answer, the ticks of the update, and those of its longest step.
fn update<T: Target>(
    (target, workspace): (&mut T, &mut T::Workspace),
    frame: &Frame<'_>,
    step: u32,
    timer: &mut Timer,
) -> Result<(Answer, u32, u32), Refusal> {
    if step == 0 {
        let (answer, ticks) = timer.measure(|| target.update(workspace, frame));
        return Ok((answer.map_err(|_| Refusal::NoUpdate)?, ticks, ticks));
    }
    let (mut sum, mut longest) = (0_u32, 0);
    loop {
        let (done, ticks) = timer.measure(|| calls::step(target, workspace, frame, step));
        (sum, longest) = (sum.saturating_add(ticks), longest.max(ticks));
        if done.map_err(|_| Refusal::NoUpdate)? {
            break;
        }
    }
    let (answer, ticks) = timer.measure(|| calls::commit(target, workspace, frame));
    Ok((answer, sum.saturating_add(ticks), longest.max(ticks)))
}

/// `frames.smr`. Only the rows of a window are read from it.
struct Recording {
    file: HostFile,
    method: u32,
    /// The work of a step; 0 means all at once.
    step: u32,
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
        let (method, step) = (word(), word());
        let (width, height, frames) = (size(word())?, size(word())?, word());
        let (x, y) = (size(word())?.into(), size(word())?.into());
        let target = Rect::new(x, y, size(word())?, size(word())?);
        Ok(Self { file, method, step, width, height, frames, target })
    }

    /// Frame `index` (from 0) with only the parts in `rect` and `other` in memory. Both lie inside the frame.
    fn read<'b>(
        &mut self,
        index: u32,
        rect: Rect,
        other: Option<Rect>,
        buffer: &'b mut [u8],
    ) -> Result<Frame<'b>, Refusal> {
        // A box smaller than the padding can be completely outside the frame. Its window is empty, but a part must have
        // a pixel.
        let rect = if rect.is_empty() { Rect::new(0, 0, 1, 1) } else { rect };
        let (first, rest) = buffer.split_at_mut_checked(pixels(rect)).ok_or(Refusal::WindowTooLarge)?;
        let (image, x, y) = self.part(index, rect, first)?;
        let frame = Frame::part(image, x, y, self.width, self.height).map_err(|_| Refusal::BadInput)?;
        let Some(other) = other else { return Ok(frame) };
        let second = rest.get_mut(..pixels(other)).ok_or(Refusal::WindowTooLarge)?;
        let (image, x, y) = self.part(index, other, second)?;
        frame.and_part(image, x, y).map_err(|_| Refusal::BadInput)
    }

    /// Reads the pixels of the frame in `rect` into `pixels`.
    fn part<'b>(&mut self, index: u32, rect: Rect, pixels: &'b mut [u8]) -> Result<(Image<'b>, u16, u16), Refusal> {
        let (x, y) = (size(rect.x.cast_unsigned())?, size(rect.y.cast_unsigned())?);
        let first_row = u64::from(index) * u64::from(self.height) + u64::from(y);
        for (row, pixels) in (first_row..).zip(pixels.chunks_exact_mut(usize::from(rect.width).max(1))) {
            let start = HEADER as u64 + row * u64::from(self.width) + u64::from(x);
            self.file.read(start, pixels).ok_or(Refusal::BadInput)?;
        }
        Ok((Image::new(pixels, rect.width, rect.height).map_err(|_| Refusal::BadInput)?, x, y))
    }
}

fn pixels(rect: Rect) -> usize {
    usize::from(rect.width) * usize::from(rect.height)
}

fn size(word: u32) -> Result<u16, Refusal> {
    u16::try_from(word).map_err(|_| Refusal::BadInput)
}

fn record(frame: u32, answer: &Answer, hash: u32, [work, ticks, longest]: [u32; 3]) -> [u32; RECORD] {
    let Answer { fine, confidence, ratio, runner_up_ratio, alpha, scale, found_again, .. } = *answer;
    let [left, top] = [fine.x, fine.y].map(i32::cast_unsigned);
    let [runner_up_ratio, alpha] = [runner_up_ratio, alpha].map(|number| number.map_or(NONE, u32::from));
    let box_and_state = [2, frame, left, top, fine.width, fine.height, answer.state.code().into()];
    let figures = [confidence.into(), ratio.into(), runner_up_ratio, alpha, scale, found_again.into(), hash];
    let mut record = [0; RECORD];
    let numbers = box_and_state.into_iter().chain(figures).chain([work, ticks, longest]);
    record.iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
    record
}

/// FNV-1a.
fn fnv(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0x811C_9DC5, |hash, &byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

fn write(answers: &mut HostFile, numbers: &[u32]) -> Result<(), Refusal> {
    let mut bytes = [0; 4 * RECORD];
    for (bytes, number) in bytes.chunks_exact_mut(4).zip(numbers) {
        for (byte, value) in bytes.iter_mut().zip(number.to_le_bytes()) {
            *byte = value;
        }
    }
    answers.write(&bytes).ok_or(Refusal::NoOutput)
}

/// The compiler needs it; no call reaches it, so it is not linked. `.ci/targets` checks that.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(101)
}
