//! A camera as the frame source of `host-sim view`: frames arrive in real time, and the last minutes are kept.
//!
//! Frames have the numbers of the source, which also counts frames that it dropped. Trackers get the newest frame; a
//! frame that arrives while they are busy is skipped and counted, but its JPEG is kept. A tracker locked in a frame of
//! the last seconds gets every frame from there on, until it has caught up.

use super::frame_cache::FrameCache;
use super::lock;
use super::source::{Known, LiveState, SIDE, Source};
use crate::encode;
use anyhow::{Result, anyhow, bail};
use smr_files::messages;
use smr_recordings::{ColorFrame, Frame, Frames, GrayFrame, Live, Planes};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Largest size of all cached gray frames in bytes: seven seconds of 640x480 at 30 frames a second.
const MAX_GRAY: usize = 64 << 20;
/// Largest size of all cached JPEGs in bytes: some minutes of video.
const MAX_IMAGES: usize = 160 << 20;

/// Frame number, and the frame's colors either as luma and chroma planes or as RGB.
type Colors = (usize, Option<Planes>, Option<ColorFrame>);

pub struct Camera(Arc<Shared>);

struct Shared {
    begin: Instant,
    state: Mutex<State>,
    came: Condvar,
}

struct ArrivedFrame {
    gray: GrayFrame,
    seconds: Option<f64>,
    arrived: Instant,
}

struct State {
    gray: FrameCache<ArrivedFrame>,
    images: FrameCache<Arc<Vec<u8>>>,
    newest: usize,
    dropped: usize,
    latency_ms: f64,
    /// Reason why the source ended; `None` while frames come.
    ended: Option<String>,
    stopped: bool,
}

impl State {
    fn new() -> Self {
        Self {
            gray: FrameCache::new(MAX_GRAY, |came: &ArrivedFrame| came.gray.pixels.len()),
            images: FrameCache::new(MAX_IMAGES, |image| image.len()),
            newest: 0,
            dropped: 0,
            latency_ms: 0.0,
            ended: None,
            stopped: false,
        }
    }

    fn oldest_gray(&self) -> usize {
        self.gray.all().first_key_value().map_or(self.newest + 1, |(first, _)| *first)
    }
}

impl Shared {
    fn kept(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    fn read(&self, frames: Frames, images: &SyncSender<Colors>) {
        let mut said = None;
        for frame in frames {
            match frame {
                Ok(Frame { number, gray, seconds, planes, color, .. }) => {
                    let mut kept = self.kept();
                    if kept.stopped {
                        break;
                    }
                    kept.newest = number;
                    kept.gray.keep(number, ArrivedFrame { gray, seconds, arrived: Instant::now() });
                    drop(kept);
                    self.came.notify_all();
                    // While the JPEG encoder is busy, frames get no JPEG.
                    if let Err(TrySendError::Disconnected(_)) = images.try_send((number, planes, color)) {
                        break;
                    }
                }
                Err(error) => said = Some(messages::of(&error)),
            }
        }
        self.kept().ended = Some(said.unwrap_or_else(|| "the source has ended".to_owned()));
        self.came.notify_all();
    }

    fn encode(&self, images: &Receiver<Colors>) {
        for (number, planes, color) in images {
            let color = planes.map(|planes| planes.color()).or(color);
            let small = color.map(|color| encode::within(&color, SIDE));
            if let Some(Ok(image)) = small.map(|small| encode::color_jpeg(&small, encode::ENOUGH)) {
                self.kept().images.keep(number, Arc::new(image));
            }
        }
    }

    /// Waits for the frame that the trackers get next; `None` if there will be none.
    fn next(&self, reader: &mut Reader) -> Option<Result<Frame>> {
        let mut kept = self.kept();
        if let Some(arrived) = reader.arrived {
            kept.latency_ms = 0.9 * kept.latency_ms + 0.1 * arrived.elapsed().as_secs_f64() * 1e3;
        }
        loop {
            if kept.stopped {
                return None;
            }
            if reader.next <= kept.newest {
                break;
            }
            reader.has_caught_up = true;
            if let Some(said) = &kept.ended {
                let is_new = !std::mem::replace(&mut reader.has_told, true);
                return is_new.then(|| Err(anyhow!("{said}")));
            }
            kept = self.came.wait_timeout(kept, Duration::from_secs(1)).unwrap_or_else(PoisonError::into_inner).0;
        }
        let all = kept.gray.all();
        // If the source has dropped the frame of a lock, the tracker gets the one before it.
        let before = all.range(..=reader.next).next_back().filter(|_| reader.arrived.is_none());
        let next = before.or_else(|| all.range(reader.next..).next());
        let (number, ArrivedFrame { gray, seconds, arrived }) =
            next.filter(|_| !reader.has_caught_up).or(all.last_key_value())?;
        let frame = Frame::new(reader.next.max(*number), *seconds, gray.clone());
        // Frames before the reader's first one do not count as dropped, because no target was tracked then.
        let missed = reader.arrived.map_or(0, |_| frame.number - reader.next);
        (reader.next, reader.arrived) = (frame.number + 1, Some(*arrived));
        kept.dropped += missed;
        Some(Ok(frame))
    }
}

/// A reader of the camera's frames for the trackers, from one start frame on.
#[derive(Default)]
struct Reader {
    next: usize,
    /// True once the trackers have waited for a frame; from then on they get only the newest one.
    has_caught_up: bool,
    /// Arrival time of the last frame given to the trackers; `None` before the first.
    arrived: Option<Instant>,
    has_told: bool,
}

impl Camera {
    pub fn new(live: Live) -> Self {
        let arrivals = Arc::clone(&live.arrivals);
        let end = std::iter::once_with(move || arrivals.ended().map(|said| Err(anyhow!(said))));
        Self::of(Box::new(live.map(Ok).chain(end.flatten())))
    }

    fn of(frames: Frames) -> Self {
        let shared = Arc::new(Shared { begin: Instant::now(), state: Mutex::new(State::new()), came: Condvar::new() });
        let (sender, images) = sync_channel(1);
        let (reader, encoder) = (Arc::clone(&shared), Arc::clone(&shared));
        thread::spawn(move || reader.read(frames, &sender));
        thread::spawn(move || encoder.encode(&images));
        Self(shared)
    }
}

impl Source for Camera {
    fn known(&self) -> Known {
        Known { frames: Some(self.0.kept().newest), times: Vec::new() }
    }

    fn gray_from(&self, number: usize) -> Result<Frames> {
        let kept = self.0.kept();
        let oldest = kept.oldest_gray();
        if number < oldest {
            bail!("trackers can go back to frame {oldest} only: lock in a newer frame");
        }
        drop(kept);
        let shared = Arc::clone(&self.0);
        let mut reader = Reader { next: number, ..Reader::default() };
        Ok(Box::new(std::iter::from_fn(move || shared.next(&mut reader))))
    }

    fn oldest(&self) -> usize {
        self.0.kept().oldest_gray()
    }

    /// Returns the JPEG of the frame or, if it has none, of the nearest frame before it.
    fn image(&self, number: usize) -> Option<Arc<Vec<u8>>> {
        let kept = self.0.kept();
        let nearest = kept.images.all().range(..=number).next_back();
        nearest.filter(|_| number <= kept.newest).map(|(_, image)| Arc::clone(image))
    }

    fn live(&self) -> Option<LiveState> {
        let kept = self.0.kept();
        let seconds = self.0.begin.elapsed().as_secs_f64();
        #[allow(clippy::cast_precision_loss)] // far below 2^52
        let rate = kept.newest as f64 / seconds.max(0.001);
        Some(LiveState {
            oldest: kept.images.all().first_key_value().map_or(1, |(first, _)| *first),
            newest: kept.newest,
            dropped: kept.dropped,
            latency_ms: (kept.latency_ms * 10.0).round() / 10.0,
            rate: (rate * 100.0).round() / 100.0,
            has_ended: kept.ended.is_some() || kept.stopped,
        })
    }

    fn stop(&self) {
        self.0.kept().stopped = true;
        self.0.came.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    fn frame(level: u8) -> Frame {
        let gray = GrayFrame { width: 8, height: 8, pixels: vec![level; 64] };
        Frame { color: Some(ColorFrame::from(&gray)), ..Frame::new(level.into(), Some(level.into()), gray) }
    }

    fn wait_for(camera: &Camera, newest: usize) {
        let begin = Instant::now();
        while camera.live().unwrap().newest < newest || camera.0.kept().images.all().is_empty() {
            assert!(begin.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn trackers_get_the_newest_frame_and_what_they_miss_is_counted() {
        let (sender, frames) = channel();
        let camera = Camera::of(Box::new(frames.into_iter()));
        (2..=3).for_each(|level| sender.send(Ok(frame(level))).unwrap());
        wait_for(&camera, 3);
        assert_eq!(camera.live().unwrap().dropped, 0, "nobody follows yet");
        let mut seen = camera.gray_from(2).unwrap();
        let mut next = || {
            seen.next().unwrap().map(|Frame { number, seconds, gray, .. }| (number, gray.pixels[0], seconds.unwrap()))
        };
        // The tracker is locked in an older frame, so it gets every frame.
        assert_eq!((next().unwrap(), next().unwrap()), ((2, 2, 2.0), (3, 3, 3.0)));
        sender.send(Ok(frame(4))).unwrap();
        wait_for(&camera, 4);
        assert_eq!(next().unwrap(), (4, 4, 4.0));
        // The tracker has caught up now, or does so with the next frame.
        let late = thread::spawn(move || {
            thread::sleep(Duration::from_millis(50));
            sender.send(Ok(frame(5))).unwrap();
            sender
        });
        assert_eq!(next().unwrap(), (5, 5, 5.0));
        let sender = late.join().unwrap();
        (6..=9).for_each(|level| sender.send(Ok(frame(level))).unwrap());
        wait_for(&camera, 9);
        assert_eq!(next().unwrap(), (9, 9, 9.0));
        assert_eq!(camera.live().unwrap().dropped, 3);
        // The source itself has dropped two frames.
        sender.send(Ok(frame(12))).unwrap();
        wait_for(&camera, 12);
        assert_eq!((next().unwrap(), camera.live().unwrap().dropped), ((12, 12, 12.0), 5));
        let mut again =
            camera.gray_from(11).unwrap().map(|frame| frame.map(|frame| (frame.number, frame.gray.pixels[0])));
        assert_eq!([again.next().unwrap().unwrap(), again.next().unwrap().unwrap()], [(11, 9), (12, 12)]);
        drop(sender);
        assert_eq!(next().unwrap_err().to_string(), "the source has ended");
        assert!(seen.next().is_none() && camera.live().unwrap().has_ended);
        assert!(camera.image(12).is_some() && camera.image(13).is_none());
    }

    #[test]
    fn what_is_kept_is_bounded() {
        let (sender, frames) = channel::<Result<_>>();
        let camera = Camera::of(Box::new(frames.into_iter()));
        let mut kept = camera.0.kept();
        for number in 1..=20 {
            let gray = GrayFrame { width: 1 << 12, height: 1 << 11, pixels: vec![0; 1 << 23] };
            kept.gray.keep(number, ArrivedFrame { gray, seconds: None, arrived: Instant::now() });
            kept.images.keep(number, Arc::new(vec![0; 20 << 20]));
        }
        let all = (kept.gray.all().len(), kept.images.all().len());
        assert_eq!(all, (MAX_GRAY >> 23, MAX_IMAGES / (20 << 20)));
        drop(kept);
        let error = camera.gray_from(3).err().unwrap().to_string();
        assert_eq!(error, "trackers can go back to frame 13 only: lock in a newer frame");
        drop(sender);
    }
}
