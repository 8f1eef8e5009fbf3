"""Whether a mechanism can be a case: its equations have a unique solution at the start."""

from __future__ import annotations

from mbproj import InputError, State, System, assemble, compile_system, initial_guess, mobility, read_scene_text
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.redundancy import conditioning, redundancy

#: Rows nearer than this to dependence are those of a pose next to a singular one, which other tests are for.
NEAR_SINGULAR = 1e-4


def start(text: str) -> tuple[System, State]:
    """The system of a scene and the state that it starts from."""
    scene = read_scene_text(text)
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))


def is_solvable(text: str) -> bool:
    """Whether rows are independent, or redundant for good; nothing has to move."""
    try:
        system, state = start(text)
    except InputError:
        return False
    pose = pose_of(state.q)
    ranks = mobility(system, pose)
    distance = conditioning(system, pose).distance
    near = distance is not None and THRESHOLDS.dependent < distance < NEAR_SINGULAR
    constant = not ranks.redundant or redundancy(system, state).is_constant
    return bool(constant and not near)
