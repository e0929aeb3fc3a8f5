//! `host-sim replay` with records of `smr_core::record`: whole, damaged, cut off, one after another, or part of a log.

use crate::program::{host_sim, utf8};
use host_sim::replay::{ReplayedRecord, replay};
use smr_core::paper::{self, Fraction, Radius};
use smr_core::record::{Recorded, Recorder};
use smr_core::similarity::Table;
use smr_core::{Answer, Frame, Image, Rect, Robust, State, Tracker, robust};
use smr_evaluation::CoreKind;
use smr_recordings::synthetic;
use std::convert::Infallible;
use std::fs;
use std::io::Cursor;

type Paper = smr_core::Paper<1024, 65>;

static STEEP: Table = match Table::new(100) {
    Ok(table) => table,
    Err(_) => panic!("100 is in range"),
};

/// The values set here differ from the preset's, so a record that lacks one of them gives other answers.
fn small_paper() -> paper::Config {
    let mut config = paper::Config::camera();
    config.table = &STEEP;
    config.window = Radius { x: 14, y: 12 };
    config.window_limit = Radius { x: 32, y: 31 };
    (config.k, config.growth, config.padding) = (Fraction::new(2, 7), 3, 17);
    (config.neighbourhood, config.least_threshold) = (6, 11);
    config.gate_tracking = Fraction::new(21, 20);
    config
}

fn other_robust() -> robust::Config {
    let mut config = robust::Config::refined();
    (config.reach, config.patience, config.learning_rate) = (6, 170, 150);
    config
}

fn start() -> Rect {
    synthetic::truth(0).and_then(|start| start.to_rect()).expect("it begins with the target in view")
}

/// Reduces a frame to the windows that the tracker asks for, as on a chip.
fn asked_for<'a, T: Recorded>(frame: Frame<'a>, tracker: &Tracker<T>) -> Frame<'a> {
    let Rect { width, height, .. } = frame.bounds();
    let part = |rect: Rect| {
        let place = |at: i32| u16::try_from(at).expect("inside the frame");
        (frame.patch(rect).expect("inside the frame"), place(rect.x), place(rect.y))
    };
    let window = tracker.window().filter(|window| !window.is_empty()).unwrap_or(Rect::new(0, 0, 1, 1));
    let (image, x, y) = part(window);
    let least = Frame::part(image, x, y, width, height).expect("inside the frame");
    let Some(sweep) = tracker.sweep_window() else { return least };
    let (image, x, y) = part(sweep);
    least.and_part(image, x, y).expect("inside the frame")
}

/// Tracks the built-in recording into a flight record with every kind of entry. Returns the record and the answers.
fn flight<T: Recorded>(config: T::Config, frames: usize) -> (Vec<u8>, Vec<Answer>) {
    let mut bytes = Vec::new();
    let mut tracker = Box::new(Tracker::<T>::with(config).expect("a good configuration"));
    let write = |piece: &[u8]| -> Result<(), Infallible> {
        bytes.extend(piece);
        Ok(())
    };
    let Ok(mut recorder) = Recorder::begin(tracker.target(), write);
    let mut answers = Vec::new();
    for (index, frame) in synthetic::frames().take(frames).enumerate() {
        let whole = frame.frame();
        if index == 0 {
            tracker.lock(&whole, start()).expect("it locks");
            let Ok(()) = recorder.lock(tracker.target(), &whole, start());
            continue;
        }
        if index == 7 {
            tracker.moved(300, -256);
            let Ok(()) = recorder.moved(300, -256);
        }
        if index == 9 {
            let shown = asked_for(whole, &tracker);
            let Ok(()) = recorder.window(tracker.target(), &shown);
            tracker.update_step(&shown, 1).expect("it has what it asks for");
        }
        if index == 20 {
            let mut saved = vec![0; T::SAVED_SIZE];
            let length = tracker.save(&mut saved).expect("there is a target");
            *tracker = Tracker::with(config).expect("a good configuration");
            tracker.restore(&saved[..length]).expect("its own bytes");
            let Ok(()) = recorder.restored(&saved[..length]);
        }
        let shown = asked_for(whole, &tracker);
        let Ok(()) = recorder.window(tracker.target(), &shown);
        let answer = tracker.update(&shown).expect("it has what it asks for");
        let Ok(()) = recorder.answer(&answer);
        answers.push(answer);
    }
    assert!(recorder.is_whole());
    (bytes, answers)
}

fn flights(frames: usize) -> [(CoreKind, Vec<u8>, Vec<Answer>); 2] {
    let (paper, by_paper) = flight::<Paper>(small_paper(), frames);
    let (robust, by_robust) = flight::<Robust>(other_robust(), frames);
    [(CoreKind::Paper, paper, by_paper), (CoreKind::Robust, robust, by_robust)]
}

fn replayed(bytes: &[u8]) -> Result<ReplayedRecord, String> {
    replay(Cursor::new(bytes), false, || ()).map_err(|error| format!("{error:#}"))
}

fn entries(bytes: &[u8]) -> Vec<(usize, [u8; 4])> {
    let mut all = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let word = |at: usize| <[u8; 4]>::try_from(&bytes[at..at + 4]).expect("four bytes");
        all.push((at, word(at)));
        at += 16 + u32::from_le_bytes(word(at + 8)) as usize;
    }
    assert_eq!(at, bytes.len());
    all
}

/// Rewrites the checksum of the entry at `at`, as if the tracker had written the changed bytes.
fn signed(mut bytes: Vec<u8>, at: usize) -> Vec<u8> {
    let length = u32::from_le_bytes(bytes[at + 8..at + 12].try_into().expect("four bytes")) as usize;
    let sum = crc32fast::hash(&bytes[at..at + 12 + length]);
    bytes[at + 12 + length..at + 16 + length].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn a_flight_is_replayed_bit_for_bit() {
    for (kind, bytes, answers) in flights(240) {
        let report = replayed(&bytes).expect("a record");
        assert_eq!((report.difference, report.damage, report.cut_off), (None, None, 0), "{kind:?}");
        let [flight] = &report.flights[..] else { panic!("one flight") };
        assert_eq!((flight.locks, flight.answers), (1, 239));
        assert_eq!((flight.moved, flight.restored, flight.given_up), (1, 1, 1));
        assert_eq!(flight.bytes, bytes.len() as u64);
        let count = |state| answers.iter().filter(|answer| answer.state == state).count() as u64;
        assert_eq!(flight.states, State::ALL.map(count));
        assert!(flight.states[3] > 0, "{kind:?}: the flight has a lost target: {:?}", flight.states);
        // Bytes of each entry, by the documentation: begin 584 (`Paper`) or 558 (`Robust`), moved 24. Without their
        // pixels: lock 36, window with answer 84, window without answer 36.
        let begin = if kind == CoreKind::Paper { 584 } else { 558 };
        let saved =
            entries(&bytes).windows(2).find(|pair| pair[0].1 == *b"SMRS").map_or(0, |pair| pair[1].0 - pair[0].0);
        let expected = begin + 36 + 84 * 239 + 36 + 24 + saved as u64 + flight.pixels;
        assert_eq!(flight.bytes, expected);
    }
}

#[test]
fn a_changed_answer_is_named() {
    // For each field of an answer: its offset in bytes after the entry's header, and its name in messages.
    let fields = [
        (0, "box in 1/256 pixel"),
        (16, "state"),
        (18, "confidence"),
        (20, "ratio"),
        (24, "alpha"),
        (26, "identity"),
        (28, "scale"),
        (17, "whether it was found again"),
    ];
    for (kind, bytes, _) in flights(12) {
        let answers: Vec<usize> =
            entries(&bytes).into_iter().filter(|(_, tag)| tag == b"SMRA").map(|(at, _)| at).collect();
        for (place, field) in fields {
            if field == (if kind == CoreKind::Robust { "alpha" } else { "identity" }) {
                continue; // it has none
            }
            let mut changed = bytes.clone();
            changed[answers[4] + 12 + place] ^= 1;
            let difference = replayed(&signed(changed, answers[4])).expect("a record").difference.expect("it differs");
            assert_eq!((difference.frame, difference.field, difference.flight), (6, field, 1), "{kind:?}");
            assert_ne!(difference.recorded, difference.replayed);
        }
    }
}

/// Entries with random content and correct checksums give a verdict or an error.
#[test]
fn no_entry_makes_it_panic() {
    let mut state = 1_u64;
    let mut random = |end: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).expect("31 bits") % end
    };
    for (kind, bytes, _) in flights(4) {
        let all = entries(&bytes);
        for _ in 0..if kind == CoreKind::Paper { 400 } else { 60 } {
            let (at, _) = all[random(all.len())];
            let length = u32::from_le_bytes(bytes[at + 8..at + 12].try_into().expect("four bytes")) as usize;
            let mut changed = bytes.clone();
            for _ in 0..=random(3) {
                // Changes bytes at the start of an entry, or at its end, where a configuration has its numbers.
                let place = if random(2) == 0 { random(length.min(40)) } else { length - 1 - random(length.min(60)) };
                changed[at + 12 + place] = [0, 1, 0x7F, 0x80, 0xFF][random(5)];
            }
            let _ = replayed(&signed(changed, at));
        }
    }
}

#[test]
fn a_changed_pixel_or_configuration_is_noticed() {
    for (kind, bytes, _) in flights(12) {
        // Inverts pixels in the middle of the locked box, which changes the target.
        let (lock, _) = entries(&bytes)[1];
        let mut changed = bytes.clone();
        for pixel in &mut changed[lock + 32 + 200..lock + 32 + 400] {
            *pixel = !*pixel;
        }
        let report = replayed(&signed(changed, lock)).expect("a record");
        assert!(report.difference.is_some(), "{kind:?}");
        // Changes the configuration: the search radius or the learning rate.
        let (end, _) = entries(&bytes)[1];
        let mut changed = bytes.clone();
        changed[end - 4 - if kind == CoreKind::Paper { 2 * 11 } else { 6 }] ^= 3;
        let report = replayed(&signed(changed, 0)).expect("a record");
        assert!(report.difference.is_some(), "{kind:?}");
    }
}

#[test]
fn firmware_that_starts_again_appends() {
    let [(_, paper, _), (_, robust, _)] = flights(5);
    let cut = &paper[..paper.len() - 30];
    let report = replayed(&[cut, &robust].concat()).expect("a record");
    assert_eq!((&report.damage, report.flights.len()), (&None, 2));
    let [first, second] = &report.flights[..] else { panic!("two flights") };
    assert_eq!((first.method, first.answers, first.cut_off), ("paper", 3, 18));
    assert!(first.unanswered.as_ref().is_some_and(|last| last.frame == 5 && last.state == "tracking"));
    assert_eq!((second.method, second.answers, second.unanswered.is_none()), ("robust", 4, true));
    let report = replayed(&[&robust[..], &[0xFF; 5000]].concat()).expect("a record");
    assert_eq!((report.cut_off, report.flights[0].answers), (5000, 4));
}

#[test]
fn damage_in_the_middle_is_no_verdict() {
    let [(_, bytes, _), _] = flights(6);
    let all = entries(&bytes);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flight.smr");
    let refused = |bytes: &[u8], words: &[&str]| {
        fs::write(&file, bytes).unwrap();
        let said = host_sim(&["replay", utf8(&file)]);
        said.refuses(&[&["flight.smr"], words].concat());
        said.out
    };
    let mut damaged = bytes.clone();
    damaged[all[4].0 + 40] ^= 1;
    let out = refused(&damaged, &["bytes at byte", "are damaged", "the entries before it were replayed"]);
    assert!(out.contains("1 answers as recorded"), "{out}");
    // Removes one entry, as if a log had lost a line.
    let without = [&bytes[..all[5].0], &bytes[all[6].0..]].concat();
    refused(&without, &["entry 5 is missing"]);
    let mut other = bytes.clone();
    other[12] = 9;
    refused(&signed(other, 0), &["version 9 of the record: expected 2"]);
}

/// Heads of entries that each claim the rest of the record: smr-core's tests bound the work.
#[test]
fn a_record_of_damaged_heads_is_refused() {
    let mut bytes = Vec::new();
    while bytes.len() < 1 << 20 {
        let left = u32::try_from((1 << 20) - bytes.len()).expect("a small number");
        bytes.extend([*b"SMRB", [0; 4], left.to_le_bytes()].concat());
    }
    bytes.resize((1 << 20) + 16, 0);
    assert_eq!(replayed(&bytes).unwrap_err(), "its first entry, SMRB, is damaged: nothing can be replayed");
    // After a flight: its entries are replayed, and the rest is damaged.
    let [(_, paper, _), _] = flights(5);
    let report = replayed(&[&paper[..], &bytes].concat()).expect("a record");
    assert_eq!((report.flights.len(), report.flights[0].answers), (1, 4));
    assert!(report.damage.is_some_and(|damage| damage.contains("are damaged: no entry")));
}

#[test]
fn the_command_says_what_holds() {
    let [(_, paper, _), (_, robust, _)] = flights(6);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flight.smr");
    fs::write(&file, [&paper[..], &robust].concat()).unwrap();
    let said = host_sim(&["replay", utf8(&file)]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
    assert!(said.out.contains("flight 2 of 2, robust: 1 lock, 5 answers as recorded, bit for bit"), "{}", said.out);
    let json = host_sim(&["replay", utf8(&file), "--json"]).json();
    assert_eq!((&json["flights"][0]["method"], &json["flights"][1]["answers"]), (&"paper".into(), &5.into()));
    assert!(json["difference"].is_null() && json["damage"].is_null());
    let [small, other] = [0, 1].map(|flight| &json["flights"][flight]);
    assert_eq!((&small["settings"]["k"], &other["settings"]["reach"]), (&[2, 7].into(), &[6].into()));
    let said = small["entries"].as_array().unwrap();
    assert_eq!((said.len(), &said[0]["begin"], &said[1]["lock"][2]), (12, &"P".into(), &start().width.into()));
    assert_eq!((&said[2]["frame"][2], &said[3]["state"]), (&160.into(), &"tracking".into()));

    let (at, _) = entries(&paper).into_iter().rfind(|(_, tag)| tag == b"SMRA").unwrap();
    let mut changed = paper.clone();
    changed[at + 12 + 16] = 3;
    fs::write(&file, signed(changed, at)).unwrap();
    let said = host_sim(&["replay", utf8(&file)]);
    assert_eq!((said.code, said.err.as_str()), (Some(1), ""));
    assert!(
        said.out.contains("DIFFERS in frame 6: state\n    recorded: lost\n    replayed: tracking\n"),
        "{}",
        said.out
    );
    let said = host_sim(&["replay", utf8(&file), "--json"]);
    let json: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((said.code, &json["difference"]["field"]), (Some(1), &"state".into()));
}

#[test]
fn a_printed_log_is_a_record_too() {
    let [(_, bytes, _), _] = flights(5);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.txt");
    let mut log = "INFO  a tracker takes 9680 bytes\n".to_owned();
    for piece in bytes.chunks(48) {
        let hex: Vec<String> = piece.iter().map(|byte| format!("{byte:02x}")).collect();
        log += &format!("      smr-record [{}]\nINFO  something else [01, 02]\n", hex.join(", "));
    }
    fs::write(&file, &log).unwrap();
    let said = host_sim(&["replay", utf8(&file)]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
    assert!(said.out.contains("4 answers as recorded"), "{}", said.out);
    fs::write(&file, &log[..log.len() - 100]).unwrap();
    assert!(host_sim(&["replay", utf8(&file)]).out.contains("cut off"));
}

#[test]
fn a_writer_that_fails_ends_the_record() {
    let mut tracker = Tracker::<Paper>::with(small_paper()).unwrap();
    let pixels = vec![7; 160 * 120];
    let frame = Frame::whole(Image::new(&pixels, 160, 120).unwrap());
    tracker.lock(&frame, start()).unwrap();
    for room in [0, 100, 590, 700, 1200] {
        let mut bytes = Vec::new();
        let write = |piece: &[u8]| {
            if bytes.len() + piece.len() > room {
                return Err("full");
            }
            bytes.extend(piece);
            Ok(())
        };
        let mut calls = 0;
        if let Ok(mut recorder) = Recorder::begin(tracker.target(), write) {
            let mut failed = 0;
            for _ in 0..5 {
                failed += u32::from(recorder.lock(tracker.target(), &frame, start()).is_err());
                calls += 1;
            }
            assert_eq!((failed, recorder.is_whole()), (1, false), "it is said once, and kept in mind: {room}");
        }
        assert!(bytes.len() <= room && (calls == 5 || room < 584));
        // The entries before the cut are valid.
        if room > 584 {
            let report = replayed(&bytes).unwrap();
            assert_eq!(report.flights[0].locks, u64::from(room > 584 + 36 + 24 * 28));
        }
    }
}
