"""Shows the progress of a stage on a line of standard error, if that is a terminal."""

import sys
import time


class Progress:
    """`with Progress("frames", 90) as progress: progress.advance()`"""

    def __init__(self, stage, total):
        self.stage, self.total, self.done = stage, total, 0
        self.shown = sys.stderr.isatty()
        self.start = self.last = time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.shown:
            self.show("")
            print(file=sys.stderr)

    def advance(self, count=1, note=""):
        self.done += count
        if self.shown and time.monotonic() - self.last > 0.2:
            self.show(note)

    def show(self, note):
        self.last = time.monotonic()
        print(f"\r{self.stage}: {self.done}/{self.total}, {self.last - self.start:.0f} s {note}\033[K", end="", file=sys.stderr, flush=True)
