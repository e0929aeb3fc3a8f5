"""Draws host-sim/assets/work.svg, accuracy over time, from the comparison with OpenCV in core/python/README.md.

    python tests/bench/others/plot.py >host-sim/assets/work.svg
"""

import math
import os
import re

README = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../core/python/README.md")
ROW = re.compile(r"\| ([\w.\"()]+)( \(.*\))? \| ([\d.]+) ± ([\d.]+) \| [\d.]+ \| ([\d.]+) \|")
# The colors of host-sim/pages/src/colors.rs; other trackers than smr's are gray.
COLORS = {"smr.Paper": "rgb(255,64,64)", "smr.Robust(\"robust\")": "rgb(255,130,220)"}
OTHERS, INK, GRID = "rgb(150,160,170)", "rgb(255,255,255)", "rgb(90,90,90)"
# Score of NanoTrack v2 in host-sim/RESULTS.md, drawn as a line across the plot because its time was not measured.
NETWORK = 0.853


def x(milliseconds):
    return 70 + 570 * math.log10(milliseconds / 0.5) / math.log10(100 / 0.5)


def y(accuracy):
    return 360 - 320 * (accuracy - 0.4) / 0.5


def text(left, top, words, anchor="middle", color=INK):
    return f'<text x="{left:.0f}" y="{top:.0f}" text-anchor="{anchor}" fill="{color}">{words}</text>'


def line(points, color, more=""):
    return f'<polyline points="{" ".join(f"{left:.1f},{top:.1f}" for left, top in points)}" fill="none" stroke="{color}"{more}/>'


def main():
    with open(README, encoding="utf-8") as file:
        rows = ROW.findall(file.read().replace("*", ""))
    dashes = ' stroke-dasharray="3 4"'
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 680 420" font-family="sans-serif" font-size="14">']
    parts.append('<rect width="680" height="420" fill="#181818"/>')
    for accuracy in (0.4, 0.5, 0.6, 0.7, 0.8, 0.9):
        parts += [line([(70, y(accuracy)), (640, y(accuracy))], GRID, dashes), text(62, y(accuracy) + 5, accuracy, "end")]
    for milliseconds in (0.5, 1, 2, 5, 10, 20, 50, 100):
        parts += [line([(x(milliseconds), 40), (x(milliseconds), 360)], GRID, dashes), text(x(milliseconds), 381, milliseconds)]
    parts += [text(355, 407, "milliseconds a frame, one core of the host"), text(70, 25, "fraction of correct frames", "start")]
    parts += [line([(70, y(NETWORK)), (640, y(NETWORK))], OTHERS), text(640, y(NETWORK) - 7, "NanoTrack v2, not timed", "end", OTHERS)]
    for name, note, accuracy, error, milliseconds in rows:
        color, at, middle, error = COLORS.get(name, OTHERS), x(float(milliseconds)), float(accuracy), float(error)
        side, anchor = (-12, "end") if at > 500 else (12, "start")
        parts += [line([(at, y(middle - error)), (at, y(middle + error))], color)]
        parts += [f'<circle cx="{at:.1f}" cy="{y(middle):.1f}" r="6" fill="{color}"/>']
        parts += [text(at + side, y(middle) + 5, name.replace('"', "'") + note, anchor, color)]
    print("\n".join([*parts, "</svg>"]))


main()
