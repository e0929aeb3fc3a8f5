//! Reads a flight record entry by entry, replays it with its tracker, and writes the work and time of each update.

use crate::host_file::HostFile;
use crate::measure::{Timer, depth, spin, stack};
use semihosting::process::exit;
use smr_core::record::{AROUND, Difference, Entry, Found, HEAD, Player, Recorded, first};
use smr_core::robust::{Size, Small};
use smr_core::similarity::Backend;
use smr_core::{Answer, Paper, Robust, Tracker, UpdateError, paper, robust};

const VERSION: u32 = 5;
const CALIBRATION: u32 = 2_000_000;
/// The count of numbers in a line of `said.smr`.
const LINE: usize = 16;
/// The value that stands for a missing number.
const NONE: u32 = u32::MAX;
/// The size in bytes of an entry that contains an answer.
const ANSWER: usize = AROUND + 32;

/// The paper tracker for the test vectors: boxes of up to 128 pixels, and windows of up to +-60 pixels.
#[cfg(feature = "small")]
type PaperTracker = Paper<128, 121>;
/// The paper tracker for boxes of up to 64x64 pixels, and windows of up to +-16 pixels, growth included.
#[cfg(not(feature = "small"))]
type PaperTracker = Paper<{ 64 * 64 }, 33>;
type RobustTracker = Robust;
type SmallRobust = Robust<Small>;

/// A tracker that can be replayed. All its memory is on the stack, so the measured stack includes it.
trait Replayed: Recorded {
    type Buffer: AsMut<[u8]>;
    const BUFFER: Self::Buffer;

    /// Returns a preset with the backend, which no record has: plain loops with feature `plain`, else the best one.
    fn unrecorded_settings() -> Self::Config;
}

const BACKEND: Option<Backend> = if cfg!(feature = "plain") { Some(Backend::Scalar) } else { None };

impl Replayed for PaperTracker {
    type Buffer = [u8; 96 * 96 + AROUND + 20];
    const BUFFER: Self::Buffer = [0; 96 * 96 + AROUND + 20];

    fn unrecorded_settings() -> paper::Config {
        let mut config = paper::Config::paper();
        config.backend = BACKEND;
        config
    }
}

impl<S: Size> Replayed for Robust<S> {
    /// Holds a frame's entry, with search window and sweep window, for targets of up to 48x48 pixels.
    type Buffer = [u8; 48 * 1024];
    const BUFFER: Self::Buffer = [0; 48 * 1024];

    fn unrecorded_settings() -> robust::Config {
        let mut config = robust::Config::robust().within::<S>();
        config.backend = BACKEND;
        config
    }
}

/// The reason why a replay stops; its code is written to `said.smr`.
enum End {
    /// An entry is missing or damaged.
    Damaged,
    /// An entry exceeds the buffer.
    TooLarge,
    /// The record's tracker is unknown, or the tracker refuses the recorded configuration.
    Configuration,
    /// The lock's window differs from the recorded one, or the lock fails.
    Lock,
    /// The update's window differs from the recorded one, or the update fails.
    Update,
    /// The replayed answer, which differs from the recorded one.
    Answer(Answer),
    /// The saved target differs from the recorded one.
    Saved,
    /// `said.smr` cannot be written.
    NotWritten,
}

impl From<Difference> for End {
    fn from(difference: Difference) -> Self {
        match difference {
            Difference::Answer(_, replayed) => Self::Answer(replayed),
            Difference::OtherTracker(_) | Difference::Numbers | Difference::Config(_) => Self::Configuration,
            Difference::LockWindow(..) | Difference::Lock(_) => Self::Lock,
            Difference::Restored(_) => Self::Saved,
            _ => Self::Update,
        }
    }
}

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    let timer = start();
    // Without a record, no file is written.
    let record = HostFile::open(c"record.smr");
    let said = record.as_ref().and_then(|_| HostFile::create(c"said.smr"));
    let (Some(timer), Some(record), Some(said)) = (timer, record, said) else { exit(1) };
    let mut run = Run { record, said, timer, at: 0, step: 0, lock: 0, stack_before_update: 0 };
    let end = run.choose();
    let written = run.end(end.as_ref().err());
    exit(i32::from(end.is_err() || written.is_err()))
}

/// Prepares the processor. cortex-m-rt has already painted the stack.
#[cfg(target_arch = "arm")]
fn start() -> Option<Timer> {
    let peripherals = cortex_m::Peripherals::take()?;
    crate::alignment::require(&peripherals.SCB);
    Some(Timer::new(peripherals.SYST))
}

#[cfg(target_arch = "riscv32")]
fn start() -> Option<Timer> {
    crate::measure::paint_stack();
    Some(Timer::new())
}

struct Run {
    record: HostFile,
    said: HostFile,
    timer: Timer,
    /// Offset of the next entry in the record, in bytes.
    at: u64,
    /// Units of work per step; 0 for whole updates.
    step: u32,
    /// Ticks of the last lock.
    lock: u32,
    /// Bytes of stack in use when the last update began.
    stack_before_update: u32,
}

impl Run {
    /// Replays the record with the tracker of its first entry.
    fn choose(&mut self) -> Result<(), End> {
        let mut letter = [0];
        self.record.read(HEAD as u64 + 2, &mut letter).ok_or(End::Damaged)?;
        match letter {
            [PaperTracker::TRACKER] => self.replay::<PaperTracker>(),
            [RobustTracker::TRACKER] => self.replay::<RobustTracker>(),
            [SmallRobust::TRACKER] => self.replay::<SmallRobust>(),
            _ => Err(End::Configuration),
        }
    }

    #[inline(never)] // so that the measured stack contains only the tracker that runs
    fn replay<T: Replayed>(&mut self) -> Result<(), End> {
        let mut buffer = T::BUFFER;
        let buffer = buffer.as_mut();
        let mut tracker = Tracker::<T>::default();
        let ticks = self.timer.measure(|| spin(CALIBRATION)).1;
        #[allow(clippy::cast_possible_truncation)] // usize is u32 here
        let [room, target, workspace] = [buffer.len() as u32, size_of::<T>() as u32, size_of::<T::Workspace>() as u32];
        self.write_line(&[1, VERSION, room, target, workspace, CALIBRATION, ticks])?;
        let mut step = [0; 4];
        let told = HostFile::open(c"step.smr").and_then(|mut file| file.read(0, &mut step));
        for step in [0, u32::from_le_bytes(step)].into_iter().take(1 + usize::from(told.is_some())) {
            (self.at, self.step) = (0, step);
            while self.entry(&mut tracker, buffer)? {}
        }
        Ok(())
    }

    /// Replays the next entry and, if it begins an update, also the entry with the update's answer. Returns false at
    /// the end of the record.
    fn entry<T: Replayed>(&mut self, tracker: &mut Tracker<T>, buffer: &mut [u8]) -> Result<bool, End> {
        let Some(entry) = self.read(buffer)? else { return Ok(false) };
        let found = first(entry).map_err(|_| End::Damaged)?;
        if let (Entry::Restored(saved), true) = (found.entry, tracker.window().is_some()) {
            let (size, sum) = (found.size, fnv(saved));
            let own = tracker.save(buffer).ok().and_then(|size| buffer.get(..size)).map(fnv);
            self.at += size as u64;
            return if own == Some(sum) { Ok(true) } else { Err(End::Saved) };
        }
        let mut player = Player::new(T::unrecorded_settings());
        self.at += found.size as u64;
        self.play(tracker, &mut player, &found.entry)?;
        if player.window().is_some() {
            // A cancelled update has no answer.
            let mut answer = [0; ANSWER];
            let Ok(Some(answer)) = self.read(&mut answer) else { return Ok(true) };
            let Ok(found @ Found { entry: Entry::Answer(_), .. }) = first(answer) else { return Ok(true) };
            self.play(tracker, &mut player, &found.entry)?;
            self.at += found.size as u64;
        }
        Ok(true)
    }

    /// Replays an entry, and measures locks and updates.
    #[inline(never)] // as for `write_line`
    fn play<'a, T: Replayed>(
        &mut self,
        tracker: &mut Tracker<T>,
        player: &mut Player<'a, T>,
        entry: &Entry<'a>,
    ) -> Result<(), End> {
        let Self { timer, step, .. } = self;
        if let Entry::Lock { frame, bbox, window } = entry {
            let same = tracker.lock_window(frame.bounds(), *bbox) == *window;
            let (locked, ticks) = timer.measure(|| tracker.lock(frame, *bbox));
            self.lock = ticks;
            return if same && locked.is_ok() { Ok(()) } else { Err(End::Lock) };
        }
        let mut took = None;
        player.play(tracker, entry, |tracker, frame| {
            self.stack_before_update = depth();
            let (mut answer, mut longest) = (Ok(None), 0);
            while let Ok(None) = answer {
                let (result, ticks) = timer.measure(|| match *step {
                    0 => tracker.update(frame).map(Some),
                    work => tracker.update_step(frame, work),
                });
                (answer, longest) = (result, longest.max(ticks));
            }
            took = Some(longest);
            answer.and_then(|answer| answer.ok_or(UpdateError::NotLocked))
        })?;
        match took {
            None => Ok(()),
            Some(ticks) if self.step == 0 => self.write_line(&[2, tracker.work(), ticks]),
            Some(ticks) => self.write_line(&[3, ticks]),
        }
    }

    /// Reads the next entry; `None` at the end of the record.
    #[inline(never)] // as above
    fn read<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, End> {
        let mut head = [0; HEAD];
        if self.record.read(self.at, &mut head).is_none() {
            return Ok(None);
        }
        let [.., a, b, c, d] = head;
        let length = usize::try_from(u32::from_le_bytes([a, b, c, d])).unwrap_or(usize::MAX);
        let entry = buffer.get_mut(..AROUND.saturating_add(length)).ok_or(End::TooLarge)?;
        Ok(self.record.read(self.at, entry).map(|()| &*entry))
    }

    /// Writes the result: bytes of stack (used, available, used by an update) and ticks of the last lock; or, if the
    /// replay stopped early, the offset of the entry and the reason `why`.
    fn end(&mut self, why: Option<&End>) -> Result<(), End> {
        let Some(why) = why else {
            let (used, room) = stack();
            return self.write_line(&[4, used, room, used.saturating_sub(self.stack_before_update), self.lock]);
        };
        #[allow(clippy::cast_possible_truncation)] // records of QEMU are small
        let at = self.at as u32;
        let code = match why {
            End::Damaged => 1,
            End::TooLarge => 2,
            End::Configuration => 3,
            End::Lock => 4,
            End::Update => 5,
            End::Answer(answer) => return self.write_line(&line_of_difference(at, answer)),
            End::Saved => 7,
            End::NotWritten => 8,
        };
        self.write_line(&[5, at, code])
    }

    #[inline(never)] // its memory is taken while it runs only
    fn write_line(&mut self, numbers: &[u32]) -> Result<(), End> {
        let mut bytes = [0; 4 * LINE];
        for (bytes, number) in bytes.chunks_exact_mut(4).zip(numbers) {
            bytes.iter_mut().zip(number.to_le_bytes()).for_each(|(byte, value)| *byte = value);
        }
        self.said.write(&bytes).ok_or(End::NotWritten)
    }
}

fn line_of_difference(at: u32, answer: &Answer) -> [u32; LINE] {
    let Answer { fine, confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again, .. } = *answer;
    let [left, top] = [fine.x, fine.y].map(i32::cast_unsigned);
    let optional = [runner_up_ratio, alpha, identity];
    let [runner_up, alpha, identity] = optional.map(|number| number.map_or(NONE, u32::from));
    let (state, found_again) = (answer.state.code().into(), found_again.into());
    let (confidence, ratio) = (confidence.into(), ratio.into());
    let (width, height) = (fine.width, fine.height);
    [5, at, 6, left, top, width, height, state, confidence, ratio, runner_up, alpha, scale, found_again, identity, 0]
}

fn fnv(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0x811C_9DC5, |hash, &byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// The panic handler that a `no_std` program must have. `.ci/firmware` checks that no call reaches it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(101)
}
