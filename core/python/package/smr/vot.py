"""`python -m smr.vot`: a tracker for the VOT toolkit. A section of its `trackers.ini`:

    [smr_python]
    label = smr robust
    protocol = trax
    command = python -m smr.vot

It speaks the TraX protocol (`pip install vot-trax`) and gives the answers of `host-sim track`; with `--paper` those of
`host-sim track --method paper --config camera`.
"""

import argparse
import os
import sys
import tempfile

import numpy

from . import Paper, Recording, Robust
from ._benchmark import Target

try:
    import trax
except ImportError:
    if __name__ != "__main__":
        raise
    print("error: there is no module trax: pip install vot-trax", file=sys.stderr)
    sys.exit(2)


def pixels(image):
    """Decodes an image of the TraX protocol to gray pixels, like host-sim."""
    if isinstance(image, trax.MemoryImage):
        return gray(image.array())
    if isinstance(image, trax.FileImage):
        return picture(image.path())
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "buffer.png")  # A JPEG is known by its first bytes.
        with open(path, "wb") as file:
            file.write(image.buffer())
        return picture(path)


def picture(path):
    [frame] = Recording(path)
    return frame


def gray(array):
    """Converts an array to gray pixels: the high byte of 16 bits, colors with the rounding of host-sim."""
    if array.dtype == numpy.uint16:
        array = array >> 8
    elif array.shape[2] == 3:
        array = (array @ numpy.array([19595, 38470, 7471]) + 32768) >> 16
    return array.astype(numpy.uint8)


def box(region):
    """The bounding box of a region. Raises ValueError for a region without a place, or an empty mask."""
    if isinstance(region, trax.Rectangle):
        return region.bounds()
    if isinstance(region, trax.Mask):
        (left, top), (rows, columns) = region.offset(), numpy.nonzero(region.array())
        points = numpy.column_stack([columns, rows])
        points = numpy.concatenate([points, points + 1]) + (left, top)
    elif isinstance(region, trax.Polygon):
        points = numpy.array(list(region))
    else:
        raise ValueError("a region without a place: expected a rectangle, a polygon or a mask")
    if len(points) == 0:
        raise ValueError("the mask has no pixel")
    low, high = points.min(axis=0), points.max(axis=0)
    return (*low.tolist(), *(high - low).tolist())


def serve(server, create):
    """Answers each frame with the boxes of all targets, until the client ends the session. `create` constructs a tracker."""
    targets = []
    while (request := server.wait()).type != trax.TraxStatus.QUIT:
        if request.type == trax.TraxStatus.INITIALIZE:
            targets = []
        elif not targets:
            raise ValueError("frame before initialize: there is nothing to follow")
        frame = pixels(request.image["color"])
        for target in targets:
            target.follow(frame)
        targets += [Target(create(), frame, box(region)) for region, _ in request.objects or []]
        server.status([state(target) for target in targets])


def state(target):
    return trax.Rectangle.create(*target.box), {"confidence": f"{target.confidence:.6f}"}


def failed(what):
    print(f"error: {what}", file=sys.stderr)
    sys.exit(2)


def main():
    parser = argparse.ArgumentParser(prog="python -m smr.vot", description="A tracker for the VOT toolkit, over the TraX protocol.")
    parser.add_argument("--paper", action="store_true", help="the tracker of the paper instead of the robust one")
    create = Paper if parser.parse_args().paper else Robust
    regions, images = ["rectangle", "polygon", "mask"], ["path", "memory", "buffer"]
    server = trax.Server(regions, images, tracker_name=f"smr-{create.__name__.lower()}", multiobject=True)
    try:
        serve(server, create)
    except (ValueError, OSError) as error:
        # Sends the reason to the client.
        server.quit(str(error))
        failed(error)
    except trax.TraxException:
        failed("the client has gone without quit, or does not speak TraX")
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
