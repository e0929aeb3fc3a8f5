//! Errors of the program smr-qemu: each prints one clear line and leaves no process behind. Shell scripts replace QEMU,
//! LLVM and firmware; `.ci/firmware` runs the real programs.
#![cfg(unix)]

#[path = "../../missing.rs"]
mod missing;

use missing::{has, runs};
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// A folder with a file that looks like firmware, and with scripts that come first on the PATH.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new(qemu: &str) -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        bench.program("qemu-system-arm", qemu);
        // An ELF header: 32 bits, Arm, no sections.
        let mut elf = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0\x28\0\x01\0\0\0".to_vec();
        elf.extend([0; 16]);
        elf.extend([52, 0, 32, 0, 0, 0, 40, 0, 0, 0, 0, 0]);
        fs::write(bench.path("firmware"), elf).unwrap();
        bench
    }

    fn saying(lines: &[&[u32]]) -> Self {
        let bench = Self::new("cp \"${0%/*}/lines\" said.smr");
        let padded = |line: &&[u32]| [line, &[0; 16][line.len()..]].concat();
        let words = lines.iter().flat_map(padded);
        fs::write(bench.path("lines"), words.flat_map(u32::to_le_bytes).collect::<Vec<_>>()).unwrap();
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn program(&self, name: &str, script: &str) {
        fs::write(self.path(name), format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(self.path(name), fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn start(&self, arguments: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_smr-qemu"));
        command.env("PATH", format!("{}:/usr/bin:/bin", self.path("").display()));
        command.arg(self.path("firmware")).args(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn run(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let output = self.start(arguments).wait_with_output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    }

    #[track_caller]
    fn refuses(&self, arguments: &[&str], words: &str) {
        let (code, _, err) = self.run(arguments);
        assert_eq!((code, err.lines().count()), (Some(2), 1), "{err}");
        assert!(err.contains(words), "`{words}` is not in: {err}");
    }
}

const SEQ: &[&str] = &["synthetic", "--frames", "..3"];
const HELLO: &[u32] = &[1, 5, 9252, 4500, 4600, 2_000_000, 80_000];
/// Offset in bytes from the start of the record to a byte inside its lock entry.
const LOCKED: u32 = 600;

#[test]
fn what_is_wrong_is_said_in_one_line() {
    Bench::new("echo 'qemu: no such machine' >&2; exit 1")
        .refuses(SEQ, "ended (exit status: 1): qemu: no such machine");
    Bench::new("kill -SEGV $$").refuses(&[], "ended (signal: 11");
    Bench::new("exit 0").refuses(SEQ, "synthetic: the firmware ended before the record did");
    Bench::saying(&[HELLO, &[5, LOCKED, 5]]).refuses(SEQ, "the firmware refuses frame 2: it cannot search the frame");
    Bench::saying(&[HELLO, &[5, 0, 3]]).refuses(SEQ, "the firmware refuses frame 1: it is built without this tracker");
    Bench::saying(&[&[1, 7]]).refuses(SEQ, "by version 5 of the protocol");
    Bench::saying(&[HELLO, &[9, 3]]).refuses(SEQ, "expected what an update took");
    Bench::saying(&[HELLO, &[2, 3], &[4, 2]]).refuses(SEQ, "the firmware ended before the record did");
    Bench::saying(&[&HELLO[..6]]).refuses(SEQ, "timer stands still");
    let bench = Bench::new("");
    bench.refuses(&["--refiner"], "--refiner: expected --method robust");
    bench.program("qemu-system-arm", "");
    fs::write(bench.path("firmware"), "text").unwrap();
    bench.refuses(&[], "is not firmware: expected an ELF file of 32 bits");
    fs::remove_file(bench.path("firmware")).unwrap();
    bench.refuses(&[], "cannot open the firmware");
}

#[test]
fn another_answer_is_a_failed_check() {
    let bench = Bench::saying(&[HELLO, &[5, LOCKED, 6, 256, 512, 10, 11]]);
    let (code, out, err) = bench.run(SEQ);
    assert_eq!((code, err.as_str()), (Some(1), ""));
    let words = "FAILED in frame 2: box in 1/256 pixel\n    target:   10x11 at (256, 512)\n    recorded: ";
    assert!(out.contains(words), "{out}");
    let bench = Bench::saying(&[HELLO, &[2, 7, 8], &[2, 7, 8], &[3, 5], &[4, 20_000, 30_000, 900, 4]]);
    let (code, out, err) = bench.run(&[SEQ, &["--step", "10"]].concat());
    assert_eq!((code, err.as_str()), (Some(0), ""));
    for words in ["2 frames answered as recorded", "of the lock: 100\n", "median 200, mean 200", "at most 125\n"] {
        assert!(out.contains(words), "`{words}` is not in: {out}");
    }
}

/// The reader closes the log while the firmware runs. smr-qemu must still return the firmware's exit code.
#[test]
fn a_reader_that_goes_away_does_not_hide_that_firmware_fails() {
    let bench = Bench::new("echo first; sleep 0.3; yes | head -n 100000; exit 3");
    let mut run = bench.start(&[]);
    let mut log = BufReader::new(run.stdout.take().unwrap());
    let mut first = String::new();
    log.read_line(&mut first).unwrap();
    drop(log);
    let mut err = String::new();
    run.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((first.as_str(), run.wait().unwrap().code(), err.as_str()), ("first\n", Some(1), ""));
}

#[test]
fn a_signal_ends_qemu_as_well() {
    let bench = Bench::new("echo $$ >\"$0.id\"; exec sleep 600");
    let child = bench.start(SEQ);
    let started = || fs::read_to_string(bench.path("qemu-system-arm.id")).ok().filter(|id| id.ends_with('\n'));
    let id = std::iter::repeat_with(started).find_map(|id| id).unwrap();
    let kill = |signal: &str, id: &str| runs(Command::new("sh").args(["-c", &format!("kill {signal} {id}")]));
    assert!(kill("-INT", &child.id().to_string()));
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(130));
    assert!(!kill("-0", &id));
}

#[test]
fn cycles_are_those_of_the_blocks_that_ran() {
    if !has("cycles_are_those_of_the_blocks_that_ran", "python3", &["--version"]) {
        return;
    }
    // A trace in which the lock runs one block, and the update runs it twice.
    let bench = Bench::new("cat \"${0%/*}/trace\"");
    let translated = "IN: a\n0x00000100:  4812       ldr\n0x00000102:  c004       stm\n\n";
    let [block, mark] = ["00000100", "00000200"].map(|at| format!("Trace 0: 0x7f [0/{at}/0/ff020200] name\n"));
    let stopped = format!("{block}Stopped execution of TB chain before 0x7f [00000100] name\n");
    fs::write(bench.path("trace"), format!("{mark}{translated}{block}{mark}{mark}{block}{stopped}{block}{mark}"))
        .unwrap();
    bench.program(
        "llvm-objdump-19",
        "printf '%s\\n' '100 <follow>:' ' 100: \tldr\tr0, [r1]' ' 102: \tstm\tr0!, {r2, r3, r4}' '200 <smr_ticks>:'",
    );
    bench.program(
        "llvm-mca-19",
        r#"echo '{"CodeRegions": [{"Name": "0", "SummaryView": {"Instructions": 100, "TotalCycles": 100}}]}'"#,
    );
    let (code, out, err) = bench.run(&["--cycles"]);
    assert_eq!((code, err.as_str()), (Some(0), ""));
    // Cortex-M4 cycles: 2 for 2 instructions, 2 for words 2 and 3 of `stm`, 2 for the taken branch; 3 an instruction.
    for line in [
        "cortex-m4: lock 0.00, update median 0.000, at most 0.000; 3.00 an",
        "at 168 MHz: 14000000 updates",
        "100.0 %  3.00  follow",
    ] {
        assert!(out.contains(line), "`{line}` is not in: {out}");
    }
    bench.program("qemu-system-riscv32", "");
    bench.refuses(&["--cycles", "--machine", "virt"], "virt has a processor without a model: expected a Cortex-M");
    bench.program("llvm-mca-19", "echo damaged >&2; exit 1");
    bench.refuses(&["--cycles"], "llvm-mca-19 fails: damaged");
    bench.program("llvm-objdump-19", "echo '100 <follow>:'");
    bench.refuses(&["--cycles"], "the firmware has no function smr_ticks");
}
