//! Cells of gradient orientations by Helium: four cells at a time. The plain loops are in `plain/gradients.rs`.

use crate::kernels::layout::{CELL, CHANNELS, SIDE};
use crate::kernels::plain::gradients::DIRECTIONS;
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cells at a time.
const LANES: usize = 4;
/// Sectors between two directions, with the mirrored ones.
const SECTORS: usize = 10;
/// Read by the assembly, which knows the offsets.
#[repr(C, align(4))]
#[allow(dead_code)]
struct Tables {
    /// The largest |x| for each |y| of a gradient beyond direction 2.
    beyond_two: [u8; 256],
    /// For each pixel in a row of four cells: the index of its cell in [`Memory::sectors`].
    first: [u8; 16],
    /// Factors of |y| for the directions 1, 3 and 4.
    beyond: [[u8; 16]; 3],
    /// What is left of the index and that in the mirrored sector together.
    both: [u8; 16],
    /// The offset in [`Memory::pixels`].
    offsets: [u8; 16],
}

static TABLES: Tables = Tables {
    beyond_two: largest_beyond(DIRECTIONS[2]),
    first: [20, 20, 20, 20, 21, 21, 21, 21, 22, 22, 22, 22, 23, 23, 23, 23],
    beyond: [[191; 16], [79; 16], [105; 16]],
    both: [36, 36, 36, 36, 38, 38, 38, 38, 40, 40, 40, 40, 42, 42, 42, 42],
    offsets: [0, 16, 32, 48, 2, 18, 34, 50, 4, 20, 36, 52, 6, 22, 38, 54],
};
/// For each direction, from 5 to 8 and from 0 to 4: the factors of the sector before it, of its word |y| + 65,536 |x| and
/// of |x|, then those of the sector behind it.
static FACTORS: [[[i32; 2]; 2]; SECTORS - 1] = factors();
/// The offsets of the features of eight cells.
static FEATURES: [u16; 8] = [0, 10, 20, 30, 40, 50, 60, 70];

/// Memory of the assembly, which knows the offsets of the fields.
#[repr(C, align(4))]
#[allow(dead_code)] // the assembly reads it
struct Memory {
    /// Gradients in a row of pixels. For the first pixel of each cell |y| and |x|, then for each the index of its sector;
    /// then those of the next pixels.
    pixels: [[[[u8; 2]; LANES]; 2]; CELL as usize],
    /// The sums of |y| and |x| of each cell: those of the mirrored sectors 4 to 0, then of the sectors 0 to 4. So two
    /// sectors that stand together share a direction.
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

const fn factors() -> [[[i32; 2]; 2]; SECTORS - 1] {
    const fn beyond((cos, sin): (i32, i32)) -> [i32; 2] {
        [cos, -sin - (cos << 16)]
    }
    const fn short_of((cos, sin): (i32, i32)) -> [i32; 2] {
        beyond((-cos, -sin))
    }
    let [zero, one, two, three, four, five] = DIRECTIONS;
    [
        [beyond(four), beyond(three)], // the sector before it holds |x| less the mirrored |x|
        [short_of(four), beyond(two)],
        [short_of(three), beyond(one)],
        [short_of(two), beyond(zero)],
        [short_of(one), short_of(one)],
        [beyond(zero), short_of(two)],
        [beyond(one), short_of(three)],
        [beyond(two), short_of(four)],
        [beyond(three), short_of(five)],
    ]
}

/// Computes the gradients of 16 pixels in a row, and the index of their sector. r10 points to the pixel above the first
/// one and becomes that pixel's place, r5 is one row further down.
///
/// A gradient is beyond direction 1, 3 or 4 if |x| is at most a number that these products give for each |y|.
///
/// Loads stand between sums: the processor does both at once.
macro_rules! pixels {
    () => {
        concat!(
            "vldrb.u8 q2, [r10]\n",
            "add r10, r10, #{line}\n",
            "add r5, r10, #{line}\n",
            "vldrb.u8 q3, [r5]\n",
            "vldrb.u8 q0, [r10, #-1]\n",
            "vabd.u8 q5, q2, q3\n",
            "vldrb.u8 q1, [r10, #1]\n",
            "vhsub.u8 q3, q3, q2\n", // the top bit is the sign
            "vldrw.u32 q2, [r3, #272]\n",
            "vhsub.u8 q4, q1, q0\n",
            "vmulh.u8 q2, q2, q5\n",
            "vabd.u8 q0, q0, q1\n",
            "vstrb.8 q5, [r1, q7]\n",
            "vqadd.u8 q2, q2, q5\n",
            "vstrb.8 q0, [r2, q7]\n",
            "vqadd.u8 q2, q2, q5\n",
            "vldrw.u32 q1, [r3, #256]\n",
            beyond!("q2"),
            "vldrb.u8 q2, [r3, q5]\n",
            // A gradient is mirrored if the signs differ. If x or y is 0, both ways give the same votes.
            "veor q4, q4, q3\n",
            beyond!("q2"),
            "vldrw.u32 q3, [r3, #288]\n",
            "vmulh.u8 q3, q3, q5\n",
            "vldrw.u32 q2, [r3, #304]\n",
            "vshr.u8 q3, q3, #1\n",
            "vmulh.u8 q2, q2, q5\n",
            "vhadd.u8 q3, q3, q5\n",
            "vhadd.u8 q2, q2, q5\n",
            beyond!("q3"),
            "vshr.u8 q2, q2, #2\n",
            "vldrw.u32 q3, [r3, #320]\n",
            beyond!("q2"),
            "vpt.s8 lt, q4, zr\n",
            "vsubt.i8 q1, q3, q1\n",
            "vstrb.8 q1, [r4, q7]\n",
        )
    };
}

/// Goes on to the next sector where |x| (q0) is at most a number.
macro_rules! beyond {
    ($most:literal) => {
        concat!("vpt.u8 cs, ", $most, ", q0\nvaddt.i8 q1, q1, r8\n")
    };
}

/// Adds the gradient of one pixel in each of four cells, q1, to the sectors at an index. Loads the gradients `at`, and
/// their index.
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

/// Computes the sums of a row of cells and their energies, as the plain loop does. Rows and lines have room for a
/// multiple of four cells.
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    let Some(sums) = sums.first_chunk_mut() else { return };
    for block in 0..across.div_ceil(LANES) {
        four_cells(lines, block, sums, energies);
    }
}

/// Computes the nine gradient sums, the sum of gray levels and the energy of each of the four cells of block `block`.
/// Does nothing if the cells are not on the lines or have no room in the rows.
#[inline(never)] // the compiler would unroll the loop over blocks
fn four_cells<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    block: usize,
    sums: &mut [[u16; ROW]; CHANNELS],
    energies: &mut [u32; ROW],
) {
    let (first, at) = (block * LANES, LANES * block * usize::from(CELL));
    if first + LANES > ROW || at + LANES * usize::from(CELL) + 2 > COLUMNS {
        return;
    }
    let mut memory = MaybeUninit::<Memory>::uninit();
    let to = memory.as_mut_ptr().cast::<u8>();
    // SAFETY: 18 pixels of each of six lines are read, four sums of each row and four energies are written from `first`
    // on, and the check above leaves room for them. All of `memory` is written before it is read, `pixels` at the
    // offsets in `TABLES`, so each index is one in `sectors`.
    unsafe {
        asm!(
            "vmov.i32 q0, #0",
            "mov lr, #14",
            "dls lr, lr",
            "2:",
            "vstrw.32 q0, [r2], #16",
            "le lr, 2b",
            "vmov.i32 q6, #0",
            "vldrw.u32 q7, [r3, #336]",
            "add r2, r1, #1",
            "add r4, r1, #8",
            "add r11, r1, #64",
            "mov lr, #4",
            "dls lr, lr",
            "2:",
            pixels!(),
            // Meanwhile q6 sums up gray levels: two neighbouring pixels in a lane.
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
            // Sector 4 and the mirrored one lie between the directions 4 and 5. Their |y| count alike, their |x| do not.
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
            inout("r10") lines.as_ptr().cast::<u8>().wrapping_add(at + 1) => _,
            in("r1") to,
            inout("r2") to => _,
            inout("r3") &raw const TABLES => _,
            out("r4") _,
            out("r5") _,
            in("r8") 4,
            inout("r9") &raw const FACTORS => _,
            inout("r0") sums.as_mut_ptr().cast::<u16>().wrapping_add((CHANNELS - 1) * ROW + first) => _,
            out("r11") _,
            in("r12") energies.as_mut_ptr().wrapping_add(first),
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _, out("q6") _,
            out("q7") _,
            row = const 2 * ROW,
            line = const COLUMNS,
            options(nostack),
        );
    }
}

/// Computes the features of a row of cells, up to the length of `out`: for each cell nine times `min(sum * inverse >>
/// 16, 127)`, and `(gray >> 4) - 128`. No product reaches 2^32.
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
            "vld20.16 {{q0, q1}}, [r1]",
            "vld21.16 {{q0, q1}}, [r1]!",
            "vctp.16 r4",
            "mov r5, r0",
            "mov r8, r2",
            "mov lr, #9",
            "dls lr, lr",
            "2:",
            "vldrh.u16 q2, [r5], #{row}",
            // sum * upper half of the inverse + (sum * lower half >> 16).
            "vmulh.u16 q3, q2, q0",
            "vmul.i16 q2, q2, q1",
            "vadd.i16 q2, q2, q3",
            "vmin.u16 q2, q2, q6",
            "vpst",
            "vstrbt.16 q2, [r8, q7]",
            "adds r8, #1",
            "le lr, 2b",
            "vldrh.u16 q2, [r5]",
            "vshr.u16 q2, q2, #4",
            "vsub.i16 q2, q2, r9",
            "vpst",
            "vstrbt.16 q2, [r8, q7]",
            "adds r0, #16",
            "adds r2, #80",
            "subs r4, #8",
            "bgt 1b",
            inout("r0") sums.as_ptr() => _,
            inout("r1") inverses.as_ptr() => _,
            inout("r2") out.as_mut_ptr() => _,
            in("r3") &raw const FEATURES,
            inout("r4") out.len() => _,
            out("r5") _, out("r8") _,
            in("r9") 128,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q6") _, out("q7") _,
            row = const 2 * ROW,
            options(nostack),
        );
    }
}

/// Brings y (q3) nearer to 1 / sqrt(x) (q2), and turns its sign.
macro_rules! newton {
    () => {
        concat!(
            "vqdmulh.s32 q4, q3, q3\n",
            "vqdmulh.s32 q4, q4, q2\n",
            "vadd.i32 q4, q4, {three}\n",
            "vqdmulh.s32 q3, q3, q4\n",
            "vshl.i32 q3, q3, #3\n",
        )
    };
}

/// Replaces the energies of columns by `of` the norms of cells, as the plain loop does.
///
/// A mean is a product: for n cells and an energy below 2^29, 2^32 / n rounded up is exact. For x = number * 4^h / 2^32,
/// from 1/4 to 1, y = 1 / sqrt(x) begins as a polynomial, within 3 %. Two Newton steps, y (x y^2 - 3) / 2, turn its sign
/// twice and leave it a little too small. So the root is right or too small by 1.
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
            // The next column to the right; 0 beyond the edge.
            "vctp.32 {right}",
            "vmov q3, q5",
            "vpstt",
            "vldrwt.u32 q1, [{columns}, #4]",
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
            newton!(),
            newton!(),
            "vqdmulh.s32 q3, q3, q2",
            "vneg.s32 q1, q1",
            "vshl.u32 q3, q3, q1",
            "vshr.u32 q3, q3, #13",
            "vadd.i32 q1, q3, q6",
            "vmul.i32 q2, q1, q1",
            "vpt.u32 cs, q0, q2",
            "vaddt.i32 q3, q3, q6",
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
            three = in(reg) 64 - (3 << 27),
            out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _, out("q6") _,
            options(nostack),
        );
    }
    columns.iter_mut().for_each(|norm| *norm = of(*norm));
}
