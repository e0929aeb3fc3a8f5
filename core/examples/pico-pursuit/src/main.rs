//! A camera on a pan/tilt head that follows a target. The README shows the wiring and what to measure on your head.

#![no_std]
#![no_main]

mod camera;
#[cfg(not(feature = "robust"))]
mod paper;
#[cfg(feature = "robust")]
mod robust;

use camera::{Buffer, Camera, HEIGHT, WIDTH};
use core::convert::Infallible;
use cortex_m::singleton;
use embedded_hal::digital::InputPin;
use panic_halt as _;
#[cfg(not(feature = "robust"))]
use paper as tracker;
#[cfg(feature = "robust")]
use robust as tracker;
use rp2040_hal::dma::DMAExt;
use rp2040_hal::fugit::RateExtU32;
use rp2040_hal::gpio::{FunctionI2C, FunctionPio0, Pin, Pins, PullNone, PullUp};
use rp2040_hal::pio::PIOExt;
use rp2040_hal::pwm::Slices;
use rp2040_hal::{Clock, I2C, Sio, Timer, Watchdog, clocks, pac};
use smr_core::pursuit::{self, Axis, Pursuit, PursuitConfig, Servo};
use smr_core::{Answer, Frame, Image, Rect, State, Target, Tracker};
use tracker::{Chosen, TARGET_PIXELS};

/// The second stage of the boot loader, which `memory.x` places. (`link_section` is `unsafe`: it can name any section.)
#[unsafe(link_section = ".boot2")]
#[unsafe(no_mangle)]
#[used]
pub static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

const CRYSTAL_HERTZ: u32 = 12_000_000;
/// Divider of the PWM clock: at 125 MHz / 40 its counter reaches 62500 in 20 milliseconds.
const PWM_DIVIDER: u8 = 40;
const PWM_TOP: u16 = 62_499;

/// Focal length of your lens: n * d / w, if an object of width w at distance d covers n pixels.
const FOCAL_LENGTH_PIXELS: f32 = 160.0;

/// Limits of an axis: 60 degrees to each side, for pulses of 900 to 2100 microseconds. Measure your own servos.
const AXIS: Axis = {
    let mut axis = Axis::new(-1.05, 1.05);
    axis.gain_per_second = tracker::GAIN_PER_SECOND;
    axis
};
const SERVO: Servo = Servo::new(900, 2100);

#[rp2040_hal::entry]
fn main() -> ! {
    // `run` returns only if its set-up fails, e.g. because the camera does not respond. Then the LED stays off.
    let _ = run();
    loop {
        core::hint::spin_loop();
    }
}

fn run() -> Option<Infallible> {
    let mut chip = pac::Peripherals::take()?;
    let mut watchdog = Watchdog::new(chip.WATCHDOG);
    let clocks = clocks::init_clocks_and_plls(
        CRYSTAL_HERTZ,
        chip.XOSC,
        chip.CLOCKS,
        chip.PLL_SYS,
        chip.PLL_USB,
        &mut chip.RESETS,
        &mut watchdog,
    )
    .ok()?;
    let timer = Timer::new(chip.TIMER, &mut chip.RESETS, &clocks);
    let sio = Sio::new(chip.SIO);
    let pins = Pins::new(chip.IO_BANK0, chip.PADS_BANK0, sio.gpio_bank0, &mut chip.RESETS);

    // The head's two servos, on one PWM slice. (The LED on GP25, which `pursuit` switches, is on the Pico.)
    let mut slice = Slices::new(chip.PWM, &mut chip.RESETS).pwm2;
    slice.set_div_int(PWM_DIVIDER);
    slice.set_top(PWM_TOP);
    slice.enable();
    let (mut pan, mut tilt) = (slice.channel_a, slice.channel_b);
    pan.output_to(pins.gpio20);
    tilt.output_to(pins.gpio21);
    let camera_model = pursuit::Camera::centred(FOCAL_LENGTH_PIXELS, WIDTH, HEIGHT);
    let mut config = PursuitConfig::new(camera_model, (AXIS, SERVO), (AXIS, SERVO));
    config.hold_seconds = 3.0;
    let mut pursuit = Pursuit::new(config, pan, tilt, pins.gpio25.into_push_pull_output()).ok()?;
    pursuit.wait(0.0).ok()?;

    let sda: Pin<_, FunctionI2C, PullUp> = pins.gpio4.reconfigure();
    let scl: Pin<_, FunctionI2C, PullUp> = pins.gpio5.reconfigure();
    let bus = I2C::i2c0(chip.I2C0, sda, scl, 100.kHz(), &mut chip.RESETS, clocks.system_clock.freq());
    let _d0: Pin<_, FunctionPio0, PullNone> = pins.gpio6.reconfigure();
    let _pclk: Pin<_, FunctionPio0, PullNone> = pins.gpio14.reconfigure();
    let _href: Pin<_, FunctionPio0, PullNone> = pins.gpio15.reconfigure();
    let _vsync: Pin<_, FunctionPio0, PullNone> = pins.gpio16.reconfigure();
    let (mut pio, machine, ..) = chip.PIO0.split(&mut chip.RESETS);
    let dma = chip.DMA.split(&mut chip.RESETS);
    let buffers = [singleton!(: Buffer = [0; _])?, singleton!(: Buffer = [0; _])?, singleton!(: Buffer = [0; _])?];
    let mut camera = Camera::start(bus, timer, &mut pio, machine, (dma.ch0, dma.ch1), buffers)?;

    let mut button = pins.gpio22.into_pull_up_input();
    let mut tracker = Tracker::<Chosen>::with(tracker::config()).ok()?;
    let mut before = timer.get_counter();
    let mut sure = false;
    for update in (0..tracker::UPDATES_PER_TEMPLATE).cycle() {
        let pressed = button.is_low().ok()?;
        let pixels = camera.frame();
        let now = timer.get_counter();
        let elapsed_seconds = now.checked_duration_since(before)?.to_micros() as f32 / 1e6;
        before = now;
        let Some(frame) = pixels.and_then(|pixels| frame_to_search(&mut tracker, pixels, pressed)) else {
            pursuit.wait(elapsed_seconds).ok()?;
            continue;
        };
        let answer = tracker.update(&frame).ok()?;
        // What was found after a loss turns the head only when the tracker is sure: it may be a piece of the background.
        sure = match answer.state {
            State::Tracking | State::Leaving => true,
            State::Uncertain => sure,
            _ => false,
        };
        if sure { pursuit.steer(&answer, elapsed_seconds) } else { pursuit.wait(elapsed_seconds) }.ok()?;
        if update == tracker::UPDATES_PER_TEMPLATE - 1 {
            lock_again(&mut tracker, &frame, &answer);
        }
        let (right, down) = pursuit.picture_motion();
        tracker.moved(right, down);
    }
    None
}

/// Locks on the middle of the frame and returns `None` if the button is pressed. Otherwise returns the frame for an
/// update, or `None` without a target.
fn frame_to_search<'a, T: Target>(tracker: &mut Tracker<T>, pixels: &'a [u8], pressed: bool) -> Option<Frame<'a>> {
    let frame = Frame::whole(Image::new(pixels, WIDTH, HEIGHT).ok()?);
    if pressed {
        let (x, y) = (i32::from((WIDTH - TARGET_PIXELS) / 2), i32::from((HEIGHT - TARGET_PIXELS) / 2));
        tracker.lock(&frame, Rect::new(x, y, TARGET_PIXELS, TARGET_PIXELS)).ok()?;
        return None;
    }
    tracker.window().map(|_| frame)
}

/// Takes a new template where the target was found, if it was.
fn lock_again<T: Target>(tracker: &mut Tracker<T>, frame: &Frame<'_>, found: &Answer) {
    if found.state == State::Tracking {
        // A box that is partly outside of the frame keeps its template.
        let _ = tracker.lock(frame, found.bbox);
    }
}
