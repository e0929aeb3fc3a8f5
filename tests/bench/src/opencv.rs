//! OpenCV's `matchTemplate` and its tracker CSRT on the same searches, where `python3` has OpenCV.

use super::clock::Patience;
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use smr_core::Rect;
use smr_recordings::GrayFrame;
use smr_recordings::cleanup::Process;
use smr_recordings::output::Exchange;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::rc::Rc;
use std::time::Duration;

const SCRIPT: &str = include_str!("opencv.py");

/// The functions that are timed, as tables name them.
pub const CALL: &str = "matchTemplate(TM_CCOEFF_NORMED) and TrackerCSRT.update, 1 thread";

/// What OpenCV does in a case.
#[derive(Debug)]
pub struct Search {
    pub crop: GrayFrame,
    pub template: GrayFrame,
    /// What CSRT follows, if it is timed: it locks on in the first frame and is updated with the second; the third is timed.
    pub followed: Option<Followed>,
}

/// Three frames in a row, and the box in the first.
#[derive(Debug)]
pub struct Followed {
    pub frames: [Rc<GrayFrame>; 3],
    pub target: Rect,
}

/// What the script prints: what is missing, or the times.
#[derive(Deserialize)]
struct Answer {
    missing: Option<String>,
    #[serde(default)]
    version: String,
    #[serde(default)]
    search: Vec<f64>,
    #[serde(default)]
    csrt: Vec<f64>,
}

/// How long each search took, and OpenCV's version.
#[derive(Debug)]
pub struct Times {
    pub version: String,
    pub search: Vec<Duration>,
    /// Empty where OpenCV comes without that tracker.
    pub csrt: Vec<Duration>,
}

/// Times `matchTemplate` of each template in its crop, and what CSRT follows, run by `python`.
/// Errors: Why it was not timed.
pub fn times(python: &str, searches: &[Search], patience: Patience) -> Result<Times> {
    let folder = Exchange::create()?;
    write(searches, folder.path()).context("cannot write the searches for OpenCV")?;
    let mut command = Command::new(python);
    command
        .arg(folder.path().join("opencv.py"))
        .arg(folder.path())
        .args([patience.repeats.to_string(), patience.enough.as_secs_f64().to_string()])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let output = Process::start(&mut command).and_then(Process::finish);
    let output = output.with_context(|| format!("cannot start {python}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().last().unwrap_or("it says nothing");
    ensure!(output.status.success(), "{python} failed: {last}");
    let answer: Answer =
        serde_json::from_slice(&output.stdout).with_context(|| format!("{python} does not answer in JSON"))?;
    answer.times(searches.len()).with_context(|| python.to_owned())
}

impl Answer {
    fn times(self, expected: usize) -> Result<Times> {
        let Self { missing, version, search, csrt } = self;
        if let Some(missing) = missing {
            bail!(missing);
        }
        ensure!(search.len() == expected, "{} of {expected} searches were timed", search.len());
        let times = |seconds: Vec<f64>| {
            let times: Result<Vec<_>, _> = seconds.into_iter().map(Duration::try_from_secs_f64).collect();
            times.context("expected seconds")
        };
        Ok(Times { version, search: times(search)?, csrt: times(csrt)? })
    }
}

fn write(searches: &[Search], folder: &Path) -> Result<()> {
    fs::write(folder.join("opencv.py"), SCRIPT)?;
    let mut raw = BufWriter::new(File::create(folder.join("searches.raw"))?);
    let mut sizes = Vec::new();
    for Search { crop, template, followed } in searches {
        raw.write_all(&crop.pixels)?;
        raw.write_all(&template.pixels)?;
        let size = |picture: &GrayFrame| [picture.width, picture.height];
        let mut search = serde_json::json!({ "crop": size(crop), "template": size(template) });
        if let Some(Followed { frames, target: Rect { x, y, width, height } }) = followed {
            frames.iter().try_for_each(|frame| raw.write_all(&frame.pixels))?;
            search["frame"] = serde_json::json!(size(&frames[0]));
            search["target"] = serde_json::json!([x, y, width, height]);
        }
        sizes.push(search);
    }
    raw.flush()?;
    fs::write(folder.join("searches.json"), serde_json::to_string(&sizes)?)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_script_answers_is_read() {
        let read = |json: &str| serde_json::from_str::<Answer>(json).unwrap().times(2);
        let times = read(r#"{"version": "5.0.0", "search": [0.25, 1.5e-4], "csrt": [0.02]}"#).unwrap();
        assert_eq!((times.version.as_str(), times.search[1]), ("5.0.0", Duration::from_micros(150)));
        assert_eq!(times.csrt, [Duration::from_millis(20)]);
        let error = |json| read(json).unwrap_err().to_string();
        assert_eq!(error(r#"{"missing": "No module named 'cv2'"}"#), "No module named 'cv2'");
        assert_eq!(error(r#"{"version": "5.0.0", "search": [0.25]}"#), "1 of 2 searches were timed");
        assert_eq!(error(r#"{"version": "5.0.0", "search": [0.25, -1]}"#), "expected seconds");
    }

    #[test]
    fn without_python_it_says_why() {
        let patience = Patience { repeats: 1, enough: Duration::ZERO };
        let error = times("no-such-python", &[], patience).unwrap_err();
        assert!(format!("{error:#}").contains("cannot start no-such-python"), "{error:#}");
        // A program that ends well and says nothing.
        let error = times("true", &[], patience).unwrap_err();
        assert!(format!("{error:#}").contains("does not answer in JSON"), "{error:#}");
    }
}
