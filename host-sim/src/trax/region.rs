//! A region of the protocol as a box, and back.

use anyhow::{Context, Result};
use smr_core::Rect;
use smr_recordings::{BoundingBox, boxes};

/// The box of a rectangle, or around a polygon.
pub(super) fn parse(text: &str) -> Result<BoundingBox> {
    let entry = boxes::region(text)?;
    entry
        .filter(BoundingBox::has_area)
        .with_context(|| format!("the region {text:?} has no area: expected one with it"))
}

/// As a rectangle, to four digits as other programs write it.
pub(super) fn text(&BoundingBox { x, y, width, height }: &BoundingBox) -> String {
    format!("{x:.4},{y:.4},{width:.4},{height:.4}")
}

/// The part of `region` that lies in the frame, in whole pixels: clients give regions that reach out of the picture, and a tracker
/// can only be started on what is to be seen.
pub(super) fn inside(region: &BoundingBox, width: u16, height: u16) -> Result<Rect> {
    let part = |start: f64, length: f64, side: u16| {
        let first = start.round().clamp(0.0, side.into());
        (first, (start + length).round().clamp(first, side.into()) - first)
    };
    let ((x, width_inside), (y, height_inside)) =
        (part(region.x, region.width, width), part(region.y, region.height, height));
    let visible = BoundingBox { x, y, width: width_inside, height: height_inside };
    visible.to_rect().with_context(|| {
        format!("the region {region} has no pixel in the picture of {width}x{height}: expected one that is in it")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_polygons_and_what_is_neither() {
        let expected = BoundingBox { x: 1.0, y: 2.0, width: 3.5, height: 4.0 };
        assert_eq!(parse("1.0000,2,3.5,4").unwrap(), expected);
        assert_eq!(parse("1,3,4.5,2,4.5,6,2,5").unwrap(), expected);
        assert_eq!(text(&expected), "1.0000,2.0000,3.5000,4.0000");
        for refused in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,-4", "nan,1,2,3", "1,1,inf,4", "m1,2,3,4", "a", "0"]
        {
            assert!(parse(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn a_region_is_cut_at_the_picture() {
        let region = |x, y, width, height| BoundingBox { x, y, width, height };
        assert_eq!(inside(&region(-5.0, 2.4, 10.0, 30.0), 20, 12).unwrap(), Rect::new(0, 2, 5, 10));
        assert_eq!(inside(&region(1.0, 2.0, 3.0, 4.0), 20, 12).unwrap(), Rect::new(1, 2, 3, 4));
        assert_eq!(inside(&region(-1e300, -1e300, 1e301, 1e301), 20, 12).unwrap(), Rect::new(0, 0, 20, 12));
        assert!(inside(&region(30.0, 2.0, 3.0, 4.0), 20, 12).is_err());
    }
}
