//! A cache of limited size, keyed by frame number. It evicts the frames farthest from the one inserted last.

use std::collections::BTreeMap;

pub(super) struct FrameCache<T> {
    of: BTreeMap<usize, T>,
    /// Total size of the cached frames, in the unit of the function `size_of`. It is at most `most`, except that a
    /// single frame stays however large it is.
    size: usize,
    most: usize,
    size_of: fn(&T) -> usize,
}

impl<T> FrameCache<T> {
    pub const fn new(most: usize, size_of: fn(&T) -> usize) -> Self {
        Self { of: BTreeMap::new(), size: 0, most, size_of }
    }

    pub const fn all(&self) -> &BTreeMap<usize, T> {
        &self.of
    }

    pub fn keep(&mut self, number: usize, one: T) {
        self.size += (self.size_of)(&one);
        let mut gone = self.of.insert(number, one);
        loop {
            self.size -= gone.as_ref().map_or(0, self.size_of);
            if self.size <= self.most || self.of.len() < 2 {
                return;
            }
            let first = self.of.first_key_value().map_or(0, |(first, _)| *first);
            let is_far = self.of.last_key_value().is_some_and(|(last, _)| number - first <= last - number);
            gone = if is_far { self.of.pop_last() } else { self.of.pop_first() }.map(|(_, one)| one);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_bounded_and_near_the_newest() {
        let mut kept = FrameCache::new(9, |size: &usize| *size);
        (1..20).chain([3]).for_each(|number| kept.keep(number, 1));
        assert!(kept.all().keys().copied().eq([3].into_iter().chain(11..19)), "{:?}", kept.all());
        kept.keep(3, 5);
        assert_eq!((kept.all().len(), kept.size), (5, 9));
        kept.keep(7, 10);
        assert!(kept.all().keys().eq([&7]));
    }
}
