//! Cells of the robust tracker by Helium: gradients of eight cells side by side, and their sums as bytes. A lane is a cell. The plain
//! loops are in `plain/gradients.rs`.

#[cfg(feature = "verify")]
use crate::kernels::cells::CELL;
use crate::kernels::cells::{CHANNELS, SIDE};
#[cfg(feature = "verify")]
use crate::kernels::plain::gradients as plain;
use core::arch::asm;
use core::mem::MaybeUninit;

/// Cells side by side.
const LANES: usize = 8;
/// Of four cells, pixel by pixel: the first direction's sum of the sector 0 in [`Sectors`]; and where a pixel's bytes are in [`Pixels`].
static PLACES: [[u8; 16]; 2] = [
    [32, 32, 32, 32, 33, 33, 33, 33, 34, 34, 34, 34, 35, 35, 35, 35],
    [0, 24, 48, 72, 1, 25, 49, 73, 2, 26, 50, 74, 3, 27, 51, 75],
];
/// What gradients are multiplied by, and other numbers of the search for a sector: the registers r3 to r12.
static NUMBERS: [i32; 10] = [-4, 31, -12, 1, -8, -10, 9, 6, 11, -3];
/// Bytes to a cell's features.
static FEATURES: [u16; LANES] = [0, 10, 20, 30, 40, 50, 60, 70];

/// Sums of eight cells by the sector between two directions: of the sectors 4 to 0, then of those that mirror them, what the first
/// direction gets; then of all of these what the second one does.
#[repr(align(4))]
#[allow(dead_code)] // the assembler reads it
struct Sectors(MaybeUninit<[[u16; LANES]; 20]>);

/// Gradients of eight cells: of one pixel of each how far up and how far to the right, without sign, and where their sums are; then of
/// their next pixels in that row.
#[repr(align(4))]
#[allow(dead_code)] // the assembler reads it
struct Pixels(MaybeUninit<[[[u8; LANES]; 3]; 4]>);

/// Gradients of 16 pixels in a row, of which r0 points to the left of the first one, r4 above and r5 below. q1 is where their sums are.
macro_rules! pixels {
    ($from:literal, $place:literal, $places:literal) => {
        concat!(
            "vldrb.u8 q0, [r0, #",
            $from,
            "]\n",
            "vldrb.u8 q1, [r0, #",
            $from,
            " + 2]\n",
            "vldrb.u8 q2, [r4, #",
            $from,
            "]\n",
            "vldrb.u8 q3, [r5, #",
            $from,
            "]\n",
            "vhsub.u8 q4, q1, q0\n", // the highest bit is the sign
            "vabd.u8 q0, q0, q1\n",
            "vhsub.u8 q1, q3, q2\n",
            "vabd.u8 q2, q2, q3\n",
            // Mirrored where the signs differ. Where one of the two is 0 the outcome is the same.
            "veor q4, q4, q1\n",
            $place,
            "\n",
            "vpt.s8 lt, q4, zr\n",
            "vaddt.i8 q1, q1, r8\n",
            "vstrb.8 q2, [r1, ",
            $places,
            "]\n",
            "vstrb.8 q0, [r2, ",
            $places,
            "]\n",
            "vstrb.8 q1, [r3, ",
            $places,
            "]\n",
        )
    };
}

/// Goes on to a farther direction where the last one, q6, is not beyond the gradient: that was the sector's first one, perhaps. Then t
/// in q5 and F in q6.
macro_rules! next {
    ($first:literal, $second:literal; $third:literal, $fourth:literal) => {
        concat!(
            "vptttt.s16 ge, q6, zr\n",
            "vorrt q4, q6, q6\n",
            "vaddt.i16 q7, q7, r7\n",
            $first,
            "\n",
            $second,
            "\n",
            "vpsttt\n",
            "vshrt.s16 q6, q5, #6\n",
            $third,
            "\n",
            $fourth,
            "\n",
        )
    };
}

/// Zeroes, from q0.
macro_rules! zero {
    ($($number:literal)*) => {
        concat!($("vstrw.32 q0, [r1, #16 * ", $number, "]\n",)*)
    };
}

/// A sum of the sectors' numbers: where it goes, and its square added to the energies, those of even cells in q2, of odd ones in q3.
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

/// The sums of a row of cells, and their energies: eight cells at a time. There is room for as many, also on the lines.
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
    #[cfg(feature = "verify")]
    for (number, &energy) in energies.iter().enumerate().take(across) {
        let wanted = plain::cell(lines, number * usize::from(CELL));
        assert_eq!(energy, wanted.energy(), "energy of cell {number}, given and expected");
        assert!(
            sums.iter().zip(wanted.0).all(|(row, wanted)| row.get(number) == Some(&wanted)),
            "sums of cell {number}"
        );
    }
}

/// The sums of eight cells, of which `block` says which eight: nine by direction, that of gray levels, and the energy. Nothing if they are
/// not on the lines or in the rows.
///
/// How far a gradient is beyond a direction, v = cos * up - sin * right, has 19 bits and a sign; all that is asked for is v / 64 and
/// -v / 64, rounded down. With v = 64 * f + t these are f + (t >> 6), here called F, and -F, less 1 unless v is a multiple of 64: all of
/// it fits in 16 bits. F never grows from a direction to the next one, so that of the sector's first direction is the last one that is
/// not negative, and the next one, of which t is needed, too, is the second direction's.
///
/// | direction | cos | sin | t | f |
/// |---|---|---|---|---|
/// | 0 | 748 | 0 | 44 up, of which t >> 6 is 11 up >> 4 | 11 up |
/// | 1 | 703 | 256 | -up | 11 up - 4 right |
/// | 2 | 573 | 481 | -3 up + 31 right | 9 up - 8 right |
/// | 3 | 374 | 648 | -10 up - 8 right | 6 up - 10 right |
/// | 4 | 130 | 737 | 2 up + 31 right | 2 up - 12 right |
/// | 5 | -130 | 737 | -2 up + 31 right | -2 up - 12 right |
#[inline(never)] // a compiler would write it out for each block of a row
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
    // The pixel above and to the left of the first one.
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
        // SAFETY: of six lines, COLUMNS bytes apart, 34 pixels are read, which are there. Of `gradients` all is written, 16 bytes at a time.
        unsafe {
            asm!(
                "vldrb.u8 q6, [r4]",
                "vldrb.u8 q7, [r4, #16]",
                "vadd.i8 q5, q7, r9",
                "sub r4, r0, #{line} - 1",
                "add r5, r0, #{line} + 1",
                pixels!(0, "vorr q1, q6, q6", "q7"),
                pixels!(16, "vadd.i8 q1, q6, r9", "q5"),
                "add r0, r0, #{line}", // here, or the loop would be written out
                inout("r0") line,
                in("r1") to,
                in("r2") to.wrapping_add(LANES),
                in("r3") to.wrapping_add(2 * LANES),
                inout("r4") &raw const PLACES => _,
                out("r5") _,
                in("r8") 40,
                in("r9") 4,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                out("q3") _,
                out("q4") _,
                out("q5") _,
                out("q6") _,
                out("q7") _,
                line = const COLUMNS,
                options(nostack),
            );
        }
        // SAFETY: `gradients` and `sectors` were written. The sums 0 to 79 are read and written by way of r1, those from 80 on by way of
        // r2. r6 and r7, which may not be named, are kept in q3.
        unsafe {
            asm!(
                "vmov d6, r6, r7",
                "ldm r3, {{r3-r12}}",
                "mov lr, #4",
                "dls lr, lr",
                "2:",
                // q0 is up, q1 right.
                "vldrb.u16 q1, [r0, #8]",
                "vldrb.u16 q7, [r0, #16]",
                "vldrb.u16 q0, [r0], #24",
                // 0
                "vmul.i16 q6, q0, r11",
                "vshr.u16 q4, q6, #4",
                "vadd.i16 q4, q4, q6",
                // 1
                "vneg.s16 q5, q0",
                "vshr.s16 q2, q5, #6",
                "vadd.i16 q6, q6, q2",
                "vmla.i16 q6, q1, r3",
                // 2 to 4
                "vadd.i16 q2, q0, q0",
                next!("vmult.i16 q5, q1, r4", "vmlat.i16 q5, q0, r12"; "vmlat.i16 q6, q0, r9", "vmlat.i16 q6, q1, r7"),
                next!("vmult.i16 q5, q0, r8", "vmlat.i16 q5, q1, r7"; "vmlat.i16 q6, q0, r10", "vmlat.i16 q6, q1, r8"),
                next!("vmult.i16 q5, q1, r4", "vaddt.i16 q5, q5, q2"; "vaddt.i16 q6, q6, q2", "vmlat.i16 q6, q1, r5"),
                // 5, of which t is 4 up less.
                "vptttt.s16 ge, q6, zr",
                "vorrt q4, q6, q6",
                "vaddt.i16 q7, q7, r7",
                "vmlat.i16 q5, q0, r3",
                "vshrt.s16 q6, q5, #6",
                "vpstt",
                "vsubt.i16 q6, q6, q2",
                "vmlat.i16 q6, q1, r5",
                // q4 is what the second direction gets; the first one -F of it, less 1 where the lowest six bits are not 0.
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
                out("r4") _,
                out("r5") _,
                out("r8") _,
                out("r9") _,
                out("r10") _,
                out("r11") _,
                out("r12") _,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                out("q3") _,
                out("q4") _,
                out("q5") _,
                out("q6") _,
                out("q7") _,
                options(nostack),
            );
        }
    }
    // SAFETY: `sectors` was written. Of each row of sums, 2 * ROW bytes apart, and of the energies eight are written from `first` on, which
    // are there. Of the four inner lines 32 pixels are read.
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
            // Gray levels: those of four cells are a register; two of them are added, and then two such sums.
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
            out("lr") _,
            out("q0") _,
            out("q1") _,
            out("q2") _,
            out("q3") _,
            out("q4") _,
            row = const 2 * ROW,
            line = const COLUMNS,
            options(nostack),
        );
    }
}

/// The bytes of cells side by side, ten each: nine sums times the cell's number of `inverses`, less 16 places, at most 127; and the
/// tenth less 4 places, less 128. As many as `out` has room for.
///
/// No product reaches 2^32.
pub(crate) fn scale<const ROW: usize>(sums: &[[u16; ROW]], inverses: &[u32; ROW], out: &mut [[i8; CHANNELS]]) {
    let Some(sums) = sums.first_chunk::<CHANNELS>() else { return };
    const { assert!(ROW.is_multiple_of(LANES)) };
    if out.is_empty() || out.len() > ROW {
        return;
    }
    // SAFETY: of eight cells at a time sums and inverses are read, which are there: there are a multiple of eight. Of the bytes only those
    // of cells that are left are written.
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
            // The inverse's upper half counts whole, of its lower half the upper half of the product.
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
            out("r5") _,
            out("r8") _,
            in("r9") 128,
            out("lr") _,
            out("q0") _,
            out("q1") _,
            out("q2") _,
            out("q3") _,
            out("q6") _,
            out("q7") _,
            row = const 2 * ROW,
            options(nostack),
        );
    }
}
