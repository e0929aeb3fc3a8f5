//! Numbers all changes by positions. A page says which position it has seen, and gets the later changes.

use std::collections::{BTreeMap, VecDeque};

/// Frames of a target, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub target: u32,
    pub from: usize,
    pub to: usize,
}

impl Part {
    pub const fn all(target: u32) -> Self {
        Self { target, from: 1, to: usize::MAX }
    }
}

/// Most void parts that are remembered. A page that has seen none of them begins anew.
const MOST_VOID: usize = 1000;
/// The most lines for the user that are remembered.
const MOST_SAID: usize = 4;

/// Positions of all changes except those of answers, which are kept in their segments.
#[derive(Default)]
pub(super) struct News {
    end: u64,
    /// Position of the last change of the targets.
    pub targets: u64,
    /// Position of the last change of the number of frames, or of their times.
    pub frames: u64,
    said: VecDeque<(u64, String)>,
    made: BTreeMap<u32, u64>,
    void: VecDeque<(u64, Part)>,
    /// Position of the last void part that is no longer remembered.
    forgotten: u64,
}

impl News {
    pub const fn end(&self) -> u64 {
        self.end
    }

    /// Returns the position of a change that happens now.
    pub const fn next(&mut self) -> u64 {
        self.end += 1;
        self.end
    }

    /// Makes the answers of a part void until they come again.
    pub fn void(&mut self, part: Part) {
        let at = self.next();
        self.void.push_back((at, part));
        if self.void.len() > MOST_VOID {
            self.forgotten = self.void.pop_front().map_or(0, |(at, _)| at);
        }
    }

    /// Adds a line for the user.
    pub fn say(&mut self, line: String) {
        let at = self.next();
        self.said.push_back((at, line));
        if self.said.len() > MOST_SAID {
            self.said.pop_front();
        }
    }

    /// Records that a file made for the user has progressed.
    pub fn makes(&mut self, id: u32) {
        let at = self.next();
        self.made.insert(id, at);
    }

    /// True if all parts that became void after `since` are remembered.
    pub const fn remembers(&self, since: u64) -> bool {
        since == 0 || since >= self.forgotten
    }

    pub fn voided(&self, is_told: impl Fn(u64) -> bool) -> Vec<Part> {
        told(&self.void, is_told)
    }

    pub fn said(&self, is_told: impl Fn(u64) -> bool) -> Vec<String> {
        told(&self.said, is_told)
    }

    /// Returns the files that have progressed, the latest one at the end.
    pub fn made(&self, is_told: impl Fn(u64) -> bool) -> Vec<u32> {
        let mut made: Vec<_> = self.made.iter().filter(|(_, at)| is_told(**at)).map(|(id, at)| (*at, *id)).collect();
        made.sort_unstable();
        made.into_iter().map(|(_, id)| id).collect()
    }
}

fn told<T: Clone>(all: &VecDeque<(u64, T)>, is_told: impl Fn(u64) -> bool) -> Vec<T> {
    all.iter().filter(|(at, _)| is_told(*at)).map(|(_, one)| one.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_came_behind_a_position_is_told_and_memory_is_bounded() {
        let mut news = News::default();
        news.say("one".to_owned());
        news.makes(7);
        news.void(Part::all(1));
        news.makes(3);
        news.makes(7);
        let within = |since, to| move |at| since < at && at <= to;
        assert_eq!((news.said(within(0, 5)), news.said(within(1, 5))), (vec!["one".to_owned()], vec![]));
        assert_eq!((news.made(within(0, 5)), news.made(within(4, 5))), (vec![3, 7], vec![7]));
        assert_eq!((news.made(within(0, 4)), news.made(within(5, 5)), news.end()), (vec![3], vec![], 5));
        assert_eq!((news.voided(within(2, 5)), news.voided(within(3, 5))), (vec![Part::all(1)], vec![]));
        (0..2 * MOST_VOID).for_each(|_| news.void(Part::all(2)));
        (0..9).for_each(|_| news.say("more".to_owned()));
        assert_eq!((news.voided(|_| true).len(), news.said(|_| true).len()), (MOST_VOID, MOST_SAID));
        assert!(news.remembers(0) && !news.remembers(3) && news.remembers(news.forgotten));
    }
}
