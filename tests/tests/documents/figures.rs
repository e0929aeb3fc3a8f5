//! Checks that the figures (numbers) in documents equal the values in code, scripts and files of measurements.
//! `SMR_RECORD=1 cargo test -p smr-tests figures` writes these values into the documents.

use super::root;
use smr_core::robust::Config;
use std::fs;
use std::ops::Range;

/// A document, its sentences with `{}` in place of each figure, and the right figures for each sentence.
struct Document {
    name: &'static str,
    sentences: Vec<(&'static str, Vec<String>)>,
}

/// Returns the positions of the figures if `text` begins with `sentence`. Any white space matches any other.
fn figures_at(text: &str, sentence: &str) -> Option<Vec<Range<usize>>> {
    let (mut at, mut places) = (0, Vec::new());
    for (number, piece) in sentence.split("{}").enumerate() {
        if number > 0 {
            let rest = &text[at..];
            let end = rest.find(|letter: char| !(letter.is_ascii_digit() || ".,".contains(letter)));
            let figure = rest[..end.unwrap_or(rest.len())].trim_end_matches(['.', ',']);
            places.push(at..at + figure.len());
            at += figure.len();
        }
        for letter in piece.chars() {
            let rest = &text[at..];
            at += match letter {
                ' ' => rest.len() - rest.trim_start().len(),
                _ if rest.starts_with(letter) => letter.len_utf8(),
                _ => return None,
            };
        }
    }
    places.iter().all(|place| !place.is_empty()).then_some(places)
}

fn written(name: &str, text: &str, sentence: &str, figures: &[String]) -> String {
    let starts = text.char_indices().map(|(start, _)| start);
    let mut found = starts.filter_map(|start| Some((start, figures_at(&text[start..], sentence)?)));
    let (start, places) = found.next().unwrap_or_else(|| panic!("{name} has no sentence like `{sentence}`"));
    assert_eq!(places.len(), figures.len(), "{sentence}");
    let mut text = text.to_owned();
    for (place, figure) in places.into_iter().zip(figures).rev() {
        text.replace_range(start + place.start..start + place.end, figure);
    }
    text
}

/// Returns a value of tests/budgets.txt, which `.ci/firmware --record` writes.
fn budget(name: &str) -> f64 {
    let budgets = include_str!("../../budgets.txt");
    let line = budgets.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    line.and_then(|line| line.trim().parse().ok()).unwrap_or_else(|| panic!("no {name} in budgets.txt"))
}

const UPDATE: &str = "at most {} million units while the target is followed and {} while it is lost";

fn documents() -> Vec<Document> {
    let bytes = |name: &str| budget(name).to_string();
    let thousands = |name: &str| format!("{:.1}", budget(name) / 1e3);
    let millions = |name: &str| format!("{:.1}", budget(name) / 1e6);
    let hundredths = |number: f64| format!("{:.2}", number / 1e6);
    let board = |machine: &str| {
        [
            bytes(&format!("{machine} ram")),
            bytes(&format!("{machine} flash")),
            hundredths(budget(&format!("{machine} instructions"))),
        ]
        .to_vec()
    };
    let script = include_str!("../../../.ci/c");
    let limit = |beginning: &str| {
        let line = script.lines().find_map(|line| line.trim_start().strip_prefix(beginning));
        line.and_then(|line| line.split(' ').find(|word| word.parse::<u32>().is_ok())).expect("a limit").to_owned()
    };
    let [paper, robust, refined] = ["one_tracker paper ", "one_tracker robust ", "one_tracker refined "].map(limit);
    let most = Config::robust().most_work();
    let followed_and_lost = |config: Config| {
        let mut without = config;
        without.sweep = 0;
        [without, config].map(|config| hundredths(config.most_work().update as f64)).to_vec()
    };
    let updates = followed_and_lost(Config::robust());
    let pixels = |chip: &str| {
        let formats = ["gray8", "yuyv", "rgb565le", "rgb565be", "bayer8", "gray10"];
        formats.map(|format| format!("{:.1}", budget(&format!("{chip} readout-{format}")) / 100.0)).to_vec()
    };
    let robust_row = |kind: &str, stack: &str| {
        let flash = bytes(&format!("thumbv7em-none-eabihf {kind}-flash"));
        let [mean, most] = ["instructions", "most"].map(|what| millions(&format!("mps2-an386 {kind}-{what}")));
        vec![stack.to_owned(), flash, mean, most]
    };
    vec![
        Document {
            name: "core/README.md",
            sentences: vec![
                (
                    "| `Paper<4096, 33>`: 64x64 pixels, +-16 | 4,264 | 5,584 | {} | {} | {} million |",
                    vec![
                        paper.clone(),
                        bytes("thumbv7em-none-eabihf tracker-flash"),
                        hundredths(budget("mps2-an386 instructions")),
                    ],
                ),
                (
                    "| `Robust` | 11,376 | 39,248 | {} | {} | {} million, at most {} million |",
                    robust_row("robust", &robust),
                ),
                (
                    "| `Robust` with the feature `refiner` | 12,432 | 39,272 | {} | {} | {} million, at most {} million |",
                    robust_row("refiner", &refined),
                ),
                (UPDATE, updates.clone()),
                ("With the refiner these are {} and {} million", followed_and_lost(Config::refined())),
                (
                    "A lock takes at most {} million ({} with the refiner), and a step at most {} more",
                    vec![
                        hundredths(most.lock as f64),
                        hundredths(Config::refined().most_work().lock as f64),
                        format!("{},000", most.beyond_a_step / 1000),
                    ],
                ),
            ],
        },
        Document {
            name: "core/src/image/readout.rs",
            sentences: vec![
                ("| M4 | {} | {} | {} | {} | {} | {} |", pixels("mps2-an386")),
                ("| M0+ | {} | {} | {} | {} | {} | {} |", pixels("thumbv6m-none-eabi")),
            ],
        },
        Document {
            name: "core/EVIDENCE.md",
            sentences: vec![
                (UPDATE, updates),
                (
                    "more than {} bytes (paper tracker), {} (robust), {} (robust with the refiner) and {} (`smr_init`)",
                    vec![paper, robust, refined, limit("deepest \"$name\" ")],
                ),
            ],
        },
        Document {
            name: "tests/chip/README.md",
            sentences: vec![
                ("| Cortex-M4 (`mps2-an386`) | {} B | 4232, 5500, 9252 B | {} B | {} M |", board("mps2-an386")),
                ("| Cortex-M7 (`mps2-an500`) | {} B | 4232, 5500, 9252 B | {} B | {} M |", board("mps2-an500")),
                ("| Cortex-M55 (`mps3-an547`) | {} B | 4232, 5500, 9252 B | {} B | {} M |", board("mps3-an547")),
                (
                    "takes {} M instructions on average and at most {} M, and the code {} KB of flash",
                    vec![
                        millions("mps3-an547 robust-instructions"),
                        millions("mps3-an547 robust-most"),
                        thousands("thumbv8m.main-none-eabihf+cortex-m55 robust-flash"),
                    ],
                ),
            ],
        },
    ]
}

#[test]
fn documents_have_the_figures_of_code_and_records() {
    for Document { name, sentences } in documents() {
        let path = root().join(name);
        let text = fs::read_to_string(&path).unwrap();
        let right =
            sentences.iter().fold(text.clone(), |text, (sentence, figures)| written(name, &text, sentence, figures));
        if std::env::var_os("SMR_RECORD").is_some() && text != right {
            fs::write(&path, &right).unwrap();
            continue;
        }
        for (is, should) in text.lines().zip(right.lines()) {
            assert_eq!(is, should, "{name}: SMR_RECORD=1 cargo test -p smr-tests figures writes it");
        }
    }
}

#[test]
fn figures_are_found_and_written_over_the_ends_of_lines() {
    let text = "It takes 5 KB. It takes 1.5\nKB of flash, and 7,000 more.";
    let made = written("a", text, "takes {} KB of flash, and {} more.", &["2".into(), "8,000".into()]);
    assert_eq!(made, "It takes 5 KB. It takes 2\nKB of flash, and 8,000 more.");
}
