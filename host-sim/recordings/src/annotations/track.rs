//! Tracks as files state them: the entries of each target, in any order, and what they have in common.

use super::start::{Target, checked_name};
use crate::bounding_box::BoundingBox;
use anyhow::{Context, Result, anyhow, bail};
use std::collections::HashMap;

/// An entry of a target in a frame. Its line is computed from its position, and only for an error.
pub(super) struct Entry {
    pub frame: usize,
    /// Position in the text, in bytes.
    pub at: usize,
    pub seen: Seen,
}

pub(super) enum Seen {
    Box(BoundingBox),
    Gone,
    /// A tracker's answer, which the viewer computes again.
    Answer,
}

pub(super) struct Track {
    pub name: Option<String>,
    pub entries: Vec<Entry>,
    /// True if the target goes from each box to the next entry on a line.
    pub is_line: bool,
}

impl Track {
    /// Sorts the entries by frame. Errors: Two of them are in one frame.
    pub fn sort(&mut self, text: &str) -> Result<()> {
        self.entries.sort_by_key(|entry| entry.frame);
        let twice = self.entries.windows(2).find(|pair| pair[0].frame == pair[1].frame);
        if let Some([first, second]) = twice {
            let (name, first) = (self.name.as_deref().unwrap_or("the target"), line_of(text, first.at));
            bail!(
                "{}: {name} is in frame {} twice, also in {first}: expected one entry for each target in a frame",
                line_of(text, second.at),
                second.frame
            );
        }
        Ok(())
    }

    /// Returns the target with its locks; none if the track has no box to lock on.
    pub fn target(mut self, text: &str) -> Result<Target> {
        self.sort(text)?;
        let mut starts: Vec<(usize, Option<BoundingBox>)> = Vec::new();
        // No line begins or ends at a box of a tracker, or leads to where the target is gone.
        let pairs = self.entries.windows(2).filter(|pair| pair.iter().all(|entry| matches!(entry.seen, Seen::Box(_))));
        let lines = pairs.filter(|_| self.is_line).map(|pair| pair[0].frame).collect();
        for Entry { frame, at, seen } in self.entries {
            match seen {
                Seen::Box(bbox) => {
                    bbox.pixels().map_err(|what| anyhow!("{}: the box {what}", line_of(text, at)))?;
                    starts.push((frame, Some(bbox)));
                }
                Seen::Gone if starts.last().is_some_and(|(_, bbox)| bbox.is_some()) => starts.push((frame, None)),
                Seen::Gone | Seen::Answer => {}
            }
        }
        Ok(Target { name: self.name, starts, lines })
    }
}

/// Makes a name of a label. Tracks with one label are numbered: `car`, `car-2`. `names` counts the tracks of each name.
pub(super) fn unused(label: &str, names: &mut HashMap<String, usize>) -> Result<String> {
    let fits = |letter: char| letter.is_alphanumeric() || "-_. ".contains(letter);
    let plain = |letter: char| if fits(letter) { letter } else { '_' };
    let name: String = label.trim().chars().map(plain).collect();
    let name = checked_name(&name).context("label")?;
    loop {
        let count = names.entry(name.clone()).or_insert(0);
        *count += 1;
        let numbered = if *count == 1 { return Ok(name) } else { format!("{name}-{count}") };
        if !names.contains_key(&numbered) {
            names.insert(numbered.clone(), 1);
            return Ok(numbered);
        }
    }
}

pub(super) fn line_of(text: &str, at: usize) -> String {
    let before = text.as_bytes().iter().take(at).filter(|&&byte| byte == b'\n');
    format!("line {}", before.count() + 1)
}

/// Parses a finite number with a decimal point.
pub(super) fn number(text: &str) -> Result<f64> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let hint = if text.contains(',') { " with a decimal point" } else { "" };
    number.with_context(|| format!("expected a number{hint}, found {}", shown(text)))
}

/// Parses the number of a frame, which some programs write as `7.0`. `first` is the number of the first frame.
pub(super) fn frame(text: &str, first: u32) -> Result<u32> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.fract() == 0.0);
    let number = number.filter(|number| (f64::from(first)..f64::from(u32::MAX)).contains(number));
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the range is checked
    let number = number.map(|number| number as u32);
    number.with_context(|| format!("expected the number of a frame, {first} or more, found {}", shown(text)))
}

/// Quotes the beginning of a text, with control characters escaped.
pub(super) fn shown(text: &str) -> String {
    let start: String = text.chars().take(60).collect();
    format!("{start:?}{}", if start.len() < text.len() { "..." } else { "" })
}
