//! What every source has in common, and each source read from files.

use super::*;
use png::{BitDepth, ColorType};
use std::fs::File;
use std::io::Write;
use tempfile::TempDir;

fn open_plain(path: &Path) -> Result<Sequence> {
    open(path, &OpenOptions::default())
}

fn open_sized(path: &Path, width: u16, height: u16) -> Result<Sequence> {
    open(path, &OpenOptions { size: Some((width, height)), ..OpenOptions::default() })
}

fn message<T>(result: Result<T>) -> String {
    format!("{:#}", result.err().expect("an error"))
}

/// The good frames, and the error after them.
fn read(sequence: Result<Sequence>) -> (Vec<GrayFrame>, Option<String>) {
    let mut frames = Vec::new();
    let mut error = None;
    for frame in sequence.unwrap().frames {
        assert!(error.is_none(), "nothing follows an error");
        match frame {
            Ok(frame) => frames.push(frame),
            Err(found) => error = Some(format!("{found:#}")),
        }
    }
    (frames, error)
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    File::create(&path).unwrap().write_all(bytes).unwrap();
    path
}

fn first_pixels(frames: &[GrayFrame]) -> Vec<u8> {
    frames.iter().map(|frame| frame.pixels[0]).collect()
}

fn save_png(path: &Path, (width, height): (u32, u32), color: ColorType, depth: BitDepth, samples: &[u8]) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
}

fn save_gray(path: &Path, width: u32, height: u32, value: u8) {
    let pixels = vec![value; (width * height) as usize];
    save_png(path, (width, height), ColorType::Grayscale, BitDepth::Eight, &pixels);
}

mod folders {
    use super::*;

    #[test]
    fn the_layouts_of_vot_and_got10k() {
        let vot = folder();
        fs::create_dir(vot.path().join("color")).unwrap();
        for number in 1..=3 {
            save_gray(&vot.path().join(format!("color/{number:08}.png")), 20, 16, number);
        }
        write(&vot, "groundtruth.txt", b"2,3,8,3,8,9,2,9\n3,4,5,6\nnan,nan,nan,nan\n");
        write(&vot, "sequence", b"channels.color=color/%08d.jpg\n");
        assert!(is_sequence(vot.path()));
        let sequence = open_plain(vot.path()).unwrap();
        let first = "2,3,6,6".parse().unwrap();
        assert_eq!((sequence.length, sequence.init), (Some(3), Some(first)));
        assert_eq!(sequence.truth, Some(vec![Some(first), Some("3,4,5,6".parse().unwrap()), None]));

        let got = folder();
        for number in 1..=2 {
            save_gray(&got.path().join(format!("{number:08}.png")), 20, 16, number);
        }
        write(&got, "groundtruth.txt", b"2.0000,3.0000,6.0000,6.0000\n2,3,6,6\n");
        write(&got, "absence.label", b"0\n1\n");
        assert_eq!(open_plain(got.path()).unwrap().truth, Some(vec![Some(first), None]));
    }

    #[test]
    fn pictures_come_in_natural_order() {
        let folder = folder();
        for (name, value) in [("img10.png", 10), ("img2.PNG", 2), ("img1.png", 1)] {
            save_gray(&folder.path().join(name), 4, 3, value);
        }
        write(&folder, ".img3.png", b"a thumbnail");
        write(&folder, "gt.txt", b"1,2,3,4\nNaN,NaN,NaN,NaN\n1,2,3,5\n");
        let sequence = open_plain(folder.path()).unwrap();
        assert_eq!(sequence.length, Some(3));
        assert_eq!(sequence.init, Some("1,2,2,2".parse().unwrap()));
        assert_eq!(sequence.truth.as_ref().unwrap().len(), 3);
        assert_eq!(sequence.name, folder.path().file_name().unwrap().to_str().unwrap());
        let (frames, error) = read(Ok(sequence));
        assert_eq!((first_pixels(&frames), error), (vec![1, 2, 10], None));
        assert!(is_sequence(folder.path()));
    }

    #[test]
    fn otb_layout() {
        let folder = folder();
        fs::create_dir(folder.path().join("img")).unwrap();
        save_gray(&folder.path().join("img/0001.jpg"), 8, 8, 7);
        write(&folder, "groundtruth_rect.txt", b"2\t3\t4\t5\n");
        let sequence = open_plain(folder.path()).unwrap();
        assert_eq!((sequence.length, sequence.init), (Some(1), Some("1,2,4,5".parse().unwrap())));
        assert_eq!(read(Ok(sequence)).0[0].pixels, [7; 64]);
        assert!(is_sequence(folder.path()));
    }

    #[test]
    fn the_box_that_is_asked_for_wins() {
        let folder = folder();
        save_gray(&folder.path().join("1.png"), 4, 3, 0);
        write(&folder, "gt.txt", b"1,2,3,4");
        write(&folder, "init.txt", b"0,0,2,2");
        assert_eq!(open_plain(folder.path()).unwrap().init, Some("0,0,2,2".parse().unwrap()));
        let asked: BoundingBox = "1,1,2,2".parse().unwrap();
        let options = OpenOptions { init: Some(asked), ..OpenOptions::default() };
        assert_eq!(open(folder.path(), &options).unwrap().init, Some(asked));
        assert_eq!(open(Path::new("synthetic"), &options).unwrap().init, Some(asked));
    }

    /// A video is a file as any other: what ffmpeg would decode does not matter here.
    #[test]
    fn a_file_starts_from_the_box_beside_it() {
        let folder = folder();
        let file = folder.path().join("x.y4m");
        fs::write(&file, b"YUV4MPEG2 W4 H3 Cmono\nFRAME\n\0\0\0\0\0\0\0\0\0\0\0\0").unwrap();
        write(&folder, "init.txt", b"0,0,2,2");
        let expected = Some("0,0,2,2".parse().unwrap());
        assert_eq!(open_plain(&file).unwrap().init, expected);
        assert_eq!(start_beside(&folder.path().join("x.mp4")).unwrap(), expected);
        write(&folder, "init.txt", b"0,0");
        assert!(start_beside(&file).unwrap_err().to_string().contains("init.txt"));
    }

    #[test]
    fn a_frame_of_another_size_is_named() {
        let folder = folder();
        save_gray(&folder.path().join("1.png"), 4, 3, 0);
        save_gray(&folder.path().join("2.png"), 4, 4, 0);
        save_gray(&folder.path().join("3.png"), 4, 3, 0);
        let (frames, error) = read(open_plain(folder.path()));
        let expected = format!("{}, frame 2: it is 4x4: expected 4x3, the size of the first", folder.path().display());
        assert_eq!((frames.len(), error), (1, Some(expected)));
    }

    #[test]
    fn pictures_beside_a_recording_are_not_guessed_about() {
        let folder = folder();
        save_gray(&folder.path().join("thumbnail.png"), 4, 3, 0);
        let video = write(&folder, "a.mp4", b"");
        let expected = format!(
            "{at} holds {video} and 1 pictures, {at}/thumbnail.png first: expected one or the other; name the file meant",
            at = folder.path().display(),
            video = video.display()
        );
        assert_eq!(message(open_plain(folder.path())), expected);
    }

    /// Files of a folder, and what is refused about them: masks beside pictures, cover pictures, kinds that are not read.
    #[test]
    fn pictures_of_two_kinds_are_not_guessed_about() {
        let several = "expected one kind in one folder; move the others away";
        let unread = "is a picture of a kind that is not read: convert it to PNG first";
        for (names, expected) in [
            (&["1.jpg", "1.png"][..], several),
            (&["1.jpeg", "2.JPG", "3.jfif"], ""),
            (&["1.pgm", "1.ppm"], several),
            (&["1.png", "img/1.png"], several),
            (&["1.bmp", "img/1.png"], several),
            (&["color/1.jpg", "img/1.jpg"], several),
            (&["color/1.jpg", "color/1.png"], several),
            (&["img/1.png", "depth/1.png"], ""),
            (&["1.png", "2.tif"], several),
            (&["1.HEIC", "2.HEIC"], unread),
            (&["img/1.webp", "gt.txt"], unread),
            (&["1.dng", "2.dng"], unread),
            (&["1.png", "1_mask.png"], "two pictures of one number: expected one a frame; move the others away"),
            (&["left1.png", "right1.png"], "two pictures of one number: expected one a frame; move the others away"),
            (&["a.mp4", "cover.webp"], "expected one or the other; name the file meant"),
        ] {
            let folder = folder();
            for name in names {
                let file = folder.path().join(name);
                fs::create_dir_all(file.parent().unwrap()).unwrap();
                match name.ends_with("txt") {
                    true => fs::write(&file, "1,2,3,4").unwrap(),
                    false => save_gray(&file, 4, 3, 1),
                }
            }
            let opened = open_plain(folder.path()).err().map(|error| format!("{error:#}")).unwrap_or_default();
            assert!(opened.ends_with(expected) && opened.is_empty() == expected.is_empty(), "{names:?}: {opened}");
            if expected == unread {
                assert!(
                    message(recordings(&[folder.path().to_owned()]).and_then(|found| open_plain(&found[0])))
                        .ends_with(unread)
                );
            }
        }
        let folder = folder();
        let file = write(&folder, "pages.tif", b"II*\0");
        assert!(message(open_plain(&file)).ends_with(unread), "ffmpeg would read the first page alone");
    }

    #[test]
    fn a_size_is_for_raw_dumps_only() {
        let folder = folder();
        save_gray(&folder.path().join("1.png"), 4, 3, 0);
        assert_eq!(
            message(open_sized(folder.path(), 4, 3)),
            format!("--size is for raw dumps: {} holds pictures", folder.path().display())
        );
        assert!(message(open_sized(Path::new("synthetic"), 4, 3)).starts_with("--size is for raw dumps: synthetic"));
        let other = tempfile::tempdir().unwrap();
        write(&other, "a.y4m", b"YUV4MPEG2 W3 H2 Cmono\nFRAME\n123456");
        assert!(message(open_sized(other.path(), 3, 2)).ends_with("a.y4m is none"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_is_no_gap() {
        let folder = folder();
        save_gray(&folder.path().join("1.png"), 4, 3, 1);
        save_gray(&folder.path().join("3.png"), 4, 3, 3);
        std::os::unix::fs::symlink("nowhere", folder.path().join("2.png")).unwrap();
        let at = folder.path().display();
        let expected = format!("{at}/2.png (frame 2) is a link to a file that is not there");
        assert_eq!(message(open_plain(folder.path())), expected);
        fs::remove_file(folder.path().join("2.png")).unwrap();
        assert_eq!(first_pixels(&read(open_plain(folder.path())).0), [1, 3]);
    }

    #[cfg(unix)]
    #[test]
    fn ground_truth_behind_a_link_to_nothing_is_missed() {
        for name in ["gt.txt", "groundtruth_rect.txt", "init.txt"] {
            let folder = folder();
            save_gray(&folder.path().join("1.png"), 4, 3, 1);
            std::os::unix::fs::symlink("nowhere", folder.path().join(name)).unwrap();
            assert!(message(open_plain(folder.path())).starts_with("cannot read "), "{name}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_start_is_said() {
        let start = |init: &str| {
            let init = Some(init.parse().unwrap());
            message(open(Path::new("synthetic"), &OpenOptions { init, ..OpenOptions::default() }).unwrap().start())
        };
        let large = "synthetic: the box to start from is too large or too far away (at most 65535 pixels on a side): 0,0,70000,5 (x,y,width,height)";
        assert_eq!(start("0,0,70000,5"), large);
        assert!(start("1e300,0,7,5").contains("too far away"));
        assert!(start("1,1,0.3,5").contains("the box to start from has no pixels: 1,1,0.3,5"));
    }

    #[test]
    fn what_cannot_be_opened_is_said_in_one_line() {
        let folder = folder();
        let at = folder.path().display();
        let expected = format!("{at} holds no recording: expected pictures (PNG, JPEG, PGM, PPM, PAM) or one video");
        assert_eq!(message(open_plain(folder.path())), expected);
        assert!(!is_sequence(folder.path()));

        let missing = message(open_plain(&folder.path().join("missing")));
        assert!(missing.starts_with(&format!(
            "cannot open {at}/missing: expected a folder, a file, or one of street, synthetic, periodic, border, noise"
        )));

        let text = write(&folder, "notes.txt", b"no video");
        assert_eq!(
            message(open_plain(&text)),
            format!("{at}/notes.txt is a text file: expected a recording (a video, Y4M or pictures)")
        );

        write(&folder, "a.y4m", b"");
        assert_eq!(message(open_plain(folder.path())), format!("{at}/a.y4m is empty: expected a recording"));

        write(&folder, "b.mp4", b"");
        assert!(message(open_plain(folder.path())).contains("holds several recordings, among them"));
    }

    #[test]
    fn the_built_in_recording_has_a_name() {
        let sequence = open_plain(Path::new("synthetic")).unwrap();
        assert_eq!((sequence.name.as_str(), sequence.length), ("synthetic", Some(synthetic::LENGTH)));
        assert!(is_sequence(Path::new("synthetic")));
    }
}

mod pictures {
    use super::*;

    fn gray_of(name: &str, bytes: &[u8]) -> u8 {
        let folder = folder();
        let (frames, error) = read(open_plain(&write(&folder, name, bytes)));
        assert_eq!(error, None, "{name}");
        frames[0].pixels[0]
    }

    /// The gray of a PNG of 2x2 pixels, each of these samples.
    fn gray_of_png(color: ColorType, depth: BitDepth, pixel: &[u8]) -> u8 {
        let folder = folder();
        let file = folder.path().join("1.png");
        save_png(&file, (2, 2), color, depth, &pixel.repeat(4));
        gray_of("1.png", &fs::read(&file).unwrap())
    }

    #[test]
    fn colour_becomes_gray_by_bt_601() {
        for (color, gray) in [([255, 0, 0], 76), ([0, 255, 0], 150), ([0, 0, 255], 29), ([255; 3], 255), ([7; 3], 7)] {
            let [r, g, b] = color;
            assert_eq!(gray_of_png(ColorType::Rgb, BitDepth::Eight, &color), gray);
            assert_eq!(gray_of_png(ColorType::Rgba, BitDepth::Eight, &[r, g, b, 9]), gray);
            assert_eq!(gray_of("1.ppm", &[b"P6 1 1 255\n", &color[..]].concat()), gray);
            assert_eq!(gray_of("1.ppm", format!("P3 1 1 255\n{r} {g} {b}\n").as_bytes()), gray);
            let header = b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
            assert_eq!(gray_of("1.pnm", &[&header[..], &color, &[9]].concat()), gray);
        }
    }

    #[test]
    fn of_16_bits_the_high_byte_is_taken() {
        assert_eq!(gray_of_png(ColorType::Grayscale, BitDepth::Sixteen, &[0x81, 0xFF]), 0x81);
        assert_eq!(gray_of_png(ColorType::GrayscaleAlpha, BitDepth::Sixteen, &[0x81, 0xFF, 0, 9]), 0x81);
        assert_eq!(gray_of_png(ColorType::Rgb, BitDepth::Sixteen, &[0xFF, 0xFF, 0, 0xFF, 0, 0]), 76);
        assert_eq!(gray_of("1.pgm", b"P5 1 1 65535\n\x81\xFF"), 0x81);
        assert_eq!(gray_of("1.pgm", b"P2 1 1 65535\n33279\n"), 0x81);
    }

    #[test]
    fn small_pngs_are_expanded() {
        for (color, depth, pixel, gray) in [
            (ColorType::Grayscale, BitDepth::Four, 0xF0, 255),
            (ColorType::Grayscale, BitDepth::One, 0x80, 255),
            (ColorType::Indexed, BitDepth::Eight, 1, 76),
        ] {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            encoder.set_palette(&[0, 0, 0, 255, 0, 0]);
            encoder.write_header().unwrap().write_image_data(&[pixel]).unwrap();
            assert_eq!(gray_of("1.png", &bytes), gray, "{color:?} {depth:?}");
        }
    }

    #[test]
    fn gray_passes_unchanged() {
        let folder = folder();
        let ramp: Vec<u8> = (0..=255).collect();
        save_png(&folder.path().join("1.png"), (16, 16), ColorType::Grayscale, BitDepth::Eight, &ramp);
        write(&folder, "1.pgm", &[b"P5\n# a comment\n16 16\n255\n", ramp.as_slice()].concat());
        for name in ["1.png", "1.pgm"] {
            let (frames, error) = read(open_plain(&folder.path().join(name)));
            assert_eq!((frames.len(), error), (1, None));
            assert_eq!(frames[0].pixels, ramp, "{name}");
        }
    }

    #[test]
    fn a_cut_pnm_is_an_error() {
        for bytes in [
            &b"P5 2 2 255\n123"[..],
            b"P5 2 2 65535\n1234567",
            b"P2 2 2 255\n1 2 3",
            b"P2 2 1 255 1 256",
            b"P5 2 2",
            b"P7\nWIDTH 2",
        ] {
            let folder = folder();
            let error = read(open_plain(&write(&folder, "1.pnm", bytes))).1.unwrap();
            assert!(error.contains("expected a PNG, JPEG, PGM, PPM or PAM picture: "), "{error}");
        }
    }

    #[test]
    fn what_is_no_picture_is_named() {
        let folder = folder();
        save_gray(&folder.path().join("1.png"), 2, 2, 0);
        let bad = write(&folder, "2.png", b"not a picture");
        let (frames, error) = read(open_plain(folder.path()));
        let expected =
            format!("cannot read {} (frame 2): expected a PNG, JPEG, PGM, PPM or PAM picture: ", bad.display());
        assert_eq!(frames.len(), 1);
        assert!(error.as_ref().unwrap().starts_with(&expected), "{error:?}");
    }

    #[test]
    fn a_cut_picture_is_an_error() {
        let folder = folder();
        let file = folder.path().join("1.png");
        save_gray(&file, 64, 64, 9);
        let bytes = fs::read(&file).unwrap();
        fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(read(open_plain(&file)).1.unwrap().starts_with("cannot read "));
        save_gray(&folder.path().join("0.png"), 64, 64, 7);
        save_gray(&folder.path().join("2.png"), 64, 64, 8);
        let (frames, error) = read(open_plain(folder.path()));
        assert_eq!(first_pixels(&frames), [7]);
        assert!(
            error.unwrap().ends_with("1.png (frame 2): expected a PNG, JPEG, PGM, PPM or PAM picture: it is cut short")
        );
    }

    /// A JPEG with detail everywhere, so that most bytes are pixels.
    fn jpeg() -> Vec<u8> {
        let pixels: Vec<u8> = (0..96 * 96_u32).map(|at| at.wrapping_mul(2_654_435_761).to_be_bytes()[0]).collect();
        let mut bytes = Vec::new();
        jpeg_encoder::Encoder::new(&mut bytes, 75).encode(&pixels, 96, 96, jpeg_encoder::ColorType::Luma).unwrap();
        bytes
    }

    #[cfg(unix)]
    #[test]
    fn a_picture_may_come_through_a_pipe() {
        let folder = folder();
        let pipe = folder.path().join("1.pgm");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = pipe.clone();
        let written = std::thread::spawn(move || fs::write(writer, b"P5 2 1 255\n78"));
        assert_eq!(first_pixels(&read(open_plain(&pipe)).0), [b'7']);
        written.join().unwrap().unwrap();
    }

    #[test]
    fn a_jpeg_that_is_cut_anywhere_is_an_error() {
        let (folder, whole) = (folder(), jpeg());
        let file = write(&folder, "1.jpg", &whole);
        let (expected, error) = read(open_plain(&file));
        assert_eq!((expected.len(), error), (1, None));
        // What follows the end is no damage.
        write(&folder, "1.jpg", &[&whole[..], b"a trailer"].concat());
        assert_eq!(read(open_plain(&file)), (expected.clone(), None));
        for length in [700, whole.len() / 2, whole.len() - 40, whole.len() - 2, whole.len() - 1] {
            write(&folder, "1.jpg", &whole[..length]);
            let (frames, error) = read(open_plain(&file));
            assert_eq!(frames.len(), 0, "{length}");
            assert!(error.unwrap().starts_with("cannot read "), "{length}");
        }
    }

    /// With segments in front of the picture, behind the first two bytes.
    fn jpeg_with(segments: &[(u8, &[u8])]) -> Vec<u8> {
        let whole = jpeg();
        let segment = |(marker, data): &(u8, &[u8])| {
            [&[0xFF, *marker][..], &u16::try_from(data.len() + 2).unwrap().to_be_bytes(), data].concat()
        };
        [&whole[..2], &segments.iter().map(segment).collect::<Vec<_>>().concat(), &whole[2..]].concat()
    }

    /// An upright picture of 3x2 pixels with six values, as it is stored for each orientation.
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
            for is_little_endian in [true, false] {
                let mut bytes = Vec::new();
                let mut info = png::Info::with_size(width, height);
                info.exif_metadata = Some(exif::tests::exif(is_little_endian, orientation).into());
                let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
                encoder.write_header().unwrap().write_image_data(&stored).unwrap();
                let gray = decode_picture(&bytes).unwrap();
                assert_eq!((gray.width, gray.height, &gray.pixels[..]), (3, 2, &upright[..]), "{orientation}");
                assert_eq!(decode_colors(&bytes).unwrap().pixels, upright.map(|value| [value; 3]));
            }
        }
        let folder = folder();
        let (exif, plain) = (exif::tests::exif(false, 6), decode_picture(&jpeg()).unwrap());
        let file = write(&folder, "1.jpg", &jpeg_with(&[(0xE1, &[exif::HEAD, &exif].concat())]));
        let turned = read_picture(&file).unwrap();
        assert!((0..96).all(|at| turned.level(95 - at, 7) == plain.level(7, at)), "from the left to the top");
        assert_eq!(read(open_plain(&file)).0, [turned]);
    }

    #[test]
    fn bytes_behind_the_end_of_a_jpeg_do_not_matter() {
        let (whole, expected) = (jpeg(), decode_picture(&jpeg()).unwrap());
        let views = [&jpeg_with(&[(0xE2, b"MPF\0II*\0")])[..], &whole, &whole].concat();
        assert_eq!(decode_picture(&views).unwrap(), expected);
        for behind in [&b"\xFF\xDA\xFF\xD9\xFF\xDA film"[..], b"\0\0\0\x18ftypmp42\xFF\xD8\xFF\xDA"] {
            assert_eq!(decode_picture(&[&whole, behind].concat()).unwrap(), expected);
            let damage = message(decode_picture(&[&whole[..whole.len() - 40], behind].concat()));
            assert!(damage.contains("it is damaged") || damage.contains("its end is missing"), "{damage}");
        }
    }

    /// As webcams and frames cut out of AVI have them: without any, or without some.
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

    /// "Damaged" is said of damage only.
    #[test]
    fn what_is_not_read_is_named() {
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
        for (bytes, expected) in [
            (jpeg_as(0xC9, 8, 96), "it is an arithmetic-coded JPEG, which is not read: convert it to PNG first"),
            (jpeg_as(0xCA, 8, 96), "it is an arithmetic-coded JPEG"),
            (jpeg_as(0xC3, 8, 96), "it is a lossless JPEG"),
            (jpeg_as(0xC1, 12, 96), "it is a JPEG of more than 8 bits"),
            (jpeg_as(0xC5, 8, 96), "it is a hierarchical JPEG"),
            (jpeg_as(0xF7, 8, 96), "it is a JPEG-LS picture"),
            (jpeg_as(0xC0, 8, 0), "it is a JPEG whose height follows its pixels"),
            (b"RIFF\x10\0\0\0WEBPVP8 ".to_vec(), "it is a WebP picture, which is not read"),
            (b"\0\0\0\x18ftypheic\0\0\0\0".to_vec(), "it is a HEIC picture"),
            (b"\0\0\0\x20ftypavif\0\0\0\0".to_vec(), "it is an AVIF picture"),
            (b"PF\n2 1\n-1.0\n".to_vec(), "it is a picture of floating-point numbers (PFM)"),
            (b"II*\0\x08\0\0\0".to_vec(), "it is a TIFF picture"),
            (b"BM\0\0".to_vec(), "it is a BMP picture"),
            (b"P4 8 1 \xAA".to_vec(), "it is a bitmap of one bit (PBM)"),
            (png_with(b"acTL", &[0, 0, 0, 9, 0, 0, 0, 0]), "it is an animated PNG of 9 pictures"),
            (png_with(b"CgBI", &[0; 4]), "it is a PNG in Apple's own form"),
        ] {
            let error = decode_picture(&bytes).unwrap_err();
            assert!(error.to_string().starts_with(expected) && !error.is::<Damaged>(), "{error}");
        }
        assert!(decode_picture(&jpeg_as(0xC1, 8, 96)).is_ok(), "extended, but as baseline");
        assert!(decode_picture(&jpeg()[..700]).unwrap_err().is::<Damaged>());
    }

    #[test]
    fn several_pictures_in_one_file_are_a_recording() {
        let folder = folder();
        let png = |value: u8| {
            save_gray(&folder.path().join("kept"), 2, 1, value);
            fs::read(folder.path().join("kept")).unwrap()
        };
        let jpeg = |value: u8| {
            let mut bytes = Vec::new();
            let encoder = jpeg_encoder::Encoder::new(&mut bytes, 100);
            encoder.encode(&[value; 64], 8, 8, jpeg_encoder::ColorType::Luma).unwrap();
            bytes
        };
        let pnm = |header: &str, value: u8| [header.as_bytes(), &[value; 2]].concat();
        let text = |value: u8| format!("P2 2 1 255 {value} {value}\n").into_bytes();
        let wide = |value: u8| [b"P5 2 1 65535\n", &[value, 99, value, 99][..]].concat();
        let each: [(&str, Vec<Vec<u8>>); 6] = [
            ("a.png", [7, 8, 9].map(png).to_vec()),
            ("a.jpg", [7, 8, 9].map(jpeg).to_vec()),
            ("a.pgm", [7, 8, 9].map(|value| pnm("P5 2 1 255\n", value)).to_vec()),
            ("b.pgm", [7, 8, 9].map(|value| [pnm("P5\n# two\n2 1\n255\n", value), b"\n".to_vec()].concat()).to_vec()),
            ("a.pnm", [7, 8, 9].map(text).to_vec()),
            ("b.pnm", [7, 8, 9].map(wide).to_vec()),
        ];
        for (name, pictures) in each {
            let file = write(&folder, name, &pictures.concat());
            let sequence = open_plain(&file).unwrap();
            assert_eq!((sequence.length, sequence.colors.picture_names()), (Some(3), vec![]), "{name}");
            assert_eq!(first_pixels(&read(Ok(sequence)).0), [7, 8, 9], "{name}");
            let (recording, _) = Seekable::open(&file, &OpenOptions::default()).unwrap();
            assert_eq!(
                first_pixels(&recording.gray_from(3).unwrap().map(|frame| frame.unwrap().0).collect::<Vec<_>>()),
                [9]
            );
            assert_eq!(recording.color_from(2, 9).unwrap().next().unwrap().pixels[0], [8; 3]);
            assert!(message(decode_picture(&pictures.concat())).starts_with("it holds several pictures"), "{name}");
            let cut = pictures.concat().len() - pictures[2].len() / 2;
            let cut = write(&folder, name, &pictures.concat()[..cut]);
            assert!(read(open_plain(&cut)).1.is_some_and(|error| error.contains("(frame 3)")), "{name}");
        }
        let preview = [jpeg(7), pictures::jpeg()].concat();
        assert_eq!(read(open_plain(&write(&folder, "c.jpg", &preview))).0.len(), 1, "of another size");
    }

    #[test]
    fn levels_of_16_bits_are_said_and_stretched() {
        let folder = folder();
        let value = |at: u16| 7600 + 3 * (at % 256);
        for number in 1..=3_u16 {
            let pixels: Vec<u8> = (0..1024).flat_map(|at| value(at + number).to_be_bytes()).collect();
            let file = folder.path().join(format!("{number}.png"));
            save_png(&file, (32, 32), ColorType::Grayscale, BitDepth::Sixteen, &pixels);
        }
        let opened = |levels: Option<&str>| {
            let levels = levels.map(|levels| levels.parse().unwrap());
            open(folder.path(), &OpenOptions { levels, ..OpenOptions::default() })
        };
        let plain = opened(None).unwrap();
        assert_eq!(
            plain.notes,
            [
                "of its 16-bit values only 7600 to 8365 occur: trackers see levels 29 to 32 of 256; --levels 7409..8556 stretches them"
            ]
        );
        let stretched = opened(Some("7600..8365")).unwrap();
        assert_eq!(stretched.notes, Vec::<String>::new());
        let (frames, colors) = (stretched.frames, stretched.colors.open(1, Duration::ZERO));
        for ((number, frame), mut colors) in (1..).zip(frames).zip([Some(colors), None, None]) {
            let frame = frame.unwrap();
            assert!((0..1024_u16).zip(&frame.pixels).all(|(at, &pixel)| u16::from(pixel) == (at + number) % 256));
            colors.iter_mut().for_each(|colors| assert_eq!(colors.next(&frame).0.pixels[5], [6; 3]));
        }
        assert_eq!(opened(Some("0..100")).unwrap().notes.len(), 1, "all is white");
        let eight = write(&folder, "8.pgm", b"P5 1 1 255\n9");
        let options = OpenOptions { levels: Some("0..9".parse().unwrap()), ..OpenOptions::default() };
        assert!(
            read(open(&eight, &options)).1.unwrap().ends_with("--levels is for 16-bit pictures: this one has 8 bits")
        );
        let error = message(open(Path::new("synthetic"), &options));
        assert_eq!(error, "--levels is for 16-bit pictures: synthetic is none");
        let wide = write(&folder, "16.pgm", b"P5 3 1 65535\n\0\0\0\x05\0\x09");
        assert_eq!(read(open(&wide, &options)).0[0].pixels, [0, 142, 255]);
    }

    #[test]
    fn the_colours_of_a_jpeg_become_gray() {
        let folder = folder();
        for (color, gray) in [([255, 0, 0], 76_u8), ([0, 255, 0], 150), ([0, 0, 255], 29)] {
            let mut bytes = Vec::new();
            let encoder = jpeg_encoder::Encoder::new(&mut bytes, 95);
            encoder.encode(&color.repeat(64), 8, 8, jpeg_encoder::ColorType::Rgb).unwrap();
            let (frames, error) = read(open_plain(&write(&folder, "1.jpg", &bytes)));
            assert_eq!(error, None);
            assert!(frames[0].pixels.iter().all(|pixel| pixel.abs_diff(gray) <= 2), "{:?}", frames[0].pixels);
        }
    }

    #[test]
    fn a_picture_without_pixels_is_refused() {
        for header in ["P5\n0 0\n255\n", "P5\n0 5\n255\n", "P5\n5 0\n255\n", "P6\n0 0\n255\n", "P6 0 5 255\n"] {
            let folder = folder();
            let file = write(&folder, "1.pgm", header.as_bytes());
            let (frames, error) = read(open_plain(&file));
            assert_eq!(frames.len(), 0);
            assert!(error.unwrap().contains("1.pgm"), "{header:?}");
        }
    }

    #[test]
    fn a_pgm_with_another_white_is_refused() {
        let folder = folder();
        let file = write(&folder, "1.pgm", b"P5 2 1 1023\n\x03\xFF\x00\x00");
        let error = read(open_plain(&file)).1.unwrap();
        assert!(error.ends_with("its largest value is 1023: expected 255 or 65535"), "{error}");
    }
}

mod raw_dumps {
    use super::*;

    #[test]
    fn frames_follow_each_other() {
        let folder = folder();
        let file = write(&folder, "dump.raw", &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
        let sequence = open_sized(&file, 3, 2).unwrap();
        assert_eq!((sequence.name.as_str(), sequence.length), ("dump", Some(2)));
        assert_eq!(first_pixels(&read(Ok(sequence)).0), [1, 7]);
        assert_eq!(first_pixels(&read(open_sized(folder.path(), 3, 2)).0), [1, 7]);
    }

    #[test]
    fn any_file_of_a_given_size_is_a_dump() {
        let folder = folder();
        let file = write(&folder, "dump.dat", &[5; 12]);
        assert_eq!(read(open_sized(&file, 3, 2)).0.len(), 2);
    }

    #[test]
    fn the_size_is_needed() {
        let folder = folder();
        let file = write(&folder, "dump.y8", &[5; 12]);
        assert!(message(open_plain(&file)).ends_with("the size of its frames is needed (--size WIDTHxHEIGHT)"));
        assert_eq!(message(open_sized(&file, 0, 2)), "--size 0x2: expected at least 1x1");
    }

    #[test]
    fn a_cut_dump_gives_its_whole_frames_first() {
        let folder = folder();
        let file = write(&folder, "dump.gray", &[5; 16]);
        let (frames, error) = read(open_sized(&file, 3, 2));
        let expected = format!(
            "{}, frame 3: it is cut short, or its frames are not 3x2: expected 6 bytes, found 4",
            file.display()
        );
        assert_eq!((frames.len(), error), (2, Some(expected)));
        assert_eq!(read(open_sized(&file, 16384, 16384)).0.len(), 0);
        let expected = "--size 16384x16385: a frame has 268451840 bytes: expected at most 268435456";
        assert_eq!(message(open_sized(&file, 16384, 16385)), expected);
    }
}

mod y4m_files {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_luma_plane_is_the_picture() {
        let folder = folder();
        let frames =
            b"FRAME\n\x01\x02\x03\x04\x05\x06\x80\x80\x80\x80FRAME Ip\n\x07\x08\x09\x0A\x0B\x0C\x80\x80\x80\x80";
        for colour in [" C420jpeg", " C420", ""] {
            let file =
                write(&folder, "a.y4m", &[format!("YUV4MPEG2 W3 H2 F25:1{colour}\n").as_bytes(), frames].concat());
            let (frames, error) = read(open_plain(&file));
            assert_eq!((frames.len(), error), (2, None));
            assert_eq!(frames[1].pixels, [7, 8, 9, 10, 11, 12]);
        }
    }

    #[test]
    fn a_cut_file_gives_its_whole_frames_first() {
        let folder = folder();
        let whole = b"YUV4MPEG2 W3 H2 F25:1 Cmono\nFRAME\n123456FRAME\n123456";
        for (cut, found) in [(1, 11), (6, 6), (9, 3)] {
            let file = write(&folder, "a.y4m", &whole[..whole.len() - cut]);
            let (frames, error) = read(open_plain(&file));
            let at = file.display();
            let expected = format!("{at}, frame 2: it is cut short: expected 12 bytes with its header, found {found}");
            assert_eq!((frames.len(), error), (1, Some(expected)));
            // What lies behind the part that is read is no matter.
            let part = open_plain(&file).unwrap().part("..1".parse().unwrap(), "--frames");
            assert_eq!(read(Ok(part)), (frames, None));
        }
    }

    #[test]
    fn headers_that_are_refused() {
        let folder = folder();
        let refused = [
            (
                "YUV4MPEG2 W3 H2\r\n",
                "its header ends with CR LF: expected LF alone; it was changed as if it were text, and its pixels too",
            ),
            ("RIFF\n", "expected a line that begins with YUV4MPEG2"),
            ("YUV4MPEG2 W3 H2 F25:1 C420p10\n", "its pixels have 10 bits (C420p10): expected 8"),
            ("YUV4MPEG2 W3 H2 F25:1 Cmono16\n", "its pixels have 16 bits (Cmono16): expected 8"),
            ("YUV4MPEG2 W3 H2 C411\n", "its colour space is C411: expected mono, 420, 422 or 444 with 8 bits"),
            ("YUV4MPEG2 W70000 H2\n", "its header says W70000: expected a size of 1 to 65535"),
            ("YUV4MPEG2 W3 H0\n", "its header says H0: expected a size of 1 to 65535"),
            ("YUV4MPEG2 W3\n", "its header names no size: expected H and a number"),
            (
                "YUV4MPEG2 W65535 H65535 Cmono\n",
                "a frame of 65535x65535 has 4294836225 bytes: expected at most 268435456",
            ),
            ("YUV4MPEG2 W3 H2 Fx\n", "its header is not understood: expected that of YUV4MPEG2, as ffmpeg writes it"),
        ];
        for (header, expected) in refused {
            let file = write(&folder, "a.y4m", header.as_bytes());
            assert_eq!(message(open_plain(&file)), format!("{}: {expected}", file.display()));
        }
    }

    #[test]
    fn a_file_without_frames_and_one_with_rubbish() {
        let folder = folder();
        let file = write(&folder, "a.y4m", b"YUV4MPEG2 W3 H2 Cmono\n");
        assert_eq!(
            read(open_plain(&file)).1,
            Some(format!("{} holds no frame: expected at least one", file.display()))
        );
        let file = write(&folder, "a.y4m", b"YUV4MPEG2 W3 H2 Cmono\nRUBBISH\n");
        assert!(read(open_plain(&file)).1.unwrap().contains("frame 1: it does not begin as a frame of YUV4MPEG2 does"));
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(header in "(W|H|C|F|A|[0-9]{1,20}|mono|420p10| |:){0,12}", frames: Vec<u8>) {
            let bytes = [b"YUV4MPEG2 ", header.as_bytes(), b"\nFRAME\n", &frames].concat();
            if let Ok(stream) = y4m::Frames::new(bytes.as_slice(), "arbitrary".to_owned()) {
                let _ = stream.take(3).count();
            }
        }
    }
}

/// Pure red has luma 81 and differences of color 90 and 240 in limited range (BT.601).
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

mod videos {
    use super::*;
    use crate::missing::has_ffmpeg;
    use std::process::Command;

    /// A lossless video of the first frames of the built-in recording. Gray in limited range would lose levels.
    fn encode(folder: &TempDir, frames: usize) -> PathBuf {
        let raw: Vec<u8> = synthetic::frames().take(frames).flat_map(|frame| frame.pixels).collect();
        let (raw, video) = (write(folder, "pixels", &raw), folder.path().join("a: colon.mkv"));
        let size = format!("{}x{}", synthetic::WIDTH, synthetic::HEIGHT);
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-nostdin", "-v", "error", "-f", "rawvideo", "-pix_fmt", "gray", "-s", &size, "-i"]).arg(raw);
        let status = ffmpeg.args(["-c:v", "ffv1"]).arg(format!("file:{}", video.display())).status().unwrap();
        assert!(status.success());
        video
    }

    #[test]
    fn a_lossless_video_gives_the_same_pixels() {
        if !has_ffmpeg("a_lossless_video_gives_the_same_pixels") {
            return;
        }
        let folder = folder();
        let video = encode(&folder, 5);
        let (frames, error) = read(open_plain(&video));
        assert_eq!(error, None);
        assert!(frames.into_iter().eq(synthetic::frames().take(5)));
        assert_eq!(read(open_plain(folder.path())).0.len(), 5);
    }

    #[test]
    fn a_damaged_video_is_an_error_after_its_frames() {
        if !has_ffmpeg("a_damaged_video_is_an_error_after_its_frames") {
            return;
        }
        let folder = folder();
        let video = encode(&folder, 20);
        let bytes = fs::read(&video).unwrap();
        fs::write(&video, &bytes[..bytes.len() * 2 / 3]).unwrap();
        let (frames, error) = read(open_plain(&video));
        assert!((5..20).contains(&frames.len()), "{}", frames.len());
        assert!(error.unwrap().starts_with(&format!("{} is damaged, says ffmpeg: ", video.display())));
        let damage = open_plain(&video).unwrap().frames.find_map(Result::err).unwrap();
        let part = damage.downcast_ref::<Damaged>().and_then(Damaged::whole_part).unwrap();
        assert_eq!(part, format!("..{}", frames.len()));
        let part = open_plain(&video).unwrap().part(part.parse().unwrap(), "--frames");
        assert!(read(Ok(part)) == (frames, None), "the frames before it can be read alone");
    }

    #[test]
    fn what_ffmpeg_cannot_read_is_an_error_at_once() {
        if !has_ffmpeg("what_ffmpeg_cannot_read_is_an_error_at_once") {
            return;
        }
        let folder = folder();
        let file = write(&folder, "a.mp4", b"no video at all");
        let error = message(open_plain(&file));
        assert!(error.starts_with(&format!("ffmpeg cannot decode {}: ", file.display())), "{error}");
        let said = "Invalid data found when processing input: expected a whole video, or else pictures, Y4M";
        assert!(error.contains(said) && !error.contains('\n'), "{error}");
    }

    #[test]
    fn frames_of_another_size_are_not_scaled() {
        if !has_ffmpeg("frames_of_another_size_are_not_scaled") {
            return;
        }
        let folder = folder();
        let parts = ["160x120", "96x64"].map(|size| {
            let part = folder.path().join(size).with_extension("part");
            let source = format!("testsrc=size={size}:duration=1:rate=25");
            let mut ffmpeg = Command::new("ffmpeg");
            ffmpeg.args([
                "-nostdin",
                "-v",
                "error",
                "-f",
                "lavfi",
                "-i",
                &source,
                "-c:v",
                "mpeg1video",
                "-f",
                "mpegts",
            ]);
            assert!(ffmpeg.arg(&part).status().unwrap().success());
            fs::read(part).unwrap()
        });
        let file = write(&folder, "a.ts", &parts.concat());
        let error = read(open_plain(&file)).1.unwrap();
        let expected = "the size of its frames or the format of their pixels changes on the way: expected one";
        assert_eq!(error, format!("{}: {expected}", file.display()));
    }

    #[test]
    fn a_video_may_be_dropped_half_read() {
        if !has_ffmpeg("a_video_may_be_dropped_half_read") {
            return;
        }
        let folder = folder();
        let mut sequence = open_plain(&encode(&folder, 60)).unwrap();
        assert!(sequence.frames.next().unwrap().is_ok());
        drop(sequence); // would wait for ever if ffmpeg were not ended
    }
}
