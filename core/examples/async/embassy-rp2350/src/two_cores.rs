//! The robust tracker on both cores of an RP2350: core 1 reads the camera's next frame while core 0 follows in the frame
//! before. Not yet run on a board.
//!
//! Each frame is followed, up to the camera's rate, if an update takes no longer than a frame. It costs the RAM of two
//! windows, 150 KB: both are a whole frame, because the next window is known only after the update.
//!
//! Buffers pass between the cores as `&'static mut`, through one channel when read and through another when free, so
//! each has one owner at a time and no pixel is copied. Pins: those of `main.rs`.

#![no_std]
#![no_main]

mod camera;

use camera::{Camera, FORMAT, FRAME, HEIGHT, WIDTH, Wires};
use embassy_executor::{Executor, Spawner};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::multicore::{Stack, spawn_core1};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use panic_halt as _;
use smr_core::readout::Readout;
use smr_core::robust::Workspace;
use smr_core::{Frame, Image, Rect, Robust, State, Target};
use static_cell::{ConstStaticCell, StaticCell};

const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// The box to lock on when the button is pressed: 64x64 pixels in the middle.
const START: Rect = Rect::new(128, 88, 64, 64);

type Gray = [u8; PIXELS];
type Buffers = Channel<CriticalSectionRawMutex, &'static mut Gray, 2>;

static FREE: Buffers = Channel::new();
static FULL: Buffers = Channel::new();
static GRAY: ConstStaticCell<[Gray; 2]> = ConstStaticCell::new([[0; PIXELS]; 2]);
static TARGET: ConstStaticCell<Robust> = ConstStaticCell::new(Robust::new());
static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static STACK: ConstStaticCell<Stack<4096>> = ConstStaticCell::new(Stack::new());
static EXECUTOR: StaticCell<Executor> = StaticCell::new();

/// Core 0: follows in each full buffer, then frees it.
#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let chip = embassy_rp::init(embassy_rp::config::Config::default());
    let button = Input::new(chip.PIN_22, Pull::Up);
    let mut led = Output::new(chip.PIN_25, Level::Low);
    spawn_core1(chip.CORE1, STACK.take(), move || {
        let camera = Camera::new(Wires {
            pio: chip.PIO0,
            dma: chip.DMA_CH0,
            data: (chip.PIN_6, chip.PIN_7, chip.PIN_8, chip.PIN_9, chip.PIN_10, chip.PIN_11, chip.PIN_12, chip.PIN_13),
            pclk: chip.PIN_14,
            href: chip.PIN_15,
            vsync: chip.PIN_16,
        });
        EXECUTOR.init(Executor::new()).run(|spawner| {
            if let Ok(task) = read(camera) {
                spawner.spawn(task);
            }
        })
    });

    for pixels in GRAY.take() {
        FREE.send(pixels).await;
    }
    let (target, workspace) = (TARGET.take(), WORKSPACE.take());
    loop {
        let pixels = FULL.receive().await;
        if let Ok(image) = Image::new(&pixels[..], WIDTH, HEIGHT) {
            let frame = Frame::whole(image);
            if button.is_low() {
                let _ = target.lock(workspace, &frame, START);
            } else if let Ok(answer) = target.update(workspace, &frame) {
                led.set_level(Level::from(answer.state == State::Tracking));
            }
        }
        FREE.send(pixels).await;
    }
}

/// Core 1: fills each free buffer with the next whole frame.
#[embassy_executor::task]
async fn read(mut camera: Camera) {
    let Ok(begun) = Readout::new(FORMAT, (WIDTH, HEIGHT), FRAME) else { return };
    let mut pixels = FREE.receive().await;
    loop {
        let mut readout = begun;
        camera.read(&mut readout, &mut pixels[..]).await;
        if readout.is_complete() {
            FULL.send(pixels).await;
            pixels = FREE.receive().await;
        }
    }
}
