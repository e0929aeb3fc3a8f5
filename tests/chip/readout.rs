//! Measures the instructions of the read-out for each gray pixel, in QEMU on a Cortex-M.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf --profile firmware -p smr-chip --bin readout
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../../core/examples/record/measure.rs"]
#[allow(dead_code)] // this firmware does not measure the stack
mod measure;

#[cfg(target_os = "none")]
mod firmware {
    use crate::measure::{Timer, spin};
    use core::hint::black_box;
    use core::panic::PanicInfo;
    use cortex_m::Peripherals;
    use semihosting::process::exit;
    use semihosting::{eprintln, println};
    use smr_core::Rect;
    use smr_core::readout::{Format, Readout, ReadoutError};

    const CALIBRATION: u32 = 2_000_000;
    /// A window like that of a target of 40x40 pixels. Its left edge is at no multiple of four.
    const WINDOW: Rect = Rect::new(17, 10, 140, 140);
    const SENSOR: (u16, u16) = (640, 480);

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(peripherals) = Peripherals::take() else { exit(1) };
        let mut timer = Timer::new(peripherals.SYST);
        let tick = CALIBRATION / timer.measure(|| spin(CALIBRATION)).1.max(1);
        for (name, format) in [
            ("gray8", Format::GRAY8),
            ("yuyv", Format::YUYV),
            ("uyvy", Format::UYVY),
            ("rgb565le", Format::RGB565_LE),
            ("rgb565be", Format::RGB565_BE),
            ("bayer8", Format::BAYER8),
            ("gray10", Format::GRAY10),
        ] {
            let (result, ticks) = timer.measure(|| read(format));
            if let Err(why) = result {
                panic!("{name}: {why}");
            }
            println!("{name}: {} instructions for 100 pixels", 100 * (ticks * tick) / WINDOW.area());
        }
        let ticks = timer.measure(outside).1;
        println!("a line outside the window: {} instructions", ticks * tick / u32::from(SENSOR.1));
        exit(0)
    }

    /// Converts the lines of a window, one by one as from an interrupt.
    fn read(format: Format) -> Result<(), ReadoutError> {
        static LINE: [u8; 1280] = [90; 1280];
        let mut pixels = [0; 140 * 140];
        let mut readout = Readout::new(black_box(format), SENSOR, WINDOW)?;
        let mut y = 10 * if format == Format::BAYER8 { 2 } else { 1 };
        while !readout.is_complete() {
            readout.push_line(y, black_box(&LINE), &mut pixels)?;
            y += 1;
        }
        black_box(readout.frame(&pixels)?);
        Ok(())
    }

    /// Pushes lines that all lie below the window.
    fn outside() {
        let window = Rect::new(0, 0, 1, 1);
        let Ok(mut readout) = Readout::new(black_box(Format::YUYV), SENSOR, window) else { return };
        for y in 0..SENSOR.1 {
            let _ = black_box(readout.push_line(y, black_box(&[0; 1280]), &mut [0]));
        }
    }

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        eprintln!("{info}");
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
include!("host.rs");
