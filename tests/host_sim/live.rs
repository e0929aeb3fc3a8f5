//! Live sources: host-sim drops and counts frames that come while the tracker is busy; Ctrl-C stops the source cleanly.

use crate::missing::has_ffmpeg;
use crate::program::{PROGRAM, Said, host_sim, utf8};
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// An ffmpeg process that serves a test picture as a stream.
struct Server {
    process: Child,
    address: String,
}

impl Server {
    fn start(rate: &[&str], seconds: &str) -> Self {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let address = format!("http://127.0.0.1:{port}/camera");
        let source = format!("testsrc2=size=320x240:rate=30:duration={seconds}");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "quiet"]).args(rate).args(["-f", "lavfi", "-i", &source, "-c:v", "mpeg4"]);
        ffmpeg.args(["-flush_packets", "1", "-listen", "1", "-f", "matroska", &address]);
        Self { process: ffmpeg.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap(), address }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Repeats `run` until it returns a value; `None` means that the server does not accept connections yet.
fn when_it_listens<T>(mut run: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(done) = run() {
            return done;
        }
        assert!(begin.elapsed() < Duration::from_secs(30), "nobody listens");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn what_comes_too_fast_is_dropped_and_counted() {
    if !has_ffmpeg("what_comes_too_fast_is_dropped_and_counted") {
        return;
    }
    let server = Server::start(&[], "20");
    let folder = tempfile::tempdir().unwrap();
    let boxes = folder.path().join("boxes.csv");
    let arguments = ["track", &server.address, "--init", "100,80,60,60", "--format", "csv", "-o", utf8(&boxes)];
    let Said { code, err, .. } = when_it_listens(|| {
        let said = host_sim(&arguments);
        (!said.err.contains("refused")).then_some(said)
    });
    assert_eq!(code, Some(0), "{err}");
    let end = err.lines().last().unwrap();
    let mut counts = end.split_once("camera: ").unwrap().1.split(' ').filter_map(|word| word.parse::<usize>().ok());
    let (came, dropped) = (counts.next().unwrap(), counts.next().unwrap());
    let csv = std::fs::read_to_string(&boxes).unwrap();
    let rows: Vec<(usize, f64)> = csv.lines().skip(1).map(number_and_time).collect();
    assert_eq!((rows.len(), rows[0]), (came - dropped, (1, 0.0)), "{end}");
    assert!(rows.is_sorted() && rows.last().unwrap().0 <= came, "{end}");
    assert!(dropped > 0, "600 frames are sent at once: {end}");
    assert!(err.contains("warning") && err.contains("frames are dropped"), "{err}");
}

fn number_and_time(row: &str) -> (usize, f64) {
    let mut fields = row.split(',');
    (fields.next().unwrap().parse().unwrap(), fields.next().unwrap().parse().unwrap())
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_live_source_with_what_was_written() {
    if !has_ffmpeg("ctrl_c_ends_a_live_source_with_what_was_written") {
        return;
    }
    let server = Server::start(&["-re"], "600");
    let folder = tempfile::tempdir().unwrap();
    let video = folder.path().join("boxes.mp4");
    let (mut process, mut lines) = when_it_listens(|| {
        let mut command = Command::new(PROGRAM);
        command.args(["track", &server.address, "--init", "100,80,60,60", "--video"]).arg(&video);
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        lines.next().map(|first| (process, std::iter::once(first).chain(lines)))
    });
    assert_eq!(lines.by_ref().take(10).count(), 10);
    assert!(crate::program::kill("-INT", &process.id().to_string()));
    let rest = lines.count();
    assert_eq!(process.wait().unwrap().code(), Some(0));
    let made = smr_recordings::open(&video, &smr_recordings::OpenOptions::default()).unwrap();
    assert_eq!(made.frames.map(Result::unwrap).count(), 10 + rest);
}

#[test]
fn what_is_secret_in_an_address_is_not_printed() {
    if !has_ffmpeg("what_is_secret_in_an_address_is_not_printed") {
        return;
    }
    let said = host_sim(&["track", "rtsp://me:secret@127.0.0.1:1/a?key=abc", "--init", "1,1,9,9"]);
    said.refuses(&["ffmpeg cannot read rtsp://127.0.0.1:1/a: "]);
    assert!(!said.err.contains("secret") && !said.err.contains("abc"), "{}", said.err);
}
