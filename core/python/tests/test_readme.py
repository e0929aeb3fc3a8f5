"""The examples of the README run as they stand, and mypy and pyright find no error in them nor in calls beyond them."""

import pathlib
import re
import subprocess
import sys

import pytest
import smr

README = pathlib.Path(__file__).parents[1] / "README.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", README.read_text(), re.MULTILINE | re.DOTALL)
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
last: Optional[smr.Answer] = restored.answer
rows = [one.row() for one in answers]
left, top, right, bottom = answers[0].fine_box.xyxy
alike = smr.Robust(**smr.Robust().options)
window: Optional[smr.Box] = restored.window()
f: list[float] = smr.evaluate(["synthetic"], {"one": smr.Robust()}, starts="near")["f"]
recording = smr.Recording("synthetic", color=True)
for color in recording:
    restored.update(color)
score = recording.score([(1, 2, 3, 4), None])
camera = smr.Recording(0)
count, rate, size = len(camera), camera.fps or 25.0, camera.size or (1, 1)
"""


def test_examples_run(monkeypatch, tmp_path, synthetic):
    cv2 = pytest.importorskip("cv2", reason="no OpenCV")
    frames, box = synthetic
    colors = [cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR) for frame in frames[:40]]
    height, width = frames[0].shape
    video = cv2.VideoWriter(str(tmp_path / "video.mp4"), cv2.VideoWriter_fourcc(*"mp4v"), 25, (width, height))
    for color in colors:
        video.write(color)
    video.release()
    monkeypatch.chdir(tmp_path)
    # `selectROI` returns the target's box, in place of one that a person draws.
    monkeypatch.setattr(cv2, "selectROI", lambda frame: tuple(map(int, box)), raising=False)
    names = {}
    assert len(BLOCKS) == 4
    for block in BLOCKS:
        exec(block, names)
        if names["frame"] is None:
            # A block that reads the video to its end leaves `frame` None: the next block gets the last frame.
            assert names["ok"] and smr.Recording("synthetic").truth[39][0] == pytest.approx(names["box"].x, abs=3)
            names["frame"] = colors[-1]
    assert names["table"]["tracker"] == ["robust", "paper"] and names["table"]["f"][0] > 0.9


@pytest.mark.parametrize("checker", [["mypy", "--strict"], ["pyright", "--pythonpath", sys.executable]], ids=["mypy", "pyright"])
def test_a_type_checker_finds_no_error(checker, tmp_path):
    for name in (checker[0], "cv2"):
        pytest.importorskip(name, reason=f"no {name}")
    program = [sys.executable, "-m", *checker]
    # At its first run, the module pyright downloads its program.
    if subprocess.run([*program, "--version"], capture_output=True, timeout=300).returncode != 0:
        pytest.skip(f"{checker[0]} cannot be fetched")
    file = tmp_path / "example.py"
    file.write_text("# pyright: strict, reportUnusedExpression=false, reportUnnecessaryComparison=false\n" + "".join(BLOCKS) + CALLS)
    ran = subprocess.run([*program, str(file)], capture_output=True, text=True, cwd=tmp_path, timeout=300)
    assert ran.returncode == 0, ran.stdout + ran.stderr
