//! Columns of a grid: each is mixed of two numbers of a row that stand side by side, by fractions of 1/256.
//!
//! `smlad` of the DSP extension does it in one instruction, for which the numbers have a sign: 2^15 less than they are. Helium
//! mixes four columns at a time.

#[cfg(any(smr_dsp, smr_helium))]
use core::arch::asm;
use heapless::Vec;

/// Numbers that a column can begin on.
const PLACES: u16 = 512;
/// What columns are mixed of: 256 times gray levels, less [`LESS`] in two's complement. After the last place there may be one more.
pub(crate) type Mixed = [u16; PLACES as usize + 4];

/// So much less are the numbers of a row.
pub(crate) const LESS: u16 = if cfg!(smr_dsp) { 1 << 15 } else { 0 };

/// One column.
#[cfg(smr_dsp)]
macro_rules! column {
    () => {
        concat!(
            "ldrh {pair}, [{from}], #2\n",
            "ldr {part}, [{parts}], #4\n",
            "ldr {pair}, [{row}, {pair}]\n",
            "smlad {pair}, {pair}, {part}, {half}\n",
            "lsrs {pair}, {pair}, #16\n",
            "strb {pair}, [{out}], #1\n",
        )
    };
}

/// Where so many columns are.
pub(crate) struct Columns<const N: usize> {
    /// Bytes from the row's start to the first of the two numbers.
    from: Vec<u16, N>,
    /// The parts of the first one and of the second one, which are 256 together.
    parts: Vec<[u16; 2], N>,
}

impl<const N: usize> Columns<N> {
    /// There are fewer places than that.
    pub(crate) const PLACES: usize = PLACES as usize;

    #[inline(always)] // made where it stays
    pub(crate) const fn new() -> Self {
        Self { from: Vec::new(), parts: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.from.clear();
        self.parts.clear();
    }

    /// How many columns there are.
    pub(crate) fn count(&self) -> usize {
        self.from.len()
    }

    /// A column `part` 256ths of the way from the number at `place` to the next one; none if there is no room.
    pub(crate) fn push(&mut self, place: u16, part: u8) {
        let _ = self.from.push(2 * (place % PLACES));
        let _ = self.parts.push([256 - u16::from(part), part.into()]);
    }

    /// The gray levels of the columns in `row`, rounded, as many as `out` has room for.
    #[inline(always)] // into its one caller
    pub(crate) fn mix(&self, row: &Mixed, out: &mut [u8]) {
        #[cfg(any(smr_dsp, smr_helium))]
        {
            self.fast(row, out);
            #[cfg(feature = "verify")]
            for (number, (&out, wanted)) in out.iter().zip(self.each(row)).enumerate() {
                assert_eq!(out, wanted, "column {number}");
            }
        }
        #[cfg(not(any(smr_dsp, smr_helium)))]
        out.iter_mut().zip(self.each(row)).for_each(|(out, level)| *out = level);
    }

    /// The plain loop.
    #[allow(dead_code)] // for those who have no faster one
    fn each(&self, row: &Mixed) -> impl Iterator<Item = u8> {
        self.from.iter().zip(&self.parts).map(|(&from, parts)| {
            let pair = row.get(usize::from(from / 2)..).and_then(|row| row.first_chunk()).copied().unwrap_or([0; 2]);
            let [first, second] = pair.map(|number| u32::from(number.wrapping_add(LESS)));
            let [rest, part] = parts.map(u32::from);
            let [_, _, level, _] = (first * rest + second * part + (1 << 15)).to_le_bytes();
            level
        })
    }

    #[cfg(smr_dsp)]
    fn fast(&self, row: &Mixed, out: &mut [u8]) {
        let count = out.len().min(self.from.len()).min(self.parts.len());
        if count == 0 {
            return;
        }
        // SAFETY: `count` numbers of each are there. A place is below PLACES, so the pair is in the row, and it need not be aligned.
        unsafe {
            asm!(
                "tst {count}, #1",
                "beq 2f",
                column!(),
                "subs {count}, #1",
                "beq 3f",
                "2:",
                column!(),
                column!(),
                "subs {count}, #2",
                "bne 2b",
                "3:",
                from = inout(reg) self.from.as_ptr() => _,
                parts = inout(reg) self.parts.as_ptr() => _,
                out = inout(reg) out.as_mut_ptr() => _,
                count = inout(reg) count => _,
                row = in(reg) row.as_ptr(),
                half = in(reg) (1 << 23) + (1 << 15),
                pair = out(reg) _,
                part = out(reg) _,
                options(nostack),
            );
        }
    }

    #[cfg(smr_helium)]
    fn fast(&self, row: &Mixed, out: &mut [u8]) {
        let count = out.len().min(self.from.len()).min(self.parts.len());
        if count == 0 {
            return;
        }
        // SAFETY: `count` numbers of each are there, and the last round has as many lanes as are left. A place is below PLACES, so the
        // pair is in the row, and it need not be aligned.
        unsafe {
            asm!(
                "dlstp.32 lr, {count}",
                "2:",
                "vldrh.u32 q0, [r0], #8",
                "vldrb.u8 q1, [{parts}], #16",
                "vldrw.u32 q2, [{row}, q0]",
                "vmullb.u16 q0, q2, q1",
                "vmullt.u16 q2, q2, q1",
                "vadd.i32 q0, q0, q2",
                "vrshr.u32 q0, q0, #16",
                "vstrb.32 q0, [r1], #4",
                "letp lr, 2b",
                parts = inout(reg) self.parts.as_ptr() => _,
                count = in(reg) count,
                row = in(reg) row.as_ptr(),
                // A load that widens, and a store that narrows, take only r0 to r7.
                inout("r0") self.from.as_ptr() => _,
                inout("r1") out.as_mut_ptr() => _,
                out("lr") _,
                out("q0") _,
                out("q1") _,
                out("q2") _,
                options(nostack),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_rounded_means() {
        let mut columns = Columns::<5>::new();
        for (place, part) in [(0, 0), (0, 128), (1, 255), (511, 0), (511, 0), (0, 0)] {
            columns.push(place, part);
        }
        let mut row: Mixed = [0; PLACES as usize + 4];
        (row[1], row[2], row[511]) = (1 << 8, 255 << 8, 255 << 8);
        row.iter_mut().for_each(|level| *level = level.wrapping_sub(LESS));
        let mut out = [7; 7];
        columns.mix(&row, &mut out);
        assert_eq!(out, [0, 1, 254, 255, 255, 7, 7]);
    }
}
