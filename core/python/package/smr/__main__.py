"""`python -m smr SOURCE`: follows a target through a video, a camera or a recording, in a window where OpenCV has one."""

import argparse
import json
import os
import sys

from . import Answer, Box, Paper, Recording, Robust, State
from ._smr import start_beside

os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")  # This program says in a line of its own what is wrong.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
try:
    import cv2
except ImportError:
    cv2 = None

COLORS = {State.TRACKING: (80, 220, 60), State.LEAVING: (0, 200, 255), State.UNCERTAIN: (0, 140, 255), State.LOST: (60, 60, 255)}  # BGR


class Window:
    """Shows frames, and reads boxes and keys from the user. `pause` is the wait for a key, in milliseconds."""

    def __init__(self, pause):
        self.pause = pause

    def select(self, frame):
        """Returns the box that the user draws, or None."""
        print("draw a box, then press space; c selects nothing", file=sys.stderr)
        # Suppresses OpenCV's notice, which would appear between the lines of standard output.
        box = cv2.selectROI("smr", frame, showCrosshair=False, printNotice=False)
        return box if box[2] and box[3] else None

    def show(self, frame, answer):
        """Draws the answer into a copy of the frame. Returns the pressed key; `q` if the window was closed."""
        picture = cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR) if frame.ndim == 2 else frame.copy()
        x, y, width, height = answer.box
        text = answer.state if answer.confidence is None else f"{answer.state} {answer.confidence:.2f}"
        cv2.rectangle(picture, (x, y), (x + width, y + height), COLORS[answer.state], 2)
        cv2.putText(picture, text, (8, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.7, COLORS[answer.state], 2)
        cv2.imshow("smr", picture)
        key = cv2.waitKey(self.pause) & 255
        return chr(key) if cv2.getWindowProperty("smr", cv2.WND_PROP_VISIBLE) > 0 else "q"


def has_window():  # On Linux, OpenCV ends the process where it finds no display.
    return cv2 is not None and cv2.currentUIFramework() != "" and (sys.platform != "linux" or "DISPLAY" in os.environ)


def opened(source):
    """Returns the frames, the box from a file beside the source, and the milliseconds from frame to frame."""
    is_camera = source.isdecimal()
    source = int(source) if is_camera else source
    # OpenCV, unlike Recording, also opens cameras of other systems than Linux.
    if cv2 and (sys.platform != "linux" if is_camera else os.path.isfile(source)):
        capture = cv2.VideoCapture(source)
        if capture.isOpened():
            box = None if is_camera else start_beside(source)
            return captured(capture), box, max(1, round(1000 / (capture.get(cv2.CAP_PROP_FPS) or 30)))
    recording = Recording(source, color=is_camera)
    return iter(recording), recording.start, 1 if recording.is_live else round(1000 / (recording.fps or 30))


def captured(capture):
    while (read := capture.read())[0]:
        yield read[1]


def locked(tracker, frame, box):
    """Starts the tracker. Returns the answer for this frame, which has no confidence, no ratios and no identity."""
    tracker.init(frame, box)
    place = Box(*(int(side + 0.5) for side in box))
    return Answer(place, place, State.TRACKING, *[None] * 7)


def text(number, answer):
    place = "-" if answer.state == State.LOST else ",".join(map(str, answer.box))
    return f"{number} {answer.state} {place}" + ("" if answer.confidence is None else f" {answer.confidence:.6f}")


def json_line(number, answer):
    """The answer as a line of JSON, with the keys and values of `host-sim track --json`."""
    box, fine = (None if answer.state == State.LOST else place._asdict() for place in (answer.box, answer.fine_box))
    figures = {name: (value := getattr(answer, name)) and round(value, 6) for name in ("confidence", "ratio", "identity", "scale")}
    return json.dumps({"frame": number, "state": answer.state, "box": box, "fine": fine, **figures, "found_again": answer.found_again})


def follow(frames, tracker, box, window, to_line):
    """Prints a line for each frame and shows the frame if there is a window, until the last frame or the key `q`."""
    answer = None
    for number, frame in enumerate(frames, 1):
        if answer is None:
            box = box or (window.select(frame) if window else None)
            if box is None:
                raise ValueError("no box was selected" if window else "there is no window to select a box in: expected --box X,Y,W,H")
            answer = locked(tracker, frame, box)
        else:
            answer = tracker.follow(frame)
        print(to_line(number, answer), flush=True)
        key = window.show(frame, answer) if window else None
        if key == "q":
            return
        if key == "r" and (box := window.select(frame)):
            locked(tracker, frame, box)
    if answer is None:
        raise ValueError("there are no frames")


def numbers(given):
    try:
        x, y, width, height = map(float, given.split(","))
    except ValueError:
        raise ValueError(f"--box: expected X,Y,W,H, four numbers, found {given}") from None
    return x, y, width, height


def arguments():
    parser = argparse.ArgumentParser(prog="python -m smr", description="Follows a target. In the window, q ends and r selects again.")
    parser.add_argument("source", metavar="SOURCE", help="a video, the number of a camera, or a recording of host-sim such as synthetic")
    parser.add_argument("--box", metavar="X,Y,W,H", help="the initial box; without it, the one beside a recording, or one that you draw")
    parser.add_argument("--paper", action="store_true", help="the tracker of the paper instead of the robust one")
    parser.add_argument("--json", action="store_true", help="a line of JSON for each frame, as of host-sim track --json")
    return parser.parse_args()


def main():
    options = arguments()
    frames, box, pause = opened(options.source)
    box = numbers(options.box) if options.box else box
    window = Window(pause) if has_window() else None
    follow(frames, Paper() if options.paper else Robust(), box, window, json_line if options.json else text)


if __name__ == "__main__":
    try:
        main()
    except BrokenPipeError:
        # Redirects standard output to the null device: Python's flush at exit would raise BrokenPipeError again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        sys.exit(130)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
