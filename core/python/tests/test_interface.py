"""The names of the package: documented, typed, and like those of OpenCV."""

import ast
import inspect
import pathlib

import numpy as np
import pytest
import smr

STUBS = pathlib.Path(smr.__file__).with_name("_smr.pyi")


def test_everything_is_documented_and_typed():
    typed = {node.name: node for node in ast.parse(STUBS.read_text()).body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    for name in set(dir(smr._smr)) - {"__all__"}:
        if name.startswith("__"):
            continue
        assert name in typed, name
        assert inspect.getdoc(getattr(smr._smr, name)), name
        if isinstance(typed[name], ast.ClassDef):
            members = {node.name for node in typed[name].body}
            public = {member for member in vars(getattr(smr._smr, name)) if not member.startswith("_")}
            assert public <= members, public - members
            for member in public:
                assert inspect.getdoc(getattr(getattr(smr._smr, name), member)), member
    for name in smr.__all__:
        assert inspect.getdoc(getattr(smr, name)), name
    assert STUBS.with_name("py.typed").exists()


def test_options_are_those_of_the_stubs():
    tree = ast.parse(STUBS.read_text())
    for make in (smr.Paper, smr.Robust):
        (node,) = (node for node in tree.body if getattr(node, "name", "") == make.__name__)
        new = next(member for member in node.body if member.name == "__new__")
        named = {argument.arg for argument in new.args.args[1:] + new.args.kwonlyargs}
        assert named == set(make().options)
        assert make(**make().options).options == make().options


def test_a_drop_in_for_opencv(synthetic):
    cv2 = pytest.importorskip("cv2", reason="no OpenCV")
    frames, box = synthetic
    box = tuple(map(int, box))
    trackers = [cv2.TrackerCSRT_create(), smr.Robust(), smr.Paper()]
    for tracker in trackers:
        picture = cv2.cvtColor(frames[0], cv2.COLOR_GRAY2BGR)
        assert tracker.init(picture, box) is None
    for frame in frames[1:10]:
        picture = cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
        answers = [tracker.update(picture) for tracker in trackers]
        assert all(ok is True and len(place) == 4 for ok, place in answers)
        for _, place in answers:
            cv2.rectangle(picture, place, (0, 255, 0))


def test_gray_is_that_of_opencv():
    cv2 = pytest.importorskip("cv2", reason="no OpenCV")
    random = np.random.default_rng(9)
    still = np.random.default_rng(4).integers(0, 256, (90, 120, 3), np.uint8)
    for make in (smr.Robust, smr.Paper):
        color, gray = make(), make()
        color.init(still, (30, 30, 40, 30))
        gray.init(cv2.cvtColor(still, cv2.COLOR_BGR2GRAY), (30, 30, 40, 30))
        for _ in range(50):
            frame = np.roll(still, random.integers(-3, 4, 2), axis=(0, 1)).astype(int)
            frame = np.clip(frame + random.integers(-40, 40, frame.shape), 0, 255).astype(np.uint8)
            assert color.follow(frame) == gray.follow(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY))
        assert color.save() == gray.save()
