"""What a results file keeps in memory does not grow with the run."""

from __future__ import annotations

import tracemalloc
from math import prod
from pathlib import Path

import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.results import ResultsWriter, open_own_results, writer
from mbproj.results.datasets import chunk_rows
from mbproj.results.file.dataset import CHUNK_CACHE
from tests.cli.commands import FIVE_BAR

#: What HDF5 may keep of the chunks of all datasets together, bytes.
CHUNKS = 2**24
FIXED = {"step": "1e-3"}
BY_ERROR = {"tolerance": "1e-6", "integrator": "dopri5"}


def peak_of(samples: int, options: dict[str, str], path: Path) -> float:
    """The largest memory of Python's that a run with so many samples takes, bytes."""
    given = {"duration": f"{samples * 1e-3:g}", "output_step": "1e-3", **options}
    scene = read_scene(FIVE_BAR, {}, given)
    system = compile_system(scene)
    state, settings = assemble(system, initial_guess(scene, system)), settings_to_run(scene)
    tracemalloc.start()
    try:
        with ResultsWriter(path, scene, system.names.as_mapping()) as recorder:
            simulate(system, state, settings, recorder, keep=recorder.keep)
        return float(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("options", [FIXED, BY_ERROR], ids=["fixed", "by_error"])
def test_memory_does_not_grow_with_the_samples(options, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(writer, "FLUSH_BYTES", 2**20)
    short, long = (peak_of(samples, options, tmp_path / "results.h5") for samples in (2000, 8000))
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
