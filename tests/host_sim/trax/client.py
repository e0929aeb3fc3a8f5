"""The client of vot-trax, the protocol's own implementation: leads two sessions in a row with one `host-sim trax`, as the VOT toolkit does for
repetitions, and prints each answer.

Usage: client.py HOST_SIM METHOD PROTOCOL WAY FORM FOLDER FRAMES X Y WIDTH HEIGHT
WAY: path, memory or buffer. FORM: rectangle or polygon. FOLDER: pictures 00001.png ...
A line: x,y,width,height,confidence
"""

import os
import subprocess
import sys

import numpy
from trax.client import Client
from trax.image import BufferImage, FileImage, MemoryImage
from trax.region import Polygon, Rectangle


def pixels(pgm):
    """Of a PGM: the picture as an array."""
    kind, size, largest, data = pgm.split(b"\n", 3)
    width, height = map(int, size.split())
    assert kind == b"P5" and largest == b"255"
    return numpy.frombuffer(data, dtype=numpy.uint8).reshape(height, width)


def image(way, folder, number):
    stem = os.path.join(folder, f"{number:05}")
    if way == "path":
        return FileImage.create(stem + ".png")
    if way == "buffer":
        with open(stem + ".png", "rb") as file:
            return BufferImage.create(file.read())
    with open(stem + ".pgm", "rb") as file:
        return MemoryImage.create(pixels(file.read()))


def main():
    program, method, protocol, way, form, folder, frames = sys.argv[1:8]
    x, y, width, height = map(float, sys.argv[8:])
    command = [program, "trax", "--method", method, "--protocol", protocol]
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    client = Client((server.stdin.fileno(), server.stdout.fileno()), log=os.devnull)
    assert client.tracker_name == method, client.tracker_name
    assert set(client.image_formats) == {"path", "memory", "buffer"}, client.image_formats
    assert set(client.region_formats) == {"rectangle", "polygon"}, client.region_formats
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    region = Polygon.create(corners) if form == "polygon" else Rectangle.create(x, y, width, height)
    for number in 2 * list(range(1, int(frames) + 1)):
        images = {"color": image(way, folder, number)}
        if number == 1:
            answers, _ = client.initialize(images, [(region, {})], {})
        else:
            answers, _ = client.frame(images, {}, [])
        [(answer, properties)] = answers
        print(*answer.bounds(), properties["confidence"], sep=",")
    client.quit()
    server.stdin.close()
    sys.exit(server.wait(timeout=20))


main()
