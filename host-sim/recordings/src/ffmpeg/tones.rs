//! Tone mapping: converts HDR light to the levels of an ordinary screen.

use super::matroska;
use super::process::Input;
use anyhow::Result;
use std::io::Read;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transfer {
    Pq,
    Hlg,
}

/// Returns the transfer function of a video stream's first image; `None` without HDR. ffmpeg states it as a number in
/// the head of a Matroska file.
pub(super) fn transfer(input: &Input, map: &str) -> Result<Option<Transfer>> {
    let mut command = input.command(&[]);
    command.args(["-map", map, "-frames:v", "1", "-vf", "crop='min(2,iw)':'min(2,ih)'"]);
    command.args(["-c:v", "ffv1", "-f", "matroska", "-"]);
    let ffmpeg = input.run(&mut command)?;
    let mut head = Vec::new();
    ffmpeg.output().take(MAX_HEAD).read_to_end(&mut head)?;
    Ok(match matroska::number(&head, &TRANSFER_CHARACTERISTICS) {
        Some(16) => Some(Transfer::Pq),
        Some(18) => Some(Transfer::Hlg),
        _ => None,
    })
}

/// Largest Matroska file with an image of four pixels, in bytes.
const MAX_HEAD: u64 = 1 << 20;

/// Path of Matroska elements: Segment, Tracks, TrackEntry, Video, Colour, TransferCharacteristics.
const TRANSFER_CHARACTERISTICS: [u32; 6] = [0x1853_8067, 0x1654_AE6B, 0xAE, 0xE0, 0x55B0, 0x55BA];

/// Tone curve: multiplies red, green and blue of BT.709 (negative light is cut to 0) by (1 + L / P^2) / (1 + L), and
/// cuts the products to 1. L is the brightest of the three, and P is 1000 cd/m2, both in units of white paper (203
/// cd/m2, ITU-R BT.2408).
pub(super) struct Tones {
    transfer: Transfer,
    /// Light of each 12-bit level: for PQ relative to the reference white, for HLG the scene's light, from 0 to 1.
    light: Vec<f32>,
    /// Table of sRGB levels: entry n is the 8-bit level of the light (n / 4095)^2.
    levels: Vec<u8>,
}

const PEAK: f32 = 1000.0 / 203.0;

impl Tones {
    pub fn of(transfer: Transfer) -> Self {
        let steps = || (0..4096_u16).map(|step| f32::from(step) / 4095.0);
        let light = match transfer {
            Transfer::Pq => |level: f32| {
                let root = level.powf(32.0 / 2523.0);
                10_000.0 / 203.0
                    * ((root - 0.835_937_5).max(0.0) / (18.851_562 - 18.687_5 * root)).powf(8192.0 / 1305.0)
            },
            Transfer::Hlg => |level: f32| match level {
                ..=0.5 => level * level / 3.0,
                _ => (((level - 0.559_910_7) / 0.178_832_77).exp() + 0.284_668_92) / 12.0,
            },
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        let level = |root: f32| match root * root {
            light @ ..=0.003_130_8 => (light * 12.92 * 255.0).round() as u8,
            light => ((1.055 * light.powf(1.0 / 2.4) - 0.055) * 255.0).round() as u8,
        };
        Self { transfer, light: steps().map(light).collect(), levels: steps().map(level).collect() }
    }

    /// Converts red, green and blue from 16 bits to 8, in ffmpeg's layouts rgb48le and rgb24.
    pub fn of_all(&self, bytes: &[u8]) -> Vec<u8> {
        let pixels = bytes.as_chunks::<6>().0.iter();
        pixels.flat_map(|&[a, b, c, d, e, f]| self.shown([[a, b], [c, d], [e, f]].map(u16::from_le_bytes))).collect()
    }

    fn shown(&self, pixel: [u16; 3]) -> [u8; 3] {
        let [red, green, blue] = pixel.map(|level| self.light[usize::from(level >> 4)]);
        // The system gain of HLG, for a screen of 1000 cd/m2, grows with the luminance of the pixel.
        let gain = match self.transfer {
            Transfer::Pq => 1.0,
            Transfer::Hlg => PEAK * (0.2627 * red + 0.678 * green + 0.0593 * blue).powf(0.2),
        };
        let own = [
            1.6605 * red - 0.5876 * green - 0.0729 * blue,
            -0.1246 * red + 1.1329 * green - 0.0083 * blue,
            -0.0182 * red - 0.1006 * green + 1.1188 * blue,
        ];
        let own = own.map(|light| (light * gain).max(0.0));
        let brightest = own[0].max(own[1]).max(own[2]);
        let by = (1.0 + brightest / (PEAK * PEAK)) / (1.0 + brightest);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive, and bounded
        own.map(|light| self.levels[((light * by).sqrt().min(1.0) * 4095.0).round() as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By ITU-R BT.2408, levels are 58 % (PQ) and 75 % (HLG) at 203 cd/m2, and 75 % (PQ) and 100 % (HLG) at 1000 cd/m2.
    #[test]
    fn white_is_bright_and_what_is_brighter_still_differs() {
        for (transfer, white, peak) in [(Transfer::Pq, 38_056, 49_269), (Transfer::Hlg, 49_151, 65_535)] {
            let tones = Tones::of(transfer);
            let shown = |level| tones.shown([level; 3]);
            let [gray, ..] = shown(white);
            assert!(gray.abs_diff(190) <= 2 && shown(white) == [gray; 3], "{transfer:?}: {gray}");
            assert!((253..=255).contains(&shown(peak)[0]), "{transfer:?}: {:?}", shown(peak));
            assert_eq!((shown(0), shown(65_535)), ([0; 3], [255; 3]));
            let [red, green, blue] = tones.shown([40_000, 20_000, 20_000]);
            assert!(red > green + 60 && green.abs_diff(blue) < 40, "{transfer:?}: {red} {green} {blue}");
        }
    }
}
