"""Cost: cycles and instructions on emulated chips, milliseconds on this machine."""

import json
import os
import re
import statistics
import sys
import tempfile
from pathlib import Path

from .boards import rows as boards_table
from .programs import ROOT, Failed, Skipped, run, target_folder
from .table import Table

# For each machine of QEMU: the firmware's target, and its processor if it is not the target's own.
MACHINES = {
    "mps2-an385": ("thumbv6m-none-eabi", ""),
    "mps2-an386": ("thumbv7em-none-eabihf", ""),
    "mps2-an500": ("thumbv7em-none-eabihf", ""),
    "mps3-an547": ("thumbv8m.main-none-eabihf", "cortex-m55"),
    "virt": ("riscv32imac-unknown-none-elf", ""),
}
NAMES = {"mps2-an385": "Cortex-M0+", "mps2-an386": "Cortex-M4", "mps2-an500": "Cortex-M7", "mps3-an547": "Cortex-M55", "virt": "RV32"}
TRACKERS = {"paper's": ["--method", "paper"], "robust": ["--method", "robust"], "robust with refiner": ["--method", "robust", "--refiner"]}


class Firmware:
    """The replay firmware on emulated machines."""

    def __init__(self, programs):
        self.programs, self.built = programs, {}
        run(["cargo", "build", "--release", "--locked", "--quiet", "-p", "smr-qemu"], cwd=ROOT)
        self.qemu = target_folder() / "release/smr-qemu"

    def elf(self, machine, features):
        target, processor = MACHINES[machine]
        key = target, processor, features
        if key not in self.built:
            flags = {f"CARGO_TARGET_{re.sub('[-.]', '_', target).upper()}_RUSTFLAGS": f"-Ctarget-cpu={processor}"} if processor else {}
            build = ["build", "-p", "smr-chip", "--profile", "firmware", "--bin", "replay", "--features", features, "--quiet", "--message-format", "json"]
            built = re.findall('"executable":"([^"]*)"', run([".ci/target-cargo", target, *build], cwd=ROOT, env=os.environ | flags))[-1]
            # A copy, because firmware with other features is built at the same place.
            kept = self.programs.folder / f"replay-{target}-{processor}-{features}"
            kept.write_bytes(Path(built).read_bytes())
            self.built[key] = kept
        return self.built[key]

    def replay(self, machine, recording, *options, features=""):
        """The output of a replay of the recording."""
        shown = f"cargo run --target {MACHINES[machine][0]} --profile firmware -p smr-chip --bin replay -- {recording} {' '.join(options)} --machine {machine}"
        self.programs.said(shown)
        print(f"    replay {recording} {' '.join(options)} on {machine}", file=sys.stderr, flush=True)
        return run([self.qemu, self.elf(machine, features), recording, *options, "--machine", machine], cwd=self.programs.sequences.parent)


def number(said, before):
    found = re.search(before + r"(\d+)", said)
    if not found:
        raise Failed(f"the output of replay has no `{before}`")
    return int(found.group(1))


def millions(count):
    return f"{count / 1e6:.2f}" if count < 1e6 else f"{count / 1e6:.1f}"


def instruction_ratios(programs):
    """Mean instructions of an update on the test vectors, as multiples of the M4's: paper, robust, refined."""
    families = {"cortex-m4": "", "riscv32imc": "riscv", "xtensa": "xtensa"}
    command = [".ci/instructions", *families]
    programs.said(" ".join(command))
    counts = {}
    for line in run(command, cwd=ROOT).splitlines():
        archive, _, count = line.split()
        counts.setdefault(archive, []).append(int(count))
    return {family: [own / m4 for own, m4 in zip(counts[name], counts["cortex-m4"])] for name, family in families.items() if family}


def chips(programs):
    """Estimated cycles of both trackers, and updates a second of chips."""
    firmware = Firmware(programs)
    processors = {"cortex-m0plus": "mps2-an385", "cortex-m4": "mps2-an386", "cortex-m7": "mps2-an500", "cortex-m55": "mps3-an547", "cortex-m85": "mps3-an547"}
    cycles, rates = {}, {}
    for tracker, options in TRACKERS.items():
        for machine in dict.fromkeys(processors.values()):
            said = firmware.replay(machine, "street", "--frames", "1..30", "--cycles", *options, features="refiner")
            for name, *figures in re.findall(r"(cortex-\w+\+?): lock ([\d.]+), update median ([\d.]+), at most ([\d.]+)", said):
                cycles[tracker, name.replace("+", "plus")] = figures
            for chip, clock, median, least in re.findall(r"\n\s+(\S+) at (\d+) MHz: (\d+) updates a second, at least (\d+)", said):
                rates.setdefault((chip, clock), {})[tracker] = f"{median} ({least})"
    rows = []
    for tracker in TRACKERS:
        own = [cycles[tracker, name] for name in processors]
        rows.append([f"{tracker}, update: median; most", *(f"{float(median):.2f}; {float(most):.2f}" for _, median, most in own)])
        rows.append([f"{tracker}, lock", *(f"{float(lock):.2f}" for lock, _, _ in own)])
    by_chip = [[chip, f"{clock} MHz", *(rates[chip, clock].get(tracker, "-") for tracker in TRACKERS)] for chip, clock in rates]
    medians = {name: [float(cycles[tracker, name][1]) for tracker in TRACKERS] for name in processors}
    ratios = instruction_ratios(programs)
    figures = {family: "; ".join(f"{ratio:.1f}" for ratio in own) for family, own in ratios.items()}
    return figures, {"cycles": rows, "rates": by_chip, "boards": boards_table(medians, ratios)}


def replay(programs):
    """Memory and instructions of the replay firmware."""
    firmware, rows = Firmware(programs), []
    for method, machines in (("paper", list(NAMES)), ("robust", ["mps2-an386", "mps3-an547", "mps2-an385", "virt"])):
        for machine in machines:
            frames = ["--frames", "1..30"] if method == "robust" and machine in ("mps2-an385", "virt") else []
            said = firmware.replay(machine, "synthetic", "--method", method, *frames)
            memory = ", ".join(str(number(said, f"{part} ")) for part in ("target", "workspace", "buffer"))
            update, lock = number(said, "update: median "), number(said, "of the lock: ")
            cost = f"{millions(update)} M; the lock {millions(lock)} M"
            rows.append([f"{method}, {NAMES[machine]} (`{machine}`)", f"{number(said, 'RAM ')} B", f"{memory} B", f"{number(said, 'flash ')} B", cost])
    noise = {}
    for machine in ("mps2-an386", "mps3-an547", "mps2-an385", "virt"):
        said = firmware.replay(machine, "noise", "--method", "paper")
        noise[machine] = f"{millions(number(said, 'update: median '))}; {millions(number(said, 'mean .*at most '))}"
    return {}, {"all": rows, "noise": [["an update of `noise`: median; most", *noise.values()]]}


def boards(programs, options, names):
    """Rows of tests/bench/others/run for these trackers."""
    recording = programs.sequences / "tld/01_david"
    if not recording.is_dir():
        raise Skipped("no folder tld in the recordings (SMR_SEQUENCES)")
    programs.said(f"tests/bench/others/run --only boards {'--openmv OPENMV_SOURCES ' if options else ''}sequences/tld/01_david")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "boards.json"
        run([ROOT / "tests/bench/others/run", "--only", "boards", *options, "--json", out, recording])
        measured = json.loads(out.read_text())["boards"]
    cells = {}
    for row in measured:
        cells.setdefault(row["name"], []).extend(f"{row[key]:.2f}" for key in ("instructions", "cycles", "lock"))
    return [[name, *own] for name, own in cells.items() if names(name)]


def others(programs):
    """smr, SAD and MOSSE on a Cortex-M4 and an M55."""
    return {}, {"all": boards(programs, [], lambda name: True)}


def openmv(programs):
    """OpenMV's `find_template` there. It does not depend on smr."""
    folder = os.environ.get("OPENMV_SOURCES")
    if not folder:
        raise Skipped("no OPENMV_SOURCES, the folder of OpenMV's sources")
    return {}, {"all": boards(programs, ["--openmv", folder], lambda name: name.startswith("OpenMV"))}


def host(programs):
    """Milliseconds of an update, beside OpenCV."""
    recording = programs.sequences / "tld/01_david"
    if not recording.is_dir():
        raise Skipped("no folder tld in the recordings (SMR_SEQUENCES)")
    run([sys.executable, "-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps", ROOT / "core/python"])
    programs.said("tests/bench/others/run --only host sequences/tld/01_david")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "host.json"
        run([sys.executable, ROOT / "tests/bench/others/run", "--only", "host", "--json", out, recording])
        seconds = json.loads(out.read_text())["host"]
    if not seconds:
        raise Skipped("no cv2: pip install opencv-contrib-python-headless")
    medians = {name: 1000 * statistics.median(own) for name, own in seconds.items()}

    def times(slow, fast):
        return f"{medians[slow] / medians[fast]:.1f}"

    figures = {
        "match-16": times("matchTemplate, +-16", "smr.Paper, +-16"),
        "match-60": times("matchTemplate, +-60x50", "smr.Paper, +-60x50"),
        "csrt": f"{medians['CSRT'] / medians['smr.Robust']:.0f}",
        "paper-16": f"{medians['smr.Paper, +-16']:.3f}",
    }
    return figures, {"all": [[name, f"{median:.3f}"] for name, median in medians.items()]}


MODULES = {
    "armv7emsp": "Cortex-M4 and M7 with FPU, M33, M55: OpenMV cameras, RP2350",
    "armv6m": "Cortex-M0+: RP2040. All other Cortex-M can load this file, too, but run slower with it",
    "rv32imc": "RISC-V with 32 bits: ESP32-C3, RP2350 as RISC-V",
    "x64": "Linux on x86-64",
}


def modules(programs):
    """Bytes of the files for MicroPython."""
    programs.said(".ci/micropython all")
    run([".ci/micropython", "all"], cwd=ROOT)
    rows = []
    for name, processors in MODULES.items():
        files = [target_folder() / f"micropython/smr_{name}{ending}.mpy" for ending in ("", "_refiner")]
        if missing := [file.name for file in files if not file.exists()]:
            raise Skipped(f"no {missing[0]}: `.ci/micropython all` says why")
        rows.append([f"`smr_{name}.mpy`", processors, *(f"{file.stat().st_size:,}" for file in files)])
    return {}, {"all": rows}


TABLES = [
    Table("chips", "estimated cycles on chips", ("paper", "robust"), chips),
    Table("replay", "memory and instructions of the replay firmware", ("paper", "robust"), replay),
    Table("others", "smr, SAD and MOSSE on emulated chips", ("paper", "robust"), others),
    Table("openmv", "OpenMV's find_template on emulated chips", (), openmv),
    Table("modules", "bytes of the files for MicroPython", (), modules),
    Table("host", "milliseconds beside OpenCV", ("paper", "robust"), host),
]
