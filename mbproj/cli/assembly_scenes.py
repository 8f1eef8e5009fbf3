"""Assemblies written as scenes: the text stays, except that bodies start at other poses and held coordinates have their
values."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import assemble, moved_by
from mbproj.dynamics.assembly.assemblies import Assemblies, Assembly
from mbproj.errors import InputError, Place, Problem
from mbproj.model import System, initial_guess
from mbproj.model.system import Conditions
from mbproj.output_files import SCENE, make_folder, write_text
from mbproj.pages.appearance.motion import motion_at
from mbproj.scene import read_scene_text
from mbproj.scene.read import Scene
from mbproj.scene.text.rewrite import Changes, with_changes
from mbproj.thresholds import THRESHOLDS

HINT = "choose another folder with --write"


def check_starts(scene: Scene, folder: Path) -> None:
    """Make the folder. Raises InputError where it cannot be made, or parameters were changed."""
    if scene.overrides:
        problem = Problem("--set has changed parameters, which the file does not have", Place("--write"))
        raise InputError(problem)
    make_folder(folder, HINT)


def write_starts(
    scene: Scene, system: System, all_assemblies: Assemblies, held: Conditions, folder: Path, *, force: bool
) -> Iterator[Path]:
    """Write DIR/<scene>_<number>.yaml for each assembly, from 1 on. Raises InputError where the text cannot be changed
    so that the scene starts there."""
    stem = folder / (scene.path.stem if scene.path is not None else "scene")
    for number, each in enumerate(all_assemblies.found, 1):
        try:
            text = with_changes(scene.text, _changes(scene, system, each, held))
            read = read_scene_text(text, str(scene.path))
            own = compile_system(read)
            reached = assemble(own, initial_guess(read, own))
        except (ValueError, InputError) as error:
            raise InputError(Problem(f"assembly {number} cannot be written: {error}", Place("--write"))) from error
        if max(moved_by(reached.q, each.q)) > THRESHOLDS.same_pose:
            problem = Problem(f"assembly {number} cannot be written: from there the scene closes elsewhere")
            raise InputError(problem)
        yield write_text(Path(f"{stem}_{number}.yaml"), text, SCENE, force=force, hint=HINT)


def _changes(scene: Scene, system: System, each: Assembly, held: Conditions) -> Changes:
    """The start of each body, and the values of held joint coordinates, as changes of the text."""
    motion = motion_at(system, each.q)
    bodies: dict[str, Changes] = {
        body.name: {"start": _pose(motion.position[0, k].tolist(), motion.orientation[0, k].tolist())}
        for k, body in enumerate(scene.bodies)
    }
    joints: dict[str, dict[str, str | None]] = {}
    for index, value in zip(held.index.tolist(), held.value.tolist(), strict=True):
        joint, _, coordinate = system.names.coordinates[index].rpartition(".")
        joints.setdefault(joint, {})[coordinate] = repr(value)
    return {"bodies": bodies, **({"joints": joints} if joints else {})}


def _pose(position: list[float], orientation: list[float]) -> Changes:
    return {"position": repr(position), "orientation": f"{{quaternion: {orientation!r}}}"}
