//! Sums of products by Helium: eight products in one instruction.
//!
//! - Responses: `vmladava` adds the products of two vectors to a register. Up to seven neighbouring offsets share the
//!   loaded weights. In a loop from `dlstp` to `letp` the last round uses and loads one lane for each remaining weight.
//! - Gradient: the features of a channel are copied side by side. The gradient of its weights is then the response to a
//!   filter of errors, at the offset of each weight.

use crate::kernels::layout::{CHANNELS, Layout, Packed};
use crate::kernels::plain::products as plain;
use core::arch::asm;
use core::ops::Range;

/// Bytes from a filter offset to the next one: the features of one cell, one byte each.
const STEP: usize = CHANNELS;
/// Maximum number of neighbouring sums that are computed at a time.
const MAX_SUMS: usize = 7;

pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    let Some(down) = layout
        .checked_height(cells.len(), weights.len())
        .filter(|_| span <= N && out.len() >= span && span % 2 == 1 && span > 1)
    else {
        return plain::responses(pieces, room, spare, cells, layout, weights, out);
    };
    let read = row.next_multiple_of(8);
    let rows = Rows { width: row, cells: stride.wrapping_sub(read), weights: (row.wrapping_sub(read)).wrapping_mul(2) };
    for y in pieces.start..pieces.end.min(span) {
        let Some(out) = out.get_mut(y) else { return };
        let from = cells.as_ptr().wrapping_add(y * stride);
        let mut x = 0;
        while x < span {
            // Divides the offsets into as few blocks as possible, of similar size. The last may overlap the one before.
            let width = match span - x {
                0..=3 => 3,
                4 | 5 | 8..=10 | 15 => 5,
                _ => 7,
            };
            x = x.min(span - width);
            let (cells, weights) = (from.wrapping_add(x * step), weights.as_ptr());
            // SAFETY: `checked_height` found enough cells for these offsets, all of which are below `span`.
            let sums = unsafe {
                match width {
                    3 => rows.three::<STEP>(cells, weights, down),
                    5 => rows.five::<STEP>(cells, weights, down),
                    _ => rows.seven::<STEP>(cells, weights, down),
                }
            };
            out.iter_mut().skip(x).zip(sums).take(width).for_each(|(out, sum)| *out = sum);
            x += width;
        }
    }
}

/// Row sizes of a filter. The assembly reads this.
#[repr(C)]
struct Rows {
    width: usize,
    /// Bytes from the end of a row's last vector to the next row: first in the cells, then in the weights.
    cells: usize,
    weights: usize,
}

/// Defines a function for the sums at offsets `APART` bytes apart: the first sum in r0, the others in the given
/// registers. `asm!` takes no operand in r6, so the lines with r6 are arguments: `$begin`, `$seventh`, `$end`.
macro_rules! sums {
    (
        $name:ident: $sums:expr;
        $first:ident $nine:ident $($number:literal $register:tt $sum:ident)*;
        $($begin:literal)*; $($seventh:literal)*; $($end:literal)*
    ) => {
        /// # Safety
        /// At `weights`, `self.width` weights can be read in each of `down` rows, and at `cells` as many bytes at each
        /// of the offsets, which are `APART` bytes apart. Rows are as far apart as `self` states. Neither number is 0.
        #[inline(never)]
        unsafe fn $name<const APART: usize>(&self, cells: *const i8, weights: *const i16, down: usize) -> [i32; MAX_SUMS] {
            let ($first, $nine): (_, i32);
            $(let $sum;)*
            // SAFETY: the last vector of a row has as many lanes as weights are left. Nothing but the stack is written.
            unsafe {
                asm!(
                    $($begin,)*
                    "2:",
                    "ldr r9, [r5]",
                    "dlstp.16 lr, r9",
                    "3:",
                    "vldrh.u16 q0, [r3], #16",
                    $(
                        concat!("vldrb.s16 q1, [r1, #", $number, " * {apart}]"),
                        concat!("vmladava.s16 ", $register, ", q0, q1"),
                    )*
                    $($seventh,)*
                    "vldrb.s16 q1, [r1], #8",
                    "vmladava.s16 r0, q0, q1",
                    "letp lr, 3b",
                    "ldrd r9, lr, [r5, #4]",
                    "add r1, r1, r9",
                    "add r3, r3, lr",
                    "subs r11, r11, #1",
                    "bne 2b",
                    $($end,)*
                    inout("r0") 0 => $first,
                    $(inout($register) 0 => $sum,)*
                    inout("r1") cells => _,
                    inout("r3") weights => _,
                    in("r5") self,
                    inout("r11") down => _,
                    out("r9") $nine,
                    out("lr") _, out("q0") _, out("q1") _,
                    apart = const APART,
                );
            }
            $sums
        }
    };
}

impl Rows {
    sums! {
        three: [a, b, c, 0, 0, 0, 0];
        a _nine 1 "r2" b 2 "r4" c;;;
    }
    sums! {
        five: [a, b, c, d, e, 0, 0];
        a _nine 1 "r2" b 2 "r4" c 3 "r8" d 4 "r10" e;;;
    }
    sums! {
        six: [a, b, c, d, e, f, 0];
        a _nine 1 "r2" b 2 "r4" c 3 "r8" d 4 "r10" e 5 "r12" f;;;
    }
    sums! {
        seven: [a, b, c, d, e, f, g];
        a g 1 "r2" b 2 "r4" c 3 "r8" d 4 "r10" e 5 "r12" f;
        "push {{r6}}" "movs r6, #0";
        "vldrb.s16 q1, [r1, #6 * {apart}]" "vmladava.s16 r6, q0, q1";
        "mov r9, r6" "pop {{r6}}"
    }
}

/// Multiplies eight errors of a row by the bytes under them at each of six neighbouring offsets (seven if `seven` is
/// 1), and adds the products to the sum of that offset.
macro_rules! eight {
    () => {
        "vldrh.u16 q0, [r3], #16
        vldrb.s16 q1, [r1, #1]
        vmladava.s16 r2, q0, q1
        vldrb.s16 q1, [r1, #2]
        vmladava.s16 r4, q0, q1
        vldrb.s16 q1, [r1, #3]
        vmladava.s16 r8, q0, q1
        vldrb.s16 q1, [r1, #4]
        vmladava.s16 r10, q0, q1
        vldrb.s16 q1, [r1, #5]
        vmladava.s16 r12, q0, q1
        .if {seven}
        vldrb.s16 q1, [r1, #6]
        vmladava.s16 r6, q0, q1
        .endif
        vldrb.s16 q1, [r1], #8
        vmladava.s16 r0, q0, q1"
    };
}

impl Rows {
    /// Computes the sums of [`Rows::seven`], or of [`Rows::six`] if `SEVEN` is 0, for a square block of errors. A row
    /// of the block begins every `N` errors, a row of bytes every `apart` bytes. A row of 9 or 17 errors consists of
    /// one or two vectors of eight, and one last error. The last errors of all rows are processed as a column, which
    /// fills lanes better.
    ///
    /// # Safety
    /// In each of `self.width` rows, `self.width` errors can be read at `errors`, and `self.width + 5 + SEVEN` bytes at
    /// `bytes`; `self` states the same distances of rows as `N` and `apart`. `self.width` is not 0. Seven sums can be
    /// written at `to`.
    #[inline(never)]
    unsafe fn errors_at<const N: usize, const SEVEN: usize>(
        &self,
        bytes: *const i8,
        errors: *const i16,
        apart: usize,
        to: *mut [i32; MAX_SUMS],
    ) {
        let span = self.width;
        if span != 17 && span != 9 {
            // SAFETY: `span` rows of `span` errors can be read, and the bytes under them at six or seven offsets, one
            // byte apart. Seven sums can be written at `to`.
            unsafe {
                *to =
                    if SEVEN == 0 { self.six::<1>(bytes, errors, span) } else { self.seven::<1>(bytes, errors, span) };
            }
            return;
        }
        let (mut a, mut b, mut c, mut d, mut e, mut f, mut g);
        // SAFETY: of a row all errors but the last are read, then those as a column. Only the stack is written; it
        // saves r6, which `asm!` may not name.
        unsafe {
            asm!(
                "push {{r6}}",
                "movs r6, #0",
                "dls lr, lr",
                "2:",
                eight!(),
                "cbz r5, 3f",
                eight!(),
                "3:",
                "add r1, r1, r9",
                "add r3, r3, r11",
                "le lr, 2b",
                "mov r11, r6",
                "pop {{r6}}",
                inout("r0") 0 => a,
                inout("r2") 0 => b,
                inout("r4") 0 => c,
                inout("r8") 0 => d,
                inout("r10") 0 => e,
                inout("r12") 0 => f,
                inout("r1") bytes => _,
                inout("r3") errors => _,
                in("r5") span / 17,
                in("r9") apart.wrapping_sub(span - 1),
                inout("r11") 2 * (N.wrapping_sub(span - 1)) => g,
                inout("lr") span => _,
                out("q0") _, out("q1") _,
                seven = const SEVEN,
            );
        }
        // SAFETY: of each row the last error is read, and the bytes under it. The last round has as many lanes as rows
        // are left. Only the stack is written; it saves r6, which `asm!` may not name.
        unsafe {
            asm!(
                "push {{r6}}",
                "movs r6, #0",
                "vidup.u16 q2, r6, #1",
                "mov r6, r11",
                "vmul.i16 q3, q2, r9",
                "vmul.i16 q2, q2, r5",
                "lsl r11, r5, #3",
                "sub r11, r11, #5 + {seven}",
                "dlstp.16 lr, lr",
                "2:",
                "vldrh.u16 q0, [r3, q3]",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r0, q0, q1",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r2, q0, q1",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r4, q0, q1",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r8, q0, q1",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r10, q0, q1",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r12, q0, q1",
                ".if {seven}",
                "adds r1, #1",
                "vldrb.s16 q1, [r1, q2]",
                "vmladava.s16 r6, q0, q1",
                ".endif",
                "add r1, r1, r11",
                "add r3, r3, r9, lsl #3",
                "letp lr, 2b",
                "mov r11, r6",
                "pop {{r6}}",
                inout("r0") a,
                inout("r2") b,
                inout("r4") c,
                inout("r8") d,
                inout("r10") e,
                inout("r12") f,
                inout("r1") bytes.wrapping_add(span - 1) => _,
                inout("r3") errors.wrapping_add(span - 1) => _,
                in("r5") apart,
                in("r9") 2 * N,
                inout("r11") g,
                inout("lr") span => _,
                out("q0") _, out("q1") _, out("q2") _, out("q3") _,
                seven = const SEVEN,
            );
        }
        // SAFETY: seven sums can be written at `to`, which is aligned.
        unsafe { *to = [a, b, c, d, e, f, g] };
    }
}

pub(crate) use plain::TAKES_ROWS_OF_CELLS;
pub(crate) const GATHER_PIECES: Option<usize> = Some(STEP);

/// Adds the gradient of the filter's error, as [`plain::gather`] specifies. Pieces of work are channels.
pub(crate) fn gather<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, span, .. } = layout;
    let width = stride / STEP;
    let count = |down: usize| (down + span - 2) * width + row / STEP + span - 1;
    let room_for = |&down: &usize| {
        span <= N && errors.len() >= span && stride.is_multiple_of(STEP) && count(down) + MAX_SUMS <= size_of_val(room)
    };
    let fitting = layout.checked_height(cells.len(), sums.len()).filter(room_for);
    let (of_cells, _) = sums.as_chunks_mut::<STEP>();
    let (Some(down), Some(of_channel)) = (fitting, spare.get_mut(..of_cells.len() + MAX_SUMS)) else {
        return plain::gather(layout.all_rows_in_first_piece(pieces), room, spare, cells, layout, errors, sums);
    };
    let read = span.next_multiple_of(8);
    let rows = Rows { width: span, cells: width.wrapping_sub(read), weights: N.wrapping_sub(read).wrapping_mul(2) };
    // Computes six or seven sums at a time, whichever is faster: a block of seven costs 9/8 of a block of six.
    let across = row / STEP;
    let block = if 9 * across.div_ceil(MAX_SUMS) <= 8 * across.div_ceil(6) { MAX_SUMS } else { 6 };
    for channel in pieces.start..pieces.end.min(STEP) {
        let plane = room.0.as_mut_ptr().cast::<i8>();
        // SAFETY: reads one byte of each cell under the filter. `checked_height` and `room_for` checked cells and room.
        unsafe { side_by_side(cells.as_ptr().wrapping_add(channel), plane, count(down)) };
        for y in 0..down {
            let mut x = 0;
            while x < across {
                let from = plane.cast_const().wrapping_add(y * width + x);
                let to = of_channel.as_mut_ptr().wrapping_add(y * across + x).cast();
                // SAFETY: the errors lie on the copied bytes, or, beyond the last weight, on the room after them. Sums
                // at such offsets are overwritten by those of the next row, or lie after all others.
                unsafe {
                    if block == MAX_SUMS {
                        rows.errors_at::<N, 1>(from, errors.as_ptr().cast(), width, to);
                    } else {
                        rows.errors_at::<N, 0>(from, errors.as_ptr().cast(), width, to);
                    }
                }
                x += block;
            }
        }
        for (of_cell, sum) in of_cells.iter_mut().zip(&*of_channel) {
            if let Some(of_channel) = of_cell.get_mut(channel) {
                *of_channel += sum;
            }
        }
    }
}

/// Copies one byte of each of `count` cells, side by side.
///
/// # Safety
/// A byte can be read in each of `count` cells, ten bytes apart, from `cells` on. `count` bytes can be written at `to`.
/// `count` is not 0.
unsafe fn side_by_side(cells: *const i8, to: *mut i8, count: usize) {
    // SAFETY: the last round has as many lanes as cells are left of `count`.
    unsafe {
        asm!(
            "vldrh.u16 q0, [{places}]",
            "dlstp.16 lr, {count}",
            "2:",
            "vldrb.u16 q1, [{cells}, q0]",
            "vstrb.16 q1, [r0], #8",
            "add {cells}, {cells}, #80",
            "letp lr, 2b",
            places = in(reg) &raw const super::CELLS,
            count = in(reg) count,
            cells = inout(reg) cells => _,
            // The base register of a narrowing store must be one of r0 to r7.
            inout("r0") to => _,
            out("lr") _, out("q0") _, out("q1") _,
            options(nostack),
        );
    }
}
