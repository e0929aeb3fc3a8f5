//! The robust tracker with Embassy on an RP2350 with a 320x240 camera at the PIO. Not yet run on a board.
//!
//! The whole frame is never in memory. The DMA fills one of two line buffers while the read-out converts the window's
//! part of the other to gray. The update comes after the window's last line. Frames during an update are skipped.
//!
//! | pin | connects to |
//! |---|---|
//! | GP6 to GP16 | camera: see `camera.rs` |
//! | GP22 | button; its other side to GND |
//! | GP25 | lock indicator: the Pico 2's own LED |

#![no_std]
#![no_main]

mod camera;

use camera::{Camera, FORMAT, FRAME, HEIGHT, WIDTH, Wires};
use embassy_executor::Spawner;
use embassy_rp::gpio::{Input, Level, Output, Pull};
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

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let chip = embassy_rp::init(embassy_rp::config::Config::default());
    let button = Input::new(chip.PIN_22, Pull::Up);
    let mut led = Output::new(chip.PIN_25, Level::Low);
    let mut camera = Camera::new(Wires {
        pio: chip.PIO0,
        dma: chip.DMA_CH0,
        data: (chip.PIN_6, chip.PIN_7, chip.PIN_8, chip.PIN_9, chip.PIN_10, chip.PIN_11, chip.PIN_12, chip.PIN_13),
        pclk: chip.PIN_14,
        href: chip.PIN_15,
        vsync: chip.PIN_16,
    });

    let (target, workspace) = (TARGET.take(), WORKSPACE.take());
    let pixels = GRAY.take();
    loop {
        let is_lock = button.is_low();
        let windows = match target.windows() {
            Some(windows) if !is_lock => windows,
            _ => target.lock_window(FRAME, START).into(),
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
