//! The built-in recording `street`, which `smr_scene::street` draws, for demonstrations.

use crate::bounding_box::BoundingBox;
use crate::formats::to_gray::luma;
use crate::raster::{ColorFrame, GrayFrame};
use crate::sequence::Sequence;
use crate::source::Source;
use smr_files::locked;
use smr_scene::street::{HEIGHT, LENGTH, Street, WIDTH};
use std::sync::{Mutex, MutexGuard};

pub const NAME: &str = "street";

static STREET: Mutex<Street> = Mutex::new(Street::BLANK);

pub(crate) fn sequence() -> Sequence {
    let source = Source::Made(frame, LENGTH);
    let pixels = |index| frame(index).pixels.into_iter().map(luma).collect();
    let gray = move |index| GrayFrame { width: WIDTH, height: HEIGHT, pixels: pixels(index) };
    Sequence { source, ..Sequence::made(NAME, (0..LENGTH).map(gray), (0..LENGTH).map(truth).collect()) }
}

fn street() -> MutexGuard<'static, Street> {
    locked(&STREET)
}

fn frame(index: usize) -> ColorFrame {
    let pixels = street().frame(index).iter().map(|&[red, green, blue, _]| [red, green, blue]).collect();
    ColorFrame { width: WIDTH, height: HEIGHT, pixels }
}

fn truth(index: usize) -> Option<BoundingBox> {
    street().truth(index).map(BoundingBox::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_as_it_was() {
        let bytes = [0, 61, 150, 299].into_iter().flat_map(|index| frame(index).pixels).flatten();
        let fnv = crate::fixtures::fnv(bytes);
        assert_eq!(fnv, 0x58A7_C6CF_3681_FB9C, "{fnv:#X}");
    }

    #[test]
    fn the_script_is_kept() {
        let hidden: Vec<usize> = (0..LENGTH).filter(|&index| truth(index).is_none()).collect();
        assert_eq!(hidden, (39..=48).collect::<Vec<_>>());
        let [first, last] = [0, LENGTH - 1].map(|index| truth(index).unwrap());
        assert!(last.width * last.height > 3.0 * first.width * first.height, "{first:?} {last:?}");
        assert_eq!(truth(LENGTH), Some(last), "it stands still at the end");
    }

    #[test]
    fn the_truth_lies_on_the_car() {
        for index in [0, 100, 140, 180, 260] {
            let (frame, truth) = (frame(index), truth(index).unwrap());
            let (right, bottom) = (truth.x + truth.width, truth.y + truth.height);
            let (mut inside, mut beside) = (0.0, 0.0);
            for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
                let [red, green, blue] =
                    frame.pixels[usize::from(y) * usize::from(WIDTH) + usize::from(x)].map(u16::from);
                let (x, y) = (f64::from(x), f64::from(y));
                if red > 60 && red > 2 * green.max(blue) && truth.y <= y && y < bottom {
                    inside += f64::from(u8::from(truth.x <= x && x < right));
                    beside += f64::from(u8::from(truth.x - 1.0 == x || x == right));
                }
            }
            assert!(inside > 0.2 * truth.width * truth.height && beside == 0.0, "{index}: {inside} {beside}");
        }
    }
}
