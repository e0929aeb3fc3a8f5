//! Compares `Config::paper()` on the paper's recordings with the boxes of the paper's prototype, frame by frame.

use crate::missing::recordings;
use smr_core::paper::{Config, Fraction};
use smr_core::{Rect, State, Tracker};
use smr_evaluation::Paper;
use smr_recordings::{OpenOptions, Sequence};
use std::fs;
use std::path::Path;

const RECORDINGS: [&str; 6] =
    ["01_david", "02_jumping", "03_pedestrian1", "04_pedestrian2", "05_pedestrian3", "06_car"];

/// For each frame: left, top, right, bottom; `None` if the target is lost.
type Boxes = Vec<Option<[i32; 4]>>;

fn read(path: &Path) -> Boxes {
    let text = fs::read_to_string(path).expect("the rows are there");
    text.lines()
        .map(|line| {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().expect("a number")).collect();
            #[allow(clippy::cast_possible_truncation)] // whole, and in a picture
            let whole = |index: usize| numbers[index] as i32;
            numbers.iter().all(|number| number.is_finite()).then(|| [0, 1, 2, 3].map(whole))
        })
        .collect()
}

fn follow(sequence: Sequence, config: Config, larger: u16) -> Boxes {
    let mut start = sequence.start().expect("an initial box");
    (start.width, start.height) = (start.width + larger, start.height + larger);
    let corners = |target: Rect| [target.x, target.y, target.right(), target.bottom()];
    let mut tracker = Box::new(Tracker::<Paper>::with(config).expect("a configuration that can be used"));
    let mut frames = sequence.frames.map(|frame| frame.expect("a frame").gray);
    let first = frames.next().expect("a first frame");
    tracker.lock(&first.frame(), start).expect("a box in the picture");
    let rest = frames.map(|frame| {
        let answer = tracker.update(&frame.frame()).expect("a frame of the same size");
        (answer.state != State::Lost).then(|| corners(answer.bbox))
    });
    [Some(corners(start))].into_iter().chain(rest).collect()
}

/// Compares the tracker's boxes with those in the files `*.{rows}.txt`. `larger` is added to the sides of the initial
/// box, in pixels: 1 if the boxes in the files include the pixel at the lower right corner, else 0.
fn compare(test: &str, rows: &str, config: Config, larger: u16) {
    let Some(tld) = recordings(test, "tld") else { return };
    let Some(boxes) = recordings(test, "paper-rows") else { return };
    for name in RECORDINGS {
        let sequence = smr_recordings::open(&tld.join(name), &OpenOptions::default()).expect("a recording");
        let (ours, expected) = (follow(sequence, config, larger), read(&boxes.join(format!("{name}.{rows}.txt"))));
        assert_eq!(ours.len(), expected.len(), "{name}: frames");
        // The first row is skipped: it is the initial box, not an answer of the tracker.
        let differs = (1..ours.len()).find(|&frame| ours[frame] != expected[frame]);
        if let Some(frame) = differs {
            panic!("{name}, frame {}: {:?}, expected {:?}", frame + 1, ours[frame], expected[frame]);
        }
    }
}

#[test]
fn with_a_quarter_of_the_change_every_box_is_the_prototypes() {
    compare("with_a_quarter_of_the_change_every_box_is_the_prototypes", "k0.25", Config::paper(), 0);
}

#[test]
fn with_inclusive_boxes_and_7_20_of_the_change_every_box_is_the_prototypes() {
    let mut config = Config::paper();
    config.k = Fraction::new(7, 20);
    let test = "with_inclusive_boxes_and_7_20_of_the_change_every_box_is_the_prototypes";
    compare(test, "k0.35-inclusive", config, 1);
}
