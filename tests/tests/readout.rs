//! Partial readout: a tracker that gets only the windows it asks for gives the same answers as one that gets whole frames. With less it
//! refuses.

use smr_core::{Frame, Image, LockError, Paper, Rect, Robust, Target, Tracker, UpdateError, paper, robust};

type SmallPaper = Paper<16_384, 301>;

/// Frames of one size. The target is locked in the middle.
struct Recording {
    size: (u16, u16),
    target: Rect,
    frames: Vec<Vec<u8>>,
}

/// A waving texture that moves and grows; three of nine frames are noise, so that the target is lost and searched.
fn recording(seed: u16) -> Recording {
    let (width, height) = (60 + seed * 37 % 200, 50 + seed * 53 % 150);
    let (across, down) = (4 + seed * 29 % (width / 2), 4 + seed * 31 % (height / 2));
    let target = Rect::new(i32::from((width - across) / 2), i32::from((height - down) / 2), across, down);
    let pixels = || (0..height).flat_map(move |y| (0..width).map(move |x| (f64::from(x), f64::from(y))));
    let scene = |step: u16| -> Vec<u8> {
        let step = f64::from(step);
        let zoom = 1.0 + 0.02 * step;
        let level = |(x, y): (f64, f64)| {
            let (u, v) = ((x - 3.0 * step) / zoom, (y - 2.0 * (step % 5.0)) / zoom);
            let near = (u * 0.31 + f64::from(seed)).sin() * (v * 0.27).cos();
            128.0 + 60.0 * near + 50.0 * (u * 0.11 + v * 0.17).sin()
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // gray levels
        let byte = |level: f64| level as u8;
        pixels().map(level).map(byte).collect()
    };
    let noise = |step: u16| -> Vec<u8> {
        let mut state = u32::from(seed) * 1000 + u32::from(step) + 1;
        let mut next = || {
            for (left, by) in [(true, 13), (false, 17), (true, 5)] {
                state ^= if left { state << by } else { state >> by };
            }
            state.to_be_bytes()[0]
        };
        pixels().map(|_| next()).collect()
    };
    let frames = (0..30).map(|step| if step % 9 > 5 { noise(step) } else { scene(step) }).collect();
    Recording { size: (width, height), target, frames }
}

/// The part of a frame in memory: copies of these rectangles, so that nothing else can be read.
struct Memory {
    parts: Vec<(Rect, Vec<u8>)>,
    size: (u16, u16),
}

impl Memory {
    fn of(frame: &[u8], size: (u16, u16), rects: &[Rect]) -> Self {
        let image = Image::new(frame, size.0, size.1).expect("a frame of this size");
        let copy = |&rect: &Rect| {
            // Even if the tracker needs no pixels, a frame has at least one.
            let rect = if rect.is_empty() { Rect::new(0, 0, 1, 1) } else { rect };
            let part = image.crop(rect).expect("what is asked for lies in the frame");
            (rect, part.rows().flatten().copied().collect())
        };
        Self { parts: rects.iter().map(copy).collect(), size }
    }

    fn frame(&self) -> Frame<'_> {
        let parts = self.parts.iter().map(|(rect, pixels)| {
            let place = (u16::try_from(rect.x).unwrap(), u16::try_from(rect.y).unwrap());
            (Image::new(pixels, rect.width, rect.height).unwrap(), place)
        });
        let mut parts = parts;
        let (image, (x, y)) = parts.next().expect("a part");
        let first = Frame::part(image, x, y, self.size.0, self.size.1).unwrap();
        parts.fold(first, |frame, (image, (x, y))| frame.and_part(image, x, y).unwrap())
    }
}

fn saved<T: Target>(tracker: &Tracker<T>) -> Vec<u8> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let size = tracker.save(&mut bytes).expect("there is a target");
    bytes.truncate(size);
    bytes
}

/// Without its last row; `None` if there is only one.
fn less(rect: Rect) -> Option<Rect> {
    (rect.height > 1).then(|| Rect { height: rect.height - 1, ..rect })
}

/// The number of compared frames, and of those with a second window.
fn compare<T: Target>(config: T::Config) -> (u32, u32) {
    let tracker = || Box::new(Tracker::<T>::new(config).expect("a good configuration"));
    let (mut frames, mut sweeps) = (0, 0);
    for seed in 1..40 {
        let Recording { size, target, frames: pictures } = recording(seed);
        let whole_of = |pixels| Frame::whole(Image::new(pixels, size.0, size.1).unwrap());
        let (mut whole, mut part) = (tracker(), tracker());
        whole.lock(&whole_of(&pictures[0]), target).unwrap();
        let window = part.lock_window(Rect::new(0, 0, size.0, size.1), target);
        if let Some(less) = less(window) {
            let memory = Memory::of(&pictures[0], size, &[less]);
            assert_eq!(part.lock(&memory.frame(), target), Err(LockError::LockWindowNotInMemory));
        }
        part.lock(&Memory::of(&pictures[0], size, &[window]).frame(), target).unwrap();
        assert_eq!(saved(&whole), saved(&part), "recording {seed}: lock");
        for (number, picture) in (1..).zip(&pictures[1..]) {
            let (window, sweep) = (part.window().unwrap(), part.sweep_window());
            let asked: Vec<Rect> = std::iter::once(window).chain(sweep).collect();
            for missing in 0..asked.len() {
                let Some(less) = less(asked[missing]) else { continue };
                let mut fewer = asked.clone();
                fewer[missing] = less;
                // The other part may happen to hold what this one lacks.
                let memory = Memory::of(picture, size, &fewer);
                if !memory.frame().covers(asked[missing]) {
                    assert_eq!(part.update(&memory.frame()), Err(UpdateError::WindowNotInMemory));
                }
            }
            let memory = Memory::of(picture, size, &asked);
            let answers = [whole.update(&whole_of(picture)).unwrap(), part.update(&memory.frame()).unwrap()];
            assert_eq!(answers[0], answers[1], "recording {seed}, frame {number}");
            assert_eq!(saved(&whole), saved(&part), "recording {seed}, frame {number}");
            frames += 1;
            sweeps += u32::from(sweep.is_some());
        }
    }
    (frames, sweeps)
}

#[test]
fn what_is_not_asked_for_is_not_read() {
    assert_eq!(compare::<SmallPaper>(paper::Config::camera()), (39 * 29, 0));
    let (frames, sweeps) = compare::<Robust>(robust::Config::robust());
    assert_eq!(frames, 39 * 29);
    assert!(sweeps > 100, "a second window is asked for in {sweeps} frames");
}
