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
    assert_eq!((&data["shown"], &data["last"], &data["targets"]), (&41.into(), &240.into(), &serde_json::json!([])));
    assert_eq!(numbers(&data), (1..=240).collect::<Vec<_>>());
    let first = host_sim(&["frame", "synthetic", "-o", utf8(&page)]);
    assert!(first.out.contains("240 frames to go through"), "{}", first.out);
    assert_eq!(box_of(&page), [36, 24, 24, 28], "the box beside the recording is that of its first frame");
    host_sim(&["frame", "synthetic", "241", "-o", utf8(&page)]).refuses(&["no frame 241", "1 to 240"]);
}

fn box_of(page: &Path) -> [i64; 4] {
    let data = data(page);
    [0, 1, 2, 3].map(|side: usize| data["targets"][0]["locks"][0]["box"][side].as_i64().unwrap())
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
    assert_eq!(data["words"], format!("'{}' --resize 1/3 --frames 11..20", utf8(&frames)));
    let outside = host_sim(&[&["frame", utf8(&frames), "5", "-o", utf8(&page)][..], &options].concat());
    outside.refuses(&["no frame 5", "11 to 20"]);
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
  const text = async (id) => { await pause(100); return byId(id).textContent.replace("host-sim track synthetic ", ""); };
  const point = (kind, x, y, pointerType = "mouse") => {
    const { left, top, width } = stage.getBoundingClientRect();
    const scale = width / 160;
    const at = { clientX: left + x * scale, clientY: top + y * scale };
    stage.dispatchEvent(new PointerEvent(kind, { ...at, button: kind === "pointermove" ? -1 : 0, pointerId: 1, pointerType, isPrimary: true, bubbles: true }));
  };
  const drag = (from, to, type) => { point("pointerdown", ...from, type); point("pointermove", ...to, type); point("pointerup", ...to, type); };
  const key = (key, more) => stage.dispatchEvent(new KeyboardEvent("keydown", { key, ...more, bubbles: true, cancelable: true }));
  const times = (count, ...of) => { for (let done = 0; done < count; done += 1) key(...of); };
  // The clock of this browser runs ahead of true time, which pictures take to be decoded, and so does toDataURL.
  const shows = async (place) => {
    for (let tries = 0; tries < 100 && byId("place").value !== place; tries += 1) { stage.toDataURL(); await pause(20); }
  };
  await shows("frame 120 of 240");
  is("nothing is wider than the window", document.documentElement.scrollWidth, document.documentElement.clientWidth);
  is("only the picture keeps fingers to itself", getComputedStyle(stage).touchAction + getComputedStyle(document.body).touchAction, "noneauto");
  is("the frame in the address", byId("place").value, "frame 120 of 240");
  is("nothing to copy yet", document.querySelector("[data-of=track]").disabled, true);
  drag([30.2, 40.3], [69.8, 80.4]);
  is("a box", await text("track"), "--init 30,40,40,40@120 --video out.mp4");
  drag([50, 60], [55, 62], "touch");
  is("moved", await text("track"), "--init 35,42,40,40@120 --video out.mp4");
  drag([75, 82], [500, 90], "pen");
  is("its corner dragged beyond the frame", await text("track"), "--init 35,42,125,48@120 --video out.mp4");
  drag([35, 66], [45, 66]);
  is("its left edge", await text("track"), "--init 45,42,115,48@120 --video out.mp4");
  drag([5, 5], [5.1, 5.1]);
  is("a click changes nothing", await text("track"), "--init 45,42,115,48@120 --video out.mp4");
  key("Enter"); key("ArrowLeft", { altKey: true }); key("ArrowUp"); key("Enter");
  is("moved by keys", await text("track"), "--init 44,39,115,48@120 --video out.mp4");
  key("Enter"); key("ArrowLeft", { shiftKey: true }); key("ArrowDown", { altKey: true, shiftKey: true }); key("Enter");
  is("resized by keys", await text("track"), "--init 44,39,112,49@120 --video out.mp4");
  key("Enter"); key("ArrowLeft"); key("Escape");
  is("dropped", await text("track"), "--init 44,39,112,49@120 --video out.mp4");
  key("Enter"); times(30, "ArrowRight"); key("Enter");
  is("it stays inside", await text("track"), "--init 48,39,112,49@120 --video out.mp4");
  key("Enter"); times(30, "ArrowUp", { shiftKey: true }); key("Enter");
  is("it keeps a pixel", await text("track"), "--init 48,39,112,1@120 --video out.mp4");
  const slider = document.querySelector("#timeline input");
  slider.value = 1;
  slider.dispatchEvent(new Event("input"));
  await shows("frame 1 of 240");
  drag([60, 45], [100, 75]);
  is("a box in another frame", await text("track"), "--init 60,45,40,30 --init 48,39,112,1@120 --video out.mp4");
  key("Delete");
  is("it is removed", await text("track"), "--init 48,39,112,1@120 --video out.mp4");
  key("z", { ctrlKey: true }); key("z", { ctrlKey: true });
  is("undone", await text("track"), "--init 48,39,112,1@120 --video out.mp4");
  byId("add").click();
  key("Enter"); key("Enter");
  is("two targets", await text("track"), "--init target1=48,39,112,1@120 --init target2=60,45,40,30 --video out.mp4");
  const name = (at, value) => {
    const field = document.querySelectorAll("#targets [type=text]")[at];
    field.value = value;
    field.dispatchEvent(new Event("change"));
    return field;
  };
  name(1, "red car's");
  is("the same for report", await text("report"), "host-sim report synthetic --init target1=48,39,112,1@120 --init red_car_s=60,45,40,30 -o report.html");
  is("and for view", byId("view").textContent, "host-sim view synthetic --init target1=48,39,112,1@120 --init red_car_s=60,45,40,30");
  is("no name twice", name(0, "red_car_s").value, "target1");
  is("which is said", byId("said").textContent, "Another target is called red_car_s: give this one another name.");
  is("each in its color", new Set([...document.querySelectorAll("#targets li")].map((item) => item.style.getPropertyValue("--of"))).size, 2);
  byId("zoom").value = 2;
  byId("zoom").dispatchEvent(new Event("change"));
  drag([80, 60], [90, 60]);
  is("half as far", (await text("track")).includes("red_car_s=65,45,40,30"), true);
  key("Enter"); times(20, "ArrowLeft");
  await pause(100);
  key("Enter");
  is("moved out of the view", (await text("track")).includes("red_car_s=5,45,40,30"), true);
  drag([50, 60], [60, 60]);
  is("which has followed", (await text("track")).includes("red_car_s=10,45,40,30"), true);
  await pause(600);
  is("the address follows", location.hash, "#frame=1");
  location.hash = "frame=33";
  await shows("frame 33 of 240");
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
