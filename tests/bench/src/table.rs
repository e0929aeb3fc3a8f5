//! The measurements as text.

use super::goal::STATED_FOR;
use super::report::Report;
use super::speeds::{Speed, TEMPLATES, WINDOWS};
use super::window::{Row, Window};
use smr_core::paper::Radius;
use smr_evaluation::{NOTHING, aligned, cell, header};

/// Everything that was measured, table by table.
pub fn text(report: &Report) -> String {
    let Report { processor, recordings, template, every, .. } = report;
    let mut parts = vec![format!(
        "{processor}, one thread; {}: every {every}. frame with ground truth, template {template}\n",
        recordings.join(", ")
    )];
    parts.extend(report.windows.iter().map(window));
    parts.push(ratios(&report.windows));
    parts.push(speeds(&report.speeds));
    parts.push("instructions on this machine are not counted here: .ci/instructions does, with valgrind\n".to_owned());
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
    let mut lines = vec![header("way|searches|median us|p95 us|max us|ns/offset/pixel|work left|work")];
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
        cell(row.nanoseconds_per_offset_pixel, 4),
        row.work_left.map_or(NOTHING.to_owned(), |left| format!("{:.1} %", left * 100.0)),
        row.work.map_or(NOTHING.to_owned(), |work| work.to_string()),
    ]
}

/// Pairs down, windows across.
fn ratios(windows: &[Window]) -> String {
    let mut titles = header("times as long (median)|as");
    titles.extend(windows.iter().map(|window| plus_minus(window.window)));
    let mut lines = vec![titles];
    let mut pairs = Vec::new();
    for ratio in windows.iter().flat_map(|window| &window.ratios) {
        if !pairs.contains(&(ratio.of, ratio.to)) {
            pairs.push((ratio.of, ratio.to));
        }
    }
    for (of, to) in pairs {
        let mut line = vec![of.to_string(), to.to_string()];
        line.extend(windows.iter().map(|window| cell(window.ratio(of, to), 3)));
        lines.push(line);
    }
    if lines.len() > 1 { aligned(&lines, 2) } else { String::new() }
}

/// Templates down, windows across.
fn speeds(speeds: &[Speed]) -> String {
    let mut lines = vec![header("frames per second").into_iter().chain(WINDOWS.map(plus_minus)).collect()];
    for (name, value) in
        [("pruned", (|speed| speed.pruned) as fn(&Speed) -> Option<f64>), ("exhaustive", |speed| speed.exhaustive)]
    {
        lines.extend(TEMPLATES.map(|side| {
            let of_side = speeds.iter().filter(|speed| speed.template == side);
            let figures = of_side.map(|speed| cell(value(speed), 0));
            std::iter::once(format!("{side}x{side}, {name}")).chain(figures).collect()
        }));
    }
    aligned(&lines, 1)
}

fn goals(report: &Report) -> String {
    let title = format!("goals are stated for {STATED_FOR}; measured: {}", report.recordings.join(", "));
    let mut lines = vec![header("goal|at most|measured|compared")];
    for goal in &report.goals {
        let figure = |value: f64| format!("{value:.3} {}", goal.unit).trim_end().to_owned();
        let measured = goal.measured.map_or(NOTHING.to_owned(), figure);
        lines.push(vec![goal.work.clone(), figure(goal.at_most), measured, goal.compared()]);
    }
    format!("{title}\n{}", aligned(&lines, 1))
}

fn plus_minus(radius: Radius) -> String {
    format!("+-{}x{}", radius.x, radius.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::goal::Goal;
    use crate::sad::Sad;
    use crate::searches::Way;
    use crate::window::Ratio;
    use host_sim::percentiles::Spread;
    use smr_core::similarity::Backend;

    fn report() -> Report {
        let plain = Way::Sad(Sad::Plain);
        let exhaustive = Way::Update { backend: Backend::Scalar, pruning: false };
        let nanoseconds = Spread { median: 1_250, p95: 2_000, max: 3_000 };
        let row = |way, work_left| Row {
            way,
            cases: 2,
            nanoseconds,
            nanoseconds_per_offset_pixel: Some(0.5),
            work_left,
            work: None,
        };
        let ratios = vec![Ratio { of: plain, to: exhaustive, cases: 2, median: 1.5 }];
        let (near, ways) = (Radius { x: 1, y: 1 }, vec![row(plain, Some(1.0)), row(exhaustive, None)]);
        let window = Window { window: near, offsets: 9, cases: 2, skipped: 1, ways, ratios };
        let empty = Window { window: WINDOWS[4], offsets: 12221, cases: 0, skipped: 3, ways: vec![], ratios: vec![] };
        Report {
            version: "0",
            methods: vec!["smr"],
            processor: "a processor".into(),
            recordings: vec!["one".into(), "two".into()],
            template: "own".into(),
            every: 5,
            windows: vec![window, empty],
            speeds: vec![],
            eval_seconds: None,
            goals_stated_for: STATED_FOR,
            goals: vec![Goal::new("work".into(), 2.0, "s", Some(1.0))],
            differences: vec![],
        }
    }

    #[test]
    fn everything_is_in_a_table() {
        let expected = [
            "a processor, one thread; one, two: every 5. frame with ground truth, template own",
            "window +-1x1: 9 offsets, 2 searches; 1 left out, for which the frame has no room",
            "SAD, plain loop            2        1.2     2.0     3.0           0.5000    100.0 %     -",
            "Scalar, exhaustive         2        1.2     2.0     3.0           0.5000          -     -",
            "window +-60x50: 12221 offsets, 0 searches; 3 left out, for which the frame has no room",
            "SAD, plain loop         Scalar, exhaustive  1.500        -",
            "goals are stated for templates of 64x64 in the six TLD recordings \
             (../shared/sequences/tld); measured: one, two",
            "work  2.000 s   1.000 s  within: 0.50 of it",
        ];
        let text = text(&report());
        for line in expected {
            assert!(text.lines().any(|printed| printed == line), "`{line}` is not a line of:\n{text}");
        }
    }
}
