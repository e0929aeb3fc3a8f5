//! Enlarges a part of a frame by a whole number, smoothly.

use smr_recordings::ColorFrame;

/// A part of a frame that is enlarged `by` times. All numbers are in pixels of the enlarged frame, so that the part may
/// begin within a pixel of the frame.
pub(super) struct Part {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
    pub by: u32,
}

impl Part {
    /// Returns the opaque pixels of the part, which is not empty and lies in the frame.
    pub fn rgba(&self, frame: &ColorFrame) -> Vec<[u8; 4]> {
        let &Self { left, top, width, height, by } = self;
        let columns: Vec<_> = (left..left + width).map(|x| Between::of(x, by, frame.width)).collect();
        let (first, last) = (columns[0].first, columns[columns.len() - 1].second);
        let (mut all, mut row) = (Vec::with_capacity(columns.len() * height as usize), Vec::new());
        for y in top..top + height {
            let y = Between::of(y, by, frame.height);
            let [above, below] = [y.first, y.second].map(|y| {
                let begin = y * usize::from(frame.width);
                frame.pixels[begin + first..=begin + last].as_flattened()
            });
            row.clear();
            row.extend(above.iter().zip(below).map(|(&above, &below)| mixed(above.into(), below.into(), y.part)));
            all.extend(columns.iter().map(|x| {
                let [from, to] = [&row[3 * (x.first - first)..][..3], &row[3 * (x.second - first)..][..3]];
                let value = |at: usize| rounded(mixed(from[at], to[at], x.part));
                [value(0), value(1), value(2), u8::MAX]
            }));
        }
        all
    }
}

/// The place of a column or row of the enlarged frame among those of the frame.
struct Between {
    first: usize,
    second: usize,
    /// Part of the way from the middle of the first to that of the second, from 0 to below 1.
    part: f32,
}

impl Between {
    fn of(at: u32, by: u32, most: u16) -> Self {
        // In halves of an enlarged pixel, from the middle of the frame's first pixel on.
        let middle = (2 * at + 1).saturating_sub(by);
        let first = (middle / (2 * by)) as usize;
        let part = f64::from(middle % (2 * by)) / f64::from(2 * by);
        Self { first, second: (first + 1).min(usize::from(most) - 1), part: single(part) }
    }
}

#[allow(clippy::cast_possible_truncation)] // what is too large becomes infinite
pub(super) const fn single(number: f64) -> f32 {
    number as f32
}

fn mixed(from: f32, to: f32, part: f32) -> f32 {
    from + (to - from) * part
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it is from 0 to 255
fn rounded(value: f32) -> u8 {
    (value + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_copied_or_lie_on_a_line_between_those_of_the_frame() {
        let pixels = [10, 50, 90, 20, 60, 100].map(|red| [red, 7, 255]).to_vec();
        let frame = ColorFrame { width: 3, height: 2, pixels };
        let reds = |left, top, width, height, by| {
            let pixels = Part { left, top, width, height, by }.rgba(&frame);
            assert!(pixels.iter().all(|pixel| pixel[1..] == [7, 255, 255]));
            pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>()
        };
        assert_eq!(reds(0, 0, 3, 2, 1), [10, 50, 90, 20, 60, 100]);
        assert_eq!(reds(1, 1, 2, 1, 1), [60, 100]);
        assert_eq!(reds(0, 0, 12, 1, 4), [10, 10, 15, 25, 35, 45, 55, 65, 75, 85, 90, 90]);
        assert_eq!(reds(3, 5, 2, 3, 4), [34, 44, 35, 45, 35, 45], "a part that begins within a pixel");
        assert_eq!(reds(0, 0, 1, 6, 3), [10, 10, 13, 17, 20, 20]);
    }
}
