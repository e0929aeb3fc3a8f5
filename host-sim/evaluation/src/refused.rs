//! The error of a box that a tracker refuses to lock on: the reason, and the options that help.

use super::MethodKind;
use super::baseline::MAX_PIXELS;
use anyhow::Error;
use smr_core::{LockError, Rect};
use std::fmt;

/// A box that a tracker refuses to lock on. `Display` states the reason; [`Refused::way_out`] suggests options.
#[derive(Debug)]
pub struct Refused {
    kind: MethodKind,
    target: Rect,
    frame: Rect,
    why: LockError,
}

impl Refused {
    /// Converts a [`LockError`] to a [`Refused`] for box `target` in a frame of bounds `frame`; keeps other errors.
    pub fn or(error: Error, kind: MethodKind, target: Rect, frame: Rect) -> Error {
        match error.downcast_ref::<LockError>() {
            Some(&why) => Self { kind, target, frame, why }.into(),
            None => error,
        }
    }

    /// Returns advice that names only the options for which `has` is true.
    pub fn way_out(&self, has: impl Fn(&str) -> bool) -> String {
        let all = match self.why {
            LockError::BoxTooLarge => vec![
                (has("method") && self.kind != MethodKind::Robust, "--method robust, which takes every box"),
                (has("init"), "a smaller box (--init)"),
                (!has("init"), "a smaller box"),
                (has("resize"), "--resize 1/2"),
            ],
            LockError::WindowTooLarge => vec![
                (has("method"), "--method robust"),
                (has("set"), "a smaller --set window_limit or --set padding"),
                (has("resize"), "--resize 1/2"),
            ],
            _ => vec![
                (has("init"), "--init X,Y,W,H with a box in the frame (drag it in `host-sim view`)"),
                (!has("init"), "a box in the frame"),
            ],
        };
        let ways: Vec<&str> = all.into_iter().filter(|(there, _)| *there).map(|(_, way)| way).collect();
        format!("use {}", ways.join(", or "))
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Rect { x, y, width, height } = self.target;
        let tracker = self.kind.name();
        write!(f, "the box {x},{y},{width},{height} (x,y,width,height) ")?;
        match self.why {
            LockError::BoxOutsideFrame => {
                let Rect { width, height, .. } = self.frame;
                write!(f, "is not wholly inside the frame of {width}x{height} pixels")
            }
            LockError::BoxTooLarge => {
                let pixels = u64::from(width) * u64::from(height);
                let most = if self.kind.is_core() { crate::MAX_PIXELS as u64 } else { MAX_PIXELS.into() };
                write!(f, "has {pixels} pixels; the tracker {tracker} takes at most {most}")
            }
            LockError::WindowTooLarge => {
                let most = crate::MAX_OFFSETS;
                write!(
                    f,
                    "could be looked for in a window of more than {most} offsets on an axis; the tracker {tracker} takes at most {most}"
                )
            }
            why => write!(f, "cannot be followed by the tracker {tracker}: {why}"),
        }
    }
}

impl std::error::Error for Refused {}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(kind: MethodKind, why: LockError) -> Refused {
        let (target, frame) = (Rect::new(1, 2, 300, 250), Rect::new(0, 0, 320, 240));
        Refused::or(why.into(), kind, target, frame).downcast().unwrap()
    }

    #[test]
    fn the_box_and_the_bound_are_said() {
        let large = refused(MethodKind::Paper, LockError::BoxTooLarge).to_string();
        let expected = format!(
            "the box 1,2,300,250 (x,y,width,height) has 75000 pixels; the tracker paper takes at most {}",
            crate::MAX_PIXELS
        );
        assert_eq!(large, expected);
        let outside = refused(MethodKind::Lk, LockError::BoxOutsideFrame).to_string();
        assert_eq!(outside, "the box 1,2,300,250 (x,y,width,height) is not wholly inside the frame of 320x240 pixels");
    }

    #[test]
    fn no_option_is_named_that_the_command_lacks() {
        let all = ["method", "init", "resize", "set"];
        for why in [LockError::BoxTooLarge, LockError::WindowTooLarge, LockError::BoxOutsideFrame, LockError::BoxEmpty]
        {
            let refused = refused(MethodKind::Paper, why);
            assert!(refused.way_out(|name| all.contains(&name)).contains("--"), "{why}");
            for missing in all {
                let way = refused.way_out(|name| all.contains(&name) && name != missing);
                assert!(!way.contains(&format!("--{missing}")), "{why}: {way}");
            }
        }
        let way = refused(MethodKind::Paper, LockError::BoxTooLarge).way_out(|_| true);
        assert_eq!(way, "use --method robust, which takes every box, or a smaller box (--init), or --resize 1/2");
    }
}
