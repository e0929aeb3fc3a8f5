//! Cells of gradient orientations by Helium: eight cells at a time. The plain loops are in `plain/gradients.rs`.

use crate::kernels::layout::{CELL, CHANNELS, SIDE};
use crate::kernels::plain::gradients::DIRECTIONS;
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cells at a time.
const LANES: usize = 8;
/// Sectors between two directions, with the mirrored ones.
const SECTORS: usize = 10;
/// For each pixel in a row of four cells: the index of its cell in [`Sectors`], what is left of that and the index in
/// the mirrored sector together, and the offset of its bytes in [`Pixels`].
static PLACES: [[u8; 16]; 3] = [
    [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3],
    [72, 72, 72, 72, 74, 74, 74, 74, 76, 76, 76, 76, 78, 78, 78, 78],
    [0, 16, 32, 48, 2, 18, 34, 50, 4, 20, 36, 52, 6, 22, 38, 54],
];
/// The largest |x| for each |y| of a gradient beyond direction 2.
static BEYOND_TWO: [u8; 256] = largest_beyond(DIRECTIONS[2]);
/// Four times for each sector, in the order of [`Sectors`]: the factors of |y| and |x| in the vote for the first
/// direction, then those of |x| and |y| in the vote for the second direction.
static FACTORS: [[[[i16; 2]; 4]; 2]; SECTORS] = factors();
/// The offsets of the features of eight cells.
static FEATURES: [u16; LANES] = [0, 10, 20, 30, 40, 50, 60, 70];

/// The votes of eight cells for the first and the second direction of each sector: of the sectors 0 to 4, then of the
/// mirrored sectors 4 to 0.
#[repr(align(4))]
#[allow(dead_code)] // the assembly reads it
struct Sectors(MaybeUninit<[[[u16; 2]; LANES]; SECTORS]>);

/// Gradients of four cells in a row of pixels. For the first pixel of each cell |y| and |x|, then for each the index of
/// its votes; then the same for the next pixels.
#[repr(align(4))]
#[allow(dead_code)] // the assembly reads it
struct Pixels(MaybeUninit<[[[[u8; 2]; 4]; 2]; CELL as usize]>);

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

#[allow(clippy::cast_possible_truncation)] // at most 748 * 32
const fn factors() -> [[[[i16; 2]; 4]; 2]; SECTORS] {
    let mut factors = [[[[0; 2]; 4]; 2]; SECTORS];
    let mut at = 0;
    while at < SECTORS {
        let sector = if at < SECTORS / 2 { at } else { SECTORS - 1 - at };
        let (first, second) = (DIRECTIONS[sector], DIRECTIONS[sector + 1]);
        factors[at] =
            [[[-32 * second.0 as i16, 32 * second.1 as i16]; 4], [[-32 * first.1 as i16, 32 * first.0 as i16]; 4]];
        at += 1;
    }
    factors
}

/// Computes the gradients of 16 pixels in a row, and the index of their votes. r0 points to the pixel above the first
/// one and becomes that pixel's place, r5 is one row further down.
///
/// A gradient is beyond direction 1, 3 or 4 if |x| is at most a number that these products give for each |y|.
macro_rules! pixels {
    () => {
        concat!(
            "vldrb.u8 q2, [r0]\n",
            "add r0, r0, #{line}\n",
            "add r5, r0, #{line}\n",
            "vldrb.u8 q0, [r0, #-1]\n",
            "vldrb.u8 q1, [r0, #1]\n",
            "vldrb.u8 q3, [r5]\n",
            "vhsub.u8 q4, q1, q0\n", // the top bit is the sign
            "vabd.u8 q0, q0, q1\n",
            "vhsub.u8 q1, q3, q2\n",
            "vabd.u8 q2, q2, q3\n",
            // A gradient is mirrored if the signs differ. If x or y is 0, both ways give the same votes.
            "veor q4, q4, q1\n",
            "vmov.i8 q1, #191\n",
            "vmulh.u8 q3, q1, q2\n",
            "vorr q1, q6, q6\n",
            "vqadd.u8 q3, q3, q2\n",
            "vstrb.8 q2, [r1, q7]\n",
            "vqadd.u8 q3, q3, q2\n",
            "vstrb.8 q0, [r2, q7]\n",
            beyond!(),
            "vldrb.u8 q3, [r3, q2]\n",
            beyond!(),
            "vmov.i8 q3, #79\n",
            "vmulh.u8 q3, q3, q2\n",
            "vshr.u8 q3, q3, #1\n",
            "vhadd.u8 q3, q3, q2\n",
            beyond!(),
            "vmov.i8 q3, #105\n",
            "vmulh.u8 q3, q3, q2\n",
            "vhadd.u8 q3, q3, q2\n",
            "vshr.u8 q3, q3, #2\n",
            beyond!(),
            "vpt.s8 lt, q4, zr\n",
            "vsubt.i8 q1, q5, q1\n",
            "vstrb.8 q1, [r4, q7]\n",
        )
    };
}

/// Goes on to the next sector where |x| (q0) is at most q3.
macro_rules! beyond {
    () => {
        "vpt.u8 cs, q3, q0\nvaddt.i8 q1, q1, r8\n"
    };
}

/// Adds the votes of one pixel in each of four cells.
macro_rules! votes {
    ($($at:literal)*) => {
        concat!($(
            concat!("vldrh.u32 q0, [r1, #", $at, " + 8]\n"),
            concat!("vldrb.u16 q1, [r1, #", $at, "]\n"),
            "vldrw.u32 q2, [r9, q0, uxtw #2]\n",
            "vshl.i16 q1, q1, #4\n",
            "vldrw.u32 q3, [r10, q0, uxtw #2]\n",
            "vqdmladh.s16 q2, q1, q2\n",
            "vldrw.u32 q4, [r11, q0, uxtw #2]\n",
            "vqdmladhx.s16 q2, q1, q3\n",
            "vadd.i16 q4, q4, q2\n",
            "vstrw.32 q4, [r11, q0, uxtw #2]\n",
        )*)
    };
}

/// Stores q0, which is zero.
macro_rules! zero {
    ($to:literal: $($number:literal)*) => {
        concat!($("vstrw.32 q0, [", $to, ", #16 * ", $number, "]\n",)*)
    };
}

/// Loads the votes of the next sector.
macro_rules! load {
    ($($registers:literal)*) => {
        concat!($("vld20.16 ", $registers, ", [r1]\nvld21.16 ", $registers, ", [r1]!\n",)*)
    };
}

/// Stores the sum of the votes for a direction, q0, and adds its square to the energies: q2 for even cells, q3 for odd
/// ones.
macro_rules! sum {
    ($to:literal) => {
        concat!(
            concat!("vstrh.16 q0, ", $to, "\n"),
            "vshr.u16 q0, q0, #2\n",
            "vmullb.u16 q1, q0, q0\n",
            "vmullt.u16 q0, q0, q0\n",
            "vadd.i32 q2, q2, q1\n",
            "vadd.i32 q3, q3, q0\n",
        )
    };
}

/// Computes the sums of a row of cells and their energies, as the plain loop does. Rows and lines have room for a
/// multiple of eight cells.
#[inline(never)]
pub(crate) fn gradients<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; SIDE],
    sums: &mut [[u16; ROW]],
    energies: &mut [u32; ROW],
    across: usize,
) {
    let Some(sums) = sums.first_chunk_mut() else { return };
    for block in 0..across.div_ceil(LANES) {
        eight_cells(lines, block, sums, energies);
    }
}

/// Computes the nine gradient sums, the sum of gray levels and the energy of each of the eight cells of block `block`.
/// Does nothing if the cells are not on the lines or have no room in the rows.
///
/// How far a gradient is beyond a direction, v = cos * |y| - sin * |x|, has 19 bits and a sign. `vqdmladh` gives v / 64,
/// rounded down, from 32 cos, 32 sin, 16 |y| and 16 |x|.
#[inline(never)] // the compiler would unroll the loop over blocks
fn eight_cells<const COLUMNS: usize, const ROW: usize>(
    lines: &[[u8; COLUMNS]; 6],
    block: usize,
    sums: &mut [[u16; ROW]; 10],
    energies: &mut [u32; ROW],
) {
    let (first, at) = (block * LANES, 4 * block * LANES);
    if first + LANES > ROW || at + 4 * LANES + 2 > COLUMNS {
        return;
    }
    let mut sectors = Sectors(MaybeUninit::uninit());
    let mut gradients = Pixels(MaybeUninit::uninit());
    // The upper left neighbour of the first pixel.
    let pixels = lines.as_ptr().cast::<u8>().wrapping_add(at);
    // SAFETY: all of `sectors` and `gradients` is written.
    unsafe {
        asm!(
            "vmov.i32 q0, #0",
            zero!("r1": 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19),
            zero!("r2": 0 1 2 3),
            in("r1") &raw mut sectors,
            in("r2") &raw mut gradients,
            out("q0") _,
            options(nostack),
        );
    }
    let to = (&raw mut gradients).cast::<u8>();
    let factors = (&raw const FACTORS).cast::<[[i16; 2]; 4]>();
    let mut half = 0;
    while half < 2 {
        // SAFETY: 18 pixels of each of six lines are read, and the check above leaves room for them. `gradients` is
        // written at the offsets in `PLACES`, so each index of votes is one in `sectors`.
        unsafe {
            asm!(
                "vldrb.u8 q6, [r4]",
                "vldrb.u8 q5, [r4, #16]",
                "vldrb.u8 q7, [r4, #32]",
                "add r4, r1, #8",
                "mov lr, #4",
                "dls lr, lr",
                "2:",
                pixels!(),
                votes!(0 16 32 48),
                "le lr, 2b",
                inout("r0") pixels.wrapping_add(16 * half + 1) => _,
                in("r1") to,
                in("r2") to.wrapping_add(1),
                in("r3") &raw const BEYOND_TWO,
                inout("r4") &raw const PLACES => _,
                out("r5") _,
                in("r8") 8,
                in("r9") factors,
                in("r10") factors.wrapping_add(1),
                in("r11") (&raw mut sectors).cast::<[[u16; 2]; 4]>().wrapping_add(half),
                out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _,
                out("q6") _, out("q7") _,
                line = const COLUMNS,
                options(nostack),
            );
        }
        half += 1; // not a range: the compiler would unroll the loop
    }
    // SAFETY: `sectors` was written. Eight sums of each row and eight energies are written from `first` on: `first +
    // LANES <= ROW`. 32 pixels of the four inner lines are read.
    unsafe {
        asm!(
            "vmov.i32 q2, #0",
            "vmov.i32 q3, #0",
            "mov r4, r0",
            load!("{{q4, q5}}"),
            "vstrh.16 q4, [r0], #{row}", // for direction 0, without the mirrored sector
            load!("{{q6, q7}}"),
            "vadd.i16 q0, q5, q6",
            sum!("[r0], #{row}"),
            load!("{{q4, q5}}"),
            "vadd.i16 q0, q7, q4",
            sum!("[r0], #{row}"),
            load!("{{q6, q7}}"),
            "vadd.i16 q0, q5, q6",
            sum!("[r0], #{row}"),
            load!("{{q4, q5}}"),
            "vadd.i16 q0, q7, q4",
            load!("{{q6, q7}}"),
            "vadd.i16 q0, q0, q7",
            sum!("[r0], #{row}"),
            "vadd.i16 q0, q5, q6",
            load!("{{q6, q7}}"),
            "vadd.i16 q0, q0, q7",
            sum!("[r0], #{row}"),
            load!("{{q4, q5}}"),
            "vadd.i16 q0, q5, q6",
            sum!("[r0], #{row}"),
            load!("{{q6, q7}}"),
            "vadd.i16 q0, q7, q4",
            sum!("[r0], #{row}"),
            load!("{{q4, q5}}"),
            "vadd.i16 q0, q5, q6",
            sum!("[r0], #{row}"),
            "vldrh.u16 q0, [r4]",
            "vadd.i16 q0, q0, q4",
            sum!("[r4]"),
            "vst20.32 {{q2, q3}}, [r2]",
            "vst21.32 {{q2, q3}}, [r2]",
            // Gray levels: a vector holds a row of four cells. Neighbouring pixels are added, then neighbouring sums.
            "vmov.i32 q2, #0",
            "vmov.i32 q3, #0",
            "mov lr, #4",
            "dls lr, lr",
            "3:",
            "vldrb.u8 q1, [r3, #16]",
            "vldrb.u8 q0, [r3]",
            "add r3, r3, #{line}",
            "vmovlb.u8 q4, q1",
            "vmovlt.u8 q1, q1",
            "vadd.i16 q3, q3, q4",
            "vadd.i16 q3, q3, q1",
            "vmovlb.u8 q4, q0",
            "vmovlt.u8 q0, q0",
            "vadd.i16 q2, q2, q4",
            "vadd.i16 q2, q2, q0",
            "le lr, 3b",
            "vshr.u32 q0, q2, #16",
            "vshr.u32 q1, q3, #16",
            "vadd.i16 q0, q0, q2",
            "vadd.i16 q1, q1, q3",
            "vstrh.32 q0, [r0]",
            "vstrh.32 q1, [r0, #8]",
            inout("r0") sums.as_mut_ptr().cast::<u16>().wrapping_add(first) => _,
            inout("r1") &raw const sectors => _,
            inout("r2") energies.as_mut_ptr().wrapping_add(first) => _,
            inout("r3") pixels.wrapping_add(COLUMNS + 1) => _,
            out("r4") _,
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
    const { assert!(ROW.is_multiple_of(LANES)) };
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
