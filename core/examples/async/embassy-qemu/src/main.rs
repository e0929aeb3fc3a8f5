//! The robust tracker beside a task with a deadline, on one executor of Embassy. Runs in QEMU.
//!
//! `track` follows a drawn target and yields after each step; `blink` toggles a counter at an exact period. The program
//! measures the longest turn of `track` and the largest delay of `blink`, and compares the answers with those of whole
//! updates.

#![no_std]
#![no_main]

mod camera;
mod clock;
mod turns;

use camera::{FRAMES, HEIGHT, PIXELS, START, WIDTH};
use clock::{CYCLES_A_TICK, cycles};
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m_rt::exception;
use embassy_executor::Spawner;
use embassy_time::{Duration, Instant, Timer};
use semihosting::println;
use semihosting::process::exit;
use smr_core::readout::{Format, Readout};
use smr_core::robust::{Config, Workspace};
use smr_core::{Answer, Frame, Rect, Robust, State, Target};
use static_cell::ConstStaticCell;
use turns::{Turns, instructions_a_cycle};

/// The work of a step: about as many instructions of a Cortex-M4.
const WORK: u32 = 100_000;
/// The period of `blink`: shorter than an update, longer than a step.
const PERIOD: Duration = Duration::from_micros(500);
const CONFIG: Config = Config::robust();

// The memory of the tracker and of the pixels that it reads. It is built at compile time and `take` gives out a
// reference, so nothing is copied through the stack. The workspace is all zeros and separate from the target, so it
// takes no flash. `main` takes these and hands them to `track`, which keeps them.
static TARGET: ConstStaticCell<Robust> = ConstStaticCell::new(Robust::const_new(CONFIG));
static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static WINDOW: ConstStaticCell<[u8; PIXELS]> = ConstStaticCell::new([0; PIXELS]);
static SWEEP: ConstStaticCell<[u8; PIXELS]> = ConstStaticCell::new([0; PIXELS]);

static BLINKS: AtomicU32 = AtomicU32::new(0);
static LARGEST_DELAY_CYCLES: AtomicU32 = AtomicU32::new(0);

struct Tracking {
    target: &'static mut Robust,
    workspace: &'static mut Workspace,
    window: &'static mut [u8; PIXELS],
    sweep: &'static mut [u8; PIXELS],
}

type Answers = [Option<Answer>; FRAMES as usize];

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    clock::start();
    let tracking =
        Tracking { target: TARGET.take(), workspace: WORKSPACE.take(), window: WINDOW.take(), sweep: SWEEP.take() };
    // Both fail only if the task is already running.
    let (Ok(blink), Ok(track)) = (blink(), track(tracking)) else { exit(1) };
    // When both are ready, `blink` runs first. So it waits for at most one turn of `track`.
    blink.metadata().set_priority(1);
    spawner.spawn(track);
    spawner.spawn(blink);
}

/// Wakes at an exact period, like a task with a deadline, and notes how late it was.
#[embassy_executor::task]
async fn blink() {
    let mut at = Instant::now();
    loop {
        at += PERIOD;
        Timer::at(at).await;
        let delay = cycles() - at.as_ticks() * CYCLES_A_TICK;
        LARGEST_DELAY_CYCLES.fetch_max(u32::try_from(delay).unwrap_or(u32::MAX), Ordering::Relaxed);
        BLINKS.fetch_add(1, Ordering::Relaxed);
    }
}

#[embassy_executor::task]
async fn track(mut tracking: Tracking) {
    match compare(&mut tracking).await {
        Ok(()) => exit(0),
        Err(what) => {
            println!("error: {what}");
            exit(1)
        }
    }
}

async fn compare(tracking: &mut Tracking) -> Result<(), &'static str> {
    let tick = instructions_a_cycle();
    let mut turns = Turns::begin();
    let whole = tracking.follow(None, &mut turns).await?;
    println!("longest turn without steps: {}", turns.longest_cycles() * tick);
    println!("largest delay of blink without steps: {}", LARGEST_DELAY_CYCLES.load(Ordering::Relaxed) * tick);
    // blink catches up with the periods that it missed.
    Timer::after(PERIOD).await;
    LARGEST_DELAY_CYCLES.store(0, Ordering::Relaxed);
    BLINKS.store(0, Ordering::Relaxed);

    let mut turns = Turns::begin();
    let start = Instant::now();
    let steps = tracking.follow(Some(WORK), &mut turns).await?;
    let periods = start.elapsed().as_ticks() / PERIOD.as_ticks();
    let (blinks, delay) = (BLINKS.load(Ordering::Relaxed), LARGEST_DELAY_CYCLES.load(Ordering::Relaxed));

    let states = |state| steps.iter().flatten().filter(|answer| answer.state == state).count();
    println!("frames: {}", steps.len() - 1);
    println!("tracking: {}", states(State::Tracking));
    println!("uncertain: {}", states(State::Uncertain));
    println!("lost: {}", states(State::Lost));
    println!("answers that differ: {}", whole.iter().zip(&steps).filter(|(whole, steps)| whole != steps).count());
    println!("periods: {periods}");
    println!("blinks: {blinks}");
    println!("largest delay of blink: {}", delay * tick);
    println!("longest turn: {}", turns.longest_cycles() * tick);
    println!("stated bound: {}", WORK + Robust::most_work(&CONFIG, START.width, START.height).beyond_a_step);
    Ok(())
}

impl Tracking {
    /// Locks and follows the target through all frames: in steps of the given work, or with whole updates.
    async fn follow(&mut self, steps: Option<u32>, turns: &mut Turns) -> Result<Answers, &'static str> {
        let mut answers = [None; FRAMES as usize];
        let frame = Rect::new(0, 0, WIDTH, HEIGHT);
        let window = self.target.lock_window(frame, START);
        let readout = read_out(0, (window, self.window), None, turns).await?;
        lock(self.target, self.workspace, &complete(&readout)?, steps, turns).await?;
        for (number, answer) in (1..).zip(answers.iter_mut().skip(1)) {
            let window = self.target.window().ok_or("no target")?;
            let sweep = self.target.sweep_window().map(|window| (window, &mut *self.sweep));
            let readout = read_out(number, (window, self.window), sweep, turns).await?;
            *answer = Some(update(self.target, self.workspace, &complete(&readout)?, steps, turns).await?);
        }
        Ok(answers)
    }
}

type Window<'a> = (Rect, &'a mut [u8; PIXELS]);

/// Reads one frame out, line by line. The pixels belong to the read-out until it is dropped, after the update.
async fn read_out<'a>(
    number: u16,
    (window, pixels): Window<'a>,
    sweep: Option<Window<'a>>,
    turns: &mut Turns,
) -> Result<Readout<'a>, &'static str> {
    let refused = |_| "the read-out refuses a window or a line";
    let mut readout = Readout::new(Format::Gray8, (WIDTH, HEIGHT), window, pixels).map_err(refused)?;
    if let Some((window, pixels)) = sweep {
        readout = readout.and_window(window, pixels).map_err(refused)?;
    }
    for y in 0..HEIGHT {
        readout.push_line(y, &camera::line(number, y)).map_err(refused)?;
        turns.yield_now().await;
    }
    Ok(readout)
}

fn complete<'a>(readout: &'a Readout<'_>) -> Result<Frame<'a>, &'static str> {
    readout.frame().map_err(|_| "a line is missing")
}

async fn lock(
    target: &mut Robust,
    workspace: &mut Workspace,
    frame: &Frame<'_>,
    steps: Option<u32>,
    turns: &mut Turns,
) -> Result<(), &'static str> {
    let refused = |_| "cannot lock on the box";
    let Some(work) = steps else {
        target.lock(workspace, frame, START).map_err(refused)?;
        turns.yield_now().await;
        return Ok(());
    };
    let mut lock = target.begin_lock(workspace, frame, START).map_err(refused)?;
    turns.yield_now().await;
    while !lock.step(work) {
        turns.yield_now().await;
    }
    turns.yield_now().await;
    lock.finish();
    turns.yield_now().await;
    Ok(())
}

async fn update(
    target: &mut Robust,
    workspace: &mut Workspace,
    frame: &Frame<'_>,
    steps: Option<u32>,
    turns: &mut Turns,
) -> Result<Answer, &'static str> {
    let refused = |_| "cannot search the frame";
    let Some(work) = steps else {
        let answer = target.update(workspace, frame).map_err(refused)?;
        turns.yield_now().await;
        return Ok(answer);
    };
    // Yields between the start of the update and its first step, and before its end, too: each of them may take as long
    // as a step.
    let mut update = target.begin(workspace, frame).map_err(refused)?;
    turns.yield_now().await;
    while !update.step(work) {
        turns.yield_now().await;
    }
    turns.yield_now().await;
    let answer = update.finish();
    turns.yield_now().await;
    Ok(answer)
}

/// Handles all interrupts of the board, because cortex-m-rt does not know their names.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    assert!(clock::interrupt(number), "interrupt {number} was not expected");
}
