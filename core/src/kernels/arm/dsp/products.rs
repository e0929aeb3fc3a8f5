//! Sums of products by the DSP extension: `smlad` adds two products of 16-bit numbers.
//!
//! Both kernels slide rows of factors along rows of numbers. Up to five neighbouring sums share a factor. Numbers move
//! from the registers of one sum to the next, so each is loaded once. A factor is a pair of 16-bit numbers:
//!
//! - Responses: two channels of a cell. Rows of cells are unpacked, channels side by side.
//! - Gradient: the errors of two rows of offsets. A channel is unpacked as pairs of two rows of cells, or of
//!   differences.
//!
//! Both compute three sums of products instead of four (`three_sums.rs`). In the gradient, rows of errors take the role
//! of filter rows, and filter rows that of rows of offsets.

use crate::kernels::layout::{CHANNELS, Layout, PACKED, Packed};
use crate::kernels::plain::products as plain;
use crate::kernels::three_sums::{BOTH, PairedSizes, Rows, SUMS, Slide};
use crate::kernels::unrolling::rolled;
use core::arch::asm;
use core::ops::Range;

/// Bytes from a filter offset to the next one: the features of one cell, one byte each.
const STEP: usize = CHANNELS;
/// The shortest row that the assembly supports, in factors.
const MIN_FACTORS: usize = 4;
const PAIRS: usize = STEP / 2;
const WORD: usize = size_of::<i32>();

/// Computes filter responses, as [`plain::responses`] specifies. Pieces of work are pairs of rows of cells.
pub(crate) fn responses<const N: usize>(
    pieces: Range<usize>,
    room: &mut Packed,
    spare: &mut [i32],
    cells: &[i8],
    layout: Layout,
    weights: &[i16],
    out: &mut [[i32; N]],
) {
    let Layout { row, stride, span, .. } = layout;
    let down = layout.checked_height(cells.len(), weights.len()).unwrap_or(0);
    let (pairs, width, of_row) = (PairedSizes::new(down, span), row / STEP + span.saturating_sub(1), row / 2);
    let fits = down > 0 && row >= MIN_FACTORS * STEP && span <= N && out.len() >= span;
    let room_for = width * PAIRS + pairs.both() * N;
    if !fits || room_for > PACKED / 2 || pairs.rows_of_factors() * of_row > spare.len() {
        return plain::responses(layout.all_rows_in_first_piece(pieces), room, spare, cells, layout, weights, out);
    }
    if pieces.start == 0 {
        for number in 0..pairs.rows_of_factors() {
            let (first, second) = pairs.factors(number);
            let [first, second] =
                [first, second.unwrap_or(first)].map(|number| weights.as_ptr().wrapping_add(number * row));
            // SAFETY: the filter has these rows of `row` weights, and `spare` has `of_row` words for each row of
            // factors.
            unsafe { weights_by_channels(spare.as_mut_ptr().wrapping_add(number * of_row), row / STEP, first, second) };
        }
    }
    let (unpacked, both) = room.words().split_at_mut_checked(width * PAIRS).unwrap_or_default();
    let both = both.as_chunks_mut().0.get_mut(..pairs.both()).unwrap_or_default();
    let (cells, unpacked, factors) = (cells.as_ptr(), unpacked.as_mut_ptr(), spare.as_ptr());
    let mut rows = Unpacked { cells, stride, unpacked, width, factors, of_row };
    pairs.responses(pieces, &mut rows, both, out);
}

/// A row of cells, unpacked, and rows of factors that multiply it. `checked_height` has checked that all rows exist.
struct Unpacked {
    cells: *const i8,
    stride: usize,
    unpacked: *mut i32,
    width: usize,
    factors: *const i32,
    of_row: usize,
}

impl Rows for Unpacked {
    #[inline(always)]
    fn take(&mut self, first: usize, second: Option<usize>) {
        let of = |row: usize| self.cells.wrapping_add(row * self.stride);
        // SAFETY: `checked_height` found `width` cells in these rows, and `unpacked` has five words for each.
        unsafe { cells_by_channels(self.unpacked, self.width, of(first), second.map(of)) };
    }

    #[inline(always)]
    fn add(&mut self, number: usize, sums: &mut [i32]) {
        let Self { unpacked, width, of_row, .. } = *self;
        let factors = self.factors.wrapping_add(number * of_row);
        // SAFETY: five rows of at least `MIN_FACTORS` factors begin here. At each offset they lie on five rows of `width`
        // numbers.
        unsafe { Slide { factors, count: of_row / PAIRS, numbers: unpacked, width, rows: PAIRS }.add(sums) };
    }
}

/// Unpacks a row of `width` cells to pairs of channels: row `first`, minus row `second` if there is one. Writes each
/// pair for all cells before the next pair: the channels 0 and 2, 1 and 3, 4 and 6, 5 and 7, 8 and 9.
///
/// # Safety
/// `width` cells of ten bytes can be read at `first` and at `second`, and five words for each written at `to`. `width`
/// is not 0.
#[inline(never)]
unsafe fn cells_by_channels(to: *mut i32, width: usize, first: *const i8, second: Option<*const i8>) {
    static ZEROES: [i8; STEP] = [0; STEP];
    // SAFETY: a round takes ten bytes and writes five words, for each of the `width` cells. Without `second` the same
    // zeroes are read in each. Words need not be aligned.
    unsafe {
        asm!(
            "2:",
            "ldr {x}, [{first}], #4",
            "ldr {y}, [{second}]",
            "sxtb16 {u}, {x}",
            "sxtb16 {v}, {y}",
            "ssub16 {u}, {u}, {v}",
            "sxtb16 {x}, {x}, ror #8",
            "sxtb16 {y}, {y}, ror #8",
            "ssub16 {x}, {x}, {y}",
            "str {x}, [{to}, {width}]",
            "ldr {x}, [{first}], #4",
            "ldr {y}, [{second}, #4]",
            "sxtb16 {v}, {x}",
            "sxtb16 {x}, {x}, ror #8",
            "str {u}, [{to}], #4",
            "sxtb16 {u}, {y}",
            "ssub16 {u}, {v}, {u}",
            "sxtb16 {y}, {y}, ror #8",
            "ssub16 {x}, {x}, {y}",
            "str {x}, [{third}, {width}]",
            "str {u}, [{third}], #4",
            "ldrsb {x}, [{first}], #1",
            "ldrsb {y}, [{second}, #8]",
            "ldrsb {u}, [{first}], #1",
            "ldrsb {v}, [{second}, #9]",
            "subs {x}, {x}, {y}",
            "subs {u}, {u}, {v}",
            "pkhbt {x}, {x}, {u}, lsl #16",
            "str {x}, [{last}], #4",
            "add {second}, {second}, {step}",
            "subs {count}, {count}, #1",
            "bne 2b",
            first = inout(reg) first => _,
            second = inout(reg) second.unwrap_or(ZEROES.as_ptr()) => _,
            step = in(reg) if second.is_some() { STEP } else { 0 },
            to = inout(reg) to => _,
            third = inout(reg) to.wrapping_add(2 * width) => _,
            last = inout(reg) to.wrapping_add(4 * width) => _,
            width = in(reg) WORD * width,
            count = inout(reg) width => _,
            x = out(reg) _, y = out(reg) _, u = out(reg) _, v = out(reg) _,
            options(nostack),
        );
    }
}

/// Unpacks a row of weights to pairs of channels: the row `first`, plus the row `second` unless both are the same.
///
/// # Safety
/// `width` cells of ten weights can be read at `first` and at `second`, and five words for each written at `to`.
/// `width` is not 0.
#[inline(never)]
unsafe fn weights_by_channels(to: *mut i32, width: usize, first: *const i16, second: *const i16) {
    // SAFETY: a round takes ten weights and writes five words, for each of the `width` cells. Words need not be
    // aligned.
    unsafe {
        asm!(
            "2:",
            "mov {pairs}, {to}",
            "3:",
            "ldr {x}, [{first}], #4",
            "ldr {y}, [{second}], #4",
            "and {y}, {y}, {mask}",
            "sadd16 {x}, {x}, {y}",
            "ldr {u}, [{first}], #4",
            "ldr {y}, [{second}], #4",
            "and {y}, {y}, {mask}",
            "sadd16 {u}, {u}, {y}",
            "pkhbt {y}, {x}, {u}, lsl #16",
            "str {y}, [{pairs}]",
            "pkhtb {x}, {u}, {x}, asr #16",
            "str {x}, [{pairs}, {width}]",
            "add {pairs}, {pairs}, {width}, lsl #1",
            "eors {again}, {again}, #1",
            "bne 3b",
            "ldr {x}, [{first}], #4",
            "ldr {y}, [{second}], #4",
            "and {y}, {y}, {mask}",
            "sadd16 {x}, {x}, {y}",
            "str {x}, [{pairs}]",
            "adds {to}, #4",
            "subs {count}, {count}, #1",
            "bne 2b",
            first = inout(reg) first => _,
            second = inout(reg) second => _,
            to = inout(reg) to => _,
            width = in(reg) WORD * width,
            count = inout(reg) width => _,
            mask = in(reg) -i32::from(first != second),
            again = inout(reg) 0 => _,
            pairs = out(reg) _, x = out(reg) _, y = out(reg) _, u = out(reg) _,
            options(nostack),
        );
    }
}

/// Unpacks a channel of two rows of `width` cells to pairs of 16-bit numbers, one from each row. Takes the rows
/// `first`, and subtracts the rows `second` unless `whole`.
///
/// # Safety
/// At each address in `first`, and unless `whole` in `second`, a byte can be read in each of `width` cells, ten bytes
/// apart. `width` words can be written at `to`. `width` is not 0.
#[inline(always)]
unsafe fn pairs_of_rows(to: *mut i32, width: usize, first: [*const i8; 2], second: [*const i8; 2], whole: bool) {
    // SAFETY: a round takes two or four bytes and writes a word, for each of the `width` cells.
    unsafe {
        asm!(
            "2:",
            "ldrsb {x}, [{upper}], #10\nldrsb {y}, [{lower}], #10",
            "cbnz r1, 3f",
            "ldrsb {u}, [{less_upper}], #10\nldrsb {v}, [{less_lower}], #10",
            "subs {x}, {x}, {u}\nsubs {y}, {y}, {v}",
            "3:",
            "subs {count}, {count}, #1",
            "pkhbt {x}, {x}, {y}, lsl #16",
            "str {x}, [{to}], #4",
            "bne 2b",
            upper = inout(reg) first[0] => _,
            lower = inout(reg) first[1] => _,
            less_upper = inout(reg) second[0] => _,
            less_lower = inout(reg) second[1] => _,
            in("r1") usize::from(whole), // `cbnz` takes a low register
            to = inout(reg) to => _,
            count = inout(reg) width => _,
            x = out(reg) _, y = out(reg) _, u = out(reg) _, v = out(reg) _,
            options(nostack),
        );
    }
}

pub(crate) const TAKES_ROWS_OF_CELLS: bool = true;
pub(crate) const GATHER_PIECES: Option<usize> = Some(SUMS * STEP);

/// Adds the gradient of the filter's error to `sums`, as [`plain::gather`] specifies. A piece of work is one channel of
/// one of the three partial sums in `three_sums.rs`.
///
/// An error is at most 16,383, and two of them add up to at most 32,766, which fits in 16 bits. A difference of two
/// features takes 9 bits. Each of the three sums is at most 17 * 9 * 32,766 * 128 < 2^30.
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
    let down = layout.checked_height(cells.len(), sums.len()).unwrap_or(0);
    let (by_two, across) = (PairedSizes::new(span, down), row / STEP);
    let width = across + span.saturating_sub(1);
    let (factors, numbers) = room.words().split_at_mut_checked((by_two.rows_of(0) + 1) * span).unwrap_or_default();
    let fits = down > 0 && span >= MIN_FACTORS && span <= N && errors.len() >= span;
    let has_room = (by_two.rows_of(0) + by_two.offsets_of(0)) / 2 * width <= numbers.len();
    let (true, Some(of_row)) = (fits && has_room, spare.get_mut(..across)) else {
        return plain::gather(layout.all_rows_in_first_piece(pieces), room, spare, cells, layout, errors, sums);
    };
    let (numbers, sums) = (numbers.as_mut_ptr(), sums.as_mut_ptr());
    for piece in pieces.start..pieces.end.min(SUMS * STEP) {
        let (sum_of, channel) = (piece / STEP, piece % STEP);
        let (rows, offsets) = (by_two.rows_of(sum_of), by_two.offsets_of(sum_of));
        // At odd vertical offsets, the first row of errors lies on the second row of a pair of rows of cells.
        let odd_rows = rows.div_ceil(2);
        if channel == 0 {
            factors.fill(0);
            for (y, errors) in errors.iter().enumerate().take(span) {
                if sum_of != BOTH && sum_of / 2 != y % 2 {
                    continue;
                }
                let mut half = |row: usize, first: usize| {
                    factors.as_mut_ptr().wrapping_add((first + row / 2) * span).cast::<i16>().wrapping_add(row % 2)
                };
                let (mut even, mut odd) = (half(y / 2, 0), half(y / 2 + 1, odd_rows));
                for error in rolled(errors.iter().take(span)) {
                    // SAFETY: `factors` has `rows_of(0)` + 1 rows of `span` pairs; at most so many are at even and odd
                    // offsets.
                    unsafe { (*even, *odd) = (*even + error, *odd + error) };
                    (even, odd) = (even.wrapping_add(2), odd.wrapping_add(2));
                }
            }
        }
        // An index beyond the last row of cells reads the last row instead. The products of this substitute cancel: the
        // sum `both` adds them, and the sums `upper` and `lower` subtract them.
        let channel_of = |row: usize| cells.as_ptr().wrapping_add(row.min(down + span - 2) * stride + channel);
        for number in 0..(rows + offsets) / 2 {
            let of = |row| channel_of(4 * number + row);
            let (first, second) = ([of(sum_of), of(sum_of + 2)], [of(1), of(3)]);
            // SAFETY: `checked_height` found `width` cells in these rows, and `has_room` room for so many rows of
            // numbers.
            unsafe { pairs_of_rows(numbers.wrapping_add(number * width), width, first, second, sum_of == BOTH) };
        }
        for at in 0..offsets {
            let factors = factors.as_ptr().wrapping_add(at % 2 * odd_rows * span);
            let numbers = numbers.wrapping_add(at / 2 * width);
            of_row.fill(0);
            // SAFETY: each row has `span` factors, at least `MIN_FACTORS`, and `width` numbers under them at all `across`
            // offsets.
            unsafe { Slide { factors, count: span, numbers, width, rows: (rows + 1 + at % 2) / 2 }.add(of_row) };
            let first = 2 * at + sum_of / 2;
            for at in first..down.min(first + 1 + usize::from(sum_of == BOTH)) {
                let mut to = sums.wrapping_add(at * row + channel);
                for sum in rolled(of_row.iter()) {
                    // SAFETY: there is a sum for each of the `row` weights in each of the `down` rows.
                    unsafe { *to += sum };
                    to = to.wrapping_add(STEP);
                }
            }
        }
    }
}

impl Slide<i32> {
    /// Adds to `sums[i]`, for each row, the dot product of its factors and its numbers from index `i` on.
    ///
    /// # Safety
    /// `rows` rows of `count` factors can be read at `factors`, one after the other. Of as many rows at `numbers`,
    /// `width` apart, `count + sums.len() - 1` numbers can be read. `count` is at least `MIN_FACTORS`, `rows` is not 0.
    #[inline(never)]
    unsafe fn add(mut self, sums: &mut [i32]) {
        let (mut to, mut left) = (sums.as_mut_ptr(), sums.len());
        while left > 0 {
            // SAFETY: no function takes more than the `left` sums, whose numbers lie in the rows. There is none for
            // three sums, because it would hardly ever run.
            let done = unsafe {
                match left {
                    1 => self.one(to),
                    2 | 3 => self.two(to),
                    4 | 6 | 8 | 12 | 16 => self.four(to),
                    _ => self.five(to),
                }
            };
            (to, left) = (to.wrapping_add(done), left - done);
            self.numbers = self.numbers.wrapping_add(done);
        }
    }
}

/// Adds to each sum the two products of a pair of numbers and a pair of factors.
macro_rules! add {
    ($($sum:literal $number:literal $factor:literal,)*) => {
        concat!($("smlad ", $sum, ", ", $number, ", ", $factor, ", ", $sum, "\n",)*)
    };
}

/// Defines a function that adds products to n sums. In each row, steps of one and two take the first `count % 4`
/// factors, then steps of four the rest. After a step of one or two, the first numbers (`$window`) are loaded again. A
/// step of four decrements the counter of factors where it would otherwise wait for its first load.
macro_rules! slide {
    ($name:ident $n:literal: $load:literal $store:literal $window:literal; $one:expr; $two:expr; $four:expr) => {
        impl Slide<i32> {
            /// # Safety
            /// `rows` rows of `count` factors can be read at `factors`, one after the other. Of as many rows at
            /// `numbers`, `width` apart, `count + n - 1` numbers can be read. `count` is at least `MIN_FACTORS`, `rows` is
            /// not 0. n sums can be read and written at `sums`. All addresses are aligned.
            #[inline(never)]
            unsafe fn $name(&self, sums: *mut i32) -> usize {
                let Self { factors, count, numbers, width, rows } = *self;
                // SAFETY: of each row `count` factors and `count + n - 1` numbers are read. Only the n sums and the
                // stack are written. The stack keeps r6 and r7, which `asm!` may not name, and what each row needs.
                unsafe {
                    asm!(
                        "push {{r0, r5, r8, r11}}",
                        "push {{r6, r7}}",
                        $load,
                        "2:",
                        "ldr r11, [sp, #20]",
                        $window,
                        // Moves the two lowest bits of the factor count to the sign and the carry.
                        "lsls r7, r11, #31",
                        "bpl 3f",
                        $one,
                        $window,
                        "3:",
                        "bcc 4f",
                        $two,
                        $window,
                        "4:",
                        $four,
                        "bhs 4b",
                        "ldrd r6, r7, [sp, #12]",
                        "add lr, lr, r6",
                        "cmp r12, r7",
                        "bne 2b",
                        "pop {{r6, r7}}",
                        "ldr r5, [sp]",
                        $store,
                        "add sp, sp, #16",
                        inout("r0") sums => _,
                        // Bytes from the end of the numbers that are read in one row to the start of the next row.
                        inout("r5") WORD * width.wrapping_sub(count + $n - 1) => _,
                        inout("r8") factors.wrapping_add(rows * count) => _,
                        // The factor count less four: not negative, with the same two lowest bits.
                        inout("r11") count.wrapping_sub(MIN_FACTORS) => _,
                        inout("r12") factors => _,
                        inout("lr") numbers => _,
                        out("r1") _, out("r2") _, out("r3") _, out("r4") _, out("r9") _, out("r10") _,
                    );
                }
                $n
            }
        }
    };
}

macro_rules! count {
    () => {
        "subs r11, r11, #4\n"
    };
}

/// Adds the products of two factors (r6 and r7) to two sums (r0 and r1). On entry, r5 holds the number that is
/// multiplied by r6 for r0. On exit, it holds the number two places further.
macro_rules! two {
    ($move:literal; $between:expr) => {
        concat!(
            "ldrd r6, r7, [r12], #8\n",
            $between,
            add!("r0" "r5" "r6",),
            "ldrd r8, r5, [lr], #", $move, "\n",
            add!("r1" "r8" "r6", "r0" "r8" "r7", "r1" "r5" "r7",),
        )
    };
}

/// Adds the products of two factors to four sums. Registers a, b, c hold numbers on entry, and c, d, a on exit.
macro_rules! four {
    ($a:literal $b:literal $c:literal $d:literal $move:literal; $between:expr) => {
        concat!(
            "ldrd r6, r7, [r12], #8\n",
            $between,
            add!("r0" $a "r6",),
            "ldrd ", $d, ", ", $a, ", [lr], #", $move, "\n",
            add!("r1" $b "r6", "r2" $c "r6", "r0" $b "r7", "r1" $c "r7", "r3" $d "r6", "r2" $d "r7", "r3" $a "r7",),
        )
    };
}

/// Adds the products of two factors to five sums. Registers a to d hold numbers on entry, and c, d, a, b on exit.
macro_rules! five {
    ($a:literal $b:literal $c:literal $d:literal $move:literal; $between:expr) => {
        concat!(
            "ldrd r6, r7, [r12], #8\n",
            $between,
            add!("r0" $a "r6", "r1" $b "r6", "r0" $b "r7",),
            "ldrd ", $a, ", ", $b, ", [lr], #", $move, "\n",
            add!(
                "r2" $c "r6", "r1" $c "r7", "r3" $d "r6", "r2" $d "r7", "r4" $a "r6", "r3" $a "r7", "r4" $b "r7",
            ),
        )
    };
}

slide! {
    one 1: "ldr r0, [r0]" "str r0, [r5]" "";
    concat!("ldr r6, [r12], #4\n", "ldr r7, [lr], #4\n", add!("r0" "r6" "r7",));
    concat!("ldrd r6, r7, [r12], #8\n", "ldrd r5, r8, [lr], #8\n", add!("r0" "r5" "r6", "r0" "r8" "r7",));
    concat!(
        "ldrd r6, r7, [r12], #8\n", "ldrd r5, r8, [lr], #8\n", count!(), add!("r0" "r5" "r6", "r0" "r8" "r7",),
        "ldrd r6, r7, [r12], #8\n", "ldrd r5, r8, [lr], #8\n", add!("r0" "r5" "r6", "r0" "r8" "r7",),
    )
}
slide! {
    two 2: "ldrd r0, r1, [r0]" "strd r0, r1, [r5]" "ldr r5, [lr], #4";
    concat!("ldr r6, [r12], #4\n", "ldr r7, [lr]\n", add!("r0" "r5" "r6", "r1" "r7" "r6",));
    two!("4"; "");
    concat!(two!("8"; count!()), two!("8"; ""))
}
slide! {
    four 4: "ldm r0, {{r0-r3}}" "stm r5, {{r0-r3}}" "ldm lr!, {{r5, r8, r9}}";
    concat!(
        "ldr r6, [r12], #4\n", "ldr r7, [lr], #-8\n",
        add!("r0" "r5" "r6", "r1" "r8" "r6", "r2" "r9" "r6", "r3" "r7" "r6",)
    );
    four!("r5" "r8" "r9" "r10" "-4"; "");
    concat!(four!("r5" "r8" "r9" "r10" "8"; count!()), four!("r9" "r10" "r5" "r8" "8"; ""))
}
slide! {
    five 5: "ldm r0, {{r0-r4}}" "stm r5, {{r0-r4}}" "ldm lr!, {{r5, r8-r10}}";
    concat!(
        "ldr r6, [r12], #4\n", "ldr r7, [lr], #-12\n",
        add!("r0" "r5" "r6", "r1" "r8" "r6", "r2" "r9" "r6", "r3" "r10" "r6", "r4" "r7" "r6",)
    );
    five!("r5" "r8" "r9" "r10" "-8"; "");
    concat!(five!("r5" "r8" "r9" "r10" "8"; count!()), five!("r9" "r10" "r5" "r8" "8"; ""))
}
