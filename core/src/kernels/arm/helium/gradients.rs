//! Cells of gradient orientations by Helium: eight cells at a time, each in a lane. The plain loops are in
//! `plain/gradients.rs`.

use crate::kernels::cells::{CHANNELS, SIDE};
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cells at a time.
const LANES: usize = 8;
/// For each pixel in a row of four cells: the index in [`Sectors`] of the votes of its cell for the first direction of
/// sector 0, and the offset of its bytes in [`Pixels`].
static PLACES: [[u8; 16]; 2] = [
    [32, 32, 32, 32, 33, 33, 33, 33, 34, 34, 34, 34, 35, 35, 35, 35],
    [0, 24, 48, 72, 1, 25, 49, 73, 2, 26, 50, 74, 3, 27, 51, 75],
];
/// Factors of gradients and other constants for the search of a sector: the registers r3 to r12.
static NUMBERS: [i32; 10] = [-4, 31, -12, 1, -8, -10, 9, 6, 11, -3];
/// The offsets of the features of eight cells.
static FEATURES: [u16; LANES] = [0, 10, 20, 30, 40, 50, 60, 70];

/// The votes of eight cells: for the first direction of the sectors 4 to 0, then of the mirrored sectors; then the same
/// for the second direction.
#[repr(align(4))]
#[allow(dead_code)] // the assembly reads it
struct Sectors(MaybeUninit<[[u16; LANES]; 20]>);

/// Gradients of eight cells. For the first pixel of each cell in a row |y|, then |x|, then the index of its votes; then
/// the same for the next pixels in that row.
#[repr(align(4))]
#[allow(dead_code)] // the assembly reads it
struct Pixels(MaybeUninit<[[[u8; LANES]; 3]; 4]>);

/// Computes the gradients of 16 pixels in a row. r0 points to the left neighbour of the first pixel, r4 to the one
/// above, r5 to the one below. q1 becomes the index of the votes.
macro_rules! pixels {
    ($from:literal, $place:literal, $places:literal) => {
        concat!(
            concat!("vldrb.u8 q0, [r0, #", $from, "]\n"),
            concat!("vldrb.u8 q1, [r0, #", $from, " + 2]\n"),
            concat!("vldrb.u8 q2, [r4, #", $from, "]\n"),
            concat!("vldrb.u8 q3, [r5, #", $from, "]\n"),
            "vhsub.u8 q4, q1, q0\n", // the top bit is the sign
            "vabd.u8 q0, q0, q1\n",
            "vhsub.u8 q1, q3, q2\n",
            "vabd.u8 q2, q2, q3\n",
            // A gradient is mirrored if the signs differ. If x or y is 0, both ways give the same votes.
            "veor q4, q4, q1\n",
            concat!($place, "\n"),
            "vpt.s8 lt, q4, zr\n",
            "vaddt.i8 q1, q1, r8\n",
            concat!("vstrb.8 q2, [r1, ", $places, "]\n"),
            concat!("vstrb.8 q0, [r2, ", $places, "]\n"),
            concat!("vstrb.8 q1, [r3, ", $places, "]\n"),
        )
    };
}

/// Steps to the next direction in the lanes where F of the last one (q6) is not negative, and notes the last one there
/// as the first direction of the sector. Computes t of the next direction in q5 and F in q6.
macro_rules! next {
    ($first:literal, $second:literal; $third:literal, $fourth:literal) => {
        concat!(
            "vptttt.s16 ge, q6, zr\n",
            "vorrt q4, q6, q6\n",
            "vaddt.i16 q7, q7, r7\n",
            concat!($first, "\n", $second, "\n"),
            "vpsttt\n",
            "vshrt.s16 q6, q5, #6\n",
            concat!($third, "\n", $fourth, "\n"),
        )
    };
}

/// Stores q0, which is zero.
macro_rules! zero {
    ($($number:literal)*) => {
        concat!($("vstrw.32 q0, [r1, #16 * ", $number, "]\n",)*)
    };
}

/// Adds up the votes for a direction, stores the sum, and adds its square to the energies: q2 for even cells, q3 for
/// odd ones.
macro_rules! sum {
    ($first:literal $($other:literal)*) => {
        concat!(
            "vldrw.u32 q0, [r1, #16 * ", $first, "]\n",
            $("vldrw.u32 q1, [r1, #16 * ", $other, "]\n", "vadd.i16 q0, q0, q1\n",)*
            "vstrh.16 q0, [r0], #{row}\n",
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
#[inline(never)] // one copy in flash
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
/// How far a gradient is beyond a direction, v = cos * |y| - sin * |x|, has 19 bits and a sign. The votes need only v /
/// 64 and -v / 64, both rounded down. Let v = 64 f + t. Then
///
/// ```text
/// floor(v / 64)  = F = f + (t >> 6)
/// floor(-v / 64) = -F, less 1 unless v is a multiple of 64
/// ```
///
/// and all of it fits in 16 bits. F never grows from one direction to the next. So the last direction with F >= 0 is
/// the first of the sector, and the next one, whose t is needed too, is the second. In the table, up = |y| and right =
/// |x|.
///
/// | direction | cos | sin | t | f |
/// |---|---|---|---|---|
/// | 0 | 748 | 0 | 44 up, of which t >> 6 is 11 up >> 4 | 11 up |
/// | 1 | 703 | 256 | -up | 11 up - 4 right |
/// | 2 | 573 | 481 | -3 up + 31 right | 9 up - 8 right |
/// | 3 | 374 | 648 | -10 up - 8 right | 6 up - 10 right |
/// | 4 | 130 | 737 | 2 up + 31 right | 2 up - 12 right |
/// | 5 | -130 | 737 | -2 up + 31 right | -2 up - 12 right |
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
    let to = (&raw mut gradients).cast::<u8>();
    // The upper left neighbour of the first pixel.
    let pixels = lines.as_ptr().cast::<u8>().wrapping_add(at);
    // SAFETY: all of `sectors` is written.
    unsafe {
        asm!(
            "vmov.i32 q0, #0",
            zero!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19),
            in("r1") &raw mut sectors,
            out("q0") _,
            options(nostack),
        );
    }
    let (mut line, end) = (pixels.wrapping_add(COLUMNS), pixels.wrapping_add(5 * COLUMNS));
    while line != end {
        // SAFETY: 34 pixels of each of six lines are read, and the check above leaves room for them. All of `gradients`
        // is written, 16 bytes at a time.
        unsafe {
            asm!(
                "vldrb.u8 q6, [r4]",
                "vldrb.u8 q7, [r4, #16]",
                "vadd.i8 q5, q7, r9",
                "sub r4, r0, #{line} - 1",
                "add r5, r0, #{line} + 1",
                pixels!(0, "vorr q1, q6, q6", "q7"),
                pixels!(16, "vadd.i8 q1, q6, r9", "q5"),
                "add r0, r0, #{line}", // in the assembly, or the compiler would unroll the loop
                inout("r0") line,
                in("r1") to,
                in("r2") to.wrapping_add(LANES),
                in("r3") to.wrapping_add(2 * LANES),
                inout("r4") &raw const PLACES => _,
                out("r5") _,
                in("r8") 40,
                in("r9") 4,
                out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _, out("q6") _,
                out("q7") _,
                line = const COLUMNS,
                options(nostack),
            );
        }
        // SAFETY: `gradients` and `sectors` were written. r1 points to the votes 0 to 79 and r2 to those from 80 on. r6
        // and r7, which `asm!` may not name, are saved in q3.
        unsafe {
            asm!(
                "vmov d6, r6, r7",
                "ldm r3, {{r3-r12}}",
                "mov lr, #4",
                "dls lr, lr",
                "2:",
                // q0 is |y|, q1 is |x|.
                "vldrb.u16 q1, [r0, #8]",
                "vldrb.u16 q7, [r0, #16]",
                "vldrb.u16 q0, [r0], #24",
                // Direction 0.
                "vmul.i16 q6, q0, r11",
                "vshr.u16 q4, q6, #4",
                "vadd.i16 q4, q4, q6",
                // Direction 1.
                "vneg.s16 q5, q0",
                "vshr.s16 q2, q5, #6",
                "vadd.i16 q6, q6, q2",
                "vmla.i16 q6, q1, r3",
                // Directions 2 to 4.
                "vadd.i16 q2, q0, q0",
                next!("vmult.i16 q5, q1, r4", "vmlat.i16 q5, q0, r12"; "vmlat.i16 q6, q0, r9", "vmlat.i16 q6, q1, r7"),
                next!("vmult.i16 q5, q0, r8", "vmlat.i16 q5, q1, r7"; "vmlat.i16 q6, q0, r10", "vmlat.i16 q6, q1, r8"),
                next!("vmult.i16 q5, q1, r4", "vaddt.i16 q5, q5, q2"; "vaddt.i16 q6, q6, q2", "vmlat.i16 q6, q1, r5"),
                // Direction 5: its t is 4 |y| less.
                "vptttt.s16 ge, q6, zr",
                "vorrt q4, q6, q6",
                "vaddt.i16 q7, q7, r7",
                "vmlat.i16 q5, q0, r3",
                "vshrt.s16 q6, q5, #6",
                "vpstt",
                "vsubt.i16 q6, q6, q2",
                "vmlat.i16 q6, q1, r5",
                // The votes are q4 for the second direction, and for the first -F, less 1 if the lowest six bits of t
                // are not 0.
                "vshl.i16 q5, q5, #10",
                "vpt.i16 ne, q5, zr",
                "vaddt.i16 q6, q6, r6",
                "vldrh.u16 q0, [r1, q7, uxtw #1]",
                "vldrh.u16 q1, [r2, q7, uxtw #1]",
                "vsub.i16 q0, q0, q6",
                "vadd.i16 q1, q1, q4",
                "vstrh.16 q0, [r1, q7, uxtw #1]",
                "vstrh.16 q1, [r2, q7, uxtw #1]",
                "le lr, 2b",
                "vmov r6, r7, d6",
                inout("r0") to => _,
                in("r1") &raw mut sectors,
                in("r2") (&raw mut sectors).cast::<[u16; LANES]>().wrapping_add(10),
                inout("r3") &raw const NUMBERS => _,
                out("r4") _, out("r5") _, out("r8") _, out("r9") _, out("r10") _, out("r11") _, out("r12") _,
                out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _, out("q5") _,
                out("q6") _, out("q7") _,
                options(nostack),
            );
        }
    }
    // SAFETY: `sectors` was written. Eight sums of each row and eight energies are written from `first` on: `first +
    // LANES <= ROW`. 32 pixels of the four inner lines are read.
    unsafe {
        asm!(
            "vmov.i32 q2, #0",
            "vmov.i32 q3, #0",
            sum!(4 9),
            sum!(14 3),
            sum!(13 2),
            sum!(12 1),
            sum!(11 0 15),
            sum!(10 16 5),
            sum!(17 6),
            sum!(18 7),
            sum!(19 8),
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
            in("r1") &raw const sectors,
            inout("r2") energies.as_mut_ptr().wrapping_add(first) => _,
            inout("r3") pixels.wrapping_add(COLUMNS + 1) => _,
            out("lr") _, out("q0") _, out("q1") _, out("q2") _, out("q3") _, out("q4") _,
            row = const 2 * ROW,
            line = const COLUMNS,
            options(nostack),
        );
    }
}

/// Computes the features of a row of cells, up to the length of `out`: for each cell nine times `min(sum * inverse >>
/// 16, 127)`, and `(gray >> 4) - 128`. No product reaches 2^32.
pub(crate) fn scale<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
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
