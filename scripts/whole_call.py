"""What a run takes around its steps, in processor time: the least of many repetitions.

    python scripts/whole_call.py parts [TIMES]     read, compile, assemble, simulate and record the five-bar
    python scripts/whole_call.py fixed [TIMES]     the part of `simulate` that does not depend on the duration
    python scripts/whole_call.py start [TIMES]     the command `mbproj run` beside bare imports of what it needs
    python scripts/whole_call.py peer [TIMES]      `simulate` beside programs derived by hand, each right to 1e-5 m

`fixed` fits a line to the times of DOP853 at a tolerance of 1e-7 over 1 to 5 s, all with as many samples: with 1001, as
by default, and with 2. `start` has compiled bytecode in a folder of its own. `peer` takes the settings that
`bench_peers.py` chooses, and counts the whole call, not only its integration.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.rank.uniqueness import unique_components
from mbproj.model.system import System
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.compiled import Compiled
from mbproj.results.writer import ResultsWriter
from mbproj.scene.scene import Scene

ROOT = Path(__file__).parents[1]
SCENES = ("five_bar", "spatial_slider_crank")
FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
IMPORTS = ["-c", "import numpy, h5py, yaml, click"]
#: As the command sets it: NumPy's import starts threads else, which take a third of its time.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
DURATIONS = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
#: The error in m at which programs are compared.
ERROR = 1e-5


def least(times: int, *calls: Callable[[], object]) -> list[float]:
    """The least ms of each call, made in turn so that a slow spell of the machine meets all of them."""
    spans = np.full((times, len(calls)), np.inf)
    for row in spans:
        for at, call in enumerate(calls):
            begun = process_time()
            call()
            row[at] = process_time() - begun
    return [1e3 * each for each in spans.min(axis=0)]


def parts(times: int) -> None:
    """The parts of a run in one process, beside the kernel's march over the same steps."""
    scene = read_scene(FIVE_BAR)
    system, settings = compile_system(scene), settings_to_run(scene)
    state = assemble(system, initial_guess(scene, system))
    compiled = choose(system, state, settings).compiled
    assert compiled is not None, "this needs the compiled kernel"
    with tempfile.TemporaryDirectory() as folder:
        files, old = (Path(folder) / f"{at}.h5" for at in range(2 * times)), Path(folder) / "old.h5"
        record(old, scene, system, state, settings)
        calls: dict[str, Callable[[], object]] = {
            "read": lambda: read_scene(FIVE_BAR),
            "compile": lambda: compile_system(scene),
            "assemble": lambda: assemble(system, initial_guess(scene, system)),
            "choose the formulation": lambda: choose(system, state, settings),
            "simulate": lambda: simulate(system, state, settings),
            "simulate and record in a new file": lambda: record(next(files), scene, system, state, settings),
            "simulate and record over an old file": lambda: record(old, scene, system, state, settings),
            "the integration alone": lambda: integrate(compiled, state, settings),
        }
        for name, span in zip(calls, least(times, *calls.values()), strict=True):
            print(f"{name}: {span:.2f} ms")


def record(output: Path, scene: Scene, system: System, state: State, settings: Settings) -> None:
    """A run in a file."""
    with ResultsWriter(output, scene, system.names.as_mapping(), unique_components(system, state)) as recorder:
        simulate(system, state, settings, recorder, keep=recorder.keep)


def integrate(compiled: Compiled, state: State, settings: Settings) -> None:
    """The kernel's march."""
    run = compiled.run(state, settings)
    while run.outcome.status == compiled.core.Status.running:
        run.advance(1000, 10.0)


def fixed(times: int) -> None:
    """The part of `simulate` that does not depend on the duration, and the rest for each second."""
    for name in SCENES:
        scene = read_scene(ROOT / "mechanisms" / f"{name}.yaml")
        system = compile_system(scene)
        state = assemble(system, initial_guess(scene, system))
        usual = replace(settings_to_run(scene), integrator="dop853", tolerance=1e-7, step=None)
        for samples in (1001, 2):
            runs = [replace(usual, duration=end, output_step=end / (samples - 1)) for end in DURATIONS.tolist()]
            spans = least(times, *(partial(simulate, system, state, each) for each in runs))
            per_second, constant = np.polyfit(DURATIONS, spans, 1)
            print(f"{name}, {samples} samples: fixed {constant:.2f} ms, and {per_second:.2f} ms for each second")


def start(times: int) -> None:
    """The command beside the imports, in turn."""
    with tempfile.TemporaryDirectory() as folder:
        run = ["-m", "mbproj", "run", str(FIVE_BAR), "-q", "-o", str(Path(folder) / "results.h5")]
        spans = np.array([[seconds(IMPORTS, folder), seconds(run, folder)] for _ in range(times + 1)])[1:]
    imports, command = spans.min(axis=0)
    print(f"imports {1e3 * imports:.0f} ms, the command {1e3 * command:.0f} ms: {command / imports:.2f} times")


def seconds(arguments: list[str], bytecode: str) -> float:
    """Processor time of a Python of its own, with compiled bytecode in a folder."""
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": str(ROOT), "PYTHONPYCACHEPREFIX": bytecode}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def peer(times: int) -> None:
    """The whole call beside programs derived by hand."""
    from bench_peers import installed
    from peers.problem import MECHANISMS
    from peers.sweep import sweep

    programs = {each.name: each for each in installed(["mbproj_run", "hand_derived"], "auto")}
    pairs = ("mbproj, auto, DOP853", "hand-derived, DOP853")
    for mechanism in MECHANISMS.values():
        tried = [sweep(programs[name], mechanism, (ERROR,)) for name in pairs]
        chosen = [next(each for each in trials if each.error <= ERROR) for trials in tried]
        own, bound = least(times, *(each.setting.integrate for each in chosen))
        labels = [each.setting.label for each in chosen]
        print(f"{mechanism.name}, {mechanism.duration} s: {own:.2f} ms at {labels[0]}, by hand {bound:.2f} ms ", end="")
        print(f"at {labels[1]}: {own / bound:.1f} times")


def main() -> None:
    what, *count = sys.argv[1:] or ["help"]
    measures = {"parts": (parts, 40), "fixed": (fixed, 40), "start": (start, 9), "peer": (peer, 40)}
    if what not in measures:
        raise SystemExit(__doc__)
    measure, usual = measures[what]
    measure(int(*count) if count else usual)


if __name__ == "__main__":
    main()
