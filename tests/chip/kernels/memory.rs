//! Memory for the test images, at the edges of the emulated board's memory, so that an access beyond an edge faults.

#![allow(unsafe_code)] // memory by its address

use core::slice;
#[cfg(target_arch = "arm")]
use cortex_m::peripheral::MPU;
use smr_core::unstable::check::{Areas, ROOM};

/// Returns three areas for images: two end at two addresses of `edges`, one starts at the third. Call this only once.
pub fn take() -> Areas<'static> {
    let [end, other_end, start] = edges();
    // SAFETY: the board has writable memory there, and the linker script puts nothing there: the firmware is short.
    let room = |at: usize| unsafe { slice::from_raw_parts_mut(at as *mut u8, ROOM) };
    Areas { end: room(end - ROOM), other_end: room(other_end - ROOM), start: room(start) }
}

/// Three addresses at the edges of the board's memories: the ends of two memories, and the start of a third.
#[cfg(target_arch = "arm")]
fn edges() -> [usize; 3] {
    let peripherals = cortex_m::Peripherals::take().expect("they were not taken before");
    crate::alignment::require(&peripherals.SCB);
    let edges = match processor() {
        // Cortex-M3 (QEMU's board mps2-an385) and Cortex-M4 (mps2-an386)
        0xC23 | 0xC24 => [0x2080_0000, 0x0080_0000, 0x2100_0000],
        0xC27 => [0x2080_0000, 0x0080_0000, 0x6000_0000], // M7: mps2-an500
        0xD22 => return [0x2008_0000, 0x0008_0000, 0x2100_0000], // M55: mps3-an547
        _ => panic!("this board's memory is not known"),
    };
    // QEMU's MPS2 boards, unlike MPS3, read zeroes beyond the memory instead of faulting.
    forbid(&peripherals.MPU, [edges[0], edges[1], edges[2] - FORBIDDEN]);
    edges
}

/// Three addresses for QEMU's machine `virt`. Its one memory (128 MB) ends at the first; the others lie inside.
#[cfg(target_arch = "riscv32")]
fn edges() -> [usize; 3] {
    const END: usize = 0x8800_0000;
    [END, END - ROOM, END - 3 * ROOM]
}

#[cfg(target_arch = "arm")]
/// Number of bytes that the memory protection unit (MPU) blocks beyond each edge.
const FORBIDDEN: usize = 4096;

#[cfg(target_arch = "arm")]
/// Blocks `FORBIDDEN` bytes from each address on, with the MPU of Armv7-M.
fn forbid(mpu: &MPU, addresses: [usize; 3]) {
    const ON_AND_ELSE_ALLOWED: u32 = 0b101;
    /// Region size and access bits: 2^(11 + 1) bytes that may be neither read nor written.
    const NOT_EVEN_READ: u32 = 11 << 1 | 1;
    // RASR, the MPU's fifth register. The crate cortex-m names it differently for Armv8-M.
    let size_and_access = MPU::PTR.cast_mut().cast::<u32>().wrapping_add(4);
    for (region, address) in (0..).zip(addresses) {
        #[allow(clippy::cast_possible_truncation)] // usize is u32 here
        let address = address as u32;
        // SAFETY: no Rust object is at that address.
        unsafe {
            mpu.rnr.write(region);
            mpu.rbar.write(address);
            size_and_access.write_volatile(NOT_EVEN_READ);
        }
    }
    // SAFETY: no Rust object is in the regions that are forbidden, and all other memory stays accessible.
    unsafe { mpu.ctrl.write(ON_AND_ELSE_ALLOWED) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Reads the byte after `memory`, which must fault.
pub fn read_beyond(memory: &[u8]) {
    // SAFETY: there is no memory at this address, so no object is read: the processor faults, as intended.
    unsafe { memory.as_ptr_range().end.read_volatile() };
}

#[cfg(target_arch = "arm")]
/// The Arm processor's part number.
fn processor() -> u32 {
    // SAFETY: every Armv7-M and Armv8-M processor has this register, and it can always be read.
    let id = unsafe { (*cortex_m::peripheral::CPUID::PTR).base.read() };
    id >> 4 & 0xFFF
}
