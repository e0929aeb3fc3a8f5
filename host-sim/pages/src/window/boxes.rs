//! Reads locks (boxes that trackers start from) from CSV as `host-sim track` writes it, or from CVAT XML for video.

use super::{Lock, Target};
use anyhow::{Context, Result, anyhow, bail, ensure};
use smr_recordings::{BoundingBox, checked_name};

/// Parses CSV or CVAT XML into targets. Errors: The text is neither, a line is wrong, or there is no box to lock on.
pub fn read(text: &str) -> Result<Vec<Target>> {
    let text = text.trim_start_matches('\u{feff}');
    let read = if text.trim_start().starts_with('<') { of_cvat(text)? } else { of_csv(text)? };
    let targets = (1..).zip(read).map(|(id, Reading { name, locks, .. })| Target { id, name, locks });
    let targets: Vec<_> = targets.filter(|target| !target.locks.is_empty()).collect();
    ensure!(
        !targets.is_empty(),
        "there is no box to lock on: expected one without a confidence, or a key frame of CVAT"
    );
    Ok(targets)
}

/// A target during parsing: its locks so far, and the last frame that was read for it.
struct Reading {
    name: String,
    locks: Vec<Lock>,
    last: usize,
}

impl Reading {
    const fn new(name: String) -> Self {
        Self { name, locks: Vec::new(), last: 0 }
    }

    /// Advances to `frame`, which must be later than the target's previous frame. Returns the previous one, 0 at first.
    fn go_to(&mut self, frame: usize) -> Result<usize> {
        let before = std::mem::replace(&mut self.last, frame);
        ensure!(before < frame, "frame {frame} of {} comes behind frame {before}: expected frames in order", self.name);
        Ok(before)
    }

    fn lock(&mut self, frame: usize, bbox: BoundingBox) -> Result<()> {
        let rect = bbox.pixels().map_err(|what| anyhow!("the box {what}"))?;
        self.locks.push(Lock::new(frame, Some(rect)));
        Ok(())
    }

    fn leave(&mut self, frame: usize) {
        if self.locks.last().is_some_and(|last| last.bbox.is_some()) {
            self.locks.push(Lock::new(frame, None));
        }
    }
}

const COLUMNS: [&str; 5] = ["frame", "x", "y", "width", "height"];

fn row(names: &[&str], line: &str, all: &mut Vec<Reading>) -> Result<()> {
    let fields: Vec<_> = line.split(',').map(str::trim).collect();
    let (count, found) = (names.len(), fields.len());
    ensure!(count == found, "expected {count} fields as in line 1, found {found}");
    let field = |name: &str| names.iter().position(|one| *one == name).map(|at| fields[at]);
    let [number, bbox @ ..] = COLUMNS.map(|name| field(name).unwrap_or_default());
    let frame = number.parse().ok().filter(|&frame: &usize| frame > 0);
    let frame = frame.with_context(|| format!("expected the number of a frame, found {number:?}"))?;
    let name = field("target").map_or_else(|| Ok("target".to_owned()), checked_name)?;
    let at = all.iter().position(|one| one.name == name).unwrap_or_else(|| {
        all.push(Reading::new(name));
        all.len() - 1
    });
    let before = all[at].go_to(frame)?;
    if field("state").is_some() && before + 1 < frame {
        all[at].leave(before + 1);
    }
    let is_answer = field("confidence").is_some_and(|confidence| !confidence.is_empty());
    let has_none = field("state") == Some("lost") || is_answer || bbox == [""; 4];
    if has_none { Ok(()) } else { all[at].lock(frame, bbox.join(",").parse()?) }
}

/// Parses CSV. Rows with a box become locks, except *lost* rows and trackers' answers (rows with a confidence): if
/// answers became locks, the one after a user's correction would replace the correction after a single frame. With a
/// column `state`, a target is gone in frames without a row for it.
fn of_csv(text: &str) -> Result<Vec<Reading>> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let (number, head) = lines.next().context("it is empty: expected CSV or CVAT XML")?;
    let names: Vec<_> = head.split(',').map(str::trim).collect();
    if let Some(name) = COLUMNS.iter().find(|name| !names.contains(name)) {
        let expected = "expected CSV with the columns frame, x, y, width and height, or CVAT XML";
        bail!("line {number}: there is no column {name}: {expected}");
    }
    let mut all = Vec::new();
    lines.try_for_each(|(number, line)| row(&names, line, &mut all).with_context(|| format!("line {number}")))?;
    let end = all.iter().map(|one| one.last).max().unwrap_or(0);
    let ended = all.iter_mut().filter(|one| names.contains(&"state") && one.last < end);
    ended.for_each(|one| one.leave(one.last + 1));
    Ok(all)
}

/// Parses CVAT XML for video. A key frame is a lock or, with `outside`, the frame from which on the target is gone.
/// Boxes between key frames and boxes from a tracker (`source="auto"`) are skipped.
fn of_cvat(text: &str) -> Result<Vec<Reading>> {
    let mut all: Vec<Reading> = Vec::new();
    for (line, tag) in tags(text) {
        let read = match tag.split(|letter: char| letter.is_whitespace() || "/>".contains(letter)).next() {
            Some("track") => track(tag, &all).map(|track| all.push(track)),
            Some("box") => all
                .last_mut()
                .context("this box is in no track: expected CVAT XML for video")
                .and_then(|track| key(tag, track)),
            Some("image") => Err(anyhow!("this is CVAT XML for images: expected the one for video")),
            _ => Ok(()),
        };
        read.with_context(|| format!("line {line}"))?;
    }
    Ok(all)
}

/// Parses the start tag of a track. Tracks with the same label are numbered: `car`, `car-2`.
fn track(tag: &str, others: &[Reading]) -> Result<Reading> {
    let plain = |letter: char| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' };
    let label: String = attribute(tag, "label")?.chars().map(plain).collect();
    let numbered = (2..).map(|number| format!("{label}-{number}"));
    let mut names = std::iter::once(label.clone()).chain(numbered);
    let name = names.find(|name| others.iter().all(|other| other.name != *name)).unwrap_or_default();
    Ok(Reading::new(checked_name(&name)?))
}

fn key(tag: &str, track: &mut Reading) -> Result<()> {
    let has = |name: &str, value: &str| attribute(tag, name).is_ok_and(|found| found == value);
    if has("keyframe", "0") || has("source", "auto") {
        return Ok(());
    }
    let number = |name: &str| -> Result<f64> {
        let text = attribute(tag, name)?;
        text.parse().with_context(|| format!("{name}={text:?}: expected a number"))
    };
    let index = attribute(tag, "frame")?;
    let frame = index.parse().ok().and_then(|index: usize| index.checked_add(1));
    let frame = frame.with_context(|| format!("frame={index:?}: expected the number of a frame"))?;
    track.go_to(frame)?;
    if has("outside", "1") {
        track.leave(frame);
        return Ok(());
    }
    let (x, y) = (number("xtl")?, number("ytl")?);
    track.lock(frame, BoundingBox { x, y, width: number("xbr")? - x, height: number("ybr")? - y })
}

/// Returns (line number, text between `<` and `>`) of each XML tag.
fn tags(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut line = 1;
    let parts = text.split('<').map(move |part| {
        let at = line;
        line += part.matches('\n').count();
        (at, part.split('>').next().unwrap_or_default())
    });
    parts.skip(1)
}

fn attribute(tag: &str, name: &str) -> Result<String> {
    let key = format!("{name}=\"");
    let mut places = tag.match_indices(&key).map(|(at, key)| tag.split_at(at + key.len()));
    let value = places.find(|(before, _)| before.trim_end_matches(&key).ends_with(char::is_whitespace));
    let value = value.and_then(|(_, value)| value.split('"').next());
    let value = value
        .with_context(|| format!("there is no {name}=\"...\" in <{}>", tag.chars().take(60).collect::<String>()))?;
    let named = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    Ok(named.iter().fold(value.to_owned(), |text, (from, to)| text.replace(from, to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lock(frame: usize, bbox: (i32, i32, u16, u16)) -> Lock {
        Lock { frame, bbox: Some(bbox) }
    }

    #[test]
    fn given_boxes_of_csv_are_locks_and_answers_are_none() {
        let csv = "target,frame,time,x,y,width,height,state,confidence\ncar,1,,1.4,2,3,4,tracking,\ncar,2,,9,9,3,4,tracking,0.9\nman,2,,5,6,7,8,tracking,\n\
                   car,3,,,,,,lost,0\ncar,4,,9,9,3,4,uncertain,0.4\ncar,7,,-1,2,3,4,tracking,\ncar,8,,,,,,lost,\n";
        let targets = read(csv).unwrap();
        let gone = |frame| Lock::new(frame, None);
        let (car, man) = ([lock(1, (1, 2, 3, 4)), gone(5), lock(7, (-1, 2, 3, 4))], [lock(2, (5, 6, 7, 8)), gone(3)]);
        assert_eq!((targets[0].locks.as_slice(), targets[1].locks.as_slice()), (&car[..], &man[..]));
        assert_eq!((targets[1].id, targets[1].name.as_str()), (2, "man"));
    }

    #[test]
    fn other_files_are_read_and_what_is_wrong_is_named_with_its_line() {
        let csv = read("\u{feff}frame, x, y, width, height\r\n1,1.4,2,3,4\r\n\r\n50,5,6,7,8\r\n").unwrap();
        assert_eq!(csv[0].locks, [lock(1, (1, 2, 3, 4)), lock(50, (5, 6, 7, 8))], "what has no states has key frames");
        let cvat = "<?xml version=\"1.0\"?>\n<annotations>\n<track id=\"0\" label=\"a &amp; &quot;b&gt;\">\n\
                    <box frame=\"0\" keyframe=\"0\" xtl=\"0\"/><box\nframe=\"4\" outside=\"0\" keyframe=\"1\" xtl=\"1\" ytl=\"2\" xbr=\"4\" ybr=\"6.4\">\n\
                    <attribute name=\"box\">1</attribute></box><box frame=\"6\" outside=\"1\" /></track>\n<track label=\"car\">\n</track>\
                    <track label=\"car\"><box frame=\"1\" xtl=\"1\" ytl=\"1\" xbr=\"9\" ybr=\"9\"/></track></annotations>";
        let cvat = read(cvat).unwrap();
        assert_eq!((cvat[0].name.as_str(), cvat[1].name.as_str()), ("a____b_", "car-2"));
        assert_eq!(cvat[0].locks, [lock(5, (1, 2, 3, 4)), Lock { frame: 7, bbox: None }]);
        for (text, said) in [
            ("", "it is empty"),
            ("a,b\n1,2", "line 1: there is no column frame: expected CSV with the columns"),
            ("frame,x,y,width,height\n1,2,3,4\n", "line 2: expected 5 fields as in line 1, found 4"),
            ("frame,x,y,width,height\n0,1,2,3,4\n", "line 2: expected the number of a frame, found \"0\""),
            ("frame,x,y,width,height\n1,1,2,3,4\n1,1,2,3,4", "line 3: frame 1 of target comes behind frame 1"),
            ("frame,x,y,width,height\n1,a,2,3,4", "line 2: expected x,y,width,height"),
            ("frame,x,y,width,height\n1,1,2,.2,4", "line 2: the box has no pixels"),
            ("target,frame,x,y,width,height\na/b,1,1,2,3,4", "line 2: the name \"a/b\""),
            ("frame,x,y,width,height\n1,,,,\n", "there is no box to lock on"),
            ("<annotations></annotations>", "there is no box to lock on"),
            ("<a>\n<image id=\"1\"/></a>", "line 2: this is CVAT XML for images"),
            ("<a>\n\n<box frame=\"1\"/></a>", "line 3: this box is in no track"),
            ("<track label=\"a\">\n<box frame=\"1\"/>", "line 2: there is no xtl=\"...\" in <box frame=\"1\"/>"),
            ("<track label=\"a\">\n<box frame=\"x\"/>", "line 2: frame=\"x\": expected the number of a frame"),
        ] {
            let error = format!("{:#}", read(text).unwrap_err());
            assert!(error.starts_with(said), "{error}");
        }
    }
}
