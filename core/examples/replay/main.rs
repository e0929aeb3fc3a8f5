//! Follows the target of a recording on the debugger's host and writes an answer for each frame. `tests/qemu` runs
//! it in QEMU and compares the answers with its own.
//!
//! Only the windows that the tracker needs are in memory. The firmware has no log and no panic, so that its
//! measurements are those of the tracker: either of the two, at once or in steps.
//!
//! # Protocol, version 4
//!
//! Two files in the working folder of QEMU. All numbers are 32 bits, little-endian.
//!
//! The firmware reads `frames.smr`: `SMRF`, version, method (0 smr, 1 robust, 2 robust with
//! its refiner, if the firmware is built with the feature `refiner`), work of a step (0: all at once), width,
//! height, number of frames, then left, top, width and height of the box to lock on in the first frame. The frames
//! follow: 8-bit gray, rows without gaps.
//!
//! The firmware writes `answers.smr`: records of 20 numbers. The first number is the kind of the record. Numbers not
//! listed are 0.
//!
//! | record     | numbers                                                                                           |
//! |------------|---------------------------------------------------------------------------------------------------|
//! | 1, hello   | version, method, the most pixels of a box and the radius of the window (0 without such a bound), bytes of the buffer for pixels, size of target and of workspace, instructions and ticks of a loop (their quotient is the instructions per tick) |
//! | 2, answer  | frame (from 2), left, top, width and height of the box (in 1/256 pixel), state (0 tracking, 1 leaving, 2 uncertain, 3 lost), confidence, ratio, runner-up's ratio and alpha (2^32 - 1 if there is none), scale, 1 if found again, FNV-1a of the saved target, work, ticks of the update, ticks of its longest step |
//! | 3, end     | frames, bytes of stack used, bytes of stack in all, ticks of the lock                             |
//! | 4, refused | frame, reason (see `Refusal`)                                                                     |

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_os = "none", target_arch = "arm"))]
#[path = "../alignment.rs"]
mod alignment;
#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
mod host_file;
#[cfg(all(target_os = "none", target_arch = "arm"))]
mod measure;
#[cfg(all(target_os = "none", target_arch = "riscv32"))]
#[path = "riscv.rs"]
mod measure;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: cargo run --target thumbv7em-none-eabihf -p smr-examples --bin replay -- synthetic");
}
