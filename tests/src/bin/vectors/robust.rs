//! The vectors of the robust tracker: small recordings, and what `smr_core::Robust` answers to them on the host, by the plain
//! loops. That it is the method, too, is what `host-sim check` shows; these hold every other compiler,
//! instruction set and language to the same answers.

use crate::paper::{hash, hex, pixels};
use smr_core::robust::Config;
use smr_core::similarity::Backend;
use smr_core::unstable::weights;
use smr_core::{Answer, Frame, Image, Rect, Robust, Tracker};
use smr_evaluation::name_of;

/// Frames of one size, and what the tracker that follows a box through them consists of.
struct Case {
    name: &'static str,
    config: Config,
    size: (u16, u16),
    /// In the first frame.
    target: Rect,
    frames: Vec<Vec<u8>>,
}

/// Where the target is in a frame: left and top in quarters of a pixel, its size and the light in percent.
type View = (i64, i64, i64, i64);

/// Nothing is to be seen, neither target nor background: all is plain.
const GONE: View = (4000, 4000, 100, 100);

/// All vectors as text.
///
/// # Panics
/// If the tracker refuses a case, which is a mistake in this file.
#[must_use]
pub fn text() -> String {
    let whole = [follow("follow"), hidden("hidden"), border(), tiny(), ties(), long(), large()];
    text_of("", whole.into_iter().chain(changed()))
}

/// All vectors with the refiner as text. They are apart, because not every build has the refiner.
#[must_use]
pub fn refined_text() -> String {
    text_of(" --refiner", refined().into_iter())
}

fn text_of(option: &str, cases: impl Iterator<Item = Case>) -> String {
    let command = format!("vectors --method robust{option}");
    let header = format!("# Made by `{command}`. The form: README.md beside this file.\n");
    let mut text = format!("{header}smr-robust-vectors 3\n");
    cases.for_each(|case| case.write(&mut text));
    text
}

/// The target walks by parts of a pixel, grows, and stands in changing light.
fn follow(name: &'static str) -> Case {
    let path = [
        (40, 32, 100, 100),
        (41, 32, 103, 100),
        (42, 33, 106, 104),
        (44, 34, 109, 110),
        (46, 34, 112, 104),
        (47, 35, 115, 96),
        (48, 35, 118, 90),
    ];
    recorded(name, (48, 36), Rect::new(10, 8, 14, 12), &path)
}

/// The target is hidden until it is lost, and comes back where only the sweep looks.
fn hidden(name: &'static str) -> Case {
    let there = (192, 104, 100, 100);
    let path = [&[(16, 12, 100, 100), (18, 13, 100, 100)], [GONE; 5].as_slice(), &[there; 5]].concat();
    recorded(name, (60, 40), Rect::new(4, 3, 8, 6), &path)
}

/// The target goes beyond the left edge, then the upper one, and comes back.
fn border() -> Case {
    let path = [(16, 40), (6, 36), (-6, 34), (-18, 30), (-14, 14), (0, -6), (16, -16), (24, 4), (28, 18)];
    let path = path.map(|(x, y)| (x, y, 100, 100));
    recorded("border", (40, 30), Rect::new(4, 10, 14, 12), &path)
}

/// A target of six pixels.
fn tiny() -> Case {
    let path = [(40, 32), (44, 32), (47, 34), (44, 38), (40, 40)].map(|(x, y)| (x, y, 100, 100));
    recorded("tiny", (24, 20), Rect::new(10, 8, 3, 2), &path)
}

/// A checkerboard without noise: every frame has many places that look alike.
fn ties() -> Case {
    let size = (28, 24);
    let board = |(right, down): (i64, i64)| {
        pixels(size, |x, y| if ((x + right) / 3 + (y + down) / 3) % 2 == 0 { 50 } else { 170 })
    };
    let frames = [(0, 0), (3, 0), (3, 3), (4, 3), (4, 5), (1, 5)].map(board).to_vec();
    Case { name: "ties", config: plain(), size: (28, 24), target: Rect::new(9, 9, 8, 7), frames }
}

/// A box so long that only its middle is looked at.
fn long() -> Case {
    let path = [(12, 16), (14, 18), (9, 15), (12, 16)].map(|(x, y)| (x, y, 100, 100));
    recorded("long", (70, 12), Rect::new(3, 4, 62, 4), &path)
}

/// A target that is reduced by means of 2x2 pixels.
fn large() -> Case {
    let path = [(48, 24, 100, 100), (53, 28, 102, 104), (58, 22, 104, 96)];
    recorded("large", (98, 81), Rect::new(12, 6, 72, 66), &path)
}

/// The numbers of the configuration changed, each in a recording that it makes a difference in.
fn changed() -> [Case; 6] {
    type Change = fn(&mut Config);
    let changes: [(Case, Change); 6] = [
        (follow("without-size"), |config| config.size = false),
        (hidden("without-sweep"), |config| config.sweep = false),
        (follow("little-reach"), |config| config.reach = 5),
        (hidden("other-states"), |config| {
            (config.patience, config.lost_below, config.uncertain_below) = (150, 30_000, 50_000);
        }),
        (follow("learns-slowly"), |config| config.learning_rate = 40),
        (follow("learns-early"), |config| config.early_rate = 128),
    ];
    changes.map(|(mut case, change)| {
        change(&mut case.config);
        case
    })
}

/// The preset of every build, by the plain loops alone.
fn plain() -> Config {
    let mut config = Config::robust();
    config.backend = Some(Backend::Scalar);
    config
}

/// With the refiner: targets that come nearer, leave the frame, and are reduced.
fn refined() -> [Case; 3] {
    let nearer = [
        (40, 32, 100, 100),
        (41, 32, 112, 100),
        (43, 31, 125, 104),
        (44, 30, 140, 110),
        (45, 30, 155, 104),
        (46, 29, 170, 96),
    ];
    let nearer = recorded("refined", (64, 48), Rect::new(10, 8, 14, 12), &nearer);
    [nearer, Case { name: "refined-border", ..border() }, Case { name: "refined-large", ..large() }].map(|mut case| {
        case.config.refiner = true;
        case
    })
}

/// A target of a texture of its own before a background of half its contrast, with noise that differs from frame to frame.
fn recorded(name: &'static str, size: (u16, u16), target: Rect, path: &[View]) -> Case {
    let frames = (0..).zip(path).map(|(seed, view)| seen(size, target, *view, seed)).collect();
    Case { name, config: plain(), size, target, frames }
}

fn seen(size: (u16, u16), target: Rect, view: View, seed: u32) -> Vec<u8> {
    let (left, top, percent, light) = view;
    pixels((size.0.into(), size.1.into()), |x, y| {
        if view == GONE {
            return 116;
        }
        // A pixel's middle, in units of 1/256 pixel of the target as it was locked on.
        let place = |at: i64, edge: i64| (256 * at + 128 - 64 * edge) * 100 / percent;
        let (u, v) = (place(x, left), place(y, top));
        let inside =
            (0..256 * i64::from(target.width)).contains(&u) && (0..256 * i64::from(target.height)).contains(&v);
        let level = if inside { texture(u, v, 640, 1) } else { 60 + texture(256 * x, 256 * y, 1280, 2) / 2 };
        let noise = i64::from(hash(x, y, 100 + seed) % 5);
        u8::try_from((level * light / 100 + noise).clamp(0, 255)).unwrap_or(0)
    })
}

/// A level that changes smoothly from knot to knot, `apart` from each other.
fn texture(u: i64, v: i64, apart: i64, seed: u32) -> i64 {
    let (column, row) = (u.div_euclid(apart), v.div_euclid(apart));
    let (across, down) = (u.rem_euclid(apart), v.rem_euclid(apart));
    let knot = |x: i64, y: i64| i64::from(hash(column + x, row + y, seed)) * 3 / 4;
    let mix = |y: i64| knot(0, y) * (apart - across) + knot(1, y) * across;
    (mix(0) * (apart - down) + mix(1) * down) / (apart * apart)
}

impl Case {
    fn write(&self, text: &mut String) {
        let mut line = |words: String| text.push_str(&(words + "\n"));
        let Rect { x, y, width, height } = self.target;
        line(format!("\ncase {}", self.name));
        line(format!("size {} {}", self.size.0, self.size.1));
        lines(&self.config).for_each(&mut line);
        line(format!("lock {x} {y} {width} {height} {}", hex(&self.frames[0])));
        for (frame, answer) in self.frames[1..].iter().zip(self.answers()) {
            line(format!("frame {}", hex(frame)));
            line(answer);
        }
    }

    /// To every frame but the first.
    fn answers(&self) -> Vec<String> {
        let mut tracker = Box::new(Tracker::<Robust>::with(self.config).expect("numbers in range"));
        tracker.lock(&self.frame(&self.frames[0]), self.target).expect("a box inside the frame");
        let answer = |frame: &Vec<u8>| {
            let answer = tracker.update(&self.frame(frame)).expect("a frame of the same size");
            words(&answer, &tracker)
        };
        self.frames[1..].iter().map(answer).collect()
    }

    fn frame<'a>(&self, pixels: &'a [u8]) -> Frame<'a> {
        Frame::whole(Image::new(pixels, self.size.0, self.size.1).expect("frames of the case's size"))
    }
}

/// The configuration of a case, a line a number.
fn lines(config: &Config) -> impl Iterator<Item = String> {
    [
        ("reach", config.reach.into()),
        ("size_part", config.size.into()),
        ("sweep", config.sweep.into()),
        ("patience", config.patience.into()),
        ("lost_below", config.lost_below),
        ("uncertain_below", config.uncertain_below),
        ("learning_rate", config.learning_rate),
        ("early_rate", config.early_rate),
    ]
    .into_iter()
    .chain(config.refiner.then_some(("refiner", 1)))
    .map(|(name, number): (_, u16)| format!("{name} {number}"))
}

fn words(answer: &Answer, tracker: &Tracker<Robust>) -> String {
    let Answer { fine, confidence, ratio, scale, found_again, .. } = answer;
    let (state, response) = (name_of(answer.state), smr_core::unstable::response(tracker.workspace()));
    let early = fnv(tracker.target().early_template().into_iter().flatten());
    let weights = fnv(weights(tracker.target()).iter().flat_map(|weight| weight.to_le_bytes()));
    let [x, y, width, height] = [fine.x.into(), fine.y.into(), fine.width.into(), fine.height.into()] as [i64; 4];
    let found_again = u8::from(*found_again);
    format!(
        "answer {x} {y} {width} {height} {state} {confidence} {ratio} {response} {scale} {found_again} {early:08x} {weights:08x}"
    )
}

/// FNV-1a, 32 bits.
fn fnv(bytes: impl Iterator<Item = u8>) -> u32 {
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cases_show_what_they_are_for() {
        let answers = hidden("").answers().join("\n");
        for word in ["tracking", "lost"] {
            assert!(answers.contains(word), "never {word}:\n{answers}");
        }
        let again = |line: &str| line.split(' ').nth(10) == Some("1");
        assert!(answers.lines().any(again), "never found again:\n{answers}");
        let scales = follow("").answers();
        let scale = |line: &String| line.split(' ').nth(9).and_then(|word| word.parse::<u32>().ok()).unwrap_or(0);
        assert!(scales.iter().any(|line| scale(line) > 70_000), "never grown: {scales:?}");
    }

    #[test]
    fn every_number_of_the_configuration_makes_a_difference() {
        let whole = [follow("").answers(), hidden("").answers()];
        for case in changed() {
            assert!(!whole.contains(&case.answers()), "{}", case.name);
        }
    }

    #[test]
    fn the_refiner_corrects_boxes_in_each_of_its_cases() {
        for mut case in refined() {
            let with = case.answers();
            case.config.refiner = false;
            assert_ne!(with, case.answers(), "{}", case.name);
        }
    }
}
