//! Writes what is known about targets as recordings with ground truth, which `host-sim eval` takes.

use super::model::Target;
use super::source::Source;
use super::truth::Part;
use crate::export::{Format, Writer};
use anyhow::{Context, Result, bail};
use smr_files::output::Output;
use std::fs;
use std::path::{Path, PathBuf};

/// Recordings to be written: each is a part of the source in which the truth of a target is known.
pub(super) struct Recordings {
    /// Name of the source.
    pub name: String,
    /// Method whose boxes the user has looked at.
    pub method: &'static str,
    pub parts: Vec<(Target, Part)>,
}

impl Recordings {
    /// Writes a folder in `place` under a name that no file has: a single recording, or one with a folder for each. Returns
    /// the folder, and a sentence about it. `progress` takes the fraction done, and returns false to break off; nothing
    /// is left then.
    pub fn write(
        &self,
        place: &Path,
        source: &dyn Source,
        progress: &dyn Fn(f64) -> bool,
    ) -> Result<(PathBuf, String)> {
        let all: usize = self.parts.iter().map(|(_, part)| part.boxes.len()).sum();
        let folder = self.free(place)?;
        let mut done = 0;
        let written = self.parts.iter().try_for_each(|(target, part)| {
            let place = if self.parts.len() == 1 { folder.clone() } else { folder.join(name_of(target, part)) };
            write_part(&place, part, source, || {
                done += 1;
                #[allow(clippy::cast_precision_loss)] // far below 2^52
                progress(done as f64 / all as f64)
            })
        });
        let ended = written.and_then(|()| {
            let mut notes = Output::create(&folder.join("README.txt"))?;
            notes.write(self.notes().as_bytes())?;
            notes.finish()
        });
        if let Err(error) = ended {
            // Nobody had a folder of this name before.
            let _ = fs::remove_dir_all(&folder);
            return Err(error);
        }
        let count = match self.parts.len() {
            1 => "a recording".to_owned(),
            count => format!("{count} recordings"),
        };
        Ok((folder, format!("{count} with truth, {all} frames")))
    }

    fn free(&self, place: &Path) -> Result<PathBuf> {
        let name = |number: usize| match number {
            1 => format!("{}-truth", self.name),
            _ => format!("{}-truth-{number}", self.name),
        };
        let mut names = (1..1000).map(|number| place.join(name(number)));
        names.find(|name| fs::symlink_metadata(name).is_err()).context("no name is free")
    }

    fn notes(&self) -> String {
        let Self { name, method, parts } = self;
        let mut text = format!(
            "Made by host-sim view {} from {name}. To measure trackers: host-sim eval FOLDER\n\n",
            env!("CARGO_PKG_VERSION")
        );
        for (target, part) in parts {
            let last = part.boxes.len() + part.first - 1;
            let drawn = target.locks.iter().filter(|lock| (part.first..=last).contains(&lock.frame));
            let (drawn, none) = (drawn.count(), part.boxes.iter().filter(|bbox| bbox.is_none()).count());
            text += &format!(
                "{}: {} in the frames {} to {last} of {name}, of them {drawn} by hand, {none} hidden or gone\n",
                name_of(target, part),
                target.name,
                part.first,
            );
        }
        text + &format!(
            "
The frames are gray, as the trackers read them. gt.txt has a line for each frame: left, top, right and bottom edge of the
box in pixels, from the left and the upper edge of the frame, which a box may reach over. NaN: the target is hidden or gone.
init.txt has the box in the first frame. Other boxes than those by hand lie on a line between two of these, or are answers
of the tracker {method} that the user has looked at. Frames that nobody has looked at are not here.
"
        )
    }
}

fn name_of(target: &Target, part: &Part) -> String {
    format!("{}-{}-{}", target.name, part.first, part.first + part.boxes.len() - 1)
}

fn write_part(folder: &Path, part: &Part, source: &dyn Source, mut step: impl FnMut() -> bool) -> Result<()> {
    let title = folder.file_name().unwrap_or_default().to_string_lossy();
    let mut writer = Writer::create(folder, Format::Png, &title, part.boxes[0])?;
    let mut frames = source.gray_from(part.first)?;
    for number in (part.first..).take(part.boxes.len()) {
        writer.frame(&frames.next().with_context(|| format!("there is no frame {number}"))??.gray)?;
        if !step() {
            bail!("cancelled");
        }
    }
    writer.finish(Some(&part.boxes)).map(|_| ())
}
