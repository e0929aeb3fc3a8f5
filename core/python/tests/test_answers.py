"""Checks that every answer equals that of host-sim."""

import copy
import os
import pathlib
import pickle
import shutil
import subprocess

import numpy as np
import pytest
import smr
from conftest import followed, recorded

# The trackers, and the options of host-sim for each.
TRACKERS = {
    "robust": (smr.Robust, []),
    "robust with options": (lambda: smr.Robust(reach=5, patience=200, sweep=0), ["--set=reach=5", "--set=patience=200", "--set=sweep=0"]),
    "robust without the refiner": (lambda: smr.Robust(refiner=False), ["--set=refiner=off"]),
    "the preset robust": (lambda: smr.Robust("robust"), ["--config=robust"]),
    "small": (lambda: smr.Robust("small"), ["--config=small"]),
    "small_refined with options": (lambda: smr.Robust("small_refined", reach=6), ["--config=small-refined", "--set=reach=6"]),
    "camera": (smr.Paper, ["--method=paper", "--config=camera"]),
    "paper": (lambda: smr.Paper(preset="paper", k=(7, 20), runner_up_always=True), ["--method=paper", "--set=k=7/20", "--set=runner_up_always=on"]),
}  # fmt: skip
RECORDINGS = [
    *(pytest.param(name, id=name) for name in ("synthetic", "border", "periodic", "noise")),
    recorded("tld/06_car"),
    recorded("more/vot_bag"),
]
FRAMES = 100


def as_printed(number):
    return None if number is None else int(number * 1e6 + 0.5) / 1e6  # `round` takes a half to even


def as_json(answer):
    """The fields of an answer as host-sim prints them."""
    lost = answer.state == smr.State.LOST
    return {
        "state": answer.state.value,
        "box": None if lost else answer.box._asdict(),
        "fine": None if lost else answer.fine_box._asdict(),
        "confidence": as_printed(answer.confidence),
        "ratio": as_printed(answer.ratio),
        "runner_up_ratio": as_printed(answer.runner_up_ratio),
        "alpha": answer.alpha,
        "identity": as_printed(answer.identity),
        "scale": as_printed(answer.scale),
        "found_again": answer.found_again,
    }


@pytest.mark.parametrize("tracker", TRACKERS)
@pytest.mark.parametrize("path", RECORDINGS)
def test_answers_are_those_of_host_sim(path, tracker, track):
    make, options = TRACKERS[tracker]
    tracker, recording = make(), smr.Recording(path)
    expected = track(path, *options, f"--frames=1..{FRAMES}")
    for number, (frame, line) in enumerate(zip(recording, expected)):
        if number == 0:
            tracker.init(frame, recording.start)
            assert as_printed(tracker.quality) == line["quality"]
        else:
            answer = as_json(tracker.follow(frame))
            assert answer == {key: line[key] for key in answer}, f"frame {number + 1}"
    assert number + 1 == len(expected) >= 10


@pytest.mark.parametrize("make", [smr.Robust, smr.Paper])
def test_update_is_follow_in_short(make, synthetic):
    frames, box = synthetic
    one, other = make(), make()
    one.init(frames[0], box)
    for frame, answer in zip(frames[1:], followed(other, frames[:40], box)):
        ok, place = one.update(frame)
        assert (ok, place) == (answer.state != smr.State.LOST, answer.box)
        assert type(ok) is bool and all(type(number) is int for number in place)
        assert one.answer == answer and answer.box.xyxy == (*place[:2], place.x + place.width, place.y + place.height)
        names = ("state", *smr.FineBox._fields, *smr.Answer._fields[3:])
        assert tuple(answer.row().items()) == tuple(zip(names, (answer.state.value, *answer.fine_box, *answer[3:])))
    assert other.answer == one.answer
    one.restore(other.save())
    other.init(frames[40], box)
    assert one.answer is other.answer is make().answer is None


def layouts(gray):
    """The picture in other layouts of memory."""
    height, width = gray.shape
    wide = np.zeros((height + 5, width + 9), np.uint8)
    wide[3:-2, 4:-5] = gray
    double = np.repeat(np.repeat(gray, 2, axis=0), 2, axis=1)
    read_only = gray.copy()
    read_only.flags.writeable = False
    bgr = np.repeat(gray[:, :, None], 3, axis=2)
    return {
        "part of a picture": wide[3:-2, 4:-5],
        "every second pixel": double[::2, ::2],
        "every second row": np.repeat(gray, 2, axis=0)[::2],
        "flipped": np.ascontiguousarray(gray[::-1, ::-1])[::-1, ::-1],
        "columns first": np.asfortranarray(gray),
        "read-only": read_only,
        "one channel": gray[:, :, None],
        "BGR": bgr,
        "BGR, flipped": np.ascontiguousarray(bgr[::-1])[::-1],
        "BGR, planes": np.ascontiguousarray(bgr.transpose(2, 0, 1)).transpose(1, 2, 0),
        "BGR, repeated gray": np.broadcast_to(gray[:, :, None], bgr.shape),
        "no copy of a buffer": np.frombuffer(gray.tobytes(), np.uint8).reshape(gray.shape),
    }


@pytest.mark.parametrize("make", [smr.Robust, smr.Paper])
def test_layouts_change_nothing(make, synthetic):
    frames, box = synthetic
    expected = followed(make(), frames[:60], box)
    for name in layouts(frames[0]):
        assert followed(make(), [layouts(frame)[name] for frame in frames[:60]], box) == expected, name


def test_lost_targets_are_swept_for_in_color(synthetic):
    # A lost target has a second window, whose pixels must be converted as well.
    frames, box = synthetic
    gray, color = smr.Robust(), smr.Robust()
    gray.init(frames[0], box)
    color.init(np.repeat(frames[0][:, :, None], 3, axis=2), box)
    noise, swept = np.random.default_rng(1), 0
    for _ in range(60):
        frame = noise.integers(0, 256, frames[0].shape, np.uint8)
        swept += gray.sweep_window() is not None
        assert color.follow(np.repeat(frame[:, :, None], 3, axis=2)) == gray.follow(frame)
        assert color.sweep_window() == gray.sweep_window()
    assert swept > 10


def test_a_target_goes_on_wherever_it_is_copied(synthetic):
    frames, box = synthetic
    for make in (smr.Robust, smr.Paper, lambda: smr.Robust("robust", reach=4), lambda: smr.Robust("small", size=False), lambda: smr.Paper("paper", padding=3)):
        tracker = make()
        tracker.init(frames[0], box)
        for frame in frames[1:10]:
            tracker.follow(frame)
        other = make()
        other.restore(tracker.save())
        copies = [other, copy.copy(tracker), copy.deepcopy(tracker), pickle.loads(pickle.dumps(tracker))]
        assert [repr(one) for one in copies] == [repr(tracker)] * 4
        assert [type(one) for one in copies] == [type(tracker)] * 4
        expected = [tracker.follow(frame) for frame in frames[10:30]]
        for one in copies:
            assert [one.follow(frame) for frame in frames[10:30]] == expected
    fresh = pickle.loads(pickle.dumps(smr.Robust(reach=5)))
    assert fresh.options["reach"] == 5 and fresh.window() is None


def test_restore_finds_the_tracker(synthetic):
    frames, box = synthetic
    presets = ("refined", "robust", "small", "small_refined")
    for make in (*(lambda preset=preset: smr.Robust(preset) for preset in presets), smr.Paper, lambda: smr.Paper("paper")):
        tracker = make()
        tracker.init(frames[0], box)
        restored = smr.restore(tracker.save())
        assert repr(restored) == repr(tracker)
        assert restored.follow(frames[1]) == tracker.follow(frames[1])
    other = smr.Robust(reach=5)
    other.init(frames[0], box)
    with pytest.raises(ValueError, match="saved with another configuration: reach differs"):
        smr.restore(other.save())
    with pytest.raises(ValueError, match="saved with another configuration: refiner differs"):
        smr.Robust("robust", reach=5).restore(other.save())
    with pytest.raises(ValueError, match="saved by another tracker, or by one of another size"):
        smr.Robust("small_refined", reach=5).restore(other.save())
    for other in (smr.Robust("small", reach=5), smr.Paper(padding=7)):
        other.init(frames[0], box)
        with pytest.raises(ValueError, match="saved with another configuration: "):
            smr.restore(other.save())


def test_a_target_goes_on_in_c_and_back(tmp_path):
    library, compiler = os.environ.get("LIBSMR"), shutil.which("cc")
    if library is None or compiler is None:
        pytest.skip("restoring in C: no " + ("library: set LIBSMR" if library is None else "C compiler cc"))
    source, program = pathlib.Path(__file__).with_name("restore.c"), tmp_path / "restore"
    include = source.parents[2] / "c" / "include"
    libraries = ["-lpthread", "-ldl", "-lm"]
    subprocess.run([compiler, "-std=c99", f"-I{include}", source, library, *libraries, "-o", program], check=True)
    frame = np.random.default_rng(2).integers(0, 256, (15, 20), np.uint8).repeat(8, axis=0).repeat(8, axis=1)
    (tmp_path / "frame").write_bytes(frame.tobytes())
    for preset, words in [("robust", "SMR_OK -"), ("refined", "SMR_ERROR_OTHER_CONFIG refiner")]:
        tracker = smr.Robust(preset)
        tracker.init(frame, (40, 30, 40, 40))
        (tmp_path / "saved").write_bytes(tracker.save())
        files = [tmp_path / name for name in ("frame", "saved", "new")]
        said = subprocess.run([program, *files], check=True, capture_output=True, text=True).stdout
        assert said.strip() == words
    # Python saves the same bytes for this frame and box as the C program.
    tracker = smr.Robust("robust")
    tracker.init(frame, (40, 30, 40, 40))
    saved = (tmp_path / "new").read_bytes()
    assert saved == tracker.save()
    restored = smr.restore(saved)
    assert restored.options["preset"] == "robust" and restored.follow(frame) == tracker.follow(frame)


def test_the_window_moves_along(synthetic):
    frames, box = synthetic
    tracker = smr.Paper(window=(4, 4))
    assert tracker.window() is None and tracker.sweep_window() is None
    tracker.init(frames[0], box)
    x, y, width, height = tracker.window()
    tracker.moved(5.0, -3.0)
    assert tracker.window() == (x + 5, y - 3, width, height)


def test_a_group_answers_like_its_trackers(synthetic):
    frames, (x, y, width, height) = synthetic
    boxes = [(x, y, width, height), (x + 4, y + 6, 12, 12), (10, 60, 20, 20), (90, 70, 30, 24), (5, 5, 8, 8)]
    kinds = [smr.Robust, smr.Paper, smr.Robust, smr.Robust, smr.Paper]
    alone = [kind() for kind in kinds]
    groups = [smr.Group(threads) for threads in (1, 2, 16)]
    for tracker, box in zip(alone, boxes):
        tracker.init(frames[0], box)
        for group in groups:
            group.add(type(tracker)(), frames[0], box)
    for frame in frames[1:41]:
        expected = [tracker.follow(frame) for tracker in alone]
        assert frame is frames[40] or all(group.follow(frame) == expected for group in groups)
    ok, found = groups[1].update(frames[40])
    assert found == [answer.box for answer in expected]
    assert ok == all(answer.state != smr.State.LOST for answer in expected)
    assert [tracker.answer for tracker in groups[1].trackers] == expected and repr(groups[1]) == "<smr.Group of 5 trackers, 2 threads>"
    first = groups[1].trackers[0]
    groups[1].remove(first)
    assert len(groups[1]) == 4 and first.window() is not None
    assert smr.Group().follow(frames[0]) == []
