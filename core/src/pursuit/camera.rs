//! The camera model: converts positions in the picture to angles, and camera rotations to motion of the picture.

use super::error::{PursuitConfigError, first_broken};
use crate::FineRect;
use core::f32::consts::FRAC_PI_2;
use micromath::F32;

/// A pinhole camera with square pixels.
///
/// angle = atan((x - principal_x) / focal_length), positive to the right. The angle is off by at most 0.000012 radians,
/// and near the axis by at most 0.014 %: 0.002 pixels at a focal length of 160 pixels.
///
/// Three ways to get the focal length in pixels:
/// - focal length in mm / width of a pixel in mm;
/// - measured: n * d / w, if an object of width w at distance d covers n pixels;
/// - from the horizontal angle of view in the data sheet: (width / 2) / tan(angle / 2).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Camera {
    /// Focal length in pixels; at least 1.
    pub focal_length_pixels: f32,
    /// The principal point (where the optical axis meets the picture), in pixels from the left edge.
    pub principal_x_pixels: f32,
    /// The principal point in pixels from the top edge.
    pub principal_y_pixels: f32,
}

impl Camera {
    /// A camera with the principal point in the centre of its frames of `width` x `height` pixels.
    #[must_use]
    pub fn centred(focal_length_pixels: f32, width: u16, height: u16) -> Self {
        Self {
            focal_length_pixels,
            principal_x_pixels: f32::from(width) / 2.0,
            principal_y_pixels: f32::from(height) / 2.0,
        }
    }

    /// The angles right and up from the optical axis to the centre of `target`, in radians: right from x alone, up from
    /// y. At a tilt of t, a pan moves the picture only cos(t) times as far as at tilt 0, so panning takes longer.
    pub(super) fn error_radians(&self, target: FineRect) -> (f32, f32) {
        let x = middle(target.x, target.width) - self.principal_x_pixels;
        let y = middle(target.y, target.height) - self.principal_y_pixels;
        (self.angle_radians(x), self.angle_radians(-y))
    }

    /// The estimated motion of the picture right and down, in units of 1/256 pixel, for a turn of the camera right and
    /// up. The estimate is good near the optical axis and a little too small farther out. It ignores the tilt of the
    /// camera, so for a pan it is too large by a factor of 1 / cos(tilt).
    #[allow(clippy::cast_possible_truncation)] // the cast saturates; NaN becomes 0
    pub(super) fn picture_motion(&self, right_radians: f32, up_radians: f32) -> (i32, i32) {
        // Rounded, because a cast cuts off toward 0: the error would add up from call to call.
        let units = |radians: f32| F32(256.0 * self.focal_length_pixels * radians).round().0 as i32;
        (units(-right_radians), units(up_radians))
    }

    fn angle_radians(&self, offset_pixels: f32) -> f32 {
        arctangent(offset_pixels / self.focal_length_pixels)
    }

    pub(super) fn check(&self) -> Result<(), PursuitConfigError> {
        let numbers = [self.focal_length_pixels, self.principal_x_pixels, self.principal_y_pixels];
        first_broken([
            (numbers.iter().all(|number| number.is_finite()), PursuitConfigError::NotFinite),
            (self.focal_length_pixels >= 1.0, PursuitConfigError::FocalLengthTooShort),
        ])
    }
}

/// The angle in radians whose tangent is `slope`, -pi/2 to pi/2, off by at most 0.000012. `core` has no such function.
///
/// The series is formula 4.4.47 of Abramowitz and Stegun, "Handbook of Mathematical Functions", for slopes up to 1.
pub(super) fn arctangent(slope: f32) -> f32 {
    const SERIES: [f32; 5] = [0.020_835_1, -0.085_133, 0.180_141, -0.330_299_5, 0.999_866];
    let size = slope.abs();
    let is_steep = size > 1.0;
    let x = if is_steep { 1.0 / size } else { size };
    let angle = x * SERIES.iter().fold(0.0, |sum, factor| sum * (x * x) + factor);
    (if is_steep { FRAC_PI_2 - angle } else { angle }).copysign(slope)
}

/// The centre of `first..first + size` (units of 1/256 pixel), in pixels.
fn middle(first: i32, size: u32) -> f32 {
    (first as f32 + size as f32 / 2.0) / 256.0
}
