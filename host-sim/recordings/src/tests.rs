use super::*;
use crate::formats::to_gray;
use png::{BitDepth, ColorType};
use tempfile::TempDir;

/// Creates a folder from a text of names separated by spaces: `NAME=TEXT` with `|` for line ends, `LINK->TARGET`, or
/// the bare name of a picture of 4x3 pixels, whose gray level is the number in its name.
pub fn folder(files: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files.split(' ').filter(|file| !file.is_empty()) {
        #[cfg(unix)]
        if let Some((link, target)) = file.split_once("->") {
            std::os::unix::fs::symlink(target, folder.path().join(link)).unwrap();
            continue;
        }
        let (name, text) = file.split_once('=').unwrap_or((file, ""));
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let level: String = name.chars().filter(char::is_ascii_digit).collect();
        let is_picture = text.is_empty() && images::kind(&path).is_some();
        let picture = || format!("P2 4 3 255{}", format!(" {level}").repeat(12));
        fs::write(path, if is_picture { picture() } else { text.replace('|', "\n") }).unwrap();
    }
    folder
}

fn open_plain(path: &Path) -> Result<Sequence> {
    open(path, &OpenOptions::default())
}

fn message<T>(result: Result<T>) -> String {
    format!("{:#}", result.err().expect("an error"))
}

/// Returns the frames before the first error, and the error with `@` in place of the folder.
fn read(path: &Path, options: &OpenOptions) -> (Vec<GrayFrame>, String) {
    let (mut good, mut error) = (Vec::new(), String::new());
    let opened = open(path, options).map(|sequence| sequence.frames);
    for frame in opened.unwrap_or_else(|error| Box::new(std::iter::once(Err(error)))) {
        assert!(error.is_empty(), "nothing follows an error");
        match frame {
            Ok(frame) => good.push(frame.gray),
            Err(found) => error = format!("{found:#}"),
        }
    }
    let at = if path.is_dir() { path } else { path.parent().unwrap() };
    (good, error.replace(&at.display().to_string(), "@"))
}

fn levels(frames: &[GrayFrame]) -> Vec<u8> {
    frames.iter().map(|frame| frame.pixels[0]).collect()
}

/// Asserts that a file of `bytes` has frames whose first pixels are `expected`, then `error`, where `...` is any text.
#[track_caller]
fn reads(name: &str, size: Option<(u16, u16)>, bytes: &[u8], expected: &[u8], error: &str) {
    let folder = folder("");
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    let (frames, found) = read(&file, &OpenOptions { size, ..OpenOptions::default() });
    assert_eq!(levels(&frames), expected, "{name}: {found}");
    fits(&found, error, name);
}

#[track_caller]
fn fits(found: &str, expected: &str, of: &str) {
    let parts: Vec<&str> = expected.split("...").collect();
    let is_whole = parts.len() > 1 || found == expected;
    let holds = found.starts_with(parts[0]) && found.ends_with(parts[parts.len() - 1]);
    let fits = is_whole && holds && parts.iter().all(|part| found.contains(part));
    assert!(fits, "{of}: {found}, expected {expected}");
}

#[test]
fn folders_of_pictures_in_every_layout() {
    let vot = "groundtruth.txt=2,3,8,3,8,9,2,9|3,4,5,6|nan,nan,nan,nan sequence=channels.color=color/%08d.jpg";
    let vot = format!("color/00000001.png color/00000002.png color/00000003.png {vot}");
    let got = "00000001.png 00000002.png groundtruth.txt=2.0000,3.0000,6.0000,6.0000|2,3,6,6 absence.label=0|1";
    let tld = "img10.png img2.PNG img1.png .img3.png=thumbnail gt.txt=1,2,3,4|NaN,NaN,NaN,NaN|1,2,3,5";
    for (files, expected, boxes) in [
        (&vot[..], &[1, 2, 3][..], "2,3,6,6; 2,3,6,6 3,4,5,6 -"),
        (got, &[1, 2], "2,3,6,6; 2,3,6,6 -"),
        (tld, &[1, 2, 10], "1,2,2,2; 1,2,2,2 - 1,2,2,3"),
        ("img/0007.jpg groundtruth_rect.txt=2\t3\t4\t5", &[7], "1,2,4,5; 1,2,4,5"),
        ("1.png gt.txt=1,2,3,4 init.txt=0,0,2,2", &[1], "0,0,2,2; 1,2,2,2"),
        ("1.jpeg 2.JPG 3.jfif", &[1, 2, 3], "-; "),
        ("img/1.png depth/1.png", &[1], "-; "),
        ("1.png 3.png", &[1, 3], "-; "),
    ] {
        let folder = folder(files);
        let sequence = open_plain(folder.path()).unwrap();
        let shown = |entry: &Option<BoundingBox>| entry.map_or("-".to_owned(), |entry| entry.to_string());
        let truth: Vec<String> = sequence.truth.iter().flatten().map(shown).collect();
        assert_eq!(format!("{}; {}", shown(&sequence.init), truth.join(" ")), boxes, "{files}");
        assert_eq!((sequence.length, &sequence.name), (Some(expected.len()), &folder_name(folder.path())), "{files}");
        let (frames, error) = read(folder.path(), &OpenOptions::default());
        assert_eq!((levels(&frames), &error[..]), (expected.to_vec(), ""), "{files}");
        assert!(is_sequence(folder.path()), "{files}");
    }
}

#[test]
fn folders_that_are_refused() {
    let several = "...expected one kind; move the others away";
    let unread = "...: this kind of picture is not supported: convert it to PNG first";
    let bad = "cannot read @/2.png (frame 2): expected a PNG, JPEG, PGM, PPM or PAM picture: ...";
    let both = "@ holds @/a.mp4 and 1 pictures, @/1.png first: expected one or the other; name the file meant";
    let twins = "...two pictures with the same number: expected one for each frame; move the others away";
    for (files, good, expected) in [
        ("", 0, "@ holds no recording: expected pictures (PNG, JPEG, PGM, PPM, PAM) or one video"),
        ("1.png 2.png=P2|1|1|255|9 3.png", 1, "@, frame 2: it is 1x1: expected 4x3, the size of the first"),
        ("1.png 2.png=bad 3.png", 1, bad),
        ("1.png a.mp4", 0, both),
        ("a.mp4 cover.webp", 0, "...expected one or the other; name the file meant"),
        ("1.jpg 1.png", 0, several),
        ("1.pgm 1.ppm", 0, several),
        ("1.png img/1.png", 0, several),
        ("1.bmp img/1.png", 0, several),
        ("color/1.jpg img/1.jpg", 0, several),
        ("color/1.jpg color/1.png", 0, several),
        ("1.png 2.tif", 0, several),
        ("1.HEIC 2.HEIC", 0, unread),
        ("img/1.webp gt.txt=1,2,3,4", 0, unread),
        ("1.dng 2.dng", 0, unread),
        ("1.png 1_mask.png", 0, twins),
        ("left1.png right1.png", 0, twins),
        ("a.y4m", 0, "@/a.y4m is empty: expected a recording"),
        ("a.y4m b.mp4", 0, "@ holds several recordings, among them @/a.y4m and @/b.mp4: name the one meant"),
        ("1.png 2.png->nowhere 3.png", 0, "@/2.png (frame 2) is a link to a file that is not there"),
        ("1.png gt.txt->nowhere", 0, "cannot read @/gt.txt..."),
        ("1.png groundtruth_rect.txt->nowhere", 0, "cannot read @/groundtruth_rect.txt..."),
        ("1.png init.txt->nowhere", 0, "cannot read @/init.txt..."),
    ] {
        if cfg!(not(unix)) && files.contains("->") {
            continue;
        }
        let folder = folder(files);
        let (frames, error) = read(folder.path(), &OpenOptions::default());
        fits(&error, expected, files);
        assert_eq!(frames.len(), good, "{files}");
        if expected == unread {
            let found = recordings(&[folder.path().to_owned()]).and_then(|found| open_plain(&found[0]));
            fits(&message(found), unread, files);
        }
    }
    assert!(!is_sequence(folder("").path()));
    let missing = message(open_plain(&folder("").path().join("missing")));
    assert!(missing.contains("/missing: expected a folder, a file, or one of street, "), "{missing}");
}

#[test]
fn sizes_are_for_raw_dumps() {
    let sized = OpenOptions { size: Some((3, 2)), ..OpenOptions::default() };
    for (files, expected) in [
        ("1.png", "--size is for raw dumps: @ holds pictures"),
        ("a.y4m=YUV4MPEG2", "--size is for raw dumps: @/a.y4m is none"),
        ("a.raw=123456aBCDEF", ""),
    ] {
        assert_eq!(read(folder(files).path(), &sized).1, expected);
    }
    assert!(message(open(Path::new("synthetic"), &sized)).starts_with("--size is for raw dumps: synthetic"));
    let dump = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
    for name in ["dump.raw", "dump.dat"] {
        reads(name, Some((3, 2)), &dump, &[1, 7], "");
    }
    let cut = "@/dump.gray, frame 3: it is cut short, or its frames are not 3x2: expected 6 bytes, found 4";
    reads("dump.gray", Some((3, 2)), &[5; 16], &[5, 5], cut);
    reads("dump.raw", None, &dump, &[], "...the size of its frames is needed (--size WIDTHxHEIGHT)");
    reads("dump.raw", Some((0, 2)), &dump, &[], "--size 0x2: expected at least 1x1");
    reads("dump.raw", Some((16384, 16384)), &dump, &[], "...found 12");
    let large = "--size 16384x16385: a frame has 268451840 bytes: expected at most 268435456";
    reads("dump.raw", Some((16384, 16385)), &dump, &[], large);
}

#[test]
fn the_box_to_start_from() {
    let start = |init: &str| {
        let init = Some(init.parse().unwrap());
        let sequence = open(Path::new("synthetic"), &OpenOptions { init, ..OpenOptions::default() }).unwrap();
        assert_eq!((sequence.init, sequence.length), (init, Some(synthetic::LENGTH)));
        sequence.start().map_err(|error| error.to_string())
    };
    let large = "synthetic: the initial box is too large or too far away (at most 65535 pixels on a side): 0,0,70000,5 (x,y,width,height)";
    assert_eq!(start("1,1,2,2"), Ok(smr_core::Rect::new(1, 1, 2, 2)));
    assert_eq!(start("0,0,70000,5"), Err(large.to_owned()));
    assert!(start("1e300,0,7,5").unwrap_err().contains("too far away"));
    assert!(start("1,1,0.3,5").unwrap_err().contains("the initial box has no pixels: 1,1,0.3,5"));
    let beside = folder("x.y4m=YUV4MPEG2|W1|H1|Cmono| init.txt=0,0,2,2");
    assert_eq!(start_beside(&beside.path().join("x.mp4")).unwrap(), Some("0,0,2,2".parse().unwrap()));
    fs::write(beside.path().join("x.y4m"), b"YUV4MPEG2 W1 H1 Cmono\nFRAME\n\0").unwrap();
    assert_eq!(open_plain(&beside.path().join("x.y4m")).unwrap().init, Some("0,0,2,2".parse().unwrap()));
    fs::write(beside.path().join("init.txt"), "0,0").unwrap();
    assert!(message(start_beside(&beside.path().join("x.y4m"))).contains("init.txt"));
}

mod pictures {
    use super::*;

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
                assert_eq!(decode_picture(&bytes).unwrap().pixels, [gray], "{color:?}");
            }
            let jpeg = jpeg_of(95, 8, jpeg_encoder::ColorType::Rgb, &color.repeat(64));
            let found = decode_picture(&jpeg).unwrap().pixels;
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
            assert_eq!(decode_picture(&bytes).unwrap().pixels, [gray], "{bytes:?}");
        }
        let ramp: Vec<u8> = (0..=255).collect();
        let pgm = [b"P5\n# a comment\n16 16\n255\n", &ramp[..]].concat();
        for bytes in [png((16, 16), ColorType::Grayscale, BitDepth::Eight, &ramp), pgm] {
            assert_eq!(decode_picture(&bytes).unwrap().pixels, ramp);
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
            let error = decode_picture(bytes).unwrap_err();
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
        assert!(decode_picture(&jpeg_as(0xC1, 8, 96)).is_ok(), "extended, but as baseline");
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
    fn a_picture_may_come_through_a_pipe() {
        let folder = folder("");
        let pipe = folder.path().join("1.pgm");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = pipe.clone();
        let written = std::thread::spawn(move || fs::write(writer, b"P5 2 1 255\n78"));
        assert_eq!(levels(&read(&pipe, &OpenOptions::default()).0), [b'7']);
        written.join().unwrap().unwrap();
    }

    /// Stores an upright picture of 3x2 pixels in each Exif orientation, and expects it upright after decoding.
    #[test]
    fn pictures_are_turned_as_their_exif_data_say() {
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
            let gray = decode_picture(&bytes).unwrap();
            assert_eq!((gray.width, gray.height, &gray.pixels[..]), (3, 2, &upright[..]), "{orientation}");
            assert_eq!(decode_colors(&bytes).unwrap().pixels, upright.map(|value| [value; 3]));
        }
        let plain = decode_picture(&jpeg()).unwrap();
        let turned =
            decode_picture(&jpeg_with(0xE1, &[to_gray::EXIF, &to_gray::tests::exif(false, 6)].concat())).unwrap();
        assert!((0..96).all(|at| turned.level(95 - at, 7) == plain.level(7, at)), "from the left to the top");
    }

    #[test]
    fn bytes_behind_the_end_of_a_jpeg_do_not_matter() {
        let (whole, expected) = (jpeg(), decode_picture(&jpeg()).unwrap());
        let views = [&jpeg_with(0xE2, b"MPF\0II*\0")[..], &whole, &whole].concat();
        assert_eq!(decode_picture(&views).unwrap(), expected);
        for behind in [&b"\xFF\xDA\xFF\xD9\xFF\xDA film"[..], b"\0\0\0\x18ftypmp42\xFF\xD8\xFF\xDA", b"a trailer"] {
            assert_eq!(decode_picture(&[&whole, behind].concat()).unwrap(), expected);
            let damage = message(decode_picture(&[&whole[..whole.len() - 40], behind].concat()));
            assert!(damage.contains("it is damaged") || damage.contains("its end is missing"), "{damage}");
        }
    }

    /// Pictures of webcams, and frames cut out of AVI, lack some or all Huffman tables.
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
            assert_eq!(decode_picture(&bytes).unwrap(), decode_picture(&whole).unwrap(), "{kept:?}");
        }
    }

    #[test]
    fn several_pictures_in_one_file_are_a_recording() {
        let folder = folder("");
        let png = |value: u8| png((2, 1), ColorType::Grayscale, BitDepth::Eight, &[value; 2]);
        let small = |value: u8| jpeg_of(100, 8, jpeg_encoder::ColorType::Luma, &[value; 64]);
        let pnm = |header: &str, value: u8| [header.as_bytes(), &[value; 2], b"\n"].concat();
        let text = |value: u8| format!("P2 2 1 255 {value} {value}\n").into_bytes();
        let wide = |value: u8| [b"P5 2 1 65535\n", &[value, 99, value, 99][..]].concat();
        for (name, pictures) in [
            ("a.png", [7, 8, 9].map(png)),
            ("a.jpg", [7, 8, 9].map(small)),
            ("a.pgm", [7, 8, 9].map(|value| pnm("P5 2 1 255\n", value))),
            ("b.pgm", [7, 8, 9].map(|value| pnm("P5\n# two\n2 1\n255\n", value))),
            ("a.pnm", [7, 8, 9].map(text)),
            ("b.pnm", [7, 8, 9].map(wide)),
        ] {
            let (file, all) = (folder.path().join(name), pictures.concat());
            fs::write(&file, &all).unwrap();
            let (recording, sequence) = Seekable::open(&file, &OpenOptions::default()).unwrap();
            assert_eq!((sequence.length, sequence.source.picture_names()), (Some(3), vec![]), "{name}");
            let levels = |frames: Frames| frames.map(|frame| frame.unwrap().gray.pixels[0]).collect::<Vec<_>>();
            assert_eq!((levels(sequence.frames), levels(recording.gray_from(3).unwrap())), (vec![7, 8, 9], vec![9]));
            assert_eq!(recording.color_from(2, 9).unwrap().next().unwrap().pixels[0], [8; 3]);
            assert!(message(decode_picture(&all)).starts_with("it holds several pictures"), "{name}");
            reads(name, None, &all[..all.len() - pictures[2].len() / 2], &[7, 8], "...(frame 3)...");
        }
        let preview = [small(7), jpeg()].concat();
        reads("c.jpg", None, &preview, &[decode_picture(&preview).unwrap().pixels[0]], "");
    }

    #[test]
    fn levels_of_16_bits_are_said_and_stretched() {
        let folder = folder("");
        let value = |at: u16| 7600 + 3 * (at % 256);
        for number in 1..=3_u16 {
            let pixels: Vec<u8> = (0..1024).flat_map(|at| value(at + number).to_be_bytes()).collect();
            let picture = [b"P5 32 32 65535\n", &pixels[..]].concat();
            fs::write(folder.path().join(format!("{number}.pgm")), picture).unwrap();
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
}

mod y4m_files {
    use super::*;

    #[test]
    fn luma_is_the_picture_and_damage_is_named() {
        let frames =
            b"FRAME\n\x01\x02\x03\x04\x05\x06\x80\x80\x80\x80FRAME Ip\n\x07\x08\x09\x0A\x0B\x0C\x80\x80\x80\x80";
        for colour in [" C420jpeg", " C420", ""] {
            let header = format!("YUV4MPEG2 W3 H2 F25:1{colour}\n");
            reads("a.y4m", None, &[header.as_bytes(), frames].concat(), &[1, 7], "");
        }
        let line_ends =
            "...: its header ends with CR LF: expected LF alone; it was changed as if it were text, and its pixels too";
        for (text, error) in [
            ("W3 H2 Cmono\n", "@/a.y4m holds no frame: expected at least one"),
            ("W3 H2 Cmono\nRUBBISH\n", "@/a.y4m, frame 1: it does not begin as a frame of YUV4MPEG2 does..."),
            ("W3 H2\r\n", line_ends),
            ("W3 H2 F25:1 C420p10\n", "@/a.y4m: its pixels have 10 bits (C420p10): expected 8"),
            ("W3 H2 F25:1 Cmono16\n", "@/a.y4m: its pixels have 16 bits (Cmono16): expected 8"),
            ("W3 H2 C411\n", "@/a.y4m: its colour space is C411: expected mono, 420, 422 or 444 with 8 bits"),
            ("W70000 H2\n", "@/a.y4m: its header says W70000: expected a size of 1 to 65535"),
            ("W3 H0\n", "@/a.y4m: its header says H0: expected a size of 1 to 65535"),
            ("W3\n", "@/a.y4m: its header names no size: expected H and a number"),
            ("W65535 H65535 Cmono\n", "...a frame of 65535x65535 has 4294836225 bytes: expected at most 268435456"),
            ("W3 H2 Fx\n", "@/a.y4m: its header is not understood: expected that of YUV4MPEG2, as ffmpeg writes it"),
        ] {
            reads("a.y4m", None, format!("YUV4MPEG2 {text}").as_bytes(), &[], error);
        }
        reads("a.y4m", None, b"RIFF\n", &[], "@/a.y4m: expected a line that begins with YUV4MPEG2");
        let whole = b"YUV4MPEG2 W3 H2 F25:1 Cmono\nFRAME\n123456FRAME\n123456";
        for (cut, found) in [(1, 11), (6, 6), (9, 3)] {
            let error = format!("@/a.y4m, frame 2: it is cut short: expected 12 bytes with its header, found {found}");
            reads("a.y4m", None, &whole[..whole.len() - cut], b"1", &error);
        }
    }

    /// In limited range (BT.601), pure red has Y 81, Cb 90 and Cr 240.
    #[test]
    fn planes_have_colors_in_both_ranges() {
        let color = |header: &str, planes: &[u8]| {
            let stream = [b"YUV4MPEG2 W2 H2 ".as_slice(), header.as_bytes(), b"\nFRAME\n", planes].concat();
            let mut frames = y4m::Frames::new(stream.as_slice(), "a.y4m".to_owned()).unwrap();
            frames.next_planes().unwrap().unwrap().color().pixels
        };
        let near = |found: [u8; 3], expected: [u8; 3]| found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 2);
        let limited = color("C420", &[81, 81, 16, 235, 90, 240]);
        assert!(near(limited[0], [255, 0, 0]) && near(limited[1], [255, 0, 0]), "{limited:?}");
        let full = color("C444 XCOLORRANGE=FULL", &[76, 0, 255, 29, 85, 128, 128, 255, 255, 128, 128, 107]);
        assert!(near(full[0], [254, 0, 0]) && near(full[1], [0; 3]) && near(full[2], [255; 3]), "{full:?}");
        assert!(near(full[3], [0, 0, 254]), "{full:?}");
        assert_eq!(color("Cmono", &[0, 7, 200, 255]), [[0; 3], [7; 3], [200; 3], [255; 3]]);
    }
}

/// Runs ffmpeg to write the file `out`; false if this ffmpeg cannot write such a file.
pub fn ffmpeg(arguments: &str, out: &Path) -> bool {
    let mut ffmpeg = std::process::Command::new("ffmpeg");
    missing::runs(ffmpeg.args("-nostdin -v error".split(' ')).args(arguments.split_whitespace()).arg(ffmpeg_input(out)))
}

mod videos {
    use super::*;
    use crate::missing::has_ffmpeg;

    /// Requires exact gray levels: a conversion to limited range would lose some.
    #[test]
    fn a_lossless_video_gives_the_same_pixels_up_to_its_damage() {
        if !has_ffmpeg("a_lossless_video_gives_the_same_pixels_up_to_its_damage") {
            return;
        }
        let folder = folder("");
        let (raw, video) = (folder.path().join("pixels"), folder.path().join("a: colon.mkv"));
        fs::write(&raw, synthetic::frames().take(30).flat_map(|frame| frame.pixels).collect::<Vec<_>>()).unwrap();
        let size = format!("{}x{}", synthetic::WIDTH, synthetic::HEIGHT);
        assert!(ffmpeg(&format!("-f rawvideo -pix_fmt gray -s {size} -i {} -c:v ffv1", raw.display()), &video));
        for path in [&video, folder.path()] {
            let (frames, error) = read(path, &OpenOptions::default());
            assert_eq!(error, "");
            assert!(frames.into_iter().eq(synthetic::frames().take(30)));
        }
        let mut half_read = open_plain(&video).unwrap();
        assert!(half_read.frames.next().unwrap().is_ok());
        drop(half_read); // would wait for ever if ffmpeg were not ended

        let bytes = fs::read(&video).unwrap();
        fs::write(&video, &bytes[..bytes.len() * 2 / 3]).unwrap();
        let (frames, error) = read(&video, &OpenOptions::default());
        assert!((5..30).contains(&frames.len()), "{}", frames.len());
        assert!(error.starts_with("@/a: colon.mkv is damaged, says ffmpeg: "), "{error}");
        let damage = open_plain(&video).unwrap().frames.find_map(Result::err).unwrap();
        let part = damage.downcast_ref::<Damaged>().and_then(Damaged::whole_part).unwrap();
        let part = open_plain(&video).unwrap().part(part.parse().unwrap(), 1, "--frames").frames;
        let part: Vec<_> = part.map(|frame| frame.unwrap().gray).collect();
        assert!(part.len() >= 5 && frames.starts_with(&part), "the frames before it can be read alone");
    }

    #[test]
    fn what_is_no_video_and_frames_of_another_size_are_errors() {
        if !has_ffmpeg("what_is_no_video_and_frames_of_another_size_are_errors") {
            return;
        }
        let said = "Invalid data found when processing input: expected a whole video, or else pictures, Y4M or a raw dump (--size)";
        reads("a.mp4", None, b"no video at all", &[], &format!("ffmpeg cannot decode @/a.mp4: ...{said}"));
        let folder = folder("");
        let parts = ["160x120", "96x64"].map(|size| {
            let part = folder.path().join(size);
            let options = format!("-f lavfi -i testsrc=size={size}:duration=1:rate=25 -c:v mpeg1video -f mpegts");
            assert!(ffmpeg(&options, &part));
            fs::read(part).unwrap()
        });
        let file = folder.path().join("a.ts");
        fs::write(&file, parts.concat()).unwrap();
        // The last frame in front of the change is decoded or not, as the version of ffmpeg has it.
        let error = read(&file, &OpenOptions::default()).1;
        assert!(error.ends_with("it is 96x64: expected 160x120, the size of the first"), "{error}");
    }
}
