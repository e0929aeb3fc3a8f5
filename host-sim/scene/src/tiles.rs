//! A built-in recording: a target made of tiles of high contrast moves over tiles of low contrast, 2 pixels to the
//! right and 1 down per frame. The target is hidden in frames 12 to 19 (from 0). All pixels are computed in integers
//! and without a buffer, so firmware draws the same pixels as the host.

pub const WIDTH: u16 = 320;
pub const HEIGHT: u16 = 240;
pub const FRAMES: u16 = 30;

/// Left and top edge of the target in the first frame.
pub const START: (u16, u16) = (100, 80);
pub const SIDE: u16 = 40;

pub const fn place(frame: u16) -> (u16, u16) {
    (START.0 + 2 * frame, START.1 + frame)
}

pub const fn is_hidden(frame: u16) -> bool {
    frame >= 12 && frame < 20
}

pub fn level(frame: u16, x: u16, y: u16) -> u8 {
    let (left, top) = place(frame);
    let inside = (left..left + SIDE).contains(&x) && (top..top + SIDE).contains(&y);
    if inside && !is_hidden(frame) { tile((x - left) / 5, (y - top) / 5) } else { 90 + tile(x / 8, y / 8 + 40) / 6 }
}

fn tile(column: u16, row: u16) -> u8 {
    let number = (u32::from(column) * 73 + u32::from(row) * 179 + 7).wrapping_mul(2_654_435_761);
    number.to_be_bytes()[0]
}
