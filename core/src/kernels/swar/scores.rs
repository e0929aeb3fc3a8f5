//! Scores, distances, ranges and bounds for processors without DSP or SIMD: words of four pixels in ordinary 32-bit
//! registers (SWAR), and unrolled loops over bytes.
//!
//! A byte of a word holds the upper seven bits of a pixel. Its top bit is free for the result of a comparison:
//!
//! ```text
//! x + (127 - y) has the top bit set if x > y
//! ```
//!
//! Seven bits suffice for ranges and bounds, because a bound may be too large. Scores and distances need all eight
//! bits, so they process single bytes.
//!
//! These processors load words from multiples of four only, where the search stores ranges. Words of other rows are
//! shifted together from two aligned words.

use crate::image::Image;
use crate::kernels::cut_table::CutTable;
use crate::kernels::plain::scores::{self as plain, Plain};
use crate::kernels::rows::Rows;
#[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
use crate::kernels::scores::Effort;
use crate::kernels::scores::{Blocks, ONE, Scores};
use crate::kernels::unrolling::rolled;
use core::{mem, slice};

const LANES: usize = 4;

/// Masks of the lower seven bits and of the top bit of each byte.
const LOWER: u32 = 0x7F7F_7F7F;
const TOP: u32 = !LOWER;

/// Pixels in an iteration of the loops over bytes. On Cortex-M0+, where these loops hardly ever run, 4 save flash.
const UNROLLED: usize = if cfg!(target_arch = "arm") { 4 } else { 8 };

/// Maximum number of words in a row: each word adds at most 1 to each byte of a sum, which holds up to 255.
const MAX_WORDS: usize = 255;

/// Maximum number of bytes from a row of ranges to the next one, far more than a row of `MAX_WORDS` and a window take.
const MAX_STRIDE: usize = 1 << 14;

pub(crate) struct Swar<'a> {
    plain: Plain<'a>,
    /// Half the threshold, in each byte. It widens ranges, which consist of the upper seven bits of pixels.
    threshold: u32,
    #[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
    fours: Effort,
}

impl<'a> Swar<'a> {
    #[inline(always)]
    pub(crate) fn new(table: &'a CutTable) -> Self {
        Self {
            plain: Plain { table },
            threshold: u32::from(table.threshold() / 2) * 0x0101_0101,
            #[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
            fours: Effort::NEW,
        }
    }
}

impl Scores for Swar<'_> {
    #[inline(never)]
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        let rows = Rows::of(patch, template);
        let (mut reachable, of_row) = (rows.full_after(0), plain::full(rows.width));
        for y in 0..rows.height {
            let (f, g) = rows.row(y);
            // SAFETY: both pictures have `width` pixels there.
            reachable -= of_row - unsafe { row_score(f, g, rows.width, self.plain.table) };
            if reachable < floor {
                return None;
            }
        }
        Some(reachable).filter(|&score| score >= floor)
    }

    #[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
    /// # Safety
    /// The patch has at least as many rows as the template, and three more columns.
    #[inline(never)]
    unsafe fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
        if !self.fours.is_worth_it() {
            return wanted;
        }
        let rows = Rows::of(patch, template);
        let of_row = plain::full(rows.width);
        let mut reachable = [rows.full_after(0); OFFSETS];
        let mut candidates = wanted;
        for y in 0..rows.height {
            let (f, g) = rows.row(y);
            // SAFETY: the template has `width` pixels there, and the patch three more.
            let scores = unsafe { four_row_scores(f, g, rows.width, self.plain.table) };
            for (number, (reachable, score)) in rolled(reachable.iter_mut().zip(scores).enumerate()) {
                *reachable -= of_row - score;
                if *reachable < floor {
                    candidates &= !(1 << number);
                }
            }
            if candidates == 0 {
                break;
            }
        }
        self.fours.note(candidates != wanted);
        candidates
    }

    #[inline(never)]
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        let rows = Rows::of(patch, template);
        let mut sum = 0;
        for y in 0..rows.height {
            let (f, g) = rows.row(y);
            // SAFETY: both pictures have `width` pixels there.
            sum += unsafe { row_distance(f, g, rows.width) };
            if sum > enough {
                break;
            }
        }
        sum
    }

    #[inline(always)]
    fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        widened_ranges(rows, self.threshold, low, high);
    }

    #[inline(always)]
    fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        if self.plain.table.threshold() == 0 {
            return (floor == 0).then_some(0);
        }
        count_at_least(blocks, template, floor)
    }
}

/// The score of a template on black pixels.
#[cfg(smr_swar)]
#[inline(never)]
pub(crate) fn score_on_black(template: Image<'_>, table: &CutTable) -> u32 {
    let rows = Rows::of(template, template);
    let mut sum = 0;
    for y in 0..rows.height {
        let (_, g) = rows.row(y);
        // SAFETY: the template has `width` pixels there. The table is symmetrical.
        sum += unsafe { row_sum(g, g, rows.width, |_, g| table.of_pixels(g, 0).into()) };
    }
    sum
}

/// # Safety
/// `width` pixels can be read at `f` and at `g`.
#[inline(never)]
unsafe fn row_score(f: *const u8, g: *const u8, width: usize, table: &CutTable) -> u32 {
    // SAFETY: `width` pixels can be read at `f` and at `g`, and `row_sum` reads no others.
    unsafe { row_sum(f, g, width, |f, g| table.of_pixels(f, g).into()) }
}

/// Number of horizontally neighbouring offsets that are scored at once.
#[cfg(any(target_arch = "arm", target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
const OFFSETS: usize = 4;

/// The scores of a row of `width` pixels at four neighbouring offsets. The table offset of each frame pixel is computed
/// once for all template pixels that the frame pixel is compared with.
///
/// # Safety
/// `width` pixels can be read at `g`, and `width + 3` at `f`.
#[cfg(any(target_arch = "riscv32", target_arch = "riscv64", target_arch = "xtensa"))]
#[inline(never)]
unsafe fn four_row_scores(mut f: *const u8, mut g: *const u8, width: usize, table: &CutTable) -> [u32; OFFSETS] {
    let mut sums = [0; OFFSETS];
    // SAFETY: three pixels are read before the loops, and one more in each of the `width` columns. A signed difference
    // is -255 to 255, and entry 255 of 511 is that of no difference.
    unsafe {
        let equal = table.entries().as_ptr().add(255);
        // Table offset in bytes of a gray level, computed once for each pixel of the frame.
        let entries = |pixel: *const u8| size_of::<u16>() * usize::from(*pixel);
        let mut column = |pixels: [usize; OFFSETS], g: *const u8| {
            let of_black = equal.byte_sub(entries(g));
            for (sum, pixel) in sums.iter_mut().zip(pixels) {
                *sum += u32::from(*of_black.byte_add(pixel));
            }
        };
        let [mut a, mut b, mut c] = [entries(f), entries(f.add(1)), entries(f.add(2))];
        f = f.add(3);
        for _ in rolled(0..width / OFFSETS) {
            let d = entries(f);
            column([a, b, c, d], g);
            a = entries(f.add(1));
            column([b, c, d, a], g.add(1));
            b = entries(f.add(2));
            column([c, d, a, b], g.add(2));
            c = entries(f.add(3));
            column([d, a, b, c], g.add(3));
            // The last three frame pixels (`a` to `c`) are the first three of the next iteration.
            (f, g) = (f.add(OFFSETS), g.add(OFFSETS));
        }
        for _ in rolled(0..width % OFFSETS) {
            let d = entries(f);
            column([a, b, c, d], g);
            (a, b, c) = (b, c, d);
            (f, g) = (f.add(1), g.add(1));
        }
    }
    sums
}

/// The scores of a row at four neighbouring offsets, for Armv6-M. Sums are in high registers: only `add` works there.
///
/// # Safety
/// `width` pixels can be read at `g`, and `width + 3` at `f`.
#[cfg(target_arch = "arm")]
#[inline(never)]
unsafe fn four_row_scores(f: *const u8, g: *const u8, width: usize, table: &CutTable) -> [u32; OFFSETS] {
    /// Adds the similarities of four frame pixels and template pixel `$at`. The registers `$a` to `$d` hold twice the
    /// gray levels of the frame; `$d` is loaded here.
    macro_rules! column {
        ($at:literal $a:literal $b:literal $c:literal $d:literal) => {
            concat!(
                concat!("ldrb ", $d, ", [r0, #", $at, " + 3]\n", "lsls ", $d, ", ", $d, ", #1\n"),
                concat!("ldrb r3, [r1, #", $at, "]\n", "lsls r3, r3, #1\n", "mov r2, r12\n", "subs r2, r2, r3\n"),
                concat!("ldrh r3, [r2, ", $a, "]\n", "add r8, r3\n", "ldrh r3, [r2, ", $b, "]\n", "add r9, r3\n"),
                concat!("ldrh r3, [r2, ", $c, "]\n", "add r10, r3\n", "ldrh r3, [r2, ", $d, "]\n", "add lr, r3\n"),
            )
        };
    }
    let mut sums = [0; OFFSETS];
    // SAFETY: the rounds end at the last whole group of four columns. Entry 255 of 511 is that of no difference. Only
    // the sums and the stack are written. The stack keeps two addresses, and r6 and r7, which `asm!` may not name.
    unsafe {
        core::arch::asm!(
            "push {{r4, r5, r6, r7}}",
            "mov r12, r2",
            "movs r2, #0",
            "mov r8, r2",
            "mov r9, r2",
            "mov r10, r2",
            "mov lr, r2",
            "ldrb r4, [r0]",
            "ldrb r5, [r0, #1]",
            "ldrb r6, [r0, #2]",
            "lsls r4, r4, #1",
            "lsls r5, r5, #1",
            "lsls r6, r6, #1",
            "b 3f",
            "2:",
            column!(0 "r4" "r5" "r6" "r7"),
            column!(1 "r5" "r6" "r7" "r4"),
            column!(2 "r6" "r7" "r4" "r5"),
            column!(3 "r7" "r4" "r5" "r6"),
            "adds r0, #4",
            "adds r1, #4",
            "3:",
            "ldr r2, [sp]",
            "cmp r1, r2",
            "bne 2b",
            "ldr r2, [sp, #4]",
            "mov r3, r8",
            "str r3, [r2]",
            "mov r3, r9",
            "str r3, [r2, #4]",
            "mov r3, r10",
            "str r3, [r2, #8]",
            "mov r3, lr",
            "str r3, [r2, #12]",
            "add sp, #8",
            "pop {{r6, r7}}",
            inout("r0") f => _,
            inout("r1") g => _,
            inout("r2") table.entries().as_ptr().wrapping_add(255) => _,
            out("r3") _,
            inout("r4") g.wrapping_add(width / OFFSETS * OFFSETS) => _,
            inout("r5") sums.as_mut_ptr() => _,
            out("r8") _, out("r9") _, out("r10") _, out("r12") _, out("lr") _,
        );
        let done = width / OFFSETS * OFFSETS;
        if done < width {
            for (offset, sum) in rolled(sums.iter_mut().enumerate()) {
                *sum += row_score(f.add(done + offset), g.add(done), width - done, table);
            }
        }
    }
    sums
}

/// # Safety
/// `width` pixels can be read at `f` and at `g`.
#[inline(never)]
unsafe fn row_distance(f: *const u8, g: *const u8, width: usize) -> u32 {
    // SAFETY: `width` pixels can be read at `f` and at `g`, and `row_sum` reads no others.
    unsafe { row_sum(f, g, width, |f, g| f.abs_diff(g).into()) }
}

/// # Safety
/// `width` pixels can be read at `f` and at `g`.
#[inline(always)]
unsafe fn row_sum(mut f: *const u8, mut g: *const u8, width: usize, of: impl Fn(u8, u8) -> u32) -> u32 {
    let mut sum = 0;
    // SAFETY: both loops together read `width` pixels of each row.
    unsafe {
        for _ in rolled(0..width / UNROLLED) {
            for column in 0..UNROLLED {
                sum += of(*f.add(column), *g.add(column));
            }
            (f, g) = (f.add(UNROLLED), g.add(UNROLLED));
        }
        for column in rolled(0..width % UNROLLED) {
            sum += of(*f.add(column), *g.add(column));
        }
    }
    sum
}

/// Computes `low` = max(lowest pixel / 2 - t, 0) and `high` = max(127 - highest pixel / 2 - t, 0) for each 4x4 block.
/// Each byte of `threshold` is t, half of the table's threshold.
///
/// Takes the minimum and maximum of four rows in each column, then of two and of four columns.
#[inline(never)]
fn widened_ranges(rows: &[&[u8]; 4], threshold: u32, low: &mut [u8], high: &mut [u8]) {
    let (low, high) = (words_mut(low), words_mut(high));
    let [mut a, mut b, mut c, mut d] = rows.map(Words::new);
    let (mut least, mut most) = (Minima::default(), Minima::default());
    for word in 0..low.len() + Minima::DELAY {
        let half = |words: &mut Words<'_>| words.next() >> 1 & LOWER;
        let ((a, b), (c, d)) = (sorted(half(&mut a), half(&mut b)), sorted(half(&mut c), half(&mut d)));
        let (least, most) = (least.next(min(a, c)), most.next(LOWER ^ max(b, d)));
        let at = word.wrapping_sub(Minima::DELAY);
        if let (Some(low), Some(high)) = (low.get_mut(at), high.get_mut(at)) {
            (*low, *high) = (saturating_sub(least, threshold).to_le(), saturating_sub(most, threshold).to_le());
        }
    }
}

/// Sliding minimum over four neighbouring columns, one word of columns at a time.
#[derive(Default)]
struct Minima {
    /// The previous word of columns, and the minima of column pairs in the word before it.
    columns: u32,
    pairs: u32,
}

impl Minima {
    /// The result of [`Minima::next`] lags this many words behind its argument.
    const DELAY: usize = 2;

    #[inline(always)]
    fn next(&mut self, columns: u32) -> u32 {
        let pairs = min(self.columns, self.columns >> 8 | columns << 24);
        let fours = min(self.pairs, self.pairs >> 16 | pairs << 16);
        (self.columns, self.pairs) = (columns, pairs);
        fours
    }
}

/// max(a - b, 0) in each byte. Each byte of `a` is at most 127, of `b` at most 128.
#[inline(always)]
fn saturating_sub(a: u32, b: u32) -> u32 {
    let difference = (a | TOP) - b;
    let is_beyond = difference & TOP;
    difference & (is_beyond - (is_beyond >> 7))
}

#[inline(always)]
fn min(a: u32, b: u32) -> u32 {
    a - saturating_sub(a, b)
}

#[inline(always)]
fn max(a: u32, b: u32) -> u32 {
    b + saturating_sub(a, b)
}

#[inline(always)]
fn sorted(a: u32, b: u32) -> (u32, u32) {
    let beyond = saturating_sub(a, b);
    (a - beyond, b + beyond)
}

/// The whole words of a slice whose address is a multiple of four; no words for other addresses.
fn words_mut(bytes: &mut [u8]) -> &mut [u32] {
    if bytes.as_ptr().addr().is_multiple_of(LANES) {
        // SAFETY: this many words lie in the slice, aligned, and a u32 may have any value.
        unsafe { slice::from_raw_parts_mut(bytes.as_mut_ptr().cast(), bytes.len() / LANES) }
    } else {
        &mut []
    }
}

/// Reads a row word by word, from any address. Zeroes follow the end of the row.
struct Words<'a> {
    aligned: slice::Iter<'a, u32>,
    /// The bytes after the aligned words.
    end: u32,
    /// The aligned word that holds the next byte, and the number of bits before that byte.
    present: u32,
    shift: u32,
}

impl<'a> Words<'a> {
    #[inline(always)]
    fn new(row: &'a [u8]) -> Self {
        // SAFETY: a word may have any value.
        let (start, aligned, end) = unsafe { row.align_to::<u32>() };
        let before = row.as_ptr().addr() % LANES;
        let mut words = Self { aligned: aligned.iter(), end: joined(end), present: 0, shift: bits(before) };
        words.present = if before == 0 { words.next_aligned() } else { joined(start) << words.shift };
        words
    }

    #[inline(always)]
    fn next_aligned(&mut self) -> u32 {
        self.aligned.next().map_or_else(|| mem::take(&mut self.end), |&word| u32::from_le(word))
    }

    #[inline(always)]
    fn next(&mut self) -> u32 {
        let next = self.next_aligned();
        // Two shifts, because a shift by 32 would overflow.
        let word = self.present >> self.shift | next << 1 << (31 - self.shift);
        self.present = next;
        word
    }
}

#[allow(clippy::cast_possible_truncation)]
fn bits(bytes: usize) -> u32 {
    8 * bytes as u32
}

/// Joins up to three bytes to a word, the first one lowest.
fn joined(bytes: &[u8]) -> u32 {
    rolled(bytes.iter().rev()).fold(0, |word, &byte| word << 8 | u32::from(byte))
}

/// Upper bound of the score of every patch with pixels in the ranges `blocks`; `None` if it is below `floor`. Pixels
/// inside their ranges count as fully similar, and so do rows whose words reach beyond the template's memory. In
/// templates of at least seven columns, only the first and the last row can have such words.
#[inline(never)]
fn count_at_least(blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
    let (width, height) = (usize::from(template.width()), usize::from(template.height()));
    let full = plain::full(width * height);
    let allowed = full.checked_sub(floor)?;
    // Number of ranges in the first word that lie left of the template.
    let skipped = blocks.start % LANES;
    let count = (skipped + width).div_ceil(LANES);
    let from = blocks.start - skipped;
    let (low, high, (pixels, stride)) = (blocks.low, blocks.high, template.parts());
    let room = low.len().min(high.len());
    let are_aligned = (low.as_ptr().addr() | high.as_ptr().addr() | blocks.stride).is_multiple_of(LANES);
    if !are_aligned || count > MAX_WORDS || blocks.stride > MAX_STRIDE || from > room {
        return Some(full);
    }
    // Does not overflow 32 bits: at most 65,534 strides, a slice of less than 2^31 bytes, and 255 words.
    if from + (height - 1) * blocks.stride + count * LANES > room {
        return Some(full);
    }
    let mut row = RangeRow {
        low: low.as_ptr().wrapping_add(from).cast(),
        high: high.as_ptr().wrapping_add(from).cast(),
        count,
        first: TOP << (8 * skipped),
        last: TOP >> (8 * (count * LANES - skipped - width)),
    };
    let mut at = pixels.as_ptr().wrapping_sub(skipped);
    let (mut outside, pixels) = (0, pixels.as_ptr_range());
    for _ in rolled(0..height) {
        let before = at.addr() % LANES;
        let words = at.wrapping_sub(before);
        let words_end = words.wrapping_add(LANES * (count + usize::from(before > 0)));
        if words >= pixels.start && words_end <= pixels.end {
            // SAFETY: the words of the row lie within the ranges, and those of the template within its pixels.
            outside += unsafe {
                match before {
                    0 => row.outside::<false>(words.cast(), 0),
                    _ => row.outside::<true>(words.cast(), bits(before)),
                }
            };
            if outside * u32::from(ONE) > allowed {
                return None;
            }
        }
        at = at.wrapping_add(stride);
        (row.low, row.high) = (row.low.wrapping_byte_add(blocks.stride), row.high.wrapping_byte_add(blocks.stride));
    }
    Some(full - outside * u32::from(ONE))
}

/// Words in an iteration of the loop over a row of ranges. One word takes less flash.
const ROUND: usize = if cfg!(target_arch = "riscv32") { 2 } else { 1 };

struct RangeRow {
    low: *const u32,
    high: *const u32,
    /// Words in the row, at least one.
    count: usize,
    /// Masks (top bits) of the template's pixels in the first word and in the last word of the row.
    first: u32,
    last: u32,
}

impl RangeRow {
    /// Counts pixels of a template row that are not in their ranges. With `SHIFTED` the row begins `shift` bits after
    /// `g`.
    ///
    /// # Safety
    /// `count` words, at least one, can be read at `low`, `high` and `g`, which are aligned; with `SHIFTED` one more at
    /// `g`, and `shift` is 8, 16 or 24.
    #[allow(clippy::modulo_one)] // where a round is one word
    #[inline(never)]
    unsafe fn outside<const SHIFTED: bool>(&self, mut g: *const u32, shift: u32) -> u32 {
        let (mut low, mut high) = (self.low, self.high);
        let mut sum = 0;
        // SAFETY: `count` words are read in each row, and with `SHIFTED` the one after each of the template's.
        unsafe {
            let mut present = u32::from_le(*g);
            let mut outside = |low: *const u32, high: *const u32, g: *const u32| {
                let pixels = if SHIFTED {
                    let next = u32::from_le(*g.add(1));
                    let pixels = present >> shift | next << (32 - shift);
                    present = next;
                    pixels
                } else {
                    u32::from_le(*g)
                };
                let pixels = pixels >> 1 & LOWER;
                (u32::from_le(*low) + (LOWER ^ pixels)) | (u32::from_le(*high) + pixels)
            };
            let mut last = outside(low, high, g) & self.first;
            if let Some(between) = self.count.checked_sub(2) {
                sum = last >> 7;
                (low, high, g) = (low.add(1), high.add(1), g.add(1));
                for _ in rolled(0..between / ROUND) {
                    for word in rolled(0..ROUND) {
                        sum += (outside(low.add(word), high.add(word), g.add(word)) & TOP) >> 7;
                    }
                    (low, high, g) = (low.add(ROUND), high.add(ROUND), g.add(ROUND));
                }
                for _ in rolled(0..between % ROUND) {
                    sum += (outside(low, high, g) & TOP) >> 7;
                    (low, high, g) = (low.add(1), high.add(1), g.add(1));
                }
                last = outside(low, high, g);
            }
            sum += (last & self.last) >> 7;
        }
        let pairs = (sum & 0x00FF_00FF) + (sum >> 8 & 0x00FF_00FF);
        (pairs & 0xFFFF) + (pairs >> 16)
    }
}
