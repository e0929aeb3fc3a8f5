//! The page of `host-sim report` in a browser: it has no errors, and player and curves show the same frame.

use crate::browser;
use crate::program::{host_sim, utf8};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page").join(test);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Copies the page for one test. Tests with the same arguments share one run of `report`, which takes seconds.
fn page(test: &str, arguments: &[&str]) -> PathBuf {
    static MADE: Mutex<BTreeMap<String, PathBuf>> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().unwrap();
    let report = made.entry(arguments.join(" ")).or_insert_with(|| {
        let report = folder(&format!("for-{test}")).join("report.html");
        let said = host_sim(&[&["report", "--out", utf8(&report)], arguments].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        report
    });
    let page = folder(test).join("report.html");
    fs::copy(report, &page).unwrap();
    page
}

/// Clicks and keys, each followed by a check of the page's state.
const PLAYER: &str = r##"
  is("start", place(), "frame 1 of 240");
  document.getElementById("on").click();
  is("a step", place(), "frame 2 of 240");
  press("ArrowRight"); press("ArrowRight", true);
  is("keys", place(), "frame 13 of 240");
  press("End");
  is("the end", place(), "frame 240 of 240");
  press("Home");
  is("whose state it is", document.getElementById("stage").ariaLabel, "frame 1 of 240, Paper: tracking, Robust: tracking");
  unfold();
  await pause(100);
  is("nothing to compare yet", getComputedStyle(document.getElementById("histogram")).display, "none");
  const scrub = document.getElementById("scrub");
  scrub.value = 100;
  scrub.dispatchEvent(new Event("input", { bubbles: true }));
  is("scrubbing", place(), "frame 100 of 240");
  await until(() => document.getElementById("stage").dataset.frame === "100");
  const drawn = () => document.getElementById("stage").toDataURL();
  const before = drawn();
  document.querySelector("#switches input").click();
  await until(() => drawn() !== before);
  document.querySelector("#switches input").click();
  await until(() => drawn() === before);
  const curves = document.querySelectorAll(".chart canvas");
  const area = curves[1].getBoundingClientRect();
  const mouse = (kind, part) => curves[1].dispatchEvent(
    new PointerEvent(kind, { clientX: area.left + part * area.width, clientY: area.top + area.height / 2, pointerId: 1, pointerType: "mouse", bubbles: true }));
  for (const kind of ["pointermove", "pointerdown", "pointerup"]) mouse(kind, 0.75);
  const number = Number(place().split(" ")[1]);
  is("a click on a curve goes near " + number, number > 150 && number < 210, true);
  const cursors = () => [...document.querySelectorAll(".cursor")].filter((cursor) => !cursor.hidden).length;
  is("the frame is marked in all curves", cursors(), curves.length);
  const values = () => document.querySelectorAll(".panel .frame")[1].textContent;
  is("the values of the frame", values().startsWith("frame " + number), true);
  mouse("pointerdown", 0.1); mouse("pointermove", 0.3); mouse("pointerup", 0.3);
  is("a drag does not go to a frame", place(), `frame ${number} of 240`);
  is("a drag zooms, and all curves together", cursors(), 0);
  is("the values of the frame under the pointer", values() === `frame ${number}`, false);
  mouse("pointerleave", 0.3);
  is("and without it of the frame that is shown", values().startsWith("frame " + number), true);
  document.querySelector("#switches input").click();
  is("who is switched on changes no zoom", cursors(), 0);
  document.querySelector("#switches input").click();
  document.querySelectorAll(".chart canvas")[1].dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
  is("a double click shows all frames", cursors(), curves.length);
  is("pictures to compare", document.querySelectorAll("#comparisons img").length > 0, true);
"##;

#[test]
fn the_page_plays_in_a_browser() {
    let page = page("page", &["synthetic", "--method", "paper,robust"]);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("host-sim report --out ") && text.contains(" synthetic --method "), "how to make it again");
    assert!(!text.contains("http://") || text.matches("http://").count() == text.matches("http://www.w3.org/").count());
    browser::act("the_page_plays_in_a_browser", &page, 1280, "frame=1", PLAYER);
}

const BY_ITSELF: &str = r##"
  const number = () => Number(place().split(" ")[1]);
  const play = document.getElementById("play");
  await until(() => number() > 3);
  is("it plays", play.ariaLabel, "Pause");
  play.click();
  const here = number();
  await pause(300);
  is("until it is told not to", number() + play.ariaLabel, here + "Play");
  is("the first sentence", /^The .* follows the target in (all|\d+ of) \d+ frames that show it; /.test(document.querySelector(".lead").textContent), true);
  is("one main part", document.querySelectorAll("main").length, 1);
  const named = (node) => node.ariaLabel || node.closest("label")?.textContent.trim() || node.textContent.trim();
  is("all controls have names", [...document.querySelectorAll("button, input, select, canvas:not([aria-hidden]), summary")].filter((node) => !named(node)).map((node) => node.outerHTML), "");
"##;

#[test]
fn the_page_plays_by_itself_and_begins_with_what_happened() {
    let test = "the_page_plays_by_itself_and_begins_with_what_happened";
    browser::act(test, &page("page-by-itself", &["synthetic", "--method", "paper,robust"]), 1280, "", BY_ITSELF);
}

/// Zooms and moves the curves. The horizontal position of the mark of frame 120 shows which part of them is visible.
const MOVING: &str = r##"
  const mark = () => Math.round(parseFloat(document.querySelectorAll(".cursor")[1].style.left));
  const over = () => document.querySelectorAll(".chart canvas")[1];
  const point = (type, kind, x, more) => over().dispatchEvent(new type(kind,
    { clientX: over().getBoundingClientRect().left + x, clientY: over().getBoundingClientRect().top + 50, bubbles: true, cancelable: true, ...more }));
  await until(() => mark() > 0);
  const middle = mark();
  point(WheelEvent, "wheel", 100, { deltaX: 40 });
  is("there is nothing to move yet", mark(), middle);
  press("+"); press("+");
  is("zoomed around the frame", mark(), middle);
  for (const [kind, x] of [["pointerdown", 100], ["pointermove", 130], ["pointerup", 130]]) point(PointerEvent, kind, x, { shiftKey: true });
  is("moved by shift and a drag", mark(), middle + 30);
  point(WheelEvent, "wheel", 100, { deltaX: 20 });
  is("moved by the wheel", mark(), middle + 10);
  point(WheelEvent, "wheel", 100, { deltaY: 20 });
  is("the wheel up and down is the page's", mark(), middle + 10);
  const finger = (kind, id, x) => point(PointerEvent, kind, x, { pointerType: "touch", pointerId: id });
  finger("pointerdown", 1, 50); finger("pointermove", 1, 30); finger("pointerup", 1, 30);
  is("moved by a finger", mark(), middle - 10);
  press("0");
  is("all frames", mark(), middle);
  finger("pointerdown", 1, middle - 20); finger("pointerdown", 2, middle + 20);
  finger("pointermove", 1, middle - 40); finger("pointermove", 2, middle + 60);
  finger("pointerup", 1, 0); finger("pointerup", 2, 0);
  is("pinched: other frames than before", mark() !== middle, true);
  finger("pointerdown", 1, middle + 40); finger("pointercancel", 1, middle + 40);
  is("none of these is a click, nor a finger that scrolls the page", place(), "frame 120 of 240");
  press("+");
  press("0");
"##;

#[test]
fn curves_move_and_zoom_by_mouse_wheel_fingers_and_keys() {
    let test = "curves_move_and_zoom_by_mouse_wheel_fingers_and_keys";
    browser::act(test, &page("page-moving", &["synthetic", "--method", "paper"]), 1280, "frame=120", MOVING);
}

const EVENTS: &str = r##"
  const events = [...document.querySelectorAll("#events button")];
  const words = events.map((event) => event.textContent);
  is("what happened, and when", words[0], "locked at 0:00.0");
  const [lost, found] = ["lost", "found"].map((kind) => words.findIndex((word) => word.startsWith(kind + " at 0:0")));
  is("in its order: " + words, 0 < lost && lost < found, true);
  const numbers = events.map((event) => Number(event.parentNode.dataset.frame));
  const there = (at) => `frame ${numbers[at]} of 240, 0:0${((numbers[at] - 1) / 25).toFixed(1)}`;
  events[lost].click();
  is("a click goes there", place(), there(lost));
  is("and marks it", document.querySelector("#events [aria-current]").textContent, words[lost]);
  press("]");
  is("the next one", place(), there(lost + 1));
  press("["); press("[");
  is("and back", place(), there(lost - 1));
  const scrub = document.getElementById("scrub");
  is("said with the slider", scrub.getAttribute("aria-valuetext"), `0:0${((numbers[lost - 1] - 1) / 25).toFixed(1)} (frame ${numbers[lost - 1]})`);
"##;

#[test]
fn events_are_listed_with_their_times_and_lead_there() {
    let page = page("page-events", &["synthetic", "--method", "paper"]);
    let text = fs::read_to_string(&page).unwrap();
    assert_eq!(text.matches("\"times\":null").count(), 1);
    let times: Vec<String> = (0..240).map(|frame| format!("{:.2}", f64::from(frame) / 25.0)).collect();
    fs::write(&page, text.replace("\"times\":null", &format!("\"times\":[{}]", times.join(",")))).unwrap();
    browser::act("events_are_listed_with_their_times_and_lead_there", &page, 390, "frame=1", EVENTS);
}

const PORTRAIT: &str = r##"
  const high = () => document.getElementById("stage").getBoundingClientRect().height / innerHeight;
  await until(() => high() > 0.7);
  document.querySelector("#curves .panel").scrollIntoView({ block: "center" });
  // Headless browsers send no scroll event.
  dispatchEvent(new Event("scroll"));
  is("small beside the curves: " + high(), high() < 0.3, true);
  document.querySelector("footer").scrollIntoView();
  dispatchEvent(new Event("scroll"));
  is("gone at the end", document.getElementById("screen").getBoundingClientRect().bottom <= 1, true);
"##;

#[test]
fn an_upright_recording_is_as_high_as_the_window_allows() {
    let arguments = ["synthetic", "--frames", "1..40", "--resize", "90x200", "--init", "20,40,14,46"];
    let page = page("page-portrait", &arguments);
    browser::act("an_upright_recording_is_as_high_as_the_window_allows", &page, 390, "frame=1", PORTRAIT);
}

const STAYS: &str = r##"
  const stage = () => document.getElementById("stage").getBoundingClientRect();
  const curves = document.querySelectorAll("#curves .panel");
  await pause(200);
  for (const panel of [curves[0], curves[1]]) {
    panel.scrollIntoView({ block: "center" });
    await pause(20);
    is("the player is in view: " + [stage().top, stage().bottom, innerHeight], stage().top >= 0 && stage().bottom <= innerHeight, true);
    is("the curve is in view: " + panel.getBoundingClientRect().bottom, panel.getBoundingClientRect().bottom > 0 && panel.getBoundingClientRect().bottom <= innerHeight + 1, true);
    const apart = innerWidth > 1000 ? stage().right <= panel.getBoundingClientRect().left : stage().bottom <= panel.querySelector("canvas").getBoundingClientRect().top;
    is("neither hides the other", apart, true);
    const play = document.getElementById("play").getBoundingClientRect();
    is("the player is on top", document.elementFromPoint(play.left + play.width / 2, play.top + play.height / 2).id, "play");
  }
  const root = document.documentElement;
  is("nothing is wider than the window", root.scrollWidth, root.clientWidth);
  unfold();
  is("not even what was folded", root.scrollWidth, root.clientWidth);
"##;

#[test]
fn the_player_stays_in_view_and_nothing_is_too_wide() {
    let page = page("page-stays", &["synthetic", "border", "--method", "paper"]);
    for width in [390, 1280] {
        browser::act("the_player_stays_in_view_and_nothing_is_too_wide", &page, width, "frame=60", STAYS);
    }
}

const ADDRESS: &str = r##"
  // Resolves after the page has handled the new address.
  const typed = (address) => new Promise((heard) => {
    addEventListener("hashchange", () => setTimeout(heard), { once: true });
    location.hash = address;
  });
  const select = document.getElementById("recording");
  is("the frame and the recording of the address", place() + select.selectedOptions[0].text, "frame 20 of 25border");
  document.getElementById("on").click();
  await until(() => location.hash === "#recording=border&frame=21");
  await typed("recording=synthetic&frame=100");
  is("another one is typed", place() + select.selectedOptions[0].text, "frame 100 of 240synthetic");
  await typed("frame=9999");
  is("beyond the last frame", place(), "frame 240 of 240");
"##;

#[test]
fn the_address_names_the_frame() {
    let page = page("page-address", &["synthetic", "border", "--method", "paper"]);
    browser::act("the_address_names_the_frame", &page, 1280, "recording=border&frame=20", ADDRESS);
}

/// Checks the frame numbers of a page with 240 frames, the first of which has the number 601.
const NUMBERS: &str = r##"
  is("the number in the address", place(), "frame 700 of 840");
  is("of the picture", document.getElementById("stage").ariaLabel.startsWith("frame 700 of 840, "), true);
  is("of the slider", [document.getElementById("scrub").min, document.getElementById("scrub").max, document.getElementById("scrub").value], "601,840,700");
  unfold();
  await until(() => document.querySelectorAll(".panel .frame")[1].textContent.startsWith("frame 700"));
  is("in the states", document.querySelector("#more .value").textContent.includes("in 601 to 7"), true);
  await until(() => document.getElementById("compared").textContent.startsWith("Frame 700."));
  const cursor = document.querySelector(".cursor");
  is("its mark", Math.abs((parseFloat(cursor.style.left) - 56) / (cursor.parentNode.clientWidth - 70) - 99.5 / 240) < 0.01, true);
  document.getElementById("on").click();
  await until(() => location.hash === "#frame=701");
"##;

#[test]
fn one_number_shifts_all_frame_numbers() {
    let page = page("page-numbers", &["synthetic", "--method", "paper"]);
    let text = fs::read_to_string(&page).unwrap();
    assert_eq!(text.matches("\"first\":1,").count(), 1);
    fs::write(&page, text.replace("\"first\":1,", "\"first\":601,")).unwrap();
    browser::act("one_number_shifts_all_frame_numbers", &page, 1280, "frame=700", NUMBERS);
}

const LOOKS: &str = r##"
  document.querySelectorAll("#switches input").forEach((input) => { if (!input.checked) input.click(); });
  await pause(0);
  const styleOf = (node) => { const { stroke, strokeDasharray } = getComputedStyle(node); return stroke + " " + strokeDasharray; };
  const looks = (nodes) => [...nodes].map((node) => styleOf(node));
  const colors = (nodes) => new Set([...nodes].map((node) => getComputedStyle(node).stroke)).size;
  const switches = document.querySelectorAll("#switches .sample path");
  is("each of twenty entrants and the truth has a switch", switches.length, 21);
  is("each has a color of its own", colors(switches), 21);
  is("some lines are solid, others dashed", new Set([...switches].map((node) => getComputedStyle(node).strokeDasharray)).size, 5);
  const legend = document.querySelector("#curves .panel").querySelectorAll(".value .sample path");
  is("the legend of a curve is like the switches", looks(legend).join(), looks(switches).slice(0, 20).join());
  is("and so are the tables", looks(document.querySelectorAll(".scroll tbody .sample path")).join(), looks(switches).slice(0, 20).join());
  const stage = document.getElementById("stage");
  await until(() => stage.dataset.frame === "6");
  const { data } = stage.getContext("2d").getImageData(0, 0, stage.width, stage.height);
  const pixels = new Set();
  for (let at = 0; at < data.length; at += 4) pixels.add(`rgb(${data[at]}, ${data[at + 1]}, ${data[at + 2]})`);
  const onDark = (node) => { Object.assign(node.style, { colorScheme: "dark", color: "var(--line)" }); return getComputedStyle(node).color; };
  const onFrame = [...document.querySelectorAll("#switches .sample")].map(onDark);
  is("on frames, too, each has a color of its own", new Set(onFrame).size, 21);
  is("boxes of all of them: " + onFrame, onFrame.filter((color) => !pixels.has(color)), "");
"##;

/// Makes a recording with result files of 14 other trackers. With the six methods the page shows 20 entrants.
fn with_trackers(test: &str) -> PathBuf {
    let recording = folder(test).join("recording");
    let made = host_sim(&["convert", "synthetic", "--frames", "1..12", "-o", utf8(&recording)]);
    assert_eq!(made.code, Some(0), "{}", made.err);
    fs::create_dir(recording.join("trackers")).unwrap();
    for tracker in 0..14 {
        let (left, top) = (5 * tracker, 3 * tracker);
        let lines = format!("{left},{top},{},{}\n", left + 30, top + 20).repeat(12);
        fs::write(recording.join(format!("trackers/tracker{tracker}.txt")), lines).unwrap();
    }
    recording
}

#[test]
fn twenty_entrants_look_different_everywhere() {
    let recording = with_trackers("page-looks-recording");
    let page = page("page-looks", &[utf8(&recording), "--method", "robust,paper,sad,ssd,ncc,lk"]);
    browser::act("twenty_entrants_look_different_everywhere", &page, 1280, "frame=6", LOOKS);
}

const SORTED: &str = r##"
  const table = document.querySelector(".scroll table");
  const column = (at) => [...table.tBodies[0].rows].map((row) => row.cells[at].textContent.trim());
  const header = (at) => table.tHead.rows[0].cells[at];
  const sort = (at) => header(at).querySelector("button").click();
  const figure = [...table.tHead.rows[0].cells].findIndex((cell) => cell.textContent.trim() === "OTB AUC");
  const before = column(figure).map(Number);
  is("there is something to sort", new Set(before).size > 2, true);
  sort(figure);
  is("the largest first", column(figure).map(Number), [...before].sort((a, b) => b - a));
  is("said to all", header(figure).getAttribute("aria-sort"), "descending");
  sort(figure);
  is("the smallest first", column(figure).map(Number), [...before].sort((a, b) => a - b));
  const names = column(0);
  sort(0);
  is("by name", column(0), [...names].sort((a, b) => a.localeCompare(b)));
  is("one column is sorted by", document.querySelectorAll("[aria-sort]").length, 1);
  const late = [...table.tHead.rows[0].cells].findIndex((cell) => cell.textContent.trim() === "first failure");
  for (const order of ["descending", "ascending"]) {
    sort(late);
    is("without a figure comes last, " + order, column(late).join().replace(/(-,?)+$/, "").includes("-"), false);
  }
"##;

#[test]
fn tables_are_sorted_by_their_headers() {
    let recording = with_trackers("page-sorted-recording");
    let page = page("page-sorted", &[utf8(&recording)]);
    browser::act("tables_are_sorted_by_their_headers", &page, 1280, "frame=1", SORTED);
}
