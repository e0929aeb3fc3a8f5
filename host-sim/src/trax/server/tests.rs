//! Sessions as clients lead them, and as no client should.

use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;
use smr_core::paper;
use smr_evaluation::MethodKind;
use smr_recordings::synthetic;

/// What the client gets back, and how the session ended.
fn session(kind: MethodKind, protocol: u8, lines: &[u8]) -> (Vec<Message>, Result<()>) {
    let configs = paper::Config::camera().into();
    let server = Server {
        name: "smr".to_owned(),
        description: "a \"test\"".to_owned(),
        protocol,
        build: || kind.build(&configs),
    };
    let mut output = Vec::new();
    let ended = serve(&server, lines, &mut output);
    let text = String::from_utf8(output).unwrap();
    (text.lines().map(|line| Message::parse(line).unwrap().unwrap()).collect(), ended)
}

fn picture(index: usize) -> String {
    let GrayFrame { width, height, pixels } = synthetic::frames().nth(index).unwrap();
    format!("image:{width};{height};gray8;{}", STANDARD.encode(pixels))
}

fn target() -> BoundingBox {
    synthetic::truth(0).unwrap()
}

fn names(messages: &[Message]) -> Vec<&str> {
    messages.iter().map(|message| message.name.as_str()).collect()
}

#[test]
fn both_trackers_follow_in_every_version() {
    for kind in [MethodKind::Smr, MethodKind::Robust] {
        let configs = paper::Config::camera().into();
        let mut follower = Follower::new(kind.build(&configs).unwrap(), vec![(1, target().to_rect().unwrap())]);
        let frames = (1..5).zip(synthetic::frames());
        let expected: Vec<_> = frames.map(|(number, frame)| follower.step(number, &frame).unwrap().unwrap()).collect();
        let frame = |index| Message::new("frame").argument(picture(index)).line();
        let rest: String = (1..4).map(frame).chain([Message::new("quit").line()]).collect();
        let target = region::text(&target());
        let one = Message::new("initialize").argument(picture(0)).argument(&*target).line();
        let apart = Message::new("initialize").argument(&*target).line() + &frame(0);
        for (protocol, begin) in [(1, &one), (2, &one), (3, &one), (4, &apart)] {
            let (answers, ended) = session(kind, protocol, format!("noise\n{begin}{rest}never read\0").as_bytes());
            ended.unwrap();
            assert_eq!(names(&answers), ["hello", "state", "state", "state", "state"]);
            assert!(answers[0].properties.contains(&("trax.version".to_owned(), protocol.to_string())));
            for (answer, report) in answers[1..].iter().zip(&expected) {
                assert_eq!(answer, &state(&report.target.unwrap(), report));
            }
        }
    }
}

#[test]
fn several_objects_are_followed_at_a_time() {
    let GrayFrame { width, height, .. } = synthetic::frames().next().unwrap();
    let begin = |text: &str| Message::new("initialize").argument(text).line();
    let frame = |index| Message::new("frame").argument(picture(index)).line();
    let first = begin(&region::text(&target()));
    let second = begin(&format!("-5,-5,30,30,-5,{height},-5,{width}"));
    let lines = [first.clone(), frame(0), second, frame(1), frame(2)].concat();
    let (answers, ended) = session(MethodKind::Robust, 4, lines.as_bytes());
    ended.unwrap();
    assert_eq!(names(&answers), ["hello", "state", "state", "state", "state", "state"]);
    let alone = session(MethodKind::Robust, 4, [first.clone(), frame(0), frame(1), frame(2)].concat().as_bytes()).0;
    assert_eq!((&answers[2], &answers[4]), (&alone[2], &alone[3]), "the first stands first");

    let (answers, ended) = session(MethodKind::Robust, 3, [first.clone(), frame(0), first].concat().as_bytes());
    assert_eq!(ended.unwrap_err().to_string(), "initialize: there are 1 objects: expected at most 1");
    assert_eq!(names(&answers), ["hello", "state", "quit"]);
}

/// The reference client says `initialize` without an argument before a second session.
#[test]
fn an_empty_initialize_begins_a_new_session() {
    let begin = |text: &str| Message::new("initialize").argument(text).line();
    let frame = |index| Message::new("frame").argument(picture(index)).line();
    let empty = "@@TRAX:initialize\n".to_owned();
    let of_session = [begin(&region::text(&target())), frame(0), frame(1), frame(2)].concat();
    for kind in [MethodKind::Smr, MethodKind::Robust] {
        let (answers, ended) = session(kind, 4, [&*of_session, &*empty, &*of_session].concat().as_bytes());
        ended.unwrap();
        assert_eq!(names(&answers), ["hello", "state", "state", "state", "state", "state", "state"]);
        assert_eq!(answers[1..4], answers[4..], "nothing is left of the first");
    }
    // Also what was announced and has not begun.
    let lines = [&*begin("1,1,9,9"), &*empty, &*of_session].concat();
    assert_eq!(session(MethodKind::Smr, 4, lines.as_bytes()).0.len(), 4);
    let (answers, ended) = session(MethodKind::Smr, 4, [of_session, empty, frame(0)].concat().as_bytes());
    assert_eq!(ended.unwrap_err().to_string(), "frame before initialize: there is nothing to follow");
    assert_eq!(names(&answers), ["hello", "state", "state", "state", "quit"]);
}

#[test]
fn what_a_client_must_not_say_is_answered_with_the_reason() {
    let frame = picture(0);
    let locked = format!("@@TRAX:initialize {frame} 10,10,40,30\n");
    for (lines, expected) in [
        (format!("@@TRAX:frame {frame}\n"), "frame before initialize: there is nothing to follow"),
        ("@@TRAX:frame\n".to_owned(), "frame has 0 arguments: expected an image"),
        ("@@TRAX:dance a\n".to_owned(), "the message \"dance\": expected initialize, frame or quit"),
        ("@@TRAX:hello\n".to_owned(), "the message \"hello\": expected initialize, frame or quit"),
        ("@@TRAX:initialize \"a\n".to_owned(), "a quote is open: expected a second one"),
        ("@@TRAX:initialize 1,2,3\n".to_owned(), "expected x,y,width,height or a polygon"),
        (format!("@@TRAX:initialize {frame} 4000,4000,9,9\n"), "frame 1: the region 4000,4000,9,9 has no pixel in"),
        (format!("{locked}@@TRAX:frame file:///no/such.png\n"), "frame 2: cannot read /no/such.png: "),
        (format!("{locked}@@TRAX:frame image:2;1;gray8;AAA=\n"), "frame 2: the frame has another size than"),
        (format!("{locked}@@TRAX:quit now\n"), "quit has 1 arguments: expected none"),
    ] {
        let (answers, ended) = session(MethodKind::Smr, 4, lines.as_bytes());
        let error = format!("{:#}", ended.unwrap_err());
        assert!(error.starts_with(expected), "{expected}: {error}");
        let quit = answers.last().unwrap();
        assert_eq!((quit.name.as_str(), &quit.properties), ("quit", &vec![("trax.reason".to_owned(), error)]));
    }
    let (answers, ended) = session(MethodKind::Smr, 4, b"@@TRAX:frame \xFF\n");
    assert_eq!(ended.unwrap_err().to_string(), "a line is not UTF-8: expected text");
    assert_eq!(names(&answers), ["hello", "quit"]);
}

#[test]
fn a_client_that_has_gone_ends_the_session() {
    session(MethodKind::Smr, 4, b"").1.unwrap();
    session(MethodKind::Smr, 4, b"@@TRAX:initialize 1,2,3,4").1.unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn any_lines_end_the_session_in_order(lines in proptest::collection::vec(
        "(@@TRAX:(initialize|frame|quit|state) ([0-9.,-]{1,12} |image:[1-3];[1-3];gray8;[A-Z=]{0,8} |[a-z=]{1,5} ){0,3}|[ -~]{0,30})\n",
        0..6
    )) {
        let (answers, ended) = session(MethodKind::Robust, 4, lines.concat().as_bytes());
        prop_assert_eq!(ended.is_err(), answers.last().unwrap().name == "quit");
    }
}
