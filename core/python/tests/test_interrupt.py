"""Ctrl-C ends every call that can block within a second, and leaves no child process."""

import os
import pathlib
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import smr

pytestmark = [
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="interrupts: no /proc, which lists the children of a process"),
    pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="interrupts: no ffmpeg"),
]
MAX_SECONDS = 1.0

# Restores Python's handler, because a background job and its child processes ignore interrupts.
HEAD = """
import os, signal, sys, threading, time
import numpy, smr
signal.signal(signal.SIGINT, signal.default_int_handler)
def measured(call):
    print("begins", flush=True)
    try:
        call()
        print("returned", flush=True)
    except KeyboardInterrupt:
        print("KeyboardInterrupt", flush=True)
"""


def server(answer):
    """Accepts connections, sends `answer` to each, and no more. Yields its port."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        kept = []

        def accept():
            try:
                while True:
                    kept.append(listening.accept()[0])
                    kept[-1].sendall(answer)
            except OSError:
                pass

        threading.Thread(target=accept, daemon=True).start()
        yield listening.getsockname()[1]


@pytest.fixture
def stalled():
    """The port of a server that accepts connections and sends nothing."""
    yield from server(b"")


@pytest.fixture
def stopped():
    """The address of a live source that stops after 60 frames."""
    frames = b"YUV4MPEG2 W320 H240 F25:1 C420jpeg\n" + 60 * (b"FRAME\n" + bytes(320 * 240 * 3 // 2))
    for port in server(b"HTTP/1.1 200 OK\r\nContent-Type: video/x-yuv4mpeg\r\n\r\n" + frames):
        yield f"http://127.0.0.1:{port}/x.y4m"


@pytest.fixture
def pipe(tmp_path):
    """Makes a pipe of a name, which has a writer that writes what is given, and no more; without a writer for None."""
    opened = []

    def make(name, begin=b""):
        path = tmp_path / name
        os.mkfifo(path)
        if begin is not None:
            opened.append(os.open(path, os.O_RDWR))
            os.write(opened[-1], begin)
        return str(path)

    yield make
    for one in opened:
        os.close(one)


@pytest.fixture(scope="session")
def video(tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "long.mp4"
    subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "testsrc2=s=64x48:r=25:d=400", "-c:v", "mjpeg", str(path)], check=True)
    return str(path)


def children(process):
    """The processes that a process has started and that have not ended."""
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            name, fields = status.read_text().rsplit(")", 1)
        except OSError:
            continue
        if int(fields.split()[1]) == process and fields.split()[0] != "Z":
            found.append(int(name.split()[0]))
    return found


def interrupt(script, *arguments, after=0.7, **environment):
    """Sends SIGINT to a script `after` seconds. Returns what it printed; fails if it takes long to end or leaves a child process."""
    command = [sys.executable, "-c", HEAD + script, *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, **environment}) as running:
        watchdog = threading.Timer(30, running.kill)
        watchdog.start()
        try:
            assert running.stdout.readline() == "begins\n", running.communicate(timeout=10)
            time.sleep(after)
            started = children(running.pid)
            assert running.poll() is None, running.communicate(timeout=10)
            running.send_signal(signal.SIGINT)
            begin = time.monotonic()
            said = running.stdout.readline()
            seconds = time.monotonic() - begin
            said, error = said + running.stdout.read(), running.stderr.read()
            running.wait()
        finally:
            watchdog.cancel()
            running.kill()
    assert seconds < MAX_SECONDS, f"{seconds:.1f} s"
    left = [child for child in started if pathlib.Path(f"/proc/{child}").exists()]
    assert not left and error == "", error
    return said


def ends(call, *arguments, **more):
    assert interrupt(f"measured(lambda: {call})", *arguments, **more) == "KeyboardInterrupt\n"


@pytest.mark.parametrize("address", ["http://127.0.0.1:{}/x.ts", "rtsp://127.0.0.1:{}/x"])
def test_a_live_source_that_sends_nothing(stalled, address):
    ends("smr.Recording(sys.argv[1])", address.format(stalled))


@pytest.mark.parametrize("call", [
    "smr.Recording(sys.argv[1])", "next(iter(smr.Recording(sys.argv[1])))", "smr.Recording(sys.argv[1]).size",
])  # fmt: skip
@pytest.mark.parametrize("name, begin", [
    ("video", b""), ("video", None), ("a.mp4", b""), ("a.mp4", None), ("a.y4m", b""), ("a.y4m", None), ("a.png", b""), ("a.pgm", None),
])  # fmt: skip
def test_a_pipe_that_sends_nothing(pipe, call, name, begin):
    if name in ("a.png", "a.pgm") and call == "smr.Recording(sys.argv[1])":
        call = "list(smr.Recording(sys.argv[1]))"  # Pictures are read later.
    ends(call, pipe(name, begin))


def test_a_live_source_that_stops(stopped):
    said = interrupt(
        """
frames = iter(smr.Recording(sys.argv[1]))
next(frames)
def rest():
    for _ in frames:
        pass
measured(rest)
try:
    next(frames)
except RuntimeError as error:
    print(error)
""",
        stopped,
        after=1.5,
    )
    assert said == "KeyboardInterrupt\nthis iteration was interrupted while it read a frame: iterate over the recording anew\n"


def test_boxes_beside_a_recording_that_are_a_pipe(pipe, tmp_path):
    pipe("init.txt")
    (tmp_path / "1.pgm").write_bytes(b"P5 4 2 255\n" + bytes(8))
    for call in ("smr.Recording(sys.argv[1])", "smr._smr.start_beside(sys.argv[1] + '/1.pgm')", "smr.evaluate(sys.argv[1])"):
        ends(call, tmp_path)


@pytest.mark.parametrize("call", ["len(recording)", "recording.fps", "recording.size", "next(iter(recording))"])
def test_an_ffmpeg_that_does_nothing(video, tmp_path, call):
    """The first ffmpeg opens the recording; the later ones hang."""
    (tmp_path / "ffmpeg").write_text(f"#!/bin/sh\n[ -e {tmp_path}/hang ] && exec sleep 600\nexec {shutil.which('ffmpeg')} \"$@\"\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    script = f"""
recording = smr.Recording(sys.argv[1], color=True)
open({str(tmp_path / "hang")!r}, "w").close()
def call():
    return {call}
measured(call)
"""
    assert interrupt(script, video, PATH=f"{tmp_path}:{os.environ['PATH']}") == "KeyboardInterrupt\n"


@pytest.mark.parametrize("loop", [
    "sum(1 for _ in smr.Recording(sys.argv[1]))", "list(smr.Recording(sys.argv[1], color=True))", "[len(smr.Recording(sys.argv[1])) for _ in range(999)]",
    "[smr.Recording(sys.argv[1]).fps for _ in range(999)]",
])  # fmt: skip
def test_a_video_that_is_read(video, loop):
    ends(loop, video)


@pytest.mark.parametrize("executor", ["None", "futures.ThreadPoolExecutor(2)"])
def test_an_evaluation(executor):
    """Its threads end as well: Python waits for them when it ends."""
    trackers = "{str(n): smr.Robust(patience=n) for n in range(250)}"
    script = f"from concurrent import futures\nmeasured(lambda: smr.evaluate(['synthetic', 'street', 'border'], {trackers}, starts=1, executor={executor}))"
    begin = time.monotonic()
    assert interrupt(script) == "KeyboardInterrupt\n"
    assert time.monotonic() - begin < 10


def test_an_update_of_a_very_large_window():
    script = """
random = numpy.random.default_rng(1)
first, second = (random.integers(0, 256, (4000, 4000), numpy.uint8) for _ in range(2))
tracker = smr.Paper("paper", window=(1800, 1800), window_limit=(1800, 1800), runner_up_always=True)
tracker.init(first, (1900, 1900, 256, 256))
saved = tracker.save()
measured(lambda: tracker.update(second))
print(tracker.save() == saved, tracker.answer)
"""
    assert interrupt(script) == "KeyboardInterrupt\nTrue None\n"


@pytest.mark.parametrize("program", ["smr", "smr.mavlink"])
def test_the_programs(stalled, program):
    pytest.importorskip("pymavlink") if program == "smr.mavlink" else None
    more = ["udpout:127.0.0.1:1"] if program == "smr.mavlink" else ["--box", "1,2,30,40"]
    script = f"""
import runpy, importlib
importlib.import_module("smr.mavlink" if "{program}" == "smr.mavlink" else "smr")
sys.modules.pop("smr.mavlink", None)
sys.argv = ['{program}', *sys.argv[1:]]
print("begins", flush=True)
try:
    runpy.run_module('{program}', run_name='__main__')
except SystemExit as end:
    print(end.code, flush=True)
"""
    assert interrupt(script, f"http://127.0.0.1:{stalled}/x.ts", *more) == "130\n"


def test_the_mavlink_camera_ends_its_ffmpeg(stopped):
    """While its thread waits for a frame of a source that has stopped."""
    pytest.importorskip("pymavlink")
    script = """
import runpy, smr.mavlink
sys.modules.pop("smr.mavlink")
sys.argv = ["smr.mavlink", sys.argv[1], "udpout:127.0.0.1:1"]
print("begins", flush=True)
sys.stderr = sys.stdout
runpy.run_module("smr.mavlink", run_name="__main__")
"""
    assert "Ctrl-C ends it" in interrupt(script, stopped, after=2)


def test_another_thread_closes_an_iteration(stopped):
    # Other tests may have left processes, such as the resource tracker of multiprocessing.
    before = children(os.getpid())
    frames = iter(smr.Recording("synthetic"))
    next(frames)
    frames.close()
    frames.close()
    assert list(frames) == []
    recording = smr.Recording(stopped)
    frames = iter(recording)
    next(frames)
    counts = []
    waiting = threading.Thread(target=lambda: counts.append(len(list(frames))))
    waiting.start()
    time.sleep(0.5)
    assert len(children(os.getpid())) > len(before)
    begin = time.monotonic()
    frames.close()
    waiting.join(10)
    assert time.monotonic() - begin < MAX_SECONDS and len(counts) == 1 and children(os.getpid()) == before


def test_a_handler_may_use_the_package(pipe):
    """The handler of a signal runs while a call waits. It may call trackers, and the call goes on."""
    script = """
frames = list(smr.Recording("synthetic"))
tracker = smr.Robust()
tracker.init(frames[0], (36, 24, 24, 28))
def handle(*_):
    print(tracker.update(frames[1])[0], flush=True)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.kill(os.getpid(), signal.SIGINT)
signal.signal(signal.SIGINT, handle)
measured(lambda: smr.Recording(sys.argv[1]))
"""
    assert interrupt(script, pipe("a.mp4")) == "True\nKeyboardInterrupt\n"


def test_an_uncaught_interrupt_leaves_no_ffmpeg(video):
    script = """
def follow():
    frames = iter(smr.Recording(sys.argv[1]))
    for frame in frames:
        time.sleep(0.01)
print("begins", flush=True)
sys.stderr = open(os.devnull, "w")
follow()
"""
    assert interrupt(script, video) == ""


def test_a_stop_is_pickled():
    stop = smr._smr.Stop()
    stop.end()
    copy = pickle.loads(pickle.dumps(stop))
    with pytest.raises(RuntimeError, match="another thread ended this call"):
        smr._smr.measure("synthetic", {"paper": smr.Paper()}, "given", stop)
    assert smr._smr.measure("synthetic", {"paper": smr.Paper()}, "given", copy)["starts"] == [1]
    assert np.array_equal(next(iter(smr.Recording("synthetic"))), next(iter(smr.Recording("synthetic"))))
