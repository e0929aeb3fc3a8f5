//! Frames per second by size of window and template, as a diagram with two logarithmic axes.

use super::speeds::{Speed, TEMPLATES, WINDOWS};
use smr_core::State;
use smr_core::paper::Radius;
use smr_pages::report::axes::Axes;
use smr_pages::report::canvas::FONT;
use smr_pages::report::diagram::{Mark, Stroke};
use smr_pages::report::{Color, SAD, SMR, TRUTH, color_of};

/// Of the templates, from the smallest to the largest.
const COLORS: [Color; 4] = [SAD, TRUTH, color_of(State::Leaving), SMR];

/// The diagram of `speeds`.
#[must_use]
pub fn marks(speeds: &[Speed]) -> Vec<Mark> {
    let values = || speeds.iter().flat_map(|speed| [speed.pruned, speed.exhaustive]).flatten().map(f64::log10);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let (least, most) = if least <= most { (whole(least.floor()), whole(most.ceil())) } else { (0, 1) };
    let most = most.max(least + 1);
    let ends = [&WINDOWS[0], &WINDOWS[WINDOWS.len() - 1]].map(offsets);
    let axes = Axes {
        // Names below the ends have room.
        across: (ends[0] - 0.05, ends[1] + 0.05),
        up: (least.into(), most.into()),
        ..Axes::DIAGRAM
    };
    let windows = WINDOWS.map(|radius| (offsets(&radius), format!("{}x{}", radius.x, radius.y)));
    let mut marks = axes.grid(windows, (least..=most).map(|decade| (decade.into(), power_of_ten(decade))));
    let title = "frames per second   line pruned   dashed exhaustive";
    marks.push(Mark::words(axes.left, axes.top / 2.0, 0.0, title, None));
    let middle = (axes.left + axes.right) / 2.0;
    marks.push(Mark::words(middle, axes.bottom + 42.0, 0.5, "window to each side", None));
    let mut names = Vec::new();
    for (side, color) in TEMPLATES.into_iter().zip(COLORS) {
        // Through all that there is.
        let points = |value: fn(&Speed) -> Option<f64>| {
            let of_side = speeds.iter().filter(move |speed| speed.template == side);
            of_side.filter_map(move |speed| Some(Some((offsets(&speed.window), value(speed)?.log10()))))
        };
        marks.extend(axes.curve(points(|speed| speed.exhaustive), color, Stroke::Dotted));
        marks.extend(axes.curve(points(|speed| speed.pruned), color, Stroke::Solid));
        names.extend(points(|speed| speed.pruned).next_back().flatten().map(|(_, last)| (axes.y(last), side, color)));
    }
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::NEG_INFINITY;
    for (y, side, color) in names {
        // Names that would lie on each other are moved down.
        let y = y.max(free);
        free = y + f64::from(FONT.character_size.height);
        marks.push(Mark::words(axes.right + 8.0, y, 0.0, format!("{side}x{side}"), Some(color)));
    }
    marks
}

/// The logarithm of the number of offsets.
fn offsets(radius: &Radius) -> f64 {
    ((2.0 * f64::from(radius.x) + 1.0) * (2.0 * f64::from(radius.y) + 1.0)).log10()
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

#[cfg(test)]
mod tests {
    use super::*;
    use smr_pages::report::diagram::{Form, SIZE};
    use smr_recordings::decode_picture;

    fn speeds() -> Vec<Speed> {
        let speed = |template: u16, window: Radius| {
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
            let png = decode_picture(&Form::Png.draw(&marks(&speeds)).unwrap()).unwrap();
            assert_eq!((u32::from(png.width), u32::from(png.height)), SIZE);
        }
    }

    #[test]
    fn names_do_not_lie_on_each_other() {
        let speeds: Vec<Speed> = speeds().into_iter().map(|speed| Speed { pruned: Some(5.0), ..speed }).collect();
        let name = |mark: &Mark| match mark {
            Mark::Words { x, y, .. } if *x > Axes::DIAGRAM.right => Some(*y),
            _ => None,
        };
        let names: Vec<f64> = marks(&speeds).iter().filter_map(name).collect();
        assert_eq!(names.len(), 4);
        assert!(names.windows(2).all(|pair| pair[1] - pair[0] >= 14.0), "{names:?}");
    }
}
