//! Pages in headless Chromium: a script acts as a user would, and tells what it did not find.

use super::missing::{runs, skipped};
use super::program::utf8;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Headless Chromium under one of its names; `None`, with a note, if there is none.
fn browser(test: &str) -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| runs(Command::new(name).arg("--version")));
    if found.is_none() {
        skipped(test, "no Chromium");
    }
    found
}

/// An error of the page itself is a problem, too.
const BEFORE: &str = "<script>const problems = [];
window.onerror = (message) => { problems.push(message); };
window.onunhandledrejection = (event) => { problems.push(String(event.reason)); };</script>";

/// Functions for scripts: `is` notes a value that is not the expected one; `place` is the frame of a player, `unfold` shows what is folded.
const AFTER: [&str; 2] = [
    // A module comes after those of the page.
    r#"<script type="module">
const is = (what, given, wanted) => { if (String(given) !== String(wanted)) problems.push(`${what}: ${given}, not ${wanted}`); };
const pause = (time) => new Promise((resolve) => setTimeout(resolve, time));
// Takes no virtual time: that runs ahead of pictures that are decoded.
const until = async (isSo) => { const { port1, port2 } = new MessageChannel(); while (!isSo()) await new Promise((go) => { port1.onmessage = go; port2.postMessage(0); }); };
const place = () => document.getElementById("place").value;
const press = (key, shiftKey) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
const unfold = () => document.querySelectorAll("details").forEach((one) => { one.open = true; });
(async () => { try {"#,
    r#"} catch (error) { problems.push(String(error)); }
parent.postMessage(problems.length ? "PROBLEMS " + problems.join("; ") : "FINE", "*"); })();
</script></body>"#,
];

/// Opens `page` so many pixels wide, with this after `#` in the address, and runs `script` in it. Every problem fails the test.
#[track_caller]
pub fn act(test: &str, page: &Path, width: usize, address: &str, script: &str) {
    let Some(browser) = browser(test) else { return };
    let text = fs::read_to_string(page).unwrap();
    let text = text.replacen("<head>", &format!("<head>{BEFORE}"), 1);
    let tried = page.with_file_name(format!("{test}-{width}-tried.html"));
    fs::write(&tried, text.replacen("</body>", &[AFTER[0], script, AFTER[1]].concat(), 1)).unwrap();
    // Chromium's own window cannot be as narrow as a phone.
    let frame = page.with_file_name(format!("{test}-{width}-frame.html"));
    let receive = "<script>onmessage = (event) => { document.title = event.data; };</script>";
    let inner = format!("<iframe src=\"file://{}#{address}\" width=\"{width}\" height=\"900\"></iframe>", utf8(&tried));
    fs::write(&frame, format!("<title>no answer</title>{receive}{inner}")).unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000"])
        .arg("--virtual-time-budget=900000")
        .args(["--dump-dom", &format!("file://{}", utf8(&frame))])
        .output()
        .expect("it was there a moment ago");
    let dom = String::from_utf8_lossy(&output.stdout);
    let title = dom.split("<title>").nth(1).and_then(|rest| rest.split("</title>").next()).unwrap_or("no title");
    assert_eq!(title, "FINE", "{}", String::from_utf8_lossy(&output.stderr));
}
