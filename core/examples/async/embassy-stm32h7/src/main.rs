//! The robust tracker on a STM32H743 with a camera of 320x240 pixels at the DCMI, with Embassy. Built, but not yet run
//! on a board.
//!
//! Two buffers go round between two tasks, through a channel that hands out references and copies nothing:
//!
//! 1. `camera` gets an empty buffer. Until the frame is complete it belongs to the DMA, which fills it.
//! 2. `track` gets the full buffer and converts the window that the tracker reads to gray. Then it gives the buffer
//!    back, before the update. So the DMA fills one buffer while `track` reads the other one or updates.
//!
//! The gray pixels, the target and the workspace always belong to `track`.
//!
//! Set your sensor's registers before the first capture (I2C, see its data sheet): 320x240, YUYV, and its clock from
//! PA8. The data cache is off, as after a reset. If you turn it on, clean and invalidate a buffer's lines before the
//! DMA fills it and before `track` reads it.

#![no_std]
#![no_main]

mod clocks;

use embassy_executor::Spawner;
use embassy_futures::yield_now;
use embassy_stm32::dcmi::{self, Dcmi};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{DCMI, DMA1_CH0};
use embassy_stm32::rcc::{Mco, Mco1Source, McoConfig, McoPrescaler};
use embassy_stm32::{bind_interrupts, dma};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::zerocopy_channel::{Channel, Receiver, Sender};
use embassy_time::{Duration, with_timeout};
use panic_halt as _;
use smr_core::readout::{Format, Readout};
use smr_core::robust::{Config, Workspace};
use smr_core::{Answer, Rect, Robust, State, Target};
use static_cell::{ConstStaticCell, StaticCell};

const WIDTH: u16 = 320;
const HEIGHT: u16 = 240;
const FORMAT: Format = Format::Yuyv;
const LINE_BYTES: usize = FORMAT.line_bytes(WIDTH);
const PIXELS: usize = WIDTH as usize * HEIGHT as usize;
/// Words of a frame: the DMA writes words.
const WORDS: usize = LINE_BYTES * HEIGHT as usize / 4;

/// The place of the target when the button is pressed: 64x64 pixels in the middle.
const START: Rect = Rect::new(128, 88, 64, 64);
/// The work from yield to yield: about as many instructions. The DMA needs no help within a frame, so this may be
/// large.
const WORK: u32 = 200_000;
/// The longest wait for a frame: longer than any frame takes.
const PATIENCE: Duration = Duration::from_millis(300);

type Buffer = [u32; WORDS];

// 500 of the 512 KB. No constructor runs, and nothing is copied through the stack.
static BUFFERS: ConstStaticCell<[Buffer; 2]> = ConstStaticCell::new([[0; WORDS]; 2]);
static CHANNEL: StaticCell<Channel<'static, NoopRawMutex, Buffer>> = StaticCell::new();
static TARGET: ConstStaticCell<Robust> = ConstStaticCell::new(Robust::const_new(Config::robust()));
static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static WINDOW: ConstStaticCell<[u8; PIXELS]> = ConstStaticCell::new([0; PIXELS]);
static SWEEP: ConstStaticCell<[u8; PIXELS]> = ConstStaticCell::new([0; PIXELS]);

bind_interrupts!(struct Interrupts {
    DCMI => dcmi::InterruptHandler<DCMI>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let chip = embassy_stm32::init(clocks::clocks());
    // A clock of 16 MHz for the sensor.
    let mut output = McoConfig::default();
    output.prescaler = McoPrescaler::DIV4;
    let _sensor_clock = Mco::new(chip.MCO1, chip.PA8, Mco1Source::HSI, output);
    let sensor = Dcmi::new_8bit(
        chip.DCMI,
        chip.DMA1_CH0,
        Interrupts,
        chip.PC6,
        chip.PC7,
        chip.PE0,
        chip.PE1,
        chip.PE4,
        chip.PB6,
        chip.PE5,
        chip.PE6,
        chip.PB7,
        chip.PA4,
        chip.PA6,
        dcmi::Config::default(),
    );
    let button = Input::new(chip.PC13, Pull::None);
    let led = Output::new(chip.PB0, Level::Low, Speed::Low);

    let (empty, full) = CHANNEL.init(Channel::new(BUFFERS.take())).split();
    // Both fail only if the task is already running.
    if let (Ok(camera), Ok(track)) = (camera(sensor, empty), track(full, button, led)) {
        spawner.spawn(camera);
        spawner.spawn(track);
    }
}

/// Fills empty buffers with frames.
#[embassy_executor::task]
async fn camera(mut sensor: Dcmi<'static, DCMI>, mut empty: Sender<'static, NoopRawMutex, Buffer>) {
    loop {
        // Waits while `track` reads one buffer and the other is full. Frames that come in this time are left out.
        let buffer = empty.send().await;
        // The DMA borrows the buffer until the frame is complete. If the frame was disturbed, the timeout takes the
        // buffer back.
        if let Ok(Ok(())) = with_timeout(PATIENCE, sensor.capture(buffer)).await {
            empty.send_done(); // `track` may read it
        }
    }
}

/// Follows the target in full buffers. It has memory of its own: target, workspace and gray pixels.
#[embassy_executor::task]
async fn track(mut full: Receiver<'static, NoopRawMutex, Buffer>, button: Input<'static>, mut led: Output<'static>) {
    let (target, workspace) = (TARGET.take(), WORKSPACE.take());
    let (window, sweep) = (WINDOW.take(), SWEEP.take());
    loop {
        let is_lock = button.is_high(); // the blue button of a Nucleo board
        let frame = full.receive().await;
        let readout = read_out(target, is_lock, bytes(frame), window, sweep);
        // The window is in gray now, and the DMA may fill the buffer again.
        full.receive_done();
        let answer = match &readout {
            Some(readout) if is_lock => {
                lock(target, workspace, readout).await;
                None
            }
            Some(readout) => update(target, workspace, readout).await,
            None => None,
        };
        led.set_level(Level::from(answer.is_some_and(|answer| answer.state == State::Tracking)));
    }
}

/// The pixels that a lock or the next update reads; `None` without a target.
fn read_out<'a>(
    target: &Robust,
    is_lock: bool,
    frame: &[u8],
    pixels: &'a mut [u8; PIXELS],
    sweep_pixels: &'a mut [u8; PIXELS],
) -> Option<Readout<'a>> {
    let lock_window = target.lock_window(Rect::new(0, 0, WIDTH, HEIGHT), START);
    let window = if is_lock { lock_window } else { target.window()? };
    let mut readout = Readout::new(FORMAT, (WIDTH, HEIGHT), window, pixels).ok()?;
    if let Some(sweep) = target.sweep_window().filter(|_| !is_lock) {
        readout = readout.and_window(sweep, sweep_pixels).ok()?;
    }
    readout.push_frame(frame, LINE_BYTES).ok()?;
    Some(readout)
}

/// Locks in steps, so that `camera` starts the next frame in time.
async fn lock(target: &mut Robust, workspace: &mut Workspace, readout: &Readout<'_>) {
    let Ok(frame) = readout.frame() else { return };
    let Ok(mut lock) = target.begin_lock(workspace, &frame, START) else { return };
    while !lock.step(WORK) {
        yield_now().await;
    }
    lock.finish();
}

/// Updates in steps. The answer does not depend on them.
async fn update(target: &mut Robust, workspace: &mut Workspace, readout: &Readout<'_>) -> Option<Answer> {
    let frame = readout.frame().ok()?;
    let mut update = target.begin(workspace, &frame).ok()?;
    while !update.step(WORK) {
        yield_now().await;
    }
    Some(update.finish())
}

/// The bytes of a frame, in the order in which they came.
fn bytes(words: &Buffer) -> &[u8] {
    // SAFETY: every bit pattern is a valid byte, and bytes need no alignment, so all words are in the middle part.
    let (_, bytes, _) = unsafe { words.align_to() };
    bytes
}
