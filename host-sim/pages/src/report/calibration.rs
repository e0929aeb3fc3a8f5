//! The chance that a frame is correct by the ratio that was reported in it, as a diagram.

use super::axes::Axes;
use super::diagram::{Mark, Stroke};
use crate::colors::{GRID, SAD, SMR};
use smr_evaluation::robustness::Bin;

/// Both axes go from 0 to 1.
const AXES: Axes = Axes::DIAGRAM;

/// The diagram: the chance as a line, and as a dashed one how many of all frames are in each bin.
pub fn marks(bins: &[Bin]) -> Vec<Mark> {
    let all = bins.iter().map(|bin| bin.frames).sum::<u64>().max(1) as f64;
    let chances = bins.iter().map(|bin| bin.chance().map(|chance| (bin.middle(), chance)));
    let shares = bins.iter().map(|bin| Some((bin.middle(), bin.frames as f64 / all)));
    let percent = || (0..=100).step_by(20).map(|percent| (f64::from(percent) / 100.0, percent.to_string()));
    let middle = (AXES.left + AXES.right) / 2.0;
    let mut marks = AXES.grid(percent(), percent());
    marks.extend(percent().map(|(value, _)| {
        let points = vec![(AXES.x(value), AXES.top), (AXES.x(value), AXES.bottom)];
        Mark::Line { points, color: GRID, stroke: Stroke::Dotted }
    }));
    marks.extend([
        Mark::words(AXES.left, AXES.top / 2.0, 0.0, "line chance to be correct", Some(SMR)),
        Mark::words(AXES.right + 112.0, AXES.top / 2.0, 1.0, "dashed part of all frames", Some(SAD)),
        Mark::words(middle, AXES.bottom + 42.0, 0.5, "ratio and all else in percent", None),
    ]);
    marks.extend(AXES.curve(shares, SAD, Stroke::Dotted));
    marks.extend(AXES.curve(chances, SMR, Stroke::Solid));
    marks
}

#[cfg(test)]
mod tests {
    use super::super::diagram::{Form, SIZE};
    use super::*;
    use crate::report::canvas::Canvas;

    fn bins() -> Vec<Bin> {
        let counts = [(0, 0), (8, 1), (4, 2), (0, 0), (9, 9)];
        let bin = |(index, (frames, correct)): (u8, (u64, u64))| {
            let (from, to) = (f64::from(index) / 5.0, f64::from(index + 1) / 5.0);
            Bin { tracker: "robust".to_owned(), from, to, frames, correct }
        };
        (0..).zip(counts).map(bin).collect()
    }

    #[test]
    fn lines_have_gaps_where_there_are_no_frames() {
        let svg = String::from_utf8(Form::Svg.draw(&marks(&bins())).unwrap()).unwrap();
        assert_eq!(svg.matches("stroke-width=\"2\"").count(), 2, "{svg}");
        assert_eq!(AXES.y(0.125), 355.5);
        assert!(
            svg.contains("points=\"241.0,355.5 355.0,222.0\"") && svg.contains("points=\"580.0,44.0 586.0,44.0\""),
            "{svg}"
        );
    }

    #[test]
    fn the_picture_reads_back_even_if_nothing_was_measured() {
        for bins in [bins(), Vec::new()] {
            let png = Canvas::decoded(&Form::Png.draw(&marks(&bins)).unwrap());
            assert_eq!((png.width, png.height), SIZE);
        }
    }
}
