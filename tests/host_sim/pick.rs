//! The page of `host-sim frame`, with and without a browser: a box that is dragged is in the command line.

use crate::browser;
use crate::program::{host_sim, utf8};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pick").join(test);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// What the script of a page reads.
fn data(page: &Path) -> Value {
    let text = fs::read_to_string(page).unwrap();
    let data = text.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    serde_json::from_str(data).unwrap()
}

fn numbers(data: &Value) -> Vec<u64> {
    data["frames"].as_array().unwrap().iter().map(|frame| frame[0].as_u64().unwrap()).collect()
}

#[test]
fn the_page_has_the_frames_of_a_built_in_recording() {
    let page = folder("pick-built-in").join("pick.HTML");
    let said = host_sim(&["frame", "synthetic", "41", "-o", utf8(&page), "--json"]).json();
    assert_eq!(said["bytes"], fs::metadata(&page).unwrap().len());
    assert_eq!((&said["frame"], &said["pictures"], &said["box"]), (&41.into(), &240.into(), &Value::Null));
    let data = data(&page);
    assert_eq!((&data["shown"], &data["last"], &data["box"]), (&41.into(), &240.into(), &Value::Null));
    assert_eq!(numbers(&data), (1..=240).collect::<Vec<_>>());
    let first = host_sim(&["frame", "synthetic", "-o", utf8(&page)]);
    assert!(first.out.contains("240 frames to go through"), "{}", first.out);
    assert_eq!(box_of(&page), [36, 24, 24, 28], "the box beside the recording is that of its first frame");
    host_sim(&["frame", "synthetic", "241", "-o", utf8(&page)]).refuses(&["no frame 241", "1 to 240"]);
}

fn box_of(page: &Path) -> [i64; 4] {
    let data = data(page);
    ["x", "y", "w", "h"].map(|key| data["box"][key].as_i64().unwrap())
}

#[test]
fn the_page_of_a_folder_has_the_options_and_the_numbers_of_the_recording() {
    let folder = folder("pick folder");
    let (frames, page) = (folder.join("my frames"), folder.join("pick.html"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..30", "-o", utf8(&frames)]).code, Some(0));
    let options = ["--frames", "11..20", "--resize", "1/3"];
    let said = host_sim(&[&["frame", utf8(&frames), "13", "-o", utf8(&page)][..], &options].concat());
    assert_eq!(said.code, Some(0), "{}", said.err);
    let data = data(&page);
    assert_eq!((&data["width"], &data["height"]), (&160.into(), &120.into()), "the recording's own size");
    assert_eq!(numbers(&data), (11..=20).collect::<Vec<_>>());
    assert_eq!((&data["shown"], &data["least"]), (&13.into(), &serde_json::json!([3, 3])));
    assert_eq!(data["track"][0], format!("host-sim track '{}'", utf8(&frames)));
    assert_eq!(data["track"][1], "--resize 1/3 --frames 11..20 --video out.mp4");
    assert_eq!(data["report"][1], "--resize 1/3 --frames 11..20 -o report.html");
    let outside = host_sim(&[&["frame", utf8(&frames), "5", "-o", utf8(&page)][..], &options].concat());
    outside.refuses(&["no frame 5", "11 to 20"]);
    let picture = folder.join("frame.png");
    let said = host_sim(&["frame", utf8(&frames), "-o", utf8(&picture), "--frames", "11..20", "--json"]).json();
    assert_eq!(said["frame"], 11, "a picture has the same numbers");
}

/// A picture of another size is damage: `track` ends there.
#[test]
fn the_page_of_a_folder_ends_where_track_does() {
    let folder = folder("pick-damaged");
    let (frames, small, page) = (folder.join("frames"), folder.join("small"), folder.join("pick.html"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "1..20", "-o", utf8(&frames)]).code, Some(0));
    let one = ["convert", "synthetic", "--frames", "1..1", "--resize", "80x60", "-o", utf8(&small)];
    assert_eq!(host_sim(&one).code, Some(0));
    fs::copy(small.join("00001.png"), frames.join("00010.png")).unwrap();
    assert_eq!(host_sim(&["track", utf8(&frames)]).out.lines().count(), 9);
    let said = host_sim(&["frame", utf8(&frames), "-o", utf8(&page)]);
    assert_eq!((said.code, numbers(&data(&page))), (Some(0), (1..=9).collect()));
    assert!(
        said.err.starts_with("note: the page ends before damage: ") && said.err.contains("frame 10"),
        "{}",
        said.err
    );
    let beyond = host_sim(&["frame", utf8(&frames), "15", "-o", utf8(&page)]);
    assert_eq!(beyond.code, Some(2));
    assert!(beyond.err.contains("there is no frame 15: expected 1 to 9"), "{}", beyond.err);
}

/// A user with a mouse, then with keys, then with a second target.
const SCRIPT: &str = r##"
  const byId = (id) => document.getElementById(id);
  const stage = byId("stage");
  const line = () => byId("track").textContent.replace("host-sim track synthetic ", "");
  const point = (kind, x, y, pointerType = "mouse") => {
    const { left, top, width } = stage.getBoundingClientRect();
    const scale = width / 160;
    const at = { clientX: left + x * scale, clientY: top + y * scale };
    stage.dispatchEvent(new PointerEvent(kind, { ...at, button: kind === "pointermove" ? -1 : 0, pointerId: 1, pointerType, isPrimary: true, bubbles: true }));
  };
  const drag = (from, to, type) => { point("pointerdown", ...from, type); point("pointermove", ...to, type); point("pointerup", ...to, type); };
  const key = (key, more) => stage.dispatchEvent(new KeyboardEvent("keydown", { key, ...more, bubbles: true, cancelable: true }));
  is("nothing is wider than the window", document.documentElement.scrollWidth, document.documentElement.clientWidth);
  is("only the picture keeps fingers to itself", getComputedStyle(stage).touchAction + getComputedStyle(document.body).touchAction, "noneauto");
  is("the frame in the address", byId("place").value, "frame 120 of 240");
  is("nothing to copy yet", document.querySelector("[data-of=track]").disabled, true);
  drag([30.2, 40.3], [69.8, 80.4]);
  is("a box", line(), "--init 30,40,40,40@120 --video out.mp4");
  drag([50, 60], [55, 62], "touch");
  is("moved", line(), "--init 35,42,40,40@120 --video out.mp4");
  drag([75, 82], [500, 90], "pen");
  is("its corner dragged beyond the frame", line(), "--init 35,42,125,48@120 --video out.mp4");
  drag([35, 66], [45, 66]);
  is("its left edge", line(), "--init 45,42,115,48@120 --video out.mp4");
  drag([5, 5], [5.1, 5.1]);
  is("a click changes nothing", line(), "--init 45,42,115,48@120 --video out.mp4");
  key("ArrowLeft"); key("ArrowUp", { shiftKey: true });
  is("moved by keys", line(), "--init 44,32,115,48@120 --video out.mp4");
  key("ArrowLeft", { ctrlKey: true, shiftKey: true }); key("ArrowDown", { altKey: true });
  is("resized by keys", line(), "--init 44,32,105,49@120 --video out.mp4");
  for (let count = 0; count < 9; count += 1) key("ArrowRight", { shiftKey: true });
  is("it stays inside", line(), "--init 55,32,105,49@120 --video out.mp4");
  byId("h").value = "0";
  byId("h").dispatchEvent(new Event("change"));
  is("it keeps a pixel", line(), "--init 55,32,105,1@120 --video out.mp4");
  byId("scrub").value = 0;
  byId("scrub").dispatchEvent(new Event("input"));
  byId("add").click();
  const names = () => document.querySelectorAll("#targets [type=text]");
  names()[1].value = "red car's";
  names()[1].dispatchEvent(new Event("input"));
  key("Enter");
  is("two targets", line(), "--init target1=55,32,105,1@120 --init red_car_s=60,45,40,30 --video out.mp4");
  is("the same for report", byId("report").textContent, "host-sim report synthetic --init target1=55,32,105,1@120 --init red_car_s=60,45,40,30 -o report.html");
  names()[0].value = "red_car_s";
  names()[0].dispatchEvent(new Event("input"));
  is("no name twice", line(), "--init red_car_s=55,32,105,1@120 --init red_car_s_2=60,45,40,30 --video out.mp4");
  names()[0].value = "";
  names()[0].dispatchEvent(new Event("input"));
  is("each in its color", new Set([...document.querySelectorAll("#targets li")].map((item) => item.style.getPropertyValue("--c"))).size, 2);
  const zoom = byId("zoom");
  zoom.value = 2; zoom.dispatchEvent(new Event("change"));
  is("twice as large", stage.getAttribute("viewBox"), "40 30 80 60");
  point("pointerdown", 80, 60); point("pointermove", 90, 60); point("pointerup", 90, 60);
  is("half as far", line().includes("red_car_s=65,45,40,30"), true);
  for (let count = 0; count < 5; count += 1) key("ArrowLeft", { shiftKey: true });
  is("the view follows keys", stage.getAttribute("viewBox"), "0 30 80 60");
  await pause(600);
  is("the address follows", location.hash, "#frame=1");
  location.hash = "frame=33";
  await pause(50);
  is("an address that is typed", byId("place").value, "frame 33 of 240");
"##;

#[test]
fn a_box_that_is_dragged_in_a_browser_is_in_the_command_line() {
    let page = folder("pick-browser").join("pick.html");
    assert_eq!(host_sim(&["frame", "synthetic", "41", "-o", utf8(&page)]).code, Some(0));
    let test = "a_box_that_is_dragged_in_a_browser_is_in_the_command_line";
    for width in [390, 1280] {
        browser::act(test, &page, width, "frame=120", SCRIPT);
    }
}
