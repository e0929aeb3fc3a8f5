//! Targets and frames up to 65,535x65,535 pixels: no panic, no overflow, and at most the work of `most_work`.
//!
//! A frame needs 4 GiB of address space, but little memory: nearly all of its pixels are black and never written.

use arbitrary::{Result, Unstructured};
use smr_core::{Frame, Image, Rect, Target, Tracker, robust::Config};
use std::sync::{LazyLock, Mutex, PoisonError};

const MAX_PIXELS: usize = u16::MAX as usize * u16::MAX as usize;

/// Pixels of the frame, all zero between inputs. An input changes at most 32 pixels and sets them to zero at its end.
static MEMORY: LazyLock<Mutex<Vec<u8>>> = LazyLock::new(|| Mutex::new(vec![0; MAX_PIXELS]));

pub(crate) fn run<T: Target<Config = Config>>(bytes: &[u8]) -> Result<()> {
    let u = &mut Unstructured::new(bytes);
    let (width, height) = (side(u, u16::MAX)?, side(u, u16::MAX)?);
    let pixels = usize::from(width) * usize::from(height);
    let mut memory = MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
    let mut dots = Vec::new();
    for _ in 0..u.int_in_range(0..=32_u8)? {
        dots.push((u.choose_index(pixels)?, u.arbitrary()?));
    }
    dots.iter().for_each(|&(at, pixel)| memory[at] = pixel);
    let ran = follow::<T>(u, &Frame::whole(Image::new(&memory[..pixels], width, height).expect("as many as it says")));
    dots.iter().for_each(|&(at, _)| memory[at] = 0);
    ran
}

fn side(u: &mut Unstructured<'_>, most: u16) -> Result<u16> {
    let places = u.int_in_range(0..=most.ilog2())?;
    u.int_in_range(1..=most.min(u16::MAX >> (15 - places)))
}

fn follow<T: Target<Config = Config>>(u: &mut Unstructured<'_>, frame: &Frame<'_>) -> Result<()> {
    let mut config = Config::refined();
    (config.reach, config.size, config.sweep) = (u.int_in_range(4..=8)?, u.arbitrary()?, u.int_in_range(0..=8)?);
    config.reach = config.reach.min(T::UNLOCKED.config().reach);
    let bounds = frame.bounds();
    let (width, height) = (side(u, bounds.width)?, side(u, bounds.height)?);
    let (x, y) = (u.int_in_range(0..=bounds.width - width)?, u.int_in_range(0..=bounds.height - height)?);
    let most = T::most_work(&config, width, height);
    let mut tracker = Box::new(Tracker::<T>::with(config).expect("one that a tracker takes"));
    tracker.lock(frame, Rect::new(x.into(), y.into(), width, height)).expect("a box in the frame");
    assert!(u64::from(tracker.work()) <= most.lock, "{} of {most:?}", tracker.work());
    for _ in 0..u.int_in_range(1..=4_u8)? {
        tracker.moved(u.arbitrary()?, u.arbitrary()?);
        let mut before = 0;
        let answer = loop {
            if let Some(answer) = tracker.update_step(frame, 1).expect("all of it is in memory") {
                break answer;
            }
            assert!(tracker.work() - before <= most.beyond_a_step, "{} of {most:?}", tracker.work() - before);
            before = tracker.work();
        };
        assert!(u64::from(tracker.work()) <= most.update, "{} of {most:?}", tracker.work());
        assert_eq!(answer.fine.whole(), answer.bbox);
        let [window, sweep] = [tracker.window(), tracker.sweep_window()];
        assert!(window.into_iter().chain(sweep).all(|window| bounds.contains(window)), "{window:?} {sweep:?}");
    }
    assert!(tracker.saved_size().expect("it is locked") <= T::SAVED_SIZE);
    Ok(())
}
