"""The result of an export: the model, with the table of what it leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.formats.export.acting import CoordinateLoads, Say
from mbproj.formats.export.tree import Tree
from mbproj.formats.mechanism import Said, Same
from mbproj.scene.read import Scene
from mbproj.scene.records import BodyForce, Bushing
from mbproj.scene.stops import PlaneStop


@dataclass(eq=False)
class Written:
    """The text of a model, that of the file of its loops (where there is one), and the rows of the table."""

    text: str
    loops: str = ""
    said: list[Said] = field(default_factory=list)

    def say(self, element: str, what: str, same: Same) -> None:
        """Add a row to the table."""
        self.said.append(Said(element, None, what, same))


def say_unwritten(scene: Scene, say: Say, tree: Tree, acting: Mapping[str, CoordinateLoads]) -> None:
    """Add rows on the parts of the scene that neither format has."""
    free = tree.freedoms
    for coordinate in acting:
        if coordinate not in free:
            say(f"what acts on '{coordinate}'", "left out: its joint closes a loop", Same.NO)
    for motion in scene.motions:
        say(f"motion '{motion.name}'", "left out: its coordinate moves freely in the model", Same.NO)
    for force in scene.forces:
        if isinstance(force, Bushing | BodyForce):
            say(f"force '{force.name}'", "left out: there is no such force in the format", Same.NO)
        elif isinstance(force, PlaneStop):
            say(f"stop '{force.name}'", "left out: bodies pass through the plane", Same.UNTIL)
    for state in scene.states:
        say(f"state '{state.name}'", "left out: no model has states beside its motion", Same.NO)
    for element in scene.elements:
        say(f"element '{element.name}'", "left out: it comes from Python", Same.NO)
    drawn = sum(body.appearance is not None or bool(body.shapes) for body in scene.bodies)
    if drawn:
        say(f"looks of {drawn} bodies", "left out: they do not act on the motion", Same.YES)
    if np.any(scene.gravity) and scene.settings.start == "equilibrium":
        say("start: equilibrium", "the model begins there, at rest", Same.YES)
