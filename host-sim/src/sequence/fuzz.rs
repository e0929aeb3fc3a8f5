//! Every reader meets arbitrary bytes, and files that are damaged in one place: an error or frames, and never a panic.

use super::damage::{self, Reading};
use super::*;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageFormat};
use proptest::prelude::*;
use std::fs;

const SIDES: (u32, u32) = (24, 16);

fn picture(format: ImageFormat) -> Vec<u8> {
    let (width, height) = SIDES;
    let pixels: Vec<u8> = (0..width * height).map(|at| (at * at * 31 % 251) as u8).collect();
    let mut bytes = std::io::Cursor::new(Vec::new());
    match format {
        ImageFormat::Jpeg => {
            JpegEncoder::new(&mut bytes).encode(&pixels, width, height, ExtendedColorType::L8).unwrap();
        }
        _ => {
            image::write_buffer_with_format(&mut bytes, &pixels, width, height, ExtendedColorType::L8, format).unwrap();
        }
    }
    bytes.into_inner()
}

/// Frames that are given to a tracker have as many pixels as they say, and one at least.
fn check(sequence: Result<Sequence>) -> Result<(), TestCaseError> {
    let Ok(sequence) = sequence else { return Ok(()) };
    for frame in sequence.frames.take(5).flatten() {
        prop_assert!(frame.width > 0 && frame.height > 0);
        prop_assert_eq!(frame.pixels.len(), usize::from(frame.width) * usize::from(frame.height));
        let _ = frame.frame();
    }
    Ok(())
}

/// Reads `bytes` as the file `name`, both ways.
fn read_as(name: &str, bytes: &[u8], size: Option<(u16, u16)>) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    for lenient in [false, true] {
        check(open(&file, &OpenOptions { size, lenient, ..OpenOptions::default() }))?;
    }
    Ok(())
}

/// A file that was cut, and in which a few bytes are others.
fn damaged(whole: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let length = whole.len();
    let changes = proptest::collection::vec((0..length, any::<u8>()), 0..4);
    (changes, 0..=length).prop_map(move |(changes, cut)| {
        let mut bytes = whole.clone();
        changes.iter().for_each(|&(at, byte)| bytes[at] = byte);
        // Half of them whole: what is cut early shows little else.
        bytes.truncate(if cut % 2 == 0 { length } else { cut });
        bytes
    })
}

proptest! {
    #[test]
    fn damaged_png(bytes in damaged(picture(ImageFormat::Png))) {
        read_as("1.png", &bytes, None)?;
    }

    #[test]
    fn damaged_jpeg(bytes in damaged(picture(ImageFormat::Jpeg))) {
        read_as("1.jpg", &bytes, None)?;
    }

    #[test]
    fn damaged_pgm(bytes in damaged(picture(ImageFormat::Pnm))) {
        read_as("1.pgm", &bytes, None)?;
    }

    #[test]
    fn pnm_headers(
        magic in "P[1-7]", fields in proptest::collection::vec("[0-9]{1,6}|-1|#\n", 0..4), rest: Vec<u8>
    ) {
        read_as("1.ppm", &[format!("{magic}\n{}\n", fields.join(" ")).as_bytes(), &rest].concat(), None)?;
    }

    #[test]
    fn arbitrary_bytes(
        name in prop::sample::select(&["1.png", "1.jpg", "1.pnm", "1.y4m", "1.raw"][..]), bytes: Vec<u8>
    ) {
        read_as(name, &bytes, None)?;
    }

    #[test]
    fn damaged_y4m(bytes in damaged(b"YUV4MPEG2 W3 H2 F25:1 Cmono\nFRAME\n123456FRAME\n123456".to_vec())) {
        read_as("1.y4m", &bytes, None)?;
    }

    #[test]
    fn raw_of_any_size(bytes: Vec<u8>, width in 0..9_u16, height in 0..9_u16) {
        read_as("1.raw", &bytes, Some((width, height)))?;
        read_as("1.raw", &bytes, Some((width.wrapping_sub(1), height.wrapping_sub(1))))?;
    }

    /// Ground truth in both forms, the box to start from, and others' results.
    #[test]
    fn box_files(
        name in prop::sample::select(&["gt.txt", "groundtruth_rect.txt", "init.txt", "result.txt"][..]),
        bytes in prop_oneof![any::<Vec<u8>>(), "([0-9NaN.,eE+-]{0,9}[,\t \r\n]){0,12}".prop_map(String::into_bytes)],
    ) {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
        fs::write(folder.path().join("1.pgm"), b"P5 2 1 255\n\x03\xFF").unwrap();
        let opened = open(folder.path(), &OpenOptions::default());
        if let Ok(sequence) = &opened {
            let _ = sequence.start();
        }
        check(opened)?;
        let _ = boxes::read_tld(&folder.path().join(name));
    }

    /// Whatever a source gives, as long as its frames have the pixels that they say.
    #[test]
    fn frames_of_any_sizes(sizes in proptest::collection::vec((0..3_u16, 0..3_u16), 0..4)) {
        let frame = |(width, height): (u16, u16)| {
            Ok(GrayFrame { width, height, pixels: vec![0; usize::from(width) * usize::from(height)] })
        };
        let frames = damage::frames(sizes.into_iter().map(frame), "any".to_owned(), Reading::default());
        for frame in frames.flatten() {
            prop_assert!(frame.frame().bounds().area() > 0);
        }
    }
}
