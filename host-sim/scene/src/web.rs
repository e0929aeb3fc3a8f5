//! Functions by which JavaScript (`core/web/page/worker.js`) draws the street.

use crate::street::Street;

static mut STREET: Street = Street::BLANK;

/// Draws frame `index`, from 0, and returns a pointer to its pixels: red, green, blue and opacity.
#[unsafe(no_mangle)]
extern "C" fn street_frame(index: usize) -> *const [u8; 4] {
    // SAFETY: A module has one thread, and nothing else uses the street.
    let street = unsafe { &mut *&raw mut STREET };
    street.frame(index).as_ptr()
}

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    core::arch::wasm32::unreachable()
}
