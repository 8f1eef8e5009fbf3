"""Every element and attribute of MJCF, URDF and SDF: an import is a scene, a row of the table, or an error at a line.

The lists stand in tests/data/formats/attributes. Each attribute takes plausible values, and others that are empty, no
number, not finite, huge, tiny, negative or zero: of those of MJCF, which has the most, two that its name chooses, and
all where EVERY_VALUE is set. In URDF and SDF a plausible value also changes the scene or the table, unless the list
says that it has no effect on the motion: nothing is ignored in silence.
"""

from __future__ import annotations

import copy
import os
import random
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from mbproj import import_model
from mbproj.base.errors import InputError, MbprojWarning
from mbproj.scene.scene import read_scene_text
from tests.crossed import where
from tests.support import ROOT

DATA = ROOT / "tests" / "data" / "formats" / "attributes"
#: What stands in the place of each number.
NUMBERS = ("nan", "inf", "1e308", "1e-300", "-1", "0")
#: What stands in the place of a whole value.
TEXTS = ("", "x", "0 1", "x" * 300)
#: The number of these values that an attribute of MJCF takes in the usual tests.
FEW = 2


@dataclass
class Attribute:
    """An attribute, or with the name "." the text: plausible values, and whether it has to be there and has effect."""

    name: str
    values: list[str]
    required: bool
    silent: bool

    def bad(self) -> Iterator[str]:
        yield from TEXTS
        count = max(len(value.split()) for value in self.values)
        for number in NUMBERS:
            yield " ".join([number] * count)
            if count > 1:
                yield " ".join([number, *["1"] * (count - 1)])
        if self.values[0].split()[-1].replace(".", "").isdigit():
            yield " ".join([*self.values[0].split()[:-1], "1e-300"])


@dataclass
class Listed:
    """An element of a list, with the tags from the root to it."""

    path: tuple[str, ...]
    attributes: list[Attribute]
    silent: bool
    required: bool
    children: list[Listed] = field(default_factory=list)

    def new(self) -> ElementTree.Element:
        """The element with what has to be there."""
        element = ElementTree.Element(self.path[-1])
        for attribute in self.attributes:
            if attribute.required or attribute.name == ".":
                put(element, attribute.name, attribute.values[0])
        element.extend(child.new() for child in self.children if child.required)
        return element

    def walk(self) -> Iterator[Listed]:
        yield self
        for child in self.children:
            yield from child.walk()


def listed(name: str) -> Listed:
    """The root element of a list."""
    above: list[Listed] = []
    for line in (DATA / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        depth = (len(line) - len(line.lstrip())) // 2
        tag, *words = line.split()
        silent = "~" in tag or (depth > 0 and above[depth - 1].silent)
        attributes = []
        for word in words:
            key, _, values = word.partition("=")
            plain = key.rstrip("*~")
            plausible = [each.replace(",", " ") for each in values.split("|")] if values else ["0.5"]
            attributes.append(Attribute(plain, plausible, "*" in key, silent or "~" in key))
        above = above[:depth]
        path = (*(above[-1].path if above else ()), tag.rstrip("*~"))
        element = Listed(path, attributes, silent, "*" in tag)
        if above:
            above[-1].children.append(element)
        above.append(element)
    return above[0]


def put(element: ElementTree.Element, name: str, value: str) -> None:
    if name == ".":
        element.text = value
    else:
        element.set(name, value)


INERTIA = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.2" izz="0.2"/></inertial>'
SOLID = "<inertial><inertia><iyy>0.9</iyy></inertia></inertial>"
BOX = "<geometry><box><size>1 2 3</size></box></geometry>"
BASES = {
    "urdf": f"""<robot name="r"><link name="base"/><link name="hand">{INERTIA}</link><link name="arm">{INERTIA}
<visual><geometry><box size="1 2 3"/></geometry></visual></link>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/><axis xyz="1 0 0"/></joint>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/></joint></robot>""",
    "sdf": f"""<sdf version="1.11"><model name="m"><pose>0 0 0.1 0.2 0 0</pose><frame name="grip" attached_to="hand"/>
<link name="hand"><pose>0.5 0 0 0 0.2 0.1</pose>{SOLID}</link>
<link name="arm"><pose>0 0 0.2 0.3 0 0</pose>{SOLID}<visual name="v">{BOX}</visual></link>
<joint name="turn" type="revolute"><parent>world</parent><child>arm</child><axis/></joint>
<joint name="slide" type="universal"><parent>arm</parent><child>hand</child><axis/>
<axis2><xyz>0 1 0</xyz></axis2></joint>
</model></sdf>""",
    "world": """<sdf version="1.11"><world name="w"><model name="m"><link name="arm"/></model></world></sdf>""",
    "mjcf": """<mujoco><default><geom density="100"/><default class="own"><joint damping="1"/></default></default>
<asset><material name="steel"/><mesh name="tetra" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
<worldbody><site name="base"/><geom name="floor" type="plane" size="1 1 1" pos="0 0 -9" contype="0"/>
<body name="float" pos="0 5 0"><freejoint name="free"/><geom size="0.1"/></body>
<body name="arm"><joint name="turn" axis="0 1 0"/><geom name="round" size="0.1" pos="0.3 0 0" contype="0"/>
<camera name="cam"/><site name="tip" pos="0.3 0 0.1"/>
<body name="hand" pos="0.5 0 0"><joint name="ball" type="ball"/><geom size="0.1" pos="0.1 0 0" contype="0"/></body>
<body name="sled" pos="0 0 1"><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1" contype="0"/></body>
</body></worldbody>
<tendon><fixed name="sum"><joint joint="turn" coef="1"/></fixed>
<spatial name="rope"><site site="base"/><site site="tip"/></spatial></tendon>
<actuator><motor name="motor" joint="turn"/></actuator></mujoco>""",
}
INNER = {
    "a.stl": "solid a",
    "inner.sdf": '<sdf version="1.11"><model name="i"><link name="l"/></model></sdf>',
    "inner.xml": '<mujoco><worldbody><body name="b"><joint/><geom size="0.1"/></body></worldbody></mujoco>',
}


def placed(base: ElementTree.Element, element: Listed, root: Listed) -> tuple[ElementTree.Element, ElementTree.Element]:
    """A copy of a base in which the element is there, and that element: the last of its kind, or a new one."""
    model = copy.deepcopy(base)
    node, at = model, root
    for tag in element.path[1:]:
        at = next(child for child in at.children if child.path[-1] == tag)
        there = node.findall(tag)
        if not there:
            there = [at.new()]
            node.insert(0, there[0])  # of several shapes the first counts
        node = there[-1]
    return model, node


Case = tuple[str, Attribute | None, str]


def cases(name: str, part: str) -> Iterator[Case]:
    """Yield models: what is changed, the attribute whose effect on the motion has to show, if any, and the text. Before
    those with plausible values of such an attribute comes the model without it, or without its whole element."""
    root = listed("sdf" if name == "world" else name)
    base = ElementTree.fromstring(BASES[name].replace("\n", ""))
    for element in root.walk():
        if part_of(element) != part:
            continue
        shown = "/".join(element.path)
        model, node = placed(base, element, root)
        is_new = base.find("/".join(element.path[1:]) or ".") is None
        yield f"{shown} there", None, text_of(model)
        if len(element.path) > 1:
            parent = next(each for each in model.iter() if node in list(each))
            parent.append(element.new())
            yield f"{shown} twice", None, text_of(model)
            for each in parent.findall(element.path[-1]):
                parent.remove(each)
            yield f"{shown} gone", None, text_of(model)
        for attribute in element.attributes:
            told = None if name == "mjcf" or attribute.silent else attribute
            model, node = placed(base, element, root)
            node.attrib.pop(attribute.name, None)
            node.text = node.text if attribute.name != "." else None
            yield f"{shown} without {attribute.name}", told, text_of(model)
            if is_new:
                yield f"{shown} without {attribute.name} and all", told, text_of(base)
            bad = [*attribute.bad()]
            if name == "mjcf" and "EVERY_VALUE" not in os.environ:
                bad = random.Random(f"{shown} {attribute.name}").sample(bad, FEW)
            for value in [*attribute.values, *bad]:
                model, node = placed(base, element, root)
                put(node, attribute.name, value)
                yield f"{shown} {attribute.name}={value}", told if value in attribute.values else None, text_of(model)


def text_of(model: ElementTree.Element) -> str:
    return ElementTree.tostring(model, encoding="unicode")


def outcome(path: Path, text: str, **options: bool) -> tuple[str, object]:
    """What becomes of a model with these options of the import, and the scene with the rows of the table."""
    path.write_text(text, encoding="utf-8")
    with warnings.catch_warnings(), np.errstate(all="raise", under="ignore"):
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", MbprojWarning)
        try:
            found = import_model(path, **options)
        except InputError as error:
            for problem in error.problems:
                assert problem.place is not None, problem
                assert problem.place.file.startswith(str(path.parent)), problem
            return "error", str(error)
    rows = [(row.element, row.what, row.same.value) for row in found.mechanism.said]
    if not any(element == "the scene itself" for element, _, _ in rows):
        read_scene_text(found.text)
    return ("row" if rows else "scene"), (found.text, rows)


def part_of(element: Listed) -> str:
    """The part of a list that one test tries: an element below the third level is in that of the one there."""
    return "/".join(element.path[1:4])


PARTS = [
    (name, part)
    for name in BASES
    for part in dict.fromkeys(part_of(each) for each in listed("sdf" if name == "world" else name).walk())
    if name not in ("sdf", "world") or part.startswith("world") == (name == "world")
]


#: What an import is asked for: that actuators act, that planes are stops, that the frames of joints meet.
ASKED = {"mjcf": {"hold": True, "contacts": True}}
MEETING = {"meet": True}


@pytest.mark.parametrize(
    ("name", "part"), where(lambda name, part: name == "urdf" and part.startswith("joint/"), PARTS)
)
def test_each_import_is_a_scene_or_a_row_or_an_error_at_a_line(name, part, tmp_path):
    """Where a plausible value of an attribute changes neither the scene nor the table, it is ignored in silence."""
    for file, text in INNER.items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    path = tmp_path / f"model.{'xml' if name == 'mjcf' else 'urdf' if name == 'urdf' else 'sdf'}"
    wrong, seen, told, without = list[str](), dict[str, bool](), None, list[object]()
    for what, attribute, text in cases(name, part):
        try:
            became = outcome(path, text, **ASKED.get(name, {}))
            if path.suffix == ".sdf":
                outcome(path, text, **MEETING)
        except Exception as error:
            wrong.append(f"{what}: {type(error).__name__}: {error}")
            continue
        if attribute is not None and " without " in what:
            without = [*without, became] if attribute is told else [became]
            told = attribute
        elif attribute is not None:
            key = what.partition("=")[0]
            seen[key] = seen.get(key, False) or any(became != each for each in without)
    wrong += [f"{key}: ignored in silence" for key, shows in seen.items() if not shows]
    assert not wrong, "\n".join(wrong)
