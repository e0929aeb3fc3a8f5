//! Where pictures are put: at the edges of the emulated boards' memory. A byte read or written beyond is a fault.

#![allow(unsafe_code)] // memory that no Rust object is in

use core::slice;
use cortex_m::peripheral::MPU;

/// Bytes at each of the edges; the firmware itself is nowhere near.
pub const ROOM: usize = 32 * 1024;

/// The memory that is used, each `ROOM` bytes.
pub struct Memory {
    /// With nothing after it.
    pub end: &'static mut [u8],
    /// The same, elsewhere.
    pub other_end: &'static mut [u8],
    /// With nothing before it.
    pub start: &'static mut [u8],
}

/// The edges of a board's memory.
struct Edges {
    end: usize,
    other_end: usize,
    start: usize,
}

impl Memory {
    /// To be called once. `None` on a processor whose board is not known.
    pub fn take(mpu: &MPU) -> Option<Self> {
        let edges = match processor() {
            0xC24 => Edges { end: 0x2080_0000, other_end: 0x0080_0000, start: 0x2100_0000 }, // M4: mps2-an386
            0xC27 => Edges { end: 0x2080_0000, other_end: 0x0080_0000, start: 0x6000_0000 }, // M7: mps2-an500
            0xD22 => Edges { end: 0x2008_0000, other_end: 0x0008_0000, start: 0x2100_0000 }, // M55: mps3-an547
            _ => return None,
        };
        if processor() != 0xD22 {
            // QEMU's MPS2, unlike its MPS3, reads zeroes where there is no memory.
            forbid(mpu, &[edges.end, edges.other_end, edges.start - FORBIDDEN]);
        }
        // SAFETY: the board has writable memory there, which is apart from what the linker script gives out (but for the
        // end of the code memory, which the firmware does not reach).
        let room = |at: usize| unsafe { slice::from_raw_parts_mut(at as *mut u8, ROOM) };
        Some(Self { end: room(edges.end - ROOM), other_end: room(edges.other_end - ROOM), start: room(edges.start) })
    }
}

/// Bytes that are forbidden beyond an edge.
const FORBIDDEN: usize = 4096;

/// Lets the memory protection unit of Armv7-M forbid what follows each of the addresses.
fn forbid(mpu: &MPU, addresses: &[usize]) {
    const ON_AND_ELSE_ALLOWED: u32 = 0b101;
    /// No access, to 2^(11 + 1) bytes.
    const NOT_EVEN_READ: u32 = 11 << 1 | 1;
    // RASR, the unit's fifth register. The crate knows it by another name when it is built for Armv8-M.
    let size_and_access = MPU::PTR.cast_mut().cast::<u32>().wrapping_add(4);
    for (region, &address) in (0..).zip(addresses) {
        #[allow(clippy::cast_possible_truncation)] // usize is u32 here
        let address = address as u32;
        // SAFETY: no Rust object is there.
        unsafe {
            mpu.rnr.write(region);
            mpu.rbar.write(address);
            size_and_access.write_volatile(NOT_EVEN_READ);
        }
    }
    // SAFETY: as above; everything else is as without the unit.
    unsafe { mpu.ctrl.write(ON_AND_ELSE_ALLOWED) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Reads the byte after `memory`.
pub fn read_beyond(memory: &[u8]) {
    // SAFETY: there is nothing, which is what it is for: the processor faults.
    unsafe { memory.as_ptr_range().end.read_volatile() };
}

/// The part number of Arm's processors.
fn processor() -> u32 {
    // SAFETY: every Armv7-M and Armv8-M has this register, which can be read at any time.
    let id = unsafe { (*cortex_m::peripheral::CPUID::PTR).base.read() };
    id >> 4 & 0xFFF
}
