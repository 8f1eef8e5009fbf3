"""How well `mbproj fit` and `mbproj optimise` find what is known.

    python scripts/find_designs.py [path] [noise] [linkages] [load] [positions]
                                   [--seeds N] [--sets N] [--starts N] [--differences]

path      a four-bar of ten dimensions by 24 points of its coupler curve: the rms of the residuals for each of N seeds;
          --differences: the same by differences of runs, and what dual numbers take of their time
noise     how often the true numbers are within one and three standard deviations, for N noisy sets of measurements of a
          pendulum, a five-bar and a quarter car
linkages  the straight-line linkages of Hoeken, Chebyshev and Roberts, by their curves
load      the peak of a bearing's load in a six-bar, under a constraint on its stroke, beside a run of the scene found
positions how often six-bars are found that carry a body exactly through 3, 4, 5 places, of N random ones each
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from unittest.mock import patch

import numpy as np
from designs.scenes import FOUR_BAR, PENDULUM, SIX_BAR

import mbproj
from mbproj.base.errors import MbprojError
from mbproj.results.analysis.expectations import outcomes
from mbproj.scene.scene import Scene
from mbproj.studies.design.folder import best_scene
from mbproj.studies.design.neighbours import Followed
from mbproj.studies.design.run import FoundDesign, find_design
from mbproj.studies.design.spec import read_spec
from mbproj.studies.synthesis.candidates import candidates
from mbproj.studies.synthesis.spec import read_wanted
from mbproj.studies.synthesis.synthesise import SIX_BARS

#: Why dual numbers are not taken.
ASKED = "differences were asked for"
BOX = {
    "ax": (-0.3, 0.3),
    "az": (-0.3, 0.3),
    "frame": (0.4, 1.2),
    "tilt": (-0.6, 0.6),
    "crank": (0.1, 0.4),
    "coupler": (0.3, 1.0),
    "rocker": (0.3, 1.0),
    "px": (-0.2, 0.7),
    "pz": (-0.5, 0.5),
    "start": (-0.6, 0.6),
}
#: Linkages: their dimensions, the angles of crank, coupler and rocker at the start, and by how much the crank turns.
LINKAGES = {
    "Hoeken": (
        {"frame": 0.4, "crank": 0.2, "coupler": 0.5, "rocker": 0.5, "px": 1.0, "pz": 0.0},
        0.0,
        0.6,
        1.9,
        2 * np.pi,
    ),
    "Chebyshev": (
        {"frame": 0.4, "crank": 0.5, "coupler": 0.2, "rocker": 0.5, "px": 0.1, "pz": 0.0},
        0.65,
        0.6,
        0.95,
        0.25,
    ),
    "Roberts": (
        {"frame": 0.6, "crank": 0.36, "coupler": 0.3, "rocker": 0.36, "px": 0.15, "pz": -0.33},
        1.0,
        -0.1,
        2.0,
        0.2,
    ),
}


def written(folder: Path, scene: str, vary: Mapping[str, Sequence[float]], wanted: str, starts: int, seed: int) -> Path:
    """A scene and a design in the folder; the design's path."""
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    bounds = "".join(f"  parameters.{name}: [{low!r}, {high!r}]\n" for name, (low, high) in vary.items())
    path = folder / "design.yaml"
    text = f"design: 1\nscene: scene.yaml\nvary:\n{bounds}{wanted}starts: {starts}\nseed: {seed}\n"
    path.write_text(text, encoding="utf-8")
    return path


def searched(path: Path) -> FoundDesign:
    return find_design(read_spec(path), 1, fresh=True)


def table(path: Path, headings: str, columns: np.ndarray) -> None:
    np.savetxt(path, columns, delimiter=",", header=headings, comments="", fmt="%.17g")


def curve(scene: str, values: Mapping[str, float]) -> np.ndarray:
    """24 rows of the time and the tip's x and z. Raises MbprojError where it does not run."""
    results = mbproj.run(mbproj.read_scene_text(scene, "scene", values))
    tip = results.marker("tip").position
    return np.column_stack([results.time, tip[:, 0], tip[:, 2]])[:24]


def measures(scene: Scene) -> dict[str, float]:
    """What a run of the scene has of what it expects."""
    found = outcomes(scene.expectations, mbproj.run(scene))
    return {each.expectation.name: each.measured[0] for each in found if each.measured is not None}


def path(folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """A seed's truth is a random four-bar of the box that runs."""
    scene = FOUR_BAR.format(turn="2*pi", tips="0.6", leans="1.8")
    errors, times = [], []
    for seed in range(given.seeds):
        draw = np.random.default_rng(seed)
        while True:
            truth = {name: draw.uniform(*bounds) for name, bounds in BOX.items()}
            try:
                table(folder / "tip.csv", "time (s),position_x (m),position_z (m)", curve(scene, truth))
                break
            except MbprojError:
                continue
        match = "match: {path: {marker: tip, through: tip.csv}}\n"
        design, seconds = written(folder, scene, BOX, match, given.starts, seed), []
        for by_differences in (False, True)[: 1 + given.differences]:
            began = process_time()
            with patch.object(Followed, "why", ASKED) if by_differences else nullcontext():
                found = searched(design)
            seconds.append(process_time() - began)
            errors.append(float(np.sqrt(np.mean(found.trial.residuals**2))))
            yield f"seed {seed}: rms {errors[-1]:.1e} m, {found.runs} runs, {seconds[-1]:.1f} s of processor time"
        times.append(seconds[0] / seconds[-1])
    if given.differences:
        yield f"dual numbers take {np.median(times):.2f} of the time of differences, in the median"
    yield f"median of {given.seeds} seeds: {np.median(errors):.1e} m; {sum(e < 1e-12 for e in errors)} below 1e-12 m"


def noise(folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """One start each, at the scene's own numbers: what is asked for are the deviations."""
    five_bar, car = (mbproj.read_scene(f"mechanisms/{name}.yaml").text for name in ("five_bar", "quarter_car"))
    five_bar = five_bar.replace("duration: 10 s", "duration: 1 s\n  output_step: 50 ms").partition("expect:")[0]
    car = car.replace("duration: 8 s", "duration: 1 s").replace("tolerance: 1.0e-9", "step: 2 ms")
    car = car.replace("integrator: dop853", "integrator: rk4").partition("expect:")[0]
    cases: dict[str, tuple[str, dict[str, float], str, str, float]] = {
        "pendulum": (PENDULUM, {"offset": 0.3, "damping": 0.1, "release": 0.7}, "joint: pin", "angle", 2e-3),
        "five-bar": (five_bar, {"length": 1.0, "width": 0.1}, "joint: A", "angle", 1e-3),
        "quarter car": (car, {"sprung": 300.0, "coil": 4e4, "damping": 3e3}, "joint: body", "displacement", 1e-4),
    }
    for name, (scene, truth, of, quantity, size) in cases.items():
        results = mbproj.run(mbproj.read_scene_text(scene))
        exact = results.coordinate(f"{of.partition(': ')[2]}.{quantity}").value
        shares = []
        for seed in range(given.sets):
            shaken = exact + size * np.random.default_rng(seed).normal(size=len(exact))
            table(folder / "measured.csv", f"time (s),{quantity}", np.column_stack([results.time, shaken]))
            vary = {key: (0.7 * value, 1.3 * value) for key, value in truth.items()}
            match = f"match: {{it: {{{of}, quantity: {quantity}, through: measured.csv}}}}\n"
            found = searched(written(folder, scene, vary, match, 1, seed))
            assert found.knowledge is not None
            shares.append(np.abs(found.x - [*truth.values()]) / found.knowledge.deviation)
        within = [np.mean(np.array(shares) <= k) for k in (1.0, 3.0)]
        yield f"{name}: {len(truth)} numbers, {given.sets} sets: {within[0]:.1%} within 1, {within[1]:.1%} within 3"


def linkages(folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """Their own curve is matched, from starts all over a box."""
    for name, (truth, start, tips, leans, turn) in LINKAGES.items():
        scene = FOUR_BAR.format(turn=repr(float(turn)), tips=repr(tips), leans=repr(leans))
        points = curve(scene, {**truth, "start": start})
        table(folder / "tip.csv", "time (s),position_x (m),position_z (m)", points)
        scene = scene.replace("start: 0.2 rad", f"start: {start!r} rad")
        vary = {
            key: (value - 0.3 * max(abs(value), 0.1), value + 0.3 * max(abs(value), 0.1))
            for key, value in truth.items()
        }
        match = "match: {path: {marker: tip, through: tip.csv}}\n"
        found = searched(written(folder, scene, vary, match, given.starts, 0))
        off = np.abs(found.x - [*truth.values()]).max()
        rms = np.sqrt(np.mean(found.trial.residuals**2))
        yield f"{name}: rms {rms:.1e} m, dimensions off by {off:.1e} m, {found.runs} runs"


def load(folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """The stroke stays; the ram's mass is the load's cause and is not varied."""
    before = measures(mbproj.read_scene_text(SIX_BAR))
    vary = {"coupler": (0.35, 0.5), "rocker": (0.2, 0.4), "arm": (0.2, 0.5), "rod": (0.4, 1.0)}
    wanted = (
        "minimise: {load: {joint: D, quantity: reaction_force, component: norm, at: largest}}\n"
        f"subject_to: {{stroke: {{joint: G, quantity: displacement, at: range, at_least: {before['stroke']!r}}}}}\n"
    )
    for engine in ("cma", "slsqp"):
        path = written(folder, SIX_BAR, vary, wanted, 2, 0)
        found = find_design(read_spec(path), 1, engine=engine, fresh=True)
        (folder / "best.yaml").write_text(best_scene(found), encoding="utf-8")
        again = measures(mbproj.read_scene(folder / "best.yaml"))
        yield (
            f"{engine}: load {before['load']:.4g} -> {found.trial.goals[0]:.4g} N, stroke "
            f"{before['stroke']:.6g} -> {again['stroke']:.6g} m, {found.runs} runs; "
            f"an independent run of best.yaml: {again['load']:.10g} N"
        )


def positions(folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """Places along an arc, shifted by 0.1 m and turned by 8° at random."""
    arc = np.array([(0, 0, 0), (0.5, 0.2, 17), (1, 0.1, 46), (1.3, -0.2, 60), (1.5, -0.5, 80)], dtype=float)
    wish = folder / "carry.yaml"
    wish.write_text("design: 1\nsynthesis: {positions: places.csv}\n", encoding="utf-8")
    for name in SIX_BARS:
        for count in range(3, len(arc) + 1):
            off = []
            for seed in range(given.seeds):
                places = arc[:count] + np.random.default_rng(seed).normal(size=(count, 3)) * (0.1, 0.1, 8.0)
                table(folder / "places.csv", "x (m),z (m),angle (deg)", places)
                off.append(candidates(read_wanted(wish), name)[0]["rms"])
            yield f"{name}, {count} places: {sum(each < 1e-12 for each in off)} of {given.seeds} exact"


STUDIES: Mapping[str, Callable[[Path, argparse.Namespace], Iterator[str]]] = {
    "path": path,
    "noise": noise,
    "linkages": linkages,
    "load": load,
    "positions": positions,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*", choices=[*STUDIES, []], default=[*STUDIES])
    for name, count in (("--seeds", 20), ("--sets", 200), ("--starts", 5)):
        parser.add_argument(name, type=int, default=count)
    parser.add_argument("--differences", action="store_true")
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        for name in given.studies:
            print(f"{name}:")
            for line in STUDIES[name](Path(folder), given):
                print(f"  {line}", flush=True)


if __name__ == "__main__":
    main()
