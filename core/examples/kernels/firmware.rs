//! Runs the comparisons, measures the cost, and at last reads beyond the memory, which must fault.

use crate::alignment;
use crate::checks::{Checks, Difference};
use crate::figures::{self, Counter};
use crate::measure::Timer;
use crate::memory::{self, Memory};
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::Peripherals;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use defmt::{Debug2Format, error, info};
use defmt_semihosting as _;
use semihosting::process::exit;
use smr_core::similarity::Backend;

/// True when a fault is expected.
static TRYING: AtomicBool = AtomicBool::new(false);

#[entry]
fn main() -> ! {
    let peripherals = Peripherals::take();
    let memory = peripherals.as_ref().and_then(|peripherals| Memory::take(&peripherals.MPU));
    let (Some(peripherals), Some(mut memory)) = (peripherals, memory) else {
        error!("this board's memory is not known");
        exit(1)
    };
    alignment::require(&peripherals.SCB);
    let mut checks = Checks { backend: Backend::best(), compared: 0 };
    if let Err(difference) = checks.all(&mut memory) {
        let Difference { what, width, height, threshold } = difference;
        error!(
            "{}: {=str} of {=usize}x{=usize}, threshold {=u16}",
            Debug2Format(&checks.backend),
            what,
            width,
            height,
            threshold
        );
        exit(1);
    }
    info!("{}: {=u32} answers, all as the plain loops give them", Debug2Format(&checks.backend), checks.compared);
    info!("backend, kernel, size: instructions a call, thousandths of an instruction a pixel");
    figures::print(&mut Counter::new(Timer::new(peripherals.SYST)), &mut memory);

    TRYING.store(true, Ordering::SeqCst);
    memory::read_beyond(memory.end);
    error!("a byte was read from where no memory is: the checks would not notice if a kernel did");
    exit(1)
}

/// Ends the program. It is a success if the fault was expected.
#[exception]
#[allow(unsafe_code)] // cortex-m-rt requires an unsafe handler
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    if TRYING.load(Ordering::SeqCst) {
        exit(0);
    }
    error!("a fault at {=u32:#x}: memory was touched that is not the kernel's", frame.pc());
    exit(1)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    error!("{}", defmt::Display2Format(info));
    exit(1)
}
