//! The memory of a target from frame to frame (track, filter, early template, refiner), and its saved form.

use super::super::config::Config;
use super::super::constants::{Limits, PIXEL_BITS};
use super::super::features::{Grid, Motion, Place};
use super::super::filter::{Filter, scale};
use super::super::refiner::{self, First, Review};
use super::super::verification::{Light, Template};
use super::calm::Calm;
use super::confidence::Confidence;
use super::giving_up::Doubt;
use super::redetection::Sweep;
use super::track::Track;
use crate::image::Rect;
use crate::track::saved::{Reader, Refusal, Saved, Writer, around};
use crate::track::settings::Numbers;
use crate::track::{Quality, RestoreError, SaveError};
use heapless::Vec;

/// Bytes of a saved track.
const TRACK: usize = 62 + Calm::SAVED;
/// Bytes of the refiner's memory and of its doubt.
const REFINED: usize = refiner::SAVED + Doubt::SAVED;

/// The largest size of a saved target, in bytes.
pub(crate) const fn most_saved(limits: Limits) -> usize {
    around(Config::COUNT) + TRACK + 4 * limits.weights() + 2 * limits.pixels as usize + REFINED
}

/// The learned part of a target: it grows with the size.
pub(crate) struct Learned<const WEIGHTS: usize, const PIXELS: usize> {
    filter: Filter<Vec<i32, WEIGHTS>>,
    template: Template<Vec<u16, PIXELS>>,
}

impl<const WEIGHTS: usize, const PIXELS: usize> Learned<WEIGHTS, PIXELS> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { filter: Filter::new(), template: Template::new() }
    }

    pub(crate) fn parts(&self) -> (&Filter, &Template) {
        (&self.filter, &self.template)
    }

    pub(crate) fn parts_mut(&mut self) -> (&mut Filter, &mut Template) {
        (&mut self.filter, &mut self.template)
    }
}

/// The memory of a target of any size.
#[derive(Clone, Copy)]
pub(crate) struct Memory<'a> {
    pub(crate) limits: Limits,
    /// The target's place and state; `None` before the first lock.
    pub(crate) track: Option<&'a Track>,
    pub(crate) filter: &'a Filter,
    pub(crate) template: &'a Template,
    /// The refiner's crop of the target in the first frame.
    pub(crate) first: &'a First,
}

/// As [`Memory`], for a call that changes it.
pub(crate) struct MemoryMut<'a> {
    pub(crate) limits: Limits,
    pub(crate) track: &'a mut Option<Track>,
    pub(crate) filter: &'a mut Filter,
    pub(crate) template: &'a mut Template,
    pub(crate) first: &'a mut First,
}

impl Memory<'_> {
    #[inline(never)]
    pub(crate) fn saved_size(&self, config: &Config) -> Result<usize, SaveError> {
        let refiner = if config.refines() { REFINED } else { 0 };
        let size =
            around(Config::COUNT) + TRACK + 4 * self.filter.weights().len() + 2 * self.template.mean().len() + refiner;
        self.track.map(|_| size).ok_or(SaveError::NotLocked)
    }

    #[inline(never)]
    pub(crate) fn save(&self, config: &Config, bytes: &mut [u8]) -> Result<usize, SaveError> {
        let track = self.track.ok_or(SaveError::NotLocked)?;
        let mut to =
            Writer::new(bytes, self.saved_size(config)?, &Saved::of(self.limits.kind, config, &config.numbers()))?;
        for side in [track.bounds.width, track.bounds.height].into_iter().chain(track.size) {
            to.u16(side);
        }
        let Motion { place: Place { x, y, scale }, velocity: [right, down] } = track.motion;
        for place in [x, y, right, down] {
            to.i64(place);
        }
        to.u32(scale);
        to.u32(track.tracked_scale);
        to.i32(track.confidence.mean());
        to.u32(track.sweep.next);
        to.u16(track.quality.value());
        to.u32(track.light.number());
        track.calm.save(&mut to);
        self.filter.weights().iter().for_each(|&weight| to.i32(weight));
        self.template.mean().iter().for_each(|&pixel| to.u16(pixel));
        if config.refines() {
            track.review.save(&mut to);
            track.doubt.save(&mut to);
            self.first.save(&mut to);
        }
        Ok(to.finish())
    }
}

impl MemoryMut<'_> {
    pub(crate) fn shared(&self) -> Memory<'_> {
        let Self { limits, track, filter, template, first } = self;
        Memory { limits: *limits, track: track.as_ref(), filter, template, first }
    }

    /// Restores a target that [`Memory::save`] wrote. Changes nothing if it fails.
    #[inline(never)]
    pub(crate) fn restore(&mut self, config: &Config, bytes: &[u8]) -> Result<(), Refusal> {
        let mut from = reader(self.limits, config, bytes)?;
        let mut track = read_track(self.limits, &mut from).ok_or(RestoreError::Damaged)?;
        let count = track.grid.weights();
        let pixels = usize::from(track.grid.columns) * usize::from(track.grid.rows);
        let weights = from.slice(4 * count).ok_or(RestoreError::Damaged)?;
        let mean = from.slice(2 * pixels).ok_or(RestoreError::Damaged)?;
        if config.refines() {
            track.review = Review::read(&mut from).ok_or(RestoreError::Damaged)?;
            track.doubt = Doubt::read(&mut from).ok_or(RestoreError::Damaged)?;
            self.first.restore(&mut from).ok_or(RestoreError::Damaged)?; // nothing below can fail
        } else if !from.is_empty() {
            return Err(RestoreError::Damaged.into());
        }
        self.filter.restore(count, weights.as_chunks().0.iter().map(|&bytes| i32::from_le_bytes(bytes)));
        self.template.restore(mean.as_chunks().0.iter().map(|&bytes| u16::from_le_bytes(bytes)));
        *self.track = Some(track);
        Ok(())
    }
}

fn read_track(limits: Limits, from: &mut Reader<'_>) -> Option<Track> {
    let bounds = Rect::new(0, 0, from.u16()?, from.u16()?);
    let target = Rect::new(0, 0, from.u16()?, from.u16()?);
    let (x, y, right, down) = (from.i64()?, from.i64()?, from.i64()?, from.i64()?);
    let (scale, tracked_scale) = (from.u32()?, from.u32()?);
    let confidence = Confidence::restore(from.i32()?)?;
    let sweep = Sweep { next: from.u32()? };
    let quality = Quality::of_value(from.u16()?);
    let light = Light::restore(from.u32()?)?;
    let calm = Calm::read(from)?;
    let place = Place { x, y, scale };
    let farthest = i64::from(u16::MAX) << PIXEL_BITS;
    let possible = bounds.contains(target)
        && place.inside(bounds) == place
        && [right, down].iter().all(|by| (-farthest..=farthest).contains(by))
        && [scale, tracked_scale].into_iter().all(scale::is_possible);
    possible.then(|| Track {
        bounds,
        grid: Grid::within(limits, target),
        size: [target.width, target.height],
        motion: Motion { place, velocity: [right, down] },
        tracked_scale,
        confidence,
        sweep,
        quality,
        review: Review::NONE,
        doubt: Doubt::NONE,
        light,
        calm,
    })
}

pub(crate) fn reader<'a>(limits: Limits, config: &Config, bytes: &'a [u8]) -> Result<Reader<'a>, Refusal> {
    Reader::new(bytes, &Saved::of(limits.kind, config, &config.numbers()))
}
