//! The small robust tracker with Embassy on an STM32H743 (NUCLEO-H743ZI2) with a 320x240 gray camera at the DCMI. Not yet
//! run on a board.
//!
//! The DMA fills one of two buffers with the next frame while the tracker follows in the other. A frame that arrives
//! during a longer update is skipped.
//!
//! | pin | connects to |
//! |---|---|
//! | PC6, PC7, PE0, PE1, PE4, PD3, PE5, PE6 | camera D0 to D7 |
//! | PA6, PA4, PB7 | camera PIXCLK, HSYNC, VSYNC |
//! | PC13 | the board's button, which locks on the middle of the frame |
//! | PB0 | the board's LED: tracking |
//!
//! Set your sensor's registers by I2C: 320x240, 8-bit gray, HSYNC high during a line, VSYNC high between frames.

#![no_std]
#![no_main]

use core::slice;
use cortex_m::peripheral::SCB;
use embassy_executor::Spawner;
use embassy_futures::join::join;
use embassy_stm32::dcmi::{self, Dcmi};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{DCMI, DMA1_CH0};
use embassy_stm32::{bind_interrupts, dma};
use panic_halt as _;
use smr_core::robust::{Small, Workspace};
use smr_core::{Frame, Image, Rect, Robust, State, Target};
use static_cell::ConstStaticCell;

const WIDTH: u16 = 320;
const HEIGHT: u16 = 240;
const WORDS: usize = WIDTH as usize * HEIGHT as usize / 4;

/// The box to lock on when the button is pressed: 64x64 pixels in the middle.
const START: Rect = Rect::new(128, 88, 64, 64);

/// A frame from the DMA. It begins at a cache line and has whole ones, so that invalidating it discards nothing else.
#[repr(align(32))]
struct Buffer([u32; WORDS]);

const _: () = assert!(size_of::<Buffer>() == 4 * WORDS);

// Statics without a constructor at run time, so nothing is copied through the stack. `main` takes them once.
static TARGET: ConstStaticCell<Robust<Small>> = ConstStaticCell::new(Robust::new());
static WORKSPACE: ConstStaticCell<Workspace<Small>> = ConstStaticCell::new(Workspace::new());
static FRAMES: ConstStaticCell<[Buffer; 2]> = ConstStaticCell::new([const { Buffer([0; WORDS]) }; 2]);

bind_interrupts!(struct Interrupts {
    DCMI => dcmi::InterruptHandler<DCMI>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    // The clocks are those after a reset (64 MHz): `cycles` shows how to set 400 MHz.
    let chip = embassy_stm32::init(embassy_stm32::Config::default());
    let Some(mut core) = cortex_m::Peripherals::take() else { return };
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    let button = Input::new(chip.PC13, Pull::None);
    let mut led = Output::new(chip.PB0, Level::Low, Speed::Low);
    let mut camera = Dcmi::new_8bit(
        chip.DCMI,
        chip.DMA1_CH0,
        Interrupts,
        chip.PC6,
        chip.PC7,
        chip.PE0,
        chip.PE1,
        chip.PE4,
        chip.PD3,
        chip.PE5,
        chip.PE6,
        chip.PB7,
        chip.PA4,
        chip.PA6,
        dcmi::Config::default(),
    );
    let (target, workspace) = (TARGET.take(), WORKSPACE.take());
    let [mut filling, mut full] = FRAMES.take().each_mut();
    loop {
        // `join` starts the DMA first.
        let follow = async {
            if let Some(is_tracking) = follow(target, workspace, full.bytes(), button.is_high()) {
                led.set_level(Level::from(is_tracking));
            }
        };
        let (captured, ()) = join(camera.capture(&mut filling.0), follow).await;
        if captured.is_ok() {
            filling.invalidate(&mut core.SCB);
            (filling, full) = (full, filling);
        }
    }
}

/// Locks on the middle of the frame if the button is pressed, or follows the target. `None` without an answer.
fn follow(
    target: &mut Robust<Small>,
    workspace: &mut Workspace<Small>,
    pixels: &[u8],
    is_pressed: bool,
) -> Option<bool> {
    let frame = Frame::whole(Image::new(pixels, WIDTH, HEIGHT).ok()?);
    if is_pressed {
        target.lock(workspace, &frame, START).ok()?;
        return None;
    }
    target.window()?;
    Some(target.update(workspace, &frame).ok()?.state == State::Tracking)
}

impl Buffer {
    /// Discards the cache's copy, which is older than what the DMA has written.
    fn invalidate(&mut self, scb: &mut SCB) {
        // SAFETY: the buffer has whole cache lines, and the CPU never writes to it, so no line has newer bytes.
        unsafe { scb.invalidate_dcache_by_slice(&mut self.0) }
    }

    fn bytes(&self) -> &[u8] {
        // SAFETY: the words are initialised, and bytes of any value and alignment are a `u8`.
        unsafe { slice::from_raw_parts(self.0.as_ptr().cast(), size_of::<Self>()) }
    }
}
