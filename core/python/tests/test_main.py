"""`python -m smr` as a program, and its window with keys from a script instead of a user."""

import json
import subprocess
import sys

import numpy
import pytest
import smr
from conftest import followed, interrupted, refuses, run
from smr import __main__ as program

KEYS = ("frame", "state", "box", "fine", "confidence", "ratio", "identity", "scale", "found_again")


def lines(text):
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.parametrize("options, method", [([], ["robust"]), (["--paper"], ["paper", "--config", "camera"])])
def test_json_lines_are_those_of_host_sim(track, options, method):
    expected = [{key: line[key] for key in KEYS} for line in track("synthetic", "--method", *method)]
    assert any(line["state"] == "lost" for line in expected) or method == ["robust"]
    assert lines(run("smr", "synthetic", "--json", *options).stdout) == expected


def test_text_has_a_line_for_each_frame():
    ran = run("smr", "synthetic", "--box", "35.5,24.4,24,28")
    assert (ran.returncode, ran.stderr) == (0, "")
    printed = ran.stdout.splitlines()
    assert len(printed) == 240
    assert printed[0] == "1 tracking 36,24,24,28"
    (answer,) = followed(smr.Robust(), list(smr.Recording("synthetic"))[:2], (36, 24, 24, 28))
    assert printed[1] == f"2 tracking {','.join(map(str, answer.box))} {answer.confidence:.6f}"


@pytest.mark.parametrize("arguments, reason", [
    (["/no/such.mp4"], "cannot open /no/such.mp4: "),
    ([__file__, "--box", "1,1,9,9"], "ffmpeg "),
    (["synthetic", "--box", "5,5,0,9"], "the box has no pixels: 5,5,0,9"),
    *((["synthetic", "--box", box], f"--box: expected X,Y,W,H, four numbers, found {box}") for box in ("5,5,9", "5,5,9,x")),
    (["synthetic", "--box", "500,5,9,9"], "the box 500,5,9,9 "),
    (["99", "--box", "5,5,9,9"], "ffmpeg "),
    (["PICTURES"], "there is no window to select a box in: expected --box X,Y,W,H\n"),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, arguments, reason):
    (tmp_path / "1.pgm").write_bytes(b"P5\n64 48\n255\n" + bytes(64 * 48))
    refuses(["smr", *(str(tmp_path) if word == "PICTURES" else word for word in arguments)], reason)


def test_a_closed_pipe_ends_it_quietly():
    command = [sys.executable, "-m", "smr", "synthetic"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout.readline().startswith("1 tracking")
        running.stdout.close()
        assert (running.wait(timeout=30), running.stderr.read()) == (0, "")


def test_an_interrupt_ends_it_quietly():
    endless = "frames, own = list(smr.Recording('synthetic')), {'start': (36, 24, 24, 28), 'is_live': True}\n" \
        "own['__iter__'] = lambda self: itertools.cycle(frames)\n" \
        "smr.Recording = lambda source, color: type('', (), own)()"  # fmt: skip
    code, _, said = interrupted(lambda running: [running.stdout.readline() for _ in range(300)], "smr", "synthetic", before=endless)
    assert (code, said) == (130, "")


class Keys:
    """In place of a window: keys by the number of the frame, and the boxes that a user draws."""

    def __init__(self, keys, boxes):
        self.keys, self.boxes, self.shown = keys, boxes, []

    def select(self, _frame):
        return self.boxes.pop(0)

    def show(self, _frame, answer):
        self.shown.append(answer)
        return self.keys.get(len(self.shown), "")


def test_r_selects_again_and_q_ends(capsys):
    frames = list(smr.Recording("synthetic"))
    window = Keys({3: "r", 5: "r", 9: "q"}, [(36, 24, 24, 28), (10, 10, 20, 20), None])
    program.follow(frames, smr.Robust(), None, window, program.text)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == len(window.shown) == 9
    assert window.boxes == []
    # The target is the box drawn in frame 3, even after a later selection was cancelled.
    assert window.shown[3:] == followed(smr.Robust(), frames[2:9], (10, 10, 20, 20))


@pytest.mark.parametrize("shape", [(48, 64), (48, 64, 3)])
def test_the_window_draws_into_a_copy(monkeypatch, shape):
    cv2 = pytest.importorskip("cv2", reason="skipped: window of python -m smr: no OpenCV")
    pictures = []
    monkeypatch.setattr(cv2, "imshow", lambda _name, picture: pictures.append(picture))
    monkeypatch.setattr(cv2, "waitKey", lambda _milliseconds: ord("r"))
    monkeypatch.setattr(cv2, "getWindowProperty", lambda _name, _property: 1.0)
    frame, box = numpy.zeros(shape, numpy.uint8), smr.Box(8, 30, 20, 10)
    answer = smr.Answer(box, box, smr.State.LOST, 0.25, 0.5, None, None, None, 1.0, False)
    window = program.Window(1)
    assert window.show(frame, answer) == "r"
    assert not frame.any()
    assert tuple(pictures[0][30, 15]) == program.COLORS[smr.State.LOST]
    monkeypatch.setattr(cv2, "getWindowProperty", lambda _name, _property: 0.0)
    assert window.show(frame, answer) == "q"


@pytest.mark.parametrize("drawn, expected", [((0, 0, 0, 0), None), ((3, 4, 5, 6), (3, 4, 5, 6))])
def test_a_selection_that_is_given_up_is_none(monkeypatch, capsys, drawn, expected):
    cv2 = pytest.importorskip("cv2", reason="skipped: window of python -m smr: no OpenCV")
    monkeypatch.setattr(cv2, "selectROI", lambda _name, _frame, showCrosshair, printNotice: drawn)
    assert program.Window(1).select(numpy.zeros((9, 9), numpy.uint8)) == expected
    said = capsys.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)


def test_a_video_file_is_followed_in_color(tmp_path):
    cv2 = pytest.importorskip("cv2", reason="skipped: python -m smr on a video: no OpenCV")
    path = str(tmp_path / "video.avi")
    frames = list(smr.Recording("synthetic"))[:20]
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), 25, frames[0].shape[::-1])
    if not writer.isOpened():
        pytest.skip("skipped: python -m smr on a video: this OpenCV writes no AVI")
    for frame in frames:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    recording = smr.Recording(path)
    assert (recording.size, recording.fps, len(recording)) == ((160, 120), pytest.approx(25, abs=0.1), 20)
    ran = run("smr", path, "--box", "36,24,24,28", "--json")
    assert (ran.returncode, ran.stderr) == (0, "")
    # A program like those that users of OpenCV write.
    capture = cv2.VideoCapture(path)
    answers = followed(smr.Robust(), [capture.read()[1] for _ in frames], (36, 24, 24, 28))
    assert [line["fine"] for line in lines(ran.stdout)[1:]] == [answer.fine_box._asdict() for answer in answers]
