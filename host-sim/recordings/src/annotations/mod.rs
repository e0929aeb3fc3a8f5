//! Boxes of named targets in files that people and other programs write: CSV with column names, CVAT XML, and JSON of
//! Label Studio.
//!
//! Each format has a reader, which returns tracks: the entries of a target, in the order of the file. `Track::target`
//! gives all formats one meaning: entries by frame, at most one in a frame, boxes with pixels.

pub mod boxes;
mod csv;
mod cvat;
mod label_studio;
pub(crate) mod start;
mod track;
mod xml;

use anyhow::{Result, bail, ensure};
use smr_files::input::{self, Kind};
use start::Target;
use std::path::Path;

/// Files of boxes: 64 MiB are enough for a million lines of 67 bytes.
const KIND: Kind = Kind { expected: "CSV, CVAT XML or JSON of Label Studio", most: 64 };

/// The recording whose boxes are in a file.
#[derive(Clone, Copy)]
pub struct Labelled<'a> {
    /// Name without extension, by which it is found in a file about several recordings.
    pub name: &'a str,
    pub size: (u16, u16),
    /// Count of its frames, if known.
    pub frames: Option<usize>,
}

/// Reads a file of boxes. Errors: It is of no known kind, an entry is wrong, or there is no box to lock on.
pub fn read(file: &Path, of: &Labelled<'_>) -> Result<Vec<Target>> {
    parse(&input::bytes(file, &KIND)?, of)
}

/// Parses the content of a file of boxes. Errors: as [`read`].
pub fn parse(bytes: &[u8], of: &Labelled<'_>) -> Result<Vec<Target>> {
    let text = input::decoded(bytes, &KIND)?;
    ensure!(!text.trim().is_empty(), "it is empty: expected {}", KIND.expected);
    let tracks = match text.trim_start().as_bytes().first() {
        Some(b'<') => cvat::tracks(&text)?,
        Some(b'[') => label_studio::tracks(&text, of)?,
        Some(b'{') => bail!("it is an object of JSON: expected a list in [ ], as Label Studio exports it"),
        _ => csv::tracks(&text)?,
    };
    let targets = tracks.into_iter().map(|track| track.target(&text)).collect::<Result<Vec<_>>>()?;
    let targets: Vec<_> = targets.into_iter().filter(|target| !target.starts.is_empty()).collect();
    ensure!(
        !targets.is_empty(),
        "there is no box to lock on: expected one without a confidence, a shape of CVAT without source=\"auto\", or a videorectangle"
    );
    Ok(targets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounding_box::BoundingBox;

    const RECORDING: Labelled<'_> = Labelled { name: "clip 1", size: (200, 100), frames: None };

    /// Returns each target as text: its name, then its locks with their frames.
    fn read(text: &str) -> Result<Vec<String>, String> {
        let lock = |(frame, bbox): (usize, Option<BoundingBox>)| {
            format!("{frame}:{}", bbox.map_or("gone".to_owned(), |bbox| bbox.to_string()))
        };
        let target = |Target { name, starts, .. }: Target| {
            let locks: Vec<_> = starts.into_iter().map(lock).collect();
            format!("{} {}", name.unwrap_or_default(), locks.join(" "))
        };
        parse(text.as_bytes(), &RECORDING)
            .map(|all| all.into_iter().map(target).collect())
            .map_err(|error| format!("{error:#}"))
    }

    fn reads(text: &str, expected: &[&str]) {
        assert_eq!(read(text).map(|all| all.join("; ")), Ok(expected.join("; ")), "{text}");
    }

    fn refuses(text: &str, said: &str) {
        let error = read(text).unwrap_err();
        assert!(error.contains(said), "{text}\n{error}\n{said}");
    }

    #[test]
    fn given_boxes_of_csv_are_locks_and_answers_are_none() {
        let csv = "target,frame,time,x,y,width,height,state,confidence\ncar,1,,1.4,2,3,4,tracking,\ncar,2,,9,9,3,4,tracking,0.9\nman,2,,5,6,7,8,tracking,\n\
                   car,3,,,,,,lost,0\ncar,4,,9,9,3,4,uncertain,0.4\ncar,7,,-1,2,3,4,tracking,\ncar,8,,,,,,lost,\n";
        reads(csv, &["car 1:1.4,2,3,4 5:gone 7:-1,2,3,4", "man 2:5,6,7,8 3:gone"]);
        // Without states, the rows are key frames.
        reads("frame,x,y,width,height\n50,5,6,7,8\n1,1,2,3,4", &[" 1:1,2,3,4 50:5,6,7,8"]);
    }

    #[test]
    fn csv_is_read_as_other_programs_write_it() {
        let two = [" 1:60,80,40.5,40 7:1,2,3,4"];
        for csv in [
            "frame,x,y,width,height\n1,60,80,40.5,40\n7,1,2,3,4\n",
            "\u{feff}frame,x,y,width,height\r\n1,60,80,40.5,40\r\n\r\n7,1,2,3,4",
            "frame,x,y,width,height\r1,60,80,40.5,40\r7,1,2,3,4\r",
            "\"\",\"frame\",\"x\",\"y\",\"width\",\"height\"\n\"1\",1,60,80,40.5,40\n\"2\",7,1,2,3,4\n",
            "Frame;X;Y;Width;HEIGHT\n1;60;80;40.5;40\n7;1;2;3;4\n",
            "sep=;\nframe;x;y;width;height\n1;60;80;40.5;40\n7;1;2;3;4\n",
            "\"sep=|\"\nframe|x|y|width|height\n1|60|80|40.5|40\n7|1|2|3|4\n",
            "frame\tx\ty\twidth\theight\n1\t60\t80\t40.5\t40\n7\t1\t2\t3\t4\n",
            " frame , \"x\" ,y,\t width,height \n 1, 60 , \"80\" ,40.5,40\n7 ,1,2,3,4\n ,,,,\n,,,,\n  \n",
            "height,note,width,y,x,note,frame\n40,\"a, \"\"b\"\"\nframe,1\",40.5,80,60,,1\n4,;,3,2,1,,7\n",
            "index,frame,x,y,width,height\n0,1.0,60.0,80.0,40.5,40.0\n1,7.0,1.0,2.0,3.0,4.0\n",
            "7,frame,x,y,width,height\n,001,6e1,+80,40.50,40\n,7,1,2,3,4\n,8,,,,\n",
        ] {
            reads(csv, &two);
        }
        reads("target;frame;x;y;width;height\n\"Größe 2\";1;1;2;3;4", &["Größe 2 1:1,2,3,4"]);
        let utf16: Vec<u8> =
            "\u{feff}frame\tx\ty\twidth\theight\n1\t1\t2\t3\t4".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(parse(&utf16, &RECORDING).unwrap().len(), 1);
    }

    #[test]
    fn a_fault_of_csv_has_its_line_and_column() {
        let expected = "expected CSV with the columns frame, x, y, width and height (and target), CVAT XML, or JSON of Label Studio, found the columns";
        for (head, said) in [
            ("a,b\n1,2", &*format!("line 1: there is no column frame: {expected} \"a, b\"")),
            ("\n\nFrame;x1;y1;x2;y2\n", &format!("line 3: there is no column x: {expected} \"Frame, x1, y1, x2, y2\"")),
            ("sep=;\nframe,x\n", "line 2: there is no column frame"),
            ("1,60,80,40,40\n", "found the columns \"1, 60, 80, 40, 40\""),
            ("{\"info\": 1}", "it is an object of JSON: expected a list in [ ], as Label Studio exports it"),
            ("frame,x,X,y,width,height\n", "line 1: there are two columns x: expected one"),
            ("frame,x,y,width,height,state,State\n", "line 1: there are two columns state: expected one"),
            ("\"frame,x,y,width,height\n1,1,2,3,4\n", "line 1: a quote is missing"),
            ("", "it is empty: expected CSV, CVAT XML or JSON"),
            ("\u{feff} \n", "it is empty"),
            (",,,\n", "it has no line with the names of columns"),
        ] {
            refuses(head, said);
        }
        let number = "expected a number";
        for (rows, said) in [
            ("1,2,3,4", "line 2: expected 5 fields as in the line of names, found 4"),
            ("1,2,3,4,5\n\n\n2,2,3,4,5,6", "line 5: expected 5 fields"),
            ("0,1,2,3,4", "line 2: column frame: expected the number of a frame, 1 or more, found \"0\""),
            ("-1,1,2,3,4", "found \"-1\""),
            ("1.5,1,2,3,4", "found \"1.5\""),
            ("NaN,1,2,3,4", "found \"NaN\""),
            ("4294967295,1,2,3,4", "found \"4294967295\""),
            ("99999999999999999999,1,2,3,4", "found \"99999999999999999999\""),
            (",1,2,3,4", "column frame: expected the number of a frame, 1 or more, found \"\""),
            ("1,1,2,3,4\n2,1,2,3,4\n1,1,2,3,4", "line 4: the target is in frame 1 twice, also in line 2: expected one"),
            ("1,a,2,3,4", &format!("line 2: column x: {number}, found \"a\"")),
            ("1,1,NaN,3,4", &format!("line 2: column y: {number}, found \"NaN\"")),
            ("1,inf,2,3,4", &format!("line 2: column x: {number}, found \"inf\"")),
            ("1,1e999,2,3,4", &format!("line 2: column x: {number}, found \"1e999\"")),
            ("1,NA,NA,NA,NA", &format!("line 2: column x: {number}, found \"NA\"")),
            ("1,1,2,,4", &format!("line 2: column width: {number}, found \"\"")),
            ("1,\"60,5\",2,3,4", &format!("line 2: column x: {number} with a decimal point, found \"60,5\"")),
            ("1,1,2,-3,4", "line 2: column width: expected a number above 0, found \"-3\""),
            ("1,1,2,3,0", "line 2: column height: expected a number above 0, found \"0\""),
            ("1,1,2,.2,4", "line 2: the box has no pixels: 1,2,0.2,4 (x,y,width,height)"),
            ("1,1,2,70000,4", "line 2: the box is too large or too far away"),
            ("1,1,2,3,4\n2,\"1,2,3,4\n3,1,2,3,4\n", "line 3: a quote is missing: expected quotes in pairs"),
            ("1,,,,\n", "there is no box to lock on"),
        ] {
            refuses(&format!("frame,x,y,width,height\n{rows}"), said);
        }
        for (rows, said) in [
            ("a/b,1,1,2,3,4,,", "line 2: column target: the name \"a/b\""),
            (",1,1,2,3,4,tracking,", "line 2: column target: the name \"\""),
            (
                "a,1,1,2,3,4,moving,",
                "line 2: column state: expected one of tracking, leaving, uncertain, lost, found \"moving\"",
            ),
            ("a,1,1,2,3,4,tracking,high", "line 2: column confidence: expected a number, found \"high\""),
            ("a,1,1,2,3,4,tracking,0.5", "there is no box to lock on: expected one without a confidence"),
        ] {
            refuses(&format!("target,frame,x,y,width,height,state,confidence\n{rows}"), said);
        }
    }

    fn track(shapes: &str) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<annotations><version>1.1</version><meta/>\n<track id=\"0\" label=\"a\">\n{shapes}\n</track></annotations>"
        )
    }

    #[test]
    fn cvat_is_read_as_xml() {
        let cvat = "<?xml version='1.0'?>\n<!-- <track label=\"no\"> --><annotations>\n<track id=\"0\" label=\"a &amp; &#98;&gt;\">\n\
                    <box frame=\"0\" keyframe=\"0\" xtl=\"0\"/><box\nframe='4' outside=\"0\" keyframe=\"1\" xtl=\"1\" ytl=\"2\" xbr = \"4\" ybr=\"6.4\">\n\
                    <attribute name=\"box\"><![CDATA[<box frame=\"9\"/>]]></attribute></box><!-- <box frame=\"1\" xtl=\"9\"/> -->\n\
                    <box frame=\"6\" outside=\"1\" /></track>\n<track label=\"car\">\n</track>\
                    <track label=\"car\"><box frame=\"1\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/></track>\
                    <track label=\" race car\"><box frame=\"7\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/><box frame=\"2\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/></track>\
                    </annotations>";
        reads(cvat, &["a _ b_ 5:1,2,3,4.4 7:gone", "car-2 2:1,1,8,8", "race car 3:1,1,8,8 8:1,1,8,8"]);
        // A label that looks like a number of another.
        let label = |label: &str| {
            format!("<track label=\"{label}\"><box frame=\"0\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/></track>")
        };
        let labels = ["car-2", "car", "car", "car"].map(label).concat();
        let names = ["car-2", "car", "car-3", "car-4"].map(|name| format!("{name} 1:1,1,8,8"));
        assert_eq!(read(&format!("<annotations>{labels}</annotations>")), Ok(names.to_vec()));
    }

    #[test]
    fn a_track_of_cvat_goes_on_a_line_between_its_own_key_frames() {
        let corners = "xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"";
        let shape = |frame: u8, more: &str| format!("<box frame=\"{frame}\" keyframe=\"1\" {more} {corners}/>\n");
        let outside = shape(9, "outside=\"1\"");
        let boxes = [shape(0, ""), shape(4, ""), outside, shape(12, ""), shape(14, "source=\"auto\""), shape(20, "")];
        let lines = |text: &str| parse(text.as_bytes(), &RECORDING).unwrap().remove(0).lines;
        assert_eq!(lines(&track(&boxes.concat())), [1]);
        assert_eq!(lines("frame,x,y,width,height\n1,1,2,3,4\n9,5,6,7,8"), [0; 0]);
    }

    #[test]
    fn label_studio_is_read_in_percent_of_the_frame() {
        let key =
            |frame: u8, more: &str| format!(r#"{{"frame":{frame},"x":10,"y":20.5,"width":30,"height":40{more}}}"#);
        let region = |keys: &[String], labels: &str| {
            let keys = keys.join(",");
            format!(
                r#"{{"type":"videorectangle","id":"a","value":{{"framesCount":9,"sequence":[{keys}],"labels":[{labels}]}}}}"#
            )
        };
        let file = |regions: &[String]| {
            let other = r#"{"type":"choices","value":{"choices":["night"]}}"#;
            format!(
                "[{{\"id\":1,\n\"annotations\":[{{\"result\":[{other},\n{}]}}],\"data\":{{}}}}]",
                regions.join(",\n")
            )
        };
        let off = r#","enabled":false,"rotation":0,"time":1.5"#;
        let all = [key(7, ""), key(1, r#","enabled":true"#), key(4, off)];
        let car = file(&[
            region(&all, "\"car\""),
            region(&[key(3, r#","rotation":90"#)], "\"car\""),
            region(&[key(2, off)], ""),
        ]);
        reads(
            &car,
            &[
                "car 1:20,20.5,60,40 4:20,20.5,60,40 5:gone 7:20,20.5,60,40",
                "car-2 3:-20,20.5,40,60",
                "target 2:20,20.5,60,40 3:gone",
            ],
        );
        assert_eq!(parse(car.as_bytes(), &RECORDING).unwrap()[0].lines, [1]);
        let one = |keys: &[String]| file(&[region(keys, "")]);
        for (text, said) in [
            ("[1]", "line 1: it is damaged, or no JSON of Label Studio"),
            (&*one(&[key(0, "")]), "line 3: it is damaged, or no JSON of Label Studio (expected the number of a frame"),
            (
                &one(&[key(1, "").replace("30", "0")]),
                "target in frame 1: expected width and height above 0, found 0 and 40",
            ),
            (
                &one(&[key(2, "").replace("40", "-4")]),
                "target in frame 2: expected width and height above 0, found 30 and -4",
            ),
            (&one(&[key(1, "").replace("30", "0.01")]), "target in frame 1: the box has no pixels: 20,20.5,0.0"),
            (&one(&[key(1, "").replace("30", "1e300")]), "target in frame 1: the box is too large or too far away"),
            (&one(&[key(4, ""), key(1, ""), key(4, "")]), "target is in frame 4 twice: expected one box"),
            ("[]", "there is no box to lock on"),
            (
                &car.replace("}],\"data", "},{\"result\":[]}],\"data"),
                "it has 2 annotations of the video: expected that of one person",
            ),
            (
                "[{\"id\":1,\"video\":\"a.mp4\",\"box\":[]}]",
                "no task of it has annotations: expected Label Studio's export JSON, not",
            ),
        ] {
            refuses(text, said);
        }
    }

    #[test]
    fn the_recording_is_found_in_an_export_of_several_videos() {
        let task = |video: &str, label: &str| {
            let key = r#"{"frame":13,"x":10,"y":20,"width":30,"height":40,"enabled":true,"rotation":0,"time":0.5}"#;
            let value = format!(r#"{{"framesCount":240,"duration":10,"sequence":[{key}],"labels":["{label}"]}}"#);
            let region = format!(r#"{{"type":"videorectangle","from_name":"box","to_name":"video","value":{value}}}"#);
            format!(
                r#"{{"annotations":[{{"was_cancelled":true,"result":[]}},{{"was_cancelled":false,"result":[{region}]}}],"drafts":[],"data":{{"video":"{video}","fps":24}}}}"#
            )
        };
        let export = |videos: &[&str]| {
            format!(
                "[{}]",
                videos.iter().map(|video| task(video, &format!("in {}", video.len()))).collect::<Vec<_>>().join(",")
            )
        };
        for mine in [
            "/data/upload/1/3d3ad63e-clip_1.mp4",
            "/data/local-files/?d=clip 1.mp4",
            "/data/local-files/?d=M%C3%A4use/clip%201.mp4",
            "https://host/a.b/clip 1.webm",
            "https://host/clip%201.mp4?token=a/b.c&x=%",
        ] {
            let others = ["/data/upload/1/3d3ad63e-clip_11.mp4", "clip.mp4", "s3://clip 1/other.mp4"];
            let found = export(&[others[0], mine, others[1], others[2]]);
            let at = Labelled { frames: Some(300), ..RECORDING };
            let read = parse(found.as_bytes(), &at).unwrap();
            // Label Studio has counted 24 frames a second, and the recording has 30.
            assert_eq!((read.len(), read[0].starts[0].0), (1, 16), "{mine}");
            assert_eq!(read[0].name.as_deref(), Some(&*format!("in {}", mine.len())), "{mine}");
            refuses(
                &export(&others),
                "it is about 3 videos: expected one called clip 1, found 3d3ad63e-clip_11, clip, other",
            );
            refuses(&export(&[mine, mine]), "it is about 2 videos: expected one called clip 1, found ");
        }
        for (frames, frame) in [(None, 13), (Some(240), 13), (Some(241), 13), (Some(250), 14), (Some(120), 7)] {
            let read = parse(export(&["other.mp4"]).as_bytes(), &Labelled { frames, ..RECORDING }).unwrap();
            assert_eq!(read[0].starts[0].0, frame, "{frames:?}");
        }
        for nonsense in ["1e300", "0", "-240", "2"] {
            let export = export(&["other.mp4"]).replace("240", nonsense);
            let read = parse(export.as_bytes(), &Labelled { frames: Some(300), ..RECORDING }).unwrap();
            assert_eq!(read[0].starts[0].0, 13, "{nonsense}");
        }
    }

    #[test]
    fn each_shape_of_cvat_is_its_bounding_box() {
        let shape = |kind: &str, attributes: &str| {
            track(&format!("<{kind} frame=\"0\" keyframe=\"1\" outside=\"0\" {attributes}/>"))
        };
        let cuboid = "xtl1=\"10\" ytl1=\"20\" xbl1=\"10\" ybl1=\"50\" xtr1=\"30\" ytr1=\"20\" xbr1=\"30\" ybr1=\"50\" \
                      xtl2=\"40\" ytl2=\"15\" xbl2=\"40\" ybl2=\"45\" xtr2=\"35\" ytr2=\"15\" xbr2=\"35\" ybr2=\"45\"";
        for (kind, attributes, bounds) in [
            ("box", "xtl=\"60.5\" ytl=\"90\" xbr=\"140.5\" ybr=\"110\"", "60.5,90,80,20"),
            ("box", "xtl=\"60\" ytl=\"90\" xbr=\"140\" ybr=\"110\" rotation=\"90.00\"", "90,60,20,80"),
            ("box", "xtl=\"60\" ytl=\"90\" xbr=\"140\" ybr=\"110\" rotation=\"-180\"", "60,90,80,20"),
            ("box", "xtl=\"60\" ytl=\"90\" xbr=\"140\" ybr=\"110\" rotation=\"630\"", "90,60,20,80"),
            ("polygon", "points=\"10.0,20.0;50.0,20.0;50.0,60.0\"", "10,20,40,40"),
            ("polyline", "points=\"10,20; -5.5,21\"", "-5.5,20,15.5,1"),
            ("points", "points=\"10,20;11,25;12,22\"", "10,20,2,5"),
            ("ellipse", "cx=\"50\" cy=\"60\" rx=\"20\" ry=\"10\"", "30,50,40,20"),
            ("ellipse", "cx=\"50\" cy=\"60\" rx=\"20\" ry=\"10\" rotation=\"270\"", "40,40,20,40"),
            ("cuboid", cuboid, "10,15,30,35"),
            ("mask", "rle=\"5, 2, 5\" left=\"5\" top=\"6\" width=\"4\" height=\"3\"", "6,7,2,1"),
        ] {
            reads(&shape(kind, attributes), &[&format!("a 1:{bounds}")]);
        }
        let point = |at: &str, outside: u8| {
            format!(
                "<points label=\"p\" outside=\"{outside}\" points=\"{at}\"><attribute name=\"n\">1</attribute></points>"
            )
        };
        let skeleton =
            |frame: u8, points: &str| format!("<skeleton frame=\"{frame}\" keyframe=\"1\">{points}</skeleton>");
        let seen = [point("1,2", 0), point("99,99", 1), point("5,9", 0)].concat();
        reads(&track(&(skeleton(0, &seen) + &skeleton(4, &point("1,2", 1)))), &["a 1:1,2,4,7 5:gone"]);
        // A square that is turned by 45 degrees.
        let turned =
            parse(shape("box", "xtl=\"0\" ytl=\"0\" xbr=\"10\" ybr=\"10\" rotation=\"45\"").as_bytes(), &RECORDING)
                .unwrap();
        let bounds = turned[0].starts[0].1.unwrap();
        assert!((bounds.x + 2.071).abs() < 1e-3 && (bounds.width - 14.142).abs() < 1e-3, "{bounds}");
    }

    #[test]
    fn shapes_of_images_are_locks_of_their_label() {
        let image = |id: u8, shapes: &str| {
            format!("<image id=\"{id}\" name=\"{id}.png\" width=\"99\" height=\"99\">\n{shapes}</image>\n")
        };
        let car = "<box label=\"car\" source=\"manual\" occluded=\"0\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\" z_order=\"0\"></box>";
        let man = "<tag label=\"night\"/><polygon label=\"a/b\" points=\"1,1;5,1;5,5\"/>";
        let all = |images: &[String]| format!("<annotations>\n{}</annotations>", images.concat());
        reads(
            &all(&[image(4, car), image(0, &format!("{man}{car}")), image(2, "")]),
            &["car 1:1,1,8,8 5:1,1,8,8", "a_b 1:1,1,4,4"],
        );
        refuses(
            &all(&[image(3, &format!("{car}\n{car}"))]),
            "line 4: car is in frame 4 twice, also in line 3: expected one",
        );
        refuses(&all(&[image(3, &car.replace("label", "l"))]), "line 3: there is no label=\"...\" in <box>");
        refuses(&all(&[image(3, car).replace("id=", "i=")]), "line 2: there is no id=\"...\" in <image>");
    }

    #[test]
    fn a_fault_of_cvat_has_its_line() {
        let corners = "xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"";
        for (shapes, said) in [
            ("<box frame=\"1\"/>", "line 4: there is no xtl=\"...\" in <box>"),
            (&*format!("<box {corners}/>"), "line 4: there is no frame=\"...\" in <box>"),
            (
                &format!("<box frame=\"x\" {corners}/>"),
                "line 4: frame: expected the number of a frame, 0 or more, found \"x\"",
            ),
            (&format!("<box frame=\"NaN\" {corners}/>"), "found \"NaN\""),
            (&format!("<box frame=\"-1\" {corners}/>"), "found \"-1\""),
            (&format!("<box frame=\"18446744073709551615\" {corners}/>"), "found \"18446744073709551615\""),
            (
                &format!("<box frame=\"1\" {corners}/>\n<box frame=\"1\" {corners}/>"),
                "line 5: a is in frame 2 twice, also in line 4",
            ),
            (
                &format!("<box frame=\"1\" {corners} xtl=\"2\"/>"),
                "line 4: it is damaged (error while parsing attribute: position 46: duplicated attribute",
            ),
            (
                &format!("<box frame=\"1\" keyframe=\"True\" {corners}/>"),
                "line 4: keyframe: expected 0 or 1, found \"True\"",
            ),
            (&format!("<box frame=\"1\" outside=\"\" {corners}/>"), "line 4: outside: expected 0 or 1, found \"\""),
            (
                &format!("<box frame=\"1\" rotation=\"90,0\" {corners}/>"),
                "line 4: rotation: expected a number with a decimal point, found \"90,0\"",
            ),
            (
                "\n<box frame=\"1\" xtl=\"1,5\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/>",
                "line 5: xtl: expected a number with a decimal point, found \"1,5\"",
            ),
            (
                "<box frame=\"1\" xtl=\"inf\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/>",
                "line 4: xtl: expected a number, found \"inf\"",
            ),
            (
                "<box frame=\"1\" xtl=\"10\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/>",
                "line 4: expected xtl <= xbr and ytl <= ybr, found 10, 9 and 1, 9",
            ),
            ("<box frame=\"1\" xtl=\"9\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/>", "line 4: the box has no pixels: 9,1,0,8"),
            ("<points frame=\"1\" points=\"9,1\"/>", "line 4: the box has no pixels: 9,1,0,0"),
            ("<polygon frame=\"1\" points=\"\"/>", "line 4: points: expected x,y;x,y;..., found \"\""),
            ("<polygon frame=\"1\" points=\"1,2;3\"/>", "line 4: points: expected x,y;x,y;..., found \"1,2;3\""),
            ("<polygon frame=\"1\" points=\"1,2;NaN,4;5,6\"/>", "line 4: points: expected x,y;x,y;..."),
            (
                "<ellipse frame=\"1\" cx=\"1\" cy=\"1\" rx=\"-1\" ry=\"2\"/>",
                "line 4: expected rx and ry above 0, found -1 and 2",
            ),
            (
                "<mask frame=\"1\" rle=\"1,99\" left=\"1\" top=\"1\" width=\"2\" height=\"2\"/>",
                "line 4: expected left, top, width, height and rle of a mask",
            ),
            ("<cuboid frame=\"1\" xtl1=\"1\"/>", "line 4: there is no ytl1=\"...\" in <cuboid>"),
            ("<blob frame=\"1\"/>", "line 4: <blob> is no shape of CVAT: expected one of box, polygon"),
            ("<box frame=\"1\" keyframe=\"0\"/>", "there is no box to lock on"),
            (&format!("<box frame=\"1\" source=\"auto\" {corners}/>"), "there is no box to lock on"),
        ] {
            refuses(&track(shapes), said);
        }
        let whole = track(&format!("<box frame=\"1\" {corners}/>"));
        for end in 1..whole.len() {
            refuses(&whole[..end], "line ");
        }
        let bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE a [<!ENTITY b \"bb\"><!ENTITY c \"&b;&b;\">]>\n<annotations>&c;</annotations>";
        for (text, said) in [
            (bomb, "line 2: it has a DOCTYPE: expected CVAT XML, which has none"),
            ("<!DOCTYPE html>\n<html></html>", "line 1: it has a DOCTYPE"),
            ("<annotations>\n<track label=\"&b;\"/></annotations>", "line 2: it is damaged ("),
            ("<annotation>\n</annotation>", "line 1: <annotation> is no CVAT XML: expected <annotations>"),
            ("<annotations></annotations>", "there is no box to lock on"),
            (
                "<annotations>\n<box frame=\"1\"/></annotations>",
                "line 2: <box> is not known: expected <track> or <image>",
            ),
            ("<annotations>\n<track/></annotations>", "line 2: there is no label=\"...\" in <track>"),
            ("<annotations>\n<track label=\" \"/></annotations>", "line 2: label: the name \"\""),
            ("<annotations>\n<track label=\"a\"></box></annotations>", "line 2: it is damaged ("),
            ("<annotations/>\n<annotations/>", "line 2: a second document begins"),
            ("<?xml version=\"1.0\"?>\n", "line 1: it is cut short"),
        ] {
            refuses(text, said);
        }
        let deep = format!("<annotations><track label=\"a\">{}", "<box>\n".repeat(100_000));
        refuses(&deep, "line 63: its elements are nested too deep");
        let wide = (0..200_000).map(|number| format!("a{number}=\"\" ")).collect::<String>();
        refuses(&format!("<annotations>\n<track {wide}/></annotations>"), "line 2: <track> has too many attributes");
    }
}
