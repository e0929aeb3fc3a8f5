"""The figures are those of `host-sim eval`."""

import concurrent.futures
import json
import multiprocessing
import os
import signal
import warnings

import pytest
import smr
from conftest import followed

RECORDINGS = ["synthetic", "border", "noise"]
# The time is the only figure that differs from run to run.
TIME = "microseconds_per_frame"


def figures(columns):
    """All but the time, row by row."""
    names = [name for name in columns if name not in (TIME, "options")]
    return [dict(zip(names, row)) for row in zip(*(columns[name] for name in names))]


def test_figures_are_those_of_host_sim(host_sim):
    trackers = {"paper": smr.Paper("paper"), "robust": smr.Robust()}
    recordings = RECORDINGS[:2]
    for starts, options in [("given", ["--starts=1"]), ("near", []), (20, ["--starts=every:20"])]:
        measured = smr.evaluate(recordings, trackers, starts=starts)
        text = host_sim("eval", "--robustness", "--method=paper,robust", *options, *recordings, "--json")
        rows = json.loads(text)["measured"]
        expected = [{name: value for name, value in row.items() if name not in (TIME, "options")} for row in rows]
        assert figures(measured) == expected
        assert all(0 < time < 1e6 for time in measured[TIME])
    small = json.loads(host_sim("eval", "--robustness", "--config=small", "--starts=1", "border", "--json"))["measured"]
    expected = [{name: value for name, value in row.items() if name not in (TIME, "options")} for row in small]
    assert figures(smr.evaluate("border", smr.Robust("small"))) == expected


def test_scores_are_those_of_host_sim(host_sim, synthetic):
    recording = smr.Recording("synthetic")
    answers = followed(smr.Robust(), list(recording), recording.start)
    score = recording.score([recording.start, *(None if answer.state == smr.State.LOST else answer.fine_box for answer in answers)])
    (expected,) = json.loads(host_sim("eval", "--method=robust", "synthetic", "--json"))["measured"]
    # VOT's figures require a confidence, which these answers lack.
    compared = {name: value for name, value in score.items() if not name.startswith("vot")}
    assert len(compared) == 12 and compared == {name: expected[name] for name in compared}
    assert score["frames"] == len(recording.truth) == 240


def test_recordings_are_found_and_named(tmp_path, host_sim):
    for name in ("b", "a"):
        host_sim("convert", "border", "-o", tmp_path / "all" / name)
    (tmp_path / "all" / "c").mkdir()
    (tmp_path / "all" / "c" / "1.png").write_bytes(b"no picture")
    found = smr.recordings([tmp_path / "all"])
    assert [path.name for path in found] == ["a", "b", "c"]
    with pytest.warns(UserWarning, match="1.png|ground truth"):
        measured = smr.evaluate(tmp_path / "all")
    assert measured["sequence"] == ["a", "b"] and measured["tracker"] == ["robust"] * 2
    with pytest.raises(ValueError, match="c"):
        smr.evaluate(found[2])


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_processes(start):
    expected = figures(smr.evaluate(RECORDINGS))
    # Starts processes after this process has used threads, which a fork does not copy.
    context = multiprocessing.get_context(start)
    with warnings.catch_warnings(), concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as executor:
        warnings.simplefilter("ignore", DeprecationWarning)
        assert figures(smr.evaluate(RECORDINGS, executor=executor)) == expected


def test_dask_goes_on_when_a_worker_is_killed(tmp_path):
    distributed = pytest.importorskip("distributed", reason="no distributed (Dask)")
    names = RECORDINGS * 4
    expected = figures(smr.evaluate(names))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path)
    ) as cluster, distributed.Client(cluster) as client:
        executor = Killing(client.get_executor(), str(tmp_path / "killed"))
        assert figures(smr.evaluate(names, executor=executor)) == expected
    assert (tmp_path / "killed").exists()


class Killing:
    """The executor of Dask. One of the tasks kills its worker the first time that it runs."""

    def __init__(self, executor, marker):
        self.executor, self.marker, self.count = executor, marker, 0

    def submit(self, function, path, *arguments):
        self.count += 1
        if self.count == 5:
            return self.executor.submit(killed_once, function, path, *arguments, marker=self.marker)
        return self.executor.submit(function, path, *arguments)


def killed_once(function, path, *arguments, marker):
    try:
        os.close(os.open(marker, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return function(path, *arguments)
    os.kill(os.getpid(), signal.SIGKILL)
