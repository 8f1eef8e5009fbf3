"""`mbproj.loads`: the forces with which actuators make a mechanism follow a motion, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from mbproj.api.arguments import Given, by_arguments, scene_of
from mbproj.api.run import run
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.errors import InputError, Place, Problem
from mbproj.results import Results, open_results
from mbproj.scene.read import Scene, read_scene_text
from mbproj.scene.settings import placed_in
from mbproj.studies.inverse.given_motion import GivenMotion, from_csv, from_results
from mbproj.studies.inverse.loads import ActuatorLoads, loads_of_given, loads_of_results

_NOTHING: Mapping[str, object] = {}
_ALIKE: Mapping[str, float] = {}
#: The first bytes of an HDF5 file.
HDF5 = b"\x89HDF\r\n\x1a\n"
#: The forms in which a motion may be given.
Motion: TypeAlias = "GivenMotion | Results | str | Path"


def loads(
    scene: Given | Results,
    given: Motion | None = None,
    *,
    actuators: Sequence[str] = (),
    weights: Mapping[str, float] = _ALIKE,
    smooth: Mapping[str, float] = _ALIKE,
    parameters: Mapping[str, object] = _NOTHING,
) -> ActuatorLoads:
    """The forces of actuators along a motion: inverse dynamics.

    `scene` is as in `run`, or results, whose recorded motion is used. Without `given`, a scene is run. `given` is a CSV
    file, results, or a `GivenMotion` of joint coordinates and components of markers. `actuators` are joint coordinates,
    motions, forces of the scene, components of forces on bodies. By default they are the scene's motions, or the given
    coordinates.

    Where the actuators are more than the freedoms that they reach, Σ w p² is least with these `weights`, 1 each by
    default. `smooth` gives, by unit ("rad", "m"), the root mean square change that a spline may make to the given
    motion. Where a unit has none, it is estimated.

    Raises InputError where the motion leaves a freedom open or takes a force that no actuator has. Raises
    SimulationError where the joints do not close along it.
    """
    with by_arguments():
        return loads_of(scene, given, actuators=actuators, weights=weights, smooth=smooth, parameters=parameters)


def loads_of(
    scene: Given | Results,
    given: Motion | None,
    *,
    actuators: Sequence[str],
    weights: Mapping[str, float],
    smooth: Mapping[str, float],
    parameters: Mapping[str, object],
) -> ActuatorLoads:
    """The loads as `loads` returns them, for the command: problems name its options."""
    if isinstance(scene, Results) or is_results(scene):
        if given is not None or parameters:
            message = "results have their motion and their parameters"
            raise InputError(Problem(message, Place("--given"), "give the scene, or leave both out"))
        results = scene if isinstance(scene, Results) else open_results(Path(str(scene)))
        return loads_of_results(_stored(results), results, actuators, weights)
    what = scene_of(scene, parameters, {})
    if given is None:
        return loads_of_results(what, run(what), actuators, weights)
    with placed_in(what):
        return loads_of_given(what, _motion(what, given), actuators, weights, smooth)


def _motion(scene: Scene, given: Motion) -> GivenMotion:
    system = compile_system(scene)
    if isinstance(given, GivenMotion):
        return given
    if isinstance(given, Results):
        return from_results(system, given)
    if is_results(given):
        with open_results(Path(given)) as opened:
            return from_results(system, opened)
    return from_csv(system, Path(given))


def is_results(given: object) -> bool:
    """Whether `given` is the path of an HDF5 file."""
    if not isinstance(given, (str, Path)) or "\n" in str(given):
        return False
    try:
        with Path(given).open("rb") as file:
            return file.read(len(HDF5)) == HDF5
    except OSError:
        return False


def _stored(results: Results) -> Scene:
    """The scene of a run. Raises InputError where its bodies are not those of the results."""
    return read_scene_text(results.scene_text, str(results.scene_path or results.path), results.overrides)
