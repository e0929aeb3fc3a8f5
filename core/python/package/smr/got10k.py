"""A tracker for the GOT-10k toolkit (`pip install smr-tracker[got10k]`, or `got10k` and `six`), whose experiments also run OTB, VOT, UAV123 and others.

    from got10k.experiments import ExperimentOTB
    from smr.got10k import SmrTracker

    ExperimentOTB("data/OTB").run(SmrTracker())

The boxes are those of `host-sim track` on the same pixels. The toolkit decodes JPEG files by pillow, which differs from host-sim by one or two
gray levels in a few pixels. While the target is lost, the box is the one where it was seen last: the toolkit's results have a box in every frame.
"""

import numpy

from . import Robust
from ._benchmark import Target

try:
    import six  # noqa: F401  The toolkit's experiments import it, and do not ask pip for it.
    from got10k.trackers import Tracker
except ImportError as error:
    raise ImportError(f"there is no module {error.name}: pip install smr-tracker[got10k]", name=error.name) from None


def gray(image):
    """Converts a `PIL.Image.Image` to gray pixels. pillow rounds like host-sim."""
    return numpy.asarray(image.convert("L"))


class SmrTracker(Tracker):
    """Runs `tracker`, any `smr.Tracker` (default: `smr.Robust()`). `name` is the toolkit's folder of results."""

    def __init__(self, tracker=None, name=None):
        self._tracker = Robust() if tracker is None else tracker
        super().__init__(name=name or f"smr-{type(self._tracker).__name__.lower()}", is_deterministic=True)

    def init(self, image, box):
        self._target = Target(self._tracker, gray(image), box)

    def update(self, image):
        return self._target.follow(gray(image))
