"""`python -m smr.vot` with the client of the TraX protocol: its answers against those of `host-sim track`."""

import io
import os
import subprocess
import sys

import numpy
import pytest
import smr
from conftest import followed

trax = pytest.importorskip("trax", reason="skipped: tracker of the VOT toolkit: no vot-trax")
Image = pytest.importorskip("PIL.Image", reason="skipped: tracker of the VOT toolkit: no pillow")
from trax.client import Client  # noqa: E402

OWN = [sys.executable, "-m", "smr.vot"]
START = (36.0, 24.0, 24.0, 28.0)


def session(command, images, starts, length=1000):
    """The answers of one tracker for each frame: (x, y, width, height, confidence) of each object. It begins again after `length` frames."""
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        client = Client((server.stdin.fileno(), server.stdout.fileno()), log=os.devnull)
        answers = []
        for number, image in enumerate(images):
            channels = {"color": image}
            begin = number % length == 0
            found, _ = client.initialize(channels, [(start, {}) for start in starts], {}) if begin else client.frame(channels, {}, [])
            answers.append([(*region.bounds(), properties["confidence"]) for region, properties in found])
        client.quit()
        server.stdin.close()
        assert server.wait(timeout=20) == 0
    return answers


def tracked(track, pictures, inits, folder, *options, form="png"):
    """The answers of `host-sim track` on these pictures, as a session has them. A lost target stays where it was, with confidence 0."""
    folder.mkdir()
    for number, pixels in enumerate(pictures):
        (folder / f"{number:03}.{form}").write_bytes(encoded(pixels, form))
    inits = [word for number, init in enumerate(inits) for word in ("--init", f"t{number}={init}")]
    answers = {}
    for line in track(folder, *inits, *options):
        of = answers.setdefault(line["target"], [])
        found = line["fine"] or line["box"]
        box = found and tuple(found[side] for side in ("x", "y", "width", "height"))
        confidence = line["confidence"] if box and line["frame"] > 1 else float(bool(box))
        of.append((*(box or of[-1][:4]), round(confidence, 6)))
    return [list(frame) for frame in zip(*answers.values())]


def are_those(found, expected):
    """TraX has four decimals of a place."""
    return numpy.allclose(numpy.array(found, float), numpy.array(expected), rtol=0, atol=1e-4)


def frames(count):
    return list(smr.Recording("synthetic"))[:count]


def colored(frame):
    """Colors whose rounding to gray matters."""
    shifted = frame.astype(int)[:, :, None] + numpy.array([3, 0, 7])
    return shifted.clip(0, 255).astype(numpy.uint8)


def encoded(pixels, form):
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format=form)
    return file.getvalue()


def as_images(way, pictures, folder):
    """`way` is `memory`, or how a picture in a format comes: `path png`, `buffer jpeg`."""
    way, _, form = way.partition(" ")
    for number, pixels in enumerate(pictures):
        if way == "memory":
            yield trax.MemoryImage.create(pixels)
        elif way == "buffer":
            yield trax.BufferImage.create(encoded(pixels, form))
        else:
            file = folder / f"{number}.{form}"
            file.write_bytes(encoded(pixels, form))
            yield trax.FileImage.create(str(file))


def rectangle():
    return trax.Rectangle.create(*START)


def polygon():
    x, y, width, height = START
    return trax.Polygon.create([(x, y + 3), (x + width, y), (x + width, y + height), (x + 5, y + height)])


def mask():
    pixels = numpy.zeros((40, 30), numpy.uint8)
    pixels[4:32, 6:30] = 1
    return trax.Mask.create(pixels, 30, 20)


@pytest.mark.parametrize("way, change, region", [
    ("path png", colored, rectangle),
    ("path jpeg", colored, polygon),
    ("memory", colored, polygon),
    ("memory", lambda frame: frame, rectangle),
    ("memory", lambda frame: frame.astype(numpy.uint16) * 256 + 200, rectangle),
    ("buffer png", lambda frame: frame, polygon),
    ("buffer jpeg", lambda frame: frame, rectangle),
])  # fmt: skip
def test_answers_are_those_of_host_sim(track, tmp_path, way, change, region):
    pictures = [change(frame) for frame in frames(12)]
    expected = tracked(track, pictures, ["36,24,24,28"], tmp_path / "pictures", form="jpeg" if "jpeg" in way else "png")
    assert are_those(session(OWN, as_images(way, pictures, tmp_path), [region()]), expected)
    assert len({answer for [answer] in expected}) > 5


def test_a_target_that_the_paper_loses_stays_where_it_was_seen_last(track, tmp_path):
    found = session([*OWN, "--paper"], as_images("memory", frames(200), None), [rectangle()])
    assert are_those(found, tracked(track, frames(200), ["36,24,24,28"], tmp_path / "pictures", "--method", "paper", "--config", "camera"))
    confidences = [float(answer[4]) for [answer] in found]
    lost = confidences.index(0.0)
    assert found[lost][0][:4] == found[lost - 1][0][:4]


def test_two_objects_and_a_second_session(track, tmp_path):
    images = list(as_images("memory", frames(6), None)) * 2
    starts = [rectangle(), trax.Rectangle.create(-4, 70.4, 40, 30)]
    found = session(OWN, images, starts, 6)
    assert are_those(found[:6], tracked(track, frames(6), ["36,24,24,28", "0,70,36,30"], tmp_path / "pictures"))
    assert [len(answers) for answers in found] == [2] * 12
    assert found[6:] == found[:6]


def test_a_mask_is_followed_by_the_box_around_it():
    images = list(as_images("memory", frames(5), None))
    found = session(OWN, images, [mask()])
    assert found == session(OWN, images, [rectangle()])
    assert found[0] == [(*START, "1.000000")]
    for [(*place, confidence)], answer in zip(found[1:], followed(smr.Robust(), frames(5), START)):
        assert place == pytest.approx(answer.fine_box, abs=1e-3)
        assert confidence == f"{answer.confidence:.6f}"


@pytest.mark.parametrize("messages, reason", [
    ('@@TRAX:frame "file:///1.png"\n', "frame before initialize: there is nothing to follow"),
    ('@@TRAX:initialize "0"\n@@TRAX:frame "file://PICTURE"\n', "a region without a place: expected a rectangle, a polygon or a mask"),
    ('@@TRAX:initialize "500,1,9,9"\n@@TRAX:frame "file://PICTURE"\n', "the box 500,1,9,9 (x,y,width,height) has no pixel in the frame"),
    ('@@TRAX:initialize "1,1,9,9"\n@@TRAX:frame "file:///no/such.png"\n', "cannot open /no/such.png: "),
    (f'@@TRAX:initialize "1,1,9,9"\n@@TRAX:frame "file://{__file__}"\n', "ffmpeg "),
])  # fmt: skip
def test_the_client_hears_what_is_wrong(tmp_path, messages, reason):
    picture = tmp_path / "1.png"
    picture.write_bytes(encoded(frames(1)[0], "PNG"))
    messages = messages.replace("PICTURE", str(picture))
    ran = subprocess.run(OWN, input=messages, capture_output=True, text=True, timeout=20)
    assert ran.returncode == 2
    assert ran.stderr.startswith(f"error: {reason}") and ran.stderr.count("\n") == 1
    assert f'@@TRAX:quit "trax.reason={reason}' in ran.stdout


def test_a_client_that_has_gone_is_one_line():
    ran = subprocess.run(OWN, input="", capture_output=True, text=True, timeout=20)
    assert (ran.returncode, ran.stderr) == (2, "error: the client has gone without quit, or does not speak TraX\n")


def test_the_vot_toolkit_runs_it(tmp_path):
    pytest.importorskip("vot", reason="skipped: the VOT toolkit itself: no vot-toolkit")
    (tmp_path / "trackers.ini").write_text(f"[smr]\nlabel = smr\nprotocol = trax\ncommand = {' '.join(OWN)}\n")
    # Redirects the toolkit's check for a newer version to an address without a server.
    environment = {**os.environ, "https_proxy": "http://127.0.0.1:9"}
    command = [sys.executable, "-m", "vot", "test", "smr"]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
    assert "Test concluded successfuly" in ran.stdout + ran.stderr
    assert (ran.stdout + ran.stderr).count("@@TRAX:state") >= 50
