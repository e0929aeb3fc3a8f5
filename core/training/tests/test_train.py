"""The command: recordings to weights, the same each time, and what it says of bad input."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from refiner_training import recordings as found
from refiner_training import weights

TRAIN = Path(__file__).parents[1] / "train.py"


@pytest.fixture
def train(recordings, host_sim, tmp_path):
    def run(*arguments, folder=recordings, program=host_sim, cache="cache"):
        small = ["--pairs", "600", "--cutouts", "300", "--others", "300", "--steps", "4", "--cache", tmp_path / cache]
        command = [sys.executable, TRAIN, *small, folder, *arguments, "--host-sim", program]
        return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)

    return run


def test_two_runs_give_the_same_bytes(train, tmp_path):
    first = train("--half", "a", "--out", tmp_path / "first.bin", "--processes", 1)
    second = train("--half", "a", "--out", tmp_path / "second.bin", "--processes", 2, cache="other")
    assert (first.returncode, first.stderr) == (second.returncode, second.stderr) == (0, "")
    assert first.stdout == second.stdout
    data = (tmp_path / "first.bin").read_bytes()
    assert data == (tmp_path / "second.bin").read_bytes()
    assert len(data) == weights.SIZE
    third = train("--half", "a", "--out", tmp_path / "third.bin", "--seed", 2)
    assert third.returncode == 0 and data != (tmp_path / "third.bin").read_bytes()


def test_the_recipe_and_the_report(train, tmp_path):
    done = train("--half", "b", "--out", tmp_path / "weights.bin")
    recipe = json.loads((tmp_path / "weights.json").read_text())
    assert recipe["half"] == "b" and recipe["steps"] == 4 and recipe["versions"]["host-sim"] == "host-sim 0"
    assert [recording["name"] for recording in recipe["recordings"]] == ["01_david", "Car1"]
    assert recipe["weights"]["sha256"] == hashlib.sha256((tmp_path / "weights.bin").read_bytes()).hexdigest()
    assert "on half a, whose recordings were not trained on" in done.stdout
    assert set(recipe["report"]["kinds"]) == {"pairs, random error", "pairs, the tracker's error", "cut-outs"}
    assert set(recipe["report"]["match"]) >= {"all", "beside", "resembling", "other piece"}
    # Only the cache remains; temporary files are deleted.
    assert sorted(path.name for path in (tmp_path / "cache").iterdir()) == ["frames", "tracked"]


def test_all_says_that_it_judges_what_it_trained_on(train, tmp_path):
    done = train("--out", tmp_path / "weights.bin")
    assert "held-out samples of the recordings trained on" in done.stdout


def test_halves(train, recordings):
    assert [found.half(name) for name in ("01_david", "Car1")] == ["b", "a"]
    assert train("--list-half", "a").stdout == f"{recordings / 'Car1'}\n"


def fails(done, *words):
    line = done.stderr.strip()
    assert done.returncode == 2 and done.stdout == "" and "\n" not in line, done
    assert line.startswith("error: ") and all(str(word) in line for word in words), line


def test_bad_input_gives_one_line(train, recordings, tmp_path):
    out = "--out", tmp_path / "weights.bin"
    fails(train(*out, folder=tmp_path / "nowhere"), "no folder", tmp_path / "nowhere")
    fails(train(*out, folder=recordings / "Car1", program="/nowhere/host-sim"), "no host-sim at /nowhere/host-sim", "--host-sim")
    fails(train("--half", "a", *out, folder=recordings / "Car1"), "half b has no recordings")
    fails(train("--out", tmp_path / "nowhere" / "weights.bin"), "no folder")
    empty = tmp_path / "empty"
    empty.mkdir()
    fails(train(*out, folder=empty), "no recordings in", empty)
    assert not (tmp_path / "weights.bin").exists()


def test_a_failing_host_sim_is_quoted(train, tmp_path):
    program = tmp_path / "failing"
    program.write_text("#!/bin/sh\necho 'error: no such thing' >&2\nexit 1\n")
    program.chmod(0o755)
    fails(train("--out", tmp_path / "weights.bin", program=program), "host-sim track", "error: no such thing")


@pytest.mark.parametrize("content", [b"", b"this is no video" * 100])
def test_an_unreadable_video(train, recordings, tmp_path, content):
    (recordings / "Car1" / "video.avi").write_bytes(content)
    fails(train("--out", tmp_path / "weights.bin"), recordings / "Car1" / "video.avi", "OpenCV reads 0 frames, gt.txt has 12 lines")


def test_bad_recordings(train, recordings, tmp_path):
    out = "--out", tmp_path / "weights.bin"
    truth = recordings / "Car1" / "gt.txt"
    lines = truth.read_text()
    truth.write_text("NaN,NaN,NaN,NaN\n" + lines)
    fails(train(*out), truth, "expected a box in the first line")
    truth.write_text(lines + "1,2,3,4\n")
    fails(train(*out), "OpenCV reads 12 frames, gt.txt has 13 lines")
    (recordings / "Car1" / "video.avi").unlink()
    fails(train(*out), "expected one video, found 0")
    truth.unlink()
    copied = shutil.copytree(recordings / "01_david", tmp_path / "others" / "01_david")
    fails(train(copied, *out), "two recordings are named 01_david")


def test_a_target_that_is_seen_once(train, recordings, tmp_path):
    truth = recordings / "Car1" / "gt.txt"
    lines = truth.read_text().splitlines()
    truth.write_text("\n".join([lines[0], *["NaN,NaN,NaN,NaN"] * (len(lines) - 1)]))
    fails(train("--half", "a", "--out", tmp_path / "weights.bin"), "no recording shows its target in two frames")


def test_bad_options(train, tmp_path):
    fails(train(), "--out FILE is missing")
    fails(train("--out", tmp_path / "weights.bin", "--steps", "none"), "--steps", "expected a whole number, 1 or more")
