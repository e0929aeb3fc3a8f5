//! Event messages of targets: locked, corrected, lost, found, each with its time.

use smr_core::State;
use smr_evaluation::name_of;

pub struct Events(Vec<Seen>);

#[derive(Clone, Default)]
struct Seen {
    last: Option<State>,
    frames: [usize; State::ALL.len()],
}

impl Events {
    pub fn new(targets: usize) -> Self {
        Self(vec![Seen::default(); targets])
    }

    /// Counts the state of a tracker's answer. Returns the answer's event, such as `lost at 0:12.4 (frame 311)`, or
    /// `None` if the target was not locked, corrected, lost or found.
    pub fn of(&mut self, target: usize, locks: bool, frame: usize, time: Option<f64>, state: State) -> Option<String> {
        let seen = &mut self.0[target];
        let before = seen.last.replace(state);
        seen.frames[usize::from(state.code())] += 1;
        let event = match (before, state) {
            (None, _) => "locked",
            _ if locks => "corrected",
            (Some(before), State::Lost) if before != State::Lost => "lost",
            (Some(State::Lost), state) if state != State::Lost => "found",
            _ => return None,
        };
        let frame = format!("frame {frame}");
        Some(format!("{event} at {}", time.map_or(frame.clone(), |time| format!("{} ({frame})", clock(time)))))
    }

    /// Lists the states that a target had, each with its number of frames: `tracking 4, lost 2`.
    pub fn sum(&self, target: usize) -> String {
        let counts = self.0[target].frames.iter().zip(State::ALL).filter(|(count, _)| **count > 0);
        counts.map(|(count, state)| format!("{} {count}", name_of(state))).collect::<Vec<_>>().join(", ")
    }
}

/// Formats a time in minutes and seconds, with hours if there are any: `1:02:03.4`.
fn clock(seconds: f64) -> String {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
    let tenths = (seconds * 10.0).round() as u64;
    let (hours, minutes) = (tenths / 36_000, tenths / 600 % 60);
    let rest = format!("{}.{}", tenths / 10 % 60, tenths % 10);
    if hours > 0 { format!("{hours}:{minutes:02}:{rest:0>4}") } else { format!("{minutes}:{rest:0>4}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_as_on_a_clock() {
        assert_eq!([0.04, 12.35, 59.96, 3723.4].map(clock), ["0:00.0", "0:12.4", "1:00.0", "1:02:03.4"]);
    }

    #[test]
    fn only_changes_are_told() {
        let mut events = Events::new(1);
        let (seen, lost) = (State::Tracking, State::Lost);
        let answers = [(true, seen), (false, seen), (false, lost), (false, lost), (false, seen), (true, seen)];
        let told: Vec<String> = (1..)
            .zip(answers)
            .filter_map(|(frame, (locks, state))| events.of(0, locks, frame, Some(frame as f64), state))
            .collect();
        let expected = ["locked at 0:01.0 (frame 1)", "lost at 0:03.0 (frame 3)", "found at 0:05.0 (frame 5)"];
        assert_eq!(told, [&expected[..], &["corrected at 0:06.0 (frame 6)"]].concat());
        assert_eq!(events.sum(0), "tracking 4, lost 2");
    }
}
