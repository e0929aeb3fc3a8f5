"""The figures of host-sim over many recordings."""

import os
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any, Optional, Union

from ._smr import Robust, Stop, Tracker, measure, recordings

Path = Union[str, "os.PathLike[str]"]


def evaluate(
    paths: Union[Path, Sequence[Path]],
    trackers: Union[Tracker, Mapping[str, Tracker], None] = None,
    *,
    starts: Union[str, int] = "given",
    executor: Optional[Executor] = None,
) -> dict[str, list[Any]]:
    """Runs trackers over recordings with ground truth and returns the figures of `host-sim eval --robustness`.

    `paths` is a recording, a folder of recordings, or a list of them. `trackers` is a tracker, or a dict of trackers by name: only
    their options are used. `starts` is "given" (the first box), "near" (five boxes around it), or a number N (every N-th frame).

    `executor` is any `concurrent.futures` executor with a `submit`, such as Dask's `Client.get_executor()`. Each recording is one task. Paths
    must be valid where the tasks run. Without it, there is one thread for each core.

    Returns a dict of lists, one row for each tracker and recording: `pandas.DataFrame(smr.evaluate(...))`. A recording that cannot be measured
    causes a warning and has no rows. Raises ValueError if none could be measured.
    """
    if isinstance(paths, (str, os.PathLike)):
        paths = [paths]
    if trackers is None:
        trackers = Robust()
    if isinstance(trackers, Tracker):
        trackers = {type(trackers).__name__.lower(): trackers}
    if not isinstance(trackers, dict) or not all(isinstance(one, Tracker) for one in trackers.values()):
        raise TypeError(f"trackers: expected a tracker such as smr.Robust(), or a dict of trackers by name, found {trackers!r}")
    found = recordings(paths)
    if not found:
        raise ValueError("paths: expected a recording, a folder of recordings, or a list of them, found an empty list")
    if executor is not None:
        return _rows(executor, found, trackers, starts)
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        return _rows(threads, found, trackers, starts)


def _rows(executor: Executor, found: Sequence[Path], trackers: Mapping[str, Tracker], starts: Union[str, int]) -> dict[str, list[Any]]:
    stop = Stop()
    futures = [executor.submit(measure, path, trackers, starts, stop) for path in found]
    tables, failures = [], []
    try:
        for future in futures:
            try:
                tables.append(future.result())
            except ValueError as error:
                failures.append(str(error))
    except BaseException:  # KeyboardInterrupt, for example: whoever waits for the executor waits no longer.
        for future in futures:
            future.cancel()
        stop.end()
        raise
    if not tables:
        raise ValueError("; ".join(failures))
    for failure in failures:
        warnings.warn(failure, stacklevel=3)
    # Rows ordered by tracker, as in host-sim.
    order = [(number, row) for row in range(len(trackers)) for number in range(len(tables))]
    return {name: [tables[number][name][row] for number, row in order] for name in tables[0]}
