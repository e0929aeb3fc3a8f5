"""Times OpenCV on the searches that host-sim has written down; one thread. Answers with one line of JSON."""

import json
import sys
import time

try:
    import cv2
    import numpy
except ImportError as error:
    print(json.dumps({"missing": str(error)}))
    sys.exit(0)

folder, repeats, enough = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
cv2.setNumThreads(1)
with open(folder + "/searches.json") as file:
    searches = json.load(file)
with open(folder + "/searches.raw", "rb") as file:
    pixels = numpy.frombuffer(file.read(), numpy.uint8)


def shortest(prepare):
    """Seconds of one call of what `prepare` gives: the least of up to `repeats`, fewer once they are `enough` together."""
    least, total = float("inf"), 0.0
    for _ in range(repeats):
        call = prepare()
        start = time.perf_counter()
        call()
        seconds = time.perf_counter() - start
        least, total = min(least, seconds), total + seconds
        if total > enough:
            break
    return least


def picture(size):
    """The next picture of so many columns and rows."""
    global pixels
    width, height = size
    taken, pixels = pixels[: width * height], pixels[width * height :]
    return taken.reshape(height, width)


def match(crop, template):
    return lambda: cv2.matchTemplate(crop, template, cv2.TM_CCOEFF_NORMED)


def csrt(frames, target):
    """The tracker after the first frame and an update, before another one."""
    tracker = cv2.TrackerCSRT_create()
    tracker.init(frames[0], target)
    tracker.update(frames[1])
    return lambda: tracker.update(frames[2])


answer = {"version": cv2.__version__, "search": [], "csrt": []}
for search in searches:
    crop, template = picture(search["crop"]), picture(search["template"])
    # What is loaded and set up at the first call is no part of a search.
    if not answer["search"]:
        match(crop, template)()
    answer["search"].append(shortest(lambda: match(crop, template)))
    if "frame" in search:
        frames = [cv2.cvtColor(picture(search["frame"]), cv2.COLOR_GRAY2BGR) for _ in range(3)]
        if hasattr(cv2, "TrackerCSRT_create"):
            answer["csrt"].append(shortest(lambda: csrt(frames, search["target"])))
print(json.dumps(answer))
