//! The entrants of a report: methods that ran, then other trackers' result files, with titles, colors and dashes.

use super::film::FilmedRecording;
use crate::colors::{Color, TRUTH};
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
const LOOKS: usize = METHODS.len() + FILES.len() + 1;

// Indices of a method's titles in `METHODS`: full, short, and within a sentence.
pub(super) const TITLE: usize = 0;
const SHORT: usize = 1;
pub(super) const SENTENCE: usize = 2;

/// Color and titles (full, short, within a sentence) of each method. SMR is red and SAD blue, as in the paper. The
/// colors must be distinct from each other on any frame, and from the colors of states.
const METHODS: [(MethodKind, Color, [&str; 3]); 6] = [
    (MethodKind::Robust, [255, 130, 220], ["Robust tracker", "Robust", "the robust tracker"]),
    (MethodKind::Paper, [255, 64, 64], ["Paper's tracker (SMR, 2013)", "Paper", "the paper tracker of 2013"]),
    (MethodKind::Sad, [64, 140, 255], ["SAD"; 3]),
    (MethodKind::Ssd, [0, 205, 220], ["SSD"; 3]),
    (MethodKind::Ncc, [200, 225, 90], ["NCC"; 3]),
    (MethodKind::Lk, [235, 235, 235], ["LK"; 3]),
];

/// Colors of result files. Each was chosen as different as possible from all before it.
const FILES: [Color; 14] = [
    [165, 0, 240],
    [150, 90, 30],
    [195, 0, 120],
    [120, 90, 165],
    [255, 0, 255],
    [255, 150, 60],
    [75, 120, 15],
    [90, 75, 255],
    [180, 120, 255],
    [0, 120, 135],
    [255, 60, 165],
    [195, 90, 105],
    [150, 165, 240],
    [15, 105, 195],
];

/// Lengths of dashes and gaps in screen pixels. Patterns of short dashes are reserved for lost targets and runners-up.
const DASHES: [&[u8]; 5] = [&[], &[14, 5], &[12, 4, 2, 4], &[22, 4, 8, 4], &[12, 3, 2, 3, 2, 3]];

/// Background of plots in the light and in the dark theme, as in base.css.
const PANELS: [Color; 2] = [[244, 246, 247], [30, 34, 38]];
/// Minimum contrast ratio between a curve and its background, as WCAG 2 requires for graphics.
const CONTRAST: f64 = 3.0;

#[derive(Serialize)]
pub(super) struct Look {
    color: Color,
    /// `color`, darkened or lightened as little as the contrast on a light or a dark page requires.
    on_light: Color,
    on_dark: Color,
    dashes: &'static [u8],
}

pub(super) fn looks() -> Vec<Look> {
    let colors = METHODS.map(|(_, color, _)| color).into_iter().chain(FILES).chain([TRUTH]);
    let look = |(place, color): (usize, Color)| Look {
        color,
        on_light: seen(color, [0; 3], PANELS[0]),
        on_dark: seen(color, [255; 3], PANELS[1]),
        dashes: if place == TRUTH_LOOK { &[] } else { DASHES[place % DASHES.len()] },
    };
    colors.enumerate().map(look).collect()
}

fn look_of_method(kind: MethodKind) -> usize {
    METHODS.iter().position(|(method, ..)| *method == kind).unwrap_or(0)
}

pub(super) fn color_of_method(kind: MethodKind) -> Color {
    METHODS[look_of_method(kind)].1
}

const fn look_of_file(index: usize) -> usize {
    METHODS.len() + index % FILES.len()
}

/// Blends `color` toward `end`, just far enough for the contrast `CONTRAST` with the background `panel`.
fn seen(color: Color, end: Color, panel: Color) -> Color {
    let nearer = |percent: u32| {
        let mixed = |at: usize| (u32::from(color[at]) * (100 - percent) + u32::from(end[at]) * percent) / 100;
        [0, 1, 2].map(|at| u8::try_from(mixed(at)).unwrap_or(u8::MAX))
    };
    (0..=100).map(nearer).find(|color| contrast(*color, panel) >= CONTRAST).unwrap_or(end)
}

/// Returns the contrast ratio of WCAG 2: 1 for equal colors, 21 for black and white.
fn contrast(one: Color, other: Color) -> f64 {
    let (one, other) = (luminance(one), luminance(other));
    (one.max(other) + 0.05) / (one.min(other) + 0.05)
}

fn luminance(color: Color) -> f64 {
    let linear = color.map(|channel| {
        let channel = f64::from(channel) / 255.0;
        if channel <= 0.040_45 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
    });
    0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_entrants_look_different_and_are_seen_in_light_and_dark() {
        let looks = looks();
        assert_eq!(looks.len(), 21, "and the ground truth");
        let colors: [fn(&Look) -> Color; 3] = [|look| look.color, |look| look.on_light, |look| look.on_dark];
        for color in colors {
            let all: Vec<Color> = looks.iter().map(color).collect();
            for (at, one) in all.iter().enumerate() {
                let apart = |other: &Color| one.iter().zip(other).map(|(a, b)| u32::from(a.abs_diff(*b))).sum::<u32>();
                let near = all[..at].iter().map(apart).min();
                assert!(near.is_none_or(|near| near >= 40), "{one:?} of {at} is {near:?} from one before");
            }
        }
        for look in &looks {
            assert!(contrast(look.on_light, PANELS[0]) >= CONTRAST && contrast(look.on_dark, PANELS[1]) >= CONTRAST);
        }
        assert!(looks.windows(2).take(19).all(|pair| pair[0].dashes != pair[1].dashes));
    }

    #[test]
    fn contrast_is_that_of_wcag() {
        assert_eq!((contrast([0; 3], [255; 3]), contrast([7; 3], [7; 3])), (21.0, 1.0));
        assert!((contrast([119; 3], [255; 3]) - 4.48).abs() < 0.01);
    }
}
