"""`smr.got10k.SmrTracker` in the GOT-10k toolkit: its files of results against the boxes of host-sim."""

import numpy
import pytest
import smr
from conftest import followed, run

Image = pytest.importorskip("PIL.Image", reason="skipped: tracker of the GOT-10k toolkit: no pillow")
pytest.importorskip("got10k.trackers", reason="skipped: tracker of the GOT-10k toolkit: no got10k")

from smr._benchmark import inside  # noqa: E402
from smr.got10k import SmrTracker, gray  # noqa: E402

FRAMES = 120
TRACKERS = [(smr.Robust, ["robust"]), (smr.Paper, ["paper", "--config", "camera"])]


def as_png(picture):
    """Makes a JPEG a PNG of the same name: decoders of JPEG differ by a gray level here and there, those of PNG do not."""
    with Image.open(picture) as image:
        image.load()
    image.save(picture, format="PNG")


@pytest.mark.parametrize("kind, method", TRACKERS)
def test_result_files_have_the_boxes_of_host_sim(tmp_path, monkeypatch, host_sim, kind, method):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    from got10k.experiments import ExperimentGOT10k

    sequence = tmp_path / "data/val/synthetic"
    # A recording with frames in which `paper` loses the target.
    host_sim("convert", "synthetic", "--frames", f"{241 - FRAMES}..240", "--format", "got10k", "-o", str(sequence))
    for picture in sequence.glob("*.jpg"):
        as_png(picture)
    tracker = SmrTracker(kind(), name="smr")
    ExperimentGOT10k(tmp_path / "data", subset="val", result_dir=tmp_path, report_dir=tmp_path).run(tracker)

    results = (tmp_path / "GOT-10k/smr/synthetic/synthetic_001.txt").read_text().splitlines()
    expected = []
    for line in host_sim("track", str(sequence), "--method", *method, "--format", "vot").splitlines():
        # The line "0" is a lost target, for which the toolkit gets the box where the target was seen last.
        expected.append(expected[-1] if line == "0" else ",".join(f"{float(number):.3f}" for number in line.split(",")))
    assert len(results) == FRAMES
    assert results == expected


@pytest.mark.parametrize("kind, _method", TRACKERS)
def test_the_boxes_are_those_of_the_tracker(tmp_path, kind, _method):
    recording = smr.Recording("synthetic")
    frames, start = list(recording)[-FRAMES:], recording.truth[-FRAMES]
    files = [str(tmp_path / f"{number:08}.jpg") for number in range(len(frames))]
    for frame, file in zip(frames, files):
        Image.fromarray(frame).save(file, format="PNG")
    boxes, times = SmrTracker(kind()).track(files, start)
    assert times.shape == (len(frames),)

    expected = [start]
    for answer in followed(kind(), frames, start):
        expected.append(expected[-1] if answer.state == smr.State.LOST else answer.fine_box)
    assert (boxes == numpy.array(expected)).all()


def test_options_and_names():
    assert SmrTracker().name == "smr-robust"
    assert SmrTracker(smr.Paper()).name == "smr-paper"
    tracker = SmrTracker(smr.Paper(window=(4, 4)), name="narrow")
    assert (tracker.name, tracker.is_deterministic) == ("narrow", True)
    assert tracker._tracker.options["window"] == (4, 4)


def test_gray_is_that_of_host_sim_for_every_color_and_other_pictures(tmp_path):
    green, blue = numpy.mgrid[0:256, 0:256]
    for red in range(256):
        colors = numpy.stack([numpy.full_like(green, red), green, blue], axis=-1).astype(numpy.uint8)
        expected = (19595 * red + 38470 * green + 7471 * blue + 32768) >> 16
        assert (gray(Image.fromarray(colors)) == expected).all()
    values = numpy.arange(256, dtype=numpy.uint8).reshape(16, 16)
    pictures = {
        "gray": Image.fromarray(values),
        "alpha": Image.merge("LA", [Image.fromarray(values), Image.fromarray(values[::-1].copy())]),
        "palette": Image.fromarray(values).convert("P"),
    }
    for name, picture in pictures.items():
        picture.save(tmp_path / "1.png")
        with Image.open(tmp_path / "1.png") as opened:
            found = gray(opened)
        assert found.dtype == numpy.uint8 and (found == values).all(), name
        [of_host_sim] = smr.Recording(tmp_path)
        assert (of_host_sim == values).all(), name


def test_a_box_that_reaches_out_of_the_picture_is_cut():
    frame = numpy.zeros((12, 20), numpy.uint8)
    assert inside((-5, 2.4, 10, 30), frame) == (0, 2, 5, 10)
    assert inside((1.5, 2, 3, 4), frame) == (2, 2, 3, 4)
    for outside in [(30, 2, 3, 3), (1, 1, 0, 5), (-3, 1, 3, 4), (1, 1, 0.2, 5), (float("nan"), 1, 2, 3)]:
        with pytest.raises(ValueError, match=r"^the box .* has no pixel in the frame of 20x12 pixels$"):
            inside(outside, frame)


def test_without_six_it_says_what_to_install(tmp_path):
    (tmp_path / "six.py").write_text("raise ModuleNotFoundError('six', name='six')\n")
    ran = run("smr.got10k", PYTHONPATH=str(tmp_path), MPLBACKEND="Agg")
    assert ran.stderr.endswith("ImportError: there is no module six: pip install smr-tracker[got10k]\n")
