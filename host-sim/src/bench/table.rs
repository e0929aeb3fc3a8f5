//! The report as text.

use super::report::{Report, Row, Window};
use super::speeds::{Speed, TEMPLATES, WINDOWS};
use crate::evaluate::aligned;
use smr_core::Radius;

const NOTHING: &str = "-";

/// Everything that was measured, table by table.
#[must_use]
pub fn text(report: &Report) -> String {
    let Report { processor, recordings, template, every, .. } = report;
    let mut parts = vec![format!(
        "{processor}, one thread; {}: every {every}. frame with ground truth, template {template}\n",
        recordings.join(", ")
    )];
    parts.extend(report.windows.iter().map(window));
    parts.push(opencv(report));
    parts.push(ratios(&report.windows));
    parts.push(speeds(&report.speeds));
    parts.push("instructions on this machine are not counted here: .ci/instructions does, with valgrind\n".to_owned());
    if !report.boards.is_empty() {
        parts.push(boards(report));
    }
    parts.push(goals(report));
    parts.retain(|part| !part.is_empty());
    parts.join("\n")
}

fn window(window: &Window) -> String {
    let Window { offsets, cases, skipped, ways, .. } = window;
    let mut title = format!("window {}: {offsets} offsets, {cases} searches", plus_minus(window.window));
    if *skipped > 0 {
        title += &format!("; {skipped} left out, for which the frame has no room");
    }
    if *cases == 0 {
        return title + "\n";
    }
    let header = ["way", "searches", "median us", "p95 us", "max us", "ns/offset/pixel", "work left"];
    let mut lines = vec![header.map(String::from).to_vec()];
    lines.extend(ways.iter().map(row));
    format!("{title}\n{}", aligned(&lines, 1))
}

fn row(row: &Row) -> Vec<String> {
    let microseconds = |nanoseconds: u64| format!("{:.1}", nanoseconds as f64 / 1e3);
    vec![
        row.way.to_string(),
        row.cases.to_string(),
        microseconds(row.nanoseconds.median),
        microseconds(row.nanoseconds.p95),
        microseconds(row.nanoseconds.max),
        format!("{:.4}", row.nanoseconds_per_offset_pixel),
        row.work_left.map_or(NOTHING.to_owned(), |left| format!("{:.1} %", left * 100.0)),
    ]
}

fn opencv(report: &Report) -> String {
    let opencv = &report.opencv;
    match (&opencv.version, &opencv.not_timed) {
        (Some(version), _) => format!("OpenCV {version}: {} on the same pixels\n", opencv.call),
        (None, why) => format!("OpenCV was not timed: {}\n", why.as_deref().unwrap_or(NOTHING)),
    }
}

/// Pairs down, windows across.
fn ratios(windows: &[Window]) -> String {
    let mut header = vec!["times as long (median)".to_owned(), "as".to_owned()];
    header.extend(windows.iter().map(|window| plus_minus(window.window)));
    let mut lines = vec![header];
    let mut pairs = Vec::new();
    for ratio in windows.iter().flat_map(|window| &window.ratios) {
        if !pairs.contains(&(ratio.of, ratio.to)) {
            pairs.push((ratio.of, ratio.to));
        }
    }
    for (of, to) in pairs {
        let mut line = vec![of.to_string(), to.to_string()];
        line.extend(windows.iter().map(|window| {
            let ratio = window.ratios.iter().find(|ratio| (ratio.of, ratio.to) == (of, to));
            ratio.map_or(NOTHING.to_owned(), |ratio| format!("{:.3}", ratio.median))
        }));
        lines.push(line);
    }
    if lines.len() > 1 { aligned(&lines, 2) } else { String::new() }
}

/// Templates down, windows across.
fn speeds(speeds: &[Speed]) -> String {
    let mut header = vec!["frames per second".to_owned()];
    header.extend(WINDOWS.map(plus_minus));
    let mut lines = vec![header];
    for (name, value) in
        [("pruned", (|speed| speed.pruned) as fn(&Speed) -> Option<f64>), ("exhaustive", |speed| speed.exhaustive)]
    {
        lines.extend(TEMPLATES.map(|side| {
            let of_side = speeds.iter().filter(|speed| speed.template == side);
            let figure = |speed| value(speed).map_or(NOTHING.to_owned(), |value| format!("{value:.0}"));
            std::iter::once(format!("{side}x{side}, {name}")).chain(of_side.map(figure)).collect()
        }));
    }
    aligned(&lines, 1)
}

fn boards(report: &Report) -> String {
    let header = ["instructions of an update, +-16", "recording", "box", "frames", "median", "p95", "max"];
    let mut lines = vec![header.map(String::from).to_vec()];
    let mut notes = String::new();
    for board in &report.boards {
        for measured in &board.recordings {
            let [width, height] = measured.target;
            let figures = [measured.instructions.median, measured.instructions.p95, measured.instructions.max];
            let mut line = vec![board.machine.to_owned(), measured.sequence.clone(), format!("{width}x{height}")];
            line.push(measured.frames.to_string());
            line.extend(figures.map(|figure| figure.to_string()));
            lines.push(line);
        }
        let frames: u32 = board.recordings.iter().map(|measured| measured.frames).sum();
        let figures = [board.instructions.median, board.instructions.p95, board.instructions.max];
        let mut line = vec![board.machine.to_owned(), "all".to_owned(), NOTHING.to_owned(), frames.to_string()];
        line.extend(figures.map(|figure| figure.to_string()));
        lines.push(line);
        for skipped in &board.skipped {
            notes += &format!("left out on {}: {skipped}\n", board.machine);
        }
    }
    aligned(&lines, 2) + &notes
}

fn goals(report: &Report) -> String {
    let header = ["goal (64x64 in the TLD recordings)", "at most", "measured", "verdict"];
    let mut lines = vec![header.map(String::from).to_vec()];
    for goal in &report.goals {
        let figure = |value: f64| format!("{value:.3} {}", goal.unit).trim_end().to_owned();
        let measured = goal.measured.map_or(NOTHING.to_owned(), figure);
        lines.push(vec![goal.work.clone(), figure(goal.at_most), measured, goal.verdict()]);
    }
    aligned(&lines, 1)
}

fn plus_minus(radius: Radius) -> String {
    format!("+-{}x{}", radius.x, radius.y)
}
