"""Checks that bad calls raise exceptions that say what was expected, and change nothing, and that 100,000 good calls leak no memory."""

import copy
import gc
import multiprocessing
import os
import random
import threading

import numpy as np
import pytest
import smr

FRAME = np.random.default_rng(7).integers(0, 256, (60, 80), np.uint8)
BOX = (20, 10, 24, 20)
EXPECTED = r"expected a numpy array of uint8, gray \(height, width\) or BGR \(height, width, 3\), found "


@pytest.mark.parametrize("frame, words", [
    (None, "NoneType"), ([[1, 2], [3, 4]], "list"), (FRAME.tobytes(), "bytes"), (FRAME.astype(np.float32), r"float32 of shape \[60, 80\]"),
    (FRAME.astype(np.int8), "int8"), (FRAME.astype(object), "object"), (FRAME[0], r"uint8 of shape \[80\]"),
    (np.zeros((60, 80, 4), np.uint8), r"uint8 of shape \[60, 80, 4\]"), (np.zeros((1, 60, 80, 3), np.uint8), r"uint8 of shape \[1, 60, 80, 3\]"),
    (np.zeros((0, 80), np.uint8), r"uint8 of shape \[0, 80\]: each side must be 1 to 65535"),
    (np.zeros((1, 65536), np.uint8), r"uint8 of shape \[1, 65536\]: each side must be 1 to 65535"),
])  # fmt: skip
def test_frames(frame, words):
    kind = ValueError if words.startswith("uint8") else TypeError
    for call in (lambda: smr.Robust().init(frame, BOX), lambda: locked(smr.Paper).update(frame)):
        with pytest.raises(kind, match="frame: " + EXPECTED + words):
            call()


def locked(make):
    tracker = make()
    tracker.init(FRAME, BOX)
    return tracker


@pytest.mark.parametrize("make", [smr.Robust, smr.Paper])
def test_boxes_and_options(make):
    for box, kind, words in [
        ((1, 2, 3), TypeError, r"expected four numbers \(x, y, width, height\), found \(1, 2, 3\)"),
        ("abcd", TypeError, "expected four numbers"),
        (None, TypeError, "expected four numbers"),
        *[((*start, end), ValueError, "expected finite numbers") for *start, end in [(float("nan"), 2, 3, 4), (0, 0, 10, float("inf"))]],
        *[((*start, end), ValueError, "the box has no pixels") for *start, end in [(1, 2, 0, 4), (1, 2, 3, -4)]],
        ((1e12, 2, 3, 4), ValueError, "the box is too large or too far away"),
        ((70, 10, 24, 20), ValueError, r"the box 70,10,24,20 \(x,y,width,height\) is not wholly inside the frame of 80x60 pixels"),
    ]:  # fmt: skip
        tracker = locked(make)
        saved = tracker.save()
        with pytest.raises(kind, match=words):
            tracker.init(FRAME, box)
        assert tracker.save() == saved
    tracker = make()
    for call in (lambda: tracker.update(FRAME), tracker.save):
        with pytest.raises(RuntimeError, match="there is no target yet: call init first"):
            call()
    for frame in (FRAME[:50], FRAME[:, :50], FRAME[:1, :1], np.zeros((61, 80, 3), np.uint8)):
        with pytest.raises(ValueError, match="the frame has another size than the one that was locked on"):
            locked(make).update(frame)
    with pytest.raises(TypeError, match="no option rich: expected "):
        make(rich=1)
    for saved in (b"", b"SMR", locked(make).save()[:-1], bytes(200)):
        with pytest.raises(ValueError):
            smr.restore(saved)
    with pytest.raises(ValueError, match="pixels of -8388607 to 8388607"):
        tracker.moved(float("nan"), 0)


def test_options_have_ranges():
    for make, words in [
        (lambda: smr.Robust(reach=9), "reach is 4 to 8, not 9"),
        (lambda: smr.Robust(reach=256), "reach is 4 to 8, not 256"),
        (lambda: smr.Robust("small", reach=8), "reach is 4 to 7, not 8"),
        (lambda: smr.Robust("small_refined", reach=-1), "reach: expected a whole number of 4 to 7, found -1"),
        (lambda: smr.Robust(lost_below=-1), "lost_below: expected a whole number of 0 to 65535, found -1"),
        (lambda: smr.Robust(size=1), "size: expected True or False, found 1"),
        (lambda: smr.Paper(window=4), "window: expected a tuple of two whole numbers of 0 to 65535, found 4"),
        (lambda: smr.Paper(window=(200, 4)), "window_limit is smaller than window: {'window'"),
        (lambda: smr.Paper(k=(1, 0)), "k is 1 to 65535, not 0"),
        (lambda: smr.Paper("best"), "preset: expected 'camera' or 'paper', found 'best'"),
        (lambda: smr.Robust("camera"), "preset: expected 'refined' or 'robust' or 'small' or 'small_refined', found 'camera'"),
        (lambda: smr.Robust(5), "preset: expected 'refined' or 'robust' or 'small' or 'small_refined', found 5"),
        (lambda: smr.Group(0), "threads: expected 1 or more, found 0"),
    ]:
        with pytest.raises(ValueError, match=words.replace("{", r"\{")):
            make()


def test_recordings(tmp_path):
    (tmp_path / "1.png").write_bytes(b"no picture")
    for call, words in [
        (lambda: smr.Recording(tmp_path / "none"), "cannot open .*none: expected a folder, a file"),
        (lambda: smr.Recording("-"), "standard input can be read only once"),
        (lambda: smr.evaluate(tmp_path / "none"), "neither a recording nor a folder"),
        (lambda: smr.evaluate([]), "paths: expected a recording, a folder of recordings, or a list of them, found an empty list"),
        (lambda: smr.evaluate("noise", starts="some"), "starts: expected 'given', 'near' or the number of frames"),
        (lambda: smr.evaluate("noise", starts=0), "starts: expected"),
        (lambda: smr.Recording("synthetic").score([(1, 2, 3, 4)]), "there are 1 frames, but the ground truth has 240 boxes"),
        (lambda: smr.Recording(tmp_path).score([None]), "no ground truth beside it"),
        (lambda: smr.evaluate("noise", smr.Robust), "trackers: expected a tracker such as .* found <class 'smr.Robust'>"),
        (lambda: smr.evaluate("noise", {"robust": smr.Robust}), "trackers: expected a tracker such as "),
        (lambda: smr.Group().add(smr.Robust, FRAME, BOX), "tracker: expected a tracker such as "),
        (lambda: smr.Recording(None), "path: expected a path, an address or the number of a camera, found None"),
        (lambda: smr.Recording(-1), "path: expected a path, an address or the number of a camera, found -1"),
    ]:  # fmt: skip
        with pytest.raises(TypeError if words.startswith(("track", "path:")) else ValueError, match=words):
            call()
    with pytest.raises(OSError, match="1.png"):
        list(smr.Recording(tmp_path))
    recording = smr.Recording("synthetic", color=True)
    assert (len(recording), recording.size, recording.fps, bool(recording)) == (240, (160, 120), None, True)
    assert repr(recording) == 'smr.Recording("synthetic", color=True)' and repr(eval(repr(recording))) == repr(recording)


def test_a_tracker_is_for_one_thread_at_a_time():
    large = np.random.default_rng(3).integers(0, 256, (1200, 1600), np.uint8)
    tracker = smr.Robust()
    tracker.init(large, (300, 300, 700, 600))
    refused, barrier = [], threading.Barrier(4)

    def follow():
        barrier.wait()
        for _ in range(50):
            try:
                tracker.update(large)
            except RuntimeError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=follow) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # While one thread updates the tracker without the GIL, calls of other threads are refused.
    assert refused and set(refused) == {
        "this tracker is in use by another thread: give each thread a tracker of its own"
    }
    assert tracker.follow(large).state == smr.State.TRACKING


def test_a_thousand_bad_calls():
    """Any value as any argument raises only documented exceptions, after which the tracker works."""
    pick = random.Random(27).choice
    values = [
        None, True, 0, -1, 2**40, 1.5, float("nan"), float("inf"), "", "x", b"", b"SMRR", (), (1,), (1, 2, 3, 4), (20, 10, 24, 20),
        [0, 0, 80, 60], (0, 0, float("nan"), 1), {}, {"x": 1}, object(), FRAME, FRAME[::-2, ::3], FRAME.astype(float), FRAME[:0], FRAME[0],
        np.zeros((2, 2, 3), np.uint8), np.zeros((60, 80, 2), np.uint8), np.array(3, np.uint8), np.ma.masked_array(FRAME), range(4),
        np.lib.stride_tricks.as_strided(FRAME, (60, 80), (0, 0)), smr.Robust, smr.Robust(), iter([1, 2, 3, 4]),
    ]  # fmt: skip
    trackers = [locked(smr.Robust), locked(smr.Paper)]
    raised = 0
    for _ in range(1000):
        tracker = pick(trackers)
        name = pick(["init", "update", "follow", "moved", "restore", "new", "restored", "state", "score", "add", "evaluate"])
        call = {
            "new": lambda *values: pick([smr.Robust, smr.Paper])(**{pick(["reach", "window", "preset", "k"]): values[0]}),
            "restored": smr.restore,
            "state": lambda *values: tracker.__setstate__(values[:1]),
            "score": lambda *values: smr.Recording("noise").score(values[0]),
            "add": lambda *values: smr.Group().add(*values),
            "evaluate": lambda *values: smr.evaluate(pick(["", None, 3, "nowhere"]), starts=values[0]),
        }.get(name) or getattr(tracker, name)
        try:
            call(*(pick(values) for _ in range(pick([0, 1, 1, 2, 2, 2, 3]))))
        except (TypeError, ValueError, RuntimeError, OverflowError, AttributeError, IndexError, OSError):
            raised += 1
    assert raised > 700
    for tracker in trackers:
        tracker.init(FRAME, BOX)
        assert tracker.follow(FRAME).box == BOX


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_a_group_that_cannot_follow_changes_nothing(threads):
    """Not even while the exception is handled: no thread works on."""
    large = np.random.default_rng(3).integers(0, 256, (1200, 1600), np.uint8)
    group = smr.Group(threads)
    for tracker in (smr.Robust(), smr.Paper(), smr.Robust()):
        group.add(tracker, large, (300, 300, 200, 200))
    other = smr.Robust()
    other.init(large[:900], (300, 300, 200, 200))
    targets = list(group.trackers)
    before = [tracker.save() for tracker in targets]
    for trackers, frame, kind, words in [
        ([smr.Robust(), *targets], large, RuntimeError, "there is no target yet: call init first"),
        ([*targets, other], large, ValueError, "the frame has another size than the one that was locked on"),
        ([*targets, targets[0]], large, ValueError, "trackers: expected each tracker once, found one twice"),
        (targets, large.astype(float), TypeError, EXPECTED),
        (targets, None, TypeError, EXPECTED),
    ]:
        group.trackers = trackers
        with pytest.raises(kind, match=words):
            group.follow(np.roll(large, 3, axis=1) if frame is large else frame)
        assert [tracker.save() for tracker in targets] == before
    group.trackers = targets
    expected = [copy.copy(tracker).follow(large) for tracker in targets]
    assert group.follow(large) == expected


def test_from_several_threads_all_members_of_a_group_follow_or_none(synthetic):
    frames, box = synthetic
    group, others = smr.Group(4), smr.Group()
    for number in range(8):
        group.add(smr.Robust() if number % 2 else smr.Paper(), frames[0], box)
    others.trackers = group.trackers[::-1]
    refused, members = [], group.trackers[:]

    def call(follow, frame):
        try:
            follow(frame)
        except RuntimeError as error:
            refused.append(str(error))

    for frame in frames[1:25]:
        calls = [group.follow, others.follow, group.update, others.update]
        threads = [threading.Thread(target=call, args=(one, frame)) for one in calls]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert refused and all("in use by another thread" in words for words in refused)
    assert [len({member.save() for member in members[kind::2]}) for kind in (0, 1)] == [1, 1]
    # Even while another thread updates one tracker of the group, the group updates all of its trackers or none.
    single = threading.Thread(target=lambda: [members[1].follow(frame) for frame in frames[25:75]])
    single.start()
    while single.is_alive():
        call(group.follow, frames[25])
        assert len({member.save() for member in members[::2]}) == 1
    single.join()


def test_a_process_that_forks(synthetic):
    """An object from before a fork works after it, or raises an error with the reason."""
    if not hasattr(os, "fork"):
        pytest.skip("no fork")
    frames, box = synthetic
    group, begun = smr.Group(2), iter(smr.Recording("synthetic"))
    for make in (smr.Robust, smr.Paper, smr.Robust):
        group.add(make(), frames[0], box)
    group.follow(frames[1])
    next(begun)
    results = multiprocessing.get_context("fork").SimpleQueue()

    def child():
        results.put((group.follow(frames[2]), copy.deepcopy(group).follow(frames[3]), len(list(smr.Recording("synthetic")))))
        try:
            next(begun)
        except RuntimeError as error:
            results.put(str(error))

    process = multiprocessing.get_context("fork").Process(target=child)
    process.start()
    process.join(60)
    assert process.exitcode == 0
    second, third, count = results.get()
    assert (second, third, count) == (group.follow(frames[2]), group.follow(frames[3]), len(frames))
    assert "another process began to read this recording" in results.get()
    assert next(begun).shape == frames[0].shape


def test_an_array_is_kept_while_it_is_read():
    """The last reference to a frame is dropped while another thread reads it."""
    tracker = smr.Robust()
    frames = [np.random.default_rng(5).integers(0, 256, (1200, 1600), np.uint8)]
    tracker.init(frames[0], (300, 300, 700, 600))
    answers = [copy.copy(tracker).follow(frames[0])]
    thread = threading.Thread(target=lambda: answers.append(tracker.follow(frames.pop())))
    thread.start()
    while frames:
        pass
    np.zeros((1200, 1600), np.uint8)
    thread.join()
    assert answers[0] == answers[1]


def resident():
    import resource

    gc.collect()
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


@pytest.mark.parametrize("make", [lambda: smr.Robust(reach=4), lambda: smr.Paper(window=(4, 4))])
def test_memory_does_not_grow(make):
    try:
        resident()
    except (ImportError, OSError):
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
    # After 50,000 frames a leak of 32 bytes per frame would be 1.6 MB.
    assert resident() - before < 500_000
