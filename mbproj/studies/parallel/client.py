"""A client of a running Dask cluster, and the errors where there is none."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode, InputError, MbprojError, Place, Problem

if TYPE_CHECKING:
    from distributed import Client

#: Time for a scheduler to answer, s.
CONNECT = 6.0
#: The exceptions of Dask where nobody answers, or the scheduler ends during a call: they vary.
UNREACHABLE = (Exception, asyncio.CancelledError)


@dataclass(frozen=True)
class Cluster:
    """A running cluster: the address of its scheduler, or the file in which the scheduler wrote it."""

    address: str = ""
    file: Path | None = None

    def __str__(self) -> str:
        return self.address if self.file is None else str(self.file)

    @property
    def option(self) -> str:
        """The option of the command line that names the cluster."""
        return "--scheduler" if self.file is None else "--scheduler-file"


class ClusterLost(MbprojError):
    """The error where the scheduler has gone, or has no workers."""

    exit_code = ExitCode.FAILED


@contextmanager
def connected(cluster: Cluster) -> Iterator[Client]:
    """A client of the cluster. Raises InputError, at the option, where there is none."""
    place = Place(cluster.option)
    try:
        from distributed import Client
    except ImportError:
        problem = Problem("this needs the packages of Dask", place, "install them: pip install 'mbproj[cluster]'")
        raise InputError(problem) from None
    address = cluster.address if cluster.file is None else _address_in(cluster.file, place)
    _silence()
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except UNREACHABLE as error:
        hint = "start one with 'dask scheduler', or say where it is: tcp://host:8786"
        raise InputError(Problem(f"there is no scheduler at '{address}'", place, hint)) from error
    try:
        yield client
    finally:
        with suppress(*UNREACHABLE):
            client.close(timeout=1.0)


def _silence() -> None:
    """Silence Dask's own messages in this process: mbproj reports what concerns the user."""
    for name in list(logging.root.manager.loggerDict):
        if name.split(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _address_in(file: Path, place: Place) -> str:
    """The address that a scheduler has written into a file."""
    try:
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        if isinstance(address, str):
            return address
    except OSError as error:
        hint = f"the scheduler writes it: dask scheduler --scheduler-file {file}"
        raise InputError(Problem(f"cannot read '{file}': {error.strerror}", place, hint)) from error
    except (ValueError, KeyError, TypeError):
        pass
    raise InputError(Problem(f"'{file}' is not a file of a Dask scheduler", place))


def workplace(jobs: int | Cluster | None, scheduler: str | None, scheduler_file: Path | None) -> int | Cluster | None:
    """The place where the work is done: a number of processes, or a cluster. Raises InputError where two are given, or
    the cluster cannot be reached."""
    given = [name for name, value in (("--jobs", jobs), ("--scheduler", scheduler)) if value is not None]
    given += [] if scheduler_file is None else ["--scheduler-file"]
    if len(given) > 1:
        what = f"'{given[0]}' and '{given[1]}' exclude each other"
        raise InputError(Problem(what, Place(given[1]), "a cluster has its own workers"))
    if scheduler is None and scheduler_file is None:
        return jobs
    cluster = Cluster(scheduler or "", scheduler_file)
    with connected(cluster):  # raises before the work begins
        return cluster
