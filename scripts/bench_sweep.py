"""What sweeps cost: many five-bars beside a plain loop, and the study of a thousand lengths beside MuJoCo.

    python scripts/bench_sweep.py overhead [CASES]     five-bars of 1 s: `mbproj sweep` on all processors, a plain loop
    python scripts/bench_sweep.py growth [CASES]       rows of cases that nobody runs: the store, the summary, memory
    python scripts/bench_sweep.py study [CASES]        5 s, tip right to 1e-5 m at the end, one process (extra `peers`)
    python scripts/bench_sweep.py arrays [CASES]       by arrays beside one by one: three mechanisms, bits compared

What is compared alternates in blocks, and is measured by processor time: other programs on the machine slow both down
alike. Say how busy it was: the load average is printed.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter, process_time
from typing import TypeVar

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import mbproj
from mbproj.studies.case_blocks import FEWEST
from mbproj.studies.parallel.hand_out import processors
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import CaseTask, CaseWork, run_case, run_cases, run_sweep
from mbproj.studies.sweep.spec import read_spec
from mbproj.studies.sweep.store import CaseRow, Status
from mbproj.studies.sweep.summary import write_summary

ROOT = Path(__file__).parents[1]
PROGRAM = "from mbproj.commands.main import main; main()"
BLOCKS = 5
SHORT = "  simulation.duration: 1 s\n"
Setting = TypeVar("Setting", int, float)
#: Error at the end that the study allows, m, the lengths at which settings are tried, and these settings.
ERROR, PROBES = 1e-5, (0.9, 0.95, 1.0, 1.05, 1.1)
TOLERANCES = tuple(10.0 ** (-power / 2.0) for power in range(10, 24))
STEPS = tuple(int(500 * 2.0 ** (power / 2.0)) for power in range(14))
FINEST = 1e-13


def spec_of(folder: Path, cases: int, first: float, last: float, simulation: str) -> Path:
    """The file of a sweep of the five-bar's length."""
    path = folder / "lengths.yaml"
    path.write_text(
        f"sweep: 1\nscene: {ROOT / 'mechanisms' / 'five_bar.yaml'}\n"
        f"vary:\n  parameters.length: {first}:{last}:{cases}\n{simulation}"
        "measure:\n  tip: {marker: tip, quantity: position, at: end, component: z}\n",
        encoding="utf-8",
    )
    return path


def cases_of(path: Path) -> Callable[[int], float]:
    """Runs the case of a number as a worker does; the tip's height at the end."""
    spec = read_spec(path)
    work = CaseWork(spec.scene, spec.design.paths, spec.measures, None, "none", None)

    def run(number: int) -> float:
        return run_case(work, CaseTask(str(number), spec.design.case(number))).values[0]

    return run


def overhead(cases: int) -> None:
    """Processor time and pace of a sweep beside those of a plain loop over the same cases."""
    block = cases // BLOCKS
    plain, swept, wall, elapsed = [], [], [], []
    with tempfile.TemporaryDirectory() as temporary:
        for number in range(BLOCKS):
            path = spec_of(Path(temporary), block, 0.8 + 0.08 * number, 0.86 + 0.08 * number, SHORT)
            run = cases_of(path)
            run(0)
            begun, clock = process_time(), perf_counter()
            for case in range(block):
                run(case)
            plain.append((process_time() - begun) / block)
            elapsed.append((perf_counter() - clock) / block)
            start = _swept(spec_of(Path(temporary), 2, 0.8, 0.9, SHORT), Path(temporary) / f"start-{number}")
            path = spec_of(Path(temporary), block, 0.8 + 0.08 * number, 0.86 + 0.08 * number, SHORT)
            whole = _swept(path, Path(temporary) / f"block-{number}")
            swept.append((whole[0] - start[0]) / (block - 2))
            wall.append(whole[1] / block)
            print(f"  plain {1e3 * plain[-1]:.2f} ms a case, sweep {1e3 * swept[-1]:.2f} ms; {load()}", flush=True)
    print(
        f"plain loop, one process: {1e3 * np.median(plain):.2f} ms of processor a case, {1 / np.median(elapsed):.0f} /s"
    )
    pace = f"{1 / np.median(wall):.0f} a second on {processors()} processors, start included"
    print(f"sweep: {1e3 * np.median(swept):.2f} ms of processor a case beyond its start; {pace}")
    print(f"overhead: {100 * (np.median(np.divide(swept, plain)) - 1):.0f} %")


def _swept(path: Path, output: Path) -> tuple[float, float]:
    """Seconds of processor, of all processes, and of the clock that a sweep takes."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", PROGRAM, "sweep", path, "-o", output, "-q"], check=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, perf_counter() - begun


def growth(cases: int) -> None:
    """Processor time and bytes a case of what a sweep does around its cases, and the memory that it takes."""
    with tempfile.TemporaryDirectory() as temporary:
        spec = read_spec(spec_of(Path(temporary), cases // 100, 0.8, 1.2, "  bodies.bar3.mass: 1:2:100\n"))
        folder = Folder(Path(temporary) / "out", spec, fresh=False)

        def keep() -> None:
            for number in range(spec.design.count):
                row = CaseRow(Status.DONE, (float(number),), formulation="planar", seconds=0.02)
                folder.store.add(spec.key_of(spec.design.case(number)), row)

        parts: dict[str, Callable[[], object]] = {
            "keep": keep,
            "find": lambda: run_sweep(spec, folder, 1),
            "summary": lambda: write_summary(spec, folder),
        }
        with folder.store:
            for name, part in parts.items():
                begun = process_time()
                part()
                spent = 1e6 * (process_time() - begun) / spec.design.count
                files = sum(each.stat().st_size for each in folder.path.iterdir()) / spec.design.count
                most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
                print(f"{name}: {spent:.0f} us a case; {files:.0f} bytes a case so far, {most:.0f} MB", flush=True)


def study(cases: int) -> None:
    """Each program at its cheapest setting that is right at the probes, in turn."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        texts = [mjcf(length) for length in PROBES]
        exact = [ours(folder, [length], FINEST)(0) for length in PROBES]
        ours_at = cheapest(TOLERANCES, lambda setting: [ours(folder, [x], setting)(0) for x in PROBES], exact)
        theirs_at = cheapest(STEPS, lambda setting: [theirs(text, setting) for text in texts], exact)
        print(f"mbproj: dop853, tolerance {ours_at:.1e}; MuJoCo: RK4, {theirs_at} steps of {5 / theirs_at:.2e} s")
        lengths = np.linspace(PROBES[0], PROBES[-1], cases).tolist()
        models = [mjcf(length) for length in lengths]
        run = ours(folder, lengths, ours_at)
        run(0)
        spent = np.zeros(2)
        apart = 0.0
        for block in np.array_split(np.arange(cases), BLOCKS):
            begun = process_time()
            heights = [run(number) for number in block.tolist()]
            middle = process_time()
            others = [theirs(text, theirs_at) for text in models[block[0] : block[-1] + 1]]
            spent += middle - begun, process_time() - middle
            apart = max(apart, float(np.abs(np.subtract(heights, others)).max()))
    print(f"mbproj {1e3 * spent[0] / cases:.2f} ms a case, MuJoCo {1e3 * spent[1] / cases:.2f} ms; {load()}")
    print(f"MuJoCo takes {spent[1] / spent[0]:.1f} times as long; the two are at most {apart:.1e} m apart")


#: By name: what varies, and what is measured. The tolerances leave 1e-5 m of 5 s, 1e-6 m of 1 s and of 1 s.
BY_ARRAYS = {
    "five_bar": (
        "parameters.length: 0.9:1.1",
        "5 s",
        "3e-8",
        "{marker: tip, quantity: position, component: z, at: end}",
    ),
    "planar_four_bar": ("parameters.speed: 10:14", "1 s", "1e-8", "{joint: A, quantity: angle, at: end}"),
    "spatial_slider_crank": (
        "parameters.speed: 5:7",
        "1 s",
        "1e-8",
        "{marker: slider, quantity: position, component: x, at: end}",
    ),
}


def by_arrays(cases: int) -> None:
    """Processor time of blocks of cases by arrays, and of the same cases one by one, in turn."""
    for name, (vary, duration, tolerance, measure) in BY_ARRAYS.items():
        with tempfile.TemporaryDirectory() as temporary:
            path = Path(temporary) / "spec.yaml"
            path.write_text(
                f"sweep: 1\nscene: {ROOT / 'mechanisms' / f'{name}.yaml'}\nvary:\n  {vary}:{cases}\n"
                f"  simulation.duration: {duration}\n  simulation.output_step: {duration}\n"
                f"  simulation.tolerance: {tolerance}\n  simulation.integrator: dop853\nmeasure:\n  it: {measure}\n",
                encoding="utf-8",
            )
            spec = read_spec(path)
        work = CaseWork(spec.scene, spec.design.paths, spec.measures, None, "none", None)
        tasks = [CaseTask(str(number), spec.design.case(number)) for number in range(spec.design.count)]
        run_cases(work, tasks[:FEWEST])
        spent, arrays = np.zeros(2), 0
        for block in np.array_split(np.arange(cases), BLOCKS):
            own = [tasks[number] for number in block.tolist()]
            begun = process_time()
            rows = run_cases(work, own)
            middle = process_time()
            alone = [run_case(work, task) for task in own]
            spent += middle - begun, process_time() - middle
            arrays += sum(row.by_arrays for row in rows)
            assert [row.values for row in rows] == [row.values for row in alone]
        together, single = 1e3 * spent / cases
        print(f"{name}: {arrays} of {cases} by arrays, {together:.2f} ms a case; one by one {single:.2f} ms, ", end="")
        print(f"{single / together:.1f} times as long; the same bits; {load()}", flush=True)


def ours(folder: Path, lengths: Sequence[float], tolerance: float) -> Callable[[int], float]:
    """The cases of these lengths, evenly spaced, with DOP853."""
    simulation = f"  simulation.duration: 5 s\n  simulation.output_step: 5 s\n  simulation.tolerance: {tolerance}\n"
    last = lengths[-1] if len(lengths) > 1 else lengths[0] + 0.1
    path = spec_of(folder, max(2, len(lengths)), lengths[0], last, f"{simulation}  simulation.integrator: dop853\n")
    return cases_of(path)


def theirs(text: str, steps: int) -> float:
    """The tip's height after 5 s, of a model built from its text."""
    import mujoco
    from beside.by_mujoco import model_of

    model = model_of(text, "RK4", 5.0 / steps)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=steps)
    mujoco.mj_kinematics(model, data)
    return float(data.site("tip").xpos[2])


def mjcf(length: float) -> str:
    """MuJoCo's model of a length."""
    return mbproj.export_model(ROOT / "mechanisms" / "five_bar.yaml", parameters={"length": length}).text


def cheapest(settings: Sequence[Setting], heights: Callable[[Setting], list[float]], exact: list[float]) -> Setting:
    """The first setting that is right at the probes, of settings from the cheapest on."""
    for setting in settings:
        error = float(np.abs(np.subtract(heights(setting), exact)).max())
        if error <= ERROR:
            return setting
    raise SystemExit(f"no setting is right to {ERROR:g} m")


def load() -> str:
    return f"load {os.getloadavg()[0]:.1f}"


def main() -> None:
    what, *count = sys.argv[1:] or ["help"]
    parts = {
        "overhead": (overhead, 10_000),
        "growth": (growth, 1_000_000),
        "study": (study, 1000),
        "arrays": (by_arrays, 1000),
    }
    if what not in parts:
        raise SystemExit(__doc__)
    measure, usual = parts[what]
    measure(int(*count) if count else usual)


if __name__ == "__main__":
    main()
