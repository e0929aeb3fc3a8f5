//! The paper's tracker alone, to measure its flash. The program is linked, but never run.
//!
//! `.ci/targets` measures its size and checks its symbols: it contains no panic and no float. `black_box` hides all
//! inputs from the compiler, so that the compiler drops no code that a camera would need.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;
    use smr_core::paper::Config;
    use smr_core::{Frame, Image, Paper, Rect, Tracker};

    /// The tracker that is measured: a template of 64x64 pixels, a window of +-16.
    type Weighed = Tracker<Paper<4096, 33>>;

    /// The smallest start-up code: that of cortex-m-rt on Arm, none elsewhere.
    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(not(target_arch = "arm"), allow(unsafe_code), unsafe(export_name = "_start"))]
    fn start() -> ! {
        let tracker = Weighed::new(black_box(Config::paper()));
        if let Ok(mut tracker) = tracker {
            follow(&mut tracker);
        }
        loop {
            core::hint::spin_loop();
        }
    }

    fn follow(tracker: &mut Weighed) {
        loop {
            let image = Image::with_stride(black_box(&[]), black_box(0), black_box(0), black_box(0));
            let Ok(image) = image else { continue };
            let Ok(frame) = Frame::part(image, black_box(0), black_box(0), black_box(0), black_box(0)) else {
                continue;
            };
            let _ = black_box(tracker.lock(&frame, black_box(Rect::default())));
            let _ = black_box(tracker.window());
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
