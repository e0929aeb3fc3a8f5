//! Every reader of host-sim: it returns an error or the content, and never panics.

use smr_core::Rect;
use smr_evaluation::robustness::Former;
use smr_recordings::annotations::{self, Labelled};
use smr_recordings::boxes::{self, Form};
use smr_recordings::{BoundingBox, FrameRange, OpenOptions, Resize, Sequence, check_gone};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

struct Place(TempDir);

thread_local! {
    static PLACE: Place = Place(TempDir::new().expect("a folder for files"));
}

fn as_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
    PLACE.with(|Place(folder)| {
        let file: PathBuf = folder.path().join(name);
        fs::write(&file, bytes).expect("room for a small file");
        read(&file);
        fs::remove_file(&file).expect("it was written");
    });
}

/// Checks that every frame has the stated number of pixels, and at least one.
fn check(sequence: anyhow::Result<Sequence>) {
    let Ok(sequence) = sequence else { return };
    let _ = sequence.start();
    for frame in sequence.frames.take(5).flatten().map(|frame| frame.gray) {
        assert!(frame.width > 0 && frame.height > 0);
        assert_eq!(frame.pixels.len(), usize::from(frame.width) * usize::from(frame.height));
        assert_eq!(frame.frame().bounds(), Rect::new(0, 0, frame.width, frame.height));
    }
}

fn recording(name: &str, bytes: &[u8], size: Option<(u16, u16)>) {
    as_file(name, bytes, |file| {
        check(smr_recordings::open(file, &OpenOptions { size, ..OpenOptions::default() }));
    });
}

/// Reads PNM, PNG or JPEG, detected by the first bytes.
pub(crate) fn picture(bytes: &[u8]) {
    let Ok(frame) = smr_recordings::decode_image(bytes) else { return };
    assert_eq!(frame.pixels.len(), usize::from(frame.width) * usize::from(frame.height));
    let _ = frame.frame();
}

pub(crate) fn pnm(bytes: &[u8]) {
    recording("1.pgm", bytes, None);
}

pub(crate) fn png(bytes: &[u8]) {
    recording("1.png", bytes, None);
}

pub(crate) fn jpeg(bytes: &[u8]) {
    recording("1.jpg", bytes, None);
}

pub(crate) fn y4m(bytes: &[u8]) {
    recording("1.y4m", bytes, None);
}

pub(crate) fn raw(bytes: &[u8]) {
    let Some((&[a, b, c, d], pixels)) = bytes.split_first_chunk() else { return };
    recording("1.raw", pixels, Some((u16::from_le_bytes([a, b]) >> 6, u16::from_le_bytes([c, d]) >> 6)));
}

/// Checks that each target begins with a box, has at most one entry in a frame, and boxes with pixels.
fn annotated(bytes: &[u8]) {
    let of = Labelled { name: "clip", size: (320, 240), frames: Some(300) };
    for target in annotations::parse(bytes, &of).unwrap_or_default() {
        let locks = target.rects().expect("boxes have pixels");
        assert!(locks.is_sorted_by_key(|(frame, _)| *frame) && locks[0].0 > 0 && locks[0].1.is_some());
        let frames = || locks.iter().map(|(frame, bbox)| (*frame, bbox.is_some()));
        assert!(frames().zip(frames().skip(1)).all(|((one, _), (next, _))| one < next));
        check_gone("the target", frames()).expect("gone follows a box");
    }
}

/// Reads ground truth, first boxes (`init.txt`) and results in the formats of TLD, OTB, VOT and GOT-10k; CSV and CVAT.
pub(crate) fn boxes(bytes: &[u8]) {
    let Some((form, text)) = bytes.split_first() else { return };
    annotated(text);
    let names = ["gt.txt", "groundtruth_rect.txt", "groundtruth.txt", "init.txt", "absence.label", "result.txt"];
    let name = names[usize::from(*form) % names.len()];
    as_file("1.pgm", b"P5 2 1 255\n\x03\xFF", |picture| {
        let folder = picture.parent().expect("it is in a folder");
        as_file(name, text, |file| {
            check(smr_recordings::open(folder, &OpenOptions::default()));
            for form in [Form::Tld, Form::Otb, Form::Vot] {
                let Ok(entries) = form.read(file) else { continue };
                for entry in entries.into_iter().flatten() {
                    let _ = (entry.to_rect(), entry.pixels(), entry.scaled((0.5, 3.0)));
                    let overlap = entry.iou(&entry);
                    assert!(overlap.is_nan() || overlap <= 1.0, "{entry:?}: {overlap}");
                }
            }
        });
    });
}

/// Parses arguments of the command line: a box, a region, a range of frames, a size.
pub(crate) fn words(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = text.parse::<BoundingBox>();
    let _ = boxes::region(text);
    let _ = text.parse::<FrameRange>();
    let _ = text.parse::<Resize>();
}

pub(crate) fn former(bytes: &[u8]) {
    as_file("former.json", bytes, |file| {
        let _ = Former::read(file);
    });
}
