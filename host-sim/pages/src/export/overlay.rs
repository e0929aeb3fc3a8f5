//! Draws boxes and lines of text on a frame, or on an enlarged part of it.

use super::enlarged::{Part, single};
use super::letters::Line;
use crate::colors::{BLACK, Color};
use anyhow::{Context, Result, ensure};
use smr_recordings::{BoundingBox, ColorFrame};
use tiny_skia::{
    FillRule, IntSize, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Point, Rect, Shader, Stroke, StrokeDash,
    Transform,
};

/// A picture to draw on, which clips all drawings. All places are those of the frame.
pub struct Overlay {
    pixels: Pixmap,
    /// From the frame to the picture.
    view: Transform,
}

/// Least length of an enlarged part's longer side, in pixels.
const ENLARGED: u32 = 480;
/// Opacity of the dark border of lines, as in the viewer.
const SHADOW: u8 = 140;

impl Overlay {
    /// Errors: the frame has no pixels.
    pub fn new(ColorFrame { width, height, pixels }: &ColorFrame) -> Result<Self> {
        let opaque: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
        Self::of(opaque, ((*width).into(), (*height).into()), Transform::identity())
    }

    fn of(opaque: Vec<[u8; 4]>, (width, height): (u32, u32), view: Transform) -> Result<Self> {
        let size = IntSize::from_wh(width, height);
        let pixels = size.and_then(|size| Pixmap::from_vec(opaque.into_flattened(), size));
        Ok(Self { pixels: pixels.context("a frame has no pixels")?, view })
    }

    pub fn size(&self) -> (u32, u32) {
        (self.pixels.width(), self.pixels.height())
    }

    pub fn rgb(&self) -> Vec<u8> {
        let (pixels, _) = self.pixels.data().as_chunks();
        pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect::<Vec<_>>().into_flattened()
    }

    /// Returns a part of the frame: a square of `side` pixels around `centre`, moved and made smaller so that it lies in the
    /// frame, and enlarged by a whole number until its longer side has `ENLARGED` pixels. The sides are even, as videos
    /// need, unless the frame has a single column or row. Errors: the frame has no pixels.
    pub fn part(frame: &ColorFrame, centre: (f64, f64), side: u32) -> Result<Self> {
        ensure!(!frame.pixels.is_empty(), "a frame has no pixels");
        let (width, height) = (frame.width.into(), frame.height.into());
        let [wide, high] = [width, height].map(|most| (side.min(most) & !1).max(1));
        let by = ENLARGED.div_ceil(wide.max(high));
        let first = |centre: f64, part: u32, most: u32| {
            let first = (centre - f64::from(part) / 2.0).clamp(0.0, f64::from(most - part));
            whole(first * f64::from(by))
        };
        let (left, top) = (first(centre.0, wide, width), first(centre.1, high, height));
        let part = Part { left, top, width: wide * by, height: high * by, by };
        let [scale, x, y] = [by, left, top].map(|number| single(number.into()));
        let view = Transform::from_row(scale, 0.0, 0.0, scale, -x, -y);
        Self::of(part.rgba(frame), (part.width, part.height), view)
    }

    /// Returns the width of lines in pixels, larger in large pictures so that lines stay visible.
    fn pen(&self) -> f32 {
        (1.5 + self.shorter_side() / 360.0).floor()
    }

    /// Returns the height of letters in pixels.
    fn letters(&self) -> f32 {
        8.0 + self.shorter_side() / 45.0
    }

    fn shorter_side(&self) -> f32 {
        let (width, height) = self.size();
        single(width.min(height).into())
    }

    /// Draws an outline outside the box, so that it hides no small target. It is dashed for a target that may not be there.
    pub fn outline(&mut self, target: &BoundingBox, color: Color, is_dashed: bool) {
        let pen = self.pen();
        let border = (pen / 3.0).ceil();
        let out = pen / 2.0 + border;
        let Some(edges) = self.placed(target).and_then(|edges| edges.outset(out, out)) else { return };
        let path = PathBuilder::from_rect(edges);
        self.stroke(&path, (BLACK, SHADOW), &Stroke { width: pen + 2.0 * border, ..Stroke::default() });
        let dash = is_dashed.then(|| StrokeDash::new(vec![5.0 * pen; 2], 0.0)).flatten();
        self.stroke(&path, (color, u8::MAX), &Stroke { width: pen, dash, ..Stroke::default() });
    }

    /// Returns the box in whole pixels of the picture; `None` if it has none, or lies far outside.
    fn placed(&self, target: &BoundingBox) -> Option<Rect> {
        let mut corners = [(target.x, target.y), (target.x + target.width, target.y + target.height)].map(point);
        self.view.map_points(&mut corners);
        let is_near = corners.iter().all(|corner| corner.x.abs() < FAR && corner.y.abs() < FAR);
        let [from, to] = corners.map(|Point { x, y }| (x.round(), y.round()));
        Rect::from_ltrb(from.0, from.1, to.0, to.1).filter(|_| is_near)
    }

    /// Draws the path through `points`.
    pub fn path(&mut self, points: &[(f64, f64)], color: Color) {
        let mut path = PathBuilder::new();
        for (at, place) in points.iter().map(|&place| point(place)).enumerate() {
            if at == 0 { path.move_to(place.x, place.y) } else { path.line_to(place.x, place.y) }
        }
        let path = path.finish().and_then(|path| path.transform(self.view));
        let is_near = |path: &Path| {
            let bounds = path.bounds();
            [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()].iter().all(|edge| edge.abs() < FAR)
        };
        if let Some(path) = path.filter(is_near) {
            let (width, line_cap, line_join) = (self.pen(), LineCap::Round, LineJoin::Round);
            self.stroke(&path, (color, u8::MAX), &Stroke { width, line_cap, line_join, ..Stroke::default() });
        }
    }

    fn stroke(&mut self, path: &Path, (color, opacity): (Color, u8), stroke: &Stroke) {
        let paint = paint(color, opacity);
        self.pixels.stroke_path(path, &paint, stroke, Transform::identity(), None);
    }

    /// Writes a line of text into the corner, in smaller letters if it is longer than the picture.
    pub fn label(&mut self, text: &str, color: Color) -> Result<()> {
        let (size, whole) = (self.letters(), single(self.size().0.into()));
        let width = Line::new(text, size)?.width + size;
        let size = size * (whole / width).min(1.0);
        self.write(&Line::new(text, size)?, (size / 2.0, size * 1.2), color);
        Ok(())
    }

    /// Writes a line of text above the box, or below it if there is no space above.
    pub fn label_box(&mut self, target: &BoundingBox, text: &str, color: Color) -> Result<()> {
        let Some(edges) = self.placed(target) else { return Ok(()) };
        let line = Line::new(text, self.letters())?;
        let (width, height) = self.size();
        let gap = 2.0 * self.pen() + line.size * 0.3;
        let is_above = edges.top() - gap >= line.size;
        let y = if is_above { edges.top() - gap } else { edges.bottom() + gap + line.size * 0.75 };
        let most = |whole: u32, part: f32| (single(whole.into()) - part).max(0.0);
        let x = edges.left().min(most(width, line.width + gap)).max(gap);
        let y = y.min(most(height, gap)).max(line.size);
        self.write(&line, (x, y), color);
        Ok(())
    }

    /// Writes with a dark border, which makes letters legible anywhere.
    fn write(&mut self, line: &Line, (x, y): (f32, f32), color: Color) {
        let Some(path) = line.path.clone().and_then(|path| path.transform(Transform::from_translate(x, y))) else {
            return;
        };
        let (width, line_join) = (line.size * 0.22, LineJoin::Round);
        self.stroke(&path, (BLACK, u8::MAX), &Stroke { width, line_join, ..Stroke::default() });
        self.pixels.fill_path(&path, &paint(color, u8::MAX), FillRule::Winding, Transform::identity(), None);
    }
}

/// Pixels from the corner of the picture beyond which nothing is drawn.
const FAR: f32 = 100_000.0;

fn point((x, y): (f64, f64)) -> Point {
    Point { x: single(x), y: single(y) }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
fn whole(number: f64) -> u32 {
    number.round() as u32
}

fn paint([r, g, b]: Color, opacity: u8) -> Paint<'static> {
    Paint { shader: Shader::SolidColor(tiny_skia::Color::from_rgba8(r, g, b, opacity)), ..Paint::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::{WHITE, of_target};

    const GREEN: Color = of_target(4);
    const RED: Color = of_target(6);
    const GROUND: Color = [100; 3];

    fn plain(width: u16, height: u16) -> Overlay {
        let pixels = vec![GROUND; usize::from(width) * usize::from(height)];
        Overlay::new(&ColorFrame { width, height, pixels }).unwrap()
    }

    fn at(overlay: &Overlay, x: u32, y: u32) -> Color {
        let pixel = overlay.pixels.pixel(x, y).unwrap();
        [pixel.red(), pixel.green(), pixel.blue()]
    }

    fn is_plain(overlay: &Overlay) -> bool {
        overlay.rgb().iter().all(|&value| value == GROUND[0])
    }

    #[test]
    fn an_outline_is_around_the_box() {
        let mut overlay = plain(20, 16);
        overlay.outline(&BoundingBox { x: 4.2, y: 5.0, width: 6.0, height: 4.0 }, GREEN, false);
        for (x, y) in [(2, 6), (11, 6), (6, 3), (6, 10)] {
            assert_eq!(at(&overlay, x, y), GREEN, "{x},{y}");
        }
        for (x, y) in [(4, 5), (9, 8), (13, 12), (0, 0)] {
            assert_eq!(at(&overlay, x, y), GROUND, "{x},{y}");
        }
        assert!(at(&overlay, 1, 2)[0] < GROUND[0] && at(&overlay, 3, 4)[0] < GROUND[0], "a dark border on both sides");
        let green = overlay.rgb().chunks(3).filter(|&pixel| pixel == GREEN).count();
        assert_eq!(green, 2 * 8 + 2 * 6, "without the corners, which are smooth");
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut overlay = plain(20, 16);
        overlay.outline(&BoundingBox { x: -5.0, y: -5.0, width: 1000.0, height: 8.0 }, RED, false);
        assert_eq!([(0, 4), (19, 4), (0, 0)].map(|(x, y)| at(&overlay, x, y)), [RED, RED, GROUND]);
        let mut overlay = plain(20, 16);
        for is_dashed in [false, true] {
            overlay.outline(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 8.0 }, RED, is_dashed);
            overlay.outline(&BoundingBox { x: 2e9, y: -2e9, width: 65535.0, height: 65535.0 }, RED, is_dashed);
        }
        overlay.path(&[(f64::NAN, 3.0), (1e300, 9.0)], RED);
        overlay.path(&[(3.0, 3.0), (2e9, 9.0)], RED);
        overlay.label_box(&BoundingBox { x: 1e300, y: f64::NAN, width: 5.0, height: 5.0 }, "a", RED).unwrap();
        assert!(is_plain(&overlay));
        let empty = ColorFrame { width: 0, height: 16, pixels: vec![] };
        assert!(Overlay::new(&empty).is_err() && Overlay::part(&empty, (0.0, 0.0), 9).is_err());
    }

    #[test]
    fn a_path_goes_through_its_points() {
        let mut overlay = plain(20, 16);
        overlay.path(&[(2.5, 3.5), (2.5, 9.5), (8.5, 9.5)], GREEN);
        assert_eq!([(2, 4), (2, 6), (5, 9), (7, 9)].map(|(x, y)| at(&overlay, x, y)), [GREEN; 4]);
        assert_eq!([(4, 4), (10, 9), (5, 7)].map(|(x, y)| at(&overlay, x, y)), [GROUND; 3]);
    }

    #[test]
    fn a_part_lies_in_the_frame_and_is_enlarged() {
        let pixels = (0..20 * 16).map(|at| if at % 20 < 10 { GREEN } else { RED }).collect();
        let frame = ColorFrame { width: 20, height: 16, pixels };
        // A pixel has 80 pixels of the part; the colors meet at 10 in the frame.
        let meets = |part: &Overlay| (0..480).find(|&x| at(part, x, 240)[1] < 155).unwrap();
        let mut part = Overlay::part(&frame, (10.0, 8.0), 7).unwrap();
        assert_eq!((part.size(), at(&part, 40, 240), at(&part, 440, 240), meets(&part)), ((480, 480), GREEN, RED, 240));
        part = Overlay::part(&frame, (10.25, 8.0), 7).unwrap();
        assert_eq!(meets(&part), 220, "(10 - 7.25) * 80");
        part.outline(&BoundingBox { x: 8.25, y: 6.0, width: 2.0, height: 3.0 }, WHITE, false);
        assert_eq!([(78, 100), (240, 80), (242, 100)].map(|(x, y)| at(&part, x, y) == WHITE), [true, false, true]);
        for centre in [(-50.0, -50.0), (1e300, f64::NAN), (10.0, 8.0)] {
            let size = |side| Overlay::part(&frame, centre, side).unwrap().size();
            assert_eq!((size(99), size(0)), ((24 * 20, 24 * 16), (480, 480)));
        }
        let large = ColorFrame { width: 800, height: 600, pixels: vec![GROUND; 800 * 600] };
        assert_eq!((Overlay::part(&large, (400.0, 300.0), 501).unwrap().size()), (500, 500));
    }

    #[test]
    fn a_dashed_outline_has_gaps() {
        let mut overlay = plain(60, 60);
        overlay.outline(&BoundingBox { x: 10.0, y: 10.0, width: 40.0, height: 40.0 }, RED, true);
        let reds: Vec<_> = (10..50).map(|x| at(&overlay, x, 8) == RED).collect();
        assert!(reds.windows(2).filter(|pair| pair[0] != pair[1]).count() > 5, "{reds:?}");
        assert_eq!(at(&overlay, 30, 30), GROUND);
    }

    #[test]
    fn text_is_smooth_and_stays_in_the_picture() {
        let mut overlay = plain(320, 240);
        overlay.label("12 tracking 99", WHITE).unwrap();
        let shades: std::collections::BTreeSet<u8> = overlay.rgb().iter().copied().collect();
        assert!(shades.len() > 30 && shades.contains(&0) && shades.contains(&255), "{shades:?}");
        let inked = |overlay: &Overlay| {
            let rgb = overlay.rgb();
            let width = overlay.size().0 as usize;
            let places = rgb.chunks(3).enumerate().filter(|(_, pixel)| *pixel != GROUND);
            let places: Vec<_> = places.map(|(at, _)| (at % width, at / width)).collect();
            let (xs, ys) = (places.iter().map(|place| place.0), places.iter().map(|place| place.1));
            (xs.clone().min().unwrap(), xs.max().unwrap(), ys.clone().min().unwrap(), ys.max().unwrap())
        };
        let mut narrow = plain(80, 60);
        narrow.label("12 a long name tracking 99", WHITE).unwrap();
        assert!(inked(&narrow).1 < 80 - 2, "smaller letters");
        // Above the box; below it at the upper border; inside the frame at all borders.
        for (x, y, above) in [
            (100.0, 100.0, true),
            (100.0, 2.0, false),
            (-30.0, 100.0, true),
            (310.0, 100.0, true),
            (310.0, 250.0, true),
        ] {
            let mut overlay = plain(320, 240);
            overlay.label_box(&BoundingBox { x, y, width: 20.0, height: 20.0 }, "Åg", RED).unwrap();
            let (left, right, top, bottom) = inked(&overlay);
            assert!(left > 0 && right < 319 && top > 0 && bottom < 239, "{x} {y}: {left} {right} {top} {bottom}");
            assert_eq!((bottom as f64) < y + 10.0, above, "{x} {y}");
        }
    }
}
