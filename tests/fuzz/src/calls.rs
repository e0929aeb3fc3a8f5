//! Sequences of calls of a tracker: no panic, what is asked for is enough, and the same answers as from a tracker that is called in
//! the plainest way.

use crate::Fuzzed;
use crate::scene::{Part, Scene, frame};
use arbitrary::{Result, Unstructured};
use smr_core::{Answer, LockError, Rect, Tracker, UpdateError};

/// The most calls of one input.
const CALLS: u32 = 40;

struct Pair<T: Fuzzed> {
    /// Any backend, any cut, any part of the frame.
    any: Box<Tracker<T>>,
    /// The plain loops, whole updates.
    plain: Option<Box<Tracker<T>>>,
    scene: Scene,
    updates: u32,
}

pub(crate) fn run<T: Fuzzed>(bytes: &[u8]) -> Result<()> {
    let u = &mut Unstructured::new(bytes);
    let config = T::configuration(u)?;
    let Ok(any) = Tracker::<T>::new(config) else {
        assert!(Tracker::<T>::new(T::plain(config)).is_err());
        return Ok(());
    };
    let plain = T::beside(u)?.then(|| Box::new(Tracker::new(T::plain(config)).expect("the same numbers")));
    let mut pair = Pair { any: Box::new(any), plain, scene: Scene::new(u)?, updates: 0 };
    pair.lock(u)?;
    for _ in 0..CALLS {
        if u.is_empty() || pair.updates == T::UPDATES {
            break;
        }
        pair.call(u)?;
    }
    Ok(())
}

impl<T: Fuzzed> Pair<T> {
    fn call(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        match u.int_in_range(0..=15_u8)? {
            0 => self.lock(u),
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

    /// Any box, mostly one of a size that has room.
    fn lock(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Rect { width, height, .. } = self.scene.bounds();
        let target = if u.ratio(1, 16)? {
            Rect::new(u.arbitrary()?, u.arbitrary()?, u.arbitrary()?, u.arbitrary()?)
        } else {
            let (w, h) = (u.int_in_range(1..=width.min(20))?, u.int_in_range(1..=height.min(20))?);
            Rect::new(u.int_in_range(0..=width - w)?.into(), u.int_in_range(0..=height - h)?.into(), w, h)
        };
        let window = self.any.lock_window(self.scene.bounds(), target);
        assert!(window.is_empty() || self.scene.bounds().contains(window), "lock window {window:?}");
        let Some(part) = self.scene.part(window, gap(u)?).or_else(|| self.corner()) else { return Ok(()) };
        let (before, frame) = (saved(&self.any), frame(&self.scene, &part, None));
        let locked = self.any.lock(&frame, target);
        match locked {
            Ok(()) => assert_eq!(self.any.bbox(), Some(target.into())),
            // What was asked for was given, or was too large to be.
            Err(LockError::LockWindowNotInMemory) => assert_ne!(part.rect, window),
            Err(_) => assert_eq!(before, saved(&self.any)),
        }
        if let Some(plain) = &mut self.plain {
            assert_eq!(plain.lock(&frame, target), locked);
        }
        self.same();
        Ok(())
    }

    /// A pixel to have a frame at all.
    fn corner(&self) -> Option<Part> {
        self.scene.part(Rect::new(0, 0, 1, 1), 0)
    }

    /// What the next update asks for, put into memory; `None` if it is too large.
    fn needed(&self, gap: usize) -> Option<(Part, Option<Part>)> {
        let window = self.any.window()?;
        let sweep = self.any.sweep_window();
        for wanted in [Some(window), sweep].into_iter().flatten() {
            assert!(wanted.is_empty() || self.scene.bounds().contains(wanted), "window {wanted:?}");
        }
        // A window on the padding alone reads nothing.
        let first = if window.is_empty() { self.corner() } else { self.scene.part(window, gap) }?;
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
        let answer = match u.int_in_range(0..=2_u8)? {
            0 => self.any.update(&shown),
            1 => {
                let mut update = self.any.begin(&shown).expect("what it asked for is in memory");
                while !update.step(work(u)?) && !u.is_empty() {}
                Ok(update.finish())
            }
            _ => {
                let _ = self.any.begin(&shown).expect("what it asked for is in memory");
                while !self.any.resume(&shown).expect("it was begun").step(work(u)?) && !u.is_empty() {}
                self.any.resume(&shown).map(smr_core::Update::finish)
            }
        };
        let answer = answer.expect("what it asked for is in memory");
        self.believe(&answer);
        over(self.any.resume(&shown).err());
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

    /// The camera turns.
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

    /// Goes on in a new tracker.
    fn save_and_restore(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Some(mut bytes) = saved(&self.any) else { return Ok(()) };
        let mut short = vec![0; bytes.len() - 1];
        assert!(self.any.save(&mut short).is_err());
        let mut next = Tracker::<T>::new(*self.any.config()).expect("it was one");
        assert_eq!(next.restore(&bytes), Ok(()));
        assert_eq!((next.window(), next.bbox(), next.state()), (self.any.window(), self.any.bbox(), self.any.state()));
        *self.any = next;
        self.same();
        // No single bit may change unnoticed.
        let at = u.choose_index(bytes.len())?;
        bytes[at] ^= 1 << u.int_in_range(0..=7_u8)?;
        assert!(self.any.restore(&bytes).is_err());
        self.same();
        Ok(())
    }

    /// A frame of another size, and one without what is needed.
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

    /// An update that is begun and then forgotten, or made impossible.
    fn give_up(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let Some((first, second)) = self.needed(gap(u)?) else { return Ok(()) };
        let shown = frame(&self.scene, &first, second.as_ref());
        self.any.begin(&shown).expect("what it asked for is in memory").step(work(u)?);
        let before = saved(&self.any);
        if u.arbitrary()? {
            self.turn(u)?;
            over(self.any.resume(&shown).err());
        } else {
            assert_eq!(before, saved(&self.any), "an update changes nothing before it is finished");
        }
        Ok(())
    }

    /// Both remember the same, to the last bit.
    fn same(&self) {
        if let Some(plain) = &self.plain {
            assert_eq!(self.any.window(), plain.window());
            assert_eq!(self.any.sweep_window(), plain.sweep_window());
            assert!(saved(&self.any) == saved(plain), "different templates or tracks");
        }
    }
}

pub(crate) fn saved<T: Fuzzed>(tracker: &Tracker<T>) -> Option<Vec<u8>> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = tracker.save(&mut bytes).ok()?;
    bytes.truncate(length);
    Some(bytes)
}

/// There is no update to be taken up; the window has moved on, too.
fn over(resumed: Option<UpdateError>) {
    assert!(matches!(resumed, Some(UpdateError::NotBegun | UpdateError::WindowNotInMemory)), "{resumed:?}");
}

fn gap(u: &mut Unstructured<'_>) -> Result<usize> {
    u.int_in_range(0..=7_usize)
}

/// From nothing at all to everything.
fn work(u: &mut Unstructured<'_>) -> Result<u32> {
    Ok(u32::from(u.arbitrary::<u8>()?) << u.int_in_range(0..=24_u8)?)
}

fn mostly_other(u: &mut Unstructured<'_>, width: u16) -> Result<u16> {
    if u.ratio(1, 4)? { Ok(width) } else { u.int_in_range(1..=u16::MAX) }
}
