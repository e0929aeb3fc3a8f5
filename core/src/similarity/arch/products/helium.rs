//! Sums of products by Helium: eight products an instruction for responses, four to gather.
//!
//! - Responses: `vmladava` adds the products of two registers to a number. Six offsets side by side share the weights that were loaded.
//!   In a loop from `dlstp` to `letp` the last round has as many lanes as there are weights left: nothing else is read.
//! - Gathering: `vmla` adds a register times an error to the sums of four weights. Those of two cells, or of one, stay in
//!   registers for all errors; a cell's ten are the lanes from 0, 4 and 6 on, so that two are computed twice, alike.

use crate::similarity::products::Layout;
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
            let sums = unsafe { rows.six(from.wrapping_add(x * step), weights.as_ptr(), down) };
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
    /// The sums at six offsets side by side.
    ///
    /// # Safety
    /// `down` rows of `width` weights, at least one of each, can be read, and the cells under them at the six offsets.
    #[inline(never)]
    unsafe fn six(&self, cells: *const i8, weights: *const i16, down: usize) -> [i32; BLOCK] {
        let (a, b, c, d, e, f);
        // SAFETY: the caller has seen to what is read; nothing is written.
        unsafe {
            asm!(
                "2:",
                "ldr r9, [r5]",
                "dlstp.16 lr, r9",
                "3:",
                "vldrh.u16 q0, [r3], #16",
                "vldrb.s16 q1, [r1, #10]",
                "vmladava.s16 r2, q0, q1",
                "vldrb.s16 q1, [r1, #20]",
                "vmladava.s16 r4, q0, q1",
                "vldrb.s16 q1, [r1, #30]",
                "vmladava.s16 r8, q0, q1",
                "vldrb.s16 q1, [r1, #40]",
                "vmladava.s16 r10, q0, q1",
                "vldrb.s16 q1, [r1, #50]",
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

/// See [`products::gather`]. A part is a row of sums.
pub(super) fn gather<const N: usize>(
    parts: Range<usize>,
    cells: &[i8],
    layout: Layout,
    errors: &[[i16; N]],
    sums: &mut [i32],
) {
    let Layout { row, stride, step, span } = layout;
    let room = |_: &usize| span <= N && errors.len() >= span;
    let Some(_) = fits(cells, layout, sums.len()).filter(room) else {
        // There a part is a row of errors.
        let parts = if parts.start == 0 { 0..span } else { 0..0 };
        return super::plain_gather(parts, cells, layout, errors, sums);
    };
    let under = Under {
        errors: errors.as_ptr().cast(),
        span,
        cells_on: stride.wrapping_sub(span * step),
        errors_on: 2 * (N - span),
    };
    for (y, sums) in sums.chunks_exact_mut(row.max(1)).enumerate().take(parts.end).skip(parts.start) {
        let from = cells.as_ptr().wrapping_add(y * stride);
        let (pairs, rest) = sums.as_chunks_mut::<{ 2 * STEP }>();
        for (x, sums) in pairs.iter_mut().enumerate() {
            // SAFETY: `fits` has seen that these cells are there at all offsets, and there is an error for each.
            unsafe { under.two_cells(from.wrapping_add(x * 2 * STEP), sums) };
        }
        if let Some(sums) = rest.first_chunk_mut() {
            // SAFETY: as above.
            unsafe { under.one_cell(from.wrapping_add(pairs.len() * 2 * STEP), sums) };
        }
    }
}

/// What lies under a weight at all offsets.
struct Under {
    errors: *const i16,
    span: usize,
    /// Bytes from where a row of offsets has ended to the next one.
    cells_on: usize,
    errors_on: usize,
}

/// Adds to the sums of a cell or two the products of all errors with the bytes that lie there. Each register has the sums, and bytes, from
/// so many on.
macro_rules! add_products {
    ($under:ident, $cells:ident, $sums:ident: $($register:tt $from:literal $from_bytes:literal,)*) => {
        asm!(
            $(concat!("vldrw.u32 ", $register, ", [r2, #", $from_bytes, "]"),)*
            "2:",
            "dls lr, {span}",
            "3:",
            "ldrsh r3, [{errors}], #2",
            $(
                concat!("vldrb.s32 q7, [r1, #", $from, "]"),
                concat!("vmla.i32 ", $register, ", q7, r3"),
            )*
            "adds r1, #10",
            "le lr, 3b",
            "add r1, r1, {cells_on}",
            "add {errors}, {errors}, {errors_on}",
            "subs {rows}, {rows}, #1",
            "bne 2b",
            $(concat!("vstrw.32 ", $register, ", [r2, #", $from_bytes, "]"),)*
            inout("r1") $cells => _,
            in("r2") $sums.as_mut_ptr(),
            out("r3") _,
            errors = inout(reg) $under.errors => _,
            span = in(reg) $under.span,
            rows = inout(reg) $under.span => _,
            cells_on = in(reg) $under.cells_on,
            errors_on = in(reg) $under.errors_on,
            out("lr") _,
            $(out($register) _,)*
            out("q7") _,
            options(nostack),
        )
    };
}

impl Under {
    /// To the sums of two cells side by side.
    ///
    /// # Safety
    /// There are `span` rows of `span` errors, and of cells at these offsets; neither is 0.
    #[inline(never)]
    unsafe fn two_cells(&self, cells: *const i8, sums: &mut [i32; 2 * STEP]) {
        // SAFETY: the caller has seen to what is read; what is written are the sums.
        unsafe {
            add_products!(self, cells, sums: "q0" 0 0, "q1" 4 16, "q2" 8 32, "q3" 12 48, "q4" 16 64,);
        }
    }

    /// To those of one cell.
    ///
    /// # Safety
    /// As for [`Under::two_cells`].
    #[inline(never)]
    unsafe fn one_cell(&self, cells: *const i8, sums: &mut [i32; STEP]) {
        // SAFETY: as above.
        unsafe { add_products!(self, cells, sums: "q0" 0 0, "q1" 4 16, "q2" 6 24,) };
    }
}
