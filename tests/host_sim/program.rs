//! Runs `host-sim` for the tests and checks its output.

use super::missing::runs;
use serde_json::Value;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The path of the program, which cargo has built before these tests.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_host-sim");

/// Time after which a run that should have ended fails its test.
const LIMIT: Duration = Duration::from_secs(120);

pub struct Said {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

pub fn host_sim(arguments: &[&str]) -> Said {
    let Output { status, stdout, stderr } = output(Command::new(PROGRAM).args(arguments).stdout(Stdio::piped()));
    let text = |bytes| String::from_utf8(bytes).expect("host-sim writes UTF-8");
    Said { code: status.code(), out: text(stdout), err: text(stderr) }
}

/// Runs a command without input, and returns its errors and its output, if `command` pipes it. Panics if the command
/// does not end: a `view` that should have been refused would otherwise wait for Ctrl-C.
pub fn output(command: &mut Command) -> Output {
    let mut child = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().expect("host-sim runs");
    let (out, err) = (collected(child.stdout.take()), collected(child.stderr.take()));
    let Some(status) = status_in_time(&mut child) else {
        child.kill().expect("it can be killed");
        let [out, err] = [out, err].map(|bytes| String::from_utf8_lossy(&bytes.join().unwrap()).into_owned());
        panic!("{command:?} has not ended for {} s:\n{out}{err}", LIMIT.as_secs());
    };
    Output { status, stdout: out.join().unwrap(), stderr: err.join().unwrap() }
}

fn collected(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(|| {
        let mut bytes = Vec::new();
        pipe.map_or(Ok(0), |mut pipe| pipe.read_to_end(&mut bytes)).expect("a pipe can be read");
        bytes
    })
}

fn status_in_time(child: &mut Child) -> Option<std::process::ExitStatus> {
    let start = Instant::now();
    while start.elapsed() < LIMIT {
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            return Some(status);
        }
        thread::sleep(Duration::from_millis(1));
    }
    None
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
