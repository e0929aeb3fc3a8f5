//! The entrants of a report: methods that ran, then other trackers' result files, with titles, colors and dashes.

use super::film::FilmedRecording;
use crate::colors::{Color, Shades, css};
use serde::Serialize;
use smr_evaluation::MethodKind;
use smr_recordings::BoundingBox;

#[derive(Serialize)]
pub(super) struct Entrant {
    pub name: String,
    pub title: String,
    pub short: String,
    pub look: usize,
    #[serde(skip)]
    pub answers: Vec<Option<BoundingBox>>,
    /// Index of the method that was run; `None` if the answers come from a file.
    pub method: Option<usize>,
}

/// Returns a method's title, preceded by its target's name if the target has one. `words` selects the form of the
/// title: `TITLE`, `SHORT` or `SENTENCE`.
pub(super) fn titled(film: &FilmedRecording, method: usize, words: usize) -> String {
    let title = METHODS[look_of_method(film.methods[method].kind)].2[words];
    let name = film.targets[film.method_targets[method]].name.as_ref();
    name.map_or(title.to_owned(), |name| format!("{name}, {title}"))
}

pub(super) fn entrants(film: &FilmedRecording) -> Vec<Entrant> {
    let methods = film.methods.iter().enumerate().map(|(index, method)| Entrant {
        name: method.name.clone(),
        title: titled(film, index, TITLE),
        short: titled(film, index, SHORT),
        // With several targets, each pair of target and method has its own color and dashes.
        look: if film.targets.len() == 1 { look_of_method(method.kind) } else { look_of_file(index) },
        answers: film.trajectory(index),
        method: Some(index),
    });
    let files = film.files.iter().enumerate().map(|(index, file)| Entrant {
        name: file.name.clone(),
        title: file.name.clone(),
        short: file.name.clone(),
        look: look_of_file(film.file_name_indices.get(index).copied().unwrap_or(index)),
        answers: file.answers.clone(),
        method: None,
    });
    methods.chain(files).collect()
}

/// Gives result files of the same name the same index in all films, and thus the same color and dashes.
pub(super) fn place_files(films: &mut [FilmedRecording]) {
    let mut names: Vec<String> = Vec::new();
    for film in films {
        let place = |name: &String| {
            names.iter().position(|known| known == name).unwrap_or_else(|| {
                names.push(name.clone());
                names.len() - 1
            })
        };
        film.file_name_indices = film.files.iter().map(|file| &file.name).map(place).collect();
    }
}

pub(super) const TRUTH_LOOK: usize = LOOKS - 1;
const LOOKS: usize = METHODS.len() + css::FILES.len() + 1;

// Indices of a method's titles in `METHODS`: full, short, and within a sentence.
pub(super) const TITLE: usize = 0;
const SHORT: usize = 1;
pub(super) const SENTENCE: usize = 2;

/// Color and titles (full, short, within a sentence) of each method.
const METHODS: [(MethodKind, Shades, [&str; 3]); 6] = [
    (MethodKind::Robust, css::ROBUST, ["Robust tracker", "Robust", "the robust tracker"]),
    (MethodKind::Paper, css::SMR, ["Paper's tracker (SMR, 2013)", "Paper", "the paper tracker of 2013"]),
    (MethodKind::Sad, css::SAD, ["SAD"; 3]),
    (MethodKind::Ssd, css::SSD, ["SSD"; 3]),
    (MethodKind::Ncc, css::NCC, ["NCC"; 3]),
    (MethodKind::Lk, css::LK, ["LK"; 3]),
];

/// Lengths of dashes and gaps in screen pixels. Patterns of short dashes are reserved for lost targets and runners-up.
const DASHES: [&[u8]; 5] = [&[], &[14, 5], &[12, 4, 2, 4], &[22, 4, 8, 4], &[12, 3, 2, 3, 2, 3]];

#[derive(Serialize)]
pub(super) struct Look {
    /// Name of the color in colors.css.
    color: &'static str,
    dashes: &'static [u8],
}

fn colors() -> impl Iterator<Item = &'static Shades> {
    METHODS.iter().map(|(_, color, _)| color).chain(css::FILES).chain([&css::TRUTH])
}

pub(super) fn looks() -> Vec<Look> {
    let look = |(place, color): (usize, &Shades)| Look {
        color: color.name,
        dashes: if place == TRUTH_LOOK { &[] } else { DASHES[place % DASHES.len()] },
    };
    colors().enumerate().map(look).collect()
}

fn look_of_method(kind: MethodKind) -> usize {
    METHODS.iter().position(|(method, ..)| *method == kind).unwrap_or(0)
}

pub(super) fn color_of_method(kind: MethodKind) -> Color {
    METHODS[look_of_method(kind)].1.dark
}

const fn look_of_file(index: usize) -> usize {
    METHODS.len() + index % css::FILES.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::tests::is_seen;

    #[test]
    fn twenty_entrants_look_different_and_are_seen_in_light_and_dark() {
        let (looks, colors): (_, Vec<_>) = (looks(), colors().collect());
        assert_eq!(looks.len(), 21, "and the ground truth");
        for shade in [|color: &Shades| color.light, |color: &Shades| color.dark] {
            let all: Vec<Color> = colors.iter().map(|color| shade(color)).collect();
            for (at, one) in all.iter().enumerate() {
                let apart = |other: &Color| one.iter().zip(other).map(|(a, b)| u32::from(a.abs_diff(*b))).sum::<u32>();
                let near = all[..at].iter().map(apart).min();
                assert!(near.is_none_or(|near| near >= 40), "{one:?} of {at} is {near:?} from one before");
            }
        }
        assert!(colors.iter().all(|color| is_seen(color)));
        assert!(looks.windows(2).take(19).all(|pair| pair[0].dashes != pair[1].dashes));
    }
}
