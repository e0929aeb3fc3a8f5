//! Compiles the loops for a backend, with the features of its instruction set.

/// Implements `Scores` for a `Lookup`. Each listed segment count gets a loop of its own, which also serves smaller
/// counts. Pixel ranges use the first listed vector type that fits in a row.
macro_rules! scores {
    (
        $backend:ty, $planes:ident, $vector:ty $(, or $shorter:ty)?, $features:literal,
        segments: $($segments:literal)* or $most:literal
    ) => {const _: () = {
        use $crate::image::Image;
        use $crate::kernels::generic::{self, by_width, compiled};
        use $crate::kernels::plain::scores as plain;
        use $crate::kernels::rows::Rows;
        use $crate::kernels::scores::{Blocks, RowsOfRanges, Scores};

        impl Scores for $backend {
            #[inline(always)]
            fn score_at_least(&self, patch: Image<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
                let rows = Rows::of(patch, template);
                // SAFETY: a backend exists only if the machine has its instructions, and the pictures are borrowed.
                unsafe {
                    match self.segments {
                        $(..=$segments => self.sum_by_width::<$segments>(&rows, floor),)*
                        _ => self.sum_by_width::<$most>(&rows, floor),
                    }
                }
            }

            #[inline(always)]
            fn ranges(&self, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
                // SAFETY: a backend exists only if the machine has its instructions.
                unsafe { ranges(rows, self.last.unwrap_or(0), low, high) }
            }

            #[inline(always)]
            fn ranges_of_rows(&self, pixels: Image<'_>, step: usize, to: &mut RowsOfRanges<'_>) -> bool {
                // SAFETY: a backend exists only if the machine has its instructions.
                unsafe { ranges_of_rows(pixels, step, self.last.unwrap_or(0), to) }
            }

            #[inline(always)]
            fn bound(&self, blocks: &Blocks<'_>, template: Image<'_>, floor: u32) -> Option<u32> {
                let Some(rows) = Rows::of_blocks(blocks, template) else { return Some(plain::most(template, template)) };
                if self.last.is_none() {
                    return Some(0).filter(|_| floor == 0);
                }
                // SAFETY: the backend exists, so the machine has its instructions. `of_blocks` found a range for each
                // pixel of the template, and both are borrowed.
                unsafe { by_width!(rows.width, $vector, inside_at_least::<WHOLE, END>(&rows, floor)) }
            }

            /// # Safety
            /// The patch has at least as many rows as the template, and three more columns.
            #[inline(always)]
            unsafe fn candidates(&self, patch: Image<'_>, template: Image<'_>, floor: u32, wanted: u8) -> u8 {
                if !self.candidates.is_worth_it() {
                    return wanted;
                }
                let (rows, last) = (Rows::of(patch, template), self.last.unwrap_or(0));
                // SAFETY: the backend exists, so the machine has its instructions. The pictures are borrowed, and the
                // patch has three more columns than the template.
                let candidates = unsafe { by_width!(rows.width, $vector, candidates::<WHOLE, END>(&rows, last, floor)) } & wanted;
                self.candidates.note(candidates != wanted);
                candidates
            }

            #[inline(always)]
            fn distance(&self, patch: Image<'_>, template: Image<'_>, enough: u32) -> u32 {
                let rows = Rows::of(patch, template);
                // SAFETY: the backend exists, so the machine has its instructions, and the pictures are borrowed.
                unsafe { by_width!(rows.width, $vector, distance::<WHOLE, END>(&rows, enough)) }
            }
        }

        impl $backend {
            /// # Safety
            /// The processor has the features. `rows.width` pixels can be read in each row of the patch and the
            /// template.
            #[target_feature(enable = $features)]
            unsafe fn sum_by_width<const SEGMENTS: usize>(&self, rows: &Rows, floor: u32) -> Option<u32> {
                // SAFETY: the processor has the features, and each row its pixels; `by_width!` counts their vectors.
                unsafe { by_width!(rows.width, $vector, self.sum_at_least::<SEGMENTS, WHOLE, END>(rows, floor)) }
            }

            /// # Safety
            /// The processor has the features. `rows.width` pixels can be read in each row of the patch and the
            /// template. `WHOLE` and `END` are those of `by_width!` for `rows.width`.
            #[target_feature(enable = $features)]
            unsafe fn sum_at_least<const SEGMENTS: usize, const WHOLE: usize, const END: bool>(
                &self,
                rows: &Rows,
                floor: u32,
            ) -> Option<u32> {
                // SAFETY: the processor has the features, and each row its pixels, in vectors as `WHOLE` and `END` say.
                unsafe { generic::sum_at_least::<_, WHOLE, END>(&$planes::<SEGMENTS>::of(self), rows, floor) }
            }
        }

        compiled! { $features, $vector:
            fn inside_at_least(rows: &Rows, floor: u32) -> Option<u32>;
            fn candidates(rows: &Rows, last: u8, floor: u32) -> u8;
            fn distance(rows: &Rows, enough: u32) -> u32;
        }

        /// # Safety
        /// The processor has the features.
        #[target_feature(enable = $features)]
        unsafe fn ranges_of_rows(pixels: Image<'_>, step: usize, last: u8, to: &mut RowsOfRanges<'_>) -> bool {
            // SAFETY: the processor has the features, and with them the instruction sets of both vectors.
            unsafe {
                generic::ranges_of_rows::<$vector>(pixels, step, last, to)
                    $(|| generic::ranges_of_rows::<$shorter>(pixels, step, last, to))?
            }
        }

        /// # Safety
        /// The processor has the features.
        #[target_feature(enable = $features)]
        unsafe fn ranges(rows: &[&[u8]; 4], last: u8, low: &mut [u8], high: &mut [u8]) {
            // SAFETY: the processor has the features, and with them the instruction sets of both vectors.
            if !unsafe {
                generic::spread::<$vector>(rows, low, high) $(|| generic::spread::<$shorter>(rows, low, high))?
            } {
                plain::spread(rows, low, high);
            }
            generic::widen_all(low, high, last);
        }
    };};
}

/// Compiles loops of this folder with the features of an instruction set.
macro_rules! compiled {
    ($features:literal, $vector:ty: $(fn $name:ident($rows:ident: &Rows $(, $argument:ident: $of:ty)*) -> $to:ty;)*) => {$(
        /// # Safety
        /// The processor has the features. `rows.width` pixels can be read in each row of the pictures, and for
        /// `candidates` three more in each row of the patch. `WHOLE` and `END` are those of `by_width!` for the width.
        #[target_feature(enable = $features)]
        unsafe fn $name<const WHOLE: usize, const END: bool>($rows: &Rows $(, $argument: $of)*) -> $to {
            // SAFETY: the processor has the features, and each row its pixels, in vectors as `WHOLE` and `END` say.
            unsafe { generic::$name::<$vector, WHOLE, END>($rows $(, $argument)*) }
        }
    )*};
}

pub(crate) use {compiled, scores};
