//! [`Error`], which wraps any error of this crate.

use crate::image::readout::ReadoutError;
use crate::image::{FrameError, ImageError, WindowError};
use crate::track::{ConfigError, LockError, RestoreError, SaveError, UpdateError};

macro_rules! any {
    ($($name:ident($error:ident): $of:literal,)+) => {
        errors! {
            /// Any error of this crate, for functions that make several calls with `?`.
            ///
            /// ```
            /// use smr_core::{Answer, Error, Frame, Image, Rect, Robust, Tracker};
            ///
            /// fn locked(tracker: &mut Tracker<Robust>, pixels: &[u8]) -> Result<Answer, Error> {
            ///     let frame = Frame::whole(Image::new(pixels, 64, 48)?);
            ///     tracker.lock(&frame, Rect::new(20, 10, 16, 16))?;
            ///     Ok(tracker.update(&frame)?)
            /// }
            ///
            /// let error = locked(&mut Tracker::<Robust>::new(), &[0; 100]).unwrap_err();
            /// assert_eq!(error, Error::Image(smr_core::ImageError::SliceTooShort));
            /// ```
            Error { $(#[doc = $of] $name(error: $error) => "{error}",)+ }
        }

        $(impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::$name(error)
            }
        })+
    };
}

any! {
    Image(ImageError): "An image was refused.",
    Frame(FrameError): "A part of a frame was refused.",
    Readout(ReadoutError): "A line or a frame of the camera was refused.",
    Config(ConfigError): "A configuration was refused.",
    Lock(LockError): "A box was not locked.",
    Update(UpdateError): "A frame was not searched.",
    Save(SaveError): "A target was not saved.",
    Restore(RestoreError): "A saved target was refused.",
}

impl From<WindowError> for Error {
    fn from(error: WindowError) -> Self {
        match error {
            WindowError::Image(error) => Self::Image(error),
            WindowError::Frame(error) => Self::Frame(error),
        }
    }
}
