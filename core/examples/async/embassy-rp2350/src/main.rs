//! The robust tracker with Embassy on an RP2350 with a 320x240 camera at the PIO. Not yet run on a board.
//!
//! The whole frame is never in memory. The DMA fills one of two line buffers while the read-out converts the window's
//! part of the other to gray. The update comes after the window's last line. Frames during an update are skipped.
//!
//! | pin | connects to |
//! |---|---|
//! | GP6 to GP13 | camera D0 to D7 |
//! | GP14, GP15, GP16 | camera PCLK, HREF, VSYNC |
//! | GP22 | button; its other side to GND |
//! | GP25 | lock indicator: the Pico 2's own LED |
//!
//! Set your sensor's registers by I2C: 320x240, YUYV, PCLK at most 12 MHz, VSYNC high between frames.

#![no_std]
#![no_main]

mod camera;

use camera::{Camera, FORMAT, HEIGHT, LINE_BYTES, Line, WIDTH};
use embassy_executor::Spawner;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::peripherals::{DMA_CH0, PIO0};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{self, Direction, FifoJoin, Pio, ShiftConfig, ShiftDirection};
use embassy_rp::{bind_interrupts, dma};
use panic_halt as _;
use smr_core::readout::Readout;
use smr_core::robust::Workspace;
use smr_core::{Rect, Robust, State, Target};
use static_cell::ConstStaticCell;

/// Size of the buffer `GRAY` in pixels: two windows of at most a whole frame each.
const PIXELS: usize = 2 * WIDTH as usize * HEIGHT as usize;

/// The box to lock on when the button is pressed: 64x64 pixels in the middle.
const START: Rect = Rect::new(128, 88, 64, 64);

// Statics without a constructor at run time, so nothing is copied through the stack. `main` takes them once.
static TARGET: ConstStaticCell<Robust> = ConstStaticCell::new(Robust::new());
static WORKSPACE: ConstStaticCell<Workspace> = ConstStaticCell::new(Workspace::new());
static GRAY: ConstStaticCell<[u8; PIXELS]> = ConstStaticCell::new([0; PIXELS]);
static LINES: ConstStaticCell<[Line; 2]> = ConstStaticCell::new([[0; LINE_BYTES]; 2]);

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
});

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let chip = embassy_rp::init(embassy_rp::config::Config::default());
    let button = Input::new(chip.PIN_22, Pull::Up);
    let mut led = Output::new(chip.PIN_25, Level::Low);

    let mut pio = Pio::new(chip.PIO0, Interrupts);
    let data = [
        pio.common.make_pio_pin(chip.PIN_6),
        pio.common.make_pio_pin(chip.PIN_7),
        pio.common.make_pio_pin(chip.PIN_8),
        pio.common.make_pio_pin(chip.PIN_9),
        pio.common.make_pio_pin(chip.PIN_10),
        pio.common.make_pio_pin(chip.PIN_11),
        pio.common.make_pio_pin(chip.PIN_12),
        pio.common.make_pio_pin(chip.PIN_13),
    ];
    let clocks = [pio.common.make_pio_pin(chip.PIN_14), pio.common.make_pio_pin(chip.PIN_15)];
    // PIO program: while HREF (GP15) is high, reads a byte at each rising edge of PCLK (GP14).
    let program = pio_asm!(".wrap_target", "wait 1 gpio 15", "wait 1 gpio 14", "in pins, 8", "wait 0 gpio 14", ".wrap");
    let mut config = pio::Config::default();
    config.use_program(&pio.common.load_program(&program.program), &[]);
    config.set_in_pins(&data.each_ref());
    // The PIO pushes each byte at once, as the low byte of a word. The DMA reads only that byte.
    config.shift_in = ShiftConfig { auto_fill: true, threshold: 8, direction: ShiftDirection::Left };
    config.fifo_join = FifoJoin::RxOnly;
    pio.sm0.set_config(&config);
    pio.sm0.set_pin_dirs(Direction::In, &data.each_ref());
    pio.sm0.set_pin_dirs(Direction::In, &clocks.each_ref());
    let mut camera = Camera {
        machine: pio.sm0,
        dma: dma::Channel::new(chip.DMA_CH0, Interrupts),
        vsync: Input::new(chip.PIN_16, Pull::None),
        lines: LINES.take(),
    };

    let (target, workspace) = (TARGET.take(), WORKSPACE.take());
    let pixels = GRAY.take();
    loop {
        let is_lock = button.is_low();
        let windows = match target.windows() {
            Some(windows) if !is_lock => windows,
            _ => target.lock_window(Rect::new(0, 0, WIDTH, HEIGHT), START).into(),
        };
        let Ok(mut readout) = Readout::new(FORMAT, (WIDTH, HEIGHT), windows) else { continue };
        camera.read(&mut readout, &mut pixels[..]).await;
        let Ok(frame) = readout.frame(&pixels[..]) else { continue };
        if is_lock {
            let _ = target.lock(workspace, &frame, START);
        } else if target.window().is_some() {
            let is_tracking = target.update(workspace, &frame).is_ok_and(|answer| answer.state == State::Tracking);
            led.set_level(Level::from(is_tracking));
        }
    }
}
