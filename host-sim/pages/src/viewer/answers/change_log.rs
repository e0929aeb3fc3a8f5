//! A log in which each change has a position, a running number. A page polls with the last position that it has seen,
//! and gets the later changes.

use super::super::model::TargetSpan;
use std::collections::VecDeque;

/// Largest number of discarded frame ranges in the log; a page that has missed older ones reloads everything.
const MAX_VOID: usize = 1000;
const MAX_MESSAGES: usize = 4;

/// The log of all changes except new answers; each answer is stored with its own position.
#[derive(Default)]
pub struct ChangeLog {
    end: u64,
    /// Position of the last change of the targets.
    pub targets: u64,
    /// Position of the last change of the frame count or of frame times.
    pub frames: u64,
    messages: VecDeque<(u64, String)>,
    made: VecDeque<(u64, u32)>,
    void: VecDeque<(u64, TargetSpan)>,
    /// Position of the latest entry of `void` that was dropped from the log.
    forgotten: u64,
}

impl ChangeLog {
    pub const fn end(&self) -> u64 {
        self.end
    }

    /// Returns a new position, for a change that happens now.
    pub const fn next(&mut self) -> u64 {
        self.end += 1;
        self.end
    }

    /// Logs that pages must discard the answers of a frame range.
    pub fn void(&mut self, part: TargetSpan) {
        let at = self.next();
        self.void.push_back((at, part));
        if self.void.len() > MAX_VOID {
            self.forgotten = self.void.pop_front().map_or(0, |(at, _)| at);
        }
    }

    pub fn say(&mut self, line: String) {
        let at = self.next();
        self.messages.push_back((at, line));
        if self.messages.len() > MAX_MESSAGES {
            self.messages.pop_front();
        }
    }

    /// Logs progress of file `id`, a video or report that the user has ordered.
    pub fn log_progress(&mut self, id: u32) {
        let at = self.next();
        self.made.retain(|(_, other)| *other != id);
        self.made.push_back((at, id));
    }

    /// True if `since` is 0 (a new page), or if the log contains all frame ranges that were discarded after `since`.
    pub const fn remembers(&self, since: u64) -> bool {
        since == 0 || since >= self.forgotten
    }

    /// Returns what was logged after position `since`: discarded frame ranges, messages, ids of files that progressed.
    pub fn after(&self, since: u64) -> (Vec<TargetSpan>, Vec<String>, Vec<u32>) {
        (after(&self.void, since), after(&self.messages, since), after(&self.made, since))
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
        let mut log = ChangeLog::default();
        log.say("one".to_owned());
        log.log_progress(7);
        log.void(TargetSpan::all(1));
        log.log_progress(3);
        log.log_progress(7);
        assert_eq!(log.after(0), (vec![TargetSpan::all(1)], vec!["one".to_owned()], vec![3, 7]));
        assert_eq!(log.after(1), (vec![TargetSpan::all(1)], vec![], vec![3, 7]));
        assert_eq!((log.after(4), log.after(5), log.end()), ((vec![], vec![], vec![7]), Default::default(), 5));
        (0..2 * MAX_VOID).for_each(|_| log.void(TargetSpan::all(2)));
        (0..9).for_each(|_| log.say("more".to_owned()));
        let (void, messages, _) = log.after(0);
        assert_eq!((void.len(), messages.len()), (MAX_VOID, MAX_MESSAGES));
        assert!(log.remembers(0) && !log.remembers(3) && log.remembers(log.forgotten));
    }
}
