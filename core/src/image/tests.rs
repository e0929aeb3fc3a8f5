//! Tests rectangles against sets of pixels, and images at the limits of their sizes.

use super::{Frame, FrameError, Image, ImageError, Rect, WindowError, Windows};
use proptest::prelude::*;
use std::{vec, vec::Vec};

#[test]
fn what_is_not_an_image_is_refused() {
    let pixels = [0; 12];
    assert_eq!(Image::new(&pixels, 0, 4).unwrap_err(), ImageError::Empty);
    assert_eq!(Image::new(&pixels, 4, 0).unwrap_err(), ImageError::Empty);
    assert_eq!(Image::new(&[], 1, 1).unwrap_err(), ImageError::SliceTooShort);
    assert_eq!(Image::with_stride(&pixels, 4, 3, 3).unwrap_err(), ImageError::StrideTooSmall);
    assert_eq!(Image::with_stride(&pixels, 4, 3, 5).unwrap_err(), ImageError::SliceTooShort);
    assert_eq!(Image::with_stride(&pixels, 1, 65535, usize::MAX).unwrap_err(), ImageError::SliceTooShort);
    assert!(Image::with_stride(&pixels, 2, 3, 5).is_ok(), "the last row may end with its last pixel");
    let row = Image::with_stride(&pixels, 4, 1, usize::MAX).unwrap();
    assert_eq!(row.every(0, 2).and_then(|row| row.crop(Rect::new(1, 0, 2, 1))).map(|row| row.row(0).len()), Some(2));
    assert!(Image::with_stride(&pixels, 4, 1, usize::MAX).is_ok(), "one row needs no stride");
}

#[test]
fn the_largest_sizes_work() {
    let pixels = vec![3; 65535];
    for (width, height) in [(65535, 1), (1, 65535)] {
        let image = Image::new(&pixels, width, height).unwrap();
        assert_eq!(image.rows().map(<[u8]>::len).sum::<usize>(), 65535);
        let corner = Rect::new(i32::from(width) - 1, i32::from(height) - 1, 1, 1);
        assert_eq!(image.crop(corner).unwrap().row(0), [3]);
        assert!(Frame::part(image, 0, 0, 65535, 65535).is_ok());
        assert!(Frame::part(image, 65535, 65535, 65535, 65535).is_err());
    }
}

#[test]
fn a_patch_comes_from_the_part_that_has_all_of_it() {
    let (low, high) = ([1; 4 * 4], [2; 4 * 4]);
    let image = |pixels| Image::new(pixels, 4, 4).unwrap();
    let frame = Frame::part(image(&low), 0, 0, 20, 10).unwrap().and_part(image(&high), 2, 0).unwrap();
    let at = |x, width| frame.patch(Rect::new(x, 0, width, 4)).map(|patch| patch.row(0)[0]);
    assert_eq!(
        [at(0, 4), at(2, 2), at(2, 4), at(3, 3), at(0, 5), at(6, 1)],
        [Some(1), Some(1), Some(2), Some(2), None, None]
    );
    assert_eq!(frame.and_part(image(&low), 17, 0).unwrap_err(), FrameError::OutsideFrame);
}

#[test]
fn windows_follow_each_other_in_the_buffer() {
    let pixels: Vec<u8> = (0..21).collect();
    let (first, second) = (Rect::new(2, 1, 4, 3), Rect::new(0, 5, 4, 2));
    let windows = Windows::new(first, Some(second));
    assert_eq!((windows.pixels(), windows.iter().collect::<Vec<_>>()), (20, vec![first, second]));
    let frame = Frame::of_windows(&pixels, windows, (8, 7)).unwrap();
    let corners = |frame: &Frame<'_>, window| frame.patch(window).map(|patch| (patch.row(0)[0], patch.row(1)[3]));
    assert_eq!((corners(&frame, first), corners(&frame, second)), (Some((0, 7)), Some((12, 19))));
    assert!(!frame.covers(Rect::new(1, 1, 4, 3)) && frame.bounds() == Rect::new(0, 0, 8, 7));
    let frame = Frame::of_windows(&pixels, second, (8, 7)).unwrap();
    assert_eq!((corners(&frame, first), corners(&frame, second)), (None, Some((0, 7))));
    let (outside, empty) = (WindowError::Frame(FrameError::OutsideFrame), WindowError::Image(ImageError::Empty));
    let short = WindowError::Image(ImageError::SliceTooShort);
    for (count, size, first, second, error) in [
        (19, (8, 7), first, second, short),
        (11, (8, 7), first, second, short),
        (20, (8, 6), first, second, outside),
        (20, (5, 7), first, second, outside),
        (20, (8, 7), Rect::new(-1, 1, 4, 3), second, outside),
        (20, (8, 7), first, Rect::new(0, i32::MIN, 4, 2), outside),
        (20, (8, 7), Rect::default(), second, empty),
        (20, (8, 7), first, Rect::new(3, 3, 0, 9), empty),
    ] {
        let refused = Frame::of_windows(&pixels[..count], Windows::new(first, Some(second)), size);
        assert_eq!(refused.err(), Some(error), "{count} {size:?} {first:?} {second:?}");
    }
    let largest = Rect::new(0, 0, u16::MAX, u16::MAX);
    assert!(Windows::new(largest, Some(largest)).pixels() >= 65_535 * 65_535);
    assert_eq!(Windows::from(first), Windows::new(first, None));
}

fn any_rect() -> impl Strategy<Value = Rect> {
    (-12i32..12, -12i32..12, 0u16..12, 0u16..12).prop_map(|(x, y, width, height)| Rect { x, y, width, height })
}

fn pixels_of(rect: Rect) -> Vec<(i32, i32)> {
    (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (x, y))).collect()
}

proptest! {
    #[test]
    fn rectangles_are_sets_of_pixels(a in any_rect(), b in any_rect()) {
        let common: Vec<_> = pixels_of(a).into_iter().filter(|at| pixels_of(b).contains(at)).collect();
        prop_assert_eq!(pixels_of(a.intersection(b)), common.clone());
        prop_assert_eq!(a.contains(b), !b.is_empty() && common.len() == pixels_of(b).len());
        prop_assert_eq!(pixels_of(a).len(), a.area() as usize);
    }

    #[test]
    fn no_rectangle_overflows(
        a in any::<(i32, i32, u16, u16)>(),
        b in any::<(i32, i32, u16, u16)>(),
        pixels in prop::collection::vec(any::<u8>(), 100),
    ) {
        let (a, b) = (Rect::new(a.0, a.1, a.2, a.3), Rect::new(b.0, b.1, b.2, b.3));
        let common = a.intersection(b);
        prop_assert!(common.is_empty() || (a.contains(common) && b.contains(common)));
        let frame = Frame::part(Image::new(&pixels, 10, 10).unwrap(), 65525, 65525, 65535, 65535).unwrap();
        prop_assert_eq!(frame.covers(a), Rect::new(65525, 65525, 10, 10).contains(a));
    }

    #[test]
    fn rows_and_crops_are_the_pixels_at_their_place(
        (width, height, gap) in (1u16..9, 1u16..9, 0usize..4),
        rect in any_rect(),
        pixels in prop::collection::vec(any::<u8>(), 0..100),
    ) {
        let stride = usize::from(width) + gap;
        let needed = (usize::from(height) - 1) * stride + usize::from(width);
        let image = Image::with_stride(&pixels, width, height, stride);
        prop_assert_eq!(image.is_ok(), pixels.len() >= needed);
        let Ok(image) = image else { return Ok(()) };
        let expected: Vec<Vec<u8>> = (0..usize::from(height))
            .map(|y| pixels[y * stride..][..usize::from(width)].to_vec())
            .collect();
        prop_assert_eq!(image.rows().map(<[u8]>::to_vec).collect::<Vec<_>>(), expected.clone());
        prop_assert_eq!((0..height).map(|y| image.row(y).to_vec()).collect::<Vec<_>>(), expected.clone());
        prop_assert!(image.row(height).is_empty());

        let crop = image.crop(rect);
        prop_assert_eq!(crop.is_some(), Rect::new(0, 0, width, height).contains(rect));
        if let Some(crop) = crop {
            let (x, y) = (rect.x as usize, rect.y as usize);
            for (row, full) in crop.rows().zip(&expected[y..]) {
                prop_assert_eq!(row, &full[x..x + usize::from(rect.width)]);
            }
            prop_assert_eq!(crop.rows().count(), usize::from(rect.height));
        }
    }
}
