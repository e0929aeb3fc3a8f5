//! Frames as the initializer of a C array, for firmware without a file system.

use smr_recordings::{BoundingBox, GrayFrame};
use std::fmt::Write;

/// Bytes in a line of the file.
const IN_A_LINE: usize = 24;

/// `name` as a C identifier.
pub(super) fn identifier(name: &str) -> String {
    let allowed = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' };
    let plain: String = name.chars().map(allowed).collect();
    if plain.starts_with(|first: char| first.is_ascii_alphabetic()) { plain } else { format!("smr_{plain}") }
}

/// What stands before the first frame.
pub(super) fn head(name: &str, frame: &GrayFrame, start: Option<&BoundingBox>) -> String {
    let (array, large) = (identifier(name), identifier(name).to_uppercase());
    let GrayFrame { width, height, .. } = frame;
    let mut text = format!(
        "/* {name}: frames of 8-bit gray, row after row without gaps. Written by host-sim {}. */\n\
         #ifndef {large}_H\n#define {large}_H\n\n\
         #define {large}_WIDTH {width}\n#define {large}_HEIGHT {height}\n",
        env!("CARGO_PKG_VERSION")
    );
    if let Some(rect) = start.and_then(BoundingBox::to_rect) {
        text += "/* The box to start from, in the first frame. */\n";
        for (side, value) in
            [("X", rect.x), ("Y", rect.y), ("BOX_WIDTH", rect.width.into()), ("BOX_HEIGHT", rect.height.into())]
        {
            let _ = writeln!(text, "#define {large}_{side} {value}");
        }
    }
    text + &format!("\nstatic const unsigned char {array}[][{large}_WIDTH * {large}_HEIGHT] = {{\n")
}

/// A frame as one element.
pub(super) fn element(frame: &GrayFrame) -> String {
    let mut text = String::with_capacity(frame.pixels.len() * 4 + 8);
    text += "{\n";
    for line in frame.pixels.chunks(IN_A_LINE) {
        for pixel in line {
            let _ = write!(text, "{pixel},");
        }
        text.push('\n');
    }
    text + "},\n"
}

/// What stands after the last frame.
pub(super) fn foot(name: &str) -> String {
    let (array, large) = (identifier(name), identifier(name).to_uppercase());
    format!("}};\n\n#define {large}_FRAMES (sizeof {array} / sizeof {array}[0])\n\n#endif\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers() {
        for (name, expected) in [("Car1", "car1"), ("my clip-2", "my_clip_2"), ("2fast", "smr_2fast"), ("ü", "smr__")]
        {
            assert_eq!(identifier(name), expected);
        }
    }
}
