"""What a run of the five-bar (10 s, RK4, steps of 10 ms) takes around its integration, in processor time.

    python scripts/bench_run.py parts [TIMES]     in one process: read, compile, assemble, simulate, the same recorded
    python scripts/bench_run.py start [TIMES]     the command `mbproj run`, beyond importing numpy, h5py, yaml and click

The integration is the kernel's own march over the same steps, without anything around it. Medians, and the least.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.dynamics import State, unique_components
from mbproj.integrate.formulations.choice import choose
from mbproj.model import System
from mbproj.results import ResultsWriter
from mbproj.scene import Settings

ROOT = Path(__file__).parents[1]
SCENE = ROOT / "mechanisms" / "five_bar.yaml"
IMPORTS = "import numpy, h5py, yaml, click"
PROGRAM = "from mbproj.cli import main; main()"


def parts(times: int) -> None:
    """The parts of a run in one process, and how many integrations they take."""
    with tempfile.TemporaryDirectory() as folder:
        rows = np.array([one_run(Path(folder) / f"{run}.h5") for run in range(times + 2)])[2:]
    names = (
        "read",
        "compile",
        "assemble",
        "simulate",
        "recorded in a new file",
        "recorded over an old one",
        "integration alone",
    )
    for name, column in zip(names, 1e3 * rows.T, strict=True):
        print(f"{name}: {np.median(column):.2f} ms, least {column.min():.2f} ms")
    for how, reached in (("median", np.median(rows, axis=0)), ("least", rows.min(axis=0))):
        new, other = (reached[4:6] - reached[3]) / reached[6]
        without = reached[:4].sum() / reached[6]
        print(f"{how}: without recorder {without:.1f} integrations, a new file {new:.1f} more, an old one {other:.1f}")


def one_run(output: Path) -> list[float]:
    """Seconds of each part."""
    clock = [process_time()]
    scene = read_scene(SCENE)
    clock.append(process_time())
    system = compile_system(scene)
    clock.append(process_time())
    state, settings = assemble(system, initial_guess(scene, system)), settings_to_run(scene)
    clock.append(process_time())
    simulate(system, state, settings)
    clock.append(process_time())
    for _ in range(2):  # the second time the file is there, and is checked first
        with ResultsWriter(output, scene, system.names.as_mapping(), unique_components(system, state)) as recorder:
            simulate(system, state, settings, recorder, keep=recorder.keep)
        clock.append(process_time())
    return [*np.diff(clock).tolist(), integration(system, state, settings)]


def integration(system: System, state: State, settings: Settings) -> float:
    """Seconds that the kernel marches."""
    compiled = choose(system, state, settings).compiled
    assert compiled is not None, "this needs the compiled kernel"
    run = compiled.run(state, settings)
    begun = process_time()
    while run.outcome.status == compiled.core.Status.running:
        run.advance(1000, 10.0)
    return process_time() - begun


def start(times: int) -> None:
    """The command beside the imports, in turn."""
    with tempfile.TemporaryDirectory() as folder:
        run = [PROGRAM, "run", str(SCENE), "-q", "-o", str(Path(folder) / "results.h5")]
        rows = np.array([[seconds([IMPORTS]), seconds(run)] for _ in range(times + 1)])[1:]
    (imports, command), least = np.median(rows, axis=0), rows.min(axis=0)
    print(f"imports {imports:.3f} s, the command {command:.3f} s: {command - imports:.3f} s beyond them")
    print(f"least: {least[0]:.3f} s, {least[1]:.3f} s: {least[1] - least[0]:.3f} s")


def seconds(arguments: list[str]) -> float:
    """Processor time of a program of its own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", *arguments], check=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    what, *count = sys.argv[1:] or ["help"]
    measures = {"parts": (parts, 25), "start": (start, 9)}
    if what not in measures:
        raise SystemExit(__doc__)
    measure, usual = measures[what]
    measure(int(*count) if count else usual)


if __name__ == "__main__":
    main()
