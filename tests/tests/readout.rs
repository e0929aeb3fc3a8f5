//! Partial readout: a tracker that gets only the windows it asks for, line by line in any camera format, gives the same
//! answers as one that gets whole gray frames. If a line of a window is missing, the tracker returns an error.
//! `smr-core` tests the gray level of each pixel.

use smr_core::readout::{Format, Readout};
use smr_core::{Frame, Image, LockError, Paper, Rect, Robust, Target, Tracker, UpdateError, Windows, paper, robust};

/// Returns the size, the initial box and the pictures of a recording. A texture that fills each picture moves and
/// grows. The last three of every nine pictures are noise, so that the tracker has to search for the target.
fn recording(seed: u16) -> ((u16, u16), Rect, Vec<Vec<u8>>) {
    let (width, height) = (60 + seed * 37 % 200, 50 + seed * 53 % 150);
    let (across, down) = (4 + seed * 29 % (width / 2), 4 + seed * 31 % (height / 2));
    let target = Rect::new(i32::from((width - across) / 2), i32::from((height - down) / 2), across, down);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // gray levels
    let level = |at: u16, step: u16| {
        if step % 9 > 5 {
            let mixed = (u32::from(at) << 16 | u32::from(step)).wrapping_add(u32::from(seed)).wrapping_mul(0x9E37_79B9);
            return (mixed ^ mixed >> 15).wrapping_mul(0x85EB_CA6B).to_be_bytes()[0];
        }
        let (x, y, steps) = (f64::from(at % width), f64::from(at / width), f64::from(step));
        let zoom = 1.0 + 0.02 * steps;
        let (u, v) = ((x - 3.0 * steps) / zoom, (y - 2.0 * (steps % 5.0)) / zoom);
        let near = (u * 0.31 + f64::from(seed)).sin() * (v * 0.27).cos();
        (128.0 + 60.0 * near + 50.0 * (u * 0.11 + v * 0.17).sin()) as u8
    };
    let pictures = (0..30).map(|step| (0..width * height).map(|at| level(at, step)).collect());
    ((width, height), target, pictures.collect())
}

/// The lines of a sensor's picture, each followed by three padding bytes. `Format::BAYER8` has twice as many columns
/// and lines as the picture.
struct Sensor {
    format: Format,
    size: (u16, u16),
    lines: Vec<Vec<u8>>,
}

impl Sensor {
    fn new(format: Format, picture: &[u8], width: u16) -> Self {
        let scale = if format == Format::BAYER8 { 2 } else { 1 };
        let bytes = format.line_bytes(scale * width);
        let line = |row: &[u8]| (0..bytes).map(|at| row[at * row.len() / bytes]).chain([0x5A; 3]).collect();
        let rows = picture.chunks(width.into()).flat_map(|row| vec![row; scale.into()]);
        let lines: Vec<_> = rows.map(line).collect();
        Self { format, size: (scale * width, u16::try_from(lines.len()).unwrap()), lines }
    }

    /// Returns a readout of `windows` and its gray pixels.
    fn read(&self, windows: &[Rect]) -> (Readout, Vec<u8>) {
        // A readout has at least one pixel, even if the tracker needs none.
        let window = |&rect: &Rect| if rect.is_empty() { Rect::new(0, 0, 1, 1) } else { rect };
        let windows = Windows::new(window(&windows[0]), windows.get(1).map(window));
        let mut readout = Readout::new(self.format, self.size, windows).unwrap();
        let mut pixels = vec![0; readout.pixels()];
        (0..).zip(&self.lines).for_each(|(y, line)| readout.push_line(y, line, &mut pixels).unwrap());
        (readout, pixels)
    }
}

fn saved<T: Target>(tracker: &Tracker<T>) -> Vec<u8> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let size = tracker.save(&mut bytes).expect("there is a target");
    bytes[..size].to_vec()
}

/// Compares a tracker that gets partial frames with one that gets whole frames, on 39 recordings. Returns the number of
/// frames with a second window.
fn compare<T: Target>(config: T::Config) -> usize {
    let tracker = || Box::new(Tracker::<T>::with(config).expect("a good configuration"));
    let mut sweeps = 0;
    for (seed, &format) in (1..40).zip(Format::ALL.iter().cycle()) {
        let ((width, height), target, pictures) = recording(seed);
        let bounds = Rect::new(0, 0, width, height);
        let (mut whole, mut part) = (tracker(), tracker());
        for (number, picture) in pictures.iter().enumerate() {
            let of = format!("{format:?}, recording {seed}, frame {number}");
            let sensor = Sensor::new(format, picture, width);
            let (_, gray) = sensor.read(&[bounds]);
            assert!(format != Format::GRAY8 || gray == *picture);
            let frame = Frame::whole(Image::new(&gray, width, height).unwrap());
            let windows = part.windows().unwrap_or(part.lock_window(bounds, target).into());
            let asked: Vec<Rect> = windows.iter().collect();
            for missing in (0..asked.len()).filter(|&missing| asked[missing].height > 1) {
                let mut fewer = asked.clone();
                fewer[missing].height -= 1;
                let (readout, pixels) = sensor.read(&fewer);
                let less = readout.frame(&pixels).unwrap();
                if less.covers(asked[missing]) {
                    continue; // the other window happens to hold what this one lacks
                } else if number == 0 {
                    assert_eq!(part.lock(&less, target), Err(LockError::LockWindowNotInMemory), "{of}");
                } else {
                    assert_eq!(part.update(&less), Err(UpdateError::WindowNotInMemory), "{of}");
                }
            }
            let (readout, pixels) = sensor.read(&asked);
            let read = readout.frame(&pixels).unwrap();
            if number == 0 {
                assert_eq!(part.lock(&read, target).unwrap(), whole.lock(&frame, target).unwrap(), "{of}");
            } else {
                assert_eq!(part.update(&read).unwrap(), whole.update(&frame).unwrap(), "{of}");
            }
            assert_eq!(saved(&whole), saved(&part), "{of}");
            sweeps += asked.len() - 1;
        }
    }
    sweeps
}

#[test]
fn a_tracker_reads_only_what_it_asks_for() {
    assert_eq!(compare::<Paper<16_384, 301>>(paper::Config::camera()), 0);
    let sweeps = compare::<Robust>(robust::Config::refined());
    assert!(sweeps > 100, "a second window is asked for in {sweeps} frames");
}
