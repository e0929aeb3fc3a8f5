//! What a microcontroller build does on a panic. It must exist to link, and nothing reaches it: `.ci/c` looks for it in
//! the linked examples and fails if it is there.

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
