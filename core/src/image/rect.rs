//! Rectangles: [`Rect`] in pixels, [`FineRect`] in units of 1/256 pixel.

/// A rectangle in whole pixels of the frame. It may reach outside the frame.
///
/// ```
/// use smr_core::Rect;
/// let target = Rect::new(-3, 5, 10, 8);
/// assert_eq!((target.right(), target.bottom()), (7, 13));
/// assert_eq!(target.intersection(Rect::new(0, 0, 64, 48)), Rect::new(0, 5, 7, 8));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rect {
    /// Left edge, in pixels to the right of the frame's left edge.
    pub x: i32,
    /// Top edge, in pixels below the frame's top edge.
    pub y: i32,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

impl Rect {
    /// The rectangle with its top left corner at (`x`, `y`).
    #[must_use]
    pub const fn new(x: i32, y: i32, width: u16, height: u16) -> Self {
        Self { x, y, width, height }
    }

    /// The first column to the right of the rectangle. Saturates at `i32::MAX`.
    #[must_use]
    pub const fn right(self) -> i32 {
        self.x.saturating_add(self.width as i32)
    }

    /// The first row below the rectangle. Saturates at `i32::MAX`.
    #[must_use]
    pub const fn bottom(self) -> i32 {
        self.y.saturating_add(self.height as i32)
    }

    /// The number of pixels: width * height.
    #[must_use]
    pub const fn area(self) -> u32 {
        self.width as u32 * self.height as u32
    }

    /// True if width or height is 0.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// True if all pixels of `inner` are in `self`. False if `inner` is empty.
    #[must_use]
    #[inline(never)]
    pub const fn contains(self, inner: Self) -> bool {
        !inner.is_empty()
            && inner.x >= self.x
            && inner.y >= self.y
            && inner.right() <= self.right()
            && inner.bottom() <= self.bottom()
    }

    /// The pixels in both rectangles; the empty rectangle at (0, 0) if there are none.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn intersection(self, other: Self) -> Self {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let width = extent(x, self.right().min(other.right()));
        let height = extent(y, self.bottom().min(other.bottom()));
        if width == 0 || height == 0 { Self::default() } else { Self::new(x, y, width, height) }
    }
}

/// `to - from`; 0 if negative or too large for a `u16`.
fn extent(from: i32, to: i32) -> u16 {
    u16::try_from(to.saturating_sub(from)).unwrap_or(0)
}

/// A rectangle in units of 1/256 pixel. It may reach outside the frame.
///
/// ```
/// use smr_core::{FineRect, Rect};
/// let fine = FineRect { x: 300, y: -100, width: 2560, height: 2600 };
/// assert_eq!(fine.whole(), Rect::new(1, 0, 10, 10));
/// assert_eq!(FineRect::from(Rect::new(1, 0, 10, 10)).x, 256);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineRect {
    /// Left edge, in units of 1/256 pixel.
    pub x: i32,
    /// Top edge, in units of 1/256 pixel.
    pub y: i32,
    /// Width, in units of 1/256 pixel.
    pub width: u32,
    /// Height, in units of 1/256 pixel.
    pub height: u32,
}

impl FineRect {
    /// The rectangle with each edge rounded to whole pixels; at least 1x1.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn whole(self) -> Rect {
        let round = |edge: i64| (edge + 128) >> 8;
        let (left, top) = (round(self.x.into()), round(self.y.into()));
        let side = |from: i32, size: u32, start: i64| {
            u16::try_from((round(i64::from(from) + i64::from(size)) - start).max(1)).unwrap_or(u16::MAX)
        };
        let (width, height) = (side(self.x, self.width, left), side(self.y, self.height, top));
        Rect::new(i32::try_from(left).unwrap_or(0), i32::try_from(top).unwrap_or(0), width, height)
    }
}

impl From<Rect> for FineRect {
    /// Converts pixels to units of 1/256 pixel. `x` and `y` saturate at the limits of an `i32`, about +-2^23 pixels.
    fn from(rect: Rect) -> Self {
        Self {
            x: rect.x.saturating_mul(256),
            y: rect.y.saturating_mul(256),
            width: u32::from(rect.width) << 8,
            height: u32::from(rect.height) << 8,
        }
    }
}
