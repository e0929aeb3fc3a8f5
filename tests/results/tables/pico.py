"""The Pico's firmware in an emulator: frames a second, pixels of lag, and cycles beside those that tests/qemu/cycles.py estimates."""

import bisect
import json
import os
import re
import sys

from .programs import ROOT, Failed, Skipped, run, target_folder
from .table import Table

sys.path.append(str(ROOT / "tests/qemu"))
import cycles


def estimated(elf, counts):
    """Sums over smr-core's functions: emulated cycles, and those by the manual of the Cortex-M0+ with a cycle for each taken branch."""
    functions, code = cycles.program(elf, "cortex-m0plus")
    starts = sorted(functions)
    emulated = by_manual = 0
    for address, (ran, taken, took) in ((int(address), count) for address, count in counts.items()):
        if address in code and "smr_core" in functions[starts[bisect.bisect(starts, address) - 1]]:
            emulated += took
            by_manual += ran * cycles.cycles_by_manual(code[address]) + taken
    return emulated, by_manual


def pico(programs):
    """Figures that `.ci/pico all` prints, and the cycles of a dozen frames."""
    programs.said(".ci/pico all")
    said = run([".ci/pico", "all"], cwd=ROOT)
    if missing := re.search(r"^skipped: pico: (.*)", said, re.MULTILINE):
        raise Skipped(missing[1])
    rows = []
    for tracker, about in (("paper", "paper's"), ("robust", "robust (`--features robust`)")):
        found = re.search(rf"{tracker}: ([\d.]+) frames a second, at most ([\d.]+) pixels .*?{tracker}: (\d+) milliseconds.*?{tracker}: found again in ([\d.]+) s", said, re.DOTALL)
        if not found:
            raise Failed(f"`.ci/pico all` prints no figures of {tracker}")
        rows.append([about, *found.groups()])
    work = target_folder() / "pico"
    counts = json.loads(run(["node", work / "counts.mjs"], env=os.environ | {"SMR_PICO": str(work / "paper.elf")}))
    emulated, by_manual = estimated(str(work / "paper.elf"), counts)
    return {"cycles": f"{100 * abs(emulated / by_manual - 1):.1f}"}, {"all": rows}


TABLES = [Table("pico", "a Pico's firmware in an emulator", ("paper", "robust"), pico)]
