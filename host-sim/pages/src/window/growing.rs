//! A recording that may still be copied or written: it is opened anew when it has grown.

use super::{Known, Numbered, Recorded, Source};
use anyhow::Result;
use smr_recordings::{INNER, OpenOptions, Seekable, Sequence};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The time between two looks at the size of the file.
const LOOKS: Duration = Duration::from_secs(1);

/// A recording as the source of a window.
pub struct Growing {
    path: PathBuf,
    options: OpenOptions,
    opened: Arc<Mutex<Opened>>,
}

struct Opened {
    recorded: Arc<Recorded>,
    /// The most that was known: an index that is still made knows less.
    known: Known,
    /// Bytes when it was opened.
    size: u64,
    /// Bytes at the last look.
    seen: u64,
    looked: Instant,
}

impl Growing {
    /// Opens the recording at `path`, and also gives it as it is read in order.
    /// Errors: Those of [`Seekable::open`].
    pub fn open(path: &Path, options: OpenOptions) -> Result<(Self, Sequence)> {
        let size = size(path);
        let (recording, sequence) = Seekable::open(path, &options)?;
        let recorded = Arc::new(Recorded::new(recording));
        let opened = Opened { recorded, known: Known::default(), size, seen: size, looked: Instant::now() };
        Ok((Self { path: path.to_owned(), options, opened: Arc::new(Mutex::new(opened)) }, sequence))
    }

    fn recorded(&self) -> Arc<Recorded> {
        let mut opened = lock(&self.opened);
        if opened.looked.elapsed() >= LOOKS {
            let before = std::mem::replace(&mut opened.seen, size(&self.path));
            opened.looked = Instant::now();
            // Whoever writes it has ended, or rests.
            if opened.seen > opened.size && opened.seen == before {
                opened.size = opened.seen;
                self.open_anew(opened.size);
            }
        }
        Arc::clone(&opened.recorded)
    }

    /// Opens it on a thread of its own: ffmpeg may take long.
    fn open_anew(&self, size: u64) {
        let (path, options, opened) = (self.path.clone(), self.options.clone(), Arc::clone(&self.opened));
        thread::spawn(move || {
            if let Ok((recording, _)) = Seekable::open(&path, &options) {
                let mut opened = lock(&opened);
                if opened.size == size {
                    opened.recorded = Arc::new(Recorded::new(recording));
                }
            }
        });
    }
}

fn lock(opened: &Mutex<Opened>) -> MutexGuard<'_, Opened> {
    opened.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The bytes of a file, or the files of a folder; 0 of a built-in recording.
fn size(path: &Path) -> u64 {
    let files = |folder: &str| fs::read_dir(path.join(folder)).map_or(0, |files| files.count() as u64);
    match fs::metadata(path) {
        Ok(data) if data.is_dir() => files("") + INNER.map(files).iter().sum::<u64>(),
        Ok(data) => data.len(),
        Err(_) => 0,
    }
}

impl Source for Growing {
    fn known(&self) -> Known {
        let Known { frames, times } = self.recorded().known();
        let known = &mut lock(&self.opened).known;
        known.frames = known.frames.max(frames);
        if times.len() > known.times.len() {
            known.times = times;
        }
        known.clone()
    }

    fn gray_from(&self, number: usize) -> Result<Numbered> {
        self.recorded().gray_from(number)
    }

    fn picture(&self, number: usize) -> Option<Arc<Vec<u8>>> {
        self.recorded().picture(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_one_level_down_count() {
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
        (4..=5).try_for_each(write).unwrap();
        let begin = Instant::now();
        while source.known().frames == Some(3) {
            assert!(begin.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(source.known().frames, Some(5));
        assert!(begin.elapsed() > LOOKS && source.picture(5).is_some());
        assert_eq!(source.gray_from(5).unwrap().next().unwrap().unwrap().2.pixels[0], 5);
        let index = Known { frames: Some(7), times: vec![0.5; 7] };
        lock(&source.opened).known = index.clone();
        assert_eq!(source.known(), index, "it does not fall while an index is made");
        fs::remove_file(folder.path().join("5.pgm")).unwrap();
        thread::sleep(2 * LOOKS);
        assert_eq!(source.known().frames, Some(7), "what is shorter for a while is not");
    }
}
