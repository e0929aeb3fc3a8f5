//! Compares every kernel of the chip's best backend with the plain loop, on images at the edge of memory, where an
//! access beyond the image faults. Finally checks that such an access does fault.
//!
//! ```text
//! cargo run --target thumbv7em-none-eabihf -p smr-chip --bin kernels --features refiner
//! ```
//!
//! Runs only in QEMU, because it depends on the memory maps of the emulated boards.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_os = "none", target_arch = "arm"))]
#[path = "../alignment.rs"]
mod alignment;
#[cfg(target_os = "none")]
mod memory;

#[cfg(target_os = "none")]
mod firmware {
    use crate::memory;
    use core::panic::PanicInfo;
    use core::sync::atomic::{AtomicBool, Ordering};
    use semihosting::process::exit;
    use semihosting::{eprintln, println};
    use smr_core::similarity::Backend;
    use smr_core::unstable::check;

    /// True while a fault is expected.
    static TRYING: AtomicBool = AtomicBool::new(false);

    #[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
    #[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
    fn main() -> ! {
        let mut areas = memory::take();
        check::all(Backend::best(), &mut areas);
        println!("{:?}: all kernels give the answers of the plain loops", Backend::best());
        TRYING.store(true, Ordering::SeqCst);
        memory::read_beyond(areas.end);
        panic!("a byte was read from where no memory is: the checks would not notice if a kernel did");
    }

    /// Ends the program, with success if the fault was expected.
    fn fault(at: usize) -> ! {
        if TRYING.load(Ordering::SeqCst) {
            exit(0);
        }
        panic!("a fault at {at:#x}: memory was touched that is not the kernel's");
    }

    /// # Safety
    /// Only the processor calls this, with the registers that it has stored at a fault.
    #[cfg(target_arch = "arm")]
    #[cortex_m_rt::exception]
    #[allow(unsafe_code)] // cortex-m-rt requires an unsafe handler
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        fault(frame.pc() as usize)
    }

    #[cfg(target_arch = "riscv32")]
    #[allow(unsafe_code)] // SAFETY: riscv-rt calls the function of this name, and no other has it.
    #[unsafe(no_mangle)]
    extern "C" fn ExceptionHandler(_: &riscv_rt::TrapFrame) -> ! {
        fault(0)
    }

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        eprintln!("{info}");
        exit(1)
    }
}

#[cfg(not(target_os = "none"))]
include!("../host.rs");
