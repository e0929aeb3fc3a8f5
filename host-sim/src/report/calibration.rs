//! The chance that a frame is correct by the ratio that was reported in it, as a diagram.

use super::diagram::{BOTTOM, GRID, LEFT, Mark, RIGHT, Stroke, TOP};
use super::{SAD, SMR};
use crate::evaluate::robustness::Bin;

/// The diagram: the chance as a line, and as a dashed one how many of all frames are in each bin.
#[must_use]
pub fn marks(bins: &[Bin]) -> Vec<Mark> {
    let all = bins.iter().map(|bin| bin.frames).sum::<u64>().max(1) as f64;
    let chances = bins.iter().map(|bin| bin.chance().map(|chance| (bin.middle(), chance)));
    let shares = bins.iter().map(|bin| Some((bin.middle(), bin.frames as f64 / all)));
    let mut marks = grid();
    marks.extend(lines(shares).map(|points| Mark::Line { points, color: SAD, stroke: Stroke::Dotted }));
    marks.extend(lines(chances).map(|points| Mark::Line { points, color: SMR, stroke: Stroke::Solid }));
    marks
}

fn x(ratio: f64) -> f64 {
    LEFT + (RIGHT - LEFT) * ratio
}

fn y(chance: f64) -> f64 {
    BOTTOM - (BOTTOM - TOP) * chance
}

fn grid() -> Vec<Mark> {
    let words = |x: f64, y: f64, place: f64, words: String, color| Mark::Words { x, y, place, words, color };
    let mut marks = vec![
        words(LEFT, TOP / 2.0, 0.0, "line chance to be correct".into(), Some(SMR)),
        words(RIGHT + 112.0, TOP / 2.0, 1.0, "dashed part of all frames".into(), Some(SAD)),
        words((LEFT + RIGHT) / 2.0, BOTTOM + 42.0, 0.5, "ratio and all else in percent".into(), None),
    ];
    for percent in (0..=100).step_by(20) {
        let value = f64::from(percent) / 100.0;
        let (across, up) = ([(LEFT, y(value)), (RIGHT, y(value))], [(x(value), TOP), (x(value), BOTTOM)]);
        marks.extend([across, up].map(|ends| Mark::Line {
            points: ends.to_vec(),
            color: GRID,
            stroke: Stroke::Dotted,
        }));
        marks.push(words(LEFT - 8.0, y(value), 1.0, percent.to_string(), None));
        marks.push(words(x(value), BOTTOM + 18.0, 0.5, percent.to_string(), None));
    }
    marks
}

/// Lines through neighbours that there are; one without neighbours is a short line of its own.
fn lines(values: impl Iterator<Item = Option<(f64, f64)>>) -> impl Iterator<Item = Vec<(f64, f64)>> {
    let values: Vec<_> = values.map(|value| value.map(|(ratio, part)| (x(ratio), y(part)))).collect();
    let runs = values.split(Option::is_none).map(|run| run.iter().flatten().copied().collect::<Vec<_>>());
    let line = |points: Vec<(f64, f64)>| match points[..] {
        [(x, y)] => vec![(x - 3.0, y), (x + 3.0, y)],
        _ => points,
    };
    runs.filter(|points| !points.is_empty()).map(line).collect::<Vec<_>>().into_iter()
}

#[cfg(test)]
mod tests {
    use super::super::diagram::{Form, SIZE};
    use super::*;
    use crate::export::Decoded;

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
        assert_eq!(y(0.125), 355.5);
        assert!(
            svg.contains("points=\"241.0,355.5 355.0,222.0\"") && svg.contains("points=\"580.0,44.0 586.0,44.0\""),
            "{svg}"
        );
    }

    #[test]
    fn the_picture_reads_back_even_if_nothing_was_measured() {
        for bins in [bins(), Vec::new()] {
            let png = Decoded::new(&Form::Png.draw(&marks(&bins)).unwrap());
            assert_eq!(png.size, SIZE);
        }
    }
}
