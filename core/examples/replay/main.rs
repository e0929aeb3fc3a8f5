//! Follows the target of a recording that lies on the debugger's host, and answers frame by frame: what
//! `host-sim target` runs in QEMU and compares with itself.
//!
//! Of a frame only the search window is ever in memory. No log, no panic: what is measured here is the tracker.
//!
//! # Protocol, version 2
//!
//! Two files in the folder that QEMU runs in. All numbers are 32 bits, little-endian.
//!
//! `frames.smr`, read: `SMRF`, version, width, height, number of frames, then left, top, width and height of the box to
//! lock on in the first frame. The frames follow, 8-bit gray, rows without gaps.
//!
//! `answers.smr`, written: records of 16 numbers; the first says what it is, those not named are 0.
//!
//! | record     | numbers                                                                                           |
//! |------------|---------------------------------------------------------------------------------------------------|
//! | 1, hello   | version, pixels of the template, offsets on an axis, radius, pixels of the buffer, size of the tracker, instructions and ticks of a loop (so many instructions are a tick) |
//! | 2, answer  | frame (from 2), left, top, state (0 tracking, 1 leaving, 2 lost), ratio, runner-up's ratio, alpha, peak's left, top and score, runner-up's score, 1 if it was asked for (else it and its ratio are 0), FNV-1a of the template, ticks of `Tracker::update` |
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
