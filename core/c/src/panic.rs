//! The panic handler of a build for a microcontroller or of a WebAssembly module. The linker needs one, but no call can
//! reach it: `.ci/c` fails if it is in a linked program.

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    #[cfg(target_family = "wasm")]
    core::arch::wasm32::unreachable();
    #[cfg(not(target_family = "wasm"))]
    loop {
        core::hint::spin_loop();
    }
}
