//! Inputs of the benches, cut from the built-in recording, so that every run and every machine has the same pixels.

use smr_core::paper::{Config, Radius};
use smr_core::similarity::Backend;
use smr_core::{Answer, Paper, Rect, Tracker};
use smr_recordings::GrayFrame;
use smr_recordings::synthetic::{self, HEIGHT, WIDTH};

pub type Small = Tracker<Paper<4096, 33>>;

/// Index of the first of the three frames that the benches use. In these frames, nothing covers the target.
const FIRST: usize = 40;

const RADIUS: Radius = Radius { x: 16, y: 16 };

/// A tracker after a lock and one update: the next update is measured.
pub struct Prepared {
    tracker: Box<Small>,
    frame: GrayFrame,
}

/// Returns a box of this size with the target in its middle and the search window inside the frame.
pub fn target(width: u16, height: u16) -> Rect {
    let truth = synthetic::truth(FIRST).and_then(|truth| truth.to_rect()).expect("the target is visible");
    let place = |from: i32, own: u16, size: u16, radius: u16, frame: u16| {
        let middle = from + (i32::from(own) - i32::from(size)) / 2;
        middle.clamp(i32::from(radius), i32::from(frame) - i32::from(size) - i32::from(radius))
    };
    let x = place(truth.x, truth.width, width, RADIUS.x, WIDTH);
    let y = place(truth.y, truth.height, height, RADIUS.y, HEIGHT);
    Rect::new(x, y, width, height)
}

pub fn frame() -> GrayFrame {
    synthetic::frame(FIRST)
}

pub fn tracker(backend: Backend, pruning: bool) -> Box<Small> {
    let mut config = Config::paper();
    config.window = RADIUS;
    config.window_limit = RADIUS;
    config.backend = Some(backend);
    config.pruning = pruning;
    Box::new(Small::with(config).expect("the configuration can be used"))
}

impl Prepared {
    /// Locks in the first frame and updates with the second: template and pixel threshold are then as in a long run.
    pub fn new(backend: Backend, pruning: bool, target: Rect) -> Self {
        let mut tracker = tracker(backend, pruning);
        tracker.lock(&frame().frame(), target).expect("the box lies in the frame");
        tracker.update(&synthetic::frame(FIRST + 1).frame()).expect("the frame is whole");
        Self { tracker, frame: synthetic::frame(FIRST + 2) }
    }

    pub fn update(&mut self) -> Answer {
        self.tracker.update(&self.frame.frame()).expect("the frame is whole")
    }
}

/// A template, the next frame, and the box in that frame which is compared with the template.
pub struct Patch {
    pub frame: GrayFrame,
    pub template: GrayFrame,
    pub target: Rect,
}

pub fn patch() -> Patch {
    let target = target(64, 64);
    let first = frame();
    let cut = first.frame().patch(target).expect("the box lies in the frame");
    let pixels = cut.rows().flatten().copied().collect();
    let template = GrayFrame { width: target.width, height: target.height, pixels };
    Patch { frame: synthetic::frame(FIRST + 1), template, target }
}
