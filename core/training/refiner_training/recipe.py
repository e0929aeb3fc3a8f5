"""The recipe of a weights file, as JSON beside it: all that is needed to train it again and to detect differences."""

import hashlib
import importlib.metadata
import json
import platform

PACKAGES = ("jax", "jaxlib", "numpy", "opencv-python-headless")


def recipe(command, options, host_sim, recordings, tracked, weights, report):
    return {
        "command": command,
        **options,
        "versions": versions() | {"host-sim": host_sim.version()},
        "recordings": [described(recording, path) for recording, path in zip(recordings, tracked)],
        "weights": {"bytes": len(weights), "sha256": hashlib.sha256(weights).hexdigest()},
        "report": report,
    }


def versions():
    return {"python": platform.python_version()} | {package: version(package) for package in PACKAGES}


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def described(recording, tracked):
    """A recording's hashes: `sha256` of the video and the truth, `tracked` of the tracker's boxes."""
    return {"name": recording.name, "sha256": recording.digest, "tracked": hashlib.sha256(tracked.read_bytes()).hexdigest()}


def text(content):
    """Formats the recipe as JSON with one line per recording."""
    lines = json.dumps(content, indent=1, ensure_ascii=False)
    for recording in content["recordings"]:
        lines = lines.replace(json.dumps(recording, indent=1).replace("\n", "\n  "), json.dumps(recording))
    return lines + "\n"
