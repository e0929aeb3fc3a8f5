"""A table: its name, what it says, the trackers whose answers it depends on, and the function that measures it."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    name: str
    about: str
    # `paper` and `robust`, as in tests/kit/answers.txt; none for figures of other programs alone.
    trackers: tuple[str, ...]
    # Returns the figures of sentences by name, and the rows of tables by name.
    measure: Callable
