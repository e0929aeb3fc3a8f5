//! Runs `host-sim` for the tests and checks its output.

use super::missing::runs;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// The path of the program, which cargo has built before these tests.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_host-sim");

pub struct Said {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

pub fn host_sim(arguments: &[&str]) -> Said {
    let Output { status, stdout, stderr } = Command::new(PROGRAM).args(arguments).output().expect("host-sim runs");
    let text = |bytes| String::from_utf8(bytes).expect("host-sim writes UTF-8");
    Said { code: status.code(), out: text(stdout), err: text(stderr) }
}

impl Said {
    /// Checks that host-sim refused its input: exit code 2, and one line on stderr that contains all of `words`.
    #[track_caller]
    pub fn refuses(&self, words: &[&str]) {
        assert_eq!(self.code, Some(2), "{}", self.err);
        assert_eq!(self.err.lines().count(), 1, "{}", self.err);
        for word in words {
            assert!(self.err.contains(word), "`{word}` is not in: {}", self.err);
        }
    }

    #[track_caller]
    pub fn json(&self) -> Value {
        assert_eq!(self.code, Some(0), "{}", self.err);
        serde_json::from_str(&self.out).expect("standard output is JSON")
    }
}

pub fn utf8(path: &Path) -> &str {
    path.to_str().expect("test paths are UTF-8")
}

/// Sends a signal by the shell's built-in `kill`, because some systems have no program `kill`. Returns `false` if the
/// process is gone.
#[cfg(unix)]
pub fn kill(signal: &str, process: &str) -> bool {
    runs(Command::new("sh").args(["-c", "kill \"$0\" \"$1\"", signal, process]))
}
