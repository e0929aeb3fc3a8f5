//! The conformance vectors: small recordings written out pixel by pixel, with the answers of the reference.
//!
//! With them, smr-core can be checked without this program: built by another compiler, for another instruction set, or called
//! from C. `tests/vectors/README.md` describes the form.

use smr_reference::{Decision, Numbers, Reference, Step};
use std::fmt::Write;

/// Frames of one size, and how the tracker is set up to follow a box through them.
struct Case {
    name: &'static str,
    numbers: Numbers,
    size: (i64, i64),
    /// Left, top, width, height in the first frame.
    target: (i64, i64, i64, i64),
    frames: Vec<Vec<u8>>,
}

/// All vectors as text.
pub fn text() -> String {
    let header = "# Made by `vectors` from the float reference. The form: README.md beside this file.\n";
    let mut text = format!("{header}smr-vectors 3\n");
    for case in [paper(), edges(), camera(), others("others", 255.0, 11), others("scale", 40.0, 5), ties(), one_pixel()]
    {
        case.write(&mut text);
    }
    text
}

/// The paper's numbers; the target walks, leaves to the left, is gone, comes back, and jumps.
fn paper() -> Case {
    let path =
        [(18, 12), (20, 13), (17, 15), (10, 15), (3, 14), (-3, 14), (-7, 13), (60, 60), (60, 60), (-4, 12), (2, 12)];
    let path = [path.as_slice(), &[(5, 11), (30, 20), (30, 20)]].concat();
    let size = (44, 30);
    let frames = scenes(size, (9, 8), &path);
    Case { name: "paper", numbers: Numbers::paper(), size, target: (18, 12, 9, 8), frames }
}

/// The paper's zone and its gate at the edge: the template is updated in the zone alone; what has left takes more to return,
/// in every frame, until it was lost and found again.
fn edges() -> Case {
    let path = [
        (24, 20),
        (22, 21),
        (21, 20),
        (20, 20),
        (19, 20),
        (20, 19),
        (20, 22),
        (20, 23),
        (37, 21),
        (38, 21),
        (38, 10),
        (39, 10),
        (38, 11),
        (30, 12),
        (25, 20),
        (60, 60),
        (60, 60),
        (26, 21),
        (27, 20),
    ];
    let size = (48, 32);
    let frames = scenes(size, (9, 8), &path);
    Case { name: "edges", numbers: Numbers::paper(), size, target: (24, 20, 9, 8), frames }
}

/// The camera's numbers: the template is updated up to the edge, alpha has a floor, and a peak below the least ratio is none.
fn camera() -> Case {
    let path =
        [(18, 12), (18, 12), (10, 14), (1, 15), (0, 15), (-3, 14), (1, 14), (60, 60), (60, 60), (4, 12), (33, 20)];
    let size = (44, 30);
    let mut frames = scenes(size, (9, 8), &path);
    // A still scene, then a little more light.
    let brighter = |frame: &[u8], by: u8| frame.iter().map(|pixel| pixel.saturating_add(by)).collect::<Vec<_>>();
    frames[1] = brighter(&frames[0], 1);
    frames.insert(2, brighter(&frames[0], 3));
    Case { name: "camera", numbers: Numbers::camera(), size, target: (18, 12, 9, 8), frames }
}

/// Every number another one; the scale in a case of its own, because only Rust takes another table.
fn others(name: &'static str, scale: f64, frames: usize) -> Case {
    let mut numbers = Numbers { scale, ..Numbers::paper() };
    numbers.k = (7.0, 20.0);
    numbers.first_alpha = 30.0;
    numbers.padding = 5;
    numbers.window = (7, 6);
    numbers.growth = 2;
    numbers.window_limit = Some((12, 9));
    numbers.neighbourhood = 3;
    numbers.zone = (4, 3, 5, 6);
    numbers.least_alpha = 9.0;
    numbers.gate.tracking = (21.0, 20.0);
    numbers.gate.border = (23.0, 20.0);
    numbers.gate.been_at_border = (5.0, 4.0);
    numbers.gate.lost = (3.0, 2.0);
    numbers.gate.lead = 40.0;
    numbers.gate.least_ratio = 12000.0;
    let path =
        [(15, 10), (17, 9), (19, 12), (60, 60), (60, 60), (22, 9), (26, 12), (31, 14), (33, 14), (36, 15), (30, 13)];
    // The padding of 5 ends at 34: the target goes beyond it.
    let size = (40, 28);
    let frames = scenes(size, (11, 9), &path[..frames]);
    Case { name, numbers, size, target: (15, 10, 11, 9), frames }
}

/// A checkerboard without noise: every frame has many offsets of the same score.
fn ties() -> Case {
    let mut numbers = Numbers::paper();
    numbers.runner_up_always = true;
    let size = (28, 24);
    let board = |(right, down): (i64, i64)| {
        pixels(size, |x, y| if ((x + right) / 3 + (y + down) / 3) % 2 == 0 { 50 } else { 170 })
    };
    let frames = [(0, 0), (3, 0), (3, 3), (4, 3), (4, 5), (1, 5)].map(board).to_vec();
    Case { name: "ties", numbers, size, target: (9, 9, 8, 7), frames }
}

/// The smallest frame and the smallest template.
fn one_pixel() -> Case {
    let frames = [7_u8, 7, 9, 200, 7].map(|level| vec![level]).to_vec();
    Case { name: "one-pixel", numbers: Numbers::paper(), size: (1, 1), target: (0, 0, 1, 1), frames }
}

pub fn pixels((width, height): (i64, i64), level: impl Fn(i64, i64) -> u8) -> Vec<u8> {
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| level(x, y)).collect()
}

/// A textured target at each place of `path` before a textured background, with noise that differs from frame to frame.
fn scenes(size: (i64, i64), target: (i64, i64), path: &[(i64, i64)]) -> Vec<Vec<u8>> {
    let scene = |(seed, &(left, top)): (u32, &(i64, i64))| {
        pixels(size, |x, y| {
            let inside = (left..left + target.0).contains(&x) && (top..top + target.1).contains(&y);
            let texture = if inside { hash(x - left, y - top, 1) } else { hash(x / 2, y / 2, 2) / 2 };
            texture.saturating_add(hash(x, y, 100 + seed) % 8)
        })
    };
    (0..).zip(path).map(scene).collect()
}

/// A byte that looks random, the same on every machine.
pub fn hash(x: i64, y: i64, seed: u32) -> u8 {
    let mut bits = seed;
    for coordinate in [x, y] {
        let [low, high, ..] = coordinate.to_le_bytes();
        bits = (bits ^ u32::from_le_bytes([low, high, 0, 0])).wrapping_mul(0x9E37_79B1).rotate_left(13);
    }
    (bits ^ bits >> 15).wrapping_mul(0x85EB_CA77).to_be_bytes()[0]
}

impl Case {
    fn write(&self, text: &mut String) {
        let mut line = |words: String| text.push_str(&(words + "\n"));
        let (x, y, width, height) = self.target;
        line(format!("\ncase {}", self.name));
        line(format!("size {} {}", self.size.0, self.size.1));
        lines(&self.numbers).into_iter().for_each(&mut line);
        line(format!("lock {x} {y} {width} {height} {}", hex(&self.frames[0])));
        let mut reference = Reference::lock(self.numbers.clone(), &self.frames[0], self.size, self.target);
        for frame in &self.frames[1..] {
            let step = reference.update(frame);
            line(format!("frame {}", hex(frame)));
            line(answer(&step, width * height, reference.template()));
        }
    }
}

/// The configuration of a case, a line a number.
fn lines(numbers: &Numbers) -> Vec<String> {
    let Numbers {
        scale,
        k,
        first_alpha,
        padding,
        window,
        growth,
        window_limit,
        neighbourhood,
        zone,
        least_alpha,
        gate,
        runner_up_always,
    } = numbers;
    let ratio = |(numerator, denominator): (f64, f64)| format!("{numerator} {denominator}");
    let margins = |(left, top, right, bottom): (i64, i64, i64, i64)| format!("{left} {top} {right} {bottom}");
    let window_limit = window_limit.unwrap_or((u16::MAX.into(), u16::MAX.into()));
    vec![
        format!("scale {scale}"),
        format!("k {}", ratio(*k)),
        format!("first_threshold {}", first_alpha.ceil()),
        format!("least_threshold {}", least_alpha.ceil()),
        format!("padding {padding}"),
        format!("window {} {}", window.0, window.1),
        format!("growth {growth}"),
        format!("window_limit {} {}", window_limit.0, window_limit.1),
        format!("neighbourhood {neighbourhood}"),
        format!("update_zone {}", margins(*zone)),
        format!("gate_tracking {}", ratio(gate.tracking)),
        format!("gate_leaving {}", ratio(gate.border)),
        format!("gate_returning {}", ratio(gate.been_at_border)),
        format!("gate_lost {}", ratio(gate.lost)),
        format!("gate_lead {}", gate.lead),
        format!("gate_least_ratio {}", gate.least_ratio),
        format!("runner_up_always {}", u8::from(*runner_up_always)),
    ]
}

fn answer(step: &Step, area: i64, template: &[f64]) -> String {
    let state = match step.decision {
        Decision::Tracking => "tracking",
        Decision::Leaving => "leaving",
        Decision::Lost => "lost",
    };
    let (x, y) = step.position;
    let ((peak_x, peak_y), score) = step.peak;
    let ratio = |score: f64| (score / area as f64).floor();
    let asked = step.runner_up_asked;
    let (ratio, runner_up_ratio, alpha) = (ratio(score), ratio(step.runner_up), step.alpha.ceil());
    let (runner_up, runner_up_ratio) = if asked { (step.runner_up, runner_up_ratio) } else { (0.0, 0.0) };
    let (asked, hash) = (u8::from(asked), template_hash(template));
    format!(
        "answer {x} {y} {state} {ratio} {runner_up_ratio} {alpha} {peak_x} {peak_y} {score} {runner_up} {asked} {hash:08x}"
    )
}

/// FNV-1a, 32 bits, over the template's bytes.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // intensities are whole, 0 to 255
fn template_hash(template: &[f64]) -> u32 {
    template.iter().fold(0x811C_9DC5, |hash, &level| (hash ^ u32::from(level as u8)).wrapping_mul(0x0100_0193))
}

pub fn hex(pixels: &[u8]) -> String {
    pixels.iter().fold(String::new(), |mut text, pixel| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{pixel:02x}");
        text
    })
}
