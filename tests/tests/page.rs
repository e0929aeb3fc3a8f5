//! The page of `host-sim report` in a browser: no error, the player steps, the curves follow.

mod program;

use program::{host_sim, utf8};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// Headless Chromium under one of its names; `None`, with a note, if there is none.
fn browser(test: &str) -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    if found.is_none() {
        // Not `println!`, which is not shown for a test that passes.
        let _ = writeln!(std::io::stderr(), "skipped: {test}: no Chromium");
    }
    found
}

/// The actions of a user, and what the page must then show. Every failure becomes a line of the list that the test reads.
const SCRIPT: &str = r##"
<script>
const problems = [];
/** The curves are drawn after the script that changes them. */
const drawn = () => new Promise((resolve) => setTimeout(resolve));
const is = (what, given, wanted) => { if (String(given) !== String(wanted)) problems.push(`${what}: ${given}, not ${wanted}`); };
(async () => { try {
  const press = (key, shiftKey) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
  const place = () => document.getElementById("place").value;
  is("start", place(), "frame 1 of 240");
  is("nothing to compare yet", getComputedStyle(document.getElementById("histogram")).display, "none");
  document.getElementById("on").click();
  is("a step", place(), "frame 2 of 240");
  press("ArrowRight"); press("ArrowRight", true);
  is("keys", place(), "frame 13 of 240");
  press("End");
  is("the end", place(), "frame 240 of 240");
  press("Home");
  const scrub = document.getElementById("scrub");
  scrub.value = 100;
  scrub.dispatchEvent(new Event("input", { bubbles: true }));
  is("scrubbing", place(), "frame 100 of 240");
  const boxes = () => document.querySelectorAll("#stage rect.box").length;
  const before = boxes();
  is("boxes that coincide share a line", document.querySelectorAll('#stage rect.box[style*="dasharray"]').length > 1, true);
  document.querySelector("#switches input").click();
  is("a method switched off", boxes() < before, true);
  document.querySelector("#switches input").click();
  await drawn();
  const curves = document.querySelectorAll("#curves .u-over");
  const area = curves[1].getBoundingClientRect();
  const mouse = (kind, part) => curves[1].dispatchEvent(
    new MouseEvent(kind, { clientX: area.left + part * area.width, clientY: area.top + area.height / 2, movementX: 1, bubbles: true }));
  for (const kind of ["mousemove", "mousedown", "mouseup", "click"]) mouse(kind, 0.75);
  const number = Number(place().split(" ")[1]);
  is("a click on a curve goes near " + number, number > 150 && number < 210, true);
  const cursors = () => [...document.querySelectorAll("#curves .cursor")].filter((cursor) => !cursor.hidden).length;
  is("the frame is marked in all curves", cursors(), curves.length);
  const values = () => document.querySelectorAll("#curves .u-legend")[1].textContent;
  is("the values of the frame", values().includes("frame" + number), true);
  mouse("mousedown", 0.1); mouse("mousemove", 0.3); mouse("mouseup", 0.3); mouse("click", 0.3);
  await drawn();
  is("a drag does not go to a frame", place(), `frame ${number} of 240`);
  is("a drag zooms, and all curves together", cursors(), 0);
  mouse("dblclick", 0.2);
  await drawn();
  is("a double click shows all frames", cursors(), curves.length);
  is("pictures to compare", document.querySelectorAll("#comparisons img, #comparisons canvas, #comparisons svg").length > 0, true);
} catch (error) { problems.push(String(error)); }
document.title = problems.length ? "PROBLEMS " + problems.join("; ") : "FINE"; })();
</script>
"##;

#[test]
fn the_page_plays_in_a_browser() {
    let Some(browser) = browser("the_page_plays_in_a_browser") else { return };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
    fs::create_dir_all(&folder).unwrap();
    let page = folder.join("report.html");
    let said = host_sim(&["report", "synthetic", "--method", "smr,robust,sad", "--out", utf8(&page)]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let text = fs::read_to_string(&page).unwrap();
    assert!(!text.contains("http://") || text.matches("http://").count() == text.matches("http://www.w3.org/").count());
    let watch = "<script>window.onerror = (message) => { document.documentElement.dataset.error = message; };</script>";
    let tried = folder.join("tried.html");
    fs::write(
        &tried,
        text.replacen("<head>", &format!("<head>{watch}"), 1).replacen("</body>", &format!("{SCRIPT}</body>"), 1),
    )
    .unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,2000", "--virtual-time-budget=5000"])
        .args(["--dump-dom", &format!("file://{}", utf8(&tried))])
        .output()
        .expect("it was there a moment ago");
    let dom = String::from_utf8_lossy(&output.stdout);
    let title = dom.split("<title>").nth(1).and_then(|rest| rest.split("</title>").next()).unwrap_or("no title");
    assert_eq!(title, "FINE", "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!dom.contains("data-error"), "an error in the page's script");
}
