//! The memory of a target from frame to frame (track, filter, early template, refiner), and its saved form.

use super::super::config::Config;
use super::super::constants::{CHANNELS, MAX_CELLS, MAX_PIXELS, PIXEL_BITS, WEIGHTS};
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

/// Bytes of a saved track.
const TRACK: usize = 62 + Calm::SAVED;
pub(crate) const SAVED_SIZE: usize =
    around(Config::COUNT) + TRACK + 4 * MAX_CELLS * CHANNELS + 2 * MAX_PIXELS + REFINED;
/// Bytes of the refiner's memory and of its doubt.
const REFINED: usize = refiner::SAVED + Doubt::SAVED;

pub(crate) struct Memory {
    /// The target's place and state; `None` before the first lock.
    pub(crate) track: Option<Track>,
    pub(crate) filter: Filter<WEIGHTS>,
    pub(crate) template: Template,
    /// The refiner's crop of the target in the first frame.
    pub(crate) first: First,
}

impl Memory {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { track: None, filter: Filter::new(), template: Template::new(), first: First::NONE }
    }

    pub(crate) fn saved_size(&self, config: &Config) -> Result<usize, SaveError> {
        let refiner = if config.refines() { REFINED } else { 0 };
        let size =
            around(Config::COUNT) + TRACK + 4 * self.filter.weights().len() + 2 * self.template.mean().len() + refiner;
        self.track.map(|_| size).ok_or(SaveError::NotLocked)
    }

    pub(crate) fn save(&self, config: &Config, bytes: &mut [u8]) -> Result<usize, SaveError> {
        let track = self.track.ok_or(SaveError::NotLocked)?;
        let mut to = Writer::new(bytes, self.saved_size(config)?, &Saved::of(config, &config.numbers()))?;
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

    /// Restores a target that [`Memory::save`] wrote. Changes nothing if it fails.
    #[inline(never)]
    pub(crate) fn restore(&mut self, config: &Config, bytes: &[u8]) -> Result<(), Refusal> {
        let mut from = reader(config, bytes)?;
        let mut track = read_track(&mut from).ok_or(RestoreError::Damaged)?;
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
        self.track = Some(track);
        Ok(())
    }
}

fn read_track(from: &mut Reader<'_>) -> Option<Track> {
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
        grid: Grid::new(target),
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

pub(crate) fn reader<'a>(config: &Config, bytes: &'a [u8]) -> Result<Reader<'a>, Refusal> {
    Reader::new(bytes, &Saved::of(config, &config.numbers()))
}
