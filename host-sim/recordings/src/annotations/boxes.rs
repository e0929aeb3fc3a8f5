//! Text files of boxes beside recordings.
//!
//! | file | form | a line |
//! |---|---|---|
//! | `init.txt` | TLD | the initial box |
//! | `gt.txt` | TLD | `x1,y1,x2,y2`, one line a frame; NaN where the target is not visible |
//! | `groundtruth_rect.txt` | OTB | `x,y,width,height`, one line a frame, the first pixel being 1; NaN or no area where it is not visible |
//! | `groundtruth.txt` | VOT, GOT-10k | `x,y,width,height`, a polygon or a mask, read as its bounding box; NaN, no area or one number where it is not visible |
//! | `absence.label` | GOT-10k | 1 where the target is not visible, else 0; one line a frame, beside `groundtruth.txt` |
//!
//! Numbers have decimal points; a line has one separator: comma, tab or space. Results of trackers are in TLD form.

use crate::bounding_box::{BoundingBox, four_numbers, numbers};
use anyhow::{Context, Result, anyhow, ensure};
use smr_files::input::{self, Kind};
use std::fs;
use std::path::Path;

/// 64 MiB are enough for a million lines of 67 bytes, such as polygons of four corners.
const KIND: Kind = Kind { expected: "a text file with a box a line", most: 64 };

/// Formats of text files with one box per line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// x1,y1,x2,y2, or NaN,NaN,NaN,NaN
    Tld,
    /// x,y,width,height, the first pixel being 1, or NaN,NaN,NaN,NaN
    Otb,
    /// x,y,width,height, or 0 alone for no box
    Vot,
}

impl Form {
    /// Formats a box as a line of the file, without a line end.
    pub fn line(self, entry: Option<&BoundingBox>) -> String {
        let Some(&BoundingBox { x, y, width, height }) = entry else {
            return if self == Self::Vot { "0".to_owned() } else { "NaN,NaN,NaN,NaN".to_owned() };
        };
        match self {
            Self::Tld => format!("{x},{y},{},{}", x + width, y + height),
            Self::Otb => format!("{},{},{width},{height}", x + 1.0, y + 1.0),
            Self::Vot => format!("{x},{y},{width},{height}"),
        }
    }

    /// Reads a file of one box per line. Returns `None` for NaN and, in OTB and VOT form, for a box without area. In
    /// VOT form, also returns `None` for a single number, an empty mask, and frames marked 1 in `absence.label` beside
    /// the file.
    pub fn read(self, path: &Path) -> Result<Vec<Option<BoundingBox>>> {
        let mut truth = read(path, |line| self.entry(line))?;
        let labels = path.with_file_name("absence.label");
        if self == Self::Vot && is_named(&labels) {
            let absent = read(&labels, absent)?;
            let (found, expected, at) = (absent.len(), truth.len(), labels.display());
            ensure!(found == expected, "{at} has {found} lines: expected {expected}, as groundtruth.txt beside it");
            truth.iter_mut().zip(absent).filter(|(_, absent)| *absent).for_each(|(entry, _)| *entry = None);
        }
        Ok(truth)
    }

    fn entry(self, line: &str) -> Result<Option<BoundingBox>> {
        let expected = match self {
            Self::Tld => "x1,y1,x2,y2 or NaN,NaN,NaN,NaN",
            Self::Otb => "x,y,width,height",
            Self::Vot => return Ok(region(line)?.filter(BoundingBox::has_area)),
        };
        let numbers = four_numbers(line).ok_or_else(|| anyhow!("expected {expected}, found {}", shown(line)))?;
        if numbers.iter().any(|number| number.is_nan()) {
            return Ok(None);
        }
        if self == Self::Otb {
            let [x, y, width, height] = numbers;
            return Ok(Some(BoundingBox { x: x - 1.0, y: y - 1.0, width, height }).filter(BoundingBox::has_area));
        }
        let found = BoundingBox::from_corners(numbers);
        ensure!(found.width >= 0.0 && found.height >= 0.0, "expected x1 <= x2 and y1 <= y2, found {}", shown(line));
        Ok(Some(found))
    }
}

pub(crate) fn find_truth(folder: &Path) -> Result<Option<Vec<Option<BoundingBox>>>> {
    let forms = TRUTH.map(|(form, name)| (form, folder.join(name)));
    forms.iter().find(|(_, file)| is_named(file)).map(|(form, file)| form.read(file)).transpose()
}

const TRUTH: [(Form, &str); 3] =
    [(Form::Tld, "gt.txt"), (Form::Otb, "groundtruth_rect.txt"), (Form::Vot, "groundtruth.txt")];

fn absent(line: &str) -> Result<bool> {
    match line.trim() {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(anyhow!("expected 0 or 1, found {}", shown(line))),
    }
}

pub(crate) fn find_init(folder: &Path) -> Result<Option<BoundingBox>> {
    let file = folder.join("init.txt");
    if !is_named(&file) {
        return Ok(None);
    }
    let first = Form::Tld.read(&file)?.into_iter().next().flatten();
    let init = first.filter(BoundingBox::has_area);
    init.map(Some).with_context(|| format!("{}: expected x1,y1,x2,y2, a box with an area", file.display()))
}

/// True if the file has the name of an annotation file, such as `gt.txt`.
pub fn is_known(file: &Path) -> bool {
    let mut names = ["init.txt", "absence.label"].into_iter().chain(TRUTH.map(|(_, name)| name));
    file.file_name().is_some_and(|name| names.any(|known| name == known))
}

/// True if the path exists, even as a broken link: reading the link then reports the error.
fn is_named(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok()
}

fn read<T>(path: &Path, entry: impl Fn(&str) -> Result<T>) -> Result<Vec<T>> {
    let text = input::text(path, &KIND).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&text, entry).with_context(|| path.display().to_string())
}

fn parse<T>(text: &str, entry: impl Fn(&str) -> Result<T>) -> Result<Vec<T>> {
    // Many editors end a file with empty lines.
    text.trim_end()
        .lines()
        .enumerate()
        .map(|(index, line)| entry(line).with_context(|| format!("line {}", index + 1)))
        .collect()
}

/// Returns the box around a region of VOT: `x,y,width,height`, polygon `x1,y1,x2,y2,x3,y3,...`, or mask
/// `mX,Y,WIDTH,HEIGHT` with run lengths. `None` for NaN, an empty mask, and a single number (target hidden or lost).
pub fn region(text: &str) -> Result<Option<BoundingBox>> {
    let expected = || anyhow!("expected x,y,width,height or a polygon x1,y1,x2,y2,x3,y3,..., found {}", shown(text));
    if let Some(runs) = text.trim().strip_prefix('m') {
        let expected = "expected a mask mX,Y,WIDTH,HEIGHT,RUN,RUN,... whose runs cover at most WIDTH x HEIGHT pixels";
        return mask(runs).with_context(|| format!("{expected}, found {}", shown(text)));
    }
    let numbers = numbers(text).ok_or_else(expected)?;
    let hidden = numbers.iter().any(|number| number.is_nan());
    match numbers[..] {
        [_] => Ok(None),
        [_, _, _, _] if hidden => Ok(None),
        [x, y, width, height] => {
            ensure!(width >= 0.0 && height >= 0.0, "expected a width and a height of 0 or more, found {}", shown(text));
            Ok(Some(BoundingBox { x, y, width, height }))
        }
        _ if numbers.len() < 6 || numbers.len() % 2 == 1 => Err(expected()),
        _ if hidden => Ok(None),
        _ => Ok(BoundingBox::around(numbers.as_chunks().0)),
    }
}

/// Returns the box around the target in a run-length mask. The runs go through a rectangle of the image row by row,
/// and are alternately background (first) and target. The outer `None` means that the text is no mask.
pub(crate) fn mask(text: &str) -> Option<Option<BoundingBox>> {
    let numbers = text.split(',').map(|field| field.trim().parse::<u32>().ok()).collect::<Option<Vec<_>>>()?;
    let (&[x, y, width, height], runs) = numbers.split_first_chunk()?;
    let (width, height) = (u64::from(u16::try_from(width).ok()?), u64::from(u16::try_from(height).ok()?));
    let (mut end, mut corners) = (0, Vec::new());
    for (index, &run) in runs.iter().enumerate() {
        let begin = end;
        end += u64::from(run);
        if end > width * height {
            return None;
        }
        if index % 2 == 1 && run > 0 {
            let (top, bottom) = (begin / width, (end - 1) / width);
            // A run over several rows touches both sides of the mask's rectangle.
            let (left, right) = if top == bottom { (begin % width, (end - 1) % width + 1) } else { (0, width) };
            let place = |column: u64, row: u64| [(column + u64::from(x)) as f64, (row + u64::from(y)) as f64];
            corners.extend([place(left, top), place(right, bottom + 1)]);
        }
    }
    Some(BoundingBox::around(&corners))
}

fn shown(line: &str) -> String {
    let start: String = line.chars().take(60).collect();
    let is_mixed = line.contains([',']) && line.trim().contains([' ', '\t', ';']);
    format!("{start:?}{}", if is_mixed { ": use decimal points, and the same separator in the whole line" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxed(x: f64, y: f64, width: f64, height: f64) -> BoundingBox {
        BoundingBox { x, y, width, height }
    }

    fn parsed(form: Form, text: &str) -> Result<Vec<Option<BoundingBox>>> {
        parse(&input::decoded(text.as_bytes(), &KIND)?, |line| form.entry(line))
    }

    #[test]
    fn each_form_is_read_with_every_separator_and_end_of_line() {
        let shown = |entry: Option<BoundingBox>| entry.map_or("-".to_owned(), |entry| entry.to_string());
        let otb = "\u{feff}129,80,64,78\n129\t80\t64\t78\n 129  80 64 78\n129, 80, 64, 78\n0,0,0,0\nNaN,1,2,3";
        let vot = "1,2,3,4\n10.5,20,30,20,30,40,10.5,40\nnan,nan,nan,nan\n0\n0,0,0,0\n5 6 7 8\nnan,1,2,3,4,5";
        // One mask in both forms of vot-toolkit 0.9: of the whole image, and cropped to the target.
        let whole_mask = format!("m0,0,50,40,365,15,30{},20,1020", ",20,30".repeat(11));
        for (form, text, expected) in [
            (Form::Tld, "165,93,216,147\r\n164.5,93.25,215.5,147.25\r\n", "165,93,51,54 164.5,93.25,51,54"),
            (Form::Tld, "NaN,NaN,NaN,NaN\r\nnan nan nan nan\r\n\r\n", "- -"),
            (Form::Tld, "1,2,3,4\n1,2,3,4", "1,2,2,2 1,2,2,2"),
            (Form::Tld, "1,2,3,4\r1,2,3,4\r", "1,2,2,2 1,2,2,2"),
            (Form::Tld, "\u{feff}1,2,3,4\r1 2 3 4\n\n", "1,2,2,2 1,2,2,2"),
            (Form::Otb, otb, "128,79,64,78 128,79,64,78 128,79,64,78 128,79,64,78 - -"),
            (Form::Vot, vot, "1,2,3,4 10.5,20,19.5,20 - - - 5,6,7,8 -"),
            (Form::Vot, "1, 2, 3, 4\n 1,  2,3, 4\n1,2,3,4,", "1,2,3,4 1,2,3,4 1,2,3,4"),
            (Form::Vot, "  1   2 3 4 \n1 \t 2\t3\t\t4", "1,2,3,4 1,2,3,4"),
            (Form::Vot, "0,0,1,0,1,1,0,1\n0, 0, 1, 0, 1, 1, 0, 1\n0 0 1 0 1 1 0 1", "0,0,1,1 0,0,1,1 0,0,1,1"),
            (Form::Vot, &whole_mask, "10,7,20,13"),
            (Form::Vot, "m10,7,20,13,5,255\nm0,0,0,0,0\nm5,6,4,3,5,2,5", "10,7,20,13 - 6,7,2,1"),
        ] {
            let found: Vec<String> = parsed(form, text).unwrap().into_iter().map(shown).collect();
            assert_eq!(found.join(" "), expected, "{text:?}");
        }
    }

    #[test]
    fn two_separators_in_a_line_are_refused() {
        for text in [
            "60,5 80,5 40,0 40,0",
            "60,5\t80,5\t40,0\t40,0",
            "60,5;80,5;40,0;40,0",
            "60,5, 80,5, 40,0, 40,0",
            "60,5 80 40 40",
            "60, 80 40, 40",
            "60\t80 40\t40",
            "1 000\t2 000\t40\t40",
            "1,,2,3,4",
        ] {
            assert!(TRUTH.iter().all(|(form, _)| form.entry(text).is_err()), "{text:?}");
        }
        let error = region("60,5 80,5 40,0 40,0").unwrap_err().to_string();
        assert!(error.ends_with("use decimal points, and the same separator in the whole line"), "{error}");
    }

    #[test]
    fn errors_name_line_and_expectation() {
        for (form, text, expected) in [
            (Form::Tld, "1,2,3,4\n1,2,3\n", "line 2: expected x1,y1,x2,y2 or NaN,NaN,NaN,NaN, found \"1,2,3\""),
            (Form::Otb, "1,2,3,4\n\n1,2,3,4", "line 2: expected x,y,width,height, found \"\""),
            (Form::Tld, "10,2,3,4", "line 1: expected x1 <= x2 and y1 <= y2, found \"10,2,3,4\""),
            (Form::Tld, "1,2,3,inf", "line 1: expected x1,y1,x2,y2 or NaN,NaN,NaN,NaN, found \"1,2,3,inf\""),
            (Form::Tld, "1,2,3,4,5", "line 1: expected x1,y1,x2,y2 or NaN,NaN,NaN,NaN, found \"1,2,3,4,5\""),
        ] {
            assert_eq!(format!("{:#}", parsed(form, text).unwrap_err()), expected);
        }
        for text in ["", "1,2", "1,2,3", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,-3,4", "a,b,c,d", "nan,1,nan"] {
            let error = region(text).unwrap_err().to_string();
            assert!(error.starts_with("expected ") && error.contains("found "), "{text}: {error}");
        }
        for text in ["m", "m1,2,3", "m-1,2,3,4,5", "m1,2,3,4,5.5", "m1,2,70000,4", "m1,2,3,4,5,", "m10,10,3,4,13"] {
            let error = region(text).unwrap_err().to_string();
            assert!(error.starts_with("expected a mask mX,Y,WIDTH,HEIGHT"), "{text}: {error}");
        }
        for text in ["", "1,2,3", "1,2,0,4", "1,2,3,-4", "1,2,3,NaN", "NaN,2,3,4", "1,2,3,4,5", "a,b,c,d", "1 2 3 4"] {
            let error = text.parse::<BoundingBox>().unwrap_err().to_string();
            let expected = "expected x,y,width,height: four numbers with commas, width and height above 0";
            assert_eq!(error, expected, "{text}");
        }
    }

    #[test]
    fn files_of_boxes_are_found_and_named() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let fails = |expected: &str| {
            let found = find_truth(folder.path()).and(find_init(folder.path()).map(|_| ()));
            let error = format!("{:#}", found.unwrap_err()).replace(&folder.path().display().to_string(), "@");
            assert_eq!(error, expected);
        };
        assert_eq!((find_truth(folder.path()).unwrap(), find_init(folder.path()).unwrap()), (None, None));
        for text in ["", "NaN,NaN,NaN,NaN", "4,4,4,8"] {
            fs::write(place("init.txt"), text).unwrap();
            fails("@/init.txt: expected x1,y1,x2,y2, a box with an area");
        }
        fs::write(place("init.txt"), "4,4,5,8").unwrap();
        assert_eq!(find_init(folder.path()).unwrap(), Some(boxed(4.0, 4.0, 1.0, 4.0)));
        fs::write(place("groundtruth.txt"), "1,2,3,4\n5,6,7,8\n0").unwrap();
        fs::write(place("absence.label"), "0\n1\n1\n").unwrap();
        let absent = vec![Some(boxed(1.0, 2.0, 3.0, 4.0)), None, None];
        assert_eq!(find_truth(folder.path()).unwrap(), Some(absent));
        fs::write(place("absence.label"), "0\n2\n").unwrap();
        fails("@/absence.label: line 2: expected 0 or 1, found \"2\"");
        fs::write(place("absence.label"), "0\n").unwrap();
        fails("@/absence.label has 1 lines: expected 3, as groundtruth.txt beside it");
        fs::write(place("gt.txt"), "1,2,3,x").unwrap();
        fails("@/gt.txt: line 1: expected x1,y1,x2,y2 or NaN,NaN,NaN,NaN, found \"1,2,3,x\"");
    }

    prop_compose! {
        /// A box with an area, in whole sixteenths of a pixel, which f64 holds exactly, so x + width - x equals width.
        fn any_box()(x in -1_000_000_i32..1_000_000, y in -1_000_000_i32..1_000_000, w in 1_i32..1_000_000, h in 1_i32..1_000_000)
            -> BoundingBox {
            let [x, y, width, height] = [x, y, w, h].map(|number| f64::from(number) / 16.0);
            boxed(x, y, width, height)
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(entries in proptest::collection::vec(proptest::option::of(any_box()), 0..20)) {
            for (form, _) in TRUTH {
                let lines: Vec<String> = entries.iter().map(|entry| form.line(entry.as_ref())).collect();
                prop_assert_eq!(parsed(form, &lines.join("\n")).unwrap(), &entries[..], "{:?}", form);
            }
            for entry in entries.iter().flatten() {
                prop_assert_eq!(entry.to_string().parse::<BoundingBox>().unwrap(), *entry);
            }
        }
    }
}
