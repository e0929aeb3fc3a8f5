//! Replays a flight record from the debugger's host, and writes the work and time of each update. `tests/qemu` makes
//! the record, runs this firmware in QEMU, and reports the results.
//!
//! Only one entry of the record is in memory. The firmware has no log and no panic, so that it measures the tracker
//! alone. It replays the record with whole updates and, if `step.smr` exists, again in steps.
//!
//! # Files in the working folder of QEMU
//!
//! The firmware reads `record.smr`, whose format `smr_core::record` describes. A saved target in it must be the
//! tracker's own, unless the tracker has none. The four bytes of the optional file `step.smr` are the work of a step.
//!
//! The firmware writes `said.smr`: lines of 16 numbers of 32 bits, little-endian. The first number is the kind of the
//! line. Numbers that the table does not list are 0.
//!
//! | line          | numbers                                                                                        |
//! |---------------|------------------------------------------------------------------------------------------------|
//! | 1, hello      | version of these lines (5), bytes of the buffer for an entry, size of target and of workspace, instructions and ticks of a loop (their quotient is the instructions per tick) |
//! | 2, update     | work, ticks                                                                                    |
//! | 3, in steps   | ticks of the longest step                                                                      |
//! | 4, end        | bytes of stack used, bytes of stack in all, bytes of stack that an update used, ticks of the last lock |
//! | 5, difference | byte of the record, what differs (see `End`), and of another answer: left, top, width and height of the box (in 1/256 pixel), state, confidence, ratio, runner-up's ratio and alpha (2^32 - 1 if there is none), scale, 1 if found again, identity (2^32 - 1 if there is none) |

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_os = "none", target_arch = "arm"))]
#[path = "../alignment.rs"]
mod alignment;
#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
#[path = "../../../core/examples/record/host_file.rs"]
mod host_file;
#[cfg(all(target_os = "none", target_arch = "arm"))]
#[path = "../../../core/examples/record/measure.rs"]
mod measure;
#[cfg(all(target_os = "none", target_arch = "riscv32"))]
#[path = "riscv.rs"]
mod measure;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-chip --bin replay -- synthetic");
}
