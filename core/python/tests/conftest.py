"""Fixtures of the tests: the program host-sim, recordings, and the programs of the package."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys

import pytest
import smr

SEQUENCES = pathlib.Path(
    os.environ.get("SMR_SEQUENCES") or pathlib.Path(__file__).parents[4] / "shared" / "sequences"
)


@pytest.fixture(scope="session")
def host_sim():
    """Runs the program that the environment variable HOST_SIM names and returns what it prints."""
    program = os.environ.get("HOST_SIM") or shutil.which("host-sim")
    if program is None:
        pytest.skip("no host-sim: set HOST_SIM")
    return lambda *arguments: subprocess.run(
        [program, *map(str, arguments)], check=True, capture_output=True, text=True
    ).stdout


@pytest.fixture(scope="session")
def track(host_sim):
    """The lines of `host-sim track --json`."""
    return lambda *arguments: [json.loads(line) for line in host_sim("track", *arguments, "--json").splitlines()]


@pytest.fixture(scope="session")
def synthetic():
    """The frames and the first box of a built-in recording."""
    recording = smr.Recording("synthetic")
    return list(recording), recording.start


def followed(tracker, frames, start):
    """The answers in all frames but the first, in which it starts."""
    tracker.init(frames[0], start)
    return [tracker.follow(frame) for frame in frames[1:]]


def run(*arguments, **environment):
    """Runs `python -m` with these arguments, without a display."""
    environment = {**{name: value for name, value in os.environ.items() if name != "DISPLAY"}, **environment}
    return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, env=environment, timeout=60)


def refuses(arguments, reason, **environment):
    """Fails unless `python -m` says in one line what is wrong, and ends with code 2."""
    ran = run(*arguments, **environment)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr.startswith(f"error: {reason}") and ran.stderr.count("\n") == 1


def interrupted(wait, program, *arguments, before=""):
    """The exit code of `python -m PROGRAM`, and what it prints after `wait` and an interrupt."""
    # Restores Python's handler of interrupts, because a background job and its child processes ignore interrupts.
    script = f"import runpy, signal, sys, itertools, smr\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n{before}\n"
    script += f"sys.argv = {[program, *arguments]}\nrunpy.run_module({program!r}, run_name='__main__')\n"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        wait(running)
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=30)
    return running.returncode, out, err


def recorded(name):
    """The path of a recording, for a parameter; a missing one is skipped by its name."""
    path = SEQUENCES / name
    missing = pytest.mark.skipif(not path.is_dir(), reason=f"no recording {name}: set SMR_SEQUENCES")
    return pytest.param(str(path), id=name, marks=missing)
