//! The program smr-bench as maintainers run it.

#[path = "../../missing.rs"]
mod missing;

use missing::has;
use serde_json::{Value, json};
use std::process::Command;

struct Said {
    code: Option<i32>,
    out: String,
    err: String,
}

fn bench(arguments: &[&str]) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_smr-bench")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Said { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

impl Said {
    /// Bad input or usage: exit code 2 and an error that contains all of `words`.
    #[track_caller]
    fn refuses(&self, words: &[&str]) {
        assert_eq!(self.code, Some(2), "{}", self.err);
        assert!(words.iter().all(|word| self.err.contains(word)), "{}", self.err);
    }
}

/// The least work that can be timed.
const SHORT: [&str; 9] = ["synthetic", "--every", "120", "--template", "16x16", "--window", "4x3", "--repeat", "1"];

#[test]
fn bench_reports_as_json_and_in_words() {
    let said = bench(&[&SHORT[..], &["--json"]].concat());
    let report: Value = serde_json::from_str(&said.out).expect(&said.err);

    let window = &report["windows"][0];
    assert_eq!((&window["window"], &window["offsets"]), (&Value::from("4x3"), &Value::from(63)));
    let searches = window["cases"].as_u64().unwrap();
    assert!(searches > 0, "{window}");
    let ways = window["ways"].as_array().unwrap();
    let robust = ways.iter().find(|way| way["way"] == "robust, Scalar").expect("both trackers are timed");
    assert!(robust["work"].as_u64() > Some(0) && robust["work_left"].is_null(), "{robust}");
    assert_eq!(
        (&report["methods"], &report["version"]),
        (&json!(["smr", "robust"]), &env!("CARGO_PKG_VERSION").into())
    );
    let plain = ways.iter().find(|way| way["way"] == "Scalar, exhaustive").expect("every machine has the plain loop");
    assert_eq!(plain["work_left"].as_f64(), Some(1.0));
    assert!(plain["nanoseconds"]["max"].as_u64() >= plain["nanoseconds"]["median"].as_u64());
    assert!(ways.iter().any(|way| way["way"] == "SAD, plain loop"));
    assert_eq!(report["differences"], Value::Array(vec![]));
    assert!(report["goals_stated_for"].as_str().unwrap().contains("six TLD recordings"));
    assert!(report["goals"].as_array().unwrap().iter().all(|goal| goal["at_most"].as_f64() > Some(0.0)));

    let text = bench(&SHORT);
    assert_eq!((text.code, text.err.as_str()), (Some(0), ""));
    for words in ["window +-4x3: 63 offsets", "frames per second", "not measured"] {
        assert!(text.out.contains(words), "`{words}` is not in: {}", text.out);
    }
}

#[test]
fn bench_says_what_it_cannot_time() {
    bench(&["periodic"]).refuses(&["periodic", "no ground truth"]);
    for arguments in [["--template", "64"], ["--template", "0x9"], ["--window", "16"], ["--every", "0"]] {
        let said = bench(&["synthetic", arguments[0], arguments[1]]);
        assert_eq!(said.code, Some(2), "{arguments:?}");
        assert!(said.err.contains(arguments[0]), "{}", said.err);
    }
    let none = bench(&["synthetic", "--every", "120", "--repeat", "1", "--window", "100x100"]);
    assert_eq!(none.code, Some(0), "{}", none.err);
    assert!(none.out.contains("0 searches; "), "{}", none.out);
    bench(&["no/such/recording"]).refuses(&["no/such/recording"]);
    bench(&["synthetic", "--frames", "7"]).refuses(&["20..80"]);
    bench(&["synthetic", "--method", "sad"]).refuses(&["--method", "smr, robust"]);
    bench(&["synthetic", "periodic", "--init", "1,1,9,9"]).refuses(&["--init", "2"]);
}

/// Beside smr's trackers the programs of `others` are given the same frames: they see the target in the same places, or `run` fails.
#[test]
fn others_find_the_same_places() {
    const TEST: &str = "others_find_the_same_places";
    let programs = ["python3", "arm-none-eabi-gcc", "qemu-system-arm", "llvm-mca-19"];
    if !programs.iter().all(|program| has(TEST, program, &["--version"])) {
        return;
    }
    let run = |arguments: [&str; 2]| {
        let output = Command::new("python3").args(["others/run", "--only", "boards"]).args(arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Said { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    };
    let refused = run(["--openmv", "no/such"]);
    refused.refuses(&["--openmv no/such: expected OpenMV's template.c"]);
    assert_eq!(refused.err.lines().count(), 1, "{}", refused.err);
    run(["--frames", "7"]).refuses(&["20..80"]);
    let said = run(["--frames", "1..2"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for words in ["| smr, paper's tracker |", "| SAD, every offset |", "skipped: OpenMV"] {
        assert!(said.out.contains(words), "`{words}` is not in: {}", said.out);
    }
}
