"""Recordings (folders with a video and `gt.txt`), their split into halves, and the cache of their reduced frames."""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

# Silences OpenCV, because the program itself reports an unreadable video in one line.
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

import cv2
import numpy as np

from . import boxes
from .errors import BadInput

VIDEOS = {".mp4", ".mpg", ".mpeg", ".avi", ".mkv", ".webm"}
# Frames are reduced until the target's first box has at most the area of a square with this side, in pixels. Each pixel
# of its crop then covers at most 2.4 frame pixels, so the frame is little finer than the crop.
TARGET_SIDE = 28


@dataclass(frozen=True)
class Recording:
    name: str
    folder: Path
    video: Path
    truth: Path
    digest: str  # SHA-256 of the video and the truth

    @property
    def half(self):
        return half(self.name)

    def reduction(self):
        """The factor by which frames and boxes are reduced, at most 1."""
        return min(1.0, TARGET_SIDE / boxes.side(self.start()))

    def start(self):
        return boxes.read(self.truth)[0]


def half(name):
    """`a` or `b`, by a hash of the name, so that a new recording does not change the halves of others."""
    return "ab"[hashlib.md5(name.encode()).digest()[0] & 1]


def find(folders):
    """Finds recordings: each folder is a recording or contains some. Sorted by name."""
    found = {}
    for folder in map(Path, folders):
        if not folder.is_dir():
            raise BadInput(f"no folder {folder}")
        for truth in [*folder.glob("gt.txt"), *folder.glob("*/gt.txt")]:
            recording = opened(truth)
            if recording.name in found:
                raise BadInput(f"two recordings are named {recording.name}: {found[recording.name].folder} and {recording.folder}")
            found[recording.name] = recording
    if not found:
        raise BadInput(f"no recordings in {', '.join(map(str, folders))}: expected folders with a video and gt.txt")
    return [found[name] for name in sorted(found)]


def opened(truth):
    folder = truth.parent
    videos = sorted(path for path in folder.iterdir() if path.suffix.lower() in VIDEOS)
    if len(videos) != 1:
        raise BadInput(f"{folder}: expected one video, found {len(videos)}")
    lines = boxes.read(truth)
    if not lines or lines[0] is None or lines[0][2:].min() <= 0:
        raise BadInput(f"{truth}: expected a box in the first line")
    digest = hashlib.sha256(videos[0].read_bytes() + truth.read_bytes()).hexdigest()
    return Recording(folder.resolve().name, folder, videos[0], truth, digest)


def cached_frames(recording, cache):
    """The file of the reduced frames, created if it is missing."""
    path = cache / "frames" / f"{recording.name}-{recording.digest[:16]}.npy"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(f".{os.getpid()}.npy")
        np.save(unfinished, reduced_frames(recording))
        unfinished.rename(path)
    return path


def reduced_frames(recording):
    factor = recording.reduction()
    frames = [reduced(frame, factor) for frame in decoded(recording.video)]
    expected = len(boxes.read(recording.truth))
    if len(frames) != expected:
        raise BadInput(f"{recording.video}: OpenCV reads {len(frames)} frames, {recording.truth.name} has {expected} lines")
    return np.stack(frames)


def reduced(frame, factor):
    return cv2.resize(frame, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA) if factor < 1 else frame


def decoded(video):
    """Decodes a video to gray frames."""
    capture = cv2.VideoCapture(str(video))
    while True:
        more, frame = capture.read()
        if not more:
            return
        yield frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
