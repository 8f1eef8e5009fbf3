"""Work on a real Dask cluster of separate processes: what is lost is done again, nobody innocent is blamed."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import pytest

from mbproj.base.errors import InputError
from mbproj.studies.parallel import cluster as dask_client
from mbproj.studies.parallel import cluster as on_dask
from mbproj.studies.parallel.cluster import Cluster, ClusterLost, connected
from mbproj.studies.parallel.hand_out import in_bundles, in_parallel
from mbproj.studies.sweep.run import CaseTask, CaseWork, run_case
from mbproj.studies.sweep.spec import read_spec
from tests.cli.commands import mbproj
from tests.studies.sweep.specs import write
from tests.studies.tasks import fragile, place
from tests.support import ROOT

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="the extra `cluster` is not installed")


# A Dask cluster of separate processes on the loopback: a scheduler, and workers with their nannies.

#: One lost worker is enough to say so: what was on it is tried again alone.
SETTINGS = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0", "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


class Running:
    """The processes of a cluster."""

    def __init__(self, folder: Path, workers: int) -> None:
        self.file = folder / "scheduler.json"
        self._processes = [self._start("scheduler", "--port", "0", "--scheduler-file", str(self.file))]
        wait_until(lambda: self.file.exists() and self.file.read_text().endswith("}"))
        for _ in range(workers):
            self._processes.append(self._start("worker", self.address, "--nthreads", "1"))

    @property
    def address(self) -> str:
        return json.loads(self.file.read_text())["address"]

    def _start(self, what: str, *options: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, **SETTINGS}
        environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        program = [sys.executable, "-m", "dask", what, "--host", "127.0.0.1", "--no-dashboard", *options]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(program, env=environment, start_new_session=True, **quiet)

    def kill_scheduler(self) -> None:
        self._processes[0].send_signal(signal.SIGKILL)
        self._processes[0].wait()

    def stop(self) -> None:
        """Ends all, the workers' own processes too."""
        for process in self._processes:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
            process.wait()


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[Running]:
    running = Running(folder, workers)
    try:
        yield running
    finally:
        running.stop()


def wait_until(holds, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


# Work on a real Dask cluster of separate processes: what is lost is done again, nobody innocent is blamed.

PROGRAM = [sys.executable, "-c", "from mbproj.commands.main import main; main()"]


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    with cluster(tmp_path_factory.mktemp("cluster"), 3) as found:
        yield found


@pytest.mark.full
def test_a_case_that_ends_its_process_and_one_that_hangs_are_blamed_and_no_other(running):
    def lost(item, why, seconds):
        return why.split(":")[0]

    found = dict(
        pair for ended in in_bundles(fragile, 60.0, range(40), Cluster(running.address), lost, 1.5) for pair in ended
    )
    expected = {item: item * item for item in range(40)} | {13: "its worker was lost", 17: "stopped"}
    assert found == expected


@pytest.mark.full
def test_what_the_scheduler_gives_up_is_done_again(running):
    """As happens to a result on a worker that is lost before anybody has fetched it."""
    distributed = pytest.importorskip("distributed")
    found = dict([next(results := in_parallel(fragile, 0.3, [17, *range(12)], Cluster(running.address)))])
    with connected(Cluster(running.address)) as client:
        keys = [key for held in client.processing().values() for key in held]
        client.cancel([distributed.Future(key, client) for key in keys], force=True)
    found |= dict(results)
    assert found == {0: 17**2, **{item + 1: item**2 for item in range(12)}}
    assert keys


@pytest.mark.full
def test_a_connection_that_breaks_before_the_client_knows_is_the_end_of_the_scheduler(running, monkeypatch):
    distributed = pytest.importorskip("distributed")

    def broken(future):
        raise distributed.comm.CommClosedError("Stream is closed")

    monkeypatch.setattr(distributed.Future, "result", broken)
    with pytest.raises(ClusterLost, match=r"is gone; what was computed is kept"):
        list(in_parallel(fragile, 0.1, [1, 2], Cluster(running.address)))


@pytest.mark.full
def test_a_fault_of_a_function_comes_back(running):
    with pytest.raises(ValueError, match="shared -1"):
        list(in_parallel(place, "shared", [0, -1, 0], Cluster(file=running.file)))


@pytest.mark.full
def test_what_is_killed_loses_nothing_and_nothing_is_done_twice(running, tmp_path):
    """A worker is killed in the middle of a sweep, then the leading process, then the scheduler of its successor; a
    third one on this machine does what is left. All numbers are those of one process, to the last bit."""
    path = write(tmp_path, "  length: 1:2:90\n  simulation.duration: 0.9\n  simulation.step: 2e-5\n")
    there = ["--scheduler-file", str(running.file)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    begin = partial(subprocess.Popen, [*PROGRAM, "sweep", "spec.yaml", *there], cwd=tmp_path, env=environment)
    first = begin(stderr=subprocess.DEVNULL)
    log = tmp_path / "spec-sweep" / "store.sqlite-wal"
    wait_until(lambda: log.exists() and log.stat().st_size > 120_000)
    with connected(Cluster(running.address)) as client:
        busy = next(address for address, keys in client.processing().items() if keys)
        os.kill(client.run(os.getpid, workers=[busy])[busy], signal.SIGKILL)
    before = log.stat().st_size
    wait_until(lambda: log.stat().st_size > before + 40_000)
    first.kill()
    first.wait()
    before = log.stat().st_size
    second = begin(stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    wait_until(lambda: log.stat().st_size > before + 40_000)
    running.kill_scheduler()
    _, said = second.communicate(timeout=60)
    assert (second.returncode, b"is gone; what was computed is kept" in said) == (3, True), said
    done = json.loads(mbproj("sweep", "spec.yaml", "--json", folder=tmp_path).stdout)
    assert done["computed"] + done["reused"] == 90
    assert done["reused"] >= 20
    assert done["failed"] == 0
    spec = read_spec(path)
    work = CaseWork(spec.scene, spec.design.paths, spec.measures, None, "none", None)
    with (tmp_path / "spec-sweep" / "summary.csv").open(encoding="utf-8") as file:
        column = [float(row["drop (m)"]) for row in csv.DictReader(file)]
    for number in range(0, 90, 9):
        assert run_case(work, CaseTask("", spec.design.case(number))).values == (column[number],)


def test_a_scheduler_that_is_not_there_is_said_soon(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_client, "CONNECT", 0.5)
    with pytest.raises(
        InputError, match=r"--scheduler: error: there is no scheduler at 'tcp://127.0.0.1:1'; start one"
    ):
        list(in_parallel(place, "x", [0], Cluster("tcp://127.0.0.1:1")))
    missing = Cluster(file=tmp_path / "no.json")
    with pytest.raises(InputError, match=r"--scheduler-file: error: cannot read '.*no.json': No such file"):
        list(in_parallel(place, "x", [0], missing))
    (tmp_path / "no.json").write_text("[1]")
    with pytest.raises(InputError, match=r"no.json' is not a file of a Dask scheduler"):
        list(in_parallel(place, "x", [0], missing))


@pytest.mark.full
def test_a_cluster_without_workers_is_not_waited_for_without_end(monkeypatch, tmp_path):
    monkeypatch.setattr(on_dask, "NO_WORKERS", 0.5)
    with cluster(tmp_path, 0) as empty, pytest.raises(ClusterLost, match=r"has had no workers for 0.5 s; start some"):
        list(in_parallel(place, "x", [0], Cluster(empty.address)))
