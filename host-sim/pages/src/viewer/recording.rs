//! A recording as the frame source of `host-sim view`: any frame as a JPEG. Recent frames are cached, also at full
//! resolution; frames soon after the last decoded one need no seek. A recording is reopened when its file has grown.

use super::frame_cache::FrameCache;
use super::lock;
use super::source::{Known, SIDE, Source};
use crate::encode;
use anyhow::Result;
use smr_recordings::{ColorFrame, Frames, INNER, OpenOptions, Seekable, Sequence};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use std::{fs, thread};

/// Interval between checks whether the file has grown.
const LOOKS: Duration = Duration::from_secs(1);
const MAX_BYTES: usize = 96 << 20;
/// Largest number of pixels in all cached full-resolution frames: 64 MB at 3 bytes a pixel.
const MAX_PIXELS: usize = (64 << 20) / 3;
/// Largest number of frames to decode one after another to reach a later frame; a seek reaches a farther frame.
const NEAR: usize = 24;
/// Extra frames that a backward seek goes back, because a user who steps back will request earlier frames next.
const BEFORE: usize = 12;

pub struct Growing {
    path: PathBuf,
    options: OpenOptions,
    opened: Arc<Mutex<Opened>>,
}

struct Opened {
    recorded: Arc<Recorded>,
    /// Largest frame count and longest list of times so far: a reopened recording starts with an incomplete index.
    known: Known,
    /// Value of [`size`] when the recording was last opened.
    size: u64,
    seen: u64,
    looked: Instant,
}

/// An open recording with the frames that it had when opened, and its caches.
struct Recorded {
    recording: Seekable,
    images: Mutex<Images>,
    colors: Mutex<FrameCache<Arc<ColorFrame>>>,
}

struct Images {
    kept: FrameCache<Arc<Vec<u8>>>,
    /// Number of the next frame, and an iterator that starts with it.
    reader: Option<(usize, Box<dyn Iterator<Item = ColorFrame> + Send>)>,
    last: usize,
}

impl Growing {
    /// Opens the recording at `path`. Also returns it as a sequence that is read in order.
    pub fn open(path: &Path, options: OpenOptions) -> Result<(Self, Sequence)> {
        let size = size(path);
        let (recording, sequence) = Seekable::open(path, &options)?;
        let recorded = Recorded::new(recording);
        let opened = Opened { recorded, known: Known::default(), size, seen: size, looked: Instant::now() };
        Ok((Self { path: path.to_owned(), options, opened: Arc::new(Mutex::new(opened)) }, sequence))
    }

    fn recorded(&self) -> Arc<Recorded> {
        let mut opened = lock(&self.opened);
        if opened.looked.elapsed() >= LOOKS {
            let before = std::mem::replace(&mut opened.seen, size(&self.path));
            opened.looked = Instant::now();
            // The file has grown, and its size is stable since the last check.
            if opened.seen > opened.size && opened.seen == before {
                opened.size = opened.seen;
                self.open_anew(opened.size);
            }
        }
        Arc::clone(&opened.recorded)
    }

    /// Reopens the recording on a separate thread, because ffmpeg may take long.
    fn open_anew(&self, size: u64) {
        let (path, options, opened) = (self.path.clone(), self.options.clone(), Arc::clone(&self.opened));
        thread::spawn(move || {
            if let Ok((recording, _)) = Seekable::open(&path, &options) {
                let mut opened = lock(&opened);
                if opened.size == size {
                    opened.recorded = Recorded::new(recording);
                }
            }
        });
    }
}

impl Source for Growing {
    fn known(&self) -> Known {
        let (frames, times) = self.recorded().recording.known();
        let known = &mut lock(&self.opened).known;
        known.frames = known.frames.max(frames);
        if times.len() > known.times.len() {
            known.times = times;
        }
        known.clone()
    }

    fn gray_from(&self, number: usize) -> Result<Frames> {
        self.recorded().recording.gray_from(number)
    }

    fn image(&self, number: usize) -> Option<Arc<Vec<u8>>> {
        let recorded = self.recorded();
        let mut images = lock(&recorded.images);
        if let Some(image) = images.kept.all().get(&number) {
            return Some(Arc::clone(image));
        }
        let is_near = images.reader.as_ref().is_some_and(|(next, _)| (*next..next + NEAR).contains(&number));
        let steps_back = number < images.last && images.last - number < NEAR;
        let begin = if steps_back { number.saturating_sub(BEFORE).max(1) } else { number };
        images.last = number;
        // If an attempt that starts at an earlier frame fails, a second one seeks to the requested frame itself.
        let begins = [Some(begin).filter(|_| !is_near), Some(number).filter(|_| is_near || begin < number)];
        begins.into_iter().find_map(|begin| {
            if let Some(begin) = begin {
                // Dropping the former reader ends its ffmpeg before the next one starts.
                images.reader = None;
                images.reader = Some((begin, recorded.recording.color_from(begin, SIDE).ok()?));
            }
            images.read_to(number, &recorded.colors)
        })
    }

    fn color(&self, number: usize) -> Option<Arc<ColorFrame>> {
        let recorded = self.recorded();
        let kept = lock(&recorded.colors).all().get(&number).cloned();
        kept.or_else(|| {
            let frame = Arc::new(recorded.recording.color_from(number, u16::MAX).ok()?.next()?);
            lock(&recorded.colors).keep(number, Arc::clone(&frame));
            Some(frame)
        })
    }
}

/// Returns the size of a file in bytes, or the number of entries in a folder and its subfolders `INNER`; 0 for a
/// built-in recording.
fn size(path: &Path) -> u64 {
    let files = |folder: &str| fs::read_dir(path.join(folder)).map_or(0, |files| files.count() as u64);
    match fs::metadata(path) {
        Ok(data) if data.is_dir() => files("") + INNER.map(files).iter().sum::<u64>(),
        Ok(data) => data.len(),
        Err(_) => 0,
    }
}

impl Recorded {
    fn new(recording: Seekable) -> Arc<Self> {
        let images = Images { kept: FrameCache::new(MAX_BYTES, |image| image.len()), reader: None, last: 0 };
        let colors = FrameCache::new(MAX_PIXELS, |frame: &Arc<ColorFrame>| frame.pixels.len());
        Arc::new(Self { recording, images: Mutex::new(images), colors: Mutex::new(colors) })
    }
}

impl Images {
    fn read_to(&mut self, number: usize, colors: &Mutex<FrameCache<Arc<ColorFrame>>>) -> Option<Arc<Vec<u8>>> {
        loop {
            let (next, frames) = self.reader.as_mut()?;
            let at = *next;
            let Some(frame) = frames.next() else {
                self.reader = None;
                return None;
            };
            *next += 1;
            let image = Arc::new(encode::color_jpeg(&encode::within(&frame, SIDE), encode::GOOD).ok()?);
            self.kept.keep(at, Arc::clone(&image));
            // A frame with a side of `SIDE` is not cached as full resolution: ffmpeg may have scaled it down.
            if frame.width.max(frame.height) < SIDE {
                lock(colors).keep(at, Arc::new(frame));
            }
            if at == number {
                return Some(image);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_one_level_down_count() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("img")).unwrap();
        let before = size(folder.path());
        fs::write(folder.path().join("img/1.pgm"), b"").unwrap();
        assert_eq!(size(folder.path()), before + 1);
    }

    #[test]
    fn a_folder_that_has_grown_is_opened_anew_when_it_rests() {
        let folder = tempfile::tempdir().unwrap();
        let write = |number: u8| {
            fs::write(folder.path().join(format!("{number}.pgm")), [b"P5 4 2 255\n", &[number; 8][..]].concat())
        };
        (1..=3).try_for_each(write).unwrap();
        let (source, sequence) = Growing::open(folder.path(), OpenOptions::default()).unwrap();
        assert_eq!((sequence.frames.count(), source.known().frames), (3, Some(3)));
        fs::remove_file(folder.path().join("2.pgm")).unwrap();
        assert_eq!(
            [1, 3, 2, 1, 3, 2].map(|number| source.image(number).is_some()),
            [true, true, false, true, true, false]
        );
        (2..=5).try_for_each(write).unwrap();
        let begin = Instant::now();
        while source.known().frames == Some(3) {
            assert!(begin.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(source.known().frames, Some(5));
        assert!(begin.elapsed() > LOOKS && source.image(5).is_some());
        assert_eq!(source.gray_from(5).unwrap().next().unwrap().unwrap().gray.pixels[0], 5);
        let index = Known { frames: Some(7), times: vec![0.5; 7] };
        lock(&source.opened).known = index.clone();
        assert_eq!(source.known(), index, "it does not fall while an index is made");
        fs::remove_file(folder.path().join("5.pgm")).unwrap();
        thread::sleep(2 * LOOKS);
        assert_eq!(source.known().frames, Some(7), "what is shorter for a while is not");
    }

    #[test]
    fn any_frame_is_there_and_no_other() {
        let recorded = Growing::open(Path::new("synthetic"), OpenOptions::default()).unwrap().0;
        let order = [1, 2, 200, 199, 198, 150, 3];
        let seen: Vec<_> = order.iter().map(|&number| recorded.image(number).unwrap()).collect();
        let mut sorted = seen.clone();
        sorted.dedup();
        assert_eq!(sorted.len(), order.len());
        assert_eq!(recorded.image(200).unwrap(), seen[2]);
        let count = recorded.known().frames.unwrap();
        assert!(recorded.image(count).is_some() && recorded.image(count + 1).is_none());
        assert!(recorded.image(1).is_some());
        let gray = |number| recorded.gray_from(number).unwrap().next().unwrap().unwrap().gray;
        for number in [150, count, 7] {
            assert_eq!(*recorded.color(number).unwrap(), ColorFrame::from(&gray(number)), "{number}");
        }
        assert!(recorded.color(count + 1).is_none());
    }
}
