"""The file that says what a sweep is: a scene, what varies in it, how that is combined, what is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.scene.blocks.measures import MEASURES, complaints, items_of, measures_of
from mbproj.scene.expressions.units import BARE, symbol_of
from mbproj.scene.fields.choices import Choice
from mbproj.scene.fields.containers import Record
from mbproj.scene.fields.fields import Field, Text
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.ranges import RANGE, Range
from mbproj.scene.read import SceneText
from mbproj.scene.records import Expectation, KeyPath, Scene
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, as_mapping, describe
from mbproj.scene.text.source import read_text
from mbproj.studies.sweep.design import COMBINATIONS, Design, design_of
from mbproj.studies.sweep.probes import misfits

FORMAT = "1"
#: What results files are kept of.
KEEP = ("none", "failed", "all")
#: Columns of the summary that are neither parameters nor measures.
COLUMNS = ("case", "status", "message", "time", "joint", "formulation", "seconds", "file")


class Varied(Field[Mapping[str, Range]]):
    """Ranges by the paths of what they are of."""

    node_type = MappingNode

    @property
    def expects(self) -> str:
        return "a mapping {path of a value of the scene: a range}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, Range] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        if not mapping.values:
            reading.report("'vary' is empty", mapping.place, "say what varies, as in  parameters.length: 0.8:1.2:5")
            return None
        found = {}
        for name, value in mapping.values.items():
            where = (*path, name)
            reading.places[where] = mapping.keys[name]
            found[name] = RANGE.read(value, where, reading)
        whole = {name: each for name, each in found.items() if each is not None}
        return whole if len(whole) == len(found) else None

    def schema(self) -> dict[str, Any]:
        return {"description": self.expects, "type": "object", "additionalProperties": RANGE.schema()}


SPEC: Record[dict[str, Any]] = Record(
    "a sweep",
    {
        "sweep": Choice("format version", lambda: (FORMAT,)),
        "scene": Text(),
        "vary": Varied(),
        "combine": Choice("combination", lambda: COMBINATIONS),
        "samples": Integer(1),
        "seed": Integer(0),
        "measure": MEASURES,
        "keep": Choice("word for what to keep", lambda: KEEP),
    },
    dict,
    required=("sweep", "scene", "vary", "measure"),
)


@dataclass(frozen=True, eq=False)
class Spec:
    """A sweep as its file has it. `units` are those of the parameters, by their paths, "" where nobody knows; `places`
    where each key stands."""

    path: Path
    text: str = field(repr=False)
    scene: SceneText
    design: Design
    units: Mapping[str, str]
    measures: tuple[Expectation, ...]
    keep: str
    places: Mapping[KeyPath, Place] = field(repr=False)

    def place(self, *path: str | int) -> Place | None:
        """Where a key of the file stands."""
        return self.places.get(path)


def read_spec(path: Path) -> Spec:
    """The sweep in the file at `path`. Raises InputError with every problem, at its place in the file or the scene."""
    text = read_text(path)
    root, problems = compose(text, str(path))
    if not isinstance(root, MappingNode):
        wrong = f"a sweep is a mapping of keys, found {describe(root)}"
        raise InputError(Problem(wrong, root.place, f"it begins with 'sweep: {FORMAT}'"))
    reading = Reading(places={(): root.place}, problems=list(problems))
    scene, base = _scene(path, root, reading)
    reading.items = items_of(base)
    found = SPEC.read(root, (), reading)
    if found is None:
        raise InputError(in_text_order(reading.problems))
    for complaint in complaints(found["measure"], base):
        reading.report(complaint.message, reading.places[complaint.path], complaint.hint)
    _check_names(found, reading)
    combine = found.get("combine", COMBINATIONS[0])
    design = design_of(found["vary"], combine, found.get("samples"), found.get("seed"), reading)
    if design is None or reading.problems:
        raise InputError(in_text_order(reading.problems))
    reading.problems += misfits(scene, design, found["measure"], reading.places)
    if reading.problems:
        raise InputError(in_text_order(reading.problems))
    return Spec(
        path=path,
        text=text,
        scene=scene,
        design=design,
        units=_units(found["vary"], scene),
        measures=measures_of(found["measure"], base),
        keep=found.get("keep", KEEP[0]),
        places=reading.places,
    )


def _scene(path: Path, root: MappingNode, reading: Reading) -> tuple[SceneText, Scene]:
    """The scene that the file names, taken apart, and as it is by itself."""
    node = root.values.get("scene")
    if not isinstance(node, ScalarNode) or not node.text:
        SPEC.read(root, (), reading)
        raise InputError(in_text_order(reading.problems))
    where = path.parent / node.text
    try:
        text = SceneText(read_text(where), str(where), where)
    except InputError as error:
        problems = [_at(problem, str(where), node) for problem in error.problems]
        raise InputError(problems) from error
    return text, text.scene()


def _at(problem: Problem, scene: str, node: ScalarNode) -> Problem:
    """A problem of the scene as a whole, at the key that names it; others have their places in it."""
    if problem.place is None or problem.place.line is not None:
        return problem
    return replace(problem, message=f"scene '{scene}': {problem.message}", place=node.place)


def _check_names(found: Mapping[str, Any], reading: Reading) -> None:
    """Report measures that have the name of another column of the summary."""
    taken = {column_of(path) for path in found["vary"]} | {*COLUMNS}
    for name in found["measure"]:
        if name in taken:
            place = reading.places[("measure", name)]
            reading.report(f"'{name}' is another column of the summary", place, "give the measure another name")


def column_of(path: str) -> str:
    """What a quantity that varies is called in tables: a parameter by its name, others by their paths."""
    return path.removeprefix("parameters.")


def _units(ranges: Mapping[str, Range], scene: SceneText) -> dict[str, str]:
    """The SI units of what varies: as the scene has them, or the sweep."""
    known = {".".join(map(str, path)): unit for path, unit in scene.units().items()}
    found = {}
    for path, each in ranges.items():
        own = symbol_of(each.dimension) if each.dimension not in (None, BARE) else ""
        found[path] = known.get(path) or known.get(f"parameters.{path}") or own
    return found
