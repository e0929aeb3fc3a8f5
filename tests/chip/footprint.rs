//! A program to measure the flash of one tracker: the paper's, or the robust one (feature `robust`). It is never run.
//!
//! `.ci/firmware` checks that it has no panic and no float. `black_box` hides inputs, so that no code is dropped.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;
    use smr_core::{Frame, Image, Rect, Tracker};

    #[cfg(not(feature = "robust"))]
    use smr_core::paper::Config;
    #[cfg(feature = "robust")]
    use smr_core::{Robust as Weighed, robust::Config};
    /// The paper tracker with at most 64x64 template pixels and a search window of at most +-16 pixels.
    #[cfg(not(feature = "robust"))]
    type Weighed = smr_core::Paper<4096, 33>;

    const _: () = assert!(size_of::<Tracker<Weighed>>() <= 64 * 1024);

    /// The entry point, with the least start-up code: cortex-m-rt on Arm, none elsewhere.
    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(not(target_arch = "arm"), allow(unsafe_code), unsafe(export_name = "_start"))]
    fn start() -> ! {
        #[cfg(not(feature = "robust"))]
        let config = Config::paper();
        #[cfg(all(feature = "robust", not(feature = "refiner")))]
        let config = Config::robust();
        #[cfg(feature = "refiner")]
        let config = Config::refined();
        let tracker = Tracker::<Weighed>::with(black_box(config));
        if let Ok(mut tracker) = tracker {
            follow(&mut tracker);
        }
        loop {
            core::hint::spin_loop();
        }
    }

    fn follow(tracker: &mut Tracker<Weighed>) {
        loop {
            let image = Image::with_stride(black_box(&[]), black_box(0), black_box(0), black_box(0));
            let Ok(image) = image else { continue };
            let Ok(frame) = Frame::part(image, black_box(0), black_box(0), black_box(0), black_box(0)) else {
                continue;
            };
            #[cfg(feature = "robust")]
            let _ = black_box(tracker.lock_window(frame.bounds(), black_box(Rect::default())));
            let _ = black_box(tracker.lock(&frame, black_box(Rect::default())));
            let _ = black_box(tracker.window());
            #[cfg(feature = "robust")]
            let _ = black_box(tracker.sweep_window());
            let _ = black_box(tracker.update(&frame));
        }
    }

    /// The panic handler that a `no_std` program must have. No call reaches it, so the linker drops it.
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            core::hint::spin_loop();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this firmware is not run: .ci/firmware links it and measures its size");
}
