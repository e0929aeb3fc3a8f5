"""Crops, pairs and cut-outs: what they show is where the correction says."""

import math

import numpy as np
import pytest

from refiner_training import boxes, clips, crops, cutouts, disturbances, offsets, others, recordings as found, report
from refiner_training.kinds import OTHERS


def test_a_pixel_of_a_crop_lies_where_the_format_says():
    # Each gray level is the x of its pixel's centre, x + 0.5, because pixel x covers x to x + 1.
    frame = np.tile(np.arange(128, dtype=np.float32) + 0.5, (128, 1))
    box = np.array([60.25, 50.0, 24.0, 16.0])
    places = box[0] - 1.75 * box[2] / 2 + (np.arange(32) + 0.5) * 1.75 * box[2] / 32
    # OpenCV interpolates in steps of 1/32 pixel.
    assert crops.crop(frame, box)[16] == pytest.approx(places, abs=1 / 32)
    assert crops.crop(frame.T.copy(), box[[1, 0, 3, 2]])[:, 16] == pytest.approx(places, abs=1 / 32)


@pytest.mark.parametrize("side", [40.0, 60.0, 120.0])
def test_a_coarse_crop_lies_there_too(side):
    frame = np.tile(np.arange(256, dtype=np.float32) + 0.5, (256, 1))
    box = np.array([128.0, 128.0, side, side])
    places = box[0] - 1.75 * side / 2 + (np.arange(32) + 0.5) * 1.75 * side / 32
    assert crops.crop(frame, box)[16] == pytest.approx(places, abs=1 / 8)


def normalised_plainly(crop):
    """As the tracker computes it, pixel by pixel."""
    pixels = [int(pixel) for pixel in crop.ravel()]
    mean = (sum(pixels) + 512) >> 10
    root = math.isqrt(sum((pixel - mean) ** 2 for pixel in pixels))
    factor = 2**21 // (root + 128)
    return [min(max(((pixel - mean) * factor) >> 12, -64), 63) + 64 for pixel in pixels]


def test_normalised_crops():
    rng = np.random.default_rng(1)
    noise = [rng.integers(low, high, (32, 32), dtype=np.uint8) for low, high in ((0, 256), (100, 103), (250, 256))]
    halves = np.repeat([[0, 255]], 16, 1).reshape(1, 32).repeat(32, 0).astype(np.uint8)
    dot = np.zeros((32, 32), np.uint8)
    dot[3, 4] = 255
    for crop in [*noise, halves, dot, np.full((32, 32), 255, np.uint8)]:
        assert list(crops.normalised(crop).ravel()) == normalised_plainly(crop)


def test_a_flat_crop_is_zero_everywhere():
    assert (crops.normalised(np.full((32, 32), 77, np.uint8)) == crops.ZERO).all()


def test_a_wrong_box_is_within_reach():
    rng = np.random.default_rng(2)
    changes = np.array([boxes.correction(offsets.drawn(rng, cutouts.UNIT), cutouts.UNIT) for _ in range(500)])
    assert abs(changes[:, :2]).max() <= offsets.LIMIT.centre + 1e-6
    assert abs(changes[:, 2:]).max() <= offsets.LIMIT.size + offsets.LIMIT.aspect + 1e-6
    assert changes.std(0) == pytest.approx([0.12, 0.12, 0.27, 0.27], abs=0.04)


def test_a_pasted_piece_fills_its_true_box():
    rng = np.random.default_rng(3)
    frame, behind = np.full((80, 80), 255, np.uint8), np.zeros((32, 32), np.float32)
    middle = np.array([16.0, 16.0, 32 / 1.75, 32 / 1.75])
    for _ in range(50):
        piece = cutouts.Piece(frame, np.array([40.0, 40, 20, 16]), cutouts.shape(rng))
        box = offsets.drawn(rng, cutouts.UNIT, offsets.Spread(0.1, 0.1, 0.05))
        seen = cutouts.pasted(piece, box, 0.0, behind) > 127
        rows, columns = np.flatnonzero(seen.any(1)), np.flatnonzero(seen.any(0))
        truth = boxes.corrected(middle, boxes.correction(box, cutouts.UNIT))
        found = boxes.from_corners(columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)
        # The tolerance is large, because a mask has 64x64 pixels, and a sharp corner of a polygon may vanish.
        assert found == pytest.approx(truth, abs=3.5)


def test_the_content_of_a_piece_does_not_shift():
    # Each gray level is its pixel's x, so a piece that is pasted at its own box must equal the crop from the frame.
    frame = np.tile(np.arange(80, dtype=np.uint8), (80, 1))
    box = np.array([40.0, 40, 20, 20])
    piece = cutouts.Piece(frame, box, np.full((64, 64), 255, np.uint8))
    pasted = cutouts.pasted(piece, cutouts.UNIT, 0.0, np.zeros((32, 32), np.float32))
    assert pasted[4:-4, 4:-4] == pytest.approx(crops.crop(frame, box)[4:-4, 4:-4].astype(float), abs=1)


def test_other_things_do_not_show_the_target(recordings, tmp_path):
    sources = [
        clips.Source(recording.truth, found.cached_frames(recording, tmp_path), recording.truth, recording.reduction())
        for recording in found.find([recordings])
    ]
    read = clips.read(sources)
    rng = np.random.default_rng(5)
    kinds = set()
    for _ in range(300):
        group = others.drawn(rng, read)
        assert 1 <= len(group) <= others.MAX_PLACES
        for first, present, change, kind in group:
            kinds.add(kind)
            assert first.shape == present.shape == (32, 32) and present.dtype == np.uint8
            assert kind not in OTHERS or not change.any()
    # The tracker's boxes are the true ones here, so there is no mistake.
    assert set(OTHERS) - kinds == {others.Kind.MISTAKEN}


def test_the_best_place_that_resembles_the_target_is_the_target():
    rng = np.random.default_rng(6)
    frame = rng.integers(0, 255, (90, 120), dtype=np.uint8)
    truth = np.array([60.0, 40, 12, 12])
    best, *_ = others.peaks(frame, truth, others.inside(frame, truth))
    assert best == pytest.approx(truth[:2], abs=1)


def test_a_turn_keeps_the_middle():
    matrix = crops.to_frame(np.array([50.0, 40, 20, 10]))
    middle = np.array([15.5, 15.5])
    turned = disturbances.turned(matrix, 0.3)
    assert turned[:, :2] @ middle + turned[:, 2] == pytest.approx(matrix[:, :2] @ middle + matrix[:, 2])
    assert disturbances.turned(matrix, 0.0) == pytest.approx(matrix)


def test_the_area_is_the_share_of_ordered_pairs():
    assert report.area(np.array([2, 3]), np.array([1, 2, 5])) == pytest.approx((1 + 0.5 + 1 + 1) / 6, abs=1e-4)
