//! Follows the target of a recording that lies on the debugger's host, and answers frame by frame: what
//! `host-sim target` runs in QEMU and compares with itself.
//!
//! Of a frame only the windows that the tracker asks for are ever in memory. No log, no panic: what is measured here is the
//! tracker, either of the two, at once or in steps.
//!
//! # Protocol, version 3
//!
//! Two files in the folder that QEMU runs in. All numbers are 32 bits, little-endian.
//!
//! `frames.smr`, read: `SMRF`, version, method (0 smr, 1 robust), work of a step (0: all at once), width, height, number of
//! frames, then left, top, width and height of the box to lock on in the first frame. The frames follow, 8-bit gray, rows
//! without gaps.
//!
//! `answers.smr`, written: records of 20 numbers; the first says what it is, those not named are 0.
//!
//! | record     | numbers                                                                                           |
//! |------------|---------------------------------------------------------------------------------------------------|
//! | 1, hello   | version, method, the most pixels of a box and the radius of the window (0 where there is no such bound), bytes of the buffer for pixels, size of target and of workspace, instructions and ticks of a loop (so many instructions are a tick) |
//! | 2, answer  | frame (from 2), left, top, width and height of the box (in 1/256 pixel), state (0 tracking, 1 leaving, 2 uncertain, 3 lost), confidence, ratio, runner-up's ratio and alpha (2^32 - 1 where there is none), scale, 1 if found again, FNV-1a of the target as it is saved, work, ticks of the update, ticks of its longest step |
//! | 3, end     | frames, bytes of stack used, bytes there are                                                      |
//! | 4, refused | frame, why (see `Refusal`)                                                                        |

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware;
#[cfg(target_os = "none")]
mod host_file;
#[cfg(target_os = "none")]
mod measure;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware, run by host-sim: cargo run --release -p host-sim -- target synthetic");
}
