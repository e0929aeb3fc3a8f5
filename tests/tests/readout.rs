//! Partial readout: a tracker that gets only the windows it asks for gives the same answers as one that gets whole frames. With less it
//! refuses.

use smr_core::readout::{Format, Readout};
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
    let tracker = || Box::new(Tracker::<T>::with(config).expect("a good configuration"));
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
fn the_papers_tracker_reads_only_what_it_asks_for() {
    assert_eq!(compare::<SmallPaper>(paper::Config::camera()), (39 * 29, 0));
}

#[test]
fn the_robust_tracker_reads_only_what_it_asks_for() {
    let (frames, sweeps) = compare::<Robust>(robust::Config::refined());
    assert_eq!(frames, 39 * 29);
    assert!(sweeps > 100, "a second window is asked for in {sweeps} frames");
}

/// A frame as a camera of this format sends it, with three bytes after each line; and its gray levels, by the words of the documentation.
fn sent(format: Format, gray: &[u8], (width, height): (u16, u16)) -> (Vec<u8>, usize, Vec<u8>) {
    let (width, height) = (usize::from(width), usize::from(height));
    let (columns, lines) = if format == Format::Bayer8 { (2 * width, 2 * height) } else { (width, height) };
    let stride = format.line_bytes(u16::try_from(columns).unwrap()) + 3;
    let (mut bytes, mut meant) = (vec![0x5A; stride * lines], gray.to_vec());
    let widened = |value: u32, bits: u32| value << (8 - bits) | value >> (2 * bits - 8);
    for (at, &level) in gray.iter().enumerate() {
        let (x, y) = (at % width, at / width);
        let rgb = u16::from(level) * 257;
        let mut put = |x: usize, y: usize, byte: u8| bytes[y * stride + x] = byte;
        match format {
            Format::Gray8 => put(x, y, level),
            Format::Yuyv => put(2 * x, y, level),
            Format::Uyvy => put(2 * x + 1, y, level),
            Format::Rgb565Be | Format::Rgb565Le => {
                let pair = if format == Format::Rgb565Be { rgb.to_be_bytes() } else { rgb.to_le_bytes() };
                put(2 * x, y, pair[0]);
                put(2 * x + 1, y, pair[1]);
                let rgb = u32::from(rgb);
                let (red, green, blue) = (widened(rgb >> 11, 5), widened(rgb >> 5 & 63, 6), widened(rgb & 31, 5));
                meant[at] = u8::try_from((19_595 * red + 38_470 * green + 7_471 * blue + 32_768) >> 16).unwrap();
            }
            Format::Bayer8 => {
                let colors = [level, level.wrapping_add(3), level / 2, level.wrapping_mul(5)];
                for (color, (right, down)) in colors.into_iter().zip([(0, 0), (1, 0), (0, 1), (1, 1)]) {
                    put(2 * x + right, 2 * y + down, color);
                }
                let [a, b, c, d] = colors.map(u16::from);
                meant[at] = u8::try_from(((a + b) / 2 + (c + d).div_ceil(2)) / 2).unwrap();
            }
            Format::Gray10 => put(x / 4 * 5 + x % 4, y, level),
            other => panic!("{other:?}"),
        }
    }
    (bytes, stride, meant)
}

/// A tracker that is fed line by line, in the format of the camera, answers as one that sees whole gray frames.
fn fed_line_by_line<T: Target>(config: T::Config, recording: &Recording, format: Format) {
    let new = || Box::new(Tracker::<T>::with(config).expect("a valid configuration"));
    let (mut whole, mut fed) = (new(), new());
    let (size, bounds) = (recording.size, Rect::new(0, 0, recording.size.0, recording.size.1));
    let sensor = if format == Format::Bayer8 { (2 * size.0, 2 * size.1) } else { size };
    for (number, gray) in recording.frames.iter().enumerate() {
        let (bytes, stride, meant) = sent(format, gray, size);
        let frame = Frame::whole(Image::new(&meant, size.0, size.1).unwrap());
        let near = if number == 0 { fed.lock_window(bounds, recording.target) } else { fed.window().unwrap() };
        let far = fed.sweep_window().filter(|rect| number > 0 && !rect.is_empty());
        let mut readout = Readout::new(format, sensor, near).unwrap();
        if let Some(far) = far {
            readout = readout.and_window(far).unwrap();
        }
        let mut pixels = vec![0; readout.pixels()];
        for y in 0..sensor.1 {
            readout.push_line(y, &bytes[usize::from(y) * stride..], &mut pixels).unwrap();
        }
        let read = readout.frame(&pixels).unwrap();
        if number == 0 {
            assert_eq!(fed.lock(&read, recording.target), whole.lock(&frame, recording.target));
        } else {
            assert_eq!(fed.update(&read), whole.update(&frame), "{format:?}, frame {number}");
        }
    }
    assert_eq!(saved(&fed), saved(&whole), "{format:?}");
}

#[test]
fn every_format_of_a_camera_gives_the_answers_of_gray_frames() {
    for format in Format::ALL {
        for seed in [1, 5] {
            fed_line_by_line::<SmallPaper>(paper::Config::camera(), &recording(seed), format);
            fed_line_by_line::<Robust>(robust::Config::refined(), &recording(seed), format);
        }
    }
}

#[test]
fn every_format_of_a_camera_gives_the_answers_of_a_recording() {
    use smr_recordings::OpenOptions;
    let test = "every_format_of_a_camera_gives_the_answers_of_a_recording";
    let Some(folder) = crate::missing::recordings(test, "tld/06_car") else { return };
    let opened = smr_recordings::open(&folder, &OpenOptions::default()).unwrap();
    let target = opened.start().unwrap();
    let frames: Vec<_> = opened.frames.take(12).map(|frame| frame.unwrap().gray).collect();
    let size = (frames[0].width, frames[0].height);
    let recording = Recording { size, target, frames: frames.into_iter().map(|frame| frame.pixels).collect() };
    for format in Format::ALL {
        fed_line_by_line::<Robust>(robust::Config::refined(), &recording, format);
    }
}
