"""What 100,000 frames leave behind: nothing."""

import gc
import resource

import numpy as np
import pytest
import smr


def resident():
    gc.collect()
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


@pytest.mark.parametrize("make", [lambda: smr.Robust(reach=4), lambda: smr.Paper(window=(4, 4))])
def test_memory_does_not_grow(make):
    try:
        resident()
    except OSError:
        pytest.skip("no /proc/self/statm")
    gray = np.random.default_rng(2).integers(0, 256, (24, 32), np.uint8)
    frames = [gray, np.repeat(gray[:, :, None], 3, axis=2), gray[::-1][::-1], np.asfortranarray(gray)]
    tracker = make()
    tracker.init(gray, (8, 8, 8, 8))

    def follow(count):
        for number in range(count):
            answer = tracker.follow(frames[number % 4])
            tracker.update(frames[0])
            if number % 100 == 0:
                tracker.init(frames[number % 3], (8, 8, 8, 8))
                tracker.restore(tracker.save())
        return answer

    follow(1000)
    before = resident()
    follow(25_000)
    # More than 100,000 frames with both trackers. An object of 32 bytes that stays in each would be 1.6 MB here.
    assert resident() - before < 500_000
