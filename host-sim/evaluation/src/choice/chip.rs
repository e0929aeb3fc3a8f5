//! The chips of `eval --chip`, and the time that a tracker's work takes on them.

use super::candidate::Tracker;
use anyhow::{Context, Error, Result, bail};
use std::str::FromStr;

/// Estimated cycles in millions, for each processor: the rows `cycles` of `tests/results/chips.json`, measured on the
/// first 30 frames of `street`. Then the ratios of instructions to those of the Cortex-M4. `SMR_RECORD=1 cargo test -p smr-tests --test crates figures` writes the file.
pub const CYCLES: &str = include_str!("cycles.txt");

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    CortexM0Plus,
    CortexM4,
    CortexM7,
    CortexM55,
    CortexM85,
    /// RISC-V of 32 or 64 bits, without vectors.
    RiscV,
    Xtensa,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    pub name: &'static str,
    pub processor: Processor,
    pub clock_mhz: u32,
    /// RAM on the chip in units of 1024 bytes.
    pub ram_kb: u32,
}

/// All chips by their names on the command line. Clock and RAM are those of the data sheets.
pub const CHIPS: &[Chip] = {
    use Processor::{CortexM0Plus, CortexM4, CortexM7, CortexM55, CortexM85, RiscV, Xtensa};
    const fn chip(name: &'static str, processor: Processor, clock_mhz: u32, ram_kb: u32) -> Chip {
        Chip { name, processor, clock_mhz, ram_kb }
    }
    &[
        chip("rp2040", CortexM0Plus, 133, 264),
        chip("rp2350", CortexM4, 150, 520),
        chip("rp2350-riscv", RiscV, 150, 520),
        chip("esp32", Xtensa, 240, 520),
        chip("esp32-s2", Xtensa, 240, 320),
        chip("esp32-s3", Xtensa, 240, 512),
        chip("esp32-c3", RiscV, 160, 400),
        chip("esp32-c6", RiscV, 160, 512),
        chip("esp32-p4", RiscV, 360, 768),
        chip("stm32f405", CortexM4, 168, 192),
        chip("stm32f407", CortexM4, 168, 192),
        chip("stm32h743", CortexM7, 480, 1024),
        chip("stm32h747", CortexM7, 480, 1024),
        chip("stm32n657", CortexM55, 800, 4300),
        chip("nrf52840", CortexM4, 64, 256),
        chip("nrf5340", CortexM4, 128, 512),
        chip("ra4m1", CortexM4, 48, 32),
        chip("ra8d1", CortexM85, 480, 1024),
        chip("imxrt1062", CortexM7, 600, 1024),
        chip("ensemble-e3", CortexM55, 400, 13_824),
        chip("himax-we2", CortexM55, 400, 2457),
        chip("max78000", CortexM4, 100, 128),
        chip("cxd5602", CortexM4, 156, 1536),
        chip("k210", RiscV, 400, 8192),
        chip("bl808", RiscV, 480, 768),
    ]
};

/// The chip, and the frames a second that it must reach.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    pub chip: Chip,
    pub fps: u16,
}

impl Chip {
    /// RAM on the chip in bytes.
    pub const fn ram(self) -> usize {
        self.ram_kb as usize * 1024
    }
}

/// Returns the letters and digits of the name of a chip, in small letters: `ESP32-S3` is `esp32s3`.
fn letters(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_lowercase()).collect()
}

impl FromStr for Chip {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let found = CHIPS.iter().find(|chip| letters(chip.name) == letters(text)).copied();
        let names = || CHIPS.iter().map(|chip| chip.name).collect::<Vec<_>>().join(", ");
        found.with_context(|| format!("expected one of {}", names()))
    }
}

impl Processor {
    pub const fn name(self) -> &'static str {
        match self {
            Self::CortexM0Plus => "Cortex-M0+",
            Self::CortexM4 => "Cortex-M4 or M33",
            Self::CortexM7 => "Cortex-M7",
            Self::CortexM55 => "Cortex-M55",
            Self::CortexM85 => "Cortex-M85",
            Self::RiscV => "RISC-V",
            Self::Xtensa => "Xtensa",
        }
    }

    /// True if the processor's cycles are those of the Cortex-M4 times a ratio of instructions.
    pub const fn is_compared(self) -> bool {
        matches!(self, Self::RiscV | Self::Xtensa)
    }

    /// The column of `CYCLES`.
    const fn column(self) -> usize {
        match self {
            Self::CortexM0Plus => 0,
            Self::CortexM4 | Self::RiscV | Self::Xtensa => 1,
            Self::CortexM7 => 2,
            Self::CortexM55 => 3,
            Self::CortexM85 => 4,
        }
    }

    /// Returns the instructions of an update, as a multiple of the Cortex-M4's.
    fn ratio(self, tracker: Tracker) -> Result<f64> {
        let name = match self {
            Self::RiscV => "riscv",
            Self::Xtensa => "xtensa",
            _ => return Ok(1.0),
        };
        let row = CYCLES.lines().find_map(|row| row.strip_prefix(name)?.strip_prefix(" | "));
        let ratio = row.and_then(|row| row.split("; ").nth(tracker as usize));
        Ok(ratio.context("no ratio of this processor")?.parse()?)
    }

    /// Returns the cycles of the median update, and of the most expensive one, on the first frames of `street`.
    pub fn cycles(self, tracker: Tracker) -> Result<[f64; 2]> {
        let name = match tracker {
            Tracker::Paper => "paper's, update",
            Tracker::Robust => "robust, update",
            Tracker::Refined => "robust with refiner, update",
        };
        let row = CYCLES.lines().find(|row| row.starts_with(name)).context("no cycles of this tracker")?;
        let cell = row.split(" | ").nth(1 + self.column()).context("no cycles of this processor")?;
        let millions: Vec<f64> = cell.split("; ").map(str::parse).collect::<Result<_, _>>()?;
        let [median, most] = millions[..] else { bail!("{cell}: expected two numbers of cycles") };
        let ratio = self.ratio(tracker)?;
        Ok([median, most].map(|millions| millions * 1e6 * ratio))
    }

    /// Returns the cycles of a unit of the tracker's work, in the median update on `street` and in the most expensive one.
    fn rates(self, tracker: Tracker) -> Result<[f64; 2]> {
        let [[cycles, most_cycles], [work, most_work]] = [self.cycles(tracker)?, tracker.work_on_street()];
        Ok([cycles / work, most_cycles / most_work])
    }

    /// Returns the larger of the two rates, so that the estimate errs on the safe side.
    pub fn cycles_per_work(self, tracker: Tracker) -> Result<f64> {
        self.rates(tracker).map(|[median, most]| median.max(most))
    }
}

impl Tracker {
    /// Work of the median update, and of the most expensive one, in the frames in which `CYCLES` was measured.
    const fn work_on_street(self) -> [f64; 2] {
        match self {
            Self::Paper => [64_665.0, 90_870.0],
            Self::Robust => [2_862_886.0, 3_063_857.0],
            Self::Refined => [3_366_206.0, 3_366_595.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Candidate;
    use super::*;
    use crate::{Follower, Run, Variant};
    use smr_recordings::{OpenOptions, street};
    use std::path::Path;

    #[test]
    fn a_chip_is_found_by_its_letters_and_digits() {
        assert_eq!("ESP32S3".parse::<Chip>().unwrap().name, "esp32-s3");
        assert_eq!("i.MX RT1062".parse::<Chip>().unwrap().name, "imxrt1062");
        for wrong in ["", "esp", "stm32", "stm32h743x"] {
            let error = wrong.parse::<Chip>().unwrap_err().to_string();
            assert!(error.starts_with("expected one of rp2040, rp2350,") && !error.contains('\n'), "{error}");
        }
    }

    /// Frames of `street` in the measurement of cycles.
    const FRAMES: usize = 30;

    fn work_on_street(variant: &Variant) -> [f64; 2] {
        let sequence = smr_recordings::open(Path::new(street::NAME), &OpenOptions::default()).unwrap();
        let start = sequence.start().unwrap();
        let mut follower = Follower::new(variant.build().unwrap(), vec![(1, Some(start))]);
        let mut run = Run::default();
        for (place, frame) in sequence.frames.take(FRAMES).enumerate() {
            run.add(&mut follower, place, &frame.unwrap().gray).unwrap();
        }
        let mut work: Vec<u32> = run.updates().iter().filter_map(|report| report.work).collect();
        work.sort_unstable();
        [work[work.len() / 2], work[work.len() - 1]].map(f64::from)
    }

    /// The bounds are those in the help of `eval --chip`.
    #[test]
    fn cycles_grow_with_the_work() {
        for candidate in Candidate::all().iter().filter(|candidate| candidate.is_measured_on_chips()) {
            let tracker = candidate.tracker;
            assert_eq!(work_on_street(&candidate.variant), tracker.work_on_street(), "{tracker:?}");
            for chip in CHIPS {
                let [median, most] = chip.processor.rates(tracker).unwrap();
                let bound = if tracker == Tracker::Paper { 1.8 } else { 1.08 };
                let ratio = f64::max(median / most, most / median);
                assert!(ratio < bound, "{tracker:?} on {}: {median} and {most}", chip.name);
            }
        }
    }
}
