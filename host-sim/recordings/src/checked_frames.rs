//! Checks the frames of every source: at least one frame, all of one size, and none after an error.

use crate::frame::{Frame, Frames};
use anyhow::{Context, Error, Result, anyhow, ensure};
use std::fmt;

/// Error of a recording damaged from some frame on: a truncated image or raw dump, or an error of ffmpeg.
#[derive(Debug)]
pub struct Damaged {
    why: String,
    /// Number of whole frames before the damage; `None` until [`frames`] has counted them.
    before: Option<usize>,
}

impl Damaged {
    /// Returns the frames before the damage as a value of `--frames`, such as `..9`; `None` if there are none.
    pub fn whole_part(&self) -> Option<String> {
        self.before.filter(|&before| before > 0).map(|before| format!("..{before}"))
    }
}

impl fmt::Display for Damaged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}

impl std::error::Error for Damaged {}

/// Creates the error; `before` is the number of whole frames, if it is not that of the frames before the error.
pub(super) fn damaged(why: String, before: Option<usize>) -> Error {
    Damaged { why, before }.into()
}

/// Checks the frames of `source` as they are read; errors call the source `at`.
pub(super) fn frames(mut source: impl Iterator<Item = Result<Frame>> + Send + 'static, at: String) -> Frames {
    let (mut number, mut first, mut over) = (0, None, false);
    Box::new(std::iter::from_fn(move || {
        if over {
            return None;
        }
        number += 1;
        let next = match source.next() {
            Some(Ok(frame)) => Some(same_size(frame, &mut first).with_context(|| format!("{at}, frame {number}"))),
            Some(Err(mut error)) => {
                if let Some(damaged) = error.downcast_mut::<Damaged>() {
                    damaged.before.get_or_insert(number - 1);
                }
                Some(Err(error))
            }
            None if number == 1 => Some(Err(anyhow!("{at} holds no frame: expected at least one"))),
            None => None,
        };
        over = !matches!(next, Some(Ok(_)));
        next
    }))
}

fn same_size(frame: Frame, first: &mut Option<(u16, u16)>) -> Result<Frame> {
    let (width, height) = (frame.gray.width, frame.gray.height);
    ensure!(width > 0 && height > 0, "it is {width}x{height}: expected at least one pixel");
    let (first_width, first_height) = *first.get_or_insert((width, height));
    let same = (width, height) == (first_width, first_height);
    ensure!(same, "it is {width}x{height}: expected {first_width}x{first_height}, the size of the first");
    Ok(frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::GrayFrame;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_of_any_sizes(sizes in proptest::collection::vec((0..3_u16, 0..3_u16), 0..4)) {
            let frame = |(width, height): (u16, u16)| {
                let pixels = vec![0; usize::from(width) * usize::from(height)];
                Ok(Frame::new(1, None, GrayFrame { width, height, pixels }))
            };
            for frame in frames(sizes.into_iter().map(frame), "any".to_owned()).flatten() {
                prop_assert!(frame.gray.frame().bounds().area() > 0);
            }
        }
    }
}
