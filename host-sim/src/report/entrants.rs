//! Everyone whose boxes are shown: the methods that ran here, then the result files of other trackers.

use super::film::Film;
use super::{Color, color_of_method};
use crate::sequence::BoundingBox;

/// The colors of result files, in turn: none is that of a method.
const FILES: [Color; 8] = [
    [255, 165, 60],
    [150, 120, 255],
    [80, 200, 140],
    [230, 90, 190],
    [170, 170, 60],
    [100, 190, 255],
    [220, 130, 110],
    [150, 150, 160],
];

/// One of them.
#[derive(serde::Serialize)]
pub(super) struct Entrant {
    pub name: String,
    /// As it stands on the page.
    pub title: String,
    pub color: Color,
    /// One a frame.
    #[serde(skip)]
    pub answers: Vec<Option<BoundingBox>>,
    /// Its place among the methods; `None` of a file.
    pub method: Option<usize>,
}

pub(super) fn entrants(film: &Film) -> Vec<Entrant> {
    let methods = film.methods.iter().enumerate().map(|(index, method)| Entrant {
        name: method.name.clone(),
        title: method.name.to_uppercase(),
        color: color_of_method(method.kind),
        answers: film.trajectory(index),
        method: Some(index),
    });
    let files = film.files.iter().zip(FILES.into_iter().cycle()).map(|(file, color)| Entrant {
        name: file.name.clone(),
        title: file.name.clone(),
        color,
        answers: file.answers.clone(),
        method: None,
    });
    methods.chain(files).collect()
}
