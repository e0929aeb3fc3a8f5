"""The examples of the README run as they stand."""

import pathlib
import re

import pytest
import smr

README = pathlib.Path(__file__).parents[1] / "README.md"


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
    # What a person would drag.
    monkeypatch.setattr(cv2, "selectROI", lambda frame: tuple(map(int, box)), raising=False)
    names, blocks = {}, re.findall(r"^```python\n(.*?)^```", README.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 3
    for block in blocks:
        exec(block, names)
        if names["frame"] is None:
            # The video has ended. The next example goes on with its last frame.
            assert names["ok"] and smr.Recording("synthetic").truth[39][0] == pytest.approx(names["box"].x, abs=3)
            names["frame"] = colors[-1]
    assert names["table"]["tracker"] == ["robust", "paper"] and names["table"]["f"][0] > 0.9
