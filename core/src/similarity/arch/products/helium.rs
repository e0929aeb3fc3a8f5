//! Sums of products by Helium: eight products an instruction.
//!
//! - Responses: `vmladava` adds the products of two registers to a number. Six offsets side by side share the weights that were loaded.
//!   In a loop from `dlstp` to `letp` the last round has as many lanes as there are weights left: nothing else is read.
//! - Gathering: the bytes of a channel are put side by side; then what errors say of its weights are responses, too, to a filter of
//!   errors at the offset of each weight.

use crate::similarity::products::{Layout, Room};
use core::arch::asm;
use core::ops::Range;

/// Bytes from an offset to the next one: those of a cell.
const STEP: usize = 10;
/// Offsets side by side.
const BLOCK: usize = 6;

/// Whether a filter of so many weights lies on the cells at all offsets, cell by cell; and its rows.
fn fits(cells: &[i8], layout: Layout, weights: usize) -> Option<usize> {
    let Layout { row, stride, step, span } = layout;
    let whole = step == STEP && row > 0 && row.is_multiple_of(STEP) && weights.is_multiple_of(row) && span > 0;
    let down = weights.checked_div(row).filter(|&down| whole && down > 0)?;
    let needed = (down + span - 2) * stride + row + (span - 1) * step;
    (cells.len() >= needed).then_some(down)
}

/// See [`products::responses`].
pub(super) fn responses<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, step, span } = layout;
    let Some(down) = fits(cells, layout, weights.len()).filter(|_| span <= N && out.len() >= span) else {
        return super::plain_responses(parts, cells, layout, weights, out);
    };
    let read = row.next_multiple_of(8);
    let rows = Rows { width: row, cells: stride.wrapping_sub(read), weights: (row.wrapping_sub(read)).wrapping_mul(2) };
    for (y, out) in out.iter_mut().enumerate().take(parts.end.min(span)).skip(parts.start) {
        let from = cells.as_ptr().wrapping_add(y * stride);
        if span < BLOCK {
            for (x, out) in out.iter_mut().take(span).enumerate() {
                // SAFETY: `fits` has seen that the filter lies on the cells at this offset.
                *out = unsafe { rows.one(from.wrapping_add(x * step), weights.as_ptr(), down) };
            }
            continue;
        }
        for x in (0..span).step_by(BLOCK) {
            // The last block may begin before the one before it has ended: those are computed twice, alike.
            let x = x.min(span - BLOCK);
            // SAFETY: `fits` has seen that the filter lies on the cells at these offsets, the last of which is below `span`.
            let sums = unsafe { rows.six::<STEP>(from.wrapping_add(x * step), weights.as_ptr(), down) };
            out.iter_mut().skip(x).zip(sums).for_each(|(out, sum)| *out = sum);
        }
    }
}

/// How the rows of a filter lie. The assembler reads it.
#[repr(C)]
struct Rows {
    width: usize,
    /// Bytes from where a row's loop has come to the next row.
    cells: usize,
    weights: usize,
}

impl Rows {
    /// The sums at six offsets side by side, so many bytes apart.
    ///
    /// # Safety
    /// `down` rows of `width` weights, at least one of each, can be read, and the cells under them at the six offsets.
    #[inline(never)]
    unsafe fn six<const APART: usize>(&self, cells: *const i8, weights: *const i16, down: usize) -> [i32; BLOCK] {
        let (a, b, c, d, e, f);
        // SAFETY: the caller has seen to what is read; nothing is written.
        unsafe {
            asm!(
                "2:",
                "ldr r9, [r5]",
                "dlstp.16 lr, r9",
                "3:",
                "vldrh.u16 q0, [r3], #16",
                "vldrb.s16 q1, [r1, #1 * {apart}]",
                "vmladava.s16 r2, q0, q1",
                "vldrb.s16 q1, [r1, #2 * {apart}]",
                "vmladava.s16 r4, q0, q1",
                "vldrb.s16 q1, [r1, #3 * {apart}]",
                "vmladava.s16 r8, q0, q1",
                "vldrb.s16 q1, [r1, #4 * {apart}]",
                "vmladava.s16 r10, q0, q1",
                "vldrb.s16 q1, [r1, #5 * {apart}]",
                "vmladava.s16 r12, q0, q1",
                "vldrb.s16 q1, [r1], #8",
                "vmladava.s16 r0, q0, q1",
                "letp lr, 3b",
                "ldr r9, [r5, #4]",
                "add r1, r1, r9",
                "ldr r9, [r5, #8]",
                "add r3, r3, r9",
                "subs r11, r11, #1",
                "bne 2b",
                inout("r0") 0 => a,
                inout("r2") 0 => b,
                inout("r4") 0 => c,
                inout("r8") 0 => d,
                inout("r10") 0 => e,
                inout("r12") 0 => f,
                inout("r1") cells => _,
                inout("r3") weights => _,
                in("r5") self,
                inout("r11") down => _,
                out("r9") _,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                apart = const APART,
                options(readonly, nostack),
            );
        }
        [a, b, c, d, e, f]
    }

    /// The sum at one offset.
    ///
    /// # Safety
    /// As for [`Rows::six`], at one.
    #[inline(never)]
    unsafe fn one(&self, cells: *const i8, weights: *const i16, down: usize) -> i32 {
        let sum;
        // SAFETY: the caller has seen to what is read; nothing is written.
        unsafe {
            asm!(
                "2:",
                "dlstp.16 lr, {width}",
                "3:",
                "vldrh.u16 q0, [r3], #16",
                "vldrb.s16 q1, [r1], #8",
                "vmladava.s16 r0, q0, q1",
                "letp lr, 3b",
                "add r1, r1, {cells}",
                "add r3, r3, {weights}",
                "subs {down}, {down}, #1",
                "bne 2b",
                inout("r0") 0 => sum,
                inout("r1") cells => _,
                inout("r3") weights => _,
                width = in(reg) self.width,
                cells = in(reg) self.cells,
                weights = in(reg) self.weights,
                down = inout(reg) down => _,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                options(readonly, nostack),
            );
        }
        sum
    }
}

/// Parts that sums are gathered in: channels.
pub(super) const GATHER_PARTS: usize = STEP;
/// Bytes to a channel of cells side by side.
static CELLS: [u16; 8] = [0, 10, 20, 30, 40, 50, 60, 70];

/// See [`products::gather`]. A part is a channel.
pub(super) fn gather<const N: usize>(
    parts: Range<usize>,
    room: &mut Room,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, span, .. } = layout;
    let width = stride / STEP;
    let count = |down: usize| (down + span - 2) * width + row / STEP + span - 1;
    let room_for = |&down: &usize| {
        span <= N && errors.len() >= span && stride.is_multiple_of(STEP) && count(down) <= size_of_val(room)
    };
    let Some(down) = fits(cells, layout, sums.len()).filter(room_for) else {
        // There a part is a row of errors.
        let parts = if parts.start == 0 { 0..span } else { 0..0 };
        return super::plain_gather(parts, cells, layout, errors, sums);
    };
    let read = span.next_multiple_of(8);
    let rows = Rows { width: span, cells: width.wrapping_sub(read), weights: N.wrapping_sub(read).wrapping_mul(2) };
    for channel in parts.start..parts.end.min(STEP) {
        let plane = room.as_mut_ptr().cast::<i8>();
        // SAFETY: of each cell that the filter lies on, all of which are there, a byte is read; as many are written, for which there is room.
        unsafe { side_by_side(cells.as_ptr().wrapping_add(channel), plane, count(down)) };
        for (y, sums) in sums.chunks_exact_mut(row.max(1)).enumerate() {
            let (of_cells, _) = sums.as_chunks_mut::<STEP>();
            let across = of_cells.len();
            let from = plane.cast_const().wrapping_add(y * width);
            let mut x = 0;
            while x < across {
                let known = if across - x > 2 && across >= BLOCK {
                    let block = x.min(across - BLOCK);
                    // SAFETY: the errors lie on the bytes at these offsets, the last of which is that of the last cell.
                    let sums = unsafe { rows.six::<1>(from.wrapping_add(block), errors.as_ptr().cast(), span) };
                    // The last block may begin before the one before it has ended.
                    (sums, x - block)
                } else {
                    // SAFETY: as above, at this offset.
                    ([unsafe { rows.one(from.wrapping_add(x), errors.as_ptr().cast(), span) }; BLOCK], BLOCK - 1)
                };
                for sum in known.0.iter().skip(known.1) {
                    if let Some(of_channel) = of_cells.get_mut(x).and_then(|cell| cell.get_mut(channel)) {
                        *of_channel += sum;
                    }
                    x += 1;
                }
            }
        }
    }
}

/// Puts a byte of each of so many cells side by side.
///
/// # Safety
/// The first byte of each cell can be read, and `to` can be written to. The count is not 0.
unsafe fn side_by_side(cells: *const i8, to: *mut i8, count: usize) {
    // SAFETY: the caller has seen to it; the last round has as many lanes as are left.
    unsafe {
        asm!(
            "vldrh.u16 q0, [{places}]",
            "dlstp.16 lr, {count}",
            "2:",
            "vldrb.u16 q1, [{cells}, q0]",
            "vstrb.16 q1, [{to}], #8",
            "add {cells}, {cells}, #80",
            "letp lr, 2b",
            places = in(reg) &raw const CELLS,
            count = in(reg) count,
            cells = inout(reg) cells => _,
            to = inout(reg) to => _,
            out("lr") _,
            out("q0") _,
            out("q1") _,
            options(nostack),
        );
    }
}
