//! Frames as the initializer of a C array, for firmware without a file system.

use smr_core::Rect;
use smr_recordings::{BoundingBox, GrayFrame};
use std::fmt::Write;

const IN_A_LINE: usize = 24;

/// Names that a C array must not have: keywords of C23 and C++23, macros of compilers (`linux`), names in headers.
const TAKEN: &str = "
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class co_await co_return co_yield compl concept const const_cast
    consteval constexpr constinit continue decltype default delete do double dynamic_cast else enum explicit export extern false float for friend
    goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct switch template this thread_local
    throw true try typedef typeid typename typeof typeof_unqual union unsigned using virtual void volatile while xor xor_eq
    arm far fortran i386 interrupt linux main near unix errno std stderr stdin stdout size uint ulong
    abort abs accept access alarm assert bind ceil clock close complex connect div dup exit exp floor fork free gamma imaginary index kill link
    listen log nice open pause pipe poll pow raise rand random read remainder remove rename rewind round select send shutdown signal sin sleep
    socket sqrt stat sync system tan time truncate unlink wait write y0 y1";

/// Turns `name` into a C identifier that clashes with no keyword, macro or standard function.
pub(super) fn identifier(name: &str) -> String {
    let allowed = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' };
    let plain: String = name.chars().map(allowed).collect();
    let is_name = plain.starts_with(|first: char| first.is_ascii_alphabetic());
    // POSIX reserves names that end in `_t`, and smr.h defines names that begin with `smr_`.
    let is_taken = plain.ends_with("_t") || plain.starts_with("smr_");
    let is_free = !is_taken && TAKEN.split_whitespace().all(|taken| taken != plain);
    if is_name && is_free { plain } else { format!("frames_{plain}") }
}

pub(super) fn head(name: &str, frame: &GrayFrame, start: Option<&BoundingBox>) -> String {
    let (array, large) = (identifier(name), identifier(name).to_uppercase());
    let GrayFrame { width, height, .. } = frame;
    let mut text = format!(
        "/* {name}: frames of 8-bit gray, row after row without gaps. Written by host-sim {}. */\n\
         #ifndef {large}_H\n#define {large}_H\n\n\
         #define {large}_WIDTH {width}\n#define {large}_HEIGHT {height}\n",
        env!("CARGO_PKG_VERSION")
    );
    if let Some(Rect { x, y, width, height }) = start.and_then(BoundingBox::to_rect) {
        text += &format!(
            "/* The initial box, in the first frame. */\n#define {large}_X {x}\n#define {large}_Y {y}\n\
             #define {large}_BOX_WIDTH {width}\n#define {large}_BOX_HEIGHT {height}\n"
        );
    }
    text + &format!("\nstatic const unsigned char {array}[][{large}_WIDTH * {large}_HEIGHT] = {{\n")
}

pub(super) fn element(frame: &GrayFrame) -> String {
    let mut text = String::from("{\n");
    for line in frame.pixels.chunks(IN_A_LINE) {
        for pixel in line {
            let _ = write!(text, "{pixel},");
        }
        text.push('\n');
    }
    text + "},\n"
}

pub(super) fn foot(name: &str) -> String {
    let (array, large) = (identifier(name), identifier(name).to_uppercase());
    format!("}};\n\n#define {large}_FRAMES (sizeof {array} / sizeof {array}[0])\n\n#endif\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers() {
        for (name, expected) in
            [("Car1", "car1"), ("my clip-2", "my_clip_2"), ("2fast", "frames_2fast"), ("ü", "frames__")]
        {
            assert_eq!(identifier(name), expected);
        }
        for taken in ["int", "Class", "co_await", "linux", "time", "uint8_t", "smr_lock"] {
            assert_eq!(identifier(taken), format!("frames_{}", taken.to_lowercase()));
        }
    }
}
