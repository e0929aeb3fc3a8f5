//! Small images of frames for the report's player, in a limited number of bytes: they get smaller, then fewer.

use super::difference::{BARS, differences, patch};
use super::observation::{Observation, Search};
use crate::encode::{self, base64, rounded};
use anyhow::Result;
use serde_json::{Value, json};
use smr_recordings::{ColorFrame, GrayFrame, decode_colors};

/// Longest side of an image in pixels, however large the budget is.
const LARGEST: u16 = 960;
/// Lower limit for the longest side of scaled-down images, in pixels; at it, every other image is removed instead.
const SMALL: u16 = 320;
/// Longest side in pixels of a template or difference map; a larger one is subsampled by 2, 3, ...
const LARGEST_PATCH: u16 = 64;

/// Images of some or all frames, each with the methods' templates and difference maps in that frame.
pub(super) struct Images {
    /// Largest size of all images in the page together, in bytes.
    limit: usize,
    side: u16,
    /// Only frames whose index is a multiple of this are kept.
    pub every: usize,
    pub kept: Vec<Image>,
}

pub(super) struct Image {
    index: usize,
    /// Longest side of the JPEG in pixels.
    side: u16,
    pub jpeg: Vec<u8>,
    /// Each method's template and difference map as JSON, null without a comparison. `compared` is their size in bytes.
    pub comparisons: Vec<Value>,
    compared: usize,
}

impl Images {
    pub fn new(limit: usize) -> Self {
        Self { limit, side: LARGEST, every: 1, kept: Vec::new() }
    }

    /// Adds frame `index` if it is a multiple of `every`, and shrinks the images while they exceed the limit.
    pub fn offer(&mut self, index: usize, frame: &ColorFrame, observations: &[Observation]) -> Result<()> {
        if !index.is_multiple_of(self.every) {
            return Ok(());
        }
        let compared = observations.iter().map(comparison).collect::<Result<Vec<_>>>()?;
        let (comparisons, sizes): (Vec<_>, Vec<usize>) = compared.into_iter().unzip();
        let jpeg = small(frame, self.side)?;
        let side = frame.width.max(frame.height).min(self.side);
        self.kept.push(Image { index, side, jpeg, comparisons, compared: sizes.iter().sum() });
        while self.bytes() > self.limit && self.shrink()? {}
        Ok(())
    }

    /// Returns the size in bytes of all images in the page, where base64 encodes 3 bytes as 4 characters.
    pub fn bytes(&self) -> usize {
        self.kept.iter().map(|image| image.jpeg.len().div_ceil(3) * 4 + image.compared).sum()
    }

    pub fn side(&self) -> u16 {
        self.kept.first().map_or(0, |first| first.side)
    }

    /// Halves the longest side of the images, but not below `SMALL`; at `SMALL`, halves their number instead. Returns
    /// false if only one small image is left.
    pub fn shrink(&mut self) -> Result<bool> {
        let side = self.side();
        if side > SMALL {
            self.side = (side / 2).max(SMALL);
            for image in &mut self.kept {
                image.jpeg = small(&decode_colors(&image.jpeg)?, self.side)?;
                image.side = self.side;
            }
            return Ok(true);
        }
        if self.kept.len() < 2 {
            return Ok(false);
        }
        self.every *= 2;
        self.kept.retain(|image| image.index.is_multiple_of(self.every));
        Ok(true)
    }
}

fn small(frame: &ColorFrame, side: u16) -> Result<Vec<u8>> {
    encode::color_jpeg(&encode::within(frame, side), encode::ENOUGH)
}

/// Returns the template, the difference map and its histogram as JSON, and roughly their size in the page in bytes.
fn comparison(observation: &Observation) -> Result<(Value, usize)> {
    let Some(Search { difference, alpha }) = &observation.search else { return Ok((Value::Null, 0)) };
    let template = patch(&thinned(&difference.template))?;
    let map = differences(&thinned(&difference.pixels), *alpha)?;
    let compared = json!({
        "template": base64(&template),
        "map": base64(&map),
        "histogram": difference.histogram().map(|part| (part * 1000.0).round()).to_vec(),
        "counting": alpha.map(|alpha| rounded(difference.counting(alpha), 3)),
    });
    // A bar of the histogram takes up to six characters.
    Ok((compared, (template.len() + map.len()).div_ceil(3) * 4 + 6 * BARS))
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

    fn taken(limit: usize, frames: usize) -> Images {
        let mut images = Images::new(limit);
        (0..frames).for_each(|index| images.offer(index, &(&synthetic::frame(index)).into(), &[]).unwrap());
        images
    }

    #[test]
    fn beyond_the_budget_frames_get_fewer() {
        let all = taken(usize::MAX, 40);
        assert_eq!((all.kept.len(), all.every, all.side()), (40, 1, 160));
        let some = taken(all.bytes() / 3, 40);
        assert!(some.bytes() <= all.bytes() / 3);
        assert_eq!((some.kept.len(), some.every), (10, 4));
        assert!(some.kept.iter().all(|image| image.index.is_multiple_of(4)));
        assert_eq!(taken(0, 40).kept.len(), 1, "the first frame stays");
    }

    #[test]
    fn large_frames_get_smaller_first() {
        let pixels =
            (0..2000 * 1000_u32).map(|at| [(at.wrapping_mul(2_654_435_761) >> 26).to_le_bytes()[0], 7, 200]).collect();
        let frame = ColorFrame { width: 2000, height: 1000, pixels };
        let mut images = Images::new(usize::MAX);
        (0..2).for_each(|index| images.offer(index, &frame, &[]).unwrap());
        let mut sides = vec![images.side()];
        while images.kept.len() == 2 && images.shrink().unwrap() {
            sides.push(images.side());
        }
        assert_eq!(sides, [960, 480, 320, 320]);
        let [red, green, blue] = decode_colors(&images.kept[0].jpeg).unwrap().pixels[9];
        assert!(red < 80 && green < 40 && blue > 150, "as blue as it was: {red} {green} {blue}");
    }

    #[test]
    fn of_a_large_template_every_second_pixel_is_shown() {
        let pixels = (0..3).flat_map(|row| (0..100).map(move |column| row * 100 + column / 2)).collect();
        let expected = GrayFrame { width: 50, height: 2, pixels: (0..50).chain(200..250).collect() };
        assert_eq!(thinned(&GrayFrame { width: 100, height: 3, pixels }), expected);
    }
}
