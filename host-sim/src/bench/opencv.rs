//! OpenCV's `matchTemplate` on the same searches, where `python3` has OpenCV.

use crate::clock::Patience;
use crate::sequence::GrayFrame;
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const SCRIPT: &str = include_str!("opencv.py");

/// The function that is timed, as tables name it.
pub const CALL: &str = "matchTemplate(TM_CCOEFF_NORMED), 1 thread";

/// What the script prints: what is missing, or the times.
#[derive(Deserialize)]
struct Answer {
    missing: Option<String>,
    #[serde(default)]
    version: String,
    #[serde(default)]
    seconds: Vec<f64>,
}

/// How long each search took, and OpenCV's version.
#[derive(Debug)]
pub struct Times {
    pub version: String,
    pub times: Vec<Duration>,
}

/// Times `matchTemplate` of each template in its crop, run by `python`.
///
/// # Errors
/// Why it was not timed.
pub fn times(python: &str, searches: &[(GrayFrame, GrayFrame)], patience: Patience) -> Result<Times> {
    let folder = tempfile::Builder::new().prefix("smr-").tempdir().context("no temporary folder")?;
    write(searches, folder.path()).context("cannot write the searches for OpenCV")?;
    let output = Command::new(python)
        .arg(folder.path().join("opencv.py"))
        .arg(folder.path())
        .args([patience.repeats.to_string(), patience.enough.as_secs_f64().to_string()])
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("cannot start {python}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.lines().last().unwrap_or("it says nothing");
    ensure!(output.status.success(), "{python} failed: {last}");
    let answer: Answer =
        serde_json::from_slice(&output.stdout).with_context(|| format!("{python} does not answer in JSON"))?;
    answer.times(searches.len()).with_context(|| python.to_owned())
}

impl Answer {
    fn times(self, expected: usize) -> Result<Times> {
        let Self { missing, version, seconds } = self;
        if let Some(missing) = missing {
            bail!(missing);
        }
        ensure!(seconds.len() == expected, "{} of {expected} searches were timed", seconds.len());
        let times: Result<Vec<_>, _> = seconds.iter().map(|&seconds| Duration::try_from_secs_f64(seconds)).collect();
        Ok(Times { version, times: times.context("expected seconds")? })
    }
}

fn write(searches: &[(GrayFrame, GrayFrame)], folder: &Path) -> Result<()> {
    fs::write(folder.join("opencv.py"), SCRIPT)?;
    let mut raw = BufWriter::new(File::create(folder.join("searches.raw"))?);
    let mut sizes = Vec::new();
    for (crop, template) in searches {
        raw.write_all(&crop.pixels)?;
        raw.write_all(&template.pixels)?;
        let size = |picture: &GrayFrame| [picture.width, picture.height];
        sizes.push(serde_json::json!({ "crop": size(crop), "template": size(template) }));
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
        let times = read(r#"{"version": "5.0.0", "seconds": [0.25, 1.5e-4]}"#).unwrap();
        assert_eq!((times.version.as_str(), times.times[1]), ("5.0.0", Duration::from_micros(150)));
        let error = |json| read(json).unwrap_err().to_string();
        assert_eq!(error(r#"{"missing": "No module named 'cv2'"}"#), "No module named 'cv2'");
        assert_eq!(error(r#"{"version": "5.0.0", "seconds": [0.25]}"#), "1 of 2 searches were timed");
        assert_eq!(error(r#"{"version": "5.0.0", "seconds": [0.25, -1]}"#), "expected seconds");
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
