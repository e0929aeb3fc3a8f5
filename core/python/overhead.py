"""Compares the time of a call with that of the update in Rust: python overhead.py

The frames are 640x480 and gray. The tracker has a tiny window, so that its own time does not hide that of the call. Each time is the least of
15 alternating repetitions.
"""

import pathlib
import tempfile
import time

import numpy as np
import smr

FRAMES, BOX = 400, (300, 200, 8, 8)


def write(folder, frame):
    """Writes a recording in the layout of OTB, in which nothing moves."""
    for number in range(1, FRAMES + 1):
        (folder / f"{number:04}.pgm").write_bytes(b"P5 640 480 255\n" + frame.tobytes())
    line = ",".join(str(number + offset) for number, offset in zip(BOX, (1, 1, 0, 0)))
    (folder / "groundtruth_rect.txt").write_text(f"{line}\n" * FRAMES)


def in_python(call, frame):
    start = time.perf_counter()
    for _ in range(FRAMES - 1):
        call(frame)
    return (time.perf_counter() - start) / (FRAMES - 1) * 1e6


def main():
    frame = np.random.default_rng(1).integers(0, 256, (480, 640), np.uint8)
    tracker = smr.Paper(window=(1, 1))
    times = {"rust": [], "update": [], "follow": []}
    with tempfile.TemporaryDirectory() as folder:
        write(pathlib.Path(folder), frame)
        for _ in range(15):
            times["rust"] += smr.evaluate(folder, tracker)["microseconds_per_frame"]
            tracker.init(frame, BOX)
            times["update"].append(in_python(tracker.update, frame))
            times["follow"].append(in_python(tracker.follow, frame))
    rust, update, follow = (min(values) for values in times.values())
    print(f"an update in Rust takes {rust:.2f} us")
    print(f"update() adds {update - rust:.2f} us, follow() adds {follow - rust:.2f} us")


if __name__ == "__main__":
    main()
