//! The plain data that crosses the boundary, and what each is in `smr-core`.

use crate::pointer;
use crate::status::{smr_status, status_of};
use crate::table::{self, smr_table};
use core::ffi::{CStr, c_char};
use smr_core::search::Peak;
use smr_core::similarity::Backend;
use smr_core::{Answer, Config, Fraction, Frame, Gate, Image, Margins, Radius, Rect, RunnerUp, State};

/// Version of this header, major.minor.patch: a program can compare it with #smr_version.
pub const SMR_VERSION_MAJOR: u32 = 0;
/// See #SMR_VERSION_MAJOR.
pub const SMR_VERSION_MINOR: u32 = 1;
/// See #SMR_VERSION_MAJOR.
pub const SMR_VERSION_PATCH: u32 = 0;

/// The version of the library that is linked, as "major.minor.patch".
///
/// @return  A string that is always there, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn smr_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// numerator / denominator; the denominator is at least 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_fraction {
    /// What stands above the line.
    pub numerator: u16,
    /// What stands below the line; at least 1.
    pub denominator: u16,
}

/// How far the search window reaches to each side of the last position, in pixels: offsets -x..x and -y..y.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_radius {
    /// To the left and to the right.
    pub x: u16,
    /// Up and down.
    pub y: u16,
}

/// How many pixels a box keeps from each edge of the picture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_margins {
    /// Columns to the left of the box.
    pub left: u16,
    /// Rows above it.
    pub top: u16,
    /// Columns to the right of it.
    pub right: u16,
    /// Rows below it.
    pub bottom: u16,
}

/// A rectangle in whole pixels of the full frame. It may reach outside the frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_rect {
    /// Left edge, in pixels to the right of the frame's left edge; may be negative.
    pub x: i32,
    /// Top edge, in pixels below the frame's top edge; may be negative.
    pub y: i32,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

/// How clearly the peak must stand above the runner-up before a frame is believed.
///
/// The first four are ratios of the two scores that the peak must exceed. A ratio below 1 demands nothing of a peak that
/// scores at all.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_gate {
    /// While the target stays inside the picture.
    pub tracking: smr_fraction,
    /// When the box at the peak is partly outside the picture.
    pub leaving: smr_fraction,
    /// When the box at the peak is inside, but one has not been before: until a lost target is found again.
    pub returning: smr_fraction,
    /// To be found again when lost, wherever that is.
    pub lost: smr_fraction,
    /// The other way to be believed, in every state: the peak is more than this many fully similar pixels above the
    /// runner-up.
    pub lead: u16,
    /// The least similarity matching ratio of the peak, in units of 1/65535; below it no frame is believed. 0 demands
    /// nothing, which is the paper's.
    pub least_ratio: u16,
}

/// The numbers of the method. Fill it with #smr_config_camera (or #smr_config_paper) first, then change what is to be changed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_config {
    /// The similarity of two pixels by their difference, or NULL for the paper's, exp(-d / 255). A table given here is
    /// not copied: see #smr_table_init.
    pub table: *const smr_table,
    /// k in alpha = k * (largest change of a pixel of the template); more than 0.
    pub k: smr_fraction,
    /// alpha before the first update, in gray levels: a pixel counts if its difference is below it. At least 1.
    pub first_threshold: u8,
    /// The least alpha after an update, in gray levels. 0 and 1 are the same, and the paper's: after a still scene a slight
    /// change of light then leaves no pixel that counts.
    pub least_threshold: u8,
    /// Width of the virtual border of zeroes around the frame, in pixels: how far a box may leave the picture.
    pub padding: u16,
    /// The search window around the last position.
    pub window: smr_radius,
    /// How many pixels the window grows on each side, for each frame that the target stays lost.
    pub growth: u16,
    /// Where that growth ends; at least `window`. On each axis 2 * limit + 1 offsets must fit #SMR_SPAN, unless the
    /// padded frame is smaller than that.
    pub window_limit: smr_radius,
    /// The runner-up is the best score more than this many pixels away from the peak, in x or in y.
    pub neighbourhood: u16,
    /// What a box keeps from the edges of the picture for its patch to become the template.
    pub update_zone: smr_margins,
    /// When a frame is believed.
    pub gate: smr_gate,
    /// 0: the fastest way that the processor has. Else: the plain loop, which loads single bytes; a frame in Device memory
    /// (external RAM before the MPU makes it Normal) needs it, as unaligned loads of words fault there. It changes no answer.
    pub plain_loop: u8,
    /// 0: the runner-up is looked for when the gate's decision depends on it. Else: in every frame, which multiplies the
    /// time.
    pub runner_up_always: u8,
}

/// One frame of the camera: 8-bit gray pixels, the part of it that is in memory, and where in the full frame that is.
///
/// A frame that is in memory as a whole has x = y = 0, full_width = width and full_height = height.
/// Pixels are only read, and only during the call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_frame {
    /// The top left pixel in memory.
    pub pixels: *const u8,
    /// Bytes that may be read from `pixels` on: at least (height - 1) * stride + width.
    pub size: usize,
    /// Bytes from a pixel to the one below it: at least `width`.
    pub stride: usize,
    /// Pixels of a row in memory; at least 1.
    pub width: u16,
    /// Rows in memory; at least 1.
    pub height: u16,
    /// Where the part in memory begins: column of the full frame.
    pub x: u16,
    /// Where the part in memory begins: row of the full frame.
    pub y: u16,
    /// Width of the full frame; at least x + width.
    pub full_width: u16,
    /// Height of the full frame; at least y + height.
    pub full_height: u16,
}

/// What the tracker holds of its target after a frame.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum smr_state {
    /// The target was found inside the picture. Its patch is the new template if it lies in `update_zone` of #smr_config.
    SMR_TRACKING = 0,
    /// The target was found, partly outside the picture; the template is kept.
    SMR_LEAVING = 1,
    /// The peak did not stand out as the gate demands. The box is the last one that was believed, template and alpha are
    /// kept, and the window grows with every further frame.
    SMR_LOST = 2,
}

/// A position of the template's top left corner in the frame, and its score.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_peak {
    /// Left edge of the box, in the frame.
    pub x: i32,
    /// Top edge of the box, in the frame.
    pub y: i32,
    /// The sum of the similarities, in units of 1/65535 of a fully similar pixel.
    pub score: u32,
}

/// The answer of #smr_update. Ratios are in units of 1/65535, so 65535 is 1.0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_answer {
    /// The target's box; when lost, the last one that was believed.
    pub bbox: smr_rect,
    /// Whether the box is to be believed.
    pub state: smr_state,
    /// The similarity matching ratio: the peak's score over the number of pixels, rounded down.
    pub ratio: u16,
    /// The same of the runner-up; 0 if the window does not reach beyond the peak's neighbourhood, or if there is none.
    pub runner_up_ratio: u16,
    /// The threshold that this frame was scored with, in gray levels (0..256): alpha, rounded up. A pixel counted if it
    /// differed by less.
    pub alpha: u16,
    /// The best offset, believed or not.
    pub peak: smr_peak,
    /// The runner-up's score, in the peak's unit; 0 if there is none.
    pub runner_up: u32,
    /// 1 if the runner-up was looked for, 0 if nothing depended on it: see `runner_up_always` in #smr_config.
    pub has_runner_up: u8,
}

/// 8-bit gray pixels, row by row without a gap.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct smr_image {
    /// width * height bytes.
    pub pixels: *const u8,
    /// Pixels of a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
}

/// Fills a configuration with the values for cameras: the paper's with a bounded window, so that time and memory are, too.
///
/// Beside #smr_config_paper the window of a lost target grows by at most 20 pixels on each side (an #SMR_SPAN of 161 holds
/// it), the template is updated up to the edge of the picture, a peak inside the picture need not exceed the runner-up, alpha
/// is at least 10 gray levels, and a peak of less than a twentieth of what is possible is not believed.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_camera(config: *mut smr_config) -> smr_status {
    // SAFETY: the caller gives memory for an smr_config.
    let out = unsafe { pointer::Out::new(config) };
    status_of(out.map(|out| out.write(Config::camera().into())))
}

/// Fills a configuration with the values of the paper and its authors' program, for frames of about 320x240.
///
/// The window of a lost target grows until it is the padded frame: #SMR_SPAN must be at least frame + 40 - box + 1 on each
/// axis, or #smr_lock answers #SMR_ERROR_WINDOW_TOO_LARGE. For firmware see #smr_config_camera.
///
/// @param config  Memory for the configuration.
/// @return        #SMR_OK, #SMR_ERROR_NULL or #SMR_ERROR_MISALIGNED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_config_paper(config: *mut smr_config) -> smr_status {
    // SAFETY: the caller gives memory for an smr_config.
    let out = unsafe { pointer::Out::new(config) };
    status_of(out.map(|out| out.write(Config::paper().into())))
}

/// With the library's own table: another one has no address that C could give.
impl From<Config> for smr_config {
    fn from(config: Config) -> Self {
        Self {
            table: core::ptr::null(),
            k: config.k.into(),
            first_threshold: config.first_threshold,
            least_threshold: config.least_threshold,
            padding: config.padding,
            window: config.window.into(),
            growth: config.growth,
            window_limit: config.window_limit.into(),
            neighbourhood: config.neighbourhood,
            update_zone: config.update_zone.into(),
            gate: config.gate.into(),
            plain_loop: (config.backend == Some(Backend::Scalar)).into(),
            runner_up_always: (config.runner_up == RunnerUp::Always).into(),
        }
    }
}

impl smr_config {
    /// # Safety
    /// As for [`table::given`], of `self.table`.
    pub(crate) unsafe fn config(&self) -> Result<Config, smr_status> {
        let mut config = Config::paper();
        // SAFETY: as the caller says.
        config.table = unsafe { table::given(self.table)? };
        config.k = self.k.into();
        config.first_threshold = self.first_threshold;
        config.least_threshold = self.least_threshold;
        config.padding = self.padding;
        config.window = self.window.into();
        config.growth = self.growth;
        config.window_limit = self.window_limit.into();
        config.neighbourhood = self.neighbourhood;
        config.update_zone = self.update_zone.into();
        config.gate = self.gate.into();
        config.backend = (self.plain_loop != 0).then_some(Backend::Scalar);
        config.runner_up = if self.runner_up_always == 0 { RunnerUp::WhenItDecides } else { RunnerUp::Always };
        Ok(config)
    }
}

impl smr_frame {
    /// What it says, for a call on the tracker in the `size` bytes from the address `storage` on: pixels in there would
    /// change while they are read.
    ///
    /// # Safety
    /// If `pixels` is not NULL, `size` bytes from there can be read, and nobody writes them as long as the result lives.
    pub(crate) unsafe fn frame<'a>(&self, storage: usize, size: usize) -> Result<Frame<'a>, smr_status> {
        pointer::check(self.pixels)?;
        if isize::try_from(self.size).is_err() {
            return Err(smr_status::SMR_ERROR_FRAME_TOO_LARGE);
        }
        let pixels = self.pixels.addr();
        if pixels < storage.saturating_add(size) && storage < pixels.saturating_add(self.size) {
            return Err(smr_status::SMR_ERROR_FRAME_OVERLAPS_TRACKER);
        }
        // SAFETY: not NULL, bytes are always aligned, no longer than isize::MAX; the rest as the caller says.
        let pixels = unsafe { core::slice::from_raw_parts(self.pixels, self.size) };
        let image = Image::with_stride(pixels, self.width, self.height, self.stride)?;
        Ok(Frame::part(image, self.x, self.y, self.full_width, self.full_height)?)
    }
}

impl From<Fraction> for smr_fraction {
    fn from(fraction: Fraction) -> Self {
        Self { numerator: fraction.numerator, denominator: fraction.denominator }
    }
}

impl From<smr_fraction> for Fraction {
    fn from(fraction: smr_fraction) -> Self {
        Self { numerator: fraction.numerator, denominator: fraction.denominator }
    }
}

impl From<Radius> for smr_radius {
    fn from(radius: Radius) -> Self {
        Self { x: radius.x, y: radius.y }
    }
}

impl From<smr_radius> for Radius {
    fn from(radius: smr_radius) -> Self {
        Self { x: radius.x, y: radius.y }
    }
}

impl From<Margins> for smr_margins {
    fn from(margins: Margins) -> Self {
        let Margins { left, top, right, bottom } = margins;
        Self { left, top, right, bottom }
    }
}

impl From<smr_margins> for Margins {
    fn from(margins: smr_margins) -> Self {
        let smr_margins { left, top, right, bottom } = margins;
        Self { left, top, right, bottom }
    }
}

impl From<Rect> for smr_rect {
    fn from(rect: Rect) -> Self {
        Self { x: rect.x, y: rect.y, width: rect.width, height: rect.height }
    }
}

impl From<smr_rect> for Rect {
    fn from(rect: smr_rect) -> Self {
        Self { x: rect.x, y: rect.y, width: rect.width, height: rect.height }
    }
}

impl From<Gate> for smr_gate {
    fn from(gate: Gate) -> Self {
        Self {
            tracking: gate.tracking.into(),
            leaving: gate.leaving.into(),
            returning: gate.returning.into(),
            lost: gate.lost.into(),
            lead: gate.lead,
            least_ratio: gate.least_ratio,
        }
    }
}

impl From<smr_gate> for Gate {
    fn from(gate: smr_gate) -> Self {
        Self {
            tracking: gate.tracking.into(),
            leaving: gate.leaving.into(),
            returning: gate.returning.into(),
            lost: gate.lost.into(),
            lead: gate.lead,
            least_ratio: gate.least_ratio,
        }
    }
}

impl From<State> for smr_state {
    fn from(state: State) -> Self {
        match state {
            State::Tracking => Self::SMR_TRACKING,
            State::Leaving => Self::SMR_LEAVING,
            State::Lost => Self::SMR_LOST,
        }
    }
}

impl From<Peak> for smr_peak {
    fn from(peak: Peak) -> Self {
        Self { x: peak.x, y: peak.y, score: peak.score }
    }
}

impl From<Answer> for smr_answer {
    fn from(answer: Answer) -> Self {
        Self {
            bbox: answer.bbox.into(),
            state: answer.state.into(),
            ratio: answer.ratio,
            runner_up_ratio: answer.runner_up_ratio.unwrap_or(0),
            alpha: answer.alpha,
            peak: answer.found.peak.into(),
            runner_up: answer.found.runner_up.unwrap_or(0),
            has_runner_up: answer.found.runner_up.is_some().into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn a_configuration_comes_back_as_it_was() {
        let paper = format!("{:?}", Config::paper());
        for config in [Config::paper(), Config::camera()] {
            // SAFETY: no table is given.
            let back = unsafe { smr_config::from(config).config() }.unwrap();
            assert_eq!(format!("{back:?}"), format!("{config:?}"));
        }
        // A number that `Config` gains would come back by itself, from `Config::paper`, without C being able to set it.
        // Only pruning is left to the library, and which backend but the plain loop: they change no answer.
        let (_, numbers) = paper.split_once("] }").expect("the table stands first");
        assert_eq!(
            numbers.matches(": ").count(),
            37,
            "has Config a new number? Then smr_config needs it too: {numbers}"
        );
    }

    #[test]
    fn every_number_of_the_configuration_goes_to_its_place() {
        // In the order in which `Config` declares them, and prints them: the fields of a literal are evaluated as written.
        let mut numbers = 1..;
        let next = &mut || numbers.next().unwrap();
        fn fraction(next: &mut dyn FnMut() -> u16) -> smr_fraction {
            smr_fraction { numerator: next(), denominator: next() }
        }
        fn radius(next: &mut dyn FnMut() -> u16) -> smr_radius {
            smr_radius { x: next(), y: next() }
        }
        fn margins(next: &mut dyn FnMut() -> u16) -> smr_margins {
            smr_margins { left: next(), top: next(), right: next(), bottom: next() }
        }
        let config = smr_config {
            table: core::ptr::null(),
            k: fraction(next),
            first_threshold: u8::try_from(next()).unwrap(),
            least_threshold: u8::try_from(next()).unwrap(),
            padding: next(),
            window: radius(next),
            growth: next(),
            window_limit: radius(next),
            neighbourhood: next(),
            update_zone: margins(next),
            gate: smr_gate {
                tracking: fraction(next),
                leaving: fraction(next),
                returning: fraction(next),
                lost: fraction(next),
                lead: next(),
                least_ratio: next(),
            },
            plain_loop: 0,
            runner_up_always: 1,
        };
        // SAFETY: no table is given.
        let printed = format!("{:?}", unsafe { config.config() }.unwrap());
        let (_, printed) = printed.split_once("] }").expect("the table stands first");
        let words = printed.split(|character: char| !character.is_ascii_digit());
        let printed: std::vec::Vec<u16> = words.filter_map(|word| word.parse().ok()).collect();
        assert!(format!("{:?}", unsafe { config.config() }.unwrap()).contains("runner_up: Always"));
        assert_eq!(printed, (1..=25).collect::<std::vec::Vec<_>>());
    }

    #[test]
    fn the_version_is_the_packages() {
        let version = format!("{SMR_VERSION_MAJOR}.{SMR_VERSION_MINOR}.{SMR_VERSION_PATCH}");
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        // SAFETY: a static string, as its documentation says.
        assert_eq!(unsafe { CStr::from_ptr(smr_version()) }.to_bytes(), version.as_bytes());
    }
}
