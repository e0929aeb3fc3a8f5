"""What the tests share: the program host-sim, and recordings."""

import json
import os
import pathlib
import shutil
import subprocess

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


def recorded(name):
    """The path of a recording, for a parameter; a missing one is skipped by its name."""
    path = SEQUENCES / name
    missing = pytest.mark.skipif(not path.is_dir(), reason=f"no recording {name}: set SMR_SEQUENCES")
    return pytest.param(str(path), id=name, marks=missing)
