//! Runs pages in headless Chromium: a script clicks and types, and reports what fails.

use super::missing::{runs, skipped};
use super::program::utf8;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

const WAIT: Duration = Duration::from_millis(20);
/// Number of polls, `WAIT` apart, until a script times out: two minutes in all, long enough for a busy machine.
const MAX_WAITS: usize = 6000;

/// Finds headless Chromium under one of its names. If there is none, prints that the test is skipped.
fn browser(test: &str) -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| runs(Command::new(name).arg("--version")));
    if found.is_none() {
        skipped(test, "no Chromium");
    }
    found
}

/// HTML that goes before the page's scripts and records the page's own errors as problems.
const BEFORE: &str = "<script>const problems = [];
window.onerror = (message) => { problems.push(message); };
window.onunhandledrejection = (event) => { problems.push(String(event.reason)); };</script>";

/// Script functions: `is` reports a wrong value, `place` returns e.g. `frame 2 of 240`, `unfold` opens folded parts.
const AFTER: [&str; 2] = [
    r#"<script type="module">
const is = (what, given, wanted) => { if (String(given) !== String(wanted)) problems.push(`${what}: ${given}, not ${wanted}`); };
const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));
const until = async (isSo) => { for (let waits = 0; !isSo(); waits++) { if (waits > 1000) throw new Error("not so in 20 s: " + isSo); await pause(20); } };
const place = () => document.getElementById("place").value;
const press = (key, shiftKey) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
const unfold = () => document.querySelectorAll("details").forEach((one) => { one.open = true; });
(async () => { try {"#,
    r#"} catch (error) { problems.push(String(error)); }
parent.postMessage(problems.length ? "PROBLEMS " + problems.join("; ") : "FINE", "*"); })();
</script></body>"#,
];

/// Opens `page#address` in an iframe `width` pixels wide, and runs `script` in it. A reported problem fails the test.
#[track_caller]
pub fn act(test: &str, page: &Path, width: usize, address: &str, script: &str) {
    let Some(browser) = browser(test) else { return };
    let text = fs::read_to_string(page).unwrap();
    let text = text.replacen("<head>", &format!("<head>{BEFORE}"), 1);
    let tried = page.with_file_name(format!("{test}-{width}-tried.html"));
    fs::write(&tried, text.replacen("</body>", &[AFTER[0], script, AFTER[1]].concat(), 1)).unwrap();
    // An iframe, because Chromium's own window cannot be as narrow as a phone.
    let frame = page.with_file_name(format!("{test}-{width}-frame.html"));
    // The script reports by opening an address of this server, so that timers run in real time.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let to = listener.local_addr().unwrap();
    let receive = format!(
        "<script>onmessage = (event) => {{ location = \"http://{to}/?\" + encodeURIComponent(event.data); }};</script>"
    );
    let inner = format!("<iframe src=\"file://{}#{address}\" width=\"{width}\" height=\"900\"></iframe>", utf8(&tried));
    fs::write(&frame, format!("{receive}{inner}")).unwrap();
    let profile = page.with_file_name(format!("{test}-{width}-profile"));
    let mut running = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000", "--no-first-run"])
        .args([format!("--user-data-dir={}", utf8(&profile)), format!("file://{}", utf8(&frame))])
        .stderr(Stdio::null())
        .spawn()
        .expect("it was there a moment ago");
    let answer = answer(&listener);
    running.kill().unwrap();
    running.wait().unwrap();
    assert_eq!(answer.as_deref(), Some("FINE"));
}

/// Returns the query of the requested address. Skips connections without a request: browsers open some in advance.
fn answer(listener: &TcpListener) -> Option<String> {
    listener.set_nonblocking(true).ok()?;
    (0..MAX_WAITS).find_map(|_| {
        thread::sleep(WAIT);
        let (stream, _) = listener.accept().ok()?;
        stream.set_read_timeout(Some(Duration::from_secs(1))).ok()?;
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).ok()?;
        Some(line.strip_prefix("GET /?")?.split(' ').next()?.replace("%20", " "))
    })
}
