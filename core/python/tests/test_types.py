"""The examples of the README, and calls beyond them, are right for mypy and pyright."""

import pathlib
import re
import subprocess
import sys

import pytest

README = pathlib.Path(__file__).parents[1] / "README.md"
CALLS = """
import numpy as np
from typing import Optional

group = smr.Group(2)
group.add(smr.Robust("robust", reach=5), frame, (1, 2, 3, 4))
group.add(smr.Paper(window=(8, 8)), frame, np.array([1.5, 2, 3, 4]))
all_there, boxes = group.update(frame)
answers: list[smr.Answer] = group.follow(frame)
group.remove(group.trackers[0])
x, y, width, height = boxes[0]
certain: bool = answers[0].state not in (smr.State.LOST, smr.State.UNCERTAIN)
restored: smr.Tracker = smr.restore(saved)
alike = smr.Robust(**smr.Robust().options)
window: Optional[smr.Box] = restored.window()
f: list[float] = smr.evaluate(["synthetic"], {"one": smr.Robust()}, starts="near")["f"]
recording = smr.Recording("synthetic", color=True)
for color in recording:
    restored.update(color)
score = recording.score([(1, 2, 3, 4), None])
"""


@pytest.mark.parametrize("checker", [["mypy", "--strict"], ["pyright", "--pythonpath", sys.executable]], ids=["mypy", "pyright"])
def test_a_type_checker_finds_no_error(checker, tmp_path):
    for name in (checker[0], "cv2"):
        pytest.importorskip(name, reason=f"no {name}")
    program = [sys.executable, "-m", *checker]
    # The module pyright fetches its program once.
    if subprocess.run([*program, "--version"], capture_output=True, timeout=300).returncode != 0:
        pytest.skip(f"{checker[0]} cannot be fetched")
    blocks = re.findall(r"^```python\n(.*?)^```", README.read_text(), re.MULTILINE | re.DOTALL)
    file = tmp_path / "example.py"
    file.write_text("".join(blocks) + CALLS)
    ran = subprocess.run([*program, str(file)], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert ran.returncode == 0, ran.stdout + ran.stderr
