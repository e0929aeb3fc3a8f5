"""The table of the network's layers, as in the tracker's code.

Two crops -> four 3x3 convolutions with padding 1 -> 4x4x24 features -> 24 -> 7 outputs: dx, dy in sides of the box, log width, log height,
the log spreads of place and size, and a quarter of the match logit. Pixels lie row by row, the channels of a pixel side by side.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Layer:
    """A layer. `shift` also scales the weights: their unit is 1/2^shift. The unit of activations is 1/16, of the last layer's outputs 1/4096."""

    inputs: int  # channels of a convolution
    outputs: int
    shift: int
    stride: int = 0  # 0: a full layer

    @property
    def convolution(self):
        return self.stride > 0

    @property
    def row(self):
        """The number of weights of one output."""
        return 9 * self.inputs if self.convolution else self.inputs

    @property
    def padded_row(self):
        """The number of stored weights of one output: padded to a multiple of 4."""
        return -(-self.row // 4) * 4


LAYERS = (
    Layer(2, 8, 6, 2),
    Layer(8, 16, 7, 2),
    Layer(16, 24, 7, 1),
    Layer(24, 24, 7, 2),
    Layer(384, 24, 8),
    Layer(24, 7, 8),
)
LARGEST_WEIGHT = 127
LARGEST_ACTIVATION = 127
ACTIVATION_UNIT = 16
OUTPUT_UNIT = ACTIVATION_UNIT << LAYERS[-1].shift
