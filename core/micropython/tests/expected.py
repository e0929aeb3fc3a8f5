# Prints the expected output of track.py, from files with lines of `host-sim track --json`: expected.py NAME FILE ...
# host-sim prints fractions of six digits, which is enough to restore the tracker's integers.
import json
import sys

NOTHING = "-"


def units(fraction, one):
    return NOTHING if fraction is None else int(fraction * one + (0.5 if fraction >= 0 else -0.5))


def box(box, one):
    if box is None:
        return NOTHING
    return " ".join(str(units(box[side], one)) for side in ("x", "y", "width", "height"))


def line(answer):
    if answer["quality"] is not None:
        return "%s %d" % (box(answer["box"], 1), units(answer["quality"], 65535))
    return " ".join(str(value) for value in (
        answer["state"],
        box(answer["box"], 1),
        box(answer["fine"], 256),
        units(answer["confidence"], 65535),
        units(answer["ratio"], 65535),
        units(answer["runner_up_ratio"], 65535),
        NOTHING if answer["alpha"] is None else answer["alpha"],
        units(answer["identity"], 65535),
        units(answer["scale"], 65536),
        int(answer["found_again"]),
    ))


for at in range(1, len(sys.argv), 2):
    with open(sys.argv[at + 1]) as answers:
        for text in answers:
            answer = json.loads(text)
            print("|", sys.argv[at], answer["frame"], line(answer))
