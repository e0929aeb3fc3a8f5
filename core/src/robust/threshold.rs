//! The threshold by contrast: what belongs to the target differs from the template by less than the template varies.

/// Bounds of alpha, in gray levels.
const LEAST: u32 = 8;
const MOST: u32 = 100;

/// Mean and mean absolute deviation from it; the mean is rounded to a gray level, the sum of deviations is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contrast {
    pub(super) pixels: u32,
    pub(super) mean: u32,
    /// The sum over all pixels.
    pub(super) deviation: u32,
}

impl Contrast {
    pub(super) fn of(pixels: impl Iterator<Item = u8> + Clone) -> Self {
        let (count, sum) = pixels.clone().fold((0, 0), |(count, sum), pixel| (count + 1, sum + u32::from(pixel)));
        let mean = (sum + count / 2) / count.max(1);
        Self { pixels: count, mean, deviation: pixels.map(|pixel| u32::from(pixel).abs_diff(mean)).sum() }
    }
}

/// The mean absolute deviation itself, rounded down, 8 to 100: what agrees with a patch in its light differs by less.
pub(super) fn within_deviation(contrast: Contrast) -> u16 {
    u16::try_from((contrast.deviation / contrast.pixels.max(1)).clamp(LEAST, MOST)).unwrap_or(0)
}

/// 7/5 of the mean absolute deviation of `pixels` from their mean, rounded down, 8 to 100.
pub(super) fn by_contrast(pixels: &[u8]) -> u16 {
    let contrast = Contrast::of(pixels.iter().copied());
    u16::try_from((7 * contrast.deviation / (5 * contrast.pixels).max(1)).clamp(LEAST, MOST)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_a_case_by_hand() {
        assert_eq!(by_contrast(&[]), 8);
        assert_eq!(by_contrast(&[77; 100]), 8);
        assert_eq!(by_contrast(&[80, 120, 80, 120]), 28);
        assert_eq!(by_contrast(&[0, 255].repeat(512)), 100);
        let within = |pixels: &[u8]| within_deviation(Contrast::of(pixels.iter().copied()));
        assert_eq!([within(&[]), within(&[80, 120, 80, 121]), within(&[0, 255])], [8, 20, 100]);
    }
}
