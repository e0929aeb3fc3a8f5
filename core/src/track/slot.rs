//! A value that may be missing, all zeroes if it is.

/// A value or none. None is 0, which an `Option` does not promise, so a tracker in a `static` takes no flash.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub(super) enum Slot<T> {
    Empty = 0,
    Full(T),
}

impl<T> Slot<T> {
    pub(super) const fn get(&self) -> Option<&T> {
        match self {
            Self::Empty => None,
            Self::Full(value) => Some(value),
        }
    }

    pub(super) const fn get_mut(&mut self) -> Option<&mut T> {
        match self {
            Self::Empty => None,
            Self::Full(value) => Some(value),
        }
    }

    /// The value, or `other` if there is none.
    pub(super) const fn or<'a>(&'a self, other: &'a T) -> &'a T {
        match self {
            Self::Empty => other,
            Self::Full(value) => value,
        }
    }
}
