//! Follows the targets of one recording, from its first frame to its last.

use super::Track;
use super::lines::Lines;
use super::opened::Opened;
use super::pass::Pass;
use crate::command::events::Events;
use crate::command::progress::Bar;
use anyhow::{Error, Result, ensure};
use smr_files::output::complain;
use smr_files::signals;
use smr_pages::export::boxes::Printer;
use smr_recordings::misfit;
use std::path::PathBuf;

/// The outputs of a run through a recording.
pub struct Outputs<'a> {
    pub printer: Printer,
    pub lines: Lines,
    pub film: Option<PathBuf>,
    pub has_events: bool,
    pub bar: &'a Bar,
    pub is_one_of_several: bool,
}

/// Follows the targets to the end of the recording, or until `is_over`, which is an error. Returns the text of lines
/// that are kept.
pub fn follow(track: &Track, opened: Opened, outputs: Outputs<'_>, is_over: &dyn Fn() -> bool) -> Result<String> {
    let Opened { mut sequence, targets, drawn, cropped, boxes_of, .. } = opened;
    let Outputs { printer, mut lines, film, has_events, bar, is_one_of_several } = outputs;
    let events = has_events.then(|| Events::new(targets.len()));
    let live = sequence.source.live();
    if live.is_some() {
        // Ctrl-C is the usual end of a live source, so it must not lose the results.
        signals::stop_first();
    }
    let (length, truth) = (sequence.length, sequence.truth.as_ref().map(Vec::len));
    let misfit = |frames| truth.and_then(|boxes| misfit(frames, boxes));
    if let Some(misfit) = length.and_then(misfit) {
        bar.suspend(|| complain(&format!("warning: {}: {misfit}", sequence.name)));
    }
    let film = film.map(|out| Ok::<_, Error>((track.film(&out, &mut sequence, cropped)?, out))).transpose()?;
    let sequence = if film.is_some() { sequence.in_color(track.recording.ffmpeg_patience()) } else { sequence };
    // A table of several recordings has one head.
    if !matches!(lines, Lines::Kept(_)) {
        lines.write(&printer.head())?;
    }
    let (name, last) = (sequence.name, sequence.first - 1);
    let (drops, done, scale) = (false, 0, sequence.scale);
    let mut pass = Pass {
        name,
        boxes_of,
        is_one_of_several,
        targets,
        drawn,
        scale,
        printer,
        lines,
        events,
        film,
        bar,
        live,
        drops,
        last,
        done,
    };
    for frame in sequence.frames {
        ensure!(!is_over(), "stopped");
        pass.frame(frame?)?;
    }
    if let Some(misfit) = misfit(pass.last + 1 - sequence.first).filter(|_| length.is_none()) {
        pass.warn(&misfit);
    }
    pass.finish(sequence.first)
}
