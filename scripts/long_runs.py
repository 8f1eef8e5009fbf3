"""What the longest runs cost in memory, in time and in bytes.

    python scripts/long_runs.py memory [SAMPLES ...]   peak memory of `mbproj run`, and of what reads its results
    python scripts/long_runs.py writing [SAMPLES]      the results file beside what h5py takes for the same arrays
    python scripts/long_runs.py chunks [SAMPLES]       chunks and compressions: bytes, times to write and read

Times are processor time, the least of three in turn. Results files come to a folder that is removed at the end.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parents[1]))

from kernel_bench.scenes import chain

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.base.settings import Settings
from mbproj.results.writer import ResultsWriter, chunk_rows
from mbproj.scene.scene import Scene

ROOT = Path(__file__).parents[1]
PROGRAM = "from mbproj.commands.main import main; main()"
#: A mechanism in the plane, one in space, and many bodies.
CHAIN, LINKS = "chain of 30 in space", 30
SCENES = ("five_bar", "spatial_slider_crank", CHAIN)
REPEATED = 3
#: Samples of a block, as `simulate` hands them over.
BLOCK = 1000
#: By name: what h5py's `create_dataset` takes.
FILTERS: Mapping[str, Mapping[str, Any]] = {
    "none": {},
    "lzf": {"compression": "lzf"},
    "shuffle, lzf": {"compression": "lzf", "shuffle": True},
    "gzip 1": {"compression": "gzip", "compression_opts": 1},
    "shuffle, gzip 1": {"compression": "gzip", "compression_opts": 1, "shuffle": True},
    "shuffle, gzip 4": {"compression": "gzip", "compression_opts": 4, "shuffle": True},
}
#: Samples and bytes that a chunk has at most.
CHUNKS = ((128, 2**18), (512, 2**18), (2048, 2**18), (2048, 2**20), (8192, 2**20))

Arrays = Mapping[str, npt.NDArray[Any]]


class Kept:
    """A recorder that keeps its blocks."""

    def __init__(self) -> None:
        self.blocks: list[Arrays] = []

    def write(self, block: Arrays) -> None:
        """Takes a block."""
        self.blocks.append({path: np.array(values) for path, values in block.items()})


def recorded(name: str, samples: int) -> tuple[Scene, Mapping[str, Sequence[str]], Arrays]:
    """A scene, the names of its columns, and the arrays of a run of 10 s with so many samples."""
    if name == CHAIN:
        drawn = chain(LINKS, planar=False)
        settings = Settings(duration=10.0, step=10.0 / samples, integrator="rk4")
        scene = replace(drawn, settings=settings)
    else:
        interval = f"{10.0 / samples:.17g}"
        given = {"duration": "10", "step": interval, "output_step": interval}
        scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml", {}, given)
    system, kept = compile_system(scene), Kept()
    simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), kept)
    arrays = {path: np.concatenate([block[path] for block in kept.blocks]) for path in kept.blocks[0]}
    return scene, system.names.as_mapping(), arrays


def blocks(arrays: Arrays) -> Iterator[Arrays]:
    """The arrays in blocks."""
    for first in range(0, len(arrays["time"]), BLOCK):
        yield {path: values[first : first + BLOCK] for path, values in arrays.items()}


def least(*works: Callable[[], object]) -> list[float]:
    """The least processor time of each piece of work, all in turn."""
    found = [[_seconds(work) for work in works] for _ in range(REPEATED)]
    return [min(column) for column in zip(*found, strict=True)]


def _seconds(work: Callable[[], object]) -> float:
    begun = process_time()
    work()
    return process_time() - begun


def by_h5py(path: Path, arrays: Arrays, most: tuple[int, int], options: Mapping[str, Any]) -> None:
    """All arrays, each at once, with Fletcher-32."""
    with h5py.File(path, "w", libver=("v110", "v110")) as file:
        for name, values in arrays.items():
            row = values[0].nbytes if len(values) else 0
            rows = max(1, min(most[0], most[1] // max(1, row)))
            chunks = (rows, *(max(1, size) for size in values.shape[1:]))
            limits = (None, *(size or None for size in values.shape[1:]))
            file.create_dataset(
                name, data=values, chunks=chunks, maxshape=limits, fletcher32=True, track_times=False, **options
            )


def writing(samples: int) -> None:
    """The writer beside h5py, which is given the same arrays, chunks and checksums at once."""
    for name in SCENES:
        scene, names, arrays = recorded(name, samples)
        handed = list(blocks(arrays))
        with tempfile.TemporaryDirectory() as folder:

            def ours(path: Path = Path(folder) / "ours.h5", handed: list[Arrays] = handed) -> None:
                with ResultsWriter(path, scene, names) as writer:  # noqa: B023
                    for block in handed:
                        writer.write(block)

            def theirs(path: Path = Path(folder) / "theirs.h5", arrays: Arrays = arrays) -> None:
                by_h5py(path, arrays, (chunk_rows(()), 2**18), {})

            own, other = least(ours, theirs)
            sizes = [(Path(folder) / f"{whose}.h5").stat().st_size / 1e6 for whose in ("ours", "theirs")]
        print(
            f"{name}: {len(arrays['time'])} samples, {sizes[0]:.0f} MB in {own:.2f} s; h5py {sizes[1]:.0f} MB "
            f"in {other:.2f} s; {own / other:.2f} times"
        )


def chunks(samples: int) -> None:
    """Bytes a sample, and µs a sample to write, to read all and to read one column of the bodies' positions, by size of
    chunks and compression."""
    for name in SCENES:
        _, _, arrays = recorded(name, samples)
        plain = sum(values.nbytes for values in arrays.values()) / len(arrays["time"])
        print(f"{name}: {plain:.0f} bytes of numbers a sample\n  chunks, filters: bytes, write, read, one column")
        with tempfile.TemporaryDirectory() as folder:
            for most in CHUNKS:
                for filters, options in FILTERS.items():
                    path = Path(folder) / "chunks.h5"
                    (wrote,) = least(lambda: by_h5py(path, arrays, most, options))  # noqa: B023
                    size = path.stat().st_size / len(arrays["time"])
                    whole, column = least(lambda: read_all(path), lambda: read_column(path))  # noqa: B023
                    scale = 1e6 / len(arrays["time"])
                    times = "  ".join(f"{scale * each:6.2f}" for each in (wrote, whole, column))
                    print(f"  {most[0]:5} ≤ {most[1] // 1024:4} kB  {filters:16} {size:7.0f}  {times}", flush=True)


def read_all(path: Path) -> None:
    """Every array, one after another."""

    arrays: dict[str, object] = {}

    def read(name: str, found: object) -> None:  # a value returned would end the visit
        if isinstance(found, h5py.Dataset):
            arrays[name] = found[...]

    with h5py.File(path) as file:
        file.visititems(read)


def read_column(path: Path) -> None:
    """The x of the first body."""
    with h5py.File(path) as file:
        _ = file["bodies/position"][:, 0, 0]


def memory(*samples: int) -> None:
    """Peak memory in MB of the commands, in processes of their own."""
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder) / "results.h5"
        for count in samples:
            step = f"{10.0 / count:.17g}"
            scene = Path(folder) / "five_bar.yaml"  # without what it expects, for which results are read again
            scene.write_text((ROOT / "mechanisms" / "five_bar.yaml").read_text().partition("\nexpect:")[0] + "\n")
            written = peak("run", scene, "--duration", "10", "--step", step, "--output-step", step, "-q", "-o", results)
            size = results.stat().st_size / 1e6
            said = [f"{name} {peak(*words):.0f}" for name, words in _readers(results, Path(folder)).items()]
            print(f"{count} samples, {size:.0f} MB: run {written:.0f}, {', '.join(said)}", flush=True)


def _readers(results: Path, folder: Path) -> dict[str, tuple[object, ...]]:
    """The commands that read results, by name."""
    return {
        "info": ("info", results),
        "info --check": ("info", results, "--check"),
        "compare-results": ("compare-results", results, results),
        "plot": ("plot", results, "-o", folder, "--force"),
        "export (one body)": ("export", results, "--table", "body-bar1", "-o", folder, "--force"),
    }


def peak(*words: object) -> float:
    """The peak memory of a command, MB."""
    command = [sys.executable, "-c", PROGRAM, *map(str, words)]
    surroundings = {**os.environ, "PYTHONPATH": str(ROOT)}
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=surroundings)
    _, status, usage = os.wait4(running.pid, 0)
    if status:
        raise RuntimeError(f"{words} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_maxrss / 1024


def main() -> None:
    """Does what the arguments say."""
    parts: dict[str, tuple[Callable[..., object], list[int]]] = {
        "memory": (memory, [10_000, 100_000, 1_000_000]),
        "writing": (writing, [50_000]),
        "chunks": (chunks, [20_000]),
    }
    what, *numbers = sys.argv[1:] or [""]
    if what not in parts:
        sys.exit(__doc__)
    work, usual = parts[what]
    work(*([int(number) for number in numbers] or usual))


if __name__ == "__main__":
    main()
