//! Cells of gradient orientations by Helium: four cells at a time. The plain loops are in `plain/gradients.rs`.

use crate::kernels::layout::{CELL, CHANNELS, SIDE};
use crate::kernels::plain::gradients::DIRECTIONS;
use core::arch::asm;
use core::mem::MaybeUninit;

const LANES: usize = 4;
/// Number of sectors: five for gradients whose x and y have equal signs, each between two neighbouring directions, and
/// their five mirror images (x negated) for gradients whose x and y differ in sign.
const SECTORS: usize = 10;
/// Lookup tables of the assembly, which depends on their offsets.
#[repr(C, align(4))]
struct Tables([u8; 256], [[u8; 16]; 6]);
static TABLES: Tables = Tables(
    largest_beyond(DIRECTIONS[2]),
    [
        // For each of the 16 pixels in a row of four cells, the index in `Memory::sectors` of its cell's sector 0.
        [20, 20, 20, 20, 21, 21, 21, 21, 22, 22, 22, 22, 23, 23, 23, 23],
        // Factors of |y| in the comparisons with the directions 1, 3 and 4.
        [191; 16],
        [79; 16],
        [105; 16],
        // For each of the 16 pixels, the sum of two indices: of any sector and of its mirror image. The last row holds
        // byte offsets of the pixels in `Memory::pixels`.
        [36, 36, 36, 36, 38, 38, 38, 38, 40, 40, 40, 40, 42, 42, 42, 42],
        [0, 16, 32, 48, 2, 18, 34, 50, 4, 20, 36, 52, 6, 22, 38, 54],
    ],
);
/// Factors of the votes for directions 5 to 8, then 0 to 4. A vote is a sum over two neighbouring sectors in
/// `Memory::sectors`: each sector's number |y| + 65,536 |x| times its first factor, plus |x| times its second.
static FACTORS: [[[i32; 2]; 2]; SECTORS - 1] = {
    const fn distance(beyond: bool, (cos, sin): (i32, i32)) -> [i32; 2] {
        if beyond { [cos, -sin - (cos << 16)] } else { [-cos, sin + (cos << 16)] }
    }
    let [zero, one, two, three, four, five] = DIRECTIONS;
    [
        [distance(true, four), distance(true, three)], // the first entry is sector 4 with the mirrored one
        [distance(false, four), distance(true, two)],
        [distance(false, three), distance(true, one)],
        [distance(false, two), distance(true, zero)],
        [distance(false, one), distance(false, one)],
        [distance(true, zero), distance(false, two)],
        [distance(true, one), distance(false, three)],
        [distance(true, two), distance(false, four)],
        [distance(true, three), distance(false, five)],
    ]
};

/// Scratch memory of the assembly, which depends on the offsets of the fields.
#[repr(C, align(4))]
#[allow(dead_code)] // the assembly reads it
struct Memory {
    /// Gradients of a row of pixels: `[pixel of a cell][kind][cell][byte]`. Kind 0 holds the bytes |y| and |x|. Kind 1
    /// holds the index of the pair in `sectors` to which they are added, and a zero byte.
    pixels: [[[[u8; 2]; LANES]; 2]; CELL as usize],
    /// Sums `[sector][cell][|y|, |x|]`: first sectors 4 to 0 of gradients whose x and y differ in sign, then sectors 0
    /// to 4 of those with equal signs, so that two sectors next to each other vote for a common direction.
    sectors: [[[u16; 2]; LANES]; SECTORS],
}

#[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)] // at most 255
const fn largest_beyond((cos, sin): (i32, i32)) -> [u8; 256] {
    let mut largest = [0; 256];
    let mut up = 1;
    while up < largest.len() {
        let right = (cos * up as i32 - 1) / sin;
        largest[up] = if right < 255 { right as u8 } else { 255 };
        up += 1;
    }
    largest
}

/// Adds 4 (one sector) to the index in q1 if |x| (q0) is at most `$most`: the gradient is beyond a direction.
macro_rules! beyond {
    ($most:literal) => {
        concat!("vpt.u8 cs, ", $most, ", q0\nvaddt.i8 q1, q1, r8\n")
    };
}

/// Adds q1 (the gradient of one pixel in each of four cells) to the sectors at `$index`. Then loads the next gradients,
/// at `$at`, to q1, and the indices of their sectors to `$next`.
macro_rules! add {
    ($index:literal, $next:literal, $at:literal) => {
        concat!(
            concat!("vldrw.u32 q2, [r11, ", $index, ", uxtw #2]\n"),
            concat!("vldrh.u32 ", $next, ", [r1, #", $at, " + 8]\n"),
            "vadd.i16 q2, q2, q1\n",
            concat!("vldrb.u16 q1, [r1, #", $at, "]\n"),
            concat!("vstrw.32 q2, [r11, ", $index, ", uxtw #2]\n"),
        )
    };
}

/// Computes channel sums and energies as the plain loop does, four cells at a time. May write up to three cells beyond
/// `across`, if the slices have room, and leaves out cells without room.
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    let Some(sums) = sums.first_chunk_mut::<CHANNELS>() else { return };
    let mut memory = MaybeUninit::<Memory>::uninit();
    let blocks = across.div_ceil(LANES).min(ROW / LANES).min(COLUMNS.saturating_sub(2) / (LANES * usize::from(CELL)));
    for block in 0..blocks {
        let (first, at) = (block * LANES, LANES * block * usize::from(CELL));
        let to = memory.as_mut_ptr().cast::<u8>();
        // SAFETY: 18 pixels of each of six lines are read, four sums of each row and four energies are written from
        // `first` on: `blocks` have room for them. All of `memory` is written before it is read, `pixels` at the
        // offsets in `TABLES`, so each index is one in `sectors`.
        unsafe {
            asm!(
                "vmov.i32 q6, #0",
                "dls lr, lr",
                "2:",
                "vstrw.32 q6, [r2], #16",
                "le lr, 2b",
                "vldrw.u32 q7, [r3, #336]",
                "add r2, r1, #1",
                "add r4, r1, #8",
                "add r11, r1, #64",
                "dls lr, r8",
                "2:",
                // Computes the gradients of 16 pixels and the indices of their sectors. r10 points one row above the
                // pixels, then to them; r5 points one row below. A gradient is beyond direction 1, 3 or 4 if |x| is at
                // most a multiple of |y|. Loads alternate with arithmetic, because the processor does both at once.
                "vldrb.u8 q2, [r10]",
                "add r10, r10, #{line}",
                "add r5, r10, #{line}",
                "vldrb.u8 q3, [r5]",
                "vldrb.u8 q0, [r10, #-1]",
                "vabd.u8 q5, q2, q3",
                "vldrb.u8 q1, [r10, #1]",
                "vhsub.u8 q3, q3, q2", // the top bit is the sign
                "vldrw.u32 q2, [r3, #272]",
                "vhsub.u8 q4, q1, q0",
                "vmulh.u8 q2, q2, q5",
                "vabd.u8 q0, q0, q1",
                "vstrb.8 q5, [r1, q7]",
                "vqadd.u8 q2, q2, q5",
                "vstrb.8 q0, [r2, q7]",
                "vqadd.u8 q2, q2, q5",
                "vldrw.u32 q1, [r3, #256]",
                beyond!("q2"),
                "vldrb.u8 q2, [r3, q5]",
                // Selects mirrored sectors if x and y differ in sign. If x or y is 0, both choices give the same votes.
                "veor q4, q4, q3",
                beyond!("q2"),
                "vldrw.u32 q3, [r3, #288]",
                "vmulh.u8 q3, q3, q5",
                "vldrw.u32 q2, [r3, #304]",
                "vshr.u8 q3, q3, #1",
                "vmulh.u8 q2, q2, q5",
                "vhadd.u8 q3, q3, q5",
                "vhadd.u8 q2, q2, q5",
                beyond!("q3"),
                "vshr.u8 q2, q2, #2",
                "vldrw.u32 q3, [r3, #320]",
                beyond!("q2"),
                "vpt.s8 lt, q4, zr",
                "vsubt.i8 q1, q3, q1",
                "vstrb.8 q1, [r4, q7]",
                // Adds the gradients to sectors, and gray levels to q6: two neighbouring pixels in each 16-bit lane.
                "vldrh.u32 q0, [r1, #8]",
                "vldrb.u8 q3, [r10]",
                "vldrb.u16 q1, [r1]",
                "vmovlb.u8 q5, q3",
                add!("q0", "q4", 16),
                "vadd.i16 q6, q6, q5",
                add!("q4", "q0", 32),
                "vmovlt.u8 q3, q3",
                add!("q0", "q4", 48),
                "vadd.i16 q6, q6, q3",
                "vldrw.u32 q2, [r11, q4, uxtw #2]",
                "vadd.i16 q2, q2, q1",
                "vstrw.32 q2, [r11, q4, uxtw #2]",
                "le lr, 2b",
                "vshr.u32 q1, q6, #16",
                "vadd.i16 q6, q6, q1",
                "vstrh.32 q6, [r0]",
                "sub r0, r0, #4 * {row}",
                // Sector 4 and its mirror image both vote for directions 4 and 5, with equal factors of |y| and
                // opposite factors of |x|. So one pair replaces the pairs of both: |y| of sector 4 plus |y| of the
                // image, and |x| of sector 4 minus |x| of the image.
                "vldrw.u32 q0, [r11]",
                "vldrw.u32 q1, [r11, #144]",
                "mvn r2, #0",
                "lsl r2, r2, #17",
                "vshr.u32 q2, q0, #16",
                "vadd.i32 q1, q1, q0",
                "vmla.i32 q1, q2, r2",
                "vstrw.32 q1, [r11]",
                "vstrw.32 q1, [r11, #144]",
                "vmov.i32 q3, #0",
                "vmov.i32 q6, #0",
                "vldrw.u32 q1, [r11], #16",
                "mov lr, #9",
                "dls lr, lr",
                "2:",
                "ldm r9!, {{r2, r3, r4, r5}}",
                "vldrw.u32 q2, [r11]",
                "vmul.i32 q0, q1, r2",
                "vshr.s32 q1, q1, #16",
                "vmla.i32 q0, q2, r4",
                "vshr.s32 q2, q2, #16",
                "vmla.i32 q0, q1, r3",
                "vldrw.u32 q1, [r11], #16",
                "vadd.i32 q6, q6, q3",
                "vmla.i32 q0, q2, r5",
                "vshr.u32 q3, q0, #6",
                "vstrh.32 q3, [r0], #{row}",
                "vshr.u32 q3, q3, #2",
                "cmp lr, #6",
                "it eq",
                "subeq r0, r0, #9 * {row}", // after direction 8
                "vmul.i32 q3, q3, q3",
                "le lr, 2b",
                "vadd.i32 q6, q6, q3",
                "vstrw.32 q6, [r12]",
                inout("r0") sums.as_mut_ptr().cast::<u16>().wrapping_add((CHANNELS - 1) * ROW + first) => _,
                in("r1") to, inout("r2") to => _,
                inout("r3") &raw const TABLES => _,
                in("r8") 4,
                inout("r9") &raw const FACTORS => _,
                inout("r10") lines.as_ptr().cast::<u8>().wrapping_add(at + 1) => _,
                in("r12") energies.as_mut_ptr().wrapping_add(first),
                inout("lr") size_of::<Memory>() / 16 => _,
                out("r4") _, out("r5") _, out("r11") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _,
                out("q5") _, out("q6") _, out("q7") _,
                row = const 2 * ROW,
                line = const COLUMNS,
                options(nostack),
            );
        }
    }
}

/// Computes the features of a row of cells, up to the length of `out`: nine gradients `min(sum * inverse >> 16, 127)`,
/// and `(gray >> 4) - 128`. No product reaches 2^32.
pub(crate) fn features<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    let Some(sums) = sums.first_chunk::<CHANNELS>() else { return };
    const { assert!(ROW.is_multiple_of(8)) };
    if out.is_empty() || out.len() > ROW {
        return;
    }
    // SAFETY: sums and inverses are read for eight cells at a time, and ROW is a multiple of eight. Features are
    // written only for the cells in `out`.
    unsafe {
        asm!(
            "vldrh.u16 q7, [r3]",
            "vmov.i16 q6, #127",
            "1:",
            "vld20.16 {{q0, q1}}, [r1]\nvld21.16 {{q0, q1}}, [r1]!",
            "vctp.16 r4",
            "mov r5, r0",
            "mov r8, r2",
            "mov lr, #9",
            "dls lr, lr",
            "2:",
            "vldrh.u16 q2, [r5], #{row}",
            // sum * inverse >> 16, as sum * (upper half of inverse) + (sum * (lower half) >> 16).
            "vmulh.u16 q3, q2, q0",
            "vmul.i16 q2, q2, q1",
            "vadd.i16 q2, q2, q3",
            "vmin.u16 q2, q2, q6",
            "vpst\nvstrbt.16 q2, [r8, q7]",
            "adds r8, #1",
            "le lr, 2b",
            "vldrh.u16 q2, [r5]",
            "vshr.u16 q2, q2, #4",
            "vsub.i16 q2, q2, r9",
            "vpst\nvstrbt.16 q2, [r8, q7]",
            "adds r0, #16",
            "adds r2, #80",
            "subs r4, #8",
            "bgt 1b",
            inout("r0") sums.as_ptr() => _,
            inout("r1") inverses.as_ptr() => _,
            inout("r2") out.as_mut_ptr() => _,
            in("r3") &raw const super::CELLS,
            inout("r4") out.len() => _,
            out("r5") _, out("r8") _,
            in("r9") 128,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q6") _, out("q7") _,
            row = const 2 * ROW,
            options(nostack),
        );
    }
}

/// Replaces each energy in `columns` by `of(norm)`, with the norm of its cell, as the plain loop does.
///
/// For n cells and an energy below 2^29, the product with 2^32 / n, rounded up, gives the exact mean. For x = number *
/// 4^h / 2^32, from 1/4 to 1, y = 1 / sqrt(x) begins as a polynomial, within 4 %. Each Newton step computes y (x y^2 -
/// 3) / 2, the better y with the opposite sign, so two steps restore the sign. y ends a little too small, and the root
/// is right or too small by 1.
#[inline(always)]
pub(crate) fn norms(columns: &mut [u32], rows: u32, of: impl Fn(u32) -> u32) {
    let per = |cells: u32| u32::MAX / cells.max(1) + 1;
    // SAFETY: the loop is predicated: it reads and writes the columns only.
    unsafe {
        asm!(
            "vdup.32 q5, {edge}",
            "vmov.i32 q6, #1",
            "wlstp.32 lr, lr, 3f",
            "2:",
            // Loads the next column to the right, 0 beyond the edge.
            "vctp.32 {right}",
            "vmov q3, q5",
            "vpstt\nvldrwt.u32 q1, [{columns}, #4]",
            "vdupt.32 q3, {inner}",
            "vldrw.u32 q0, [{columns}]",
            "vmov.32 q3[0], {first}",
            "vmov q2, q0",
            "vshlc q2, {left}, #32",
            "vadd.i32 q0, q0, q1",
            "vadd.i32 q0, q0, q2",
            "vmulh.u32 q0, q0, q3",
            "vshl.i32 q0, q0, #6",
            "vclz.i32 q1, q0",
            "vshr.u32 q1, q1, #1", // h
            "vadd.i32 q2, q1, q1",
            "vshl.u32 q2, q0, q2",
            "vshr.u32 q2, q2, #1", // x, times 2^31
            "vqdmulh.s32 q3, q2, {c}",
            "vadd.i32 q3, q3, {b}",
            "vqdmulh.s32 q3, q3, q2",
            "vadd.i32 q3, q3, {a}", // y, times 2^29
            ".rept 2", // Newton steps
            "vqdmulh.s32 q4, q3, q3",
            "vqdmulh.s32 q4, q4, q2",
            "vadd.i32 q4, q4, {three}",
            "vqdmulh.s32 q3, q3, q4",
            "vshl.i32 q3, q3, #3",
            ".endr",
            "vqdmulh.s32 q3, q3, q2",
            "vneg.s32 q1, q1",
            "vshl.u32 q3, q3, q1",
            "vshr.u32 q3, q3, #13",
            "vadd.i32 q1, q3, q6",
            "vmul.i32 q2, q1, q1",
            "vpt.u32 cs, q0, q2\nvaddt.i32 q3, q3, q6",
            "vstrw.32 q3, [{columns}], #16",
            "subs {right}, {right}, #4",
            "csel {first}, {inner}, {edge}, gt",
            "letp lr, 2b",
            "3:",
            inout("lr") columns.len() => _,
            columns = inout(reg) columns.as_mut_ptr() => _,
            right = inout(reg) columns.len().wrapping_sub(1) => _,
            left = inout(reg) 0 => _,
            first = inout(reg) per(2 * rows) => _,
            edge = in(reg) per(2 * rows),
            inner = in(reg) per(3 * rows),
            a = in(reg) 171 << 23,
            b = in(reg) -(210 << 23),
            c = in(reg) 105 << 23,
            three = in(reg) 64 - (3 << 27), // a little less than 3, since products are rounded
            out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _, out("q6") _,
            options(nostack),
        );
    }
    columns.iter_mut().for_each(|norm| *norm = of(*norm));
}
