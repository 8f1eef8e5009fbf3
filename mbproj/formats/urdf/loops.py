"""Loops of a URDF, in the dialects that are in use.

In the file:
    <loop_joint name type><link1 link xyz rpy/><link2 link xyz rpy/><axis xyz/></loop_joint>    Isaac Sim, older Drake
    <loop name type><predecessor link><origin/></predecessor><successor link><origin/></successor><axis/></loop>  URDF+
    links closing_NAME_1 and closing_NAME_2, frames that meet                                     onshape-to-robot
Beside the file, in YAML:
    closed_loop: [[A, B], ..] with type: [3d, 6d, ..], frames of joints or links     Extended URDF
    ball_loops: [{name, parent, parent_xyz, child, child_xyz}, ..], points of links   loop_closures.yaml
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.formats.geometry import IDENTITY, Frame, numbers
from mbproj.formats.loops import Loop
from mbproj.formats.urdf.model import Urdf, axis_of, origin_of
from mbproj.formats.xml import XmlElement
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode
from mbproj.scene.text.source import read_text

#: The joint of the scene, by the word of a dialect.
TYPES = {
    "spherical": "spherical",
    "ball": "spherical",
    "3d": "spherical",
    "fixed": "fixed",
    "6d": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "universal": "universal",
}
_CLOSING = re.compile(r"closing_(.+)_([12])")


def loops_in(root: XmlElement, model: Urdf) -> Iterator[Loop]:
    """Yield the loops in the file itself."""
    for element in root.all("loop_joint"):
        yield _loop(element, [element.first("link1"), element.first("link2")], model, of_origin=False)
    for element in root.all("loop"):
        yield _loop(element, [element.first("predecessor"), element.first("successor")], model, of_origin=True)
    yield from _closing(model)


def _loop(element: XmlElement, ends: list[XmlElement | None], model: Urdf, of_origin: bool) -> Loop:
    name, kind = element.get("name") or "loop", element.get("type", "spherical")
    if kind not in TYPES or TYPES[kind] == "universal":
        able = [word for word, joint in TYPES.items() if joint != "universal"]
        raise InputError(Problem(f"a loop cannot be '{kind}'", element.place, choose_from(kind, able)))
    links, frames = [], []
    for end in ends:
        if end is None or end.get("link") not in model.links:
            link = "" if end is None else end.get("link")
            what = f"loop '{name}' names no link" if end is None else f"unknown link '{link}'"
            place = element.place if end is None else end.place
            raise InputError(Problem(what, place, choose_from(link, list(model.links))))
        links.append(end.get("link"))
        frames.append(origin_of(end.first("origin") if of_origin else end))
    axis = axis_of(element) if TYPES[kind] in ("revolute", "prismatic") else np.array([0.0, 0.0, 1.0])
    return Loop(name, TYPES[kind], (links[0], links[1]), (frames[0], frames[1]), axis, element.place)


def _closing(model: Urdf) -> Iterator[Loop]:
    """Yield the loops of links closing_NAME_1 and closing_NAME_2, whose origins meet."""
    pairs: dict[str, dict[str, str]] = {}
    for name in model.links:
        match = _CLOSING.fullmatch(name)
        if match:
            pairs.setdefault(match[1], {})[match[2]] = name
    for name, ends in pairs.items():
        if len(ends) == 1:
            (alone,) = ends.values()
            what = f"the frame '{alone}' has no other that it meets"
            raise InputError(Problem(what, model.links[alone].place, f"add closing_{name}_1 and closing_{name}_2"))
        links = (ends["1"], ends["2"])
        place = model.links[links[0]].place
        yield Loop(f"closing_{name}", "spherical", links, (IDENTITY, IDENTITY), np.array([0.0, 0.0, 1.0]), place)


def loops_beside(path: Path, given: Path | None, model: Urdf) -> Iterator[Loop]:
    """Yield the loops in the YAML file that the user names, or that is beside the model.

    Raises InputError where such a file has no loops in either dialect."""
    for file in [given] if given is not None else _beside(path):
        root, problems = compose(read_text(file), str(file))
        if problems:
            raise InputError(problems)
        values = root.values if isinstance(root, MappingNode) else {}
        any_loop = False
        for key, reader in (("closed_loop", _pairs), ("ball_loops", _balls)):
            listed = values.get(key)
            if isinstance(listed, SequenceNode):
                any_loop = True
                yield from reader(listed, values, model)
        if not any_loop:
            hint = "it lists pairs of frames: closed_loop: [[frame_1, frame_2]], and type: [3d]"
            raise InputError(Problem("the file has no list 'closed_loop' or 'ball_loops'", root.place, hint))


def _beside(path: Path) -> Iterator[Path]:
    """Yield the files beside a model that list loops."""
    for file in (path.with_suffix(".yaml"), path.with_name("loop_closures.yaml")):
        if file.is_file():
            head = file.read_text(encoding="utf-8", errors="replace")[:100_000]
            if "closed_loop:" in head or "ball_loops:" in head:
                yield file


def _pairs(listed: SequenceNode, values: Mapping[str, Node], model: Urdf) -> Iterator[Loop]:
    """Yield the loops of pairs of frames that meet in a point, 3d, or coincide, 6d."""
    kinds = values.get("type")
    words = [_text(each) for each in kinds.items] if isinstance(kinds, SequenceNode) else []
    for at, pair in enumerate(listed.items):
        ends = [_text(each) for each in pair.items] if isinstance(pair, SequenceNode) else []
        word = words[at].lower() if at < len(words) else "6d"
        if len(ends) != 2 or word not in ("3d", "6d"):
            raise InputError(Problem("a loop is a pair of frames, and 3d or 6d", pair.place, "as in [[a, b]], ['3d']"))
        links = (_link_of(ends[0], model, pair.place), _link_of(ends[1], model, pair.place))
        name = f"loop_{ends[0]}"
        yield Loop(name, TYPES[word], links, (IDENTITY, IDENTITY), np.array([0.0, 0.0, 1.0]), pair.place)


def _balls(listed: SequenceNode, values: Mapping[str, Node], model: Urdf) -> Iterator[Loop]:
    """Yield the loops of points of two links that meet."""
    for at, entry in enumerate(listed.items):
        own = entry.values if isinstance(entry, MappingNode) else {}
        links, frames = [], []
        for side in ("parent", "child"):
            name, xyz = own.get(side), own.get(f"{side}_xyz")
            if name is None:
                hint = "as in {name: a, parent: rod, parent_xyz: [0, 0, 0.1], child: foot, child_xyz: [0, 0, 0]}"
                raise InputError(Problem(f"a ball loop names no {side}", entry.place, hint))
            links.append(_link_of(_text(name), model, name.place))
            shown = " ".join(_text(each) for each in xyz.items) if isinstance(xyz, SequenceNode) else "0 0 0"
            point = numbers(shown, 3, (xyz or entry).place, f"'{side}_xyz'")
            frames.append(Frame(point, np.eye(3)))
        called = _text(own["name"]) if "name" in own else f"ball_loop_{at + 1}"
        axis = np.array([0.0, 0.0, 1.0])
        yield Loop(called, "spherical", (links[0], links[1]), (frames[0], frames[1]), axis, entry.place)


def _text(node: Node) -> str:
    return node.text if isinstance(node, ScalarNode) else ""


def _link_of(name: str, model: Urdf, place: Place) -> str:
    """The link whose frame has the name of a joint or a link. Raises InputError where there is none."""
    if name in model.joints:
        return model.joints[name].child
    if name in model.links:
        return name
    raise InputError(Problem(f"unknown frame '{name}'", place, choose_from(name, [*model.joints, *model.links])))
