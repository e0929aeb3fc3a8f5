//! The similarity kernels behind one type: a [`Scorer`] selects the kernels of a backend and checks their arguments.

#[cfg(smr_dsp)]
use super::arm::dsp::scores::Dsp;
#[cfg(smr_helium)]
use super::arm::helium::scores::Helium;
#[cfg(any(smr_dsp, smr_helium))]
use super::arm::scores::Kernels;
use super::backend::{Backend, by_backend};
use super::cut_table::CutTable;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
use super::neon;
use super::plain::scores::{self as plain, Plain};
use super::scores::{Blocks, MAX_PIXELS, RowsOfRanges, Scores};
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use super::simd128;
#[cfg(not(any(smr_dsp, smr_helium)))]
use super::swar::scores as swar;
#[cfg(target_arch = "x86_64")]
use super::x86::{avx2, ssse3};
use crate::image::{Image, Rect};

/// Computes scores and distances of two pictures on a backend. Scores use a [`CutTable`]. The common part of the
/// pictures has at most [`Table::MAX_PIXELS`](crate::similarity::Table::MAX_PIXELS) pixels.
pub struct Scorer<'a> {
    plain: Plain<'a>,
    ready: Ready<'a>,
}

impl core::fmt::Debug for Scorer<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Scorer").field("threshold", &self.plain.table.threshold()).finish_non_exhaustive()
    }
}

#[allow(clippy::large_enum_variant)] // one at a time, on the stack
enum Ready<'a> {
    Scalar(Plain<'a>),
    #[cfg(target_arch = "x86_64")]
    Ssse3(ssse3::Lookup),
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Lookup),
    #[cfg(smr_dsp)]
    Dsp(Kernels<'a, Dsp>),
    #[cfg(smr_helium)]
    Helium(Kernels<'a, Helium>),
    #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
    Neon(neon::Lookup),
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Simd128(simd128::Lookup),
    #[cfg(not(any(smr_dsp, smr_helium)))]
    Swar(swar::Swar<'a>),
}

impl<'a> Scorer<'a> {
    /// Prepares `table` for `backend`, or for the plain loop if the machine does not support the backend.
    #[must_use]
    #[inline(always)] // built in place: some are too large to be moved on a small stack
    pub fn new(backend: Backend, table: &'a CutTable) -> Self {
        let plain = Plain { table };
        #[allow(unused_unsafe)] // not every target has such vectors
        // SAFETY: a lookup by vectors is made only where the machine has their instructions.
        let ready = unsafe {
            match backend {
                #[cfg(target_arch = "x86_64")]
                Backend::Ssse3 if backend.is_available() => Ready::Ssse3(ssse3::Lookup::shuffled(table)),
                #[cfg(target_arch = "x86_64")]
                Backend::Avx2 if backend.is_available() => Ready::Avx2(avx2::Lookup::shuffled(table)),
                #[cfg(smr_dsp)]
                Backend::Dsp => Ready::Dsp(Kernels::new(table)),
                #[cfg(smr_helium)]
                Backend::Helium => Ready::Helium(Kernels::new(table)),
                #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
                Backend::Neon => Ready::Neon(neon::Lookup::new(table)),
                #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
                Backend::Simd128 => Ready::Simd128(simd128::Lookup::new(table)),
                #[cfg(not(any(smr_dsp, smr_helium)))]
                Backend::Swar => Ready::Swar(swar::Swar::new(table)),
                _ => Ready::Scalar(plain),
            }
        };
        Self { plain, ready }
    }

    /// The score: the sum of the similarities of all pairs of pixels. If the sizes differ, the common top left part is
    /// compared. `None` if it has more than [`Table::MAX_PIXELS`](crate::similarity::Table::MAX_PIXELS) pixels.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline(always))] // with only the plain loop, just its call remains
    pub fn score(&self, patch: Image<'_>, template: Image<'_>) -> Option<u32> {
        checked(patch, template)?;
        Some(by_backend!(&self.ready, Ready(kernels) => kernels.score(patch, template)))
    }

    /// The score if it is at least `floor`. `None` as soon as the remaining pixels cannot reach `floor`.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline(always))]
    pub fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        checked(patch, template)?;
        by_backend!(&self.ready, Ready(kernels) => kernels.score_at_least(patch, template, floor))
    }

    /// The sum of absolute differences (SAD). Once it exceeds `enough`, rows may be skipped: the result is then more
    /// than `enough` and at most the SAD. `None` as for [`Scorer::score`].
    #[must_use]
    #[inline(always)]
    pub fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> Option<u32> {
        checked(patch, template)?;
        Some(by_backend!(&self.ready, Ready(kernels) => kernels.distance(patch, template, enough)))
    }

    /// True if this target can bound the scores of four neighbouring offsets faster than it computes them.
    pub(crate) const BOUNDS_FOUR: bool = cfg!(any(
        smr_dsp,
        smr_helium,
        target_arch = "riscv32",
        target_arch = "riscv64",
        target_arch = "xtensa",
        target_arch = "arm"
    )) || Self::RANGES_OF_ROWS;

    /// Bit mask of the offsets in `wanted` (up to four neighbours) whose score may reach `floor`; see
    /// [`Scores::candidates`]. Returns `wanted` if the template has more than `MAX_PIXELS` pixels, or if the patch has
    /// fewer rows than the template or fewer than three more columns.
    #[inline(always)]
    pub(crate) fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
        let fits = u32::from(patch.width()) >= u32::from(template.width()) + 3 && patch.height() >= template.height();
        if !fits || checked(patch, template).is_none() {
            return wanted;
        }
        // SAFETY: the patch has at least as many rows as the template, and three more columns.
        unsafe { by_backend!(&self.ready, Ready(kernels) => kernels.candidates(patch, template, floor, wanted)) }
    }

    /// Computes the lowest and the highest pixel of 4x4 blocks for [`Scorer::bound`], as the backend encodes them. The
    /// addresses and lengths of `low` and `high` are multiples of four. Each row has three more pixels than `low`.
    #[inline(always)]
    pub(crate) fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
        debug_assert!(low.len() == high.len() && low.len().is_multiple_of(4));
        debug_assert!([low.as_ptr(), high.as_ptr()].iter().all(|at| at.addr().is_multiple_of(4)));
        by_backend!(&self.ready, Ready(kernels) => kernels.ranges(rows, low, high));
    }

    /// True if a backend of this target computes ranges of 4x4 blocks faster in several rows at once than row by row.
    pub(crate) const RANGES_OF_ROWS: bool = cfg!(any(
        target_arch = "x86_64",
        all(target_arch = "aarch64", target_feature = "neon"),
        all(target_arch = "wasm32", target_feature = "simd128")
    ));

    /// Computes pixel ranges of the 4x4 blocks that begin in every `step`th row; see [`Scores::ranges_of_rows`].
    #[inline(always)]
    pub(crate) fn ranges_of_rows(&self, pixels: Image<'_>, step: usize, mut to: RowsOfRanges<'_>) -> bool {
        by_backend!(&self.ready, Ready(kernels) => kernels.ranges_of_rows(pixels, step, &mut to))
    }

    /// Upper bound of the score of every patch with pixels in the ranges `blocks`. `None` if it is below `floor`.
    #[inline(always)]
    pub(crate) fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
        debug_assert!(blocks.stride.is_multiple_of(4));
        by_backend!(&self.ready, Ready(kernels) => kernels.bound(blocks, template, floor))
    }

    /// The score of those pixels of `template` that lie on the zero padding around the frame. `seen` is the part of the
    /// template on the frame, in template coordinates; it may be empty. The template has at most `MAX_PIXELS` pixels.
    #[must_use]
    pub(crate) fn score_on_padding(&self, template: Image<'_>, seen: Rect) -> u32 {
        let (width, height, right, bottom) = (template.width(), template.height(), seen.right(), seen.bottom());
        let [over, left] = [seen.y, seen.x].map(|size| u16::try_from(size).unwrap_or(0));
        let rest = |all: u16, from: i32| u16::try_from(i32::from(all) - from).unwrap_or(0);
        let mut sum = 0;
        for part in [
            Rect::new(0, 0, width, over),
            Rect::new(0, bottom, width, rest(height, bottom)),
            Rect::new(0, seen.y, left, seen.height),
            Rect::new(right, seen.y, rest(width, right), seen.height),
        ] {
            sum += self.score_on_black(template, part);
        }
        sum
    }

    /// The score of this part of a template on black pixels; 0 if the part is empty.
    #[cfg(smr_swar)]
    #[inline(always)]
    fn score_on_black(&self, template: Image<'_>, part: Rect) -> u32 {
        template.crop(part).map_or(0, |template| swar::score_on_black(template, self.plain.table))
    }

    /// The score of this part of a template on black pixels; 0 if the part is empty.
    #[cfg(not(smr_swar))]
    #[inline(always)]
    fn score_on_black(&self, template: Image<'_>, mut part: Rect) -> u32 {
        let (mut sum, end) = (0, part.right());
        while part.x < end {
            part.width = u16::try_from((end - part.x).min(BLACK_PIXELS.into())).unwrap_or(0);
            if let Some(template) = template.crop(part)
                && let Some(black) = Image::repeated(&BLACK, part.width, part.height)
            {
                sum +=
                    by_backend!(&self.ready, Ready(kernels) => kernels.score_at_least(black, template, 0)).unwrap_or(0);
            }
            part.x += i32::from(part.width);
        }
        sum
    }
}

#[cfg(not(smr_swar))]
static BLACK: [u8; BLACK_PIXELS as usize] = [0; BLACK_PIXELS as usize];
#[cfg(not(smr_swar))]
const BLACK_PIXELS: u8 = 64;

/// `None` if the common part of the pictures has too many pixels for a sum in a `u32`.
#[inline(always)]
fn checked(patch: Image<'_>, template: Image<'_>) -> Option<()> {
    (plain::pixels(patch, template) <= MAX_PIXELS).then_some(())
}
