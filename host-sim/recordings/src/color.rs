//! Adds colors to the gray frames of a recording.

use crate::frame::{Frame, Moment};
use crate::resize::resized;
use crate::sequence::Sequence;
use crate::source::Colors;
use std::time::Duration;

impl Sequence {
    /// Adds to each frame its colors, in the size of the gray frame, and its presentation time. If the colors cannot be
    /// read, the gray levels take their place.
    pub fn in_color(self, patience: Duration) -> Self {
        let mut colors = self.source.color_from(self.first, u16::MAX, patience);
        let frames = self.frames.map(move |frame| Ok(colored(frame?, &mut colors)));
        Self { frames: Box::new(frames), ..self }
    }
}

fn colored(frame: Frame, colors: &mut Colors) -> Frame {
    let (width, height) = (frame.gray.width, frame.gray.height);
    #[allow(clippy::cast_possible_truncation)] // it saturates
    let micros = (frame.seconds.unwrap_or(0.0) * 1e6) as i64;
    let of_live = Moment { time: micros, base: (1, 1_000_000), aspect: (1, 1) };
    let own = frame.planes.as_ref().map(|planes| (planes.color(), Some(of_live)));
    let Some((color, moment)) = own.or_else(|| colors.next()) else {
        return Frame { color: Some((&frame.gray).into()), ..frame };
    };
    let stretch = (f64::from(color.width) / f64::from(width)) / (f64::from(color.height) / f64::from(height));
    let moment = moment.map(|moment| Moment { aspect: stretched(moment.aspect, stretch), ..moment });
    Frame { color: Some(resized(color, width, height)), moment, ..frame }
}

/// Multiplies a pixel's aspect ratio, `width` to `height`, by `by`, so that an unevenly scaled image keeps its shape.
fn stretched((width, height): (u32, u32), by: f64) -> (u32, u32) {
    if (by - 1.0).abs() < 0.01 {
        // Ignores a difference below 1 %, which comes from rounding when an odd side is halved.
        return (width, height);
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive, and it saturates
    let thousandths = (f64::from(width) / f64::from(height) * by * 1000.0).round() as u32;
    (thousandths.max(1), 1000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::images::ImageFile;
    use crate::raster::{ColorFrame, GrayFrame};
    use crate::source::Source;

    #[test]
    fn images_keep_their_colors_and_get_the_size_of_the_gray_ones() {
        let folder = tempfile::tempdir().unwrap();
        let file = |number: u8| {
            let file = folder.path().join(format!("{number}.ppm"));
            std::fs::write(&file, [b"P6 4 2 255\n".as_slice(), &[number, 200, 3].repeat(8)].concat()).unwrap();
            file
        };
        let source = Source::Images([file(1), file(2)].map(ImageFile::from).to_vec());
        let mut colors = source.color_from(2, u16::MAX, Duration::ZERO);
        let gray = GrayFrame { width: 2, height: 1, pixels: vec![0; 2] };
        let mut next = || colored(Frame::new(1, None, gray.clone()), &mut colors).color.unwrap();
        assert_eq!(next(), ColorFrame { width: 2, height: 1, pixels: vec![[2, 200, 3]; 2] });
        assert_eq!(next().pixels, [[0; 3]; 2]);
        for (aspect, by, expected) in [((1, 1), 1.0, (1, 1)), ((12, 11), 1.005, (12, 11)), ((1, 1), 2.0, (2000, 1000))]
        {
            assert_eq!(stretched(aspect, by), expected);
        }
    }
}
