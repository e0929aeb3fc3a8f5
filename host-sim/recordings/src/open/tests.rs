use super::*;
use crate::built_in::synthetic;
use crate::find::recordings;
use crate::fixtures::{fits, folder, levels, message, open_plain, read, reads};

#[test]
fn folders_of_images_in_every_layout() {
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
    let both = "@ holds @/a.mp4 and 1 picture, @/1.png first: expected one or the other; name the file meant";
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
