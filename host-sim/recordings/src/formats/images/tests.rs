use super::*;
use crate::checked_frames::Damaged;
use crate::fixtures::{fits, folder, levels, message, read, reads};
use crate::formats::to_gray;
use crate::frame::Frames;
use crate::open::{OpenOptions, open};
use crate::seekable::Seekable;
use png::{BitDepth, ColorType};
use std::fs;
use std::time::Duration;

fn png((width, height): (u32, u32), color: ColorType, depth: BitDepth, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_palette(&[0, 0, 0, 255, 0, 0]);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

fn jpeg_of(quality: u8, side: u16, color: jpeg_encoder::ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    jpeg_encoder::Encoder::new(&mut bytes, quality).encode(samples, side, side, color).unwrap();
    bytes
}

/// A JPEG of random pixels, so that most of its bytes are pixel data.
fn jpeg() -> Vec<u8> {
    let pixels: Vec<u8> = (0..96 * 96_u32).map(|at| at.wrapping_mul(2_654_435_761).to_be_bytes()[0]).collect();
    jpeg_of(75, 96, jpeg_encoder::ColorType::Luma, &pixels)
}

fn jpeg_with(marker: u8, data: &[u8]) -> Vec<u8> {
    let (whole, length) = (jpeg(), u16::try_from(data.len() + 2).unwrap().to_be_bytes());
    [&whole[..2], &[0xFF, marker], &length, data, &whole[2..]].concat()
}

/// Colors become gray by BT.601, 16-bit values by their high byte, and small bit depths are expanded to 8 bits.
#[test]
fn every_kind_becomes_gray() {
    let dot = |color, depth, samples: &[u8]| png((1, 1), color, depth, samples);
    for (color, gray) in [([255, 0, 0], 76), ([0, 255, 0], 150), ([0, 0, 255], 29), ([255; 3], 255), ([7; 3], 7)] {
        let [r, g, b] = color;
        let pam = b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
        for bytes in [
            dot(ColorType::Rgb, BitDepth::Eight, &color),
            dot(ColorType::Rgba, BitDepth::Eight, &[r, g, b, 9]),
            [b"P6 1 1 255\n", &color[..]].concat(),
            format!("P3 1 1 255\n{r} {g} {b}\n").into_bytes(),
            [&pam[..], &color, &[9]].concat(),
        ] {
            assert_eq!(decode_image(&bytes).unwrap().pixels, [gray], "{color:?}");
        }
        let jpeg = jpeg_of(95, 8, jpeg_encoder::ColorType::Rgb, &color.repeat(64));
        let found = decode_image(&jpeg).unwrap().pixels;
        assert!(found.iter().all(|pixel| pixel.abs_diff(gray) <= 2), "{found:?}");
    }
    for (bytes, gray) in [
        (dot(ColorType::Grayscale, BitDepth::Sixteen, &[0x81, 0xFF]), 0x81),
        (dot(ColorType::GrayscaleAlpha, BitDepth::Sixteen, &[0x81, 0xFF, 0, 9]), 0x81),
        (dot(ColorType::Rgb, BitDepth::Sixteen, &[0xFF, 0xFF, 0, 0xFF, 0, 0]), 76),
        (dot(ColorType::Grayscale, BitDepth::Four, &[0xF0]), 255),
        (dot(ColorType::Grayscale, BitDepth::One, &[0x80]), 255),
        (dot(ColorType::Indexed, BitDepth::Eight, &[1]), 76),
        (b"P5 1 1 65535\n\x81\xFF".to_vec(), 0x81),
        (b"P2 1 1 65535\n33279\n".to_vec(), 0x81),
    ] {
        assert_eq!(decode_image(&bytes).unwrap().pixels, [gray], "{bytes:?}");
    }
    let ramp: Vec<u8> = (0..=255).collect();
    let pgm = [b"P5\n# a comment\n16 16\n255\n", &ramp[..]].concat();
    for bytes in [png((16, 16), ColorType::Grayscale, BitDepth::Eight, &ramp), pgm] {
        assert_eq!(decode_image(&bytes).unwrap().pixels, ramp);
    }
}

#[test]
fn what_is_damaged_or_not_read_is_named() {
    let jpeg_as = |marker: u8, precision: u8, height: u8| {
        let mut bytes = jpeg();
        let at = bytes.windows(2).position(|two| two == [0xFF, 0xC0]).unwrap();
        (bytes[at + 1], bytes[at + 4], bytes[at + 6]) = (marker, precision, height);
        bytes
    };
    let png_with = |kind: &[u8; 4], data: &[u8]| {
        let length = u32::try_from(data.len()).unwrap().to_be_bytes();
        [b"\x89PNG\r\n\x1a\n", &length[..], kind, data, &[0; 4]].concat()
    };
    let refused = |bytes: &[u8], expected: &str, is_damage: bool| {
        let error = decode_image(bytes).unwrap_err();
        fits(&error.to_string(), expected, &format!("{:?}", &bytes[..bytes.len().min(40)]));
        assert_eq!(error.is::<Damaged>(), is_damage, "{error}");
    };
    for (bytes, expected) in [
        (jpeg_as(0xC9, 8, 96), "it is an arithmetic-coded JPEG, which is not supported: convert it to PNG first"),
        (jpeg_as(0xCA, 8, 96), "it is an arithmetic-coded JPEG..."),
        (jpeg_as(0xC3, 8, 96), "it is a lossless JPEG..."),
        (jpeg_as(0xC1, 12, 96), "it is a JPEG of more than 8 bits..."),
        (jpeg_as(0xC5, 8, 96), "it is a hierarchical JPEG..."),
        (jpeg_as(0xF7, 8, 96), "it is a JPEG-LS picture..."),
        (jpeg_as(0xC0, 8, 0), "it is a JPEG whose height follows its pixels..."),
        (b"RIFF\x10\0\0\0WEBPVP8 ".to_vec(), "it is a WebP picture, which is not supported..."),
        (b"\0\0\0\x18ftypheic\0\0\0\0".to_vec(), "it is a HEIC picture..."),
        (b"\0\0\0\x20ftypavif\0\0\0\0".to_vec(), "it is an AVIF picture..."),
        (b"PF\n2 1\n-1.0\n".to_vec(), "it is a picture of floating-point numbers (PFM)..."),
        (b"II*\0\x08\0\0\0".to_vec(), "it is a TIFF picture..."),
        (b"BM\0\0".to_vec(), "it is a BMP picture..."),
        (b"P4 8 1 \xAA".to_vec(), "it is a bitmap of one bit (PBM)..."),
        (b"P5 2 1 1023\n\x03\xFF\0\0".to_vec(), "its largest value is 1023: expected 255 or 65535"),
        (b"P5\n0 5\n255\n".to_vec(), "it is 0x5: expected at least 1 pixel on each side"),
        (b"P6 5 0 255\n".to_vec(), "it is 5x0: expected at least 1 pixel on each side"),
        (png_with(b"acTL", &[0, 0, 0, 9, 0, 0, 0, 0]), "it is an animated PNG of 9 pictures..."),
        (png_with(b"CgBI", &[0; 4]), "it is a PNG in Apple's own form..."),
    ] {
        refused(&bytes, expected, false);
    }
    assert!(decode_image(&jpeg_as(0xC1, 8, 96)).is_ok(), "extended, but as baseline");
    let (whole, cut) = (jpeg(), "expected a PNG, JPEG, PGM, PPM or PAM picture: it is cut short");
    for length in [700, whole.len() / 2, whole.len() - 40, whole.len() - 2, whole.len() - 1] {
        refused(&whole[..length], "expected a PNG, JPEG, PGM, PPM or PAM picture: ...", true);
    }
    let png = png((64, 64), ColorType::Grayscale, BitDepth::Eight, &[9; 64 * 64]);
    refused(&png[..png.len() / 2], cut, true);
    for bytes in [&b"P5 2 2 255\n123"[..], b"P5 2 2 65535\n1234567", b"P2 2 2 255\n1 2 3", b"P2 2 1 255 1 256"] {
        refused(bytes, cut, true);
    }
    for bytes in [&b"P5 2 2"[..], b"P7\nWIDTH 2"] {
        refused(bytes, "expected a PNG, JPEG, PGM, PPM or PAM picture: its header has no ...", true);
    }
    reads("pages.tif", None, b"II*\0", &[], "...: this kind of picture is not supported: convert it to PNG first");
    let text = "@/notes.txt is a text file: expected a recording (a video, Y4M or pictures)";
    reads("notes.txt", None, b"no", &[], text);
}

#[cfg(unix)]
#[test]
fn an_image_may_come_through_a_pipe() {
    let folder = folder("");
    let pipe = folder.path().join("1.pgm");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let writer = pipe.clone();
    let written = std::thread::spawn(move || fs::write(writer, b"P5 2 1 255\n78"));
    assert_eq!(levels(&read(&pipe, &OpenOptions::default()).0), [b'7']);
    written.join().unwrap().unwrap();
}

/// Stores an upright image of 3x2 pixels in each Exif orientation, and expects it upright after decoding.
#[test]
fn images_are_turned_as_their_exif_data_say() {
    let upright = [1, 2, 3, 4, 5, 6];
    for (orientation, (width, height), stored) in [
        (1, (3, 2), upright),
        (2, (3, 2), [3, 2, 1, 6, 5, 4]),
        (3, (3, 2), [6, 5, 4, 3, 2, 1]),
        (4, (3, 2), [4, 5, 6, 1, 2, 3]),
        (5, (2, 3), [1, 4, 2, 5, 3, 6]),
        (6, (2, 3), [3, 6, 2, 5, 1, 4]),
        (7, (2, 3), [6, 3, 5, 2, 4, 1]),
        (8, (2, 3), [4, 1, 5, 2, 6, 3]),
    ] {
        let mut bytes = Vec::new();
        let mut info = png::Info::with_size(width, height);
        info.exif_metadata = Some(to_gray::tests::exif(true, orientation).into());
        let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
        encoder.write_header().unwrap().write_image_data(&stored).unwrap();
        let gray = decode_image(&bytes).unwrap();
        assert_eq!((gray.width, gray.height, &gray.pixels[..]), (3, 2, &upright[..]), "{orientation}");
        assert_eq!(decode_colors(&bytes).unwrap().pixels, upright.map(|value| [value; 3]));
    }
    let plain = decode_image(&jpeg()).unwrap();
    let turned = decode_image(&jpeg_with(0xE1, &[to_gray::EXIF, &to_gray::tests::exif(false, 6)].concat())).unwrap();
    assert!((0..96).all(|at| turned.level(95 - at, 7) == plain.level(7, at)), "from the left to the top");
}

#[test]
fn bytes_behind_the_end_of_a_jpeg_do_not_matter() {
    let (whole, expected) = (jpeg(), decode_image(&jpeg()).unwrap());
    let views = [&jpeg_with(0xE2, b"MPF\0II*\0")[..], &whole, &whole].concat();
    assert_eq!(decode_image(&views).unwrap(), expected);
    for behind in [&b"\xFF\xDA\xFF\xD9\xFF\xDA film"[..], b"\0\0\0\x18ftypmp42\xFF\xD8\xFF\xDA", b"a trailer"] {
        assert_eq!(decode_image(&[&whole, behind].concat()).unwrap(), expected);
        let damage = message(decode_image(&[&whole[..whole.len() - 40], behind].concat()));
        assert!(damage.contains("it is damaged") || damage.contains("its end is missing"), "{damage}");
    }
}

/// Images of webcams, and frames cut out of AVI, lack some or all Huffman tables.
#[test]
fn huffman_tables_that_are_missing_are_the_standard_ones() {
    let whole = jpeg();
    for kept in [&[][..], &[0x00], &[0x10]] {
        let (mut bytes, mut at) = (whole[..2].to_vec(), 2);
        while whole[at + 1] != 0xDA {
            let end = at + 2 + usize::from(u16::from_be_bytes([whole[at + 2], whole[at + 3]]));
            if whole[at + 1] != 0xC4 || kept.contains(&whole[at + 4]) {
                bytes.extend(&whole[at..end]);
            }
            at = end;
        }
        assert!(bytes.len() < at, "a table is left out");
        bytes.extend(&whole[at..]);
        assert_eq!(decode_image(&bytes).unwrap(), decode_image(&whole).unwrap(), "{kept:?}");
    }
}

#[test]
fn several_images_in_one_file_are_a_recording() {
    let folder = folder("");
    let png = |value: u8| png((2, 1), ColorType::Grayscale, BitDepth::Eight, &[value; 2]);
    let small = |value: u8| jpeg_of(100, 8, jpeg_encoder::ColorType::Luma, &[value; 64]);
    let pnm = |header: &str, value: u8| [header.as_bytes(), &[value; 2], b"\n"].concat();
    let text = |value: u8| format!("P2 2 1 255 {value} {value}\n").into_bytes();
    let wide = |value: u8| [b"P5 2 1 65535\n", &[value, 99, value, 99][..]].concat();
    for (name, images) in [
        ("a.png", [7, 8, 9].map(png)),
        ("a.jpg", [7, 8, 9].map(small)),
        ("a.pgm", [7, 8, 9].map(|value| pnm("P5 2 1 255\n", value))),
        ("b.pgm", [7, 8, 9].map(|value| pnm("P5\n# two\n2 1\n255\n", value))),
        ("a.pnm", [7, 8, 9].map(text)),
        ("b.pnm", [7, 8, 9].map(wide)),
    ] {
        let (file, all) = (folder.path().join(name), images.concat());
        fs::write(&file, &all).unwrap();
        let (recording, sequence) = Seekable::open(&file, &OpenOptions::default()).unwrap();
        assert_eq!((sequence.length, sequence.source.image_names()), (Some(3), vec![]), "{name}");
        let levels = |frames: Frames| frames.map(|frame| frame.unwrap().gray.pixels[0]).collect::<Vec<_>>();
        assert_eq!((levels(sequence.frames), levels(recording.gray_from(3).unwrap())), (vec![7, 8, 9], vec![9]));
        assert_eq!(recording.color_from(2, 9).unwrap().next().unwrap().pixels[0], [8; 3]);
        assert!(message(decode_image(&all)).starts_with("it holds several pictures"), "{name}");
        reads(name, None, &all[..all.len() - images[2].len() / 2], &[7, 8], "...(frame 3)...");
    }
    let preview = [small(7), jpeg()].concat();
    reads("c.jpg", None, &preview, &[decode_image(&preview).unwrap().pixels[0]], "");
}

#[test]
fn levels_of_16_bits_are_said_and_stretched() {
    let folder = folder("");
    let value = |at: u16| 7600 + 3 * (at % 256);
    for number in 1..=3_u16 {
        let pixels: Vec<u8> = (0..1024).flat_map(|at| value(at + number).to_be_bytes()).collect();
        let image = [b"P5 32 32 65535\n", &pixels[..]].concat();
        fs::write(folder.path().join(format!("{number}.pgm")), image).unwrap();
    }
    let options = |levels: Option<&str>| {
        let levels = levels.map(|levels| levels.parse().unwrap());
        OpenOptions { levels, ..OpenOptions::default() }
    };
    let opened = |levels| open(folder.path(), &options(levels)).unwrap();
    let note = "its 16-bit values are only 7600 to 8365, so trackers see the gray levels 29 to 32: --levels 7409..8556 gives more contrast";
    assert_eq!(opened(None).notes, [note]);
    let stretched = opened(Some("7600..8365"));
    assert_eq!(stretched.notes, Vec::<String>::new());
    for (number, frame) in (1..).zip(stretched.in_color(Duration::ZERO).frames) {
        let (gray, color) = frame.map(|frame| (frame.gray.pixels, frame.color.unwrap().pixels)).unwrap();
        assert!((0..1024_u16).zip(&gray).all(|(at, &pixel)| u16::from(pixel) == (at + number) % 256));
        assert_eq!(color[5], [gray[5]; 3]);
    }
    assert_eq!(opened(Some("0..100")).notes.len(), 1, "all is white");
    let error = message(open(Path::new("synthetic"), &options(Some("0..9"))));
    assert_eq!(error, "--levels is for 16-bit pictures: synthetic is none");
    let file = folder.path().join("other.pgm");
    fs::write(&file, b"P5 1 1 255\n9").unwrap();
    let error = read(&file, &options(Some("0..9"))).1;
    assert!(error.ends_with("--levels is for 16-bit pictures: this one has 8 bits"), "{error}");
    fs::write(&file, b"P5 3 1 65535\n\0\0\0\x05\0\x09").unwrap();
    assert_eq!(read(&file, &options(Some("0..9"))).0[0].pixels, [0, 142, 255]);
}
