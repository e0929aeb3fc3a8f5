//! Frames per second by size of window and template, as a diagram with two logarithmic axes.

use super::canvas::FONT;
use super::diagram::{BOTTOM, GRID, LEFT, Mark, RIGHT, Stroke, TOP};
use super::{Color, SAD, SMR, TRUTH, color_of};
use crate::bench::speeds::{Speed, TEMPLATES, WINDOWS};
use smr_core::State;

/// Of the templates, from the smallest to the largest.
const COLORS: [Color; 4] = [SAD, TRUTH, color_of(State::Leaving), SMR];

/// The diagram of `speeds`.
#[must_use]
pub fn marks(speeds: &[Speed]) -> Vec<Mark> {
    Diagram::new(speeds).marks(speeds)
}

/// Where values are in it.
struct Diagram {
    /// Powers of ten: the y axis.
    decades: (i32, i32),
    /// Logarithms of offsets: the x axis.
    offsets: (f64, f64),
}

impl Diagram {
    fn new(speeds: &[Speed]) -> Self {
        let values = || speeds.iter().flat_map(|speed| [speed.pruned, speed.exhaustive]).flatten().map(f64::log10);
        let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let decades = if least <= most { (whole(least.floor()), whole(most.ceil())) } else { (0, 1) };
        let decades = (decades.0, decades.1.max(decades.0 + 1));
        let offsets = |window: usize| WINDOWS.get(window).map_or(0.0, |radius| offsets(radius.x, radius.y));
        Self { decades, offsets: (offsets(0), offsets(WINDOWS.len() - 1)) }
    }

    fn x(&self, logarithm: f64) -> f64 {
        LEFT + 12.0 + (RIGHT - LEFT - 24.0) * (logarithm - self.offsets.0) / (self.offsets.1 - self.offsets.0)
    }

    fn y(&self, logarithm: f64) -> f64 {
        let (least, most) = (f64::from(self.decades.0), f64::from(self.decades.1));
        BOTTOM - (BOTTOM - TOP) * (logarithm - least) / (most - least)
    }

    fn marks(&self, speeds: &[Speed]) -> Vec<Mark> {
        let mut marks = self.grid();
        for (side, color) in TEMPLATES.into_iter().zip(COLORS) {
            let of_side = || speeds.iter().filter(move |speed| speed.template == side);
            marks.extend(self.line(of_side().map(|speed| (speed, speed.exhaustive)), color, Stroke::Dotted));
            marks.extend(self.line(of_side().map(|speed| (speed, speed.pruned)), color, Stroke::Solid));
            let last = of_side().filter_map(|speed| speed.pruned).next_back();
            if let Some(last) = last {
                let words = format!("{side}x{side}");
                let y = self.y(last.log10());
                marks.push(Mark::Words { x: RIGHT + 8.0, y, place: 0.0, words, color: Some(color) });
            }
        }
        apart(&mut marks);
        marks
    }

    fn grid(&self) -> Vec<Mark> {
        let white = |x: f64, y: f64, place: f64, words: String| Mark::Words { x, y, place, words, color: None };
        let mut marks = vec![white(LEFT, TOP / 2.0, 0.0, "frames per second   line pruned   dashed exhaustive".into())];
        for decade in self.decades.0..=self.decades.1 {
            let y = self.y(f64::from(decade));
            marks.push(Mark::Line { points: vec![(LEFT, y), (RIGHT, y)], color: GRID, stroke: Stroke::Dotted });
            marks.push(white(LEFT - 8.0, y, 1.0, power_of_ten(decade)));
        }
        for radius in WINDOWS {
            let x = self.x(offsets(radius.x, radius.y));
            marks.push(white(x, BOTTOM + 18.0, 0.5, format!("{}x{}", radius.x, radius.y)));
        }
        marks.push(white((LEFT + RIGHT) / 2.0, BOTTOM + 42.0, 0.5, "window to each side".into()));
        marks
    }

    /// Through all that there is.
    fn line<'a>(
        &self,
        values: impl Iterator<Item = (&'a Speed, Option<f64>)>,
        color: Color,
        stroke: Stroke,
    ) -> Option<Mark> {
        let point = |(speed, value): (&Speed, Option<f64>)| {
            Some((self.x(offsets(speed.window.x, speed.window.y)), self.y(value?.log10())))
        };
        let points: Vec<_> = values.filter_map(point).collect();
        (points.len() > 1).then_some(Mark::Line { points, color, stroke })
    }
}

/// The logarithm of the number of offsets.
fn offsets(x: u16, y: u16) -> f64 {
    ((2.0 * f64::from(x) + 1.0) * (2.0 * f64::from(y) + 1.0)).log10()
}

#[allow(clippy::cast_possible_truncation)] // logarithms of speeds
fn whole(value: f64) -> i32 {
    value as i32
}

fn power_of_ten(decade: i32) -> String {
    match u32::try_from(decade) {
        Ok(decade @ 0..3) => 10_u32.pow(decade).to_string(),
        Ok(decade @ 3..6) => format!("{}K", 10_u32.pow(decade - 3)),
        Ok(decade @ 6..9) => format!("{}M", 10_u32.pow(decade - 6)),
        _ => format!("1E{decade}"),
    }
}

/// Names at the right end that would lie on each other are moved down.
fn apart(marks: &mut [Mark]) {
    let mut names: Vec<&mut f64> = marks
        .iter_mut()
        .filter_map(|mark| match mark {
            Mark::Words { x, y, .. } if *x > RIGHT => Some(y),
            _ => None,
        })
        .collect();
    names.sort_by(|a, b| a.total_cmp(b));
    let mut free = f64::NEG_INFINITY;
    for y in names {
        *y = y.max(free);
        free = *y + f64::from(FONT.character_size.height);
    }
}

#[cfg(test)]
mod tests {
    use super::super::diagram::{Form, SIZE};
    use super::*;

    fn speeds() -> Vec<Speed> {
        let speed = |template: u16, window: smr_core::paper::Radius| {
            let offsets = (2 * u32::from(window.x) + 1) * (2 * u32::from(window.y) + 1);
            let pruned = 1e9 / f64::from(offsets) / f64::from(template).powi(2);
            // Not everything was timed.
            let exhaustive = (template < 64).then_some(pruned / 8.0);
            Speed { template, window, offsets, pruned: Some(pruned), exhaustive }
        };
        TEMPLATES.into_iter().flat_map(|template| WINDOWS.map(|window| speed(template, window))).collect()
    }

    #[test]
    fn a_line_for_all_that_was_timed() {
        let svg = String::from_utf8(Form::Svg.draw(&marks(&speeds())).unwrap()).unwrap();
        assert_eq!(svg.matches("stroke-width=\"2\"").count(), 4, "{svg}");
        for words in [">64x64</text>", ">60x50</text>", ">10K</text>"] {
            assert!(svg.contains(words), "{words} is not in {svg}");
        }
    }

    #[test]
    fn the_picture_reads_back_even_if_nothing_was_timed() {
        for speeds in [speeds(), Vec::new()] {
            let png = image::load_from_memory(&Form::Png.draw(&marks(&speeds)).unwrap()).unwrap();
            assert_eq!((png.width(), png.height()), SIZE);
        }
    }

    #[test]
    fn names_do_not_lie_on_each_other() {
        let diagram = Diagram::new(&[]);
        let speeds: Vec<Speed> = speeds().into_iter().map(|speed| Speed { pruned: Some(5.0), ..speed }).collect();
        let marks = diagram.marks(&speeds);
        let mut names: Vec<f64> = marks
            .iter()
            .filter_map(|mark| match mark {
                Mark::Words { x, y, .. } if *x > RIGHT => Some(*y),
                _ => None,
            })
            .collect();
        names.sort_by(f64::total_cmp);
        assert_eq!(names.len(), 4);
        assert!(names.windows(2).all(|pair| pair[1] - pair[0] >= 14.0), "{names:?}");
    }
}
