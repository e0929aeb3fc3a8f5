//! Ranges of frames, such as those in which a target is hidden, or was looked at.

use serde::{Deserialize, Serialize};

/// Ranges of frames, both ends included: in order, apart from each other.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<(usize, usize)>")]
pub struct Spans(Vec<(usize, usize)>);

impl From<Vec<(usize, usize)>> for Spans {
    /// Takes ranges in any order, which may overlap; a range may also name its last frame first.
    fn from(mut spans: Vec<(usize, usize)>) -> Self {
        spans.iter_mut().for_each(|span| *span = (span.0.min(span.1), span.0.max(span.1)));
        spans.sort_unstable();
        let mut apart: Vec<(usize, usize)> = Vec::new();
        for (from, to) in spans {
            match apart.last_mut() {
                Some((_, last)) if from <= last.saturating_add(1) => *last = to.max(*last),
                _ => apart.push((from, to)),
            }
        }
        Self(apart)
    }
}

impl Spans {
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn contains(&self, frame: usize) -> bool {
        let behind = self.0.partition_point(|(from, _)| *from <= frame);
        self.0[..behind].last().is_some_and(|(_, to)| frame <= *to)
    }

    /// Returns the latest of these frames that is not behind `end`.
    pub fn last_to(&self, end: usize) -> Option<usize> {
        let begun = self.0.partition_point(|(from, _)| *from <= end);
        self.0[..begun].last().map(|(_, to)| end.min(*to))
    }

    pub fn add(&mut self, more: Self) {
        *self = [std::mem::take(&mut self.0), more.0].concat().into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ranges_come_in_any_form_and_are_kept_in_one() {
        let json = |spans: Vec<(usize, usize)>| serde_json::to_string(&Spans::from(spans)).unwrap();
        assert_eq!(
            json(vec![(9, 7), (1, 3), (2, 4), (5, 5), (usize::MAX, 20)]),
            format!("[[1,5],[7,9],[20,{}]]", usize::MAX)
        );
        assert_eq!(serde_json::from_str::<Spans>("[[4,2],[3,9]]").unwrap(), vec![(2, 9)].into());
    }

    proptest! {
        #[test]
        fn a_frame_is_in_the_ranges_that_name_it(spans in prop::collection::vec((1..60_usize, 1..60_usize), 0..9), frame in 1..60_usize) {
            let is_named = spans.iter().any(|(from, to)| (*from.min(to)..=*from.max(to)).contains(&frame));
            let (first, rest) = spans.split_at(spans.len() / 2);
            let mut added = Spans::from(first.to_vec());
            added.add(rest.to_vec().into());
            prop_assert_eq!(added.contains(frame), is_named);
            let last = (1..=frame).rev().find(|&at| added.contains(at));
            prop_assert_eq!(added.last_to(frame), last);
            prop_assert_eq!(added, Spans::from(spans));
        }
    }
}
