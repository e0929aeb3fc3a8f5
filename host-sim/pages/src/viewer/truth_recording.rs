//! Writes what is known about targets as recordings with ground truth, which `host-sim eval` takes.

use super::model::Target;
use super::source::Source;
use super::truth::Part;
use crate::export::{Format, Writer};
use anyhow::{Context, Result, bail};
use smr_files::output::Folder;
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
        let is_free = |name: &PathBuf| fs::symlink_metadata(name).is_err();
        let folder = Folder::create(&self.names(place).find(is_free).context("no name is free")?)?;
        let mut done = 0;
        for (target, part) in &self.parts {
            let name = self.name_of(target, part);
            let place = if self.parts.len() == 1 { folder.path().to_owned() } else { folder.path().join(&name) };
            write_part(&place, &name, part, source, || {
                done += 1;
                #[allow(clippy::cast_precision_loss)] // far below 2^52
                progress(done as f64 / all as f64)
            })?;
        }
        folder.write("README.txt", self.notes().as_bytes())?;
        let count = match self.parts.len() {
            1 => "a recording".to_owned(),
            count => format!("{count} recordings"),
        };
        Ok((folder.finish_new(self.names(place))?, format!("{count} with truth, {all} frames")))
    }

    /// Returns names for the folder, the best first.
    fn names<'a>(&'a self, place: &'a Path) -> impl Iterator<Item = PathBuf> + 'a {
        (1..1000).map(move |number| match number {
            1 => place.join(format!("{}-truth", self.name)),
            _ => place.join(format!("{}-truth-{number}", self.name)),
        })
    }

    fn name_of(&self, target: &Target, part: &Part) -> String {
        format!("{}-{}-{}-{}", self.name, target.name, part.first, part.first + part.boxes.len() - 1)
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
                self.name_of(target, part),
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

fn write_part(
    folder: &Path,
    name: &str,
    part: &Part,
    source: &dyn Source,
    mut step: impl FnMut() -> bool,
) -> Result<()> {
    let mut writer = Writer::create(folder, Format::Png, name, part.boxes[0])?;
    let mut frames = source.gray_from(part.first)?;
    for number in (part.first..).take(part.boxes.len()) {
        writer.frame(&frames.next().with_context(|| format!("there is no frame {number}"))??.gray)?;
        if !step() {
            bail!("cancelled");
        }
    }
    writer.finish(Some(&part.boxes)).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::test_viewer::{Scene, target};
    use smr_recordings::synthetic;
    use std::sync::Barrier;
    use std::thread;

    fn recordings(firsts: &[usize]) -> Recordings {
        let part = |&first: &usize| {
            (
                target(1, &[1]),
                Part { first, boxes: (first..first + 3).map(|frame| synthetic::truth(frame - 1)).collect() },
            )
        };
        Recordings { name: "clip".to_owned(), method: "paper", parts: firsts.iter().map(part).collect() }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn recordings_appear_whole_and_what_is_there_stays() {
        for firsts in [&[1][..], &[1, 9]] {
            let place = tempfile::tempdir().unwrap();
            let (other, notes) = (place.path().join("clip-truth"), place.path().join("clip-truth/notes.txt"));
            let shown = || names(place.path()).into_iter().filter(|name| !name.starts_with('.')).collect::<Vec<_>>();
            let put = |_| {
                // Another program makes a folder of this name meanwhile.
                fs::create_dir_all(&other).and_then(|()| fs::write(&notes, "mine")).unwrap();
                assert_eq!(shown(), ["clip-truth"]);
                true
            };
            let write = |progress: &dyn Fn(f64) -> bool| {
                recordings(firsts).write(place.path(), &Scene::default(), progress).map(|(folder, _)| folder)
            };
            assert_eq!(write(&put).unwrap(), place.path().join("clip-truth-2"));
            assert_eq!(write(&|done| done < 0.9).unwrap_err().to_string(), "cancelled");
            assert_eq!((names(place.path()), names(&other)), (shown(), vec!["notes.txt".to_owned()]));
            assert_eq!(shown(), ["clip-truth", "clip-truth-2"]);
            // Two at once, which end one after the other.
            let both = Barrier::new(2);
            let together = |done: f64| {
                if done > 0.99 {
                    both.wait();
                }
                true
            };
            thread::scope(|scope| {
                let written = [(); 2].map(|()| scope.spawn(|| write(&together).unwrap()));
                let written = written.map(|one| one.join().unwrap());
                assert_ne!(written[0], written[1]);
                assert!(written.iter().all(|one| names(one) == names(&place.path().join("clip-truth-2"))));
            });
            assert_eq!(names(place.path()), ["clip-truth", "clip-truth-2", "clip-truth-3", "clip-truth-4"]);
        }
    }
}
