"""Recordings in which targets leave and come back elsewhere.

Each recording is played forward, backward and forward again, at most 160 frames each time. Between the plays 40 frames of another recording
are shown. The second and third play are shifted by at most a quarter of the picture's sides; edges are repeated.
"""

import hashlib
import shutil
import subprocess

from .programs import Skipped

MOST_FRAMES, GONE, AT_ONCE = 160, 40, 10
HIDDEN = "NaN,NaN,NaN,NaN"


def decoded(path, numpy):
    """The first frames of a recording, gray."""
    video = next((file for file in sorted(path.iterdir()) if file.suffix in (".mp4", ".mpg")), None)
    if video is None:
        raise Skipped(f"no video in {path.name}")
    probe = ["ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries", "stream=width,height", "-of", "csv=p=0", video]
    width, height = map(int, subprocess.run(probe, capture_output=True, text=True, check=True).stdout.strip().split(",")[:2])
    decode = ["ffmpeg", "-nostdin", "-v", "error", "-i", video, "-frames:v", str(MOST_FRAMES), "-pix_fmt", "gray", "-fps_mode", "passthrough", "-f", "rawvideo", "-"]
    pixels = subprocess.run(decode, stdout=subprocess.PIPE, check=True).stdout
    return list(numpy.frombuffer(pixels, numpy.uint8).reshape(-1, height, width))


def moved(box, right, down, width, height):
    """The shifted box of a line of truth, or `HIDDEN` if less than half of it is in the picture."""
    sides = [float(value) for value in box.replace(";", ",").split(",")[:4]]
    if any(value != value for value in sides):
        return HIDDEN
    left, top, end, bottom = sides[0] + right, sides[1] + down, sides[2] + right, sides[3] + down
    seen = [min(end, width) - max(left, 0), min(bottom, height) - max(top, 0)]
    is_seen = min(seen) > 0 and seen[0] * seen[1] > (end - left) * (bottom - top) / 2
    return f"{left},{top},{end},{bottom}" if is_seen else HIDDEN


def make(path, other, out, numpy, image):
    """Writes one recording of returns to the folder `out`."""
    random = numpy.random.default_rng(int(hashlib.md5(path.name.encode()).hexdigest()[:8], 16))
    truth = [line.strip() for line in (path / "gt.txt").read_text().splitlines() if line.strip()]
    pictures = decoded(path, numpy)
    count = min(len(pictures), len(truth), MOST_FRAMES)
    height, width = pictures[0].shape
    gone = [numpy.asarray(image.fromarray(frame).resize((width, height))) for frame in decoded(other, numpy)[:GONE]]
    gone = (gone * GONE)[:GONE]
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    lines = []

    def put(picture, line):
        (out / f"{len(lines):05}.pgm").write_bytes(f"P5\n{width} {height}\n255\n".encode() + picture.tobytes())
        lines.append(line)

    for play in range(3):
        right, down = (0, 0) if play == 0 else (int(random.integers(-side // 4, side // 4 + 1)) for side in (width, height))
        rows, columns = (numpy.clip(numpy.arange(side) - by, 0, side - 1) for side, by in ((height, down), (width, right)))
        for frame in range(count) if play % 2 == 0 else range(count - 1, -1, -1):
            put(pictures[frame][numpy.ix_(rows, columns)], moved(truth[frame], right, down, width, height))
        if play < 2:
            for picture in gone:
                put(picture, HIDDEN)
    (out / "gt.txt").write_text("\n".join(lines) + "\n")
    if (path / "init.txt").exists():
        shutil.copyfile(path / "init.txt", out / "init.txt")


def make_returns(programs, paths, folder):
    """Yields folders of recordings, a few at a time, because they are large."""
    try:
        import numpy
        from PIL import Image
    except ImportError as missing:
        raise Skipped(f"{missing}: pip install numpy pillow") from None
    if not shutil.which("ffmpeg"):
        raise Skipped("no ffmpeg")
    # The scene of the absence is that of the seventh recording after, in the order of all recordings.
    every = sorted((path for name in ("tld", "more", "many") for path in (programs.sequences / name).iterdir() if (path / "gt.txt").exists()), key=lambda path: path.name)
    for first in range(0, len(paths), AT_ONCE):
        shutil.rmtree(folder, ignore_errors=True)
        made = []
        for path in paths[first : first + AT_ONCE]:
            path = programs.sequences.parent / path
            other = every[(every.index(path) + 7) % len(every)]
            make(path, other, folder / path.name, numpy, Image)
            made.append(str(folder / path.name))
        yield made
