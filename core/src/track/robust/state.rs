//! The memory of a target from frame to frame, and its saved form.

use super::confidence::Confidence;
use super::config::{Config, Parts};
#[cfg(feature = "refiner")]
use super::constants::MARGIN;
use super::constants::{CELL, CHANNELS, MOST_CELLS, MOST_PIXELS, PIXEL, PIXEL_BITS, SCALE, WEIGHTS};
use super::grid::Grid;
use super::motion::{Motion, Place};
use super::redetection::Sweep;
#[cfg(feature = "refiner")]
use super::refiner::{Correction, FIRST, reachable};
use super::sampling::Lattice;
use super::scale;
use super::template::Template;
use crate::correlation::Filter;
use crate::image::{FineRect, Rect};
use crate::track::saved::{Kind, Reader, Setting, Settings, Writer, around};
use crate::track::update::Owner;
use crate::track::{Quality, RestoreError, SaveError};
#[cfg(feature = "refiner")]
use heapless::Vec;

/// Everything that the tracker remembers of a target.
pub(super) struct Memory {
    /// `None` before the first lock.
    pub(super) track: Option<Track>,
    pub(super) filter: Filter<WEIGHTS>,
    pub(super) template: Template,
    /// The first frame's target, as the refiner sees it.
    #[cfg(feature = "refiner")]
    pub(super) first: Vec<i8, FIRST>,
}

impl Memory {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self {
            track: None,
            filter: Filter::new(),
            template: Template::new(),
            #[cfg(feature = "refiner")]
            first: Vec::new(),
        }
    }
}

/// The track of a target: place, velocity, scale, confidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Track {
    pub(super) bounds: Rect,
    pub(super) grid: Grid,
    /// The size of the locked box.
    pub(super) size: [u16; 2],
    pub(super) motion: Motion,
    /// The scale when the state was last tracking.
    pub(super) tracked_scale: u32,
    pub(super) confidence: Confidence,
    pub(super) sweep: Sweep,
    pub(super) quality: Quality,
    #[cfg(feature = "refiner")]
    pub(super) correction: Correction,
}

impl Track {
    pub(super) fn new(bounds: Rect, target: Rect) -> Self {
        Self {
            bounds,
            grid: Grid::new(target),
            size: [target.width, target.height],
            motion: Motion::at(Place::of(target)),
            tracked_scale: SCALE,
            confidence: Confidence::FULL,
            sweep: Sweep::new(),
            quality: Quality::NONE,
            #[cfg(feature = "refiner")]
            correction: Correction::NONE,
        }
    }

    /// Adds all numbers but the grid, which follows from the size.
    fn identify(&self, owner: &mut Owner) {
        let Self { bounds, grid: _, size: [width, height], motion, tracked_scale, .. } = *self;
        owner.add_rect(bounds);
        owner.add(u32::from(width) << 16 | u32::from(height));
        let Motion { place: Place { x, y, scale }, velocity: [right, down] } = motion;
        [x, y, right, down].into_iter().for_each(|place| owner.add_long(place));
        let mean = self.confidence.mean().cast_unsigned();
        let rest = [scale, tracked_scale, mean, self.sweep.next, self.quality.value().into()];
        rest.into_iter().for_each(|number| owner.add(number));
        #[cfg(feature = "refiner")]
        {
            let Correction { centre, sides } = self.correction;
            centre.into_iter().chain(sides).for_each(|number| owner.add(number.cast_unsigned()));
        }
    }

    /// The expected place of the target in the next frame.
    pub(super) fn expected(&self, config: &Config) -> Place {
        self.motion.expected(config.parts.velocity, self.bounds)
    }

    /// The middle of the next window of redetection, at the scale when the state was last tracking.
    #[inline(never)]
    pub(super) fn swept(&self, reach: u16) -> Place {
        let side = i64::from(2 * reach * CELL) * self.grid.step_at(self.tracked_scale);
        let (x, y) = self.sweep.middle(u32::try_from(side).unwrap_or(u32::MAX), self.bounds);
        Place { x, y, scale: self.tracked_scale }
    }

    /// The pixels of the frame that the search window around a place reads.
    pub(super) fn pixels(&self, place: Place, reach: u16) -> Rect {
        Lattice::search_window(place, &self.grid, reach).pixels(self.bounds)
    }

    /// The box of the answer: the followed box, corrected by the refiner.
    #[inline(never)]
    pub(super) fn bbox(&self) -> FineRect {
        #[cfg(feature = "refiner")]
        return self.correction.correct(self.followed());
        #[cfg(not(feature = "refiner"))]
        self.followed()
    }

    /// The pixels that the refiner may read if the target is found anywhere in the search window around `centre`.
    /// Beyond the reach, the peak may lie between two cells, the template may be aligned off the middle by `MARGIN`, refinement moves by
    /// up to a pixel, and the scale may grow by a step.
    #[cfg(feature = "refiner")]
    pub(super) fn refined_pixels(&self, centre: Place, reach: u16) -> Rect {
        let [_, larger] = scale::other_scales(centre.scale);
        let pixels = (reach + 1) * CELL + MARGIN + 2;
        let by = i64::from(pixels) * self.grid.step_at(larger);
        let target = Self { motion: Motion::at(Place { scale: larger, ..centre }), ..*self };
        reachable(target.bbox(), by, self.bounds)
    }

    /// The box of the followed place and scale, without the refiner's correction.
    pub(super) fn followed(&self) -> FineRect {
        let Place { x, y, scale } = self.motion.place;
        let size = |size: u16| u32::try_from((u64::from(size) * u64::from(scale) + (1 << 7)) >> 8).unwrap_or(u32::MAX);
        let [width, height] = self.size.map(size);
        let corner = |middle: i64, size: u32| {
            let corner = ((middle + PIXEL / 2) >> 4) - i64::from(size / 2);
            i32::try_from(corner).unwrap_or(0)
        };
        FineRect { x: corner(x, width), y: corner(y, height), width, height }
    }
}

impl Memory {
    /// Adds all numbers that the rest of an update or of a lock under way depends on: those that [`Memory::save`]
    /// writes.
    pub(super) fn identify(&self, owner: &mut Owner) {
        if let Some(track) = &self.track {
            track.identify(owner);
        }
        self.filter.weights().iter().for_each(|&weight| owner.add(weight.cast_unsigned()));
        if self.track.is_none() {
            return;
        }
        let (pairs, odd) = self.template.mean().as_chunks();
        pairs.iter().for_each(|&[first, second]| owner.add(u32::from(first) << 16 | u32::from(second)));
        odd.iter().for_each(|&pixel| owner.add(pixel.into()));
        #[cfg(feature = "refiner")]
        self.first
            .as_chunks()
            .0
            .iter()
            .for_each(|&inputs| owner.add(u32::from_le_bytes(inputs.map(i8::cast_unsigned))));
    }
}

/// The numbers of the configuration without the table.
const NUMBERS: usize = 13;
/// Bytes of a saved track.
const TRACK: usize = 58;
/// Bytes of the refiner's memory: the correction and the first frame's target.
#[cfg(feature = "refiner")]
const REFINER: usize = 16 + FIRST;
#[cfg(not(feature = "refiner"))]
const REFINER: usize = 0;
/// The most bytes of a saved target.
pub(super) const SAVED_SIZE: usize = around(NUMBERS) + TRACK + 4 * MOST_CELLS * CHANNELS + 2 * MOST_PIXELS + REFINER;

impl Memory {
    /// Bytes of the saved form.
    pub(super) fn saved_size(&self, config: &Config) -> Result<usize, SaveError> {
        let refiner = if config.refiner { REFINER } else { 0 };
        let size = around(NUMBERS) + TRACK + 4 * self.filter.weights().len() + 2 * self.template.mean().len() + refiner;
        self.track.map(|_| size).ok_or(SaveError::NotLocked)
    }

    pub(super) fn save(&self, config: &Config, bytes: &mut [u8]) -> Result<usize, SaveError> {
        let track = self.track.ok_or(SaveError::NotLocked)?;
        let mut to = Writer::new(
            bytes,
            self.saved_size(config)?,
            Kind::Robust,
            &Settings { table: config.table, numbers: &numbers(config) },
        )?;
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
        self.filter.weights().iter().for_each(|&weight| to.i32(weight));
        self.template.mean().iter().for_each(|&pixel| to.u16(pixel));
        #[cfg(feature = "refiner")]
        if config.refiner {
            let Correction { centre, sides } = track.correction;
            centre.into_iter().chain(sides).for_each(|number| to.i32(number));
            self.first.iter().for_each(|input| to.put(&input.to_le_bytes()));
        }
        Ok(to.finish())
    }

    /// Restores what [`Memory::save`] wrote. If it fails, it changes nothing.
    pub(super) fn restore(&mut self, config: &Config, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut from = reader(config, bytes)?;
        #[cfg_attr(not(feature = "refiner"), allow(unused_mut))]
        let mut track = read_track(&mut from).ok_or(RestoreError::Damaged)?;
        let count = track.grid.weights();
        let pixels = usize::from(track.grid.columns) * usize::from(track.grid.rows);
        let weights = from.slice(4 * count).ok_or(RestoreError::Damaged)?;
        let mean = from.slice(2 * pixels).ok_or(RestoreError::Damaged)?;
        #[cfg(feature = "refiner")]
        let first = if config.refiner {
            track.correction = read_correction(&mut from).ok_or(RestoreError::Damaged)?;
            Some(from.slice(FIRST).ok_or(RestoreError::Damaged)?)
        } else {
            None
        };
        if !from.is_empty() {
            return Err(RestoreError::Damaged);
        }
        #[cfg(feature = "refiner")]
        if let Some(first) = first {
            if first.iter().any(|&input| input > 127) {
                return Err(RestoreError::Damaged);
            }
            self.first.clear();
            // Cannot fail: there is room for all.
            let _ = self.first.resize_default(FIRST);
            self.first.iter_mut().zip(first).for_each(|(to, input)| *to = input.cast_signed());
        }
        self.filter.restore(count, weights.as_chunks().0.iter().map(|&bytes| i32::from_le_bytes(bytes)));
        self.template.restore(mean.as_chunks().0.iter().map(|&bytes| u16::from_le_bytes(bytes)));
        self.track = Some(track);
        Ok(())
    }
}

/// Reads a saved track; `None` if a number is out of range.
fn read_track(from: &mut Reader<'_>) -> Option<Track> {
    let bounds = Rect::new(0, 0, from.u16()?, from.u16()?);
    let target = Rect::new(0, 0, from.u16()?, from.u16()?);
    let (x, y, right, down) = (from.i64()?, from.i64()?, from.i64()?, from.i64()?);
    let (scale, tracked_scale) = (from.u32()?, from.u32()?);
    let confidence = Confidence::restore(from.i32()?)?;
    let sweep = Sweep { next: from.u32()? };
    let quality = Quality::of_value(from.u16()?);
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
        #[cfg(feature = "refiner")]
        correction: Correction::NONE,
    })
}

#[cfg(feature = "refiner")]
fn read_correction(from: &mut Reader<'_>) -> Option<Correction> {
    Correction::restore([from.i32()?, from.i32()?], [from.i32()?, from.i32()?])
}

/// A reader of the state, if the configuration is the one that the target was saved with.
pub(super) fn reader<'a>(config: &Config, bytes: &'a [u8]) -> Result<Reader<'a>, RestoreError> {
    Reader::new(bytes, Kind::Robust, &Settings { table: config.table, numbers: &numbers(config) })
}

/// The settings that answers depend on, without the table; the backend is none of them. The refiner comes last, because
/// a flight record holds it only if it is on.
#[inline(never)]
pub(in crate::track) fn numbers(config: &Config) -> [(Setting, u16); NUMBERS] {
    let Parts { velocity, distance_penalty, verification, gated_learning } = config.parts;
    [
        (Setting::Size, config.size as u16),
        (Setting::Sweep, config.sweep as u16),
        (Setting::Parts, velocity as u16),
        (Setting::Parts, distance_penalty as u16),
        (Setting::Parts, verification as u16),
        (Setting::Parts, gated_learning as u16),
        (Setting::Reach, config.reach as u16),
        (Setting::Patience, config.patience as u16),
        (Setting::LostBelow, config.lost_below),
        (Setting::UncertainBelow, config.uncertain_below),
        (Setting::LearningRate, config.learning_rate),
        (Setting::EarlyRate, config.early_rate),
        (Setting::Refiner, config.refiner as u16),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_grows_around_its_middle() {
        let mut track = Track::new(Rect::new(0, 0, 100, 80), Rect::new(20, 30, 10, 20));
        assert_eq!(track.bbox().whole(), Rect::new(20, 30, 10, 20));
        track.motion.place.scale = 2 * SCALE;
        assert_eq!(track.bbox().whole(), Rect::new(15, 20, 20, 40));
    }
}
