//! Start boxes of targets on the command line: `150,100,40,48`, `car=150,100,40,48@300` or `car=gone@400`.

use crate::bounding_box::BoundingBox;
use crate::frame_number::FrameNumber;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use std::fmt;
use std::str::FromStr;

/// A box of a target in a frame; or, without a box, the first frame in which the target is gone.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    pub name: Option<String>,
    /// Frame number from 1; `None` for the first frame that is read.
    pub frame: Option<usize>,
    /// Box to lock on; `None` if the target is gone from this frame on until its next box.
    pub bbox: Option<BoundingBox>,
}

/// A target, and the boxes to lock on, each with its frame number.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name of the target; `None` for a single target without a name.
    pub name: Option<String>,
    /// Sorted frame numbers, at least one, each with its box; `None` (never the first): gone until the next box.
    pub starts: Vec<(usize, Option<BoundingBox>)>,
    /// Frames of those boxes from which the target goes to its next box on a line.
    pub lines: Vec<usize>,
}

impl Target {
    /// A target that only a tracker finds between its boxes.
    pub const fn new(name: Option<String>, starts: Vec<(usize, Option<BoundingBox>)>) -> Self {
        Self { name, starts, lines: Vec::new() }
    }

    /// Groups starts by target, in the order given; a start without a frame gets `first`, the first frame that is read.
    /// Errors: Two starts of a target in one frame, a target without a name beside others, a frame before `first`, or
    /// an error of [`check_gone`].
    pub fn all(starts: &[Start], first: usize) -> Result<Vec<Self>> {
        let mut targets: Vec<Self> = Vec::new();
        for Start { name, frame, bbox } in starts {
            let frame = frame.unwrap_or(first);
            ensure!(frame >= first, "--init: frame {frame} is not read: expected {first} or later (--frames)");
            let known = targets.iter().position(|target| target.name == *name);
            let at = known.unwrap_or_else(|| {
                targets.push(Self::new(name.clone(), Vec::new()));
                targets.len() - 1
            });
            let target = &mut targets[at];
            ensure!(
                target.starts.iter().all(|(other, _)| *other != frame),
                "--init: two values for {} in frame {frame}: expected a name for each target, like --init car=150,100,40,48, or another frame, like --init 150,100,40,48@300",
                name.as_deref().unwrap_or("one target")
            );
            target.starts.push((frame, *bbox));
        }
        let unnamed = targets.len() > 1 && targets.iter().any(|target| target.name.is_none());
        ensure!(!unnamed, "--init: of several targets each needs a name: expected NAME=X,Y,W,H");
        for target in &mut targets {
            target.starts.sort_by_key(|(frame, _)| *frame);
            let name = target.name.as_deref().unwrap_or("the target");
            check_gone(name, target.starts.iter().map(|(frame, bbox)| (*frame, bbox.is_some()))).context("--init")?;
        }
        Ok(targets)
    }

    /// Returns an error if a box lies in a frame beyond the end of the recording. `option` gave the boxes.
    pub fn check_frames(targets: &[Self], first: usize, length: Option<usize>, option: &str) -> Result<()> {
        // A recording without frames is reported elsewhere.
        let last = length.filter(|&length| length > 0).map_or(FrameNumber::MAX, |length| first + length - 1);
        let starts =
            targets.iter().flat_map(|target| target.starts.iter().map(move |(frame, _)| (*frame, &target.name)));
        let Some((frame, name)) = starts.max_by_key(|(frame, _)| *frame).filter(|(frame, _)| *frame > last) else {
            return Ok(());
        };
        let of = name.as_ref().map_or(String::new(), |name| format!(" for {name}"));
        bail!("there is no frame {frame}{of} ({option}): expected {first} to {last}")
    }

    /// Returns each frame number with its box in whole pixels; `None` where the target is gone.
    pub fn rects(&self) -> Result<Vec<(usize, Option<smr_core::Rect>)>> {
        let rect = |(frame, bbox): &(usize, Option<BoundingBox>)| {
            let rect = bbox.map(|bbox| bbox.pixels()).transpose();
            rect.map(|rect| (*frame, rect)).map_err(|what| anyhow!("the initial box {what}"))
        };
        self.starts.iter().map(rect).collect()
    }

    pub fn boxes_mut(&mut self) -> impl Iterator<Item = &mut BoundingBox> {
        self.starts.iter_mut().filter_map(|(_, bbox)| bbox.as_mut())
    }
}

/// Checks `locks` of the target `name`, sorted by frame: the frame number, and true for a box, false for "gone".
/// Errors: The target is gone before its first box, or twice without a box between.
pub fn check_gone(name: &str, locks: impl Iterator<Item = (usize, bool)>) -> Result<()> {
    let mut gone_from = Some(0);
    for (frame, is_box) in locks {
        match gone_from.filter(|_| !is_box) {
            Some(0) => {
                bail!("{name} is gone in frame {frame} before its first box: expected a box in an earlier frame")
            }
            Some(from) => {
                bail!("{name} is gone from frame {from} on, and again in frame {frame}: expected a box between")
            }
            None => gone_from = (!is_box).then_some(frame),
        }
    }
    Ok(())
}

const EXPECTED: &str = "expected X,Y,W,H, NAME=X,Y,W,H or X,Y,W,H@FRAME";
const GONE: &str = "gone";

/// Parses `[NAME=]X,Y,W,H[@FRAME]` or `[NAME=]gone@FRAME`; the frame may also follow the name: `NAME@FRAME=X,Y,W,H`.
impl FromStr for Start {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (head, tail) = text.split_once('=').map_or((None, text), |(head, tail)| (Some(head), tail));
        let (name, of_name) =
            head.map_or(Ok((None, None)), |head| split_frame(head).map(|(name, of)| (Some(name), of)))?;
        let (bbox, of_box) = split_frame(tail)?;
        ensure!(of_name.is_none() || of_box.is_none(), "{EXPECTED}: @FRAME is given twice");
        let (name, frame) = (name.map(checked_name).transpose()?, of_name.or(of_box));
        let is_gone = bbox == GONE;
        ensure!(!is_gone || frame.is_some(), "expected gone@FRAME: the first frame without the target");
        Ok(Self { name, frame, bbox: if is_gone { None } else { Some(bbox.parse()?) } })
    }
}

fn split_frame(text: &str) -> Result<(&str, Option<usize>)> {
    let Some((before, frame)) = text.split_once('@') else { return Ok((text, None)) };
    let number: FrameNumber = frame.parse().map_err(|expected| anyhow!("@{frame}: {expected}"))?;
    Ok((before, Some(number.get())))
}

/// Checks the name of a target, which appears in tables, file names and images.
pub fn checked_name(name: &str) -> Result<String> {
    let fits = |letter: char| letter.is_alphanumeric() || "-_. ".contains(letter);
    let plain = !name.trim().is_empty() && name.trim() == name && name.chars().all(fits);
    ensure!(plain, "the name {name:?}: expected letters, digits, spaces and - _ . only");
    Ok(name.to_owned())
}

impl fmt::Display for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(name) = &self.name {
            write!(f, "{name}=")?;
        }
        write!(f, "{}", self.bbox.map_or_else(|| GONE.to_owned(), |bbox| bbox.to_string()))?;
        self.frame.map_or(Ok(()), |frame| write!(f, "@{frame}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(text: &str) -> Start {
        text.parse().unwrap()
    }

    #[test]
    fn starts_as_they_are_typed() {
        for (text, printed) in [
            ("1,2,3,4", "1,2,3,4"),
            ("1,2,3,4@20", "1,2,3,4@20"),
            ("car=-1,2,3,4", "car=-1,2,3,4"),
            ("car@20=1,2,3,4", "car=1,2,3,4@20"),
            ("Größe 2=1.5,2,3,4@20", "Größe 2=1.5,2,3,4@20"),
            ("car@20=gone", "car=gone@20"),
        ] {
            assert_eq!(start(text).to_string(), printed);
        }
        for (refused, why) in [
            ("1,2,3", "expected x,y,width,height"),
            ("1,2,3,4@0", "@0: expected the number of a frame"),
            ("1,2,3,4@", "@: expected the number of a frame"),
            ("car@1=1,2,3,4@2", "@FRAME is given twice"),
            ("car=gone", "expected gone@FRAME"),
            ("=1,2,3,4", "the name \"\": expected letters"),
            ("a,b=1,2,3,4", "the name \"a,b\": expected letters"),
            ("a/b=1,2,3,4", "the name \"a/b\": expected letters"),
            (" a=1,2,3,4", "the name \" a\": expected letters"),
        ] {
            let error = refused.parse::<Start>().unwrap_err().to_string();
            assert!(error.contains(why), "{refused}: {error}");
        }
    }

    #[test]
    fn a_target_is_gone_between_two_boxes() {
        let all = |starts: &[&str]| Target::all(&starts.iter().map(|text| start(text)).collect::<Vec<_>>(), 1);
        let starts = all(&["gone@9", "1,2,3,4", "5,5,9,9@20"]).unwrap()[0].rects().unwrap();
        assert_eq!(
            starts.iter().map(|(frame, rect)| (*frame, rect.is_some())).collect::<Vec<_>>(),
            [(1, true), (9, false), (20, true)]
        );
        for (starts, why) in [
            (&["a=gone@9", "a=1,2,3,4@9"][..], "--init: two values for a in frame 9"),
            (&["gone@9"], "--init: the target is gone in frame 9 before its first box"),
            (
                &["a=1,2,3,4", "a=gone@9", "a=gone@12"],
                "--init: a is gone from frame 9 on, and again in frame 12: expected",
            ),
        ] {
            let error = format!("{:#}", all(starts).unwrap_err());
            assert!(error.starts_with(why), "{error}");
        }
    }

    #[test]
    fn boxes_of_one_name_are_one_target() {
        let starts = ["car@300=5,5,9,9", "man=1,2,3,4@120", "car=1,1,9,9"].map(start);
        let targets = Target::all(&starts, 100).unwrap();
        let frames = |at: usize| targets[at].starts.iter().map(|(frame, _)| *frame).collect::<Vec<_>>();
        assert_eq!((targets.len(), frames(0), frames(1)), (2, vec![100, 300], vec![120]));
        assert_eq!(targets[0].starts[0].1, start("1,1,9,9").bbox);
    }
}
