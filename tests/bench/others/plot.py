"""Draws host-sim/assets/work.svg, accuracy over time, from tests/results/peers.json and host.json.

    python tests/bench/others/plot.py >host-sim/assets/work.svg
"""

import json
import math
import os

RESULTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../results")
# For each tracker: its name among the peers, the name of its time, its color (those of host-sim/pages/src/colors.rs; gray for others).
OTHERS, INK, GRID = "rgb(150,160,170)", "rgb(255,255,255)", "rgb(90,90,90)"
TRACKERS = {
    "smr.Paper": ("paper", "smr.Paper, +-60x50", "rgb(255,64,64)"),
    "smr.Robust('robust')": ("robust without refiner", "smr.Robust('robust')", "rgb(255,130,220)"),
    "KCF": ("KCF", "KCF", OTHERS),
    "CSRT": ("CSRT", "CSRT", OTHERS),
}
LEAST, MOST = 0.02, 100


def result(name):
    with open(os.path.join(RESULTS, name), encoding="utf-8") as file:
        return json.load(file)


def x(milliseconds):
    return 70 + 570 * math.log10(milliseconds / LEAST) / math.log10(MOST / LEAST)


def y(accuracy):
    return 360 - 320 * (accuracy - 0.4) / 0.5


def text(left, top, words, anchor="middle", color=INK):
    return f'<text x="{left:.0f}" y="{top:.0f}" text-anchor="{anchor}" fill="{color}">{words}</text>'


def line(points, color, more=""):
    return f'<polyline points="{" ".join(f"{left:.1f},{top:.1f}" for left, top in points)}" fill="none" stroke="{color}"{more}/>'


def main():
    accuracy, times = result("peers.json")["figures"], dict(row.split(" | ") for row in result("host.json")["rows"]["all"])
    dashes = ' stroke-dasharray="3 4"'
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 680 420" font-family="sans-serif" font-size="14">']
    parts.append('<rect width="680" height="420" fill="#181818"/>')
    for level in (0.4, 0.5, 0.6, 0.7, 0.8, 0.9):
        parts += [line([(70, y(level)), (640, y(level))], GRID, dashes), text(62, y(level) + 5, level, "end")]
    for milliseconds in (0.02, 0.1, 0.5, 2, 10, 50):
        parts += [line([(x(milliseconds), 40), (x(milliseconds), 360)], GRID, dashes), text(x(milliseconds), 381, milliseconds)]
    parts += [text(355, 407, "milliseconds of an update, one core of the host"), text(70, 25, "fraction of right frames", "start")]
    network = float(accuracy["NanoTrack"])
    parts += [line([(70, y(network)), (640, y(network))], OTHERS), text(640, y(network) - 7, "NanoTrack v2, not timed", "end", OTHERS)]
    for name, (peer, timed, color) in TRACKERS.items():
        at, middle = x(float(times[timed])), float(accuracy[peer])
        side, anchor = (-12, "end") if at > 500 else (12, "start")
        parts += [f'<circle cx="{at:.1f}" cy="{y(middle):.1f}" r="6" fill="{color}"/>']
        parts += [text(at + side, y(middle) + 5, name, anchor, color)]
    print("\n".join([*parts, "</svg>"]))


main()
