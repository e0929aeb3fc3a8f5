"""Recordings as they are read: gray, reduced, complete; boxes, their files, and what the network learns."""

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
    # Gray is 0.114 * blue = 0.114 * 255 here.
    assert frame.mean() == pytest.approx(29, abs=2)


def test_frames_and_boxes_are_reduced_alike(recordings, tmp_path):
    recording = found.find([recordings / "Car1"])[0]
    recording.truth.write_text("10,10,66,66\n" * len(boxes.read(recording.truth)))
    assert recording.reduction() == 0.5
    frames = found.cached_frames(recording, tmp_path)
    clip = Clip(Source(recording.truth, frames, recording.truth, recording.reduction()))
    assert clip.frames.shape == (12, 48, 64)
    assert list(clip.truth[3]) == list(clip.tracked[3]) == [19, 19, 28, 28]


def test_a_correction_leads_to_the_truth():
    box, truth = np.array([10.0, 20, 8, 4]), np.array([12.0, 19, 10, 6])
    change = boxes.correction(box, truth)
    assert change[:2] == pytest.approx([0.25, -0.25])
    assert boxes.corrected(box, change) == pytest.approx(truth, rel=1e-6)


def test_a_file_has_a_box_or_none_a_line(tmp_path):
    (tmp_path / "gt.txt").write_text("1,2,5,10\nNaN,NaN,NaN,NaN\n\n1 2 3\nx,y,z,w\n")
    first, *others = boxes.read(tmp_path / "gt.txt")
    assert list(first) == [3, 6, 4, 8]
    assert others == [None, None, None]


def test_overlap():
    box = np.array([0.0, 0, 2, 2])
    assert boxes.intersection_over_union(box, box) == 1
    assert boxes.intersection_over_union(box, box + [1, 0, 0, 0]) == pytest.approx(1 / 3)
    assert boxes.intersection_over_union(box, box + [2, 0, 0, 0]) == 0


def test_answers_are_aligned_to_the_start():
    answers = [None, np.array([10.0, 10, 4, 8]), np.array([12.0, 10, 6, 8])]
    lost, first, second = boxes.aligned(answers, np.array([11.0, 10, 8, 8]))
    assert lost is None
    assert list(first) == [11, 10, 8, 8]
    assert list(second) == [13, 10, 12, 8]
