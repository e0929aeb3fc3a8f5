//! A target of the robust tracker as bytes.

use super::config::{Config, Parts};
use super::grid::Grid;
use super::sweep::Sweep;
use super::target::Robust;
use super::track::{Place, Track};
use super::trust::Trust;
use super::update::scale_is_known;
use super::{CHANNELS, MOST_CELLS, MOST_PIXELS};
use crate::image::Rect;
use crate::track::saved::{AROUND, ConfigSum, Kind, Reader, Writer};
use crate::track::{Quality, RestoreError, SaveError};

/// Bytes of the track.
const TRACK: usize = 58;
/// The most bytes that there can be.
pub(super) const SIZE: usize = AROUND + TRACK + 4 * MOST_CELLS * CHANNELS + 2 * MOST_PIXELS;

/// The bytes of this target.
pub(super) fn saved_size(robust: &Robust) -> Result<usize, SaveError> {
    let size = AROUND + TRACK + 4 * robust.filter.weights().len() + 2 * robust.early.fine().len();
    robust.track.map(|_| size).ok_or(SaveError::NotLocked)
}

pub(super) fn save(robust: &Robust, bytes: &mut [u8]) -> Result<usize, SaveError> {
    let track = robust.track.ok_or(SaveError::NotLocked)?;
    let mut to = Writer::new(bytes, saved_size(robust)?, Kind::Robust, sum(&robust.config))?;
    for side in [track.bounds.width, track.bounds.height, track.width, track.height] {
        to.u16(side);
    }
    for place in [track.place.x, track.place.y, track.right, track.down] {
        to.i64(place);
    }
    to.u32(track.place.scale);
    to.u32(track.believed);
    to.i32(track.trust.0);
    to.u32(track.sweep.next);
    to.u16(track.quality.value());
    robust.filter.weights().iter().for_each(|&weight| to.i32(weight));
    robust.early.fine().iter().for_each(|&fine| to.u16(fine));
    Ok(to.finish())
}

pub(super) fn restore(robust: &mut Robust, bytes: &[u8]) -> Result<(), RestoreError> {
    let mut from = Reader::new(bytes, Kind::Robust, sum(&robust.config))?;
    let track = track(&mut from).ok_or(RestoreError::Damaged)?;
    let grid = &track.grid;
    let weights = usize::from(grid.across) * usize::from(grid.down) * CHANNELS;
    let pixels = usize::from(grid.columns) * usize::from(grid.rows);
    let weights = from.slice(4 * weights).ok_or(RestoreError::Damaged)?;
    let fine = from.slice(2 * pixels).filter(|_| from.is_empty()).ok_or(RestoreError::Damaged)?;
    robust.filter.restore(grid, weights.as_chunks().0.iter().map(|&bytes| i32::from_le_bytes(bytes)));
    robust.early.restore(fine.as_chunks().0.iter().map(|&bytes| u16::from_le_bytes(bytes)));
    robust.track = Some(track);
    robust.ticket.change();
    Ok(())
}

/// The track, if each number can be one.
fn track(from: &mut Reader<'_>) -> Option<Track> {
    let bounds = Rect::new(0, 0, from.u16()?, from.u16()?);
    let target = Rect::new(0, 0, from.u16()?, from.u16()?);
    let (x, y, right, down) = (from.i64()?, from.i64()?, from.i64()?, from.i64()?);
    let (scale, believed) = (from.u32()?, from.u32()?);
    let trust = Trust::restore(from.i32()?)?;
    let sweep = Sweep { next: from.u32()? };
    let quality = Quality::of_value(from.u16()?);
    let place = Place { x, y, scale };
    let moves = i64::from(u16::MAX) << 12;
    let possible = bounds.contains(target)
        && place.inside(bounds) == place
        && [right, down].iter().all(|by| (-moves..=moves).contains(by))
        && [scale, believed].into_iter().all(scale_is_known);
    let Rect { width, height, .. } = target;
    possible.then(|| Track {
        bounds,
        grid: Grid::new(target),
        width,
        height,
        place,
        right,
        down,
        believed,
        trust,
        sweep,
        quality,
    })
}

/// The checksum of what answers depend on.
fn sum(config: &Config) -> u32 {
    let mut sum = ConfigSum::new();
    numbers(config, |number| sum.add(number));
    sum.finish()
}

/// What answers depend on.
pub(in crate::track) fn numbers(config: &Config, mut add: impl FnMut(u16)) {
    config.table.entries().iter().for_each(|&entry| add(entry));
    let Parts { velocity, near, verification, caution } = config.parts;
    for part in [config.size, config.sweep, velocity, near, verification, caution] {
        add(part.into());
    }
    let Config { reach, patience, lost_below, uncertain_below, learning_rate, early_rate, .. } = *config;
    for number in [reach.into(), patience.into(), lost_below, uncertain_below, learning_rate, early_rate] {
        add(number);
    }
}
