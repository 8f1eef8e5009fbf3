"""What a results file keeps in memory does not grow with the run."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from functools import partial
from math import prod
from pathlib import Path

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.motion import marks as run_marks
from mbproj.motion.marks import Keeping, Mark, Marks
from mbproj.results import writer
from mbproj.results.analysis.tables import tables
from mbproj.results.check import check_results
from mbproj.results.file import contents
from mbproj.results.file.contents import CHUNK_CACHE
from mbproj.results.reader import open_own_results
from mbproj.results.record import Results
from mbproj.results.writer import ResultsWriter, chunk_rows
from tests.cli.commands import FIVE_BAR

#: What HDF5 may keep of the chunks of all datasets together, bytes.
CHUNKS = 2**24
FIXED = {"step": "1e-3"}
BY_ERROR = {"tolerance": "1e-6", "integrator": "dopri5"}


def record(samples: int, options: dict[str, str], path: Path) -> None:
    """Runs the five-bar and records so many samples."""
    given = {"duration": f"{samples * 1e-3:g}", "output_step": "1e-3", **options}
    scene = read_scene(FIVE_BAR, {}, given)
    system = compile_system(scene)
    state, settings = assemble(system, initial_guess(scene, system)), settings_to_run(scene)
    with ResultsWriter(path, scene, system.names.as_mapping()) as recorder:
        simulate(system, state, settings, recorder, keep=recorder.keep)


def peak_of(work: Callable[[], object]) -> float:
    """The largest memory of Python's that it takes, bytes."""
    tracemalloc.start()
    try:
        work()
        return float(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("long") / "results.h5"
    record(4000, FIXED, path)
    return path


@pytest.mark.parametrize("options", [FIXED, BY_ERROR], ids=["fixed", "by_error"])
def test_memory_does_not_grow_with_the_samples(options, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(writer, "FLUSH_BYTES", 2**19)
    path = tmp_path / "results.h5"
    short, long = (peak_of(partial(record, samples, options, path)) for samples in (1100, 3600))
    assert long < 1.02 * short


@pytest.mark.parametrize("shape", [(), (5, 3), (1000, 4), (20_000, 4)])
def test_chunks_have_room_where_they_are_kept(shape) -> None:
    """A chunk that is not yet full is kept until it is, or it would be read again with each flush."""
    assert chunk_rows(shape) == 1 or chunk_rows(shape) * 8 * prod(shape) <= CHUNK_CACHE["rdcc_nbytes"]


def test_hdf5_keeps_few_chunks(tmp_path) -> None:
    scene = read_scene(FIVE_BAR, {}, {"duration": "0.1", "step": "0.01"})
    system = compile_system(scene)
    path = tmp_path / "results.h5"
    with ResultsWriter(path, scene, system.names.as_mapping()) as recorder:
        kept = [target.id.get_access_plist().get_chunk_cache()[1] for target in recorder._targets.values()]
        assert sum(kept) < CHUNKS
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    with open_own_results(path) as results:
        file = results.contents._file
        read = [file[each.path].id.get_access_plist().get_chunk_cache()[1] for each in results.datasets]
        assert sum(read) < CHUNKS


def test_what_is_read_of_a_large_file_does_not_stay(recorded, monkeypatch) -> None:
    """Arrays that were read stay as long as they are small together; times stay, and read again they are the same."""
    monkeypatch.setattr(contents, "KEPT_BYTES", 800_000)
    with open_own_results(recorded) as results:
        time, first = results.time, results["bodies/position"]
        assert results["bodies/position"] is first  # 480 kB
        assert np.array_equal(results["bodies/velocity"][:, 0], results.body("bar1").velocity)
        again = results["bodies/position"]
        assert again is not first
        assert np.array_equal(again, first)
        assert results.time is time


def _export(results: Results) -> None:
    assert sum(1 for table in tables(results) for _ in table.rows()) == 12 * 4001 + len(results.stored_loads)


def _check(results: Results) -> None:
    assert check_results(results).faults == ()


@pytest.mark.parametrize("read", [_export, _check])
def test_a_file_is_read_in_less_memory_than_it_has_bytes(read, recorded, monkeypatch) -> None:
    """A few of its forty arrays are there at one time."""
    monkeypatch.setattr(contents, "KEPT_BYTES", 2**19)
    with open_own_results(recorded) as results:
        assert peak_of(partial(read, results)) < 0.5 * recorded.stat().st_size


def test_marks_take_a_tenth_of_a_run_and_the_last_is_kept(monkeypatch) -> None:
    """A mark holds all events so far. Here one takes a second, and a block half a second."""
    now, block, kept = [0.0], [0], list[int]()

    def newest() -> Mark:
        now[0] += 1.0
        return {"block": block[0]}

    monkeypatch.setattr(run_marks, "perf_counter", lambda: now[0])
    keeping = Keeping(Marks(newest=newest), lambda mark: kept.append(mark["block"]))
    with pytest.raises(KeyboardInterrupt), keeping.to_the_end():
        for block[0] in range(200):
            keeping.now_and_then()
            now[0] += 0.5
        raise KeyboardInterrupt
    assert kept[0] == 0
    assert kept[-1] == 199
    assert 10 <= len(kept) <= 13
    assert len(kept) <= 0.12 * now[0]


def test_a_mark_is_kept_once() -> None:
    kept = list[int]()
    keeping = Keeping(Marks(newest=lambda: {"block": 1}), lambda mark: kept.append(mark["block"]))
    with keeping.to_the_end():
        keeping.now_and_then()
    assert kept == [1]
