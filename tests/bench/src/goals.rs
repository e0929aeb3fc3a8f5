//! The goals for smr-core's speed, beside the measured figures. Each goal is stated for certain recordings; figures from
//! other recordings are shown next to it, but do not say whether it is reached.

use super::goal::Goal;
use super::report::Report;
use super::sad::Sad;
use super::searches::Way;
use smr_core::paper::Radius;
use smr_core::similarity::Backend;

const NEAR: Radius = Radius { x: 16, y: 16 };
const FAR: Radius = Radius { x: 60, y: 50 };

/// Every goal, with what was measured for it. Those beside OpenCV are in `others/host.py`.
pub fn all(measured: &Report) -> Vec<Goal> {
    let avx2 = |pruning| Way::Update { backend: Backend::Avx2, pruning };
    let psadbw = Way::Sad(Sad::Psadbw);
    vec![
        ratio(measured, NEAR, avx2(true), avx2(false), 1.0 / 8.0),
        ratio(measured, NEAR, avx2(false), psadbw, 2.4),
        ratio(measured, FAR, avx2(false), psadbw, 2.4),
        Goal::new("eval of the recordings, 2 threads".to_owned(), 4.0, "s", measured.eval_seconds),
    ]
}

fn ratio(measured: &Report, radius: Radius, of: Way, to: Way, at_most: f64) -> Goal {
    let work = format!("+-{}x{}: {of} / {to}", radius.x, radius.y);
    let window = measured.windows.iter().find(|window| window.window == radius);
    // No goal is stated for templates of another size.
    let ratio = window.and_then(|window| window.ratio(of, to)).filter(|_| measured.template == "64x64");
    Goal::new(work, at_most, "", ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_measured_is_within_a_goal_or_beyond() {
        let goal = |measured| Goal::new(String::new(), 2.0, "s", measured);
        assert_eq!(goal(Some(1.0)).compared(), "within: 0.50 of it");
        assert_eq!(goal(Some(2.0)).compared(), "within: 1.00 of it");
        assert_eq!(goal(Some(3.0)).compared(), "beyond: 1.50 times as much");
        assert_eq!(goal(None).compared(), "not measured");
    }
}
