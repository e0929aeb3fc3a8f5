//! Property: readers read what [`Printer`] writes, in each format.

use super::{About, Answer, Format, Printer};
use proptest::collection::vec;
use proptest::prelude::*;
use serde_json::Value;
use smr_core::{State, paper};
use smr_evaluation::{Configs, Evidence, MethodAnswer, MethodKind, Variant};
use smr_recordings::BoundingBox;
use smr_recordings::annotations::{self, Labelled};
use smr_recordings::boxes::Form;
use std::collections::BTreeMap;
use std::fs;

/// A target in a frame: before its first box and while it is gone, there is no report.
#[derive(Clone, Copy, Debug)]
enum Cell {
    Given(BoundingBox),
    Found(BoundingBox),
    Lost,
    Gone,
}

impl Cell {
    fn report(self) -> Option<MethodAnswer> {
        let evidence = Evidence {
            confidence: 0.5,
            ratio: 0.5,
            runner_up_ratio: None,
            alpha: None,
            identity: None,
            scale: 1.0,
            found_again: false,
        };
        let (state, evidence) = match self {
            Self::Given(_) => (State::Tracking, None),
            Self::Found(_) => (State::Uncertain, Some(evidence)),
            Self::Lost => (State::Lost, Some(evidence)),
            Self::Gone => return None,
        };
        Some(MethodAnswer { state, bbox: None, target: self.bbox(), evidence, work: None })
    }

    fn bbox(self) -> Option<BoundingBox> {
        match self {
            Self::Given(bbox) | Self::Found(bbox) => Some(bbox),
            Self::Lost | Self::Gone => None,
        }
    }
}

/// Boxes in quarters of a pixel, which all formats write exactly.
fn any_box() -> impl Strategy<Value = BoundingBox> {
    let quarters = |quarters: i32| f64::from(quarters) / 4.0;
    (-9999..9999_i32, -9999..9999_i32, 4..9999_i32, 4..9999_i32).prop_map(move |(x, y, width, height)| BoundingBox {
        x: quarters(x),
        y: quarters(y),
        width: quarters(width),
        height: quarters(height),
    })
}

/// Cells of a target, frame by frame: after none, only a given box begins anew.
fn any_target() -> impl Strategy<Value = Vec<Cell>> {
    let cell = prop_oneof![
        any_box().prop_map(Cell::Given),
        any_box().prop_map(Cell::Found),
        Just(Cell::Lost),
        Just(Cell::Gone)
    ];
    vec(cell, 12).prop_map(|mut cells| {
        let mut is_there = false;
        for cell in &mut cells {
            is_there = matches!(cell, Cell::Given(_)) || is_there && !matches!(cell, Cell::Gone);
            *cell = if is_there { *cell } else { Cell::Gone };
        }
        cells
    })
}

fn written(format: Format, names: &[Option<String>], targets: &[Vec<Cell>]) -> String {
    let origin = Variant::new(MethodKind::Paper, &Configs::from(paper::Config::paper())).origin();
    let (name, targets_named) = ("a".to_owned(), names.to_vec());
    let about = About {
        name,
        is_one_of_several: false,
        origin,
        targets: targets_named,
        images: Vec::new(),
        has_metres: false,
        pixels_per_metre: None,
    };
    let mut printer = Printer::new(format, about);
    let mut text = printer.head();
    for frame in 1..=targets[0].len() {
        for (target, cells) in targets.iter().enumerate() {
            let report = cells[frame - 1].report();
            let answer = Answer { target, frame, time: None, size: (320, 240), report: report.as_ref(), quality: None };
            text += &printer.line(&answer).unwrap();
        }
    }
    text + &printer.foot().unwrap()
}

fn name_of(name: Option<&String>) -> String {
    name.map_or_else(|| "target".to_owned(), Clone::clone)
}

type Locks = BTreeMap<String, Vec<(usize, Option<BoundingBox>)>>;

/// Locks of each target that has one: given boxes, and first frames without the target up to frame `end`.
fn locks(names: &[Option<String>], targets: &[Vec<Cell>], end: usize) -> Locks {
    let of = |(name, cells): (&Option<String>, &Vec<Cell>)| {
        let pairs = (1..=end).zip(std::iter::once(&Cell::Gone).chain(cells)).zip(cells);
        let lock = |((frame, before), cell): ((usize, &Cell), &Cell)| match (before, cell) {
            (_, Cell::Given(bbox)) => Some((frame, Some(*bbox))),
            (Cell::Gone, _) | (_, Cell::Found(_) | Cell::Lost) => None,
            (_, Cell::Gone) => Some((frame, None)),
        };
        (name_of(name.as_ref()), pairs.filter_map(lock).collect::<Vec<_>>())
    };
    names.iter().zip(targets).map(of).filter(|(_, locks)| !locks.is_empty()).collect()
}

/// (frame, name of the target, box) of each visible target.
fn visible(names: &[Option<String>], targets: &[Vec<Cell>]) -> Vec<(usize, String, BoundingBox)> {
    let of = |frame: usize| {
        let cells = names.iter().zip(targets);
        cells.filter_map(move |(name, cells)| Some((frame, name_of(name.as_ref()), cells[frame - 1].bbox()?)))
    };
    (1..=targets[0].len()).flat_map(of).collect()
}

fn bbox(sides: &[f64]) -> BoundingBox {
    BoundingBox { x: sides[0], y: sides[1], width: sides[2], height: sides[3] }
}

const OF: Labelled<'_> = Labelled { name: "", size: (320, 240), frames: None };

proptest! {
    #[test]
    fn what_is_written_is_read(targets in vec(any_target(), 1..4), name in "[a-zäß.-][a-z ._ö0-9-]{0,5}", is_named: bool) {
        let one = targets.len() == 1 && !is_named;
        let names: Vec<_> = (0..targets.len()).map(|at| (!one).then(|| format!("{name}{at}"))).collect();
        for format in [Format::Csv, Format::Cvat] {
            // CSV has no line behind the last one.
            let last = |cells: &Vec<Cell>| cells.iter().rposition(|cell| !matches!(cell, Cell::Gone)).map_or(0, |at| at + 1);
            let end = if format == Format::Csv { targets.iter().map(last).max().unwrap_or(0) } else { targets[0].len() };
            let (text, expected) = (written(format, &names, &targets), locks(&names, &targets, end));
            let read = annotations::parse(text.as_bytes(), &OF).unwrap_or_default();
            let read: Locks = read.into_iter().map(|one| (name_of(one.name.as_ref()), one.starts)).collect();
            prop_assert_eq!(read, expected, "{}", text);
        }
        let boxes = visible(&names, &targets);
        let mot = written(Format::Mot, &names, &targets);
        let read = mot.lines().map(|line| line.split(',').map(|field| field.parse::<f64>().unwrap()).collect::<Vec<_>>());
        let expected = boxes.iter().map(|(frame, name, of)| {
            let number = names.iter().position(|one| name_of(one.as_ref()) == *name).unwrap() + 1;
            vec![*frame as f64, number as f64, of.x + 1.0, of.y + 1.0, of.width, of.height]
        });
        prop_assert_eq!(read.map(|line| line[..6].to_vec()).collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        let coco: Value = serde_json::from_str(&written(Format::Coco, &names, &targets)).unwrap();
        let named = |id: &Value| coco["categories"].as_array().unwrap().iter().find(|one| one["id"] == *id).unwrap()["name"].clone();
        let read = coco["annotations"].as_array().unwrap().iter().map(|one| {
            let sides: Vec<f64> = serde_json::from_value(one["bbox"].clone()).unwrap();
            (usize::try_from(one["image_id"].as_u64().unwrap()).unwrap(), named(&one["category_id"]).as_str().unwrap().to_owned(), bbox(&sides))
        });
        prop_assert_eq!(read.collect::<Vec<_>>(), boxes);
    }

    #[test]
    fn texts_of_one_target_are_read(cells in any_target()) {
        let file = tempfile::NamedTempFile::new().unwrap();
        let (names, targets) = ([None], [cells]);
        let expected: Vec<_> = targets[0].iter().map(|cell| cell.bbox()).collect();
        for (format, form) in [
            (Format::Tld, Form::Tld),
            (Format::Otb, Form::Otb),
            (Format::Vot, Form::Vot),
            (Format::Got10k, Form::Vot),
        ] {
            fs::write(file.path(), written(format, &names, &targets)).unwrap();
            prop_assert_eq!(form.read(file.path()).unwrap(), &expected[..], "{:?}", format);
        }
        for line in written(Format::Json, &names, &targets).lines().map(|line| serde_json::from_str::<Value>(line).unwrap()) {
            let at = usize::try_from(line["frame"].as_u64().unwrap()).unwrap() - 1;
            let fine = ["x", "y", "width", "height"].map(|side| line["fine"][side].as_f64());
            let found = fine.iter().copied().collect::<Option<Vec<_>>>().map(|sides| bbox(&sides));
            prop_assert_eq!(found, expected[at]);
        }
    }
}
