//! What the page has not heard yet: a list of what changed, of which each page has read a part.

use std::collections::VecDeque;

/// Something that the page is told.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    /// There is an answer for a target in a frame.
    Row { target: u32, frame: usize },
    /// The answers for a target in these frames are void until they come again.
    Clear { target: u32, from: usize, to: usize },
    /// A line for the user.
    Said(String),
    /// How many frames there are, or their times, changed.
    Frames,
    /// A file that is being made for the user has progressed.
    Made(u32),
}

/// The most items in the list. When it is full, it is replaced by all that is true now.
const MOST: usize = 1 << 20;
/// The most answers in one reply.
const PORTION: usize = 5000;

#[derive(Default)]
pub(super) struct News {
    items: VecDeque<Item>,
    /// The position of the first of them.
    base: u64,
}

impl News {
    pub fn add(&mut self, item: Item) {
        self.items.push_back(item);
    }

    pub fn is_full(&self) -> bool {
        self.items.len() >= MOST
    }

    /// Puts `now`, all that is true now, in place of what was remembered.
    pub fn renew(&mut self, now: impl Iterator<Item = Item>) {
        self.base += self.items.len() as u64;
        self.items = now.collect();
    }

    pub fn end(&self) -> u64 {
        self.base + self.items.len() as u64
    }

    /// The items from a position on, at most a portion, and the position behind them. What clears rows comes before all rows of a
    /// portion: a page may take them in this order.
    pub fn since(&self, position: u64) -> (Vec<Item>, u64) {
        let from = position.clamp(self.base, self.end());
        let mut portion = Vec::new();
        let mut has_rows = false;
        #[allow(clippy::cast_possible_truncation)] // at most as many as there are
        for item in self.items.iter().skip((from - self.base) as usize).take(PORTION) {
            if has_rows && matches!(item, Item::Clear { .. }) {
                break;
            }
            has_rows |= matches!(item, Item::Row { .. });
            portion.push(item.clone());
        }
        let read = portion.len() as u64;
        (portion, from + read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn row(frame: usize) -> Item {
        Item::Row { target: 1, frame }
    }

    #[test]
    fn all_is_heard_once_and_in_order() {
        let mut news = News::default();
        let clear = Item::Clear { target: 1, from: 2, to: 9 };
        for item in [row(1), row(2), clear.clone(), row(2)] {
            news.add(item);
        }
        assert_eq!(news.since(0), (vec![row(1), row(2)], 2));
        assert_eq!(news.since(2), (vec![clear, row(2)], 4));
        assert_eq!(news.since(4), (vec![], 4));
        assert_eq!(news.since(99), (vec![], 4));
        (0..2 * PORTION).for_each(|frame| news.add(row(frame)));
        assert_eq!(news.since(4).1, 4 + PORTION as u64);
    }

    #[test]
    fn whoever_was_away_for_long_hears_what_is_true_now() {
        let mut news = News::default();
        (0..10).for_each(|frame| news.add(row(frame)));
        news.renew([row(7)].into_iter());
        assert_eq!((news.since(0), news.since(10)), ((vec![row(7)], 11), (vec![row(7)], 11)));
    }
}
