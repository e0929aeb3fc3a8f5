//! Selects the board's memory map, and draws the frames that the firmware has in flash in place of a camera.

use std::{env, fs, path::PathBuf};

const BOARDS: [&str; 3] = ["stm32vldiscovery", "microbit", "netduinoplus2"];

// As in src/main.rs.
const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const FRAMES: u32 = 24;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap());
    let is_chosen = |board: &&&str| env::var_os(format!("CARGO_FEATURE_{}", board.to_uppercase())).is_some();
    let mut chosen = BOARDS.iter().filter(is_chosen);
    let (Some(board), None) = (chosen.next(), chosen.next()) else {
        panic!("expected one board: --features {}", BOARDS.join(", or "));
    };
    fs::copy(format!("memory/{board}.x"), out.join("memory.x")).unwrap();
    fs::write(out.join("frames.raw"), (0..FRAMES).flat_map(drawn).collect::<Vec<u8>>()).unwrap();
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rerun-if-changed=memory");
    println!("cargo::rerun-if-changed=build.rs");
}

/// Draws low-contrast tiles, and a high-contrast target of 12x12 pixels that moves by 2 and 1 pixels a frame and is
/// hidden in frames 10 to 13.
fn drawn(number: u32) -> impl Iterator<Item = u8> {
    let hash = |x: u32, y: u32| (x * 73 + y * 179 + 7).wrapping_mul(2_654_435_761) >> 24;
    let (left, top) = (6 + 2 * number, 4 + number);
    let hidden = (10..14).contains(&number);
    (0..WIDTH * HEIGHT).map(move |at| {
        let (x, y) = (at % WIDTH, at / WIDTH);
        let inside = !hidden && (left..left + 12).contains(&x) && (top..top + 12).contains(&y);
        let level = if inside { hash((x - left) / 3, (y - top) / 3) } else { 90 + hash(x / 8, y / 8 + 40) / 6 };
        u8::try_from(level).unwrap_or(u8::MAX)
    })
}
