//! Targets as the user drew them: each with its locks, the frames with a box of the user.

use super::spans::Spans;
use crate::export::PixelsPerMetre;
use anyhow::{Result, bail, ensure};
use serde::{Deserialize, Serialize};
use smr_core::Rect;
use smr_recordings::{check_gone, checked_name};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Identifier assigned by the page, never reused for another target.
    pub id: u32,
    pub name: String,
    pub locks: Vec<Lock>,
    /// Frames in which something covers the target. The tracker goes on; the truth has no box.
    #[serde(default, skip_serializing_if = "Spans::is_empty")]
    pub hidden: Spans,
    /// Frames in which the user has looked at the present boxes.
    #[serde(default, skip_serializing_if = "Spans::is_empty")]
    pub checked: Spans,
}

/// A frame in which the user drew the target's box, or from which on the target is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lock {
    pub frame: usize,
    /// Left, top, width and height in whole pixels; `None`: the target is gone until its next box.
    #[serde(rename = "box", deserialize_with = "Option::deserialize")]
    pub bbox: Option<(i32, i32, u16, u16)>,
    /// True if the boxes between this one and the next lie on a line between them; false if the tracker finds them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_hand: bool,
}

impl Target {
    /// Numbers targets from 1. Errors: A box has no pixels.
    pub fn numbered(given: Vec<smr_recordings::Target>) -> Result<Vec<Self>> {
        let target = |(id, given): (u32, smr_recordings::Target)| {
            let lock = |(frame, rect)| Lock { by_hand: given.lines.contains(&frame), ..Lock::new(frame, rect) };
            let locks = given.rects()?.into_iter().map(lock).collect();
            let name = given.name.unwrap_or_else(|| "target".to_owned());
            Ok(Self { id, name, locks, hidden: Spans::default(), checked: Spans::default() })
        };
        (1..).zip(given).map(target).collect()
    }

    /// Returns the name; `target` and the id if the user has given none.
    pub fn name(&self) -> String {
        if self.name.is_empty() { format!("target{}", self.id) } else { self.name.clone() }
    }

    /// True if the user has given the target a name.
    pub fn has_own_name(&self) -> bool {
        !["", "target", &format!("target{}", self.id)].contains(&&*self.name)
    }

    /// Returns the target as trackers take it, its boxes in the order of their frames. Errors: The name has other letters
    /// than a name may have, two locks are in one frame, or the target is gone twice, or before its first box.
    pub fn given(&self) -> Result<smr_recordings::Target> {
        let name = checked_name(&self.name())?;
        let start = |lock: &Lock| (lock.frame, lock.rect().map(Into::into));
        let mut starts: Vec<_> = self.locks.iter().map(start).collect();
        starts.sort_by_key(|(frame, _)| *frame);
        if let Some(twice) = starts.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            bail!("{name} has two boxes in frame {}: expected one", twice[0].0);
        }
        check_gone(&name, starts.iter().map(|(frame, bbox)| (*frame, bbox.is_some())))?;
        Ok(smr_recordings::Target::new(Some(name), starts))
    }

    pub fn named_locks(&self) -> impl Iterator<Item = (&str, &Lock)> {
        self.locks.iter().map(|lock| (&*self.name, lock))
    }

    /// True if two pages gave the same id to different targets, which share neither name nor lock.
    pub(super) fn is_another(&self, other: &Self) -> bool {
        self.id == other.id
            && self.name != other.name
            && !other.locks.is_empty()
            && !self.locks.iter().any(|lock| other.locks.contains(lock))
    }
}

impl Lock {
    pub fn new(frame: usize, rect: Option<Rect>) -> Self {
        Self { frame, bbox: rect.map(|Rect { x, y, width, height }| (x, y, width, height)), by_hand: false }
    }

    pub fn rect(&self) -> Option<Rect> {
        self.bbox.map(|(x, y, width, height)| Rect { x, y, width, height })
    }
}

/// The known length of something in the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Length {
    pub pixels_per_metre: PixelsPerMetre,
    /// The line that the user drew, from (x, y) to (x, y); `None` if the number was given on the command line.
    pub line: Option<[u16; 4]>,
}

/// Returns an error if the box of a lock, given with the name of its target, is not wholly inside frames of this width
/// and height; empty boxes pass.
pub fn check_inside<'a>(
    locks: impl IntoIterator<Item = (&'a str, &'a Lock)>,
    (width, height): (u16, u16),
) -> Result<()> {
    for (name, lock) in locks {
        let Some(rect) = lock.rect().filter(|rect| !rect.is_empty()) else { continue };
        let Rect { x, y, width: wide, height: high } = rect;
        ensure!(
            is_inside(rect, (width, height)),
            "the box {x},{y},{wide},{high} of {name} in frame {} is not wholly inside {width}x{height} pixels",
            lock.frame
        );
    }
    Ok(())
}

pub(super) fn is_inside(rect: Rect, (width, height): (u16, u16)) -> bool {
    rect.intersection(Rect { x: 0, y: 0, width, height }) == rect
}

/// Returns the first and the last frame of the range in which a target's answers can differ between the lists of locks
/// `old` and `new`; `None` if the lists are equal.
pub(super) fn differing(old: &[Lock], new: &[Lock]) -> Option<(usize, usize)> {
    let is_same = |(old, new): &(&Lock, &Lock)| (old.frame, old.bbox) == (new.frame, new.bbox);
    let same = old.iter().zip(new).take_while(is_same).count();
    let (old, new) = (&old[same..], &new[same..]);
    let from = old.iter().chain(new).map(|lock| lock.frame).min()?;
    let behind = old.iter().rev().zip(new.iter().rev()).take_while(is_same).count();
    Some((from, if behind == 0 { usize::MAX } else { new[new.len() - behind].frame - 1 }))
}

/// A range of a target's frames, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TargetSpan {
    pub target: u32,
    pub from: usize,
    pub to: usize,
}

impl TargetSpan {
    pub const fn all(target: u32) -> Self {
        Self { target, from: 1, to: usize::MAX }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_given_to_trackers_as_it_was_drawn() {
        let [early, late] = [Rect::new(1, 2, 9, 9), Rect::new(3, 4, 9, 9)];
        let locks = vec![Lock::new(9, Some(late)), Lock::new(5, None), Lock::new(2, Some(early))];
        let target = |name: &str, locks: &[Lock]| Target {
            id: 3,
            name: name.to_owned(),
            locks: locks.to_vec(),
            hidden: Spans::default(),
            checked: Spans::default(),
        };
        let given = target("", &locks).given().unwrap();
        assert_eq!(
            (given.name.as_deref(), given.rects().unwrap()),
            (Some("target3"), vec![(2, Some(early)), (5, None), (9, Some(late))])
        );
        for (name, locks, why) in [
            ("a,b", &locks[..], "the name \"a,b\": expected letters"),
            ("a", &[locks[0], locks[0]], "a has two boxes in frame 9"),
            ("a", &locks[1..2], "a is gone in frame 5 before its first box"),
        ] {
            let error = target(name, locks).given().unwrap_err().to_string();
            assert!(error.starts_with(why), "{error}");
        }
    }

    #[test]
    fn what_differs_between_two_lists_of_locks() {
        let lock = |frame| Lock::new(frame, Some(Rect::new(1, 1, 9, 9)));
        let locks = |frames: &[usize]| frames.iter().map(|&frame| lock(frame)).collect::<Vec<_>>();
        for (old, new, part) in [
            (&[1, 9][..], &[1, 9][..], None),
            (&[], &[3], Some((3, usize::MAX))),
            (&[1, 9], &[1, 5, 9], Some((5, 8))),
            (&[1, 5, 9], &[1, 9], Some((5, 8))),
            (&[1, 9], &[1], Some((9, usize::MAX))),
            (&[2, 9], &[1, 9], Some((1, 8))),
        ] {
            assert_eq!(differing(&locks(old), &locks(new)), part, "{old:?} {new:?}");
        }
        let mut moved = locks(&[1, 5, 9]);
        moved[0].by_hand = true;
        assert_eq!(differing(&locks(&[1, 5, 9]), &moved), None, "trackers do not know what is by hand");
        moved[1].bbox = None;
        assert_eq!(differing(&locks(&[1, 5, 9]), &moved), Some((5, 8)));
    }
}
