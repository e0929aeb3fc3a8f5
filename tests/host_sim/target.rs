//! `host-sim target` when something is wrong: one clear line, within a bounded time, and no process left behind.
//!
//! Small scripts replace QEMU and imitate its failures. `.ci/targets` checks that the real QEMU runs the real firmware.

use crate::program::{PROGRAM, kill};
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A folder with a file that passes for firmware, and a shell script that replaces QEMU.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(script: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        fs::write(bench.path("firmware"), least_firmware()).expect("a file can be written");
        fs::write(bench.path("qemu"), format!("#!/bin/sh\n{script}\n")).expect("a file can be written");
        fs::set_permissions(bench.path("qemu"), fs::Permissions::from_mode(0o755)).expect("a mode can be set");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Makes the script answer with these records.
    fn answering(records: &[&[u32]], then: &str) -> Self {
        let bench = Self::new("");
        let mut bytes = Vec::new();
        for record in records {
            let mut padded = record.to_vec();
            padded.resize(20, 0);
            bytes.extend(padded.iter().flat_map(|word| word.to_le_bytes()));
        }
        fs::write(bench.path("records"), bytes).expect("a file can be written");
        let script = format!("#!/bin/sh\ncp '{}' answers.smr\n{then}\n", bench.path("records").display());
        fs::write(bench.path("qemu"), script).expect("a file can be written");
        bench
    }

    fn start(&self, arguments: &[&str]) -> Child {
        Command::new(PROGRAM)
            .args(["target", "synthetic", "--frames", "..4", "--elf"])
            .arg(self.path("firmware"))
            .arg("--qemu")
            .arg(self.path("qemu"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("host-sim runs")
    }

    /// Exit code, standard output, standard error.
    fn run(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let output = self.start(arguments).wait_with_output().expect("host-sim ends");
        let text = |bytes| String::from_utf8(bytes).expect("host-sim writes UTF-8");
        (output.status.code(), text(output.stdout), text(output.stderr))
    }

    #[track_caller]
    fn refuses(&self, arguments: &[&str], words: &str) {
        let (code, _, err) = self.run(arguments);
        assert_eq!((code, err.lines().count()), (Some(2), 1), "{err}");
        assert!(err.contains(words), "`{words}` is not in: {err}");
    }
}

/// An ELF header and one section of code: all that host-sim reads of a firmware before it runs.
fn least_firmware() -> Vec<u8> {
    let mut elf = b"\x7fELF\x01\x01\x01".to_vec();
    elf.resize(16, 0);
    let half = |elf: &mut Vec<u8>, value: u16| elf.extend(value.to_le_bytes());
    let word = |elf: &mut Vec<u8>, value: u32| elf.extend(value.to_le_bytes());
    for value in [2, 40] {
        half(&mut elf, value); // an executable for Arm
    }
    for value in [1, 0, 0, 52, 0] {
        word(&mut elf, value); // version, entry, no program headers, sections after this header, flags
    }
    for value in [52, 32, 0, 40, 3, 2] {
        half(&mut elf, value); // sizes and numbers of headers; the names are in section 2
    }
    elf.resize(52 + 40, 0);
    for value in [0, 1, 2, 0, 172, 4, 0, 0, 4, 0] {
        word(&mut elf, value); // code: PROGBITS, ALLOC
    }
    for value in [0, 3, 0, 0, 172, 1, 0, 0, 1, 0] {
        word(&mut elf, value); // names: one, empty
    }
    elf.resize(176, 0);
    elf
}

const HELLO: &[u32] = &[1, 4, 0, 4096, 16, 9216, 4500, 4600, 2_000_000, 80_000];
const ROBUST: &[u32] = &[1, 4, 1, 0, 0, 9216, 11_000, 25_000, 2_000_000, 80_000];

#[test]
fn a_qemu_that_is_missing_is_asked_for() {
    let bench = Bench::new("");
    fs::remove_file(bench.path("qemu")).expect("a file can be removed");
    bench.refuses(&[], "/qemu: install QEMU (Debian: qemu-system-arm)");
}

#[test]
fn a_qemu_that_crashes_is_quoted() {
    let bench = Bench::new("echo 'qemu: unsupported machine type' >&2; exit 1");
    bench.refuses(&[], "ended (exit status: 1): qemu: unsupported machine type");
    Bench::new("sleep 5 & echo gone >&2; exit 1").refuses(&[], "ended (exit status: 1)");
    Bench::new("kill -SEGV $$").refuses(&[], "ended (signal: 11");
    Bench::new("exit 0").refuses(&[], "while waiting for an answer of the firmware");
}

/// `host-sim run firmware | head -n 1`: the firmware fails when nobody reads its log any more.
#[test]
fn a_reader_that_goes_away_does_not_hide_that_firmware_fails() {
    for (code, expected) in [(3, 1), (0, 0)] {
        let many = "for line in 1 2 3 4 5 6 7 8 9; do lines=another$line$lines$lines$lines; done; echo $lines$lines";
        let bench = Bench::new(&format!("echo first; sleep 0.3; {many}; exit {code}"));
        let mut command = Command::new(PROGRAM);
        command.arg("run").arg(bench.path("firmware")).arg("--qemu").arg(bench.path("qemu"));
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("host-sim runs");
        let mut log = BufReader::new(run.stdout.take().expect("it is piped"));
        let mut first = String::new();
        log.read_line(&mut first).expect("the log is text");
        drop(log);
        let output = run.wait_with_output().expect("host-sim ends");
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!((first.as_str(), output.status.code(), err.as_ref()), ("first\n", Some(expected), ""));
    }
}

#[test]
fn a_qemu_that_hangs_is_ended() {
    let start = Instant::now();
    let bench = Bench::new("echo $$ > \"$0.id\"; exec sleep 600");
    bench.refuses(&["--timeout", "1"], "hangs: an answer of the firmware has not come within 1 s");
    assert!(start.elapsed() < Duration::from_secs(60));
    assert!(!is_running(&bench));
}

#[test]
fn a_signal_ends_qemu_as_well() {
    let bench = Bench::new("echo $$ > \"$0.id\"; exec sleep 600");
    let child = bench.start(&[]);
    while !bench.path("qemu.id").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(kill("-INT", &child.id().to_string()));
    let output = child.wait_with_output().expect("host-sim ends");
    // 128 and the number of SIGINT.
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(130), ""));
    assert!(!is_running(&bench));
}

fn is_running(bench: &Bench) -> bool {
    let id = fs::read_to_string(bench.path("qemu.id")).expect("the script wrote its process id");
    kill("-0", id.trim())
}

#[test]
fn what_the_firmware_refuses_is_said_in_words() {
    let bench = Bench::answering(&[HELLO], "exec sleep 600");
    bench.refuses(&["--init", "10,10,65,64"], "the box is too big for the firmware: 65x64 is 4160 pixels");
    bench.refuses(&["--init", "10,10,130,30"], "more than the 9216 pixels of its buffer");
    Bench::answering(&[HELLO, &[4, 2, 5]], "").refuses(&[], "synthetic, frame 2: the firmware cannot search the frame");
    Bench::answering(&[&[1, 7]], "").refuses(&[], "version 7 of the protocol: expected 4");
}

#[test]
fn another_answer_is_a_failed_check() {
    for (method, hello) in [("smr", HELLO), ("robust", ROBUST)] {
        let bench = Bench::answering(&[hello, &[2, 2, 256, 512, 10, 11, 0]], "exec sleep 600");
        let arguments = ["--method", method, "--step", "5000"];
        let (code, out, err) = bench.run(&arguments);
        assert_eq!((code, err.as_str()), (Some(1), ""));
        let words = "FAILED in frame 2: box in 1/256 pixel\n    target: 10x11 at (256, 512)\n    host:   ";
        assert!(out.contains(words), "{out}");
        let (code, out, _) = bench.run(&[&arguments[..], &["--json"]].concat());
        assert_eq!(code, Some(1));
        let json: serde_json::Value = serde_json::from_str(&out).expect("standard output is JSON");
        let difference = &json["difference"];
        assert_eq!((&difference["frame"], &difference["target"]), (&2.into(), &"10x11 at (256, 512)".into()));
        assert_eq!((&json["method"], &json["options"]), (&method.into(), &serde_json::json!({ "step": 5000 })));
    }
}

#[test]
fn the_firmware_must_follow_by_the_method_that_was_asked_for() {
    Bench::answering(&[HELLO], "exec sleep 600").refuses(&["--method", "robust"], "the method that was asked for");
    let bench = Bench::answering(&[ROBUST, &[4, 2, 3]], "exec sleep 600");
    let words = "the window around 24x28 is more than the 9216 pixels of its buffer";
    bench.refuses(&["--method", "robust"], words);
}

#[test]
fn firmware_that_is_none_is_refused() {
    let bench = Bench::new("");
    fs::write(bench.path("firmware"), "text").expect("a file can be written");
    bench.refuses(&[], "is not firmware: expected an ELF file of 32 bits");
    fs::remove_file(bench.path("firmware")).expect("a file can be removed");
    bench.refuses(&[], "cannot open the firmware");
    assert!(!Path::new("answers.smr").exists());
}

/// A program of LLVM, QEMU, and a trace of two measurements: a lock of one block, an update of the same block twice.
fn traced() -> Bench {
    let bench = Bench::new("cat \"$(dirname \"$0\")/trace\"");
    let translated = "IN: a\n0x00000100:  4812       ldr\n0x00000102:  c004       stm\n\n";
    let [block, mark] = ["00000100", "00000200"].map(|at| format!("Trace 0: 0x7f [0/{at}/0/ff020200] name\n"));
    fs::write(bench.path("trace"), format!("{mark}{translated}{block}{mark}{mark}{block}{block}{mark}"))
        .expect("a file can be written");
    let listing = "00000100 <follow>:\n     100:      \tldr\tr0, [r1]\n     102:      \tstm\tr0!, {r2, r3, r4}\n00000200 <smr_ticks>:\n";
    fs::write(bench.path("listing"), listing).expect("a file can be written");
    let model = r#"{"CodeRegions": [{"Name": "0", "SummaryView": {"Instructions": 100, "TotalCycles": 100}}]}"#;
    fs::write(bench.path("model"), model).expect("a file can be written");
    for (name, file) in [("llvm-objdump-19", "listing"), ("llvm-mca-19", "model")] {
        fs::write(bench.path(name), format!("#!/bin/sh\ncat \"$(dirname \"$0\")/{file}\"\n"))
            .expect("a file can be written");
        fs::set_permissions(bench.path(name), fs::Permissions::from_mode(0o755)).expect("a mode can be set");
    }
    bench
}

/// Runs the firmware to estimate its cycles, with `folder` before all others that have programs.
fn estimates(bench: &Bench, folder: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(PROGRAM);
    command
        .arg("run")
        .arg(bench.path("firmware"))
        .arg("--qemu")
        .arg(bench.path("qemu"))
        .arg("--cycles")
        .args(arguments);
    let output = command.env("PATH", folder).output().expect("host-sim runs");
    let text = |bytes| String::from_utf8(bytes).expect("host-sim writes UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn cycles_are_those_of_the_blocks_that_ran() {
    let bench = traced();
    let folder = format!("{}:/usr/bin:/bin", bench.path("").display());
    let (code, out, err) = estimates(&bench, &folder, &["--json"]);
    assert_eq!((code, err.as_str()), (Some(0), ""));
    let json: serde_json::Value = serde_json::from_str(&out).expect("standard output is JSON");
    // Of the Cortex-M4: two instructions in two cycles, two more words, and two more cycles for each branch that is taken.
    let of_m4 = &json[0];
    assert_eq!((&of_m4["processor"], &of_m4["lock"]), (&"cortex-m4".into(), &6.into()));
    assert_eq!((&of_m4["update"]["median"], &of_m4["traced"]["median"]), (&12.into(), &4.into()));
    assert_eq!((&of_m4["unknown"], &of_m4["functions"][0]["function"]), (&0.0.into(), &"follow".into()));
    let (_, out, _) = estimates(&bench, &folder, &[]);
    assert!(out.contains("cortex-m4: lock 0.00, update median 0.000"), "{out}");
    assert!(out.contains("100.0 %  3.00  follow"), "{out}");
}

#[test]
fn what_cycles_need_is_asked_for() {
    let bench = traced();
    let (code, _, err) = estimates(&bench, &bench.path("none").display().to_string(), &[]);
    assert_eq!((code, err.lines().count()), (Some(2), 1), "{err}");
    assert!(err.contains("there is no llvm-objdump: --cycles needs LLVM 18 or later (Debian: llvm-19)"), "{err}");
    let (code, _, err) = estimates(&bench, "/usr/bin:/bin", &["--machine", "virt"]);
    assert_eq!(code, Some(2));
    assert!(err.contains("virt has a processor without a model: expected a Cortex-M"), "{err}");
    fs::write(bench.path("listing"), "00000100 <follow>:\n").expect("a file can be written");
    let (_, _, err) = estimates(&bench, &format!("{}:/usr/bin:/bin", bench.path("").display()), &[]);
    assert!(err.contains("the firmware has no function smr_ticks"), "{err}");
    bench.refuses(&["--refiner"], "--refiner: expected --method robust");
}
