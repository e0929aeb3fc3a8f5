//! Everyone whose boxes are shown: the methods that ran here, then the result files of other trackers.

use super::film::Film;
use super::palette::{SHORT, TITLE, look_of_file, look_of_method, words_of};
use smr_recordings::BoundingBox;

#[derive(serde::Serialize)]
pub(super) struct Entrant {
    pub name: String,
    /// As it stands on the page.
    pub title: String,
    /// As it stands where there is little room.
    pub short: String,
    pub look: usize,
    /// One a frame.
    #[serde(skip)]
    pub answers: Vec<Option<BoundingBox>>,
    /// Its place among the methods; `None` of a file.
    pub method: Option<usize>,
}

/// A method in these words, after the name of its target if it has one.
pub(super) fn titled(film: &Film, method: usize, words: usize) -> String {
    let title = words_of(film.methods[method].kind, words);
    let name = film.targets[film.of[method]].name.as_ref();
    name.map_or(title.to_owned(), |name| format!("{name}, {title}"))
}

pub(super) fn entrants(film: &Film) -> Vec<Entrant> {
    let methods = film.methods.iter().enumerate().map(|(index, method)| Entrant {
        name: method.name.clone(),
        title: titled(film, index, TITLE),
        short: titled(film, index, SHORT),
        // With several targets each method has its own look.
        look: if film.targets.len() == 1 { look_of_method(method.kind) } else { look_of_file(index) },
        answers: film.trajectory(index),
        method: Some(index),
    });
    let files = film.files.iter().enumerate().map(|(index, file)| Entrant {
        name: file.name.clone(),
        title: file.name.clone(),
        short: file.name.clone(),
        look: look_of_file(film.places.get(index).copied().unwrap_or(index)),
        answers: file.answers.clone(),
        method: None,
    });
    methods.chain(files).collect()
}

/// A tracker has one look on the whole page: its place is that of the first file of its name, in any film.
pub(super) fn place_files(films: &mut [Film]) {
    let mut names: Vec<String> = Vec::new();
    for film in films {
        let place = |name: &String| {
            names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push(name.clone());
                names.len() - 1
            })
        };
        film.places = film.files.iter().map(|file| &file.name).map(place).collect();
    }
}
