"""The names of the package: documented, typed, and like those of OpenCV."""

import ast
import inspect
import os
import pathlib

import numpy as np
import pytest
import smr

STUBS = pathlib.Path(smr.__file__).with_name("_smr.pyi")
SOURCE = pathlib.Path(__file__).parents[1] / "package/smr/_smr.pyi"


def with_texts(stubs):
    """The stubs with the documentation that the extension has at run time."""
    lines = stubs.splitlines()
    classes = [(smr, node) for node in ast.parse(stubs).body if isinstance(node, (ast.ClassDef, ast.FunctionDef))]
    members = [(getattr(smr._smr, node.name), member) for _, node in classes for member in node.body if isinstance(member, ast.FunctionDef)]
    nodes = [(smr._smr if owner is smr else owner, node) for owner, node in classes + members if not node.name.startswith("_")]
    for owner, node in sorted(nodes, key=lambda of: -of[1].lineno):
        first, end = node.body[0], node.lineno
        if isinstance(first, ast.Expr):  # What is there: a text, or `...`
            before, end = lines[first.lineno - 1][: first.col_offset], first.lineno
            lines[first.lineno - 1 : first.end_lineno] = [before.rstrip()] if before.strip() else []
            end -= not before.strip()
        indent = " " * (node.col_offset + 4)
        text = f'"""{inspect.getdoc(getattr(owner, node.name))}'.splitlines()
        lines[end:end] = [(indent + line).rstrip() for line in [*text[:-1], text[-1] + '"""' if len(text) == 1 else text[-1]]]
        if len(text) > 1:
            lines.insert(end + len(text), indent + '"""')
    return "\n".join(lines) + "\n"


def test_the_stubs_have_the_texts_of_the_extension():
    if os.environ.get("SMR_RECORD"):
        SOURCE.write_text(with_texts(SOURCE.read_text()))
    else:
        assert STUBS.read_text() == with_texts(STUBS.read_text())


def test_everything_is_documented_and_typed():
    typed = {node.name: node for node in ast.parse(STUBS.read_text()).body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    for name in set(dir(smr._smr)) - {"__all__"}:
        if name.startswith("__"):
            continue
        assert name in typed, name
        assert inspect.getdoc(getattr(smr._smr, name)), name
        if isinstance(typed[name], ast.ClassDef):
            members = {node.name for node in typed[name].body if isinstance(node, ast.FunctionDef)}
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
        new = next(member for member in node.body if getattr(member, "name", "") == "__new__")
        named = {argument.arg for argument in new.args.args[1:] + new.args.kwonlyargs}
        assert named == set(make().options) == set(inspect.signature(make).parameters)
        texts = [line.split("`")[1] for line in inspect.getdoc(make).splitlines() if line.startswith("- `")]
        assert sorted(texts) == sorted(named - {"preset"})
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
