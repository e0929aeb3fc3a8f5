//! Every frame of a recording as small pictures, within a number of bytes: beyond it frames get smaller, then fewer.

use super::difference::{BARS, Difference, differences, patch};
use super::search::Sight;
use crate::encode;
use anyhow::Result;
use smr_recordings::{ColorFrame, GrayFrame, decode_colors};

/// The longest side of a frame in a page, however large the budget is.
const LARGEST: u16 = 960;
/// Frames are made smaller while their longest side is above; then every other one is left out.
const SMALL: u16 = 320;
/// The longest side of a template and of its difference map; of a larger one every second, third, ... pixel is shown.
const LARGEST_PATCH: u16 = 64;

/// The frames that are kept, and what was compared in them.
pub(super) struct Pictures {
    /// Bytes that they may take in the page.
    limit: usize,
    side: u16,
    /// Frames are kept whose index this divides.
    pub every: usize,
    pub kept: Vec<Picture>,
}

pub(super) struct Picture {
    index: usize,
    /// The longest side of the frame as it is kept.
    side: u16,
    pub jpeg: Vec<u8>,
    /// Of each method; `None` where nothing was compared.
    pub comparisons: Vec<Option<Comparison>>,
}

pub(super) struct Comparison {
    /// PNG files.
    pub template: Vec<u8>,
    pub map: Vec<u8>,
    /// The share of the pixels in each bar, and of those that count if there is a threshold.
    pub histogram: [f64; BARS],
    pub counting: Option<f64>,
}

impl Pictures {
    pub fn new(limit: usize) -> Self {
        Self { limit, side: LARGEST, every: 1, kept: Vec::new() }
    }

    /// Takes frame `index` if there is room for such frames.
    pub fn offer(&mut self, index: usize, frame: &ColorFrame, sights: &[Sight]) -> Result<()> {
        if !index.is_multiple_of(self.every) {
            return Ok(());
        }
        let comparisons = sights.iter().map(comparison).collect::<Result<_>>()?;
        let jpeg = small(frame, self.side)?;
        let side = frame.width.max(frame.height).min(self.side);
        self.kept.push(Picture { index, side, jpeg, comparisons });
        while self.bytes() > self.limit && self.shrink()? {}
        Ok(())
    }

    /// In the page, where 3 bytes become 4 characters.
    pub fn bytes(&self) -> usize {
        self.kept.iter().map(Picture::bytes).sum()
    }

    /// The longest side of the frames that are kept; 0 if there are none.
    pub fn side(&self) -> u16 {
        self.kept.first().map_or(0, |first| first.side)
    }

    /// Smaller frames, or fewer; false if there is nothing left to leave out.
    pub fn shrink(&mut self) -> Result<bool> {
        let side = self.side();
        if side > SMALL {
            self.side = (side / 2).max(SMALL);
            for picture in &mut self.kept {
                picture.jpeg = small(&decode_colors(&picture.jpeg)?, self.side)?;
                picture.side = self.side;
            }
            return Ok(true);
        }
        if self.kept.len() < 2 {
            return Ok(false);
        }
        self.every *= 2;
        self.kept.retain(|picture| picture.index.is_multiple_of(self.every));
        Ok(true)
    }
}

fn small(frame: &ColorFrame, side: u16) -> Result<Vec<u8>> {
    encode::color_jpeg(&encode::within(frame, side), encode::ENOUGH)
}

impl Picture {
    fn bytes(&self) -> usize {
        let comparisons = self.comparisons.iter().flatten();
        // Six characters for each bar of a histogram.
        let compared = comparisons.map(|one| (one.template.len() + one.map.len()).div_ceil(3) * 4 + 6 * BARS);
        self.jpeg.len().div_ceil(3) * 4 + compared.sum::<usize>()
    }
}

fn comparison(sight: &Sight) -> Result<Option<Comparison>> {
    let Some(search) = &sight.search else { return Ok(None) };
    let Difference { pixels, template } = &search.difference;
    Ok(Some(Comparison {
        template: patch(&thinned(template))?,
        map: differences(&thinned(pixels), search.alpha)?,
        histogram: search.difference.histogram(),
        counting: search.alpha.map(|alpha| search.difference.counting(alpha)),
    }))
}

fn thinned(GrayFrame { width, height, pixels }: &GrayFrame) -> GrayFrame {
    let every = width.max(height).div_ceil(LARGEST_PATCH).max(1);
    let rows = pixels.chunks(usize::from(*width).max(1)).step_by(every.into());
    let pixels = rows.flat_map(|row| row.iter().step_by(every.into())).copied().collect();
    GrayFrame { width: width.div_ceil(every), height: height.div_ceil(every), pixels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::synthetic;

    fn taken(limit: usize, frames: usize) -> Pictures {
        let mut pictures = Pictures::new(limit);
        (0..frames).for_each(|index| pictures.offer(index, &(&synthetic::frame(index)).into(), &[]).unwrap());
        pictures
    }

    #[test]
    fn beyond_the_budget_frames_get_fewer() {
        let all = taken(usize::MAX, 40);
        assert_eq!((all.kept.len(), all.every, all.side()), (40, 1, 160));
        let some = taken(all.bytes() / 3, 40);
        assert!(some.bytes() <= all.bytes() / 3);
        assert_eq!((some.kept.len(), some.every), (10, 4));
        assert!(some.kept.iter().all(|picture| picture.index.is_multiple_of(4)));
        assert_eq!(taken(0, 40).kept.len(), 1, "the first frame stays");
    }

    #[test]
    fn large_frames_get_smaller_first() {
        let pixels =
            (0..2000 * 1000_u32).map(|at| [(at.wrapping_mul(2_654_435_761) >> 26).to_le_bytes()[0], 7, 200]).collect();
        let frame = ColorFrame { width: 2000, height: 1000, pixels };
        let mut pictures = Pictures::new(usize::MAX);
        (0..2).for_each(|index| pictures.offer(index, &frame, &[]).unwrap());
        let mut sides = vec![pictures.side()];
        while pictures.kept.len() == 2 && pictures.shrink().unwrap() {
            sides.push(pictures.side());
        }
        assert_eq!(sides, [960, 480, 320, 320]);
        let [red, green, blue] = decode_colors(&pictures.kept[0].jpeg).unwrap().pixels[9];
        assert!(red < 80 && green < 40 && blue > 150, "as blue as it was: {red} {green} {blue}");
    }

    #[test]
    fn of_a_large_template_every_second_pixel_is_shown() {
        let pixels = (0..3).flat_map(|row| (0..100).map(move |column| row * 100 + column / 2)).collect();
        let expected = GrayFrame { width: 50, height: 2, pixels: (0..50).chain(200..250).collect() };
        assert_eq!(thinned(&GrayFrame { width: 100, height: 3, pixels }), expected);
    }
}
