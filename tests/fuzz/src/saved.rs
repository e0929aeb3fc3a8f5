//! Restores a saved target with changed bytes and a correct checksum. The tracker refuses it, or updates without panic.

use crate::extent::WIDE;
use crate::scene::{KINDS, Part, Scene, frame};
use crate::{Fuzzed, calls};
use arbitrary::{Result, Unstructured};
use smr_core::{Rect, Tracker};

const LENGTH: std::ops::Range<usize> = 10..14;

pub(crate) fn run<T: Fuzzed>(bytes: &[u8]) -> Result<()> {
    let u = &mut Unstructured::new(bytes);
    let mut tracker = Box::new(Tracker::<T>::with(T::usual()).expect("one that a tracker takes"));
    if u.ratio(1, 64)? {
        assert!(tracker.restore(bytes).is_err());
        return Ok(());
    }
    let (mut scene, mut saved) = u.choose(T::locked())?.clone();
    for _ in 0..u.int_in_range(0..=6_u8)? {
        change(u, &mut saved)?;
    }
    if u.ratio(15, 16)? {
        seal(&mut saved);
    }
    if tracker.restore(&saved).is_err() {
        return Ok(());
    }
    // Saving a restored target gives its bytes again. Restoring ignores any bytes after the target.
    let again = calls::saved(&tracker).expect("it is locked");
    assert!(saved.starts_with(&again), "what was restored is saved as other bytes");
    (scene.width, scene.height) = (number(&saved, T::SIZE_AT), number(&saved, T::SIZE_AT + 2));
    follow(&mut tracker, &mut scene, u)
}

fn number(saved: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([saved[at], saved[at + 1]])
}

pub(crate) fn locked<T: Fuzzed>() -> Vec<(Scene, Vec<u8>)> {
    locked_by::<T>(T::usual())
}

/// Saves targets locked with `config` in scenes of every kind.
pub(crate) fn locked_by<T: Fuzzed>(config: T::Config) -> Vec<(Scene, Vec<u8>)> {
    let mut tracker = Box::new(Tracker::<T>::with(config).expect("one that a tracker takes"));
    let saved = (0..KINDS).map(|kind| {
        let (scene, target) = (Scene::of(kind), Rect::new((2 * kind).into(), 5, 9 + u16::from(kind), 12));
        let part = scene.part(tracker.lock_window(scene.bounds(), target), 0).expect("it is small");
        tracker.lock(&frame(&scene, &part, None), target).expect("a box in the frame");
        (scene, calls::saved(&tracker).expect("it is locked"))
    });
    saved.collect()
}

/// Changes a few bytes, a number, or the length.
fn change(u: &mut Unstructured<'_>, saved: &mut Vec<u8>) -> Result<()> {
    // Changes mostly the configuration and the track, which come first.
    let end = if u.arbitrary()? { 100.min(saved.len()) } else { saved.len() };
    let at = u.choose_index(end.max(1))?;
    match u.int_in_range(0..=5_u8)? {
        0 => saved.truncate(at),
        1 => saved.extend_from_slice(u.bytes(u.len().min(at % 16))?),
        2 => put(saved, at, &u.arbitrary::<u16>()?.to_le_bytes()),
        3 => put(saved, at, &u.arbitrary::<i32>()?.to_le_bytes()),
        4 => put(saved, at, &u.choose(&[0, 1, -1, i64::MAX, i64::MIN, 1 << 31])?.to_le_bytes()),
        _ => put(saved, at, &[u.arbitrary::<u8>()?]),
    }
    Ok(())
}

fn put(saved: &mut [u8], at: usize, bytes: &[u8]) {
    saved.iter_mut().skip(at).zip(bytes).for_each(|(old, &new)| *old = new);
}

fn seal(saved: &mut [u8]) {
    let Some(end) = saved.len().checked_sub(4).filter(|&end| end >= LENGTH.end) else { return };
    let length = u32::try_from(saved.len()).expect("a few thousand");
    saved[LENGTH].copy_from_slice(&length.to_le_bytes());
    let sum = crc32fast::hash(&saved[..end]);
    saved[end..].copy_from_slice(&sum.to_le_bytes());
}

/// Updates the tracker with partial frames that contain only the requested windows.
fn follow<T: Fuzzed>(tracker: &mut Tracker<T>, scene: &mut Scene, u: &mut Unstructured<'_>) -> Result<()> {
    for _ in 0..u.int_in_range(1..=4 * WIDE.updates[T::PACE])? {
        let part = |rect: Option<Rect>| rect.and_then(|rect| scene.part(rect, 1));
        let first: Option<Part> = part(tracker.window()).or_else(|| scene.part(Rect::new(0, 0, 1, 1), 0));
        let Some(first) = first else { return Ok(()) };
        let second = part(tracker.sweep_window());
        let enough = tracker.window().is_none_or(|window| first.rect == window)
            && tracker.sweep_window().is_some() == second.is_some();
        let answer = tracker.update(&frame(scene, &first, second.as_ref()));
        assert!(!enough || answer.is_ok(), "what it asked for is in memory: {answer:?}");
        if answer.is_err() {
            return Ok(());
        }
        scene.change(u)?;
        if u.ratio(1, 4)? {
            tracker.moved(u.arbitrary()?, u.arbitrary()?);
        }
    }
    Ok(())
}
