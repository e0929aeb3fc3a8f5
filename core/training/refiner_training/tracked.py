"""The boxes of the tracker without the refiner, whose errors the refiner learns to correct. They are computed by `host-sim` and cached."""

import hashlib
import os
import shutil
import subprocess
from pathlib import Path

from .errors import BadInput


class HostSim:
    """Runs the program `host-sim`."""

    def __init__(self, path):
        found = shutil.which(path)
        if found is None:
            raise BadInput(f"no host-sim at {path}: build it (cargo build --release -p host-sim), or name it with --host-sim")
        self.path = Path(found).resolve()
        self.digest = hashlib.sha256(self.path.read_bytes()).hexdigest()

    def version(self):
        return self.run("--version").strip()

    def run(self, *arguments):
        try:
            done = subprocess.run([self.path, *map(str, arguments)], capture_output=True, text=True, check=False)
        except OSError as error:
            raise BadInput(f"{self.path} does not run: {error.strerror}") from error
        if done.returncode:
            said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise BadInput(f"host-sim {' '.join(map(str, arguments))}: {said[0]}")
        return done.stdout

    def tracked(self, recording, cache):
        """The file of the tracker's boxes, created if it is missing."""
        path = cache / "tracked" / f"{recording.name}-{recording.digest[:16]}-{self.digest[:16]}.txt"
        if not path.exists():
            answers = self.run("track", recording.folder, "--method", "robust", "--set", "refiner=off", "--format", "tld")
            path.parent.mkdir(parents=True, exist_ok=True)
            unfinished = path.with_suffix(f".{os.getpid()}")
            unfinished.write_text(answers)
            unfinished.rename(path)
        return path
