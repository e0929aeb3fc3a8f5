//! Cells of the robust tracker by Helium: gradients of eight cells side by side, and their sums as bytes. A lane is a cell. The plain
//! loops are in `robust/gradients.rs` and `robust/features.rs`.

use core::arch::asm;
use core::mem::MaybeUninit;

/// Cells side by side.
pub(crate) const LANES: usize = 8;
/// Where lanes lie: bytes to a cell's pixels, and the first direction's sum of the sector 0.
static PLACES: [u16; 2 * LANES] = [0, 4, 8, 12, 16, 20, 24, 28, 32, 33, 34, 35, 36, 37, 38, 39];
/// Bytes to a cell's features.
static FEATURES: [u16; LANES] = [0, 10, 20, 30, 40, 50, 60, 70];

/// Sums of eight cells by the sector between two directions: of the sectors 4 to 0, then of those that mirror them, what the first
/// direction gets; then of all of these what the second one does.
#[repr(align(16))]
#[allow(dead_code)] // the assembler reads it
struct Sectors(MaybeUninit<[[u16; LANES]; 20]>);

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

/// The sums of eight cells, of which `block` says which eight: nine by direction, that of gray levels, and the energy. Nothing if they are
/// not on the lines or in the rows.
///
/// How far a gradient is beyond a direction, v = cos * up - sin * right, has 19 bits and a sign; all that is asked for is v / 64 and
/// -v / 64, rounded down. With v = 64 * f + t these are f + (t >> 6), here called F, and -F, less 1 unless v is a multiple of 64: all of
/// it fits in 16 bits. F never grows from a direction to the next one, so the smallest that is not negative, which is the smallest
/// without sign, is that of the sector's first direction.
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
pub(crate) fn eight_cells<const COLUMNS: usize, const ROW: usize>(
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
    // The pixel above and to the left of the first one.
    let pixels = lines.as_ptr().cast::<u8>().wrapping_add(at);
    // SAFETY: of six lines, COLUMNS bytes apart, 34 pixels are read, which are there. All of `sectors` is written; then the sums 0 to 79
    // are read and written by way of r1, those from 80 on by way of r2. r6 and r7, which may not be named, are kept on the stack.
    unsafe {
        asm!(
            "push {{r6, r7}}",
            "vmov.i32 q0, #0",
            "mov r4, r1",
            "mov lr, #5",
            "dls lr, lr",
            "0:",
            "vstrw.32 q0, [r4], #16",
            "vstrw.32 q0, [r4], #16",
            "vstrw.32 q0, [r4], #16",
            "vstrw.32 q0, [r4], #16",
            "le lr, 0b",
            "mov r4, #31",
            "mvn r5, #11",
            "mvn r7, #7",
            "mvn r8, #9",
            "mov r9, #9",
            "mov r10, #6",
            "mov r11, #11",
            "movs r6, #4",
            "1:",
            "mov lr, #4",
            "dls lr, lr",
            "2:",
            "vldrh.u16 q7, [r3]",
            "add r12, r0, #{right}",
            "vldrb.u16 q0, [r0, q7]",
            "vldrb.u16 q1, [r12, q7]",
            "sub r12, r12, #{above}",
            "vldrb.u16 q2, [r12, q7]",
            "add r12, r12, #{below}",
            "vldrb.u16 q3, [r12, q7]",
            "vsub.i16 q1, q1, q0",
            "vsub.i16 q3, q3, q2",
            // Mirrored where the signs differ. Where one of the two is 0 the outcome is the same.
            "veor q2, q1, q3",
            "vabs.s16 q1, q1",
            "vabs.s16 q0, q3",
            "vldrh.u16 q7, [r3, #16]",
            "mov r12, #40",
            "vpt.s16 lt, q2, zr",
            "vaddt.i16 q7, q7, r12",
            // q0 is up, q1 right. Directions 5 and 4: t in q5 and q3, F in q6 and q4.
            "vadd.i16 q2, q0, q0",
            "vmul.i16 q3, q1, r4",
            "vmul.i16 q4, q1, r5",
            "vsub.i16 q5, q3, q2",
            "vshr.s16 q6, q5, #6",
            "vsub.i16 q6, q6, q2",
            "vadd.i16 q6, q6, q4",
            "vadd.i16 q3, q3, q2",
            "vadd.i16 q2, q2, q4",
            "vshr.s16 q4, q3, #6",
            "vadd.i16 q4, q4, q2",
            // Where it is not beyond, that direction may be the sector's second one; else the sector is a farther one.
            "vptte.s16 lt, q4, zr",
            "vorrt q5, q3, q3",
            "vorrt q6, q4, q4",
            "vadde.i16 q7, q7, r7",
            // 3
            "vmul.i16 q2, q0, r8",
            "vmla.i16 q2, q1, r7",
            "vshr.s16 q3, q2, #6",
            "vmla.i16 q3, q0, r10",
            "vmla.i16 q3, q1, r8",
            "vmin.u16 q4, q4, q3",
            "vptte.s16 lt, q3, zr",
            "vorrt q5, q2, q2",
            "vorrt q6, q3, q3",
            "vadde.i16 q7, q7, r7",
            // 2
            "mvn r12, #2",
            "vmul.i16 q2, q1, r4",
            "vmla.i16 q2, q0, r12",
            "vshr.s16 q3, q2, #6",
            "vmla.i16 q3, q0, r9",
            "vmla.i16 q3, q1, r7",
            "vmin.u16 q4, q4, q3",
            "vptte.s16 lt, q3, zr",
            "vorrt q5, q2, q2",
            "vorrt q6, q3, q3",
            "vadde.i16 q7, q7, r7",
            // 1
            "mvn r12, #3",
            "vneg.s16 q2, q0",
            "vshr.s16 q3, q2, #6",
            "vmla.i16 q3, q0, r11",
            "vmla.i16 q3, q1, r12",
            "vmin.u16 q4, q4, q3",
            "vptte.s16 lt, q3, zr",
            "vorrt q5, q2, q2",
            "vorrt q6, q3, q3",
            "vadde.i16 q7, q7, r7",
            // 0
            "vmul.i16 q2, q0, r11",
            "vshr.u16 q3, q2, #4",
            "vadd.i16 q3, q3, q2",
            "vmin.u16 q4, q4, q3",
            // q4 is what the second direction gets; q6 what the first one does, -F, less 1 where the lowest six bits are not 0.
            "vshl.i16 q2, q5, #10",
            "vpte.i16 ne, q2, zr",
            "vmvnt q6, q6",
            "vnege.s16 q6, q6",
            "vldrh.u16 q0, [r1, q7, uxtw #1]",
            "vldrh.u16 q1, [r2, q7, uxtw #1]",
            "vadd.i16 q0, q0, q6",
            "vadd.i16 q1, q1, q4",
            "vstrh.16 q0, [r1, q7, uxtw #1]",
            "vstrh.16 q1, [r2, q7, uxtw #1]",
            "adds r0, #1",
            "le lr, 2b",
            "add r0, r0, #{next}",
            "subs r6, #1",
            "bne 1b",
            "pop {{r6, r7}}",
            inout("r0") pixels.wrapping_add(COLUMNS) => _,
            in("r1") &raw mut sectors,
            in("r2") (&raw mut sectors).cast::<[u16; LANES]>().wrapping_add(10),
            in("r3") &raw const PLACES,
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
            right = const 2,
            above = const COLUMNS + 1,
            below = const 2 * COLUMNS,
            next = const COLUMNS - 4,
        );
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
            "movs r4, #2",
            "2:",
            "vmov.i32 q2, #0",
            "mov r2, r3",
            "mov lr, #4",
            "dls lr, lr",
            "3:",
            "vldrb.u8 q0, [r2]",
            "add r2, r2, #{line}",
            "vmovlb.u8 q1, q0",
            "vmovlt.u8 q0, q0",
            "vadd.i16 q2, q2, q1",
            "vadd.i16 q2, q2, q0",
            "le lr, 3b",
            "vshr.u32 q0, q2, #16",
            "vadd.i16 q0, q0, q2",
            "vstrh.32 q0, [r0], #8",
            "adds r3, #16",
            "subs r4, #1",
            "bne 2b",
            inout("r0") sums.as_mut_ptr().cast::<u16>().wrapping_add(first) => _,
            in("r1") &raw const sectors,
            inout("r2") energies.as_mut_ptr().wrapping_add(first) => _,
            inout("r3") pixels.wrapping_add(COLUMNS + 1) => _,
            out("r4") _,
            out("lr") _,
            out("q0") _,
            out("q1") _,
            out("q2") _,
            out("q3") _,
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
pub(crate) fn scale<const ROW: usize>(sums: &[[u16; ROW]; 10], inverses: &[u32; ROW], out: &mut [[i8; 10]]) {
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
