"""Counts the frames in which `smr.Robust` is wrong, and its state in them: python wrong.py RECORDING...

A frame is wrong if its box has an IoU of at most 0.25 with the ground truth, or if the target is hidden there.
"""

import sys
from collections import Counter

import smr


def iou(one, other):
    sides = [min(one[at] + one[at + 2], other[at] + other[at + 2]) - max(one[at], other[at]) for at in (0, 1)]
    shared = max(sides[0], 0) * max(sides[1], 0)
    return shared / (one[2] * one[3] + other[2] * other[3] - shared)


def main():
    counts = {"wrong": Counter(), "right": Counter()}
    for recording in map(smr.Recording, sys.argv[1:]):
        tracker = smr.Robust()
        for number, (frame, truth) in enumerate(zip(recording, recording.truth)):
            if number == 0:
                tracker.init(frame, recording.start)
                continue
            answer = tracker.follow(frame)
            wrong = truth is None or iou(answer.fine_box, truth) <= 0.25
            counts["wrong" if wrong else "right"][answer.state] += 1
    for kind, states in counts.items():
        print(f"{sum(states.values())} {kind} frames:", ", ".join(f"{count} {state}" for state, count in states.most_common()))


if __name__ == "__main__":
    main()
