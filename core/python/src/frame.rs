//! Reads a numpy array as a frame: contiguous gray rows in place, other layouts after converting the needed pixels.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use smr_core::{Frame, Image, Rect, Windows};
use smr_files::messages;

/// A borrow of a numpy array while its pixels are read.
pub struct Borrowed<'py>(PyReadonlyArrayDyn<'py, u8>);

/// The pixels of an array, with numpy's shape and strides (which may be negative).
#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    /// The bytes from the pixel with the lowest address to the one with the highest.
    bytes: &'a [u8],
    /// Index of pixel (0, 0) in `bytes`.
    first: isize,
    row: isize,
    column: isize,
    /// Distance in bytes from blue to green and from green to red; `None` if the pixels are gray.
    color: Option<isize>,
    width: u16,
    height: u16,
}

impl<'py> Borrowed<'py> {
    /// Fails if the array is not `uint8` or has not the shape of a frame.
    pub fn new(array: &Bound<'py, PyAny>) -> PyResult<Self> {
        const EXPECTED: &str = "expected a numpy array of uint8, gray (height, width) or BGR (height, width, 3)";
        let Ok(untyped) = array.cast::<PyUntypedArray>() else {
            return Err(PyTypeError::new_err(format!("frame: {EXPECTED}, found {}", array.get_type().name()?)));
        };
        let found = || format!("frame: {EXPECTED}, found {} of shape {:?}", untyped.dtype(), untyped.shape());
        let Ok(bytes) = array.cast::<PyArrayDyn<u8>>() else { return Err(PyTypeError::new_err(found())) };
        if !matches!(untyped.shape(), [_, _] | [_, _, 1 | 3]) {
            return Err(PyValueError::new_err(found()));
        }
        if !untyped.shape()[..2].iter().all(|side| (1..=usize::from(u16::MAX)).contains(side)) {
            return Err(PyValueError::new_err(format!("{}: each side must be 1 to 65535", found())));
        }
        bytes.try_readonly().map(Self).map_err(|error| PyValueError::new_err(format!("frame: {error}")))
    }

    pub fn pixels(&self) -> Pixels<'_> {
        let (shape, strides) = (self.0.shape(), self.0.strides());
        let ends = shape.iter().zip(strides).map(|(&count, &stride)| (count.cast_signed() - 1) * stride);
        let lowest: isize = ends.clone().map(|end| end.min(0)).sum();
        let highest: isize = ends.map(|end| end.max(0)).sum();
        // SAFETY: all elements (at least one) lie from `lowest` to `highest` around the first; the slice borrows them.
        #[allow(unsafe_code)]
        let bytes =
            unsafe { std::slice::from_raw_parts(self.0.data().offset(lowest), (highest - lowest).cast_unsigned() + 1) };
        let side = |axis: usize| u16::try_from(shape[axis]).unwrap_or(u16::MAX); // checked by `new`
        let color = (shape.get(2) == Some(&3)).then(|| strides[2]);
        Pixels { bytes, first: -lowest, row: strides[0], column: strides[1], color, width: side(1), height: side(0) }
    }
}

impl<'a> Pixels<'a> {
    pub fn bounds(&self) -> Rect {
        Rect::new(0, 0, self.width, self.height)
    }

    /// Returns a frame of the array's size of which only pixel (0, 0) is in memory: enough to check a call's arguments.
    pub fn corner(&self) -> PyResult<Frame<'static>> {
        let pixel = Image::new(&[0], 1, 1).map_err(refused)?;
        Frame::part(pixel, 0, 0, self.width, self.height).map_err(refused)
    }

    /// The frame for a call that reads `windows`. Pixels of an unsuitable layout are converted into `gray`.
    pub fn frame<'b>(&self, windows: [Option<Rect>; 2], gray: &'b mut Vec<u8>) -> PyResult<Frame<'b>>
    where
        'a: 'b,
    {
        if let (None, 1, Ok(stride)) = (self.color, self.column, usize::try_from(self.row))
            && stride >= usize::from(self.width)
        {
            let image = Image::with_stride(self.bytes, self.width, self.height, stride);
            return Ok(Frame::whole(image.map_err(refused)?));
        }
        // If a window is empty or outside the frame, one pixel is enough: the core refuses the call without reading it.
        let inside = |window: &Rect| self.bounds().contains(*window) && !window.is_empty();
        let [first, second] = windows.map(|window| window.filter(inside));
        let first = first.unwrap_or(Rect::new(0, 0, 1, 1));
        gray.clear();
        self.gather(first, gray);
        second.inspect(|window| self.gather(*window, gray));
        Frame::of_windows(gray, Windows::new(first, second), (self.width, self.height)).map_err(refused)
    }

    fn gather(&self, window: Rect, gray: &mut Vec<u8>) {
        for y in window.y..window.bottom() {
            let place = |x: i32| (self.first + y as isize * self.row + x as isize * self.column).cast_unsigned();
            match self.color {
                None => gray.extend((window.x..window.right()).map(|x| self.bytes[place(x)])),
                // Contiguous pixels, as in almost all images.
                Some(1) if self.column == 3 => {
                    let pixels = self.bytes[place(window.x)..place(window.right() - 1) + 3].as_chunks().0;
                    gray.extend(pixels.iter().map(|&bgr| luma(bgr)));
                }
                Some(next) => gray.extend(
                    (window.x..window.right())
                        .map(|x| luma([0, 1, 2].map(|color| self.bytes[place(x).wrapping_add_signed(color * next)]))),
                ),
            }
        }
    }
}

/// A Python ValueError with the message of an error in Rust.
pub fn refused(error: impl Into<anyhow::Error>) -> PyErr {
    PyValueError::new_err(messages::of(&error.into()))
}

/// Converts blue, green and red to gray with the rounding of `cv2.cvtColor`.
fn luma([blue, green, red]: [u8; 3]) -> u8 {
    let sum = 3735 * u32::from(blue) + 19235 * u32::from(green) + 9798 * u32::from(red) + (1 << 14);
    u8::try_from(sum >> 15).unwrap_or(u8::MAX) // the weights add up to 1 << 15
}
