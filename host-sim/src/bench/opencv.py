"""Times cv2.matchTemplate on the searches that host-sim has written down; one thread. Answers with one line of JSON."""

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


def shortest(crop, template):
    """Seconds of one call: the least of up to `repeats`, fewer once they are `enough` together."""
    least, total = float("inf"), 0.0
    for _ in range(repeats):
        start = time.perf_counter()
        cv2.matchTemplate(crop, template, cv2.TM_CCOEFF_NORMED)
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


answers = []
for search in searches:
    crop, template = picture(search["crop"]), picture(search["template"])
    if not answers:
        # What is loaded and set up at the first call is no part of a search.
        cv2.matchTemplate(crop, template, cv2.TM_CCOEFF_NORMED)
    answers.append(shortest(crop, template))
print(json.dumps({"version": cv2.__version__, "seconds": answers}))
