//! The memory for the pictures, at the edges of the emulated boards' memory. An access beyond the edge faults.

#![allow(unsafe_code)] // memory by its address

use core::slice;
use cortex_m::peripheral::MPU;

/// Bytes of each area. The areas are far away from the firmware itself.
pub const ROOM: usize = 32 * 1024;

/// Three areas of `ROOM` bytes.
pub struct Memory {
    /// An area with no memory after it.
    pub end: &'static mut [u8],
    /// Another area with no memory after it.
    pub other_end: &'static mut [u8],
    /// An area with no memory before it.
    pub start: &'static mut [u8],
}

/// The edges of a board's memory.
struct Edges {
    end: usize,
    other_end: usize,
    start: usize,
}

impl Memory {
    /// Takes the memory; to be called once. `None` if the board is unknown.
    pub fn take(mpu: &MPU) -> Option<Self> {
        let edges = match processor() {
            // M3: mps2-an385, M4: mps2-an386
            0xC23 | 0xC24 => Edges { end: 0x2080_0000, other_end: 0x0080_0000, start: 0x2100_0000 },
            0xC27 => Edges { end: 0x2080_0000, other_end: 0x0080_0000, start: 0x6000_0000 }, // M7: mps2-an500
            0xD22 => Edges { end: 0x2008_0000, other_end: 0x0008_0000, start: 0x2100_0000 }, // M55: mps3-an547
            _ => return None,
        };
        if processor() != 0xD22 {
            // QEMU's MPS2, unlike its MPS3, reads zeroes where there is no memory.
            forbid(mpu, &[edges.end, edges.other_end, edges.start - FORBIDDEN]);
        }
        // SAFETY: the board has writable memory there, and the linker script puts nothing there. (The code memory ends
        // in this range, but the firmware is much shorter.)
        let room = |at: usize| unsafe { slice::from_raw_parts_mut(at as *mut u8, ROOM) };
        Some(Self { end: room(edges.end - ROOM), other_end: room(edges.other_end - ROOM), start: room(edges.start) })
    }
}

/// Bytes beyond an edge that the memory protection unit blocks.
const FORBIDDEN: usize = 4096;

/// Blocks the memory from each of the addresses on with the memory protection unit of Armv7-M.
fn forbid(mpu: &MPU, addresses: &[usize]) {
    const ON_AND_ELSE_ALLOWED: u32 = 0b101;
    /// No access to 2^(11 + 1) bytes, not even to read.
    const NOT_EVEN_READ: u32 = 11 << 1 | 1;
    // RASR, the fifth register of the unit. The crate gives it another name when it is compiled for Armv8-M.
    let size_and_access = MPU::PTR.cast_mut().cast::<u32>().wrapping_add(4);
    for (region, &address) in (0..).zip(addresses) {
        #[allow(clippy::cast_possible_truncation)] // usize is u32 here
        let address = address as u32;
        // SAFETY: no Rust object is at that address.
        unsafe {
            mpu.rnr.write(region);
            mpu.rbar.write(address);
            size_and_access.write_volatile(NOT_EVEN_READ);
        }
    }
    // SAFETY: as above; all other memory stays accessible.
    unsafe { mpu.ctrl.write(ON_AND_ELSE_ALLOWED) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Reads the byte after `memory`, which must fault.
pub fn read_beyond(memory: &[u8]) {
    // SAFETY: there is no memory at this address, so no object is read: the processor faults, as intended.
    unsafe { memory.as_ptr_range().end.read_volatile() };
}

/// The part number of the Arm processor.
fn processor() -> u32 {
    // SAFETY: every Armv7-M and Armv8-M processor has this register, and it can always be read.
    let id = unsafe { (*cortex_m::peripheral::CPUID::PTR).base.read() };
    id >> 4 & 0xFFF
}
