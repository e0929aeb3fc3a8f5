//! The windows of a frame that a tracker reads.

use super::Rect;
use core::array;
use core::iter::Flatten;

/// The windows of a frame that a tracker reads, from [`Tracker::windows`](crate::Tracker::windows): one or two
/// rectangles inside the frame.
///
/// [`Readout::new`](crate::readout::Readout::new) keeps only the pixels of these windows, and
/// [`Frame::of_windows`](crate::Frame::of_windows) makes a frame of them. Both take the pixels window by window, each
/// row by row without gaps. A [`Rect`], such as that of [`Tracker::lock_window`](crate::Tracker::lock_window), becomes
/// a single window.
///
/// ```
/// use smr_core::{Rect, Windows};
/// let windows = Windows::new(Rect::new(40, 30, 20, 10), Some(Rect::new(0, 0, 8, 8)));
/// assert_eq!(windows.pixels(), 264); // the size of the buffer in bytes
/// let mut rows = 0;
/// for window in windows {
///     rows += window.height; // here a sensor would be told to send these pixels
/// }
/// assert_eq!(rows, 18);
/// assert_eq!(Windows::from(Rect::new(40, 30, 20, 10)).pixels(), 200);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Windows([Option<Rect>; 2]);

impl Windows {
    /// One or two windows. They may overlap.
    #[must_use]
    pub const fn new(first: Rect, second: Option<Rect>) -> Self {
        Self([Some(first), second])
    }

    #[inline]
    pub(crate) fn split(self) -> (Rect, Option<Rect>) {
        let Self([first, second]) = self;
        (first.unwrap_or_default(), second)
    }

    /// The number of pixels of all windows: the bytes of a buffer for them. Pixels where windows overlap count twice.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.iter().fold(0, |sum, window| sum.saturating_add(area(window)))
    }

    /// The windows, in the order of their pixels.
    pub fn iter(&self) -> Flatten<array::IntoIter<Option<Rect>, 2>> {
        self.into_iter()
    }
}

/// The number of pixels of a window. No window inside a frame has more than a `usize` of 32 bits holds.
pub(super) fn area(window: Rect) -> usize {
    usize::from(window.width).saturating_mul(window.height.into())
}

impl IntoIterator for Windows {
    type Item = Rect;
    type IntoIter = Flatten<array::IntoIter<Option<Rect>, 2>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter().flatten()
    }
}

impl IntoIterator for &Windows {
    type Item = Rect;
    type IntoIter = Flatten<array::IntoIter<Option<Rect>, 2>>;

    fn into_iter(self) -> Self::IntoIter {
        (*self).into_iter()
    }
}

impl From<Rect> for Windows {
    fn from(window: Rect) -> Self {
        Self::new(window, None)
    }
}
