//! The sizes of a robust tracker, and the memory of each. Arrays need lengths at compile time, so each size names its own
//! vectors; the stages get views of them, and are compiled once for all sizes.

use super::super::config::Config;
use super::super::constants::Limits;
use super::super::decision::memory::Learned;
use super::super::features::Grid;
use super::super::filter::{Filter, scale};
use super::super::verification::{Template, agreement};
use super::buffers::{self, Buffers, Scratch};
use crate::image::Rect;

/// A size of [`Robust`](crate::Robust): how finely it samples its target, how far it searches, and so its memory and
/// its work. The trait is sealed: [`Standard`] and [`Small`] implement it.
///
/// | | [`Standard`] | [`Small`] |
/// |---|---|---|
/// | pixels of the template, at most | 1600 | 1296 |
/// | cells of the filter, at most | 200 | 162 |
/// | radius of the search, in cells, at most | 8 | 7 |
///
/// Targets and flight records of one size cannot be continued with the other.
#[allow(private_bounds)] // which seals the trait
pub trait Size: Stored {
    /// Pixels of the largest template. The target is resampled to a grid on which it has about this many pixels.
    const PIXELS: u16 = Self::LIMITS.pixels;
    /// The largest `Config::reach`: the radius of the search window, in cells.
    const REACH: u16 = Self::LIMITS.reach;
}

/// The memory of a size.
pub(in crate::track::robust) trait Stored: 'static {
    const LIMITS: Limits;
    /// The learned part of a target. `UNLEARNED` is all zero bytes.
    type Learned;
    const UNLEARNED: Self::Learned;
    /// The scratch memory of the stages. `UNUSED` is all zero bytes.
    type Scratch;
    const UNUSED: Self::Scratch;

    fn learned(of: &Self::Learned) -> (&Filter, &Template);
    fn learned_mut(of: &mut Self::Learned) -> (&mut Filter, &mut Template);
    fn buffers(of: &mut Self::Scratch) -> Buffers<'_>;
}

macro_rules! size {
    ($(#[$about:meta])* $name:ident, $limits:expr) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;

        impl Size for $name {}

        impl Stored for $name {
            const LIMITS: Limits = $limits;
            type Learned = Learned<{ $limits.weights() }, { $limits.pixels as usize }>;
            const UNLEARNED: Self::Learned = Learned::new();
            type Scratch = Scratch<
                { $limits.weights() },
                { $limits.pixels as usize },
                { buffers::most_bytes($limits) },
                { scale::most_bytes($limits) },
                { agreement::most_pixels_of_a_view($limits) },
            >;
            const UNUSED: Self::Scratch = Scratch::new();

            fn learned(of: &Self::Learned) -> (&Filter, &Template) {
                of.parts()
            }

            fn learned_mut(of: &mut Self::Learned) -> (&mut Filter, &mut Template) {
                of.parts_mut()
            }

            fn buffers(of: &mut Self::Scratch) -> Buffers<'_> {
                of.buffers()
            }
        }
    };
}

size! {
    /// The size with which the settings were chosen and most results measured. It takes 50.6 KB of memory, 51.7 KB with the
    /// refiner.
    Standard, Limits::STANDARD
}
size! {
    /// The size for chips with little RAM. It takes 43.4 KB of memory, 44.5 KB with the refiner, and four fifths of the work.
    Small, Limits::SMALL
}

impl Config {
    /// This configuration for a tracker of size `S`: lowers `reach` and its range to those of the size.
    ///
    /// ```
    /// use smr_core::{Settings, robust::{Config, Small}};
    /// let mut config = Config::robust().within::<Small>();
    /// assert_eq!(config.reach, 7);
    /// assert_eq!(config.set("reach", &[8]).unwrap_err().to_string(), "reach is 4 to 7, not 8");
    /// ```
    #[must_use]
    #[allow(clippy::cast_possible_truncation)] // at most 8
    pub const fn within<S: Size>(self) -> Self {
        let max_reach = S::REACH as u8;
        Self { max_reach, reach: if self.reach < max_reach { self.reach } else { max_reach }, ..self }
    }
}

impl Grid {
    /// The grid for a box of this size in a tracker of size `S`: see [`Grid::new`].
    ///
    /// ```
    /// use smr_core::{Rect, robust::{Grid, Small}};
    /// let grid = Grid::of_size::<Small>(Rect::new(0, 0, 72, 72));
    /// assert_eq!((grid.columns, grid.rows, grid.step), (36, 36, 2 * 4096));
    /// ```
    #[must_use]
    pub fn of_size<S: Size>(target: Rect) -> Self {
        Self::within(S::LIMITS, target)
    }
}
