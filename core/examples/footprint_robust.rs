//! The robust tracker alone, to measure its flash. The program is linked, but never run.
//!
//! `.ci/targets` checks it as it checks the paper's tracker in `footprint.rs`.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;
    use smr_core::robust::Config;
    use smr_core::{Frame, Image, Rect, Robust, Tracker};

    const _: () = assert!(size_of::<Tracker<Robust>>() <= 64 * 1024);

    /// The smallest start-up code: that of cortex-m-rt on Arm, none elsewhere.
    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(not(target_arch = "arm"), allow(unsafe_code), unsafe(export_name = "_start"))]
    fn start() -> ! {
        #[cfg(feature = "refiner")]
        let config = Config::refined();
        #[cfg(not(feature = "refiner"))]
        let config = Config::robust();
        let tracker = Tracker::<Robust>::new(black_box(config));
        if let Ok(mut tracker) = tracker {
            follow(&mut tracker);
        }
        loop {
            core::hint::spin_loop();
        }
    }

    fn follow(tracker: &mut Tracker<Robust>) {
        loop {
            let image = Image::with_stride(black_box(&[]), black_box(0), black_box(0), black_box(0));
            let Ok(image) = image else { continue };
            let Ok(frame) = Frame::part(image, black_box(0), black_box(0), black_box(0), black_box(0)) else {
                continue;
            };
            let _ = black_box(tracker.lock_window(frame.bounds(), black_box(Rect::default())));
            let _ = black_box(tracker.lock(&frame, black_box(Rect::default())));
            let _ = black_box(tracker.window());
            let _ = black_box(tracker.sweep_window());
            let _ = black_box(tracker.update(&frame));
        }
    }

    /// The compiler requires a panic handler. No call reaches it, so the linker drops it.
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            core::hint::spin_loop();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this firmware is not run: .ci/targets links it and measures its size");
}
