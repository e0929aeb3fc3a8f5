"""Runs host-sim and the other programs that measure, remembers their commands, and keeps their output for equal programs."""

import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
ANSWERS = ROOT / "tests/kit/answers.txt"


class Failed(Exception):
    """A program or an input that is not as it should be."""


class Skipped(Exception):
    """A program or a recording that is not there."""


def fingerprint(trackers):
    """The answers of these trackers: the first digits of their hashes in tests/kit/answers.txt."""
    return "".join(line[:4] for line in ANSWERS.read_text().splitlines() if line.split()[1] in trackers)


def evaluation():
    """The program that evaluates, as a hash of its sources."""
    files = sorted((ROOT / "host-sim/evaluation").rglob("*.rs"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def target_folder():
    return (ROOT / os.environ.get("CARGO_TARGET_DIR", "target")).resolve()


def run(command, incomplete=None, **options):
    """Runs a program and returns its output. Its last line of errors is the error, unless it has the words `incomplete`."""
    if not shutil.which(command[0], path=options.get("env", os.environ).get("PATH")):
        raise Skipped(f"no {command[0]} on the PATH")
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False, **options)
    if done.returncode != 0 and not (incomplete and incomplete in done.stderr):
        said = done.stderr.strip().splitlines() or done.stdout.strip().splitlines() or ["no message"]
        raise Failed(f"{shlex.join(map(str, command))}: {said[-1]}")
    return done.stdout


def weights(half):
    """The refiner's weights trained on a half of the recordings."""
    return ROOT / f"tests/results/weights/half-{half}.bin"


class Programs:
    def __init__(self):
        self.sequences = Path(os.environ.get("SMR_SEQUENCES", ROOT / "../shared/sequences")).resolve()
        self.folder = target_folder() / "results"
        self.folder.mkdir(parents=True, exist_ok=True)
        self._built, self._said = {}, []

    def begin(self):
        """Forgets the commands of the table before."""
        self._said = []

    def commands(self):
        return list(dict.fromkeys(self._said))

    def said(self, command):
        self._said.append(command)

    def recordings(self, *names):
        """The folders of these sets of recordings: `tld`, `more`, `many`."""
        for name in names:
            if not (self.sequences / name).is_dir():
                raise Skipped(f"no folder {name} in the recordings (SMR_SEQUENCES)")
        return [f"{self.sequences.name}/{name}" for name in names]

    def host_sim(self, half=None):
        """host-sim, with the present weights or with those trained on a half of the recordings."""
        if half not in self._built:
            self._built[half] = self._built_with(half)
        return self._built[half]

    def _built_with(self, half):
        project = ROOT if half is None else self._copy(half)
        target = target_folder() if half is None else self.folder / "target"
        run(["cargo", "build", "--release", "--locked", "--quiet", "-p", "host-sim"], cwd=project, env=os.environ | {"CARGO_TARGET_DIR": str(target)})
        program = self.folder / f"host-sim-{half or 'present'}"
        new = program.with_suffix(".new")
        shutil.copy2(target / "release/host-sim", new)
        new.replace(program)
        return program

    def _copy(self, half):
        """A copy of the project with other weights. One folder for both, so that the second build is short."""
        copy = self.folder / "project"
        shutil.rmtree(copy, ignore_errors=True)
        files = run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT).split("\0")
        for name in filter(None, files):
            if (ROOT / name).is_file():
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, copy / name)
        shutil.copyfile(weights(half), copy / "core/src/track/robust/refiner/weights.bin")
        os.utime(copy / "core/src/track/robust/refiner/weights.bin")
        return copy

    def eval(self, *arguments, half=None, shown=None):
        """Runs `host-sim eval --json` in the folder above the recordings. A tracker with the same answers gives the kept output."""
        self.said(shown or shlex.join(["host-sim", "eval", *arguments]))
        trained = weights(half).read_bytes() if half else b""
        which = [fingerprint(("paper", "robust")), evaluation(), *arguments]
        key = hashlib.sha256("\n".join(which).encode() + trained).hexdigest()[:24]
        kept = self.folder / "outputs" / f"{key}.json"
        if not kept.exists():
            print(f"    host-sim eval {shlex.join(arguments)[:110]}", file=sys.stderr, flush=True)
            # A recording that is too short for a fault is left out, and the others are measured.
            incomplete = "of the measurements failed" if "--fault" in arguments else None
            output = run([self.host_sim(half), "eval", "--json", *arguments], incomplete, cwd=self.sequences.parent)
            kept.parent.mkdir(exist_ok=True)
            kept.write_text(output)
        return json.loads(kept.read_text())

    def versions(self):
        versions = {"rustc": run(["rustc", "--version"]).split()[1]}
        if shutil.which("ffmpeg"):
            versions["ffmpeg"] = re.search(r"ffmpeg version (\S+)", run(["ffmpeg", "-version"])).group(1)
        return versions

    def machine(self):
        """The processor in words, and the number of cores."""
        model = "an unknown processor"
        if os.path.exists("/proc/cpuinfo"):
            names = re.findall(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text())
            model = names[0].strip() if names else model
        return f"{os.cpu_count()} cores of {model}"
