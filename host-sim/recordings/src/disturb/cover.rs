//! Covers of a camera's lens: frames that show nothing of the target.

use crate::raster::GrayFrame;
use clap::ValueEnum;
use smr_scene::random::Random;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Cover {
    Black,
    White,
    /// Gray level 128 in every pixel.
    Gray,
    /// Random pixels, different in every frame.
    Noise,
    /// One frame of another scene, repeated.
    Frozen,
}

const SEED: u64 = 0xC0FE_0000;

impl Cover {
    /// Returns frame `index`, from 0, of the covered lens; `other` is a frame of another scene in the same size.
    pub fn frame(self, index: usize, other: &GrayFrame) -> GrayFrame {
        let mut made = other.clone();
        match self {
            Self::Black => made.pixels.fill(0),
            Self::White => made.pixels.fill(255),
            Self::Gray => made.pixels.fill(128),
            Self::Noise => {
                let mut random = Random(SEED + index as u64);
                for pixels in made.pixels.chunks_mut(8) {
                    pixels.copy_from_slice(&random.next().to_le_bytes()[..pixels.len()]);
                }
            }
            Self::Frozen => {}
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_shows_what_it_is_called() {
        let other = GrayFrame { width: 21, height: 3, pixels: (1..64).collect() };
        let shown = |cover: Cover, index| cover.frame(index, &other);
        for (cover, level) in [(Cover::Black, 0), (Cover::White, 255), (Cover::Gray, 128)] {
            assert_eq!(shown(cover, 7).pixels, [level; 63], "{cover:?}");
        }
        assert_eq!(shown(Cover::Frozen, 9), other);
        assert_eq!(shown(Cover::Noise, 5), shown(Cover::Noise, 5), "always the same");
        assert_ne!(shown(Cover::Noise, 5), shown(Cover::Noise, 6));
        let levels: std::collections::BTreeSet<u8> = shown(Cover::Noise, 0).pixels.into_iter().collect();
        assert!(levels.len() > 40, "{levels:?}");
    }
}
