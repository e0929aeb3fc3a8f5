//! Runs `host-sim track`: one recording here, several in `several`.

use super::follow::{Outputs, follow};
use super::lines::Lines;
use super::opened::{self, Opened};
use super::{BOXES, FILM, Track, check_names, several};
use crate::command::Outcome;
use crate::command::paths::{self, Places};
use crate::command::progress::{self, Bar};
use anyhow::Result;
use smr_files::output::Output;
use smr_pages::export::boxes::Format;
use smr_recordings::name_of;
use std::io::{IsTerminal, stdout};
use std::path::Path;

impl Track {
    pub fn run(self) -> Result<Outcome> {
        self.check()?;
        match paths::several(&self.sequences, self.out.is_none())? {
            None => self.one(&self.sequences[0]),
            Some(found) => several::follow(&self, &found),
        }
    }

    fn one(&self, path: &Path) -> Result<Outcome> {
        let (boxes, films) = self.outputs();
        let places = Places::of(&self.sequences).writes("--out", boxes, Some(BOXES));
        films.iter().fold(places, |places, (option, film)| places.writes(option, Some(film), Some(FILM))).check()?;
        let kept = opened::session(self, path, &name_of(path))?;
        let opened = Opened::of(self, path, kept.as_ref())?;
        let targets = opened.targets.len();
        let format =
            self.format(if targets > 1 || self.pixels_per_metre.is_some() { Format::Csv } else { Format::Tld })?;
        check_names(format, targets)?;
        let film = films.first().map(|&(_, film)| film);
        // With a video, a terminal shows only events, because lines of numbers would hide the events.
        let has_events = film.is_some() && boxes.is_none() && stdout().is_terminal();
        let lines = match boxes {
            _ if has_events => Lines::Unread,
            None => Lines::Printed { goes_on: film.is_some() },
            Some(file) => Lines::File(Output::create(file)?),
        };
        let name = film.map_or_else(|| opened.sequence.name.clone(), |film| film.display().to_string());
        let bar = if has_events || boxes.is_some() || !stdout().is_terminal() {
            progress::bar(&name, self.length(&opened.sequence))
        } else {
            Bar::hidden()
        };
        let (printer, film) = (opened.printer(format, false, opened.pixels_per_metre.is_some()), film.cloned());
        let outputs = Outputs { printer, lines, film, has_events, bar: &bar, is_one_of_several: false };
        follow(self, opened, outputs, &|| false)?;
        Ok(Outcome::Holds)
    }
}
