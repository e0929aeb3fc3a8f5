//! Runs sequences of calls on a tracker. The tracker must not panic or read outside the windows that it requests. If a
//! second tracker, with plain kernels and updates in one call, runs too, both must give the same answers.

use crate::Fuzzed;
use crate::extent::Extent;
use crate::paper;
use crate::scene::{Part, Scene, frame};
use arbitrary::{Result, Unstructured};
use smr_core::{Answer, Frame, Image, LockError, Rect, RestoreError, Tracker, UpdateError};

struct Pair<T: Fuzzed> {
    /// The tracker under test: any kernels, updates in steps, partial frames.
    any: Box<Tracker<T>>,
    plain: Option<Box<Tracker<T>>>,
    scene: Scene,
    updates: u32,
    extent: &'static Extent,
}

pub(crate) fn run<T: Fuzzed>(bytes: &[u8], extent: &'static Extent) -> Result<()> {
    let u = &mut Unstructured::new(bytes);
    let Some(mut pair) = (if extent.from_saved && !T::starts().is_empty() && u.ratio(31, 32)? {
        Some(Pair::<T>::restored(u, extent)?)
    } else {
        Pair::<T>::locked(u, extent)?
    }) else {
        return Ok(());
    };
    let ran = pair.calls(u);
    // Compares what both trackers save, even if the calls ended early because the input did.
    pair.same_to_the_last_bit();
    ran
}

impl<T: Fuzzed> Pair<T> {
    fn locked(u: &mut Unstructured<'_>, extent: &'static Extent) -> Result<Option<Self>> {
        let config = T::configuration(u, extent)?;
        let Ok(any) = Tracker::<T>::with(config) else {
            assert!(Tracker::<T>::with(T::plain(config)).is_err());
            return Ok(None);
        };
        let mut pair = Self::new(any, T::beside(u)?, Scene::new(u, extent)?, extent);
        pair.lock(u)?;
        Ok(Some(pair))
    }

    fn restored(u: &mut Unstructured<'_>, extent: &'static Extent) -> Result<Self> {
        let start = u.choose(T::starts())?;
        let any = Tracker::<T>::with(T::by(start.config, paper::backend(u)?)).expect("it was one");
        let mut pair = Self::new(any, T::beside(u)?, start.scene.clone(), extent);
        for tracker in pair.plain.iter_mut().chain([&mut pair.any]) {
            assert_eq!(tracker.restore(&start.saved), Ok(()));
        }
        Ok(pair)
    }

    fn new(any: Tracker<T>, beside: bool, scene: Scene, extent: &'static Extent) -> Self {
        let plain = beside.then(|| Box::new(Tracker::with(T::plain(*any.config())).expect("the same numbers")));
        Self { any: Box::new(any), plain, scene, updates: 0, extent }
    }

    fn calls(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        for _ in 0..self.extent.calls {
            if u.is_empty() || self.updates == self.extent.updates[T::PACE] {
                break;
            }
            self.call(u)?;
        }
        Ok(())
    }

    /// Locks, but rarely if the tracker is slow to lock.
    fn lock_or_not(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        if self.is_slow_to_lock() && u.ratio(63, 64)? {
            return self.update(u);
        }
        self.lock(u)
    }

    fn call(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        match u.int_in_range(0..=15_u8)? {
            0 => self.lock_or_not(u),
            1 | 2 => self.turn(u),
            3 | 4 => self.save_and_restore(u),
            5 => self.other_size(u),
            6 => self.give_up(u),
            7 => self.scene.change(u),
            _ => {
                self.scene.change(u)?;
                self.update(u)
            }
        }
    }

    /// Returns a box to lock: mostly one inside the frame, or, if `lock` is slow, mostly one that `lock` refuses.
    fn target(&self, u: &mut Unstructured<'_>) -> Result<Rect> {
        let (Rect { width, height, .. }, most) = (self.scene.bounds(), self.extent.side);
        let any = |u: &mut Unstructured<'_>| -> Result<Rect> {
            Ok(Rect::new(u.arbitrary()?, u.arbitrary()?, u.arbitrary()?, u.arbitrary()?))
        };
        if self.is_slow_to_lock() {
            match u.int_in_range(0..=7_u8)? {
                0..=2 => return any(u),
                3 | 4 => return Ok(Rect::new(u.int_in_range(0..=9)?, 0, 0, u.int_in_range(0..=9)?)),
                5 => return Ok(self.scene.bounds()),
                _ => {}
            }
        } else if u.ratio(1, 16)? {
            return any(u);
        }
        let (w, h) = (u.int_in_range(1..=width.min(most))?, u.int_in_range(1..=height.min(most))?);
        Ok(Rect::new(u.int_in_range(0..=width - w)?.into(), u.int_in_range(0..=height - h)?.into(), w, h))
    }

    fn is_slow_to_lock(&self) -> bool {
        self.extent.from_saved && !T::starts().is_empty()
    }

    fn lock(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let target = self.target(u)?;
        self.same_to_the_last_bit();
        let window = self.any.lock_window(self.scene.bounds(), target);
        assert!(window.is_empty() || self.scene.bounds().contains(window), "lock window {window:?}");
        let Some(part) = self.scene.part(window, gap(u)?).or_else(|| self.corner()) else { return Ok(()) };
        let (before, frame) = (saved(&self.any), frame(&self.scene, &part, None));
        let locked = if u.arbitrary()? {
            self.any.lock(&frame, target)
        } else {
            loop {
                let step = if u.is_empty() { u32::MAX } else { u32::from(u.arbitrary::<u8>()?) << 16 };
                match self.any.lock_step(&frame, target, step) {
                    Ok(None) => {
                        assert_eq!((self.any.bbox(), self.any.window()), (None, None));
                        refuse(&mut self.any);
                    }
                    Ok(Some(quality)) => break Ok(quality),
                    Err(error) => break Err(error),
                }
            }
        };
        match locked {
            Ok(_) => assert_eq!(self.any.bbox(), Some(target.into())),
            // This error is right only if `part` is just the corner, because the lock window was too large to allocate.
            Err(LockError::LockWindowNotInMemory) => assert_ne!(part.rect, window),
            Err(_) => assert_eq!(before, saved(&self.any)),
        }
        if let Some(plain) = &mut self.plain {
            assert_eq!(plain.lock(&frame, target), locked);
        }
        self.same();
        Ok(())
    }

    /// Returns a part of one pixel, the smallest that a frame can have.
    fn corner(&self) -> Option<Part> {
        self.scene.part(Rect::new(0, 0, 1, 1), 0)
    }

    /// Allocates the windows of the next update; `None` if one is too large or the tracker is not locked.
    fn needed(&self, gap: usize) -> Option<(Part, Option<Part>)> {
        let window = self.any.window()?;
        let sweep = self.any.sweep_window();
        for wanted in [Some(window), sweep].into_iter().flatten() {
            assert!(self.scene.bounds().contains(wanted), "window {wanted:?}");
        }
        let first = self.scene.part(window, gap)?;
        let second = match sweep {
            Some(sweep) => Some(self.scene.part(sweep, gap)?),
            None => None,
        };
        Some((first, second))
    }

    fn update(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Some((first, second)) = self.needed(gap(u)?) else { return self.without_memory() };
        let whole = self.scene.part(self.scene.bounds(), gap(u)?);
        let least = frame(&self.scene, &first, second.as_ref());
        let shown = match &whole {
            Some(whole) if u.arbitrary()? => frame(&self.scene, whole, None),
            _ => least,
        };
        let mut answer = None;
        if u.arbitrary()? {
            answer = self.any.update(&shown).ok();
        }
        while answer.is_none() {
            let work = if u.is_empty() { u32::MAX } else { work(u)? };
            answer = self.any.update_step(&shown, work).expect("what it asked for is in memory");
            refuse(&mut self.any);
        }
        let answer = answer.expect("an update without an answer goes on");
        self.believe(&answer);
        if let Some(plain) = &mut self.plain {
            assert_eq!(plain.update(&least), Ok(answer));
        }
        self.updates += 1;
        self.same();
        Ok(())
    }

    fn believe(&self, answer: &Answer) {
        assert_eq!(self.any.bbox(), Some(answer.fine));
        assert_eq!(self.any.state(), Some(answer.state));
        assert_eq!(answer.fine.whole(), answer.bbox);
    }

    fn turn(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let (right, down) = if u.ratio(1, 8)? {
            (u.arbitrary()?, u.arbitrary()?)
        } else {
            (u.int_in_range(-9999..=9999)?, u.int_in_range(-9999..=9999)?)
        };
        self.any.moved(right, down);
        if let Some(plain) = &mut self.plain {
            plain.moved(right, down);
        }
        self.same();
        Ok(())
    }

    fn save_and_restore(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Some(mut bytes) = saved(&self.any) else { return Ok(()) };
        let mut short = vec![0; bytes.len() - 1];
        assert!(self.any.save(&mut short).is_err());
        let mut next = Tracker::<T>::with(*self.any.config()).expect("it was one");
        assert_eq!(next.restore(&bytes), Ok(()));
        assert_eq!((next.window(), next.bbox(), next.state()), (self.any.window(), self.any.bbox(), self.any.state()));
        *self.any = next;
        self.same();
        // Restoring must detect every change of a single bit.
        let at = u.choose_index(bytes.len())?;
        bytes[at] ^= 1 << u.int_in_range(0..=7_u8)?;
        assert!(self.any.restore(&bytes).is_err());
        self.same();
        Ok(())
    }

    /// Calls the tracker with a frame of another size, and with one that lacks the needed pixels.
    fn other_size(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let (width, height) = (self.scene.width, self.scene.height);
        self.scene.width = mostly_other(u, width)?;
        let before = saved(&self.any);
        if let Some(part) = self.corner() {
            let frame = frame(&self.scene, &part, None);
            let refused = self.any.update(&frame);
            let changed = self.scene.width != width;
            if before.is_none() {
                assert_eq!(refused, Err(UpdateError::NotLocked));
            } else if changed {
                assert_eq!(refused, Err(UpdateError::FrameSizeChanged));
            } else if let (Ok(_), Some(plain)) = (refused, &mut self.plain) {
                assert_eq!(plain.update(&frame), refused);
            }
            if refused.is_err() {
                assert_eq!(before, saved(&self.any));
            }
        }
        (self.scene.width, self.scene.height) = (width, height);
        self.same();
        Ok(())
    }

    fn without_memory(&mut self) -> Result<()> {
        let Some(part) = self.corner() else { return Ok(()) };
        assert!(self.any.update(&frame(&self.scene, &part, None)).is_err());
        Ok(())
    }

    /// Runs the first step of an update, then turns the camera.
    fn give_up(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Some((first, second)) = self.needed(gap(u)?) else { return Ok(()) };
        let shown = frame(&self.scene, &first, second.as_ref());
        let before = saved(&self.any);
        match self.any.update_step(&shown, work(u)?).expect("what it asked for is in memory") {
            None => assert_eq!(before, saved(&self.any), "an update changes nothing before it is finished"),
            Some(answer) => {
                if let Some(plain) = &mut self.plain {
                    assert_eq!(plain.update(&shown), Ok(answer));
                }
            }
        }
        // The turn gives up the update if it is unfinished.
        self.turn(u)
    }

    /// Checks that both trackers request the same windows and, if `each_call` is set, save the same bytes.
    fn same(&self) {
        if let Some(plain) = &self.plain {
            assert_eq!(self.any.window(), plain.window());
            assert_eq!(self.any.sweep_window(), plain.sweep_window());
            assert_eq!((self.any.bbox(), self.any.state()), (plain.bbox(), plain.state()));
        }
        if self.extent.each_call {
            self.same_to_the_last_bit();
        }
    }

    fn same_to_the_last_bit(&self) {
        if let Some(plain) = &self.plain {
            assert!(saved(&self.any) == saved(plain), "different templates or tracks");
        }
    }
}

/// Makes calls that a tracker in any state refuses. What is under way continues.
fn refuse<T: Fuzzed>(tracker: &mut Tracker<T>) {
    let (work, frame) = (tracker.work(), Frame::whole(Image::new(&[7], 1, 1).expect("one pixel")));
    if tracker.window().is_none_or(|window| window.right() > 1 || window.bottom() > 1) {
        assert!(tracker.update(&frame).is_err());
        assert!(tracker.update_step(&frame, 1).is_err());
    }
    assert_eq!(tracker.lock(&frame, Rect::default()), Err(LockError::BoxEmpty));
    assert_eq!(tracker.lock_step(&frame, Rect::new(1, 0, 1, 1), 1), Err(LockError::BoxOutsideFrame));
    assert_eq!(tracker.restore(b"SMRx"), Err(RestoreError::Truncated));
    assert_eq!(tracker.work(), work);
}

pub(crate) fn saved<T: Fuzzed>(tracker: &Tracker<T>) -> Option<Vec<u8>> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = tracker.save(&mut bytes).ok()?;
    bytes.truncate(length);
    Some(bytes)
}

fn gap(u: &mut Unstructured<'_>) -> Result<usize> {
    u.int_in_range(0..=7_usize)
}

/// Returns the work that a step is granted, from none to more than an update needs.
fn work(u: &mut Unstructured<'_>) -> Result<u32> {
    Ok(u32::from(u.arbitrary::<u8>()?) << u.int_in_range(0..=24_u8)?)
}

fn mostly_other(u: &mut Unstructured<'_>, width: u16) -> Result<u16> {
    if u.ratio(1, 4)? { Ok(width) } else { u.int_in_range(1..=u16::MAX) }
}
