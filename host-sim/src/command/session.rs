//! The session that `view` keeps beside a recording, for commands without a page: its targets, and its method.

use super::tracker_options::TrackerOptions;
use super::{shell, usage};
use anyhow::{Context, Result, bail, ensure};
use clap::{CommandFactory, Parser};
use serde_json::{Map, Value};
use smr_evaluation::{MethodKind, Variant};
use smr_files::output::complain;
use smr_pages::export::PixelsPerMetre;
use smr_pages::viewer::{Target, Work, session_beside};
use smr_recordings::Target as Given;
use std::ffi::OsString;
use std::path::Path;

/// A session that has targets.
pub struct Kept {
    /// Path of the file, for messages.
    pub file: String,
    work: Work,
}

impl Kept {
    /// Reads the session beside a recording; `None` if there is none, or it has no targets.
    pub fn beside(recording: &Path) -> Result<Option<Self>> {
        let Some(path) = session_beside(recording) else { return Ok(None) };
        let Some(mut work) = Work::read(&path, "give --init")?.filter(|work| !work.targets.is_empty()) else {
            return Ok(None);
        };
        work.targets.iter_mut().for_each(|target| target.locks.sort_by_key(|lock| lock.frame));
        Ok(Some(Self { file: path.display().to_string(), work }))
    }

    /// Returns the targets with their boxes in frames `first` to `last`. Errors: A box of a target that is there in frame
    /// `first` is in an earlier frame, or no box is in these frames.
    pub fn targets(&self, first: usize, last: usize) -> Result<Vec<Given>> {
        let all = self.work.targets.iter().map(|target| begun(target.given()?, first));
        let mut targets = all.collect::<Result<Vec<_>>>().with_context(|| self.file.clone())?;
        if let ([given], [target]) = (&mut targets[..], &self.work.targets[..])
            && !target.has_own_name()
        {
            given.name = None;
        }
        targets.iter_mut().for_each(|target| target.starts.retain(|(frame, _)| *frame <= last));
        targets.retain(|target| !target.starts.is_empty());
        ensure!(!targets.is_empty(), "{}: no box is in these frames: expected other --frames, or --init", self.file);
        Ok(targets)
    }

    /// Returns the target that the user drew under a name; without a name, the only one.
    pub fn drawn(&self, name: Option<&str>) -> Option<&Target> {
        self.work.targets.iter().find(|target| name.is_none_or(|name| target.name() == name))
    }

    pub fn variant(&self) -> Result<Variant> {
        variant_of(&self.work.method, &self.work.options).with_context(|| self.file.clone())
    }

    /// Pixels of a metre, if a length in the picture is known.
    pub fn pixels_per_metre(&self) -> Option<PixelsPerMetre> {
        self.work.length.as_ref().map(|length| length.pixels_per_metre)
    }

    /// Tells whose boxes are followed in the recording of this name, and if `has_method`, by which method and options.
    pub fn tell(&self, recording: &str, has_method: bool) {
        let Work { recording: other, method, options, targets, .. } = &self.work;
        let of = if other == recording { String::new() } else { format!(" of {other}") };
        let names: Vec<_> = targets.iter().map(Target::name).collect();
        let words: Vec<OsString> = std::iter::once(method.into()).chain(typed(options)).collect();
        let line = shell::line(words.iter().map(OsString::as_os_str));
        let is_told = has_method && line != MethodKind::Robust.name();
        let by = if is_told { format!("; its method: {line}") } else { String::new() };
        complain(&format!("note: {recording}: boxes of the session {}{of}: {}{by}", self.file, names.join(", ")));
    }
}

/// Drops the boxes before frame `first`. Errors: The target is there in this frame, and has no box in it.
fn begun(mut target: Given, first: usize) -> Result<Given> {
    let before = target.starts.iter().take_while(|(frame, _)| *frame < first).count();
    let has_box_in_first = target.starts.get(before).is_some_and(|(frame, _)| *frame == first);
    if let Some((frame, Some(_))) = before.checked_sub(1).map(|at| target.starts[at]).filter(|_| !has_box_in_first) {
        let name = target.name.as_deref().unwrap_or_default();
        bail!(
            "the box of {name} in frame {frame} is not read: expected one in frame {first}, --frames from {frame} on, or --init"
        );
    }
    target.starts.drain(..before);
    if target.starts.first().is_some_and(|(_, bbox)| bbox.is_none()) {
        target.starts.remove(0);
    }
    Ok(target)
}

/// The options of a method, as the page sends them.
#[derive(Parser)]
#[command(no_binary_name = true, name = "host-sim track", disable_help_flag = true)]
struct Line {
    #[arg(long, value_enum)]
    method: MethodKind,
    #[command(flatten)]
    tracker: TrackerOptions,
}

pub fn variant_of(method: &str, options: &Map<String, Value>) -> Result<Variant> {
    let words = [vec![format!("--method={method}").into()], typed(options)].concat();
    let Line { method, tracker } = Line::try_parse_from(&words)
        .map_err(|error| anyhow::anyhow!(usage::explained(&error, &Line::command(), &words)))?;
    tracker.variant(method)
}

pub fn typed(options: &Map<String, Value>) -> Vec<OsString> {
    let word = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let option = |(name, value): (&String, &Value)| {
        let values = value.as_array().map_or_else(|| std::slice::from_ref(value), Vec::as_slice);
        values.iter().flat_map(|value| [format!("--{name}"), word(value)]).collect::<Vec<_>>()
    };
    options.iter().flat_map(option).map(OsString::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_or_option_that_is_none_is_named() {
        let error =
            |method: &str, options: Value| variant_of(method, options.as_object().unwrap()).unwrap_err().to_string();
        let no_help = error("robust", serde_json::json!({ "help": "" }));
        assert!(no_help.starts_with("host-sim track has no option --help: "), "{no_help}");
        for method in ["--help", "roubst"] {
            let said = error(method, serde_json::json!({}));
            assert!(said.starts_with(&format!("--method {method}: expected one of paper, robust")), "{said}");
        }
    }

    #[test]
    fn boxes_before_the_frames_that_are_read_are_dropped_if_none_of_them_counts() {
        let target = |starts: &[(usize, bool)]| {
            let start = |&(frame, is_box): &(usize, bool)| (frame, is_box.then(|| [1, 2, 9, 9].into()));
            Given::new(Some("a".to_owned()), starts.iter().map(start).collect())
        };
        let frames = |starts: &[(usize, bool)]| {
            begun(target(starts), 20).map(|target| target.starts.iter().map(|(frame, _)| *frame).collect::<Vec<_>>())
        };
        for (starts, left) in [
            (&[(20, true), (30, true)][..], &[20, 30][..]),
            (&[(1, true), (20, true), (25, false)], &[20, 25]),
            (&[(1, true), (9, false), (30, true)], &[30]),
            (&[(1, true), (20, false), (30, true)], &[30]),
            (&[(1, true), (9, false)], &[]),
        ] {
            assert_eq!(frames(starts).unwrap(), left, "{starts:?}");
        }
        let error = frames(&[(1, true), (30, true)]).unwrap_err().to_string();
        assert_eq!(
            error,
            "the box of a in frame 1 is not read: expected one in frame 20, --frames from 1 on, or --init"
        );
    }
}
