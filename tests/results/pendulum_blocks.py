"""A pendulum's small swing in closed form, as the blocks that a run would hand to the recorder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj import Scene
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.results.layout import DATASETS
from mbproj.results.writer import ResultsWriter
from mbproj.scene.records import Body, Joint, Marker, Pair

Block = dict[str, npt.NDArray[Any]]
AMPLITUDE, RATE, LENGTH, MASS, GRAVITY = 0.2, 3.0, 9.8 / 9.0, 2.0, 9.8
NAMES: Mapping[str, Sequence[str]] = {
    "bodies": ["bob"],
    "markers": ["tip", "Mitte"],
    "joints": ["A", "Gelenk ä"],
    "coordinates": ["A.angle"],
    "coordinate_units": ["rad"],
    "forces": ["spring"],
    "force_units": ["rad"],
    "motions": ["drive"],
    "motion_units": ["rad"],
}
NO_NAMES: Mapping[str, Sequence[str]] = {kind: [] for kind in NAMES} | {"bodies": ["bob"]}
SETTINGS = Settings(duration=2.0, step=0.01, output_step=0.01, projection=ProjectionSettings(tolerance=1e-13))


def scene(**changes: Any) -> Scene:
    """A scene of one pendulum; `changes` replace its fields."""
    inertia = ((0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    pivot = Pair((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    plain = Scene(
        title="Pendulum of 9.8/9 m",
        gravity=(0.0, 0.0, -GRAVITY),
        bodies=(Body("bob", MASS, inertia, (0.0, 0.0, -LENGTH)),),
        joints=(Joint("A", "revolute", ("ground", "bob"), pivot),),
        markers=(Marker("tip", "bob", (0.0, 0.0, -LENGTH)),),
        parameters={},
        settings=SETTINGS,
        text="mbproj: 1\ntitle: Pendel, 9.8/9 m, φ = 0.2 rad\n",
        path=Path("scenes/pendulum.yaml"),
        overrides={"length": "9.8/9"},
        places={},
    )
    return replace(plain, **changes)


def times(samples: int = 201, step: float = 0.01) -> npt.NDArray[np.float64]:
    """Sample times in s."""
    return np.arange(samples) * step


def block(time: npt.NDArray[np.float64], names: Mapping[str, Sequence[str]] = NAMES, drift: float = 1e-6) -> Block:
    """Every dataset at `time`: the angle AMPLITUDE cos(RATE t) in the plane y-z, an energy error `drift` × t."""
    angle, speed = AMPLITUDE * np.cos(RATE * time), -AMPLITUDE * RATE * np.sin(RATE * time)
    kinetic, potential = 0.5 * MASS * (LENGTH * speed) ** 2, MASS * GRAVITY * LENGTH * (1 - np.cos(angle))
    zero = np.zeros_like(time)
    tip = LENGTH * np.stack([zero, np.sin(angle), -np.cos(angle)], axis=-1)
    tip_velocity = LENGTH * np.stack([zero, speed * np.cos(angle), speed * np.sin(angle)], axis=-1)
    tip_acceleration = -LENGTH * RATE**2 * np.stack([zero, angle, zero], axis=-1)
    pull = MASS * (GRAVITY * np.cos(angle) + LENGTH * speed**2)
    turn = np.stack([np.cos(angle / 2), np.sin(angle / 2), zero, zero], axis=-1)
    spin, twist = (np.stack([value, zero, zero], axis=-1) for value in (speed, -(RATE**2) * angle))
    violation = 1e-15 * (1 + np.sin(RATE * time) ** 2)
    count = np.arange(len(time)) if len(time) == 0 else np.round(time / 0.01).astype(np.int64)
    kinds = ("bodies", "markers", "joints", "coordinates", "forces", "motions")
    n, k, nj, nc, nf, nm = (len(names[kind]) for kind in kinds)
    ns, nr, nt, nv = (len(names.get(kind, ())) for kind in ("stops", "frictions", "tensions", "touching"))
    force = -pull[:, None] * tip / LENGTH

    def each(values: npt.NDArray[Any], columns: int) -> npt.NDArray[Any]:
        """Column i is `values` / (i + 1)."""
        return np.stack([values / (i + 1) for i in range(columns)], axis=1) if columns else values[:, None][:, :0]

    return {
        "time": time,
        "bodies/position": each(tip, n),
        "bodies/orientation": each(turn, n),
        "bodies/velocity": each(tip_velocity, n),
        "bodies/angular_velocity": each(spin, n),
        "bodies/acceleration": each(tip_acceleration, n),
        "bodies/angular_acceleration": each(twist, n),
        "markers/position": each(tip, k),
        "markers/velocity": each(tip_velocity, k),
        "markers/acceleration": each(tip_acceleration, k),
        "joints/violation": each(violation, nj),
        "joints/violation_length": each(violation, nj),
        "joints/violation_angle": each(violation / 3, nj),
        "joints/reaction_force": each(force, nj),
        "joints/reaction_torque": each(0.1 * force[:, [1, 2, 0]], nj),
        "joints/coordinate": each(angle, nc),
        "joints/speed": each(speed, nc),
        "forces/coordinate": each(angle, nf),
        "forces/rate": each(speed, nf),
        "forces/force": each(-5 * angle, nf),
        "motions/value": each(angle, nm),
        "motions/rate": each(speed, nm),
        "motions/force": each(2 * angle, nm),
        **(
            {"stops/gap": each(0.1 + angle, ns), "stops/rate": each(speed, ns), "stops/force": each(0 * angle, ns)}
            if ns
            else {}
        ),
        **(
            {
                "friction/rate": each(speed, nr),
                "friction/force": each(-np.sign(speed), nr),
                "friction/state": each(np.sign(speed), nr),
                "friction/dissipation": each(time, nr),
            }
            if nr
            else {}
        ),
        "diagnostics/work": 0 * time,
        "diagnostics/dissipation": 0 * time,
        "diagnostics/position_violation": violation,
        "diagnostics/velocity_violation": 4 * violation,
        "diagnostics/acceleration_violation": 9 * violation,
        "diagnostics/kinetic_energy": kinetic,
        **({"ropes/tension": each(pull, nt)} if nt else {}),
        **({"curves/contact": each(tip, nv)} if nv else {}),
        "diagnostics/potential_energy": potential,
        "diagnostics/total_energy": kinetic + potential,
        "diagnostics/energy_balance": drift * time,
        "diagnostics/step_size": np.full_like(time, 0.01),
        "diagnostics/steps": count,
        "diagnostics/rejected_steps": 0 * count,
        "diagnostics/evaluations": 4 * count,
        "diagnostics/projections": count,
        "diagnostics/projection_iterations": 2 * count,
        "diagnostics/velocity_iterations": count,
        "diagnostics/projection_failures": 0 * count,
        "diagnostics/projection_fallbacks": 0 * count,
        "diagnostics/factorisations": 7 * count,
    }


def part_of(whole: Block, samples: slice) -> Block:
    """The block of some of the samples."""
    return {path: values[samples] for path, values in whole.items()}


def record(path: Path, whole: Block | None = None, the_scene: Scene | None = None, **arguments: Any) -> Path:
    """A complete results file of the pendulum at `path`."""
    names = arguments.get("names", NAMES)
    with ResultsWriter(path, the_scene or scene(), names, arguments.get("constants")) as recorder:
        recorder.write(block(times(), names) if whole is None else whole)
        recorder.attributes({"integration_seconds": 0.5, "degrees_of_freedom": 1})
    return path


PATHS = tuple(dataset.path for dataset in DATASETS)
