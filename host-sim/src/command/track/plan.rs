//! Several recordings before they are followed: their names, their sessions, and the files that are written.

use super::lines::Lines;
use super::{BOXES, FILM, Track, opened};
use crate::command::make_folder;
use crate::command::names::apart;
use crate::command::paths::{Places, Taken};
use crate::command::session::Kept;
use anyhow::{Result, ensure};
use smr_files::messages::choice_name;
use smr_files::output::{Output, complain};
use smr_pages::export::boxes::Format;
use smr_recordings::name_of;
use std::collections::HashMap;
use std::fs;
use std::io::{IsTerminal, stdout};
use std::path::{Path, PathBuf};

pub struct Plan<'a> {
    pub track: &'a Track,
    pub recordings: Vec<Planned<'a>>,
    pub format: Format,
    pub has_events: bool,
    /// Folders that were made. They go if no file is written into them.
    pub made: Vec<PathBuf>,
}

pub struct Planned<'a> {
    pub path: &'a Path,
    pub name: String,
    /// The session whose boxes are followed.
    pub kept: Result<Option<Kept>>,
    /// True if another recording has the same name, so that messages say the path.
    pub is_namesake: bool,
    /// Files of the recording alone, of its boxes and of its video.
    pub boxes: Option<PathBuf>,
    pub film: Option<PathBuf>,
}

impl<'a> Plan<'a> {
    /// Names the recordings and files, makes the folders, and reads the sessions. Errors: An output cannot take several
    /// recordings, or belongs to an input.
    pub fn of(track: &'a Track, found: &'a [PathBuf]) -> Result<Self> {
        let format = track.format(Format::Csv)?;
        let [boxes, films] = folders(track, found)?;
        ensure!(
            boxes.is_some() || matches!(format, Format::Csv | Format::Json),
            "--format {}: a file of this format has one recording: expected csv or json, or --out DIR/ for a file each",
            choice_name(&format)
        );
        let mut recordings = named(found);
        let ending = format.endings().last().unwrap_or(&"txt");
        for one in &mut recordings {
            one.boxes = boxes.map(|folder| folder.join(format!("{}.{ending}", one.name)));
            one.film = films.map(|folder| folder.join(format!("{}.mp4", one.name)));
        }
        let files = recordings.iter().fold(Places::of(found), |files, one| {
            files.writes("--out", one.boxes.as_ref(), None).writes("--video", one.film.as_ref(), None)
        });
        files.check()?;
        let made = boxes.into_iter().chain(films).filter(|folder| !folder.exists()).map(Path::to_owned).collect();
        boxes.into_iter().chain(films).try_for_each(make_folder)?;
        for Planned { path, name, kept, .. } in &mut recordings {
            if *name != name_of(path) {
                complain(&format!("note: {} is called {name}", path.display()));
            }
            *kept = opened::session(track, path, name);
        }
        let has_events = films.is_some() && track.outputs().0.is_none() && stdout().is_terminal();
        Ok(Self { track, recordings, format, has_events, made })
    }

    /// True if a length is known in one of the recordings: a table of all has columns in metres then.
    pub fn has_metres(&self) -> bool {
        let kept = self.recordings.iter().filter_map(|one| one.kept.as_ref().ok()?.as_ref()?.pixels_per_metre());
        self.track.pixels_per_metre.into_iter().chain(kept).next().is_some()
    }

    /// Begins the table of all recordings.
    pub fn table(&self) -> Result<Lines> {
        Ok(match self.track.outputs().0 {
            _ if self.has_events => Lines::Unread,
            Some(folder) if is_folder(folder) => Lines::Unread,
            Some(file) => Lines::File(Output::create(file)?),
            None => Lines::Printed { goes_on: self.recordings.iter().any(|one| one.film.is_some()) },
        })
    }
}

/// Returns the folders of boxes and of videos, if there are any. Errors: A file of its own is no folder.
fn folders<'a>(track: &'a Track, found: &[PathBuf]) -> Result<[Option<&'a Path>; 2]> {
    let (boxes, films) = track.outputs();
    let taken = Taken { is_folder: true, ..BOXES };
    Places::of(found).writes("--out", boxes, Some(taken)).check()?;
    let boxes = boxes.map(PathBuf::as_path).filter(|out| is_folder(out));
    let Some(&(option, film)) = films.first() else { return Ok([boxes, None]) };
    Places::of(found).writes(option, Some(film), Some(FILM)).check()?;
    ensure!(
        is_folder(film),
        "{option} {}: several recordings do not fit into one video: expected a folder, such as {option} videos/",
        film.display()
    );
    Ok([boxes, Some(film)])
}

/// True for a folder that is there, and for a path that nothing has, if it has no extension or ends in `/`.
fn is_folder(path: &Path) -> bool {
    let is_new_folder = || path.extension().is_none() || path.as_os_str().as_encoded_bytes().ends_with(b"/");
    fs::metadata(path).map_or_else(|_| is_new_folder(), |there| there.is_dir())
}

fn named(found: &[PathBuf]) -> Vec<Planned<'_>> {
    let plain: Vec<_> = found.iter().map(|path| name_of(path)).collect();
    let mut counts: HashMap<&str, usize> = HashMap::new();
    plain.iter().for_each(|name| *counts.entry(name).or_default() += 1);
    let one = |((path, name), plain): (_, &String)| {
        let is_namesake = counts[&**plain] > 1;
        Planned { path, name, kept: Ok(None), is_namesake, boxes: None, film: None }
    };
    found.iter().map(PathBuf::as_path).zip(apart(plain.clone())).zip(&plain).map(one).collect()
}
