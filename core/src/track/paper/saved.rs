//! A target of the paper tracker as bytes: track (box, frame size, state), threshold alpha, template.

use super::config::Config;
use super::template::Template;
use super::track::Track;
use crate::image::Rect;
use crate::track::saved::{Reader, Refusal, Saved, Writer, around};
use crate::track::settings::{Kind, Numbers};
use crate::track::{Quality, RestoreError, SaveError, State};

/// The size in bytes of the saved `Track` and the threshold alpha together.
const TRACK: usize = 24;

/// The size in bytes of a saved target with a template of `pixels` pixels.
pub(super) const fn size(pixels: usize) -> usize {
    around(Config::COUNT) + TRACK + pixels
}

pub(super) fn saved_size(track: Option<&Track>) -> Result<usize, SaveError> {
    let target = track.ok_or(SaveError::NotLocked)?.target;
    Ok(size(usize::from(target.width) * usize::from(target.height)))
}

pub(super) fn save<const PIXELS: usize>(
    (config, track, template): (&Config, Option<&Track>, &Template<PIXELS>),
    bytes: &mut [u8],
) -> Result<usize, SaveError> {
    let (Some(track), Some(image)) = (track, template.image()) else { return Err(SaveError::NotLocked) };
    let mut to = Writer::new(bytes, saved_size(Some(track))?, &Saved::of(Kind::Paper, config, &config.numbers()))?;
    to.i32(track.target.x);
    to.i32(track.target.y);
    for side in [track.target.width, track.target.height, track.bounds.width, track.bounds.height] {
        to.u16(side);
    }
    to.u16(track.lost_for);
    to.put(&[track.state.code(), track.edge.into()]);
    to.u16(track.quality.value());
    to.u16(template.threshold());
    // Not `Image::rows`, which may compile to a division by the stride.
    (0..image.height()).for_each(|y| to.put(image.row(y)));
    Ok(to.finish())
}

pub(super) fn reader<'a>(config: &Config, bytes: &'a [u8]) -> Result<Reader<'a>, Refusal> {
    Reader::new(bytes, &Saved::of(Kind::Paper, config, &config.numbers()))
}

/// Restores the template and returns the track. If it fails, the template is unchanged.
#[inline(never)]
pub(super) fn restore<const PIXELS: usize>(
    config: &Config,
    template: &mut Template<PIXELS>,
    span: usize,
    bytes: &[u8],
) -> Result<Track, Refusal> {
    let mut from = reader(config, bytes)?;
    let (track, threshold) = track(&mut from, config.padding).ok_or(RestoreError::Damaged)?;
    track.check_room(PIXELS, span, config).map_err(|_| RestoreError::TooLarge)?;
    let area = usize::try_from(track.target.area()).unwrap_or(usize::MAX);
    let pixels = from.slice(area).filter(|_| from.is_empty()).ok_or(RestoreError::Damaged)?;
    template.restore(pixels, (track.target.width, track.target.height), threshold);
    Ok(track)
}

/// Reads the track and the threshold; `None` if a number is out of range.
fn track(from: &mut Reader<'_>, padding: u16) -> Option<(Track, u16)> {
    let (x, y) = (from.i32()?, from.i32()?);
    let target = Rect::new(x, y, from.u16()?, from.u16()?);
    let bounds = Rect::new(0, 0, from.u16()?, from.u16()?);
    let lost_for = from.u16()?;
    let state = State::from_code(from.u8()?).filter(|&state| state != State::Uncertain)?;
    let edge = match from.u8()? {
        0 => false,
        1 => true,
        _ => return None,
    };
    let (quality, threshold) = (Quality::of_value(from.u16()?), from.u16()?);
    let track = Track { target, bounds, state, edge, lost_for, quality };
    let fits = !target.is_empty() && target.width <= bounds.width && target.height <= bounds.height;
    let reachable = track.nearest_on(padding) == target;
    (fits && reachable && (1..=256).contains(&threshold)).then_some((track, threshold))
}
