use super::*;
use crate::viewer::Growing;
use smr_core::robust;
use smr_evaluation::MethodKind;
use smr_recordings::{OpenOptions, synthetic};
use std::fs;
use std::path::Path;
use std::time::Instant;

struct Nothing;

impl Requests for Nothing {
    fn variant(&self, _: &str, _: &Map<String, Value>) -> Result<Variant> {
        Ok(variant())
    }

    fn boxes(&self, _: &Viewer, format: &str) -> Result<(String, Vec<u8>)> {
        bail!("{format} is no format")
    }

    fn made(&self, _: &Viewer, ending: &str, _: Look) -> Result<Job> {
        bail!("{ending} is no ending")
    }

    fn firmware(&self, _: &Variant) -> String {
        String::new()
    }
}

fn variant() -> Variant {
    Variant::new(MethodKind::Robust, &robust::Config::robust().into())
}

fn viewer() -> Viewer {
    let (source, sequence) = Growing::open(Path::new(synthetic::NAME), OpenOptions::default()).unwrap();
    let source: Arc<dyn Source> = Arc::new(source);
    Viewer {
        name: sequence.name,
        size: (120, 90),
        words: synthetic::NAME.to_owned(),
        films: vec!["mp4"],
        place: PathBuf::new(),
        followed: Arc::new(Followed::new(variant(), Vec::new(), source.as_ref()).unwrap()),
        source,
        made: Arc::new(Made::new().unwrap()),
        requests: Box::new(Nothing),
        session: Session::open(None, synthetic::NAME).unwrap().0,
        made_by: String::new(),
    }
}

impl Viewer {
    fn replied(&self, posts: bool, address: &str, body: &str) -> (u16, String) {
        let (path, query) = address.split_once('?').unwrap_or((address, ""));
        let (path, query, body) = (path.to_owned(), query.to_owned(), body.as_bytes().to_vec());
        let reply = self.answer(&Request { posts, path, query, revision: None, body });
        (reply.status, String::from_utf8_lossy(&reply.body).into_owned())
    }
}

/// Numbers that no image, position, box or file has, as text.
const EXTREMES: [&str; 24] = [
    "",
    "0",
    "-0",
    "-1",
    "+1",
    "1e999",
    "1.5",
    "NaN",
    "seven",
    "1%00",
    "-9223372036854775809",
    "-9223372036854775808",
    "-2147483649",
    "-2147483648",
    "65536",
    "2147483646",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551614",
    "18446744073709551615",
    "340282366920938463463374607431768211456",
];

#[test]
fn numbers_at_the_ends_of_every_type_are_refused_with_words() {
    let viewer = viewer();
    let (followed, source) = (Arc::clone(&viewer.followed), Arc::clone(&viewer.source));
    let following = thread::spawn(move || followed.run(source.as_ref()));
    let gets = [
        "frames/N.jpg",
        "frames/N.png?part=1,2,3,4",
        "frames/7.png?part=N,0,8,8",
        "frames/7.png?part=0,N,8,8",
        "frames/7.png?part=0,0,N,8",
        "frames/7.png?part=0,0,8,N",
        "frames/7.png?part=N,N,N,N",
        "news?wait=0&since=N",
        "news?since=0&wait=N",
        "answers?target=N&from=1&to=9",
        "answers?target=1&from=N&to=9",
        "answers?target=1&from=1&to=N",
        "answers?target=1&from=N&to=N",
        "made/N",
    ];
    let target = |lock: &str| format!("[{{\"id\":1,\"name\":\"a\",\"locks\":[{lock}]}}]");
    let good = r#"{"frame":3,"box":[36,24,24,28]}"#;
    let posts = [
        ("targets", target(r#"{"frame":N,"box":[36,24,24,28]}"#)),
        ("targets", target(r#"{"frame":3,"box":[N,24,24,28]}"#)),
        ("targets", target(r#"{"frame":3,"box":[36,N,24,28]}"#)),
        ("targets", target(r#"{"frame":3,"box":[36,24,N,28]}"#)),
        ("targets", target(r#"{"frame":3,"box":[36,24,24,N]}"#)),
        ("targets", target(&format!(r#"{good},{{"frame":N,"box":null}}"#))),
        ("targets", target(good).replace("\"id\":1", "\"id\":N")),
        ("targets", target(good).replace("\"locks\"", "\"checked\":[[N,9],[3,N]],\"hidden\":[[N,N]],\"locks\"")),
        ("checked", r#"{"target":N,"frames":[[1,N]]}"#.to_owned()),
        ("place", r#"{"frame":N}"#.to_owned()),
        ("cancel", r#"{"id":N}"#.to_owned()),
        ("length", r#"{"pixels_per_metre":N,"line":[N,1,N,2]}"#.to_owned()),
        ("boxes", "frame,x,y,width,height,state\nN,1,2,3,4,\n".to_owned()),
        ("boxes", "frame,x,y,width,height,state\n1,1,2,3,4,\nN,1,2,3,4,\n".to_owned()),
        ("boxes", "frame,x,y,width,height\n1,N,N,N,N\n".to_owned()),
        ("boxes", "<track label=\"a\"><box frame=\"N\" xtl=\"1\" ytl=\"2\" xbr=\"9\" ybr=\"9\"/></track>".to_owned()),
        ("boxes", "<track label=\"a\"><box frame=\"1\" xtl=\"N\" ytl=\"N\" xbr=\"N\" ybr=\"9\"/></track>".to_owned()),
    ];
    let gets = gets.map(|address| (false, address, String::new()));
    for (posts, address, body) in gets.into_iter().chain(posts.map(|(address, body)| (true, address, body))) {
        for number in EXTREMES {
            let (address, body) = (address.replace('N', number), body.replace('N', number));
            let begin = Instant::now();
            let (status, said) = viewer.replied(posts, &address, &body);
            assert!([200, 400, 404].contains(&status) && !said.is_empty(), "{address} {body}: {status} {said}");
            assert!(begin.elapsed() < Duration::from_secs(2), "{address} {body}: {:?}", begin.elapsed());
            viewer.replied(false, "news?wait=0&since=0", "");
        }
    }
    for number in EXTREMES.into_iter().filter(|number| *number != "+1") {
        let expected = (404, "there is no such frame, or it is not kept any more".to_owned());
        assert_eq!(viewer.replied(false, &format!("frames/{number}.jpg"), ""), expected, "{number}");
    }
    assert_eq!(viewer.replied(false, &format!("frames/{}.jpg", synthetic::LENGTH), "").0, 200);
    assert_eq!(viewer.replied(true, "targets", &target(good)).0, 200, "it still runs");
    viewer.followed.stop();
    following.join().unwrap();
}

#[test]
fn what_is_not_there_cannot_be_looked_at_and_no_two_targets_have_one_name() {
    let viewer = viewer();
    let target =
        |id: u8, name: &str| format!(r#"{{"id":{id},"name":"{name}","locks":[{{"frame":1,"box":[36,24,24,28]}}]}}"#);
    let twice = viewer.replied(true, "targets", &format!("[{},{}]", target(1, "car"), target(2, "car")));
    assert_eq!(twice, (400, "two targets are called car: give one of them another name".to_owned()));
    assert_eq!(viewer.replied(true, "targets", &format!("[{}]", target(1, "car"))).0, 200);
    let all = synthetic::LENGTH;
    for (id, last, said) in [
        (1, all, None),
        (1, all + 1, Some(format!("there is no frame {}: expected 1 to {all}", all + 1))),
        (9, 2, Some("there is no target 9: it was removed".to_owned())),
    ] {
        let reply = viewer.replied(true, "checked", &format!(r#"{{"target":{id},"frames":[[2,{last}]]}}"#));
        assert_eq!((reply.0 == 200, said.as_ref().is_none_or(|said| reply.1 == *said)), (said.is_none(), true));
    }
    assert_eq!(viewer.followed.targets()[0].checked, vec![(2, all)].into());
}

#[test]
fn a_length_is_kept_until_it_is_removed_and_nonsense_is_refused() {
    let viewer = viewer();
    let (heard, length) = (|| viewer.followed.wait_for_changes(0, Duration::ZERO).position, || viewer.session.length());
    let before = heard();
    let good = r#"{"pixels_per_metre":120.5,"line":[10,90,120,0]}"#;
    assert_eq!(viewer.replied(true, "length", good), (200, "{}".to_owned()));
    let kept = serde_json::to_value(length()).unwrap();
    assert_eq!(kept, serde_json::from_str::<Value>(good).unwrap());
    for address in ["source", "news?wait=0&since=0"] {
        let told: Value = serde_json::from_str(&viewer.replied(false, address, "").1).unwrap();
        assert_eq!(told["length"], kept, "{address}");
    }
    assert!(heard() > before, "other pages hear it");
    for (refused, said) in [
        ("", "expected null, or { pixels_per_metre, line }"),
        ("7", "expected null, or { pixels_per_metre, line }"),
        (r#"{"line":[1,2,3,4]}"#, "pixels_per_metre"),
        (r#"{"pixels_per_metre":0,"line":null}"#, "expected a number from 0.000001 to 1000000"),
        (r#"{"pixels_per_metre":-3,"line":null}"#, "expected a number from 0.000001 to 1000000"),
        (r#"{"pixels_per_metre":"3","line":null}"#, "expected"),
        (r#"{"pixels_per_metre":9,"line":[1,2,3]}"#, "expected"),
        (r#"{"pixels_per_metre":9,"line":[1,2,121,4]}"#, "the line 1,2,121,4 is not wholly inside 120x90 pixels"),
        (r#"{"pixels_per_metre":9,"line":[1,-2,3,4]}"#, "expected"),
    ] {
        let (status, reply) = viewer.replied(true, "length", refused);
        assert!(status == 400 && reply.contains(said), "{refused}: {status} {reply}");
    }
    assert_eq!(serde_json::to_value(length()).unwrap(), kept);
    assert_eq!(viewer.replied(true, "length", "null").0, 200);
    assert_eq!(length(), None);
}

/// Looks at the target in all frames but two, and writes the parts that were looked at.
#[test]
fn what_was_looked_at_is_written_as_recordings_that_eval_takes() {
    let folder = tempfile::tempdir().unwrap();
    let viewer = Viewer { place: folder.path().to_owned(), ..viewer() };
    let post = |address: &str, body: &str| {
        let (status, said) = viewer.replied(true, address, body);
        assert_eq!(status, 200, "{said}");
        said
    };
    let target = |more: &str| format!(r#"[{{"id":1,"name":"ship","locks":[{{"frame":1,"box":[36,24,24,28]}}{more}}}]"#);
    post("targets", &target("]"));
    let none = viewer.replied(true, "recording", "");
    assert_eq!((none.0, none.1.starts_with("nothing is checked yet")), (400, true), "{}", none.1);
    let by_hand =
        r#",{"frame":30,"box":[60,40,24,28],"by_hand":true},{"frame":34,"box":[64,44,24,28]}],"hidden":[[20,24]]"#;
    post("targets", &target(by_hand));
    let all = synthetic::LENGTH;
    post("checked", r#"{"target":1,"frames":[[1,40]]}"#);
    let early = viewer.replied(true, "recording", "");
    assert_eq!(early.0, 400);
    assert!(early.1.contains("wait until frame 40 is followed, too"), "{}", early.1);
    let (followed, source) = (Arc::clone(&viewer.followed), Arc::clone(&viewer.source));
    let following = thread::spawn(move || followed.run(source.as_ref()));
    while viewer.followed.reached(Some(all)).1.is_some() || viewer.followed.reached(Some(all)).0 < all {
        thread::sleep(Duration::from_millis(5));
    }
    post("checked", &format!(r#"{{"target":1,"frames":[[43,{all}]]}}"#));
    let write = || {
        let id = serde_json::from_str::<Value>(&post("recording", "")).unwrap()["id"].as_u64().unwrap();
        loop {
            let made = serde_json::to_value(viewer.made.of(id.try_into().unwrap())).unwrap();
            assert!(made["error"].is_null(), "{made}");
            if made["folder"].is_array() {
                return PathBuf::from(made["folder"][0].as_str().unwrap());
            }
            thread::sleep(Duration::from_millis(5));
        }
    };
    let out = write();
    assert_eq!(
        (out.as_path(), write()),
        (&*folder.path().join("synthetic-truth"), folder.path().join("synthetic-truth-2"))
    );
    let notes = fs::read_to_string(out.join("README.txt")).unwrap();
    assert!(
        notes.contains(
            "\nsynthetic-ship-1-40: ship in the frames 1 to 40 of synthetic, of them 3 by hand, 5 hidden or gone\n"
        ),
        "{notes}"
    );
    let first = smr_recordings::open(&out.join("synthetic-ship-1-40"), &OpenOptions::default()).unwrap();
    let truth = first.truth.unwrap();
    assert_eq!((truth.len(), first.init), (40, truth[0]));
    assert_eq!(truth[31], Some([62, 42, 24, 28].into()), "on the line");
    assert!((1..=40).all(|frame| truth[frame - 1].is_none() == (20..=24).contains(&frame)));
    assert!(first.frames.map(|frame| frame.unwrap().gray).eq(synthetic::frames().take(40)));
    // The recordings of `eval FOLDER`.
    let parts = smr_recordings::recordings(&[out]).unwrap();
    let open = |path: &Path| smr_recordings::open(path, &OpenOptions::default());
    let measured = smr_evaluation::measure(&parts, open, &[variant()], false, &|_| {});
    assert_eq!(measured.failures.len(), 0, "{:?}", measured.failures);
    let csv = measured.tables.unwrap().csv(smr_evaluation::TableName::Measured).unwrap();
    let visible: Vec<_> =
        csv.lines().skip(1).map(|line| line.split(',').skip(1).take(3).collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(visible.first().map(String::as_str), Some("synthetic-ship-1-40 40 35"), "{csv}");
    viewer.followed.stop();
    following.join().unwrap();
}
