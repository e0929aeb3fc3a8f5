//! Damaged input, and the one rule for all sources: it is an error, unless one goes on and counts.

use super::{Frames, GrayFrame};
use crate::words;
use anyhow::{Context, Result, anyhow, ensure};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How a recording is read.
#[derive(Clone, Debug, Default)]
pub(super) struct Reading {
    /// Damage is counted, and is no error.
    pub lenient: bool,
    pub damage: Damage,
}

/// How many frames were found to be damaged up to now.
#[derive(Clone, Debug, Default)]
pub struct Damage(Arc<AtomicU64>);

impl Damage {
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// The error of a source whose input is damaged, and what there is in place of it.
#[derive(Debug)]
pub(super) struct Damaged {
    pub why: String,
    pub instead: Instead,
}

/// What comes in place of damaged input.
#[derive(Debug)]
pub(super) enum Instead {
    /// What could be decoded of the frame.
    Decoded(GrayFrame),
    /// The frame before it once more, so that the boxes of later frames stay theirs.
    Former,
    /// Nothing: the recording ends here. So many of its frames are damaged.
    End(u64),
}

impl fmt::Display for Damaged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}

impl std::error::Error for Damaged {}

impl Damaged {
    /// What `--lenient` does with it, if it helps in a frame of this number; the first is 1.
    fn lenient(&self, number: u64) -> Option<&'static str> {
        match self.instead {
            Instead::Decoded(_) => Some("takes what can be decoded"),
            Instead::Former => (number > 1).then_some("takes the frame before it once more"),
            Instead::End(_) => (number > 1).then_some("takes the frames that were decoded"),
        }
    }
}

/// What holds for every source: at least one frame, all of one size, nothing after an error, and damage as `reading` says.
pub(super) fn frames(
    source: impl Iterator<Item = Result<GrayFrame>> + Send + 'static,
    at: String,
    reading: Reading,
) -> Frames {
    let mut checked = Checked { source, at, reading, number: 0, first: None, former: None };
    let mut over = false;
    Box::new(std::iter::from_fn(move || {
        if over {
            return None;
        }
        let next = checked.next();
        over = !matches!(next, Some(Ok(_)));
        next
    }))
}

struct Checked<S> {
    source: S,
    at: String,
    reading: Reading,
    number: u64,
    /// The size of the first frame.
    first: Option<(u16, u16)>,
    /// Kept only where it may be wanted.
    former: Option<GrayFrame>,
}

impl<S: Iterator<Item = Result<GrayFrame>>> Checked<S> {
    fn next(&mut self) -> Option<Result<GrayFrame>> {
        self.number += 1;
        let frame = match self.source.next() {
            Some(Ok(frame)) => frame,
            Some(Err(error)) => match self.repaired(error) {
                Ok(frame) => frame?,
                Err(error) => return Some(Err(error)),
            },
            None if self.number == 1 => {
                return Some(Err(anyhow!("{} holds no frame: expected at least one", self.at)));
            }
            None => return None,
        };
        Some(self.same_size(frame).with_context(|| format!("{}, frame {}", self.at, self.number)))
    }

    /// What there is in place of a frame that could not be read; `None` where that is nothing.
    fn repaired(&mut self, error: anyhow::Error) -> Result<Option<GrayFrame>> {
        let says = words::of(&error);
        if !self.reading.lenient {
            let lenient = error.downcast_ref::<Damaged>().and_then(|damaged| damaged.lenient(self.number));
            return Err(lenient.map_or(error, |lenient| anyhow!("{says} (--lenient {lenient})")));
        }
        let Damaged { instead, .. } = error.downcast::<Damaged>()?;
        let (frame, count) = match instead {
            Instead::Decoded(frame) => (Some(frame), 1),
            // Of the first frame there is none before it.
            Instead::Former => (
                Some(
                    self.former
                        .clone()
                        .ok_or_else(|| anyhow!("{says}; there is no frame before it to take once more"))?,
                ),
                1,
            ),
            Instead::End(frames) => {
                ensure!(self.number > 1, says);
                (None, frames)
            }
        };
        self.reading.damage.0.fetch_add(count, Ordering::Relaxed);
        Ok(frame)
    }

    fn same_size(&mut self, frame: GrayFrame) -> Result<GrayFrame> {
        let GrayFrame { width, height, .. } = frame;
        ensure!(width > 0 && height > 0, "it is {width}x{height}: expected at least one pixel");
        let (first_width, first_height) = *self.first.get_or_insert((width, height));
        let same = (width, height) == (first_width, first_height);
        ensure!(same, "it is {width}x{height}: expected {first_width}x{first_height}, the size of the first");
        if self.reading.lenient {
            self.former = Some(frame.clone());
        }
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever a source gives, as long as its frames have the pixels that they say.
        #[test]
        fn frames_of_any_sizes(sizes in proptest::collection::vec((0..3_u16, 0..3_u16), 0..4)) {
            let frame = |(width, height): (u16, u16)| {
                Ok(GrayFrame { width, height, pixels: vec![0; usize::from(width) * usize::from(height)] })
            };
            for frame in frames(sizes.into_iter().map(frame), "any".to_owned(), Reading::default()).flatten() {
                prop_assert!(frame.frame().bounds().area() > 0);
            }
        }
    }
}
