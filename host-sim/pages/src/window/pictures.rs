//! Any frame of a recording as a JPEG, soon: what was read last is kept, and what comes next is read in order.

use super::{Known, Numbered, Source};
use crate::encode;
use anyhow::Result;
use smr_recordings::{ColorFrame, Seekable};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The longest side of a picture.
pub const SIDE: u16 = 1280;
/// The most bytes of pictures that are kept.
const MOST_BYTES: usize = 96 << 20;
/// A frame at most this far ahead is reached by reading on; others need a seek.
const NEAR: usize = 24;
/// A user who steps back will want earlier frames, so the seek goes this much further.
const BEFORE: usize = 12;

/// A recording as the source of a window.
pub struct Recorded {
    recording: Seekable,
    pictures: Mutex<Pictures>,
}

#[derive(Default)]
struct Pictures {
    kept: BTreeMap<usize, Arc<Vec<u8>>>,
    bytes: usize,
    /// The number of the frame that comes next, and where it comes from.
    reader: Option<(usize, Box<dyn Iterator<Item = ColorFrame> + Send>)>,
    last: usize,
}

impl Recorded {
    pub fn new(recording: Seekable) -> Self {
        Self { recording, pictures: Mutex::default() }
    }
}

impl Source for Recorded {
    fn known(&self) -> Known {
        let (frames, times) = self.recording.known();
        Known { frames, times }
    }

    fn gray_from(&self, number: usize) -> Result<Numbered> {
        let frames = self.recording.gray_from(number)?;
        Ok(Box::new(frames.map(|frame| frame.map(|frame| (frame.number, frame.seconds, frame.gray)))))
    }

    fn picture(&self, number: usize) -> Option<Arc<Vec<u8>>> {
        let mut pictures = self.pictures.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(picture) = pictures.kept.get(&number) {
            return Some(Arc::clone(picture));
        }
        let next = pictures.reader.as_ref().map(|(next, _)| *next);
        if !next.is_some_and(|next| (next..next + NEAR).contains(&number)) {
            let steps_back = number < pictures.last && pictures.last - number < NEAR;
            let from = if steps_back { number.saturating_sub(BEFORE).max(1) } else { number };
            // This ends the former ffmpeg before the next one starts.
            pictures.reader = None;
            pictures.reader = Some((from, self.recording.color_from(from, SIDE).ok()?));
        }
        pictures.last = number;
        pictures.read_to(number)
    }
}

impl Pictures {
    fn read_to(&mut self, number: usize) -> Option<Arc<Vec<u8>>> {
        loop {
            let (next, frames) = self.reader.as_mut()?;
            let at = *next;
            let Some(frame) = frames.next() else {
                self.reader = None;
                return None;
            };
            *next += 1;
            let picture = Arc::new(encode::color_jpeg(&encode::within(&frame, SIDE), encode::GOOD).ok()?);
            self.keep(at, &picture);
            if at == number {
                return Some(picture);
            }
        }
    }

    /// Keeps a picture. If there are too many bytes, the pictures farthest from it go.
    fn keep(&mut self, number: usize, picture: &Arc<Vec<u8>>) {
        self.bytes += picture.len();
        if let Some(before) = self.kept.insert(number, Arc::clone(picture)) {
            self.bytes -= before.len();
        }
        while self.bytes > MOST_BYTES && self.kept.len() > 1 {
            let (&first, &last) = (self.kept.keys().next().unwrap_or(&0), self.kept.keys().next_back().unwrap_or(&0));
            let farthest = if number - first > last - number { first } else { last };
            self.bytes -= self.kept.remove(&farthest).map_or(0, |picture| picture.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::OpenOptions;
    use std::path::Path;

    #[test]
    fn any_frame_is_there_and_no_other() {
        let recording = Seekable::open(Path::new("synthetic"), &OpenOptions::default()).unwrap().0;
        let recorded = Recorded::new(recording);
        let order = [1, 2, 200, 199, 198, 150, 3];
        let seen: Vec<_> = order.iter().map(|&number| recorded.picture(number).unwrap()).collect();
        let mut sorted = seen.clone();
        sorted.dedup();
        assert_eq!(sorted.len(), order.len());
        assert_eq!(recorded.picture(200).unwrap(), seen[2]);
        let count = recorded.known().frames.unwrap();
        assert!(recorded.picture(count).is_some() && recorded.picture(count + 1).is_none());
        assert!(recorded.picture(1).is_some());
    }

    #[test]
    fn what_is_kept_is_bounded() {
        let mut pictures = Pictures::default();
        let picture = Arc::new(vec![0; 10 << 20]);
        for number in (1..20).chain([3]) {
            pictures.keep(number, &picture);
            assert!(pictures.bytes <= MOST_BYTES && pictures.kept.contains_key(&number));
        }
        assert_eq!(pictures.bytes, pictures.kept.values().map(|one| one.len()).sum::<usize>());
    }
}
