//! A log of changes by position. A page polls with the last position that it has seen, and gets the later changes.

use std::collections::VecDeque;

/// A range of a target's frames, both ends included.
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

/// Most discarded frame ranges in the log; a page that has missed older ones reloads everything.
const MOST_VOID: usize = 1000;
/// Most messages for the user in the log.
const MOST_SAID: usize = 4;

/// The log of all changes except answers, whose positions are stored with them.
#[derive(Default)]
pub(super) struct News {
    end: u64,
    /// Position of the last change of the targets.
    pub targets: u64,
    /// Position of the last change of the frame count or of frame times.
    pub frames: u64,
    said: VecDeque<(u64, String)>,
    made: VecDeque<(u64, u32)>,
    void: VecDeque<(u64, Part)>,
    /// Position of the latest entry of `void` that was dropped from the log.
    forgotten: u64,
}

impl News {
    pub const fn end(&self) -> u64 {
        self.end
    }

    /// Returns a new position, for a change that happens now.
    pub const fn next(&mut self) -> u64 {
        self.end += 1;
        self.end
    }

    /// Logs that pages must discard the answers of a frame range.
    pub fn void(&mut self, part: Part) {
        let at = self.next();
        self.void.push_back((at, part));
        if self.void.len() > MOST_VOID {
            self.forgotten = self.void.pop_front().map_or(0, |(at, _)| at);
        }
    }

    pub fn say(&mut self, line: String) {
        let at = self.next();
        self.said.push_back((at, line));
        if self.said.len() > MOST_SAID {
            self.said.pop_front();
        }
    }

    /// Logs progress of file `id`, a video or report that the user has ordered.
    pub fn makes(&mut self, id: u32) {
        let at = self.next();
        self.made.retain(|(_, other)| *other != id);
        self.made.push_back((at, id));
    }

    /// True if the log contains all frame ranges that were discarded after `since`.
    pub const fn remembers(&self, since: u64) -> bool {
        since == 0 || since >= self.forgotten
    }

    /// Returns the discarded frame ranges, the messages, and the ids of files with progress after position `since`.
    pub fn after(&self, since: u64) -> (Vec<Part>, Vec<String>, Vec<u32>) {
        (after(&self.void, since), after(&self.said, since), after(&self.made, since))
    }
}

fn after<T: Clone>(all: &VecDeque<(u64, T)>, since: u64) -> Vec<T> {
    all.iter().filter(|(at, _)| since < *at).map(|(_, one)| one.clone()).collect()
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
        assert_eq!(news.after(0), (vec![Part::all(1)], vec!["one".to_owned()], vec![3, 7]));
        assert_eq!(news.after(1), (vec![Part::all(1)], vec![], vec![3, 7]));
        assert_eq!((news.after(4), news.after(5), news.end()), ((vec![], vec![], vec![7]), Default::default(), 5));
        (0..2 * MOST_VOID).for_each(|_| news.void(Part::all(2)));
        (0..9).for_each(|_| news.say("more".to_owned()));
        let (void, said, _) = news.after(0);
        assert_eq!((void.len(), said.len()), (MOST_VOID, MOST_SAID));
        assert!(news.remembers(0) && !news.remembers(3) && news.remembers(news.forgotten));
    }
}
