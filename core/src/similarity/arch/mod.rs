//! The loops of `scalar.rs`, faster: one file an instruction set, and the choice between them.
//!
//! | file | instruction set | used when | tested |
//! |---|---|---|---|
//! | `x86/avx512.rs` | AVX-512 BW, VBMI and VNNI | found at run time (`std`) or compiled for; threshold up to 128 | where the machine has it |
//! | `x86/avx2.rs` | AVX2 | the same; any threshold | where the machine has it |
//! | `x86/sse2.rs` | SSE2, the least of x86-64 | every other x86-64 | on every x86-64 |
//! | `aarch64/neon.rs` | NEON | every AArch64 that is compiled for it | emulated by QEMU (`.ci/neon`), or natively |
//! | `arm/helium.rs` | Helium, the vectors of Armv8.1-M | compiled for it | `examples/kernels` on the emulated Cortex-M55 |
//! | `arm/dsp.rs` | DSP extension of Armv7E-M and Armv8-M | compiled for it, and not for Helium | `examples/kernels` on the emulated Cortex-M4 and M7 |
//! | (`scalar.rs`) | any | everywhere else | always |
//!
//! Words of four bytes by ordinary arithmetic do not pay where there is nothing better: on Armv6-M and RV32IMAC words cannot
//! be loaded from any address, and put together from bytes a distance takes 19 instead of 10 instructions a pixel on Armv6-M.
//!
//! `products/` has sums of products, by the same backends: what the robust tracker's filter is made of. `columns.rs`, `sectors.rs` (DSP)
//! and `arm/cells.rs` (Helium) are loops of its grid and features, `weights.rs` of its filter, by what the program is compiled for; answers on emulated parts and
//! the feature `verify` hold them against the plain loops.
//!
//! `generic.rs` has the loops that x86-64 and AArch64 share: there the file of an instruction set says only what a vector is and
//! how it looks a table up. The loops of `arm/` are by hand: they are `asm!`.
//!
//! `rows.rs` is what the kernels go through pictures by, `rolled.rs` keeps loops small; `verify.rs` has the plain loops beside them and
//! `verify_filter.rs` extreme values (feature `verify`).
//!
//! # Where weights would be added
//!
//! A weight for each pixel of the template, a small integer, would multiply what is looked up before it is added: in
//! `scalar::pixel`, which specifies it, in `generic::add_row` and in the loops of `arm/`. The
//! lookup and its tables stay as they are. Bounds then take the sum of the weights for the number of pixels.
//!
//! All `unsafe` of the crate is here. Every backend passes the same tests, which one macro stamps.

#![allow(unsafe_code)] // intrinsics; each block says why it is sound

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod aarch64 {
    pub(super) mod neon;
}
#[cfg(any(smr_dsp, smr_helium))]
mod arm {
    #[cfg(smr_helium)]
    pub(crate) mod cells;
    #[cfg(smr_dsp)]
    pub(super) mod dsp;
    mod filter;
    #[cfg(smr_helium)]
    pub(super) mod helium;
}
mod columns;
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
mod generic;
mod products;
mod rolled;
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon"), smr_dsp, smr_helium))]
mod rows;
#[cfg(smr_dsp)]
mod sectors;
mod weights;
#[cfg(target_arch = "x86_64")]
mod x86 {
    pub(super) mod avx2;
    pub(super) mod avx512;
    pub(super) mod sse2;
}

#[cfg(any(test, feature = "verify"))]
mod verify;
#[cfg(feature = "verify")]
mod verify_filter;

#[cfg(test)]
mod guard;
#[cfg(test)]
mod tests;

#[cfg(smr_helium)]
pub(crate) use arm::cells;
pub(crate) use columns::{Columns, LESS, Mixed};
pub(crate) use products::Products;
pub(crate) use rolled::{rolled, rolled_if_spare};
#[cfg(smr_dsp)]
pub(crate) use sectors::{Directions, sectors};
#[cfg(feature = "verify")]
pub use verify_filter::verify_filter;
pub(crate) use weights::{Move, Numbers, lessen_by};

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
use aarch64::neon;
#[cfg(smr_dsp)]
use arm::dsp;
#[cfg(smr_helium)]
use arm::helium;
#[cfg(target_arch = "x86_64")]
use x86::{avx2, avx512, sse2};

use super::{CutTable, Table, scalar};
use crate::image::Image;

/// A way to compute scores. All ways give the same integers.
///
/// # Where pixels may be
///
/// [`Backend::Dsp`] and [`Backend::Helium`] load words from any address, which Arm's microcontrollers do in Normal memory
/// only. External RAM in the region of Device memory (0xA000_0000 to 0xDFFF_FFFF of the default memory map) faults until
/// firmware has set up the MPU to make it Normal, and so does every other memory that the MPU makes Device or Strongly-ordered;
/// so does all memory while `UNALIGN_TRP` is set. Where this cannot be had, [`Backend::Scalar`] loads bytes only:
/// `Config::backend` of either tracker.
///
/// ```
/// use smr_core::similarity::Backend;
/// assert!(Backend::available().any(|backend| backend == Backend::Scalar));
/// assert!(Backend::available().any(|backend| backend == Backend::best()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Backend {
    /// The plain loop, the specification.
    Scalar,
    /// x86-64 with no more than every one has: distances, ranges and bounds 16 pixels at a time; a score is the plain
    /// loop's, begun only where a bound allows it to reach the floor.
    Sse2,
    /// x86-64 with AVX2: 32 pixels at a time.
    Avx2,
    /// x86-64 with AVX-512 BW, VBMI and VNNI: 64 pixels at a time.
    Avx512,
    /// AArch64 with NEON: 16 pixels at a time.
    Neon,
    /// The DSP extension of Armv7E-M and Armv8-M (Cortex-M4, M7, M33): 4 pixels at a time.
    Dsp,
    /// Helium, the vectors of Armv8.1-M (Cortex-M52, M55, M85): 16 pixels at a time.
    Helium,
}

impl Backend {
    const ALL: [Self; 7] = [Self::Avx512, Self::Avx2, Self::Sse2, Self::Neon, Self::Helium, Self::Dsp, Self::Scalar];

    /// The backends that this machine can run, the fastest first; [`Backend::Scalar`] is always the last.
    ///
    /// With the feature `std` the machine is asked at run time, else only what the program is compiled for counts.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|backend| backend.is_available())
    }

    /// The fastest of them.
    #[must_use]
    pub fn best() -> Self {
        Self::available().next().unwrap_or(Self::Scalar)
    }

    /// True if this machine can run it.
    #[must_use]
    pub fn is_available(self) -> bool {
        match self {
            Self::Scalar => true,
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => sse2::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::is_available(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => avx512::is_available(),
            Self::Neon => cfg!(all(target_arch = "aarch64", target_feature = "neon")),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Sse2 | Self::Avx2 | Self::Avx512 => false,
            Self::Dsp => cfg!(smr_dsp),
            Self::Helium => cfg!(smr_helium),
        }
    }
}

/// What a backend computes; the function of the same name in `scalar.rs` says what.
trait Kernels {
    /// Apart from `score_at_least`, so that a program which asks for no floor links no bound.
    #[inline(always)]
    fn score(&self, patch: Image<'_>, template: Image<'_>) -> u32 {
        self.score_at_least(patch, template, 0).unwrap_or(0)
    }

    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    /// This one need not be as exact: what it gives may be more, never less.
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32>;

    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32;

    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]);
}

/// A table, cut off at a threshold, made ready for a backend: scores, distances and bounds of pictures of up to
/// [`Table::MAX_PIXELS`] pixels.
///
/// ```
/// use smr_core::{Image, similarity::{Backend, CutTable, Scorer, Table}};
/// let (patch, template) = ([10, 10, 10, 10], [10, 11, 22, 23]);
/// let (patch, template) = (Image::new(&patch, 4, 1)?, Image::new(&template, 4, 1)?);
/// let table = CutTable::new(&Table::PAPER, 13);
/// let scorer = Scorer::new(Backend::best(), &table);
/// let p = |d| u32::from(Table::PAPER.similarity(d));
/// assert_eq!(scorer.score(patch, template), Some(p(0) + p(1) + p(12))); // a difference of 13 is not below the threshold
/// assert_eq!(scorer.score_at_least(patch, template, 3 * 65535), None);
/// assert_eq!(scorer.distance(patch, template, u32::MAX), Some(1 + 12 + 13));
/// assert!(scorer.score_between_at_least(patch, patch, template, 0) >= scorer.score(patch, template));
///
/// let rows = [[1, 5, 5, 5, 7], [5, 5, 5, 5, 5], [5, 5, 5, 5, 5], [5, 5, 9, 5, 5]];
/// let (mut low, mut high) = ([0; 2], [0; 2]);
/// scorer.spread(&rows.each_ref().map(|row| &row[..]), &mut low, &mut high);
/// assert_eq!((low, high), ([1, 5], [9, 9]));
/// # Ok::<(), smr_core::ImageError>(())
/// ```
pub struct Scorer<'a> {
    plain: Plain<'a>,
    ready: Ready<'a>,
}

#[allow(clippy::large_enum_variant)] // there is one at a time, on the stack
enum Ready<'a> {
    Scalar(Plain<'a>),
    #[cfg(target_arch = "x86_64")]
    Sse2(sse2::Bound<'a>),
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Lookup),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Lookup),
    #[cfg(smr_dsp)]
    Dsp(dsp::Dsp<'a>),
    #[cfg(smr_helium)]
    Helium(helium::Helium<'a>),
    #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
    Neon(neon::Lookup),
}

/// The plain loops.
#[derive(Clone, Copy)]
struct Plain<'a> {
    table: &'a CutTable,
}

impl Kernels for Plain<'_> {
    #[cfg_attr(any(smr_dsp, smr_helium), inline(never))] // one copy, for those who filter first, too
    fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        scalar::score_at_least(patch, template, self.table, floor)
    }

    #[inline] // into other crates, too
    fn score_between_at_least(&self, low: Image<'_>, high: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        scalar::score_between_at_least(low, high, template, self.table, floor)
    }

    #[inline] // into other crates, too
    fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
        scalar::distance(patch, template, enough)
    }

    #[inline] // into other crates, too
    fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        scalar::spread(rows, low, high);
    }
}

/// Calls the backend that a scorer was made for.
macro_rules! dispatch {
    ($scorer:ident, $kernels:ident => $call:expr) => {
        match &$scorer.ready {
            Ready::Scalar($kernels) => $call,
            #[cfg(target_arch = "x86_64")]
            Ready::Sse2($kernels) => $call,
            #[cfg(target_arch = "x86_64")]
            Ready::Avx2($kernels) => $call,
            #[cfg(target_arch = "x86_64")]
            Ready::Avx512($kernels) => $call,
            #[cfg(smr_dsp)]
            Ready::Dsp($kernels) => $call,
            #[cfg(smr_helium)]
            Ready::Helium($kernels) => $call,
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Ready::Neon($kernels) => $call,
        }
    };
}

impl<'a> Scorer<'a> {
    /// Scores by `table`, computed by `backend`; by the plain loop where the machine does not have it or
    /// it does not reach up to the threshold (AVX-512: 128).
    #[must_use]
    #[inline(always)] // made where it stays: some are too large to be moved about on a small stack
    pub fn new(backend: Backend, table: &'a CutTable) -> Self {
        let plain = Plain { table };
        let ready = match backend {
            #[cfg(target_arch = "x86_64")]
            Backend::Sse2 => sse2::Bound::new(table).map_or(Ready::Scalar(plain), Ready::Sse2),
            #[cfg(target_arch = "x86_64")]
            Backend::Avx2 => avx2::Lookup::new(table).map_or(Ready::Scalar(plain), Ready::Avx2),
            #[cfg(target_arch = "x86_64")]
            Backend::Avx512 => avx512::Lookup::new(table).map_or(Ready::Scalar(plain), Ready::Avx512),
            #[cfg(smr_dsp)]
            Backend::Dsp => Ready::Dsp(dsp::Dsp::new(table)),
            #[cfg(smr_helium)]
            Backend::Helium => Ready::Helium(helium::Helium::new(table)),
            #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
            Backend::Neon => Ready::Neon(neon::Lookup::new(table)),
            _ => Ready::Scalar(plain),
        };
        Self { plain, ready }
    }

    /// The sum of the similarities of two pictures of the same size (of two sizes, of their common top left part). `None` if
    /// it has more than [`Table::MAX_PIXELS`] pixels.
    #[must_use]
    #[inline(always)] // where there is only the plain loop, nothing is to be left of this but the call
    pub fn score(&self, patch: Image<'_>, template: Image<'_>) -> Option<u32> {
        checked(patch, template)?;
        let score = dispatch!(self, kernels => kernels.score(patch, template));
        #[cfg(feature = "verify")]
        verify::score(Some(score), (patch, template), self.plain.table, 0);
        Some(score)
    }

    /// The same score if it is at least `floor`; `None` also, as soon as that is certain, if it is less.
    #[must_use]
    #[inline(always)]
    pub fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        checked(patch, template)?;
        let score = dispatch!(self, kernels => kernels.score_at_least(patch, template, floor));
        #[cfg(feature = "verify")]
        verify::score(score, (patch, template), self.plain.table, floor);
        score
    }

    /// The sum of absolute differences (SAD). Once it is more than `enough`, any part of it that is. `None` as for
    /// [`Scorer::score`].
    #[must_use]
    #[inline(always)]
    pub fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> Option<u32> {
        checked(patch, template)?;
        let distance = dispatch!(self, kernels => kernels.distance(patch, template, enough));
        #[cfg(feature = "verify")]
        verify::distance(distance, (patch, template), enough);
        Some(distance)
    }

    /// The most that a patch scores which lies between two pictures, `low` nowhere above `high`, or a little more, if that is
    /// at least `floor`. `None` if no such patch scores as much, or as for [`Scorer::score`].
    #[must_use]
    #[inline(always)]
    pub fn score_between_at_least(
        &self,
        low: Image<'_>,
        high: Image<'_>,
        template: Image<'_>,
        floor: u32,
    ) -> Option<u32> {
        checked(low, template)?;
        let score = dispatch!(self, kernels => kernels.score_between_at_least(low, high, template, floor));
        #[cfg(feature = "verify")]
        verify::score_between(score, (low, high, template), self.plain.table, floor);
        score
    }

    /// The lowest and the highest of each block of 4x4 pixels, by the block's first column. The rows have three pixels more
    /// than `low` and `high`.
    #[inline(always)]
    pub fn spread(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        dispatch!(self, kernels => kernels.spread(rows, low, high));
        #[cfg(feature = "verify")]
        verify::spread(rows, low, high);
    }

    /// The score of what lies on the padding; see [`scalar::score_on_padding`].
    #[must_use]
    pub(super) fn score_on_padding(&self, template: Image<'_>, seen: crate::Rect) -> u32 {
        scalar::score_on_padding(template, seen, self.plain.table)
    }
}

/// `None` where a sum could be too large for a backend.
#[inline(always)]
fn checked(patch: Image<'_>, template: Image<'_>) -> Option<()> {
    (scalar::pixels(patch, template) <= Table::MAX_PIXELS).then_some(())
}
