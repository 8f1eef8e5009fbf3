"""The result of an export: the model, with the table of what it leaves out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from xml.sax.saxutils import quoteattr

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.formats.export.tree import CoordinateLoads, Say, Tree
from mbproj.formats.mechanism import Said, Same
from mbproj.scene.records import BodyForce, Bushing, PlaneStop
from mbproj.scene.scene import Scene


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


# --- Readable XML -----------------------------------------------------------------------------------------------------
# One tag on each line, indented, with numbers from which the same numbers are read.


#: A number of an array is written as 0 where it is less than this part of the largest one.
ROUND_OFF = 1e-15


@dataclass(eq=False)
class Tag:
    """An element with its attributes as texts, and the elements in it."""

    name: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Tag] = field(default_factory=list)

    def add(self, name: str, /, **attributes: object) -> Tag:
        """Add a new element to this one, and return it. Attributes that are None are left out; `class_` is class."""
        child = tag(name, **attributes)
        self.children.append(child)
        return child

    def lines(self, indent: int = 0) -> Iterator[str]:
        """The lines of the element's text."""
        head = f"{' ' * indent}<{self.name}" + "".join(f" {k}={quoteattr(v)}" for k, v in self.attributes.items())
        if not self.children:
            yield f"{head}/>"
            return
        yield f"{head}>"
        for child in self.children:
            yield from child.lines(indent + 2)
        yield f"{' ' * indent}</{self.name}>"


def tag(name: str, /, **attributes: object) -> Tag:
    """An element; numbers and arrays become text."""
    return Tag(name, {key: _text(value) for key, value in attributes.items() if value is not None})


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    numbers = np.atleast_1d(np.asarray(value, dtype=float)).ravel()
    least = ROUND_OFF * float(np.abs(numbers).max(initial=0.0))
    return " ".join(_number(float(each)) if abs(each) > least else "0" for each in numbers)


def _number(value: float) -> str:
    """The shortest text from which the same number is read."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
