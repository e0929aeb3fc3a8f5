//! `view`: the server's replies to the page, and the files that remain after it ends.

use crate::missing::{has_ffmpeg, skipped};
use crate::program::{PROGRAM, host_sim, kill, utf8};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

struct Viewer {
    process: Child,
    place: String,
    token: String,
    folder: TempDir,
}

impl Viewer {
    fn open<Word: AsRef<OsStr>>(arguments: &[Word]) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(["view", "--no-open", "--json"]).args(arguments);
        Self::start(command)
    }

    fn start(mut command: Command) -> Self {
        let folder = tempfile::tempdir().unwrap();
        command.env("TMPDIR", folder.path());
        let mut process = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address: Value = serde_json::from_str(&line).unwrap();
        let address = address["address"].as_str().unwrap().strip_prefix("http://").unwrap();
        let (place, token) = address.trim_end_matches('/').split_once('/').unwrap();
        Self { process, place: place.to_owned(), token: token.to_owned(), folder }
    }

    fn asked(&self, head: &str, headers: &str, body: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.place).unwrap();
        let (place, length) = (&self.place, body.len());
        let rest = format!("Host: {place}\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}");
        stream.write_all(format!("{head} HTTP/1.1\r\n{rest}").as_bytes()).unwrap();
        let mut said = Vec::new();
        stream.read_to_end(&mut said).unwrap();
        let status = std::str::from_utf8(&said[9..12]).unwrap().parse().unwrap();
        let end = said.windows(4).position(|four| four == b"\r\n\r\n").unwrap() + 4;
        (status, String::from_utf8_lossy(&said[..end]).into_owned(), said.split_off(end))
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        let (status, _, body) = self.asked(&format!("GET /{}/{path}", self.token), "", "");
        (status, body)
    }

    fn saved(&self, format: &str) -> String {
        let (_, head, _) = self.asked(&format!("GET /{}/boxes?format={format}", self.token), "", "");
        head.split_once("filename=\"").unwrap().1.split('"').next().unwrap().to_owned()
    }

    fn text(&self, path: &str) -> String {
        let (status, body) = self.get(path);
        let text = String::from_utf8(body).unwrap();
        assert_eq!(status, 200, "{path}: {text}");
        text
    }

    fn json(&self, path: &str) -> Value {
        serde_json::from_str(&self.text(path)).unwrap()
    }

    fn post(&self, path: &str, body: &Value) -> (u16, String) {
        self.post_by(path, "", body)
    }

    fn post_by(&self, path: &str, headers: &str, body: &Value) -> (u16, String) {
        let (status, _, body) = self.asked(&format!("POST /{}/{path}", self.token), headers, &body.to_string());
        (status, String::from_utf8(body).unwrap())
    }

    fn wait(&self, what: &str, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        let mut position = 0;
        loop {
            let news = self.json(&format!("news?since={position}"));
            if is_wanted(&news) {
                return news;
            }
            position = news["position"].as_u64().unwrap();
            assert!(begin.elapsed() < Duration::from_secs(120), "waited too long for {what}: {news}");
        }
    }

    fn followed(&self) -> Value {
        self.wait("the end", |news| news["progress"].is_null())
    }

    fn made(&self, path: &str, body: &Value) -> Vec<u8> {
        let (status, said) = self.post(path, body);
        assert_eq!(status, 200, "{said}");
        let id = serde_json::from_str::<Value>(&said).unwrap()["id"].clone();
        let is_done = |news: &Value| {
            let made = &news["exports"][0];
            assert_eq!(made["error"], Value::Null);
            made["id"] == id && !made["file"].is_null()
        };
        self.wait(path, is_done);
        self.get(&format!("made/{id}")).1
    }

    #[cfg(unix)]
    fn interrupt(&mut self) -> Option<i32> {
        assert!(kill("-INT", &self.process.id().to_string()));
        self.process.wait().unwrap().code()
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn target(locks: &[(usize, [i32; 4])]) -> Value {
    let locks: Vec<_> = locks.iter().map(|(frame, bbox)| json!({ "frame": frame, "box": bbox })).collect();
    json!([{ "id": 7, "name": "car", "locks": locks }])
}

fn recording(folder: &TempDir) -> String {
    let recording = utf8(&folder.path().join("synthetic")).to_owned();
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..40", "-o", &recording]).code, Some(0));
    recording
}

#[test]
fn what_is_followed_in_the_viewer_is_what_track_answers() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let viewer = Viewer::open(&[recording]);
    let source = viewer.json("source");
    assert_eq!((&source["frames"], &source["width"], &source["live"]), (&json!(40), &json!(160), &json!(false)));
    assert_eq!(source["targets"][0]["locks"], json!([{ "frame": 1, "box": [36, 24, 24, 28] }]));
    viewer.followed();
    assert_eq!(viewer.text("boxes?format=csv"), host_sim(&["track", recording, "--format", "csv"]).out);
    assert_eq!(viewer.text("boxes?format=json"), host_sim(&["track", recording, "--json"]).out);
    assert_eq!(
        viewer.post("targets", &target(&[(2, [37, 24, 24, 28]), (30, [80, 40, 24, 28])])),
        (200, "{}".to_owned())
    );
    viewer.followed();
    let inits = ["track", recording, "--init", "37,24,24,28@2", "--init", "80,40,24,28@30"];
    let corrected = |more: &[&str]| host_sim(&[&inits, more].concat()).out;
    assert_eq!(viewer.text("boxes?format=csv"), corrected(&["--format", "csv"]));
    assert_eq!(viewer.post("method", &json!({ "method": "paper", "options": { "config": "camera" } })).0, 200);
    viewer.followed();
    let paper = corrected(&["--method", "paper", "--config", "camera", "--format", "csv"]);
    assert_eq!(viewer.text("boxes?format=csv"), paper);
    assert!(viewer.text("firmware").contains("camera_within"));
}

/// The way of a user with many clips: boxes are drawn in the viewer, and one `track` follows them all.
#[test]
fn what_was_drawn_in_the_viewer_is_followed_by_track() {
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let recordings = folders.each_ref().map(recording);
    let drawn = json!([
        { "id": 1, "name": "mouse", "locks": [{ "frame": 2, "box": [37, 24, 24, 28], "by_hand": true },
            { "frame": 20, "box": null }, { "frame": 30, "box": [80, 40, 24, 28] }] },
        { "id": 3, "name": "rat", "locks": [{ "frame": 5, "box": [38, 25, 24, 28] }] },
    ]);
    let answers = recordings.each_ref().map(|recording| {
        let viewer = Viewer::open(&[recording]);
        assert_eq!(viewer.post("method", &json!({ "method": "paper", "options": { "config": "camera" } })).0, 200);
        assert_eq!(viewer.post("targets", &drawn).0, 200);
        viewer.followed();
        viewer.text("boxes?format=csv")
    });
    let one = host_sim(&["track", &recordings[0]]);
    assert_eq!((one.code, one.out), (Some(0), answers[0].clone()));
    let note = format!("{}.smr.json: mouse, rat; its method: paper --config camera\n", recordings[0]);
    assert!(one.err.ends_with(&note), "{}", one.err);
    let all = host_sim(&["track", &recordings[0], &recordings[1]]);
    let rows = |name: &str| answers[0].lines().skip(1).map(|line| format!("{name},{line}\n")).collect::<String>();
    let head = format!("recording,{}\n", answers[0].lines().next().unwrap());
    assert_eq!((all.code, all.out), (Some(0), head + &rows("synthetic") + &rows("synthetic (2)")), "{}", all.err);
}

#[test]
fn a_length_is_kept_with_its_line_and_adds_the_columns_that_track_has() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let (session, aside) = (format!("{recording}.smr.json"), format!("{recording}.smr.json~"));
    let csv = |number| host_sim(&["track", recording, "--pixels-per-metre", number]).out;
    let viewer = Viewer::open(&[recording, "--pixels-per-metre", "20"]);
    viewer.followed();
    assert_eq!(viewer.text("boxes?format=csv"), csv("20"));
    let drawn = json!({ "pixels_per_metre": 37.5, "line": [10, 20, 160, 120] });
    assert_eq!(viewer.post("length", &drawn).0, 200);
    assert_eq!(viewer.text("boxes?format=csv"), csv("37.5"));
    drop(viewer);
    for words in [&[recording][..], &[recording, "--pixels-per-metre", "37.5"]] {
        assert_eq!(Viewer::open(words).json("source")["length"], drawn);
    }
    let kept = fs::read(&session).unwrap();
    let other = Viewer::open(&[recording, "--pixels-per-metre", "9"]);
    assert_eq!(other.json("source")["length"], json!({ "pixels_per_metre": 9.0, "line": null }));
    assert_eq!((fs::read(&session).unwrap(), fs::exists(&aside).unwrap()), (kept.clone(), false));
    assert_eq!(other.post("length", &Value::Null).0, 200);
    assert_eq!(fs::read(&aside).unwrap(), kept);
    assert_eq!(other.json("source")["length"], Value::Null);
}

#[test]
fn several_recordings_have_a_page_each_and_offer_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let clips = ["a <1>.y4m", "b.y4m", "cut.y4m"].map(|name| utf8(&folder.path().join(name)).to_owned());
    for clip in &clips {
        assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..3", "-o", clip]).code, Some(0));
    }
    fs::write(&clips[2], "YUV4MPEG2 W1").unwrap();
    let viewer = Viewer::open(&[folder.path()]);
    let (status, head, _) = viewer.asked(&format!("GET /{}/", viewer.token), "", "");
    assert!(status == 307 && head.contains("\r\nlocation: 1/\r\n"), "{head}");
    let page = viewer.text("1/");
    assert!(page.contains("<b aria-current=\"page\">a &lt;1&gt;</b>"), "{page}");
    assert!(page.contains("<a href=\"../2/\">b</a>") && page.contains("<datalist id=\"names\"></datalist>"));
    assert_eq!(
        (
            viewer.get("1/page/list.js").0,
            viewer.get("2/news?since=0&wait=0").0,
            viewer.json("2/source")["name"].clone()
        ),
        (200, 200, json!("b"))
    );
    assert_eq!(viewer.post("2/targets", &target(&[(2, [37, 24, 24, 28])])).0, 200);
    assert!(
        Path::new(&format!("{}.smr.json", clips[1])).exists() && !Path::new(&format!("{}.smr.json", clips[0])).exists()
    );
    assert!(viewer.text("1/").contains("<small>car</small>") && viewer.text("1/").contains("<option value=\"car\">"));
    assert!(viewer.text("2/").contains("<datalist id=\"names\"></datalist>"), "its own names are in the list");
    assert_eq!(viewer.json("1/source")["targets"], json!([]));
    let (status, said) = viewer.get("3/source");
    assert!(status == 400 && viewer.get("3/").0 == 200, "{}", String::from_utf8_lossy(&said));
    for nothing in ["0/source", "4/source", "source", "2", "x/source"] {
        assert_eq!(viewer.get(nothing).0, 404, "{nothing}");
    }
    drop(viewer);
    assert!(!Viewer::open(&[&clips[1]]).text("").contains("<nav"));
    for option in [["--init", "1,2,3,4"], ["--session", "a.json"], ["--boxes", "b.csv"]] {
        let refused = host_sim(&[&["view", "--no-open", &clips[0], &clips[1]], &option[..]].concat());
        refused.refuses(&[option[0], "is of one recording"]);
    }
    host_sim(&["view", "--no-open", &clips[0], "-"]).refuses(&["- is followed alone"]);
    host_sim(&["view", "--no-open", &clips[0], &clips[1], "--set", "reach=99"]).refuses(&["reach is 4 to 8"]);
}

#[test]
fn a_recording_without_a_command_opens_the_viewer() {
    for arguments in [["synthetic", "--no-open", "--json"], ["--no-open", "--json", "synthetic"]] {
        let mut command = Command::new(PROGRAM);
        command.args(arguments);
        assert!(Viewer::start(command).place.starts_with("127.0.0.1:"), "{arguments:?}");
    }
}

#[test]
fn the_page_has_all_that_it_asks_for() {
    let viewer = Viewer::open(&["periodic"]);
    let page = viewer.text("");
    assert!(page.contains("page/viewer.js") && !page.contains("{{") && !page.contains("http"), "{page}");
    let mut left = vec!["viewer.js".to_owned()];
    let mut seen = Vec::new();
    while let Some(name) = left.pop() {
        let text = viewer.text(&format!("page/{name}"));
        let imports =
            text.lines().filter_map(|line| Some(line.split_once("from \"./")?.1.split('"').next()?.to_owned()));
        left.extend(imports.filter(|import| !seen.contains(import)));
        seen.push(name);
    }
    assert!(seen.len() > 5);
    let (status, picture) = viewer.get("frames/3.jpg");
    assert!(status == 200 && picture.starts_with(&[0xFF, 0xD8]));
    for wrong in
        ["frames/0.jpg", "frames/999999.jpg", "frames/../source", "page/../viewer.js", "page/nothing.js", "etc/passwd"]
    {
        assert_eq!(viewer.get(wrong).0, 404, "{wrong}");
    }
    for wrong in ["boxes?format=exe", "boxes", "news", "news?since=x", "made/1", "made/x"] {
        let (status, said) = viewer.get(wrong);
        assert!(status == 400 && !said.is_empty() && !said.contains(&b'\n'), "{wrong}: {status}");
    }
    let empty = target(&[(1, [1, 1, 0, 5])]);
    assert_eq!(viewer.post("targets", &empty), (400, "the box of car in frame 1 has no pixels".to_owned()));
    assert_eq!(viewer.post("method", &json!({ "method": "other" })).0, 400);
    let bad =
        [(json!({ "bakend": "scalar" }), "--backend"), (json!({ "set": ["window=16,16"] }), "--set window=16x16")];
    for (options, meant) in bad {
        let (status, said) = viewer.post("method", &json!({ "method": "paper", "options": options }));
        assert!(status == 400 && said.ends_with(&format!("did you mean {meant}?")), "{said}");
    }
    assert_eq!(viewer.post("film", &json!({ "as": "exe" })).0, 400);
}

#[test]
fn a_video_and_a_report_are_made_to_be_taken_away() {
    let folder = tempfile::tempdir().unwrap();
    let viewer = Viewer::open(&[recording(&folder)]);
    viewer.followed();
    let report = String::from_utf8(viewer.made("report", &json!({}))).unwrap();
    assert!(report.contains("<html") && report.contains("36,24,24,28"));
    if !has_ffmpeg("a_video_and_a_report_are_made_to_be_taken_away") {
        return;
    }
    assert!(viewer.made("film", &json!({ "as": "mp4", "crop": 1 }))[4..].starts_with(b"ftyp"));
    let (status, said) = viewer.post("film", &json!({ "as": "mp4", "crop": 7 }));
    assert_eq!((status, &*said), (400, "crop: this target has no box: expected one that has"));
    // The film has the boxes that the user says: here the tracker's, then those on a line.
    let mut film = |by_hand| {
        let locks = json!([{ "frame": 1, "box": [36, 24, 24, 28], "by_hand": by_hand }, { "frame": 9, "box": [90, 70, 24, 28] }]);
        assert_eq!(viewer.post("targets", &json!([{ "id": 7, "name": "car", "locks": locks }])).0, 200);
        viewer.followed();
        viewer.made("film", &json!({ "as": "mp4" }))
    };
    let films = [false, true, true].map(&mut film);
    assert!(films[0] != films[1] && films[1] == films[2]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let folder = fs::read_dir(viewer.folder.path()).unwrap().next().unwrap().unwrap().path();
        let jobs = fs::read_dir(&folder).unwrap().map(|job| fs::read_dir(job.unwrap().path()).unwrap());
        let files: Vec<_> = jobs.flatten().map(|file| mode(&file.unwrap().path())).collect();
        assert_eq!((mode(&folder), files), (0o700, vec![0o600; 5]));
    }
    fs::remove_file(folder.path().join("synthetic/00030.png")).unwrap();
    assert_eq!(viewer.post("targets", &target(&[(40, [36, 24, 24, 28])])).0, 200);
    assert_eq!(viewer.post("film", &json!({ "as": "mp4" })).0, 200);
    let error = json!("synthetic: there is no frame 40 (--init): expected 1 to 39").to_string();
    viewer.wait("the error without the warning before it", |news| news["exports"].to_string().contains(&error));
    let (status, said) = viewer.get("frames/30.jpg");
    assert_eq!((status, viewer.get("frames/29.jpg").0, viewer.get("frames/31.jpg").0), (404, 200, 200));
    assert!(String::from_utf8(said).unwrap().contains("00030.png (frame 30): there is no such file"));
}

/// Returns the viewer's targets and the path of its session file.
fn begun(viewer: &Viewer) -> (Value, Value) {
    let source = viewer.json("source");
    (source["targets"].clone(), source["session"].clone())
}

#[test]
fn work_is_kept_beside_the_recording_and_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let file = format!("{recording}.smr.json");
    let car = target(&[(2, [37, 24, 24, 28]), (30, [80, 40, 24, 28])]);
    let viewer = Viewer::open(&[recording]);
    assert_eq!((viewer.post("place", &json!({ "frame": 3 })).0, begun(&viewer).1), (200, json!(file)));
    assert!(!Path::new(&file).exists(), "nothing has been changed");
    assert_eq!(viewer.post("targets", &car).0, 200);
    assert_eq!(viewer.post("method", &json!({ "method": "paper", "options": { "config": "camera" } })).0, 200);
    assert_eq!(viewer.post("place", &json!({ "frame": 12 })).0, 200);
    drop(viewer);
    let viewer = Viewer::open(&[recording]);
    let source = viewer.json("source");
    assert_eq!((&source["targets"], &source["method"], &source["frame"]), (&car, &json!("paper"), &json!(12)));
    assert_eq!((&source["options"], &source["ids"]), (&json!({ "config": "camera" }), &car[0]["id"]));
    assert_eq!(viewer.post("targets", &json!([])).0, 200);
    assert_eq!(viewer.json("source")["ids"], source["ids"], "the id of a removed target is not given again");
    drop(viewer);
    let viewer = Viewer::open(&[recording]);
    assert_eq!((&viewer.json("source")["targets"], &viewer.json("source")["ids"]), (&json!([]), &source["ids"]));
    assert_eq!(viewer.post("targets", &car).0, 200);
    drop(viewer);
    // Targets of the command line replace the targets of the session; the session file keeps its own.
    let viewer = Viewer::open(&[recording, "--init", "1,1,20,20"]);
    assert_eq!(
        (&begun(&viewer).0[0]["locks"][0]["box"], viewer.json("source")["method"].clone()),
        (&json!([1, 1, 20, 20]), json!("paper"))
    );
    let former = fs::read(&file).unwrap();
    assert_eq!(viewer.post("targets", &target(&[(1, [2, 2, 20, 20])])).0, 200);
    assert_eq!(fs::read(format!("{file}~")).unwrap(), former);
    viewer
        .wait("where the former work is", |news| news["said"].as_str().is_some_and(|said| said.contains(".smr.json~")));
    drop(viewer);
    assert_eq!(begun(&Viewer::open(&["synthetic"])).1, Value::Null);
    let named = folder.path().join("a.json");
    assert_eq!(begun(&Viewer::open(&["synthetic", "--session", utf8(&named)])).1, json!(named));
    let tracked = host_sim(&["track", recording, "--init", "2,2,20,20", "-o", utf8(&folder.path().join("boxes.csv"))]);
    assert_eq!(tracked.code, Some(0), "the file beside it is no part of the recording: {}", tracked.err);
    let refused = host_sim(&["view", "--no-open", recording, "--session", utf8(&folder.path().join("boxes.csv"))]);
    refused.refuses(&["boxes.csv: line 1, column 2: it is damaged, or no session"]);
}

#[test]
fn what_was_looked_at_counts_only_for_the_boxes_that_were_there() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let file = format!("{recording}.smr.json");
    let mut car = target(&[(2, [37, 24, 24, 28])]);
    car[0]["checked"] = json!([[2, 9]]);
    assert_eq!(Viewer::open(&[recording]).post("targets", &car).0, 200);
    let kept: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    let looked_at = |options: &[&str]| begun(&Viewer::open(&[&[recording], options].concat())).0[0]["checked"].clone();
    for same in [&[][..], &["--method", "robust"]] {
        assert_eq!(looked_at(same), car[0]["checked"], "{same:?}");
    }
    for other in [&["--method", "paper"][..], &["--set", "reach=5"]] {
        assert_eq!(looked_at(other), Value::Null, "{other:?}");
    }
    for (fact, other) in [("made_by", "host-sim 0.0.1"), ("recording", "another"), ("method", "paper")] {
        let mut session = kept.clone();
        session[fact] = json!(other);
        fs::write(&file, session.to_string()).unwrap();
        assert_eq!(looked_at(if fact == "method" { &["--method", "robust"] } else { &[] }), Value::Null, "{fact}");
    }
}

#[test]
fn boxes_of_a_file_are_locks() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let file = folder.path().join("boxes.csv");
    let viewer = Viewer::open(&[recording]);
    let mut car = target(&[(2, [37, 24, 24, 28]), (30, [80, 40, 24, 28])]);
    car[0]["locks"].as_array_mut().unwrap().insert(1, json!({ "frame": 20, "box": null }));
    assert_eq!(viewer.post("targets", &car).0, 200);
    viewer.followed();
    let csv = viewer.text("boxes?format=csv");
    let inits = ["--init", "37,24,24,28@2", "--init", "gone@20", "--init", "80,40,24,28@30"];
    assert_eq!(csv, host_sim(&[&["track", recording, "--format", "csv"], &inits[..]].concat()).out);
    fs::write(&file, &csv).unwrap();
    let post = |text: &str, name: &str| viewer.asked(&format!("POST /{}/boxes?name={name}", viewer.token), "", text);
    for (text, name) in [(&csv, "boxes.csv"), (&viewer.text("boxes?format=cvat"), "boxes.xml")] {
        let (status, _, read) = post(text, name);
        let read: Value = serde_json::from_slice(&read).unwrap();
        assert_eq!((status, &read["targets"][0]["locks"]), (200, &car[0]["locks"]), "{name}");
    }
    let outside = viewer.post("targets", &target(&[(2, [150, 24, 24, 28])]));
    assert_eq!(outside, (400, "the box 150,24,24,28 of car in frame 2 is not wholly inside 160x120 pixels".to_owned()));
    let (status, _, said) = post("frame\n", "my%20boxes.csv");
    assert!(status == 400 && said.starts_with(b"my boxes.csv: line 1: there is no column x"));
    let latin = viewer.asked(&format!("POST /{}/boxes?name=a.csv", viewer.token), "", "frame\0");
    assert!(latin.0 == 400 && latin.2.starts_with(b"a.csv: it has NUL characters"));
    drop(viewer);
    let viewer = Viewer::open(&[recording, "--boxes", utf8(&file), "--session", utf8(&folder.path().join("new.json"))]);
    assert_eq!(begun(&viewer).0[0]["locks"], car[0]["locks"]);
    viewer.followed();
    assert_eq!(viewer.text("boxes?format=csv"), csv);
}

/// The length of a video is known only after its packets are counted, so the viewer opens before that.
#[test]
fn a_box_behind_the_end_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let (film, video, said) = (place("film.y4m"), place("film.mp4"), place("said"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..20", "--out", utf8(&film)]).code, Some(0));
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-nostdin", "-v", "error", "-i"]).arg(&film).arg(&video);
    let mut recordings = vec![&film];
    if crate::missing::runs(&mut ffmpeg) {
        recordings.push(&video);
    } else {
        skipped("a_box_behind_the_end_is_said", "no ffmpeg that writes mp4");
    }
    fs::write(place("a.csv"), "target,frame,x,y,width,height\ncar,1,36,24,24,28\ncar,999,36,24,24,28\n").unwrap();
    let xml = |frame: u32| format!("<box frame=\"{frame}\" xtl=\"36\" ytl=\"24\" xbr=\"60\" ybr=\"52\"/>");
    let track = format!("<annotations><track label=\"car\">{}{}</track></annotations>", xml(0), xml(998));
    fs::write(place("a.xml"), track).unwrap();
    let locks = [1, 999].map(|frame| json!({ "frame": frame, "box": [36, 24, 24, 28] }));
    let mut session = json!({ "smr_session": 1, "recording": "a", "method": "paper", "options": {}, "frame": null });
    session["targets"] = json!([{ "id": 1, "name": "car", "locks": locks }]);
    fs::write(place("a.json"), session.to_string()).unwrap();
    let (csv, xml, session) = (place("a.csv"), place("a.xml"), place("a.json"));
    for recording in recordings {
        for given in [
            &["--init", "car=36,24,24,28", "--init", "car=36,24,24,28@999"][..],
            &["--boxes", utf8(&csv)],
            &["--boxes", utf8(&xml)],
            &["--session", utf8(&session)],
        ] {
            let mut command = Command::new(PROGRAM);
            command.args(["view", "--no-open", "--json"]).arg(recording).args(given);
            command.stderr(fs::File::create(&said).unwrap());
            let viewer = Viewer::start(command);
            let line = "there is no frame 999 for car: expected 1 to 20";
            viewer.wait("the message", |news| news["said"] == line);
            viewer.followed();
            let said = fs::read_to_string(&said).unwrap();
            let (note, warning) = said.split_at(said.find("warning: ").unwrap());
            assert_eq!(warning, format!("warning: film: {line}\n"), "{given:?}");
            assert_eq!(!note.is_empty(), given[0] == "--session", "{note}");
            assert_eq!(viewer.text("boxes?format=tld").lines().count(), 20);
        }
    }
}

#[test]
fn a_part_of_a_frame_has_its_own_pixels() {
    let viewer = Viewer::open(&["periodic"]);
    let part = |query: &str| viewer.get(&format!("frames/3.png?{query}"));
    let (status, png) = part("part=-5,10,30,8");
    assert!(status == 200 && png.starts_with(b"\x89PNG") && png[16..24] == [0, 0, 0, 25, 0, 0, 0, 8]);
    assert_eq!([part("part=9,9,9"), part("part=9999,0,9,9"), part("")].map(|(status, _)| status), [400; 3]);
    assert_eq!(viewer.get("frames/99999.png?part=0,0,9,9").0, 404);
}

#[test]
fn a_file_that_is_not_wanted_any_more_is_cancelled() {
    let viewer = Viewer::open(&["street"]);
    viewer.wait("the first answers", |news| news["followed"].as_u64() > Some(0));
    assert_eq!(viewer.post("report", &json!({})).0, 200);
    let begun = viewer.wait("the beginning", |news| !news["exports"].is_null())["exports"][0].clone();
    assert_eq!((&begun["id"], &begun["name"], &begun["cancelled"]), (&json!(1), &json!("street.html"), &json!(false)));
    assert_eq!(viewer.post("cancel", &json!({ "id": 1 })), (200, "{}".to_owned()));
    let ended = viewer.wait("the end", |news| news["exports"][0]["cancelled"] == true)["exports"][0].clone();
    assert_eq!((&ended["file"], &ended["error"]), (&Value::Null, &Value::Null));
    let folder = fs::read_dir(viewer.folder.path()).unwrap().next().unwrap().unwrap().path();
    let begin = Instant::now();
    while fs::read_dir(&folder).unwrap().count() > 0 {
        assert!(begin.elapsed() < Duration::from_secs(20), "its file is left");
    }
    let refused = (400, "file 1 is not being made: expected one that is".to_owned());
    assert_eq!(viewer.post("cancel", &json!({ "id": 1 })), refused);
}

/// Arguments of a program are visible to all users, so none of them may contain the viewer's key.
#[cfg(target_os = "linux")]
#[test]
fn the_browser_is_opened_by_a_private_file_and_not_by_the_address() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (browser, seen) = (folder.path().join("xdg-open"), folder.path().join("seen"));
    fs::write(
        &browser,
        "#!/bin/sh\nstat -c %a \"$1\" >\"$SEEN.part\"; cat \"$1\" >>\"$SEEN.part\"; mv \"$SEEN.part\" \"$SEEN\"\n",
    )
    .unwrap();
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let path = std::env::join_paths([folder.path(), Path::new("/usr/bin"), Path::new("/bin")]).unwrap();
    let mut command = Command::new(PROGRAM);
    command.args(["view", "--json", "synthetic"]).env("PATH", path).env("SEEN", &seen);
    let viewer = Viewer::start(command);
    let begin = Instant::now();
    while !seen.exists() {
        assert!(begin.elapsed() < Duration::from_secs(20), "no browser is opened, or not with a file");
        std::thread::sleep(Duration::from_millis(20));
    }
    let said = fs::read_to_string(seen).unwrap();
    assert!(
        said.starts_with("600\n") && said.contains(&format!("url=http://{}/{}/", viewer.place, viewer.token)),
        "{said}"
    );
}

/// The file is cut off, or is still being copied, while the viewer is open.
#[test]
fn the_end_of_a_read_is_not_the_end_of_the_file() {
    if !has_ffmpeg("the_end_of_a_read_is_not_the_end_of_the_file") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clip.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..60", "--out", utf8(&file)]).code, Some(0));
    let all = fs::read(&file).unwrap();
    let head = all.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    let frames = |count: usize| &all[..head + (all.len() - head) / 60 * count];
    fs::write(&file, frames(40)).unwrap();
    let viewer = Viewer::open(&[utf8(&file), "--init", "36,24,24,28"]);
    assert_eq!((viewer.followed()["followed"].clone(), viewer.saved("csv")), (json!(40), "clip.csv".to_owned()));
    fs::write(&file, frames(20)).unwrap();
    let corrected = |at| target(&[(1, [36, 24, 24, 28]), (at, [40, 24, 24, 28])]);
    assert_eq!(viewer.post("targets", &corrected(10)).0, 200);
    viewer.wait("why it ends", |news| news["said"].is_string());
    assert_eq!(
        (viewer.json("source")["frames"].clone(), viewer.saved("csv")),
        (json!(40), "clip-20-of-40-frames.csv".to_owned())
    );
    fs::write(&file, frames(40)).unwrap();
    assert_eq!(viewer.post("targets", &corrected(30)).0, 200);
    assert_eq!(viewer.followed()["followed"], 40);
    // The file has grown: targets that waited for frames continue without another `targets` request.
    fs::write(&file, frames(60)).unwrap();
    let grown = viewer.wait("more frames", |news| news["progress"].is_null() && news["followed"] == 60);
    assert_eq!((viewer.json("source")["frames"].clone(), viewer.get("frames/60.jpg").0), (json!(60), 200), "{grown}");
    let inits = ["--init", "36,24,24,28", "--init", "40,24,24,28@30", "--format", "csv"];
    assert_eq!(viewer.text("boxes?format=csv"), host_sim(&[&["track", utf8(&file)], &inits[..]].concat()).out);
}

/// The viewer follows a target up to the damage, and the command that it shows gives the same answers.
#[test]
fn what_is_shown_for_a_damaged_recording_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = recording(&folder);
    fs::write(folder.path().join("synthetic/00021.png"), b"\x89PNG").unwrap();
    let (film, cut) = (folder.path().join("film.y4m"), folder.path().join("cut.mp4"));
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..60", "--out", utf8(&film)]).code, Some(0));
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg
        .args(["-nostdin", "-v", "error", "-i"])
        .arg(&film)
        .args(["-c:v", "libx264", "-g", "10", "-movflags", "+faststart"])
        .arg(&cut);
    let mut recordings = vec![pictures];
    if crate::missing::runs(&mut ffmpeg) {
        let whole = fs::read(&cut).unwrap();
        fs::write(&cut, &whole[..whole.len() * 6 / 10]).unwrap();
        recordings.push(utf8(&cut).to_owned());
    } else {
        skipped("what_is_shown_for_a_damaged_recording_repeats_it", "no ffmpeg that writes mp4");
    }
    for recording in &recordings {
        let viewer = Viewer::open(&[recording, "--init", "36,24,24,28"]);
        viewer.wait("the damage", |news| news["said"].is_string());
        let news = viewer.followed();
        let words = format!("{recording} --frames ..{}", news["followed"]);
        assert_eq!((&viewer.json("source")["words"], &news["words"]), (&json!(words), &json!(words)));
        let track = host_sim(
            &[&["track", "--init", "36,24,24,28", "--format", "csv"], &words.split(' ').collect::<Vec<_>>()[..]]
                .concat(),
        );
        assert_eq!((track.code, track.out), (Some(0), viewer.text("boxes?format=csv")), "{}", track.err);
        assert!(viewer.made("report", &json!({})).starts_with(b"<!DOCTYPE"));
        assert_eq!(viewer.post("targets", &target(&[(1, [36, 24, 24, 28]), (25, [50, 40, 24, 28])])).0, 200);
        let words = viewer.json("source")["words"].clone();
        assert_eq!(words == json!(recording), recording.ends_with("synthetic"), "{words}: a lock behind the damage");
    }
}

/// File names that look like an option, or that are not UTF-8.
#[cfg(target_os = "linux")]
#[test]
fn odd_names_are_made_and_typed() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let clip = folder.path().join("clip.y4m");
    assert_eq!(host_sim(&["convert", "synthetic", "--frames", "..30", "--out", utf8(&clip)]).code, Some(0));
    for (name, typed) in [(&b"-a b.y4m"[..], "'./-a b.y4m'"), (b"bad\xff'.y4m", r"$'bad\xff\'.y4m'")] {
        let name = OsStr::from_bytes(name);
        fs::copy(&clip, folder.path().join(name)).unwrap();
        let mut command = Command::new(PROGRAM);
        command
            .current_dir(folder.path())
            .args(["view", "--no-open", "--json", "--init", "36,24,24,28", "--"])
            .arg(name);
        let viewer = Viewer::start(command);
        assert_eq!(viewer.json("source")["words"], typed);
        let report = String::from_utf8(viewer.made("report", &json!({}))).unwrap();
        assert!(report.contains("<html"));
    }
}

#[test]
fn targets_are_told_to_all_pages_and_none_takes_the_place_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let viewer = Viewer::open(&[recording(&folder)]);
    let (source, here) = (viewer.json("source"), viewer.followed()["position"].clone());
    let post = |revision: &Value, targets: &Value| {
        let (status, said) = viewer.post_by("targets", &format!("If-Match: \"{revision}\"\r\n"), targets);
        (status, serde_json::from_str::<Value>(&said).map_or(json!(said), |said| said["revision"].clone()))
    };
    let car = target(&[(2, [37, 24, 24, 28])]);
    let (status, revision) = post(&source["revision"], &car);
    assert_eq!(status, 200);
    let news = viewer.json(&format!("news?since={here}"));
    assert_eq!((&news["targets"], &news["revision"]), (&car, &revision));
    let (status, said) = post(&source["revision"], &json!([]));
    assert!(status == 400 && said.as_str().unwrap().starts_with("another page has changed the targets"), "{said}");
    assert_eq!(viewer.json("source")["targets"], car);
    let mut other = target(&[(3, [90, 24, 24, 28])]);
    other[0]["name"] = json!("man");
    assert_eq!(viewer.post("targets", &other).0, 400, "its id is that of the car");
    viewer.followed();
    let part = viewer.json("answers?target=7&from=10&to=30");
    assert_eq!(
        (part["rows"].as_array().unwrap().len(), &part["rows"][0][1], &part["to"]),
        (21, &json!(10), &json!(30))
    );
}

#[cfg(unix)]
#[test]
fn nothing_is_left_when_it_is_ended() {
    let mut viewer = Viewer::open(&["synthetic"]);
    viewer.followed();
    assert_eq!(viewer.post("report", &json!({})).0, 200);
    assert_eq!(fs::read_dir(viewer.folder.path()).unwrap().count(), 1);
    assert_eq!(viewer.interrupt(), Some(130));
    assert_eq!(fs::read_dir(viewer.folder.path()).unwrap().count(), 0);
}

/// A recording with truth of several parts is there whole, or not at all.
#[cfg(unix)]
#[test]
fn no_part_of_a_recording_is_left_when_it_is_ended() {
    let folder = tempfile::tempdir().unwrap();
    let recording = &recording(&folder)[..];
    let mut car = target(&[(1, [36, 24, 24, 28])]);
    car[0]["checked"] = json!([[1, 15], [20, 40]]);
    let mut viewer = Viewer::open(&[recording]);
    assert_eq!(viewer.post("targets", &car).0, 200);
    viewer.followed();
    assert_eq!(viewer.post("recording", &json!({})).0, 200);
    assert_eq!(viewer.interrupt(), Some(130));
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    let whole = folder.path().join("synthetic-truth");
    let expected = ["synthetic", "synthetic-truth", "synthetic.smr.json"];
    assert!(names.iter().all(|name| expected.iter().any(|known| name == known)), "{names:?}");
    assert_eq!(whole.exists(), whole.join("README.txt").exists());
}

/// The median request for a frame of a one-hour video takes less than two seconds; the server stays below 300 MiB.
#[cfg(target_os = "linux")]
#[test]
fn any_frame_of_a_long_video_is_soon_there() {
    let test = "any_frame_of_a_long_video_is_soon_there";
    let folder = tempfile::tempdir().unwrap();
    let (short, long) = (folder.path().join("short.mp4"), folder.path().join("long.mp4"));
    let source = "testsrc2=size=320x240:rate=30:duration=20";
    let made = |arguments: &[&str], file: &Path| {
        let mut ffmpeg = Command::new("ffmpeg");
        crate::missing::runs(ffmpeg.args(["-nostdin", "-v", "error"]).args(arguments).arg(file))
    };
    let is_made = made(&["-f", "lavfi", "-i", source, "-preset", "ultrafast"], &short)
        && made(&["-stream_loop", "179", "-i", utf8(&short), "-c", "copy"], &long);
    if !is_made {
        return skipped(test, "no ffmpeg that writes mp4");
    }
    let viewer = Viewer::open(&[utf8(&long)]);
    let known = viewer.wait("the index", |news| news["frames"].is_u64());
    assert_eq!((&known["frames"], known["times"].as_array().unwrap().len()), (&json!(108_000), 108_000));
    let mut times = Vec::new();
    for number in [107_999, 3, 54_321, 90_000, 12_345, 70_007, 108_000, 1, 33_333, 99_000, 45_678] {
        let begin = Instant::now();
        let (status, picture) = viewer.get(&format!("frames/{number}.jpg"));
        assert!(status == 200 && picture.starts_with(&[0xFF, 0xD8]), "{number}");
        times.push(begin.elapsed());
    }
    times.sort();
    // On an idle machine a frame takes half a second (median); the limit is larger because other tests run in parallel.
    assert!(times[times.len() / 2] < Duration::from_secs(2), "{times:?}");
    let status = fs::read_to_string(format!("/proc/{}/status", viewer.process.id())).unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak: u32 = peak.trim().trim_end_matches("kB").trim().parse().unwrap();
    assert!(peak < 300 << 10, "{peak} KiB");
}
