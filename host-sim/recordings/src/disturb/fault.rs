//! Simulated faults of cameras in undamaged frames; the same seed always generates the same frames.

use crate::disturb::away::Away;
use crate::raster::GrayFrame;
use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use smr_files::messages::choice_name;
use smr_scene::random::Random;
use std::fmt;
use std::str::FromStr;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    kind: Kind,
    /// The N of `NAME:N`: a length in frames if the kind of fault has a length, else the strength of the fault.
    amount: u16,
}

/// Kinds of faults, which the help of `eval --fault` explains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    Dropped,
    Repeated,
    Torn,
    Black,
    White,
    Columns,
    Bits,
    Gain,
    Noise,
    Origin,
    Gap,
    Away,
    Light,
    Dusk,
    Night,
    Fog,
    Gamma,
    Offset,
}

/// Length in frames of the faults whose `amount` is a strength, except changes of light, which last `LIGHT_FRAMES`.
const FRAMES: usize = 10;

const LIGHT_FRAMES: usize = 150;
/// Number of frames in which dusk fades the light to its final level.
const DUSK_FRAMES: i64 = 100;

const SEED: u64 = 0xFA17_0000;

impl Fault {
    pub fn is_there_at_the_lock(&self) -> bool {
        self.kind == Kind::Night
    }

    /// True if the target leaves, and is at another position when it returns.
    pub fn is_away(&self) -> bool {
        self.kind == Kind::Away
    }

    pub fn frames(&self) -> usize {
        let amount = usize::from(self.amount);
        match self.kind {
            Kind::Dropped => 2 * amount,
            Kind::Repeated | Kind::Torn | Kind::Black | Kind::White | Kind::Gap | Kind::Away => amount,
            Kind::Columns | Kind::Bits | Kind::Gain | Kind::Noise | Kind::Origin => FRAMES,
            Kind::Light | Kind::Dusk | Kind::Night | Kind::Fog | Kind::Gamma | Kind::Offset => LIGHT_FRAMES,
        }
    }

    /// Returns the faulty frame to show in place of `frame`, or `None` to drop it; `index` counts from the first frame
    /// of the fault. `before` is the last frame before the fault, `former` the recorded frame before `frame`.
    pub fn of(
        &self,
        index: usize,
        frame: &GrayFrame,
        (before, former): (&GrayFrame, &GrayFrame),
        seed: u64,
        away: &Away,
    ) -> Option<GrayFrame> {
        let amount = self.amount;
        let mut random = Random(SEED ^ seed << 24 ^ (index as u64 + 1) << 8);
        let mut once = Random(SEED ^ seed << 24);
        let mut made = frame.clone();
        let width = usize::from(frame.width);
        let pixels = &mut made.pixels;
        match self.kind {
            Kind::Dropped if index.is_multiple_of(2) => return None,
            Kind::Gap => return None,
            Kind::Away => return Some(away.view(index, frame)),
            Kind::Dropped => {}
            Kind::Repeated => pixels.clone_from(&before.pixels),
            Kind::Torn => {
                let height = usize::from(frame.height);
                let start = (height / 4 + random.place(height / 2)) * width;
                pixels[start..].copy_from_slice(&former.pixels[start..]);
            }
            Kind::Black => pixels.fill(0),
            Kind::White => pixels.fill(255),
            Kind::Columns => {
                for _ in 0..amount {
                    let (column, value) = (once.place(width), once.next().to_le_bytes()[0]);
                    pixels.iter_mut().skip(column).step_by(width).for_each(|pixel| *pixel = value);
                }
            }
            Kind::Bits => {
                for pixel in pixels {
                    if random.place(1000) < usize::from(amount) {
                        *pixel ^= 1 << random.place(8);
                    }
                }
            }
            Kind::Gain => relight(pixels, |level| level * i64::from(amount) / 100),
            Kind::Noise => relight(pixels, |level| level + normal(&mut random, amount)),
            Kind::Light | Kind::Night => dim(pixels, amount.into(), &mut random),
            Kind::Dusk => {
                let step = i64::try_from(index + 1).unwrap_or(DUSK_FRAMES).min(DUSK_FRAMES);
                dim(pixels, 100 + (i64::from(amount) - 100) * step / DUSK_FRAMES, &mut random);
            }
            Kind::Fog => relight(pixels, |level| FOG + (level - FOG) * i64::from(amount) / 100),
            Kind::Gamma => relight(pixels, |level| raised(level, f64::from(amount) / 100.0)),
            Kind::Offset => relight(pixels, |level| level + i64::from(amount)),
            Kind::Origin => {
                // Repeats the edges of the shifted image in the area that it leaves uncovered.
                let (right, down) = (i32::from(amount), i32::from(amount / 2));
                let level = |x: i32, y: i32| frame.level((x - right).max(0), (y - down).max(0));
                return Some(GrayFrame::drawn(frame.width, frame.height, level));
            }
        }
        Some(made)
    }
}

const FOG: i64 = 110;

fn relight(pixels: &mut [u8], mut light: impl FnMut(i64) -> i64) {
    pixels.iter_mut().for_each(|pixel| *pixel = u8::try_from(light((*pixel).into()).clamp(0, 255)).unwrap_or(u8::MAX));
}

/// Scales gray levels by `hundredths` / 100, and adds noise with a standard deviation of one gray level.
fn dim(pixels: &mut [u8], hundredths: i64, random: &mut Random) {
    relight(pixels, |level| level * hundredths / 100 + normal(random, 1));
}

#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // 0 to 255
fn raised(level: i64, power: f64) -> i64 {
    (255.0 * (level as f64 / 255.0).powf(power)).round() as i64
}

/// Returns a nearly normal random number: the sum of eight uniform bytes, less its mean, scaled to `deviation`.
fn normal(random: &mut Random, deviation: u16) -> i64 {
    let sum: i64 = random.next().to_le_bytes().into_iter().map(i64::from).sum();
    // The standard deviation of the sum is sqrt(8 * (256^2 - 1) / 12) = 209.
    ((sum - 4 * 255) * i64::from(deviation)).div_euclid(209)
}

impl FromStr for Fault {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (name, amount) = text.split_once(':').unwrap_or((text, if text == "away" { "40" } else { "" }));
        let Ok(kind) = Kind::from_str(name, false) else {
            let names = Kind::value_variants().iter().map(choice_name).collect::<Vec<_>>().join(", ");
            bail!("there is no fault {name}: expected NAME:N, all, light, away or cover; names are {names}")
        };
        let most = if kind == Kind::Bits { 1000 } else { 9999 };
        let amount = amount.parse().ok().filter(|amount| (1..=most).contains(amount));
        let amount = amount.ok_or_else(|| anyhow!("expected {name}:N with a whole number from 1 to {most}"))?;
        Ok(Self { kind, amount })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", choice_name(&self.kind), self.amount)
    }
}

/// A value of `--fault`: one fault, a named list of faults, or the covers of the lens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Faults {
    List(Vec<Fault>),
    Cover,
}

impl FromStr for Faults {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let list = match text {
            "cover" => return Ok(Self::Cover),
            "all" => {
                "dropped:5 repeated:5 torn:3 black:3 white:3 columns:8 bits:20 gain:50 gain:150 noise:20 origin:12 gap:10"
            }
            "light" => "light:20 light:200 dusk:20 night:20 fog:20 gamma:50 gamma:200 offset:60",
            one => one,
        };
        Ok(Self::List(list.split(' ').map(str::parse).collect::<Result<_>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(seed: i32) -> GrayFrame {
        GrayFrame::drawn(40, 30, |x, y| ((x * 7 + y * 293 + seed * 50) % 251).to_le_bytes()[0])
    }

    fn made(fault: &str, index: usize) -> Option<GrayFrame> {
        let away = Away::new(&[Some([9, 9, 4, 4].into()); 9], 1..3, frame(3).frame().bounds());
        fault.parse::<Fault>().unwrap().of(index, &frame(3), (&frame(1), &frame(2)), 7, &away)
    }

    fn changed(fault: &str, index: usize) -> usize {
        let made = made(fault, index).unwrap();
        made.pixels.iter().zip(frame(3).pixels).filter(|(a, b)| **a != *b).count()
    }

    #[test]
    fn each_does_what_it_is_called() {
        assert_eq!((made("dropped:3", 0), made("dropped:3", 1)), (None, Some(frame(3))));
        assert_eq!((made("gap:3", 2), made("repeated:3", 2)), (None, Some(frame(1))));
        assert!(made("black:1", 0).unwrap().pixels.iter().all(|&pixel| pixel == 0));
        assert!(made("white:1", 0).unwrap().pixels.iter().all(|&pixel| pixel == 255));
        let torn = made("torn:1", 0).unwrap();
        let row = |frame: &GrayFrame, y: usize| frame.pixels[y * 40..][..40].to_vec();
        assert_eq!((row(&torn, 0), row(&torn, 29)), (row(&frame(3), 0), row(&frame(2), 29)));
        assert_ne!(made("away:2", 1), made("away:2", 2), "gone, and back");
        assert_eq!(made("gain:50", 0).unwrap().pixels[9], frame(3).pixels[9] / 2);
        let shifted = made("origin:12", 0).unwrap();
        assert_eq!((shifted.level(20, 10), shifted.level(0, 0)), (frame(3).level(8, 4), frame(3).level(0, 0)));
        assert!((1..=3 * 30).contains(&changed("columns:3", 0)));
        assert_eq!(made("columns:3", 0), made("columns:3", 5), "stuck ones stay the same");
        assert!((60..240).contains(&changed("bits:100", 0)), "{}", changed("bits:100", 0));
        assert_ne!(made("bits:100", 0), made("bits:100", 1));
        assert_eq!(made("noise:9", 4), made("noise:9", 4), "always the same");
    }

    #[test]
    fn light_is_what_it_is_called() {
        type Expected = fn(f64) -> f64;
        for (fault, index, expected) in [
            ("light:20", 0, (|level| level / 5.0) as Expected),
            ("night:200", 0, |level| 2.0 * level),
            ("dusk:20", 49, |level| 0.6 * level),
            ("dusk:20", 120, |level| level / 5.0),
            ("fog:20", 0, |level| 110.0 + (level - 110.0) / 5.0),
            ("gamma:50", 0, |level| (level * 255.0).sqrt()),
            ("offset:60", 0, |level| level + 60.0),
        ] {
            for (was, is) in frame(3).pixels.into_iter().zip(made(fault, index).unwrap().pixels) {
                assert!((f64::from(is) - expected(was.into()).min(255.0)).abs() < 5.0, "{fault}: {was} {is}");
            }
        }
    }

    #[test]
    fn noise_has_its_deviation() {
        let mut random = Random(5);
        let sum: i64 = (0..10_000).map(|_| normal(&mut random, 100).pow(2)).sum();
        assert!((9_000..11_000).contains(&(sum / 10_000)), "{sum}");
    }

    #[test]
    fn what_is_typed_is_what_is_printed() {
        for (list, length, first) in [("all", 12, "dropped:5"), ("light", 8, "light:20"), ("away", 1, "away:40")] {
            let Faults::List(faults) = list.parse().unwrap() else { panic!("{list}") };
            assert_eq!((faults.len(), &faults[0].to_string()[..]), (length, first));
            assert!(
                faults.iter().all(|fault| fault.frames() > 0 && fault.to_string().parse::<Fault>().unwrap() == *fault)
            );
        }
        for refused in ["", "torn", "torn:0", "torn:x", "melted:3", "bits:1001", "gap:10000", "gain:-1"] {
            assert!(refused.parse::<Faults>().is_err(), "{refused}");
        }
    }
}
