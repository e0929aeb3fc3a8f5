"""Recordings as they are read: gray, reduced, complete."""

import cv2
import numpy as np
import pytest

from refiner_training import boxes, recordings as found
from refiner_training.clips import Clip, Source


def test_colors_become_gray(tmp_path):
    path = tmp_path / "blue.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 25, (64, 48))
    video.write(np.full((48, 64, 3), (255, 0, 0), np.uint8))
    video.release()
    (frame,) = found.decoded(path)
    # 0.114 of 255.
    assert frame.mean() == pytest.approx(29, abs=2)


def test_frames_and_boxes_are_reduced_alike(recordings, tmp_path):
    recording = found.find([recordings / "Car1"])[0]
    recording.truth.write_text("10,10,66,66\n" * len(boxes.read(recording.truth)))
    assert recording.reduction() == 0.5
    frames = found.cached_frames(recording, tmp_path)
    clip = Clip(Source(recording.truth, frames, recording.truth, recording.reduction()))
    assert clip.frames.shape == (12, 48, 64)
    assert list(clip.truth[3]) == list(clip.tracked[3]) == [19, 19, 28, 28]
