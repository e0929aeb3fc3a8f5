//! A simulated camera: draws a target line by line, as a sensor sends it.

pub const WIDTH: u16 = 96;
pub const HEIGHT: u16 = 72;
pub const PIXELS: usize = WIDTH as usize * HEIGHT as usize;
pub const FRAMES: u16 = 30;

/// The target's box in frame 0.
pub const START: smr_core::Rect = smr_core::Rect::new(20, 16, 16, 16);

/// Draws low-contrast tiles, and a high-contrast target that moves 2 pixels per frame and is hidden in frames 10 to 21.
pub fn line(frame: u16, y: u16) -> [u8; WIDTH as usize] {
    let (left, top) = (20 + 2 * (frame % 24), 16 + frame % 24);
    let hidden = (10..22).contains(&frame);
    let mut pixels = [0; WIDTH as usize];
    for (x, pixel) in (0..WIDTH).zip(&mut pixels) {
        let inside = !hidden && (left..left + 16).contains(&x) && (top..top + 16).contains(&y);
        *pixel = if inside { hash((x - left) / 4, (y - top) / 4) } else { 90 + hash(x / 8, y / 8 + 40) / 6 };
    }
    pixels
}

/// A pseudo-random gray level for each tile.
fn hash(x: u16, y: u16) -> u8 {
    let [.., high] = (u32::from(x) * 73 + u32::from(y) * 179 + 7).wrapping_mul(2_654_435_761).to_le_bytes();
    high
}
