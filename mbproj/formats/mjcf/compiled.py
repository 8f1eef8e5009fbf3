"""Runs MuJoCo's compiler on a complete source: gives the model, the places of its elements, its pose at the start."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from, warn_once
from mbproj.formats.geometry import LARGEST
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.mjcf.source import MjcfSource
from mbproj.formats.xml import XmlElement

# --- Flags of an MJCF model that switch parts of the physics off ------------------------------------------------------
# The model without them.


class Switch(NamedTuple):
    """What a flag switches off, and the arrays of the model that are zero without it."""

    what: str
    arrays: tuple[str, ...] = ()


_SOFT = {
    "EQUALITY": Switch("equalities", ("eq_active0",)),
    "FRICTIONLOSS": Switch("dry friction", ("dof_frictionloss", "tendon_frictionloss")),
    "LIMIT": Switch("limits of joints and tendons", ("jnt_limited", "tendon_limited")),
    "CONTACT": Switch("contacts", ("geom_contype", "geom_conaffinity")),
}
_OF_SPRINGS = tuple(f"{kind}_stiffness{ending}" for kind in ("jnt", "tendon") for ending in ("", "poly"))
_OF_DAMPERS = tuple(f"{kind}_damping{ending}" for kind in ("dof", "tendon", "actuator") for ending in ("", "poly"))
#: What the flags of `mjtDisableBit` switch off. Actuators ask `is_off`.
SWITCHES: Mapping[str, Switch] = MappingProxyType(
    {
        **_SOFT,
        "CONSTRAINT": Switch(
            "equalities, dry friction, limits and contacts", tuple(name for each in _SOFT.values() for name in each[1])
        ),
        "SPRING": Switch("springs of joints and tendons", _OF_SPRINGS),
        "DAMPER": Switch("dampers of joints and tendons", _OF_DAMPERS),
        "GRAVITY": Switch("gravity, and what compensates it", ("body_gravcomp",)),
        "CLAMPCTRL": Switch("ranges of control signals", ("actuator_ctrllimited",)),
        "ACTUATION": Switch("actuators"),
    }
)


def disabled(model: Any) -> frozenset[str]:
    """The names of the model's flags that switch something off: "GRAVITY", "CONTACT", .."""
    import mujoco

    return _bits(mujoco.mjtDisableBit, "mjDSBL_", model.opt.disableflags)


def enabled(model: Any) -> frozenset[str]:
    """The names of the flags of what the model switches on: "SLEEP", "ENERGY", .."""
    import mujoco

    return _bits(mujoco.mjtEnableBit, "mjENBL_", model.opt.enableflags)


def _bits(kind: Any, beginning: str, flags: int) -> frozenset[str]:
    members = kind.__members__.items()
    known = {name.removeprefix(beginning): int(bit) for name, bit in members if name.startswith(beginning)}
    unknown = flags & ~sum(known.values())
    names = {name for name, bit in known.items() if flags & bit}
    return frozenset(names | ({f"{unknown:#x}"} if unknown else set()))


def without_disabled(model: Any) -> Any:
    """A copy of MuJoCo's model in which all that its flags switch off is zero."""
    model, off = copy.copy(model), disabled(model)
    for name in off & SWITCHES.keys():
        for array in SWITCHES[name].arrays:
            if hasattr(model, array):
                getattr(model, array)[:] = 0
    if "GRAVITY" in off:
        model.opt.gravity[:] = 0.0
    if off >= {"SPRING", "DAMPER"}:  # then MuJoCo computes none of its passive forces
        model.body_gravcomp[:] = 0.0
        model.opt.density = model.opt.viscosity = 0.0
    if is_unlifted(model) and model.jnt_actgravcomp.all():
        model.body_gravcomp[:] = 0.0
    return model


def is_unlifted(model: Any) -> bool:
    """Whether joints, along which actuators compensate gravity, have none that does."""
    off = not model.nu or "ACTUATION" in disabled(model)
    return bool(off and model.body_gravcomp.any() and model.jnt_actgravcomp.any())


def is_off(model: Any, number: int) -> str:
    """What the model switches off so that an actuator exerts nothing; "" where it acts."""
    if "ACTUATION" in disabled(model):
        return "actuators"
    group = int(model.actuator_group[number])
    off = 0 <= group <= 30 and bool(int(model.opt.disableactuator) >> group & 1)
    return f"actuators of group {group}" if off else ""


# --- Runs MuJoCo's compiler on a complete source ----------------------------------------------------------------------


_LINE = re.compile(r"[Ll]ine:? *=? *(\d+)")
#: An element by its number, as in "actuator 0", in messages of MuJoCo's compiler that have no line.
_COUNTED = re.compile(r"\b(actuator|tendon|equality|sensor) (\d+)\b")
#: The kind under which MuJoCo numbers the elements of a tag.
KINDS = {"body": "body", "joint": "jnt", "freejoint": "jnt", "geom": "geom", "site": "site"}
#: The numbers of the plugin mujoco.pid, in its order.
PID_KEYS = ("kp", "ki", "kd", "imax", "slewmax")


@dataclass(frozen=True, eq=False)
class CompiledMjcf:
    """MuJoCo's model and data at the pose of the start, with the source. `model` is without what the flags of the
    `whole` model switch off. `places` are those of elements by kind and number."""

    model: Any
    whole: Any
    data: Any
    source: MjcfSource
    places: Mapping[tuple[str, int], Place]

    def name(self, kind: str, number: int) -> str:
        """The name of an element, "" where it has none; `kind` is the name of MuJoCo's accessor, "body", "jnt", .."""
        return str(getattr(self.model, kind)(number).name)

    def place(self, kind: str, number: int) -> Place | None:
        """The place of an element; None where it is not known."""
        return self.places.get((kind, number))

    def output(self, number: int) -> int:
        """The number of an actuator's first force, by which MuJoCo orders gears and ranges of lengths."""
        return int(getattr(self.model, "actuator_outadr", np.arange(self.model.nu))[number])

    def bent(self, word: str, number: int) -> bool:
        """Whether a spring or a damper has a part that is not linear, as "jnt_stiffness" says; older versions of MuJoCo
        have none."""
        powers = getattr(self.model, f"{word}poly", None)
        return powers is not None and bool(np.any(powers[number]))

    def plugin_of(self, number: int) -> Mapping[str, float] | str | None:
        """The numbers of an actuator of the plugin `mujoco.pid`; for another plugin the reason to leave it out; None
        for an actuator without a plugin."""
        at = int(self.model.actuator_plugin[number])
        if at < 0:
            return None
        named = {child.get("plugin") for each in self.source.root.all("extension") for child in each.children}
        if named != {"mujoco.pid"}:
            return "a scene has no actuators of plugins, but for mujoco.pid alone"
        text = bytes(self.model.plugin_attr)[int(self.model.plugin_attradr[at]) :].split(b"\0")
        return {word: float(value or 0.0) for word, value in zip(PID_KEYS, text, strict=False)}

    def place_in(self, section: str, name: str) -> Place | None:
        """The place of the element with this name in a section; None where there is none."""
        elements = (element for each in self.source.root.all(section) for element in each.children)
        return next((element.place for element in elements if element.get("name") == name), None)


def compile_mjcf(source: MjcfSource, options: ImportOptions) -> CompiledMjcf:
    """Compile the source, and set the pose of the start. Raises InputError where MuJoCo is not installed or refuses the
    model, or a missing mesh would give a body its mass."""
    _refuse_without_mujoco(Place(source.root.place.file))
    if source.stand_ins:
        _refuse_mass_of_missing(source)
    whole = _model(source)
    model = without_disabled(whole)
    places = _places(model, source.root)
    _refuse_unusable(model, places, source.root.place)
    return CompiledMjcf(model, whole, _posed(model, source, options), source, places)


def _refuse_unusable(model: Any, places: Mapping[tuple[str, int], Place], root: Place) -> None:
    """Raises InputError where MuJoCo has computed a mass that is too large, or directions of no length."""
    problems: list[Problem] = []
    for kind, array, what in (
        ("body", "body_mass", "mass"),
        ("body", "body_inertia", "inertia"),
        *((kind, f"{kind}_quat", "orientation") for kind in ("body", "geom", "site")),
        ("body", "body_iquat", "orientation of the inertia"),
        ("jnt", "jnt_axis", "axis"),
    ):
        is_unit = "quat" in array or array == "jnt_axis"
        sizes = np.array([np.abs(row).max() for row in getattr(model, array)])
        for number in np.flatnonzero(~(np.abs(sizes - 1.0) < 1.0) if is_unit else ~(sizes <= LARGEST)):
            said = "has no direction" if is_unit else f"is not finite, or beyond {LARGEST:g}"
            place = places.get((kind, int(number)), root)
            problems.append(Problem(f"the {what} of a {kind} {said}", place, "repair it there"))
    if problems:
        raise InputError(problems)


def _refuse_without_mujoco(place: Place) -> None:
    """Raises InputError where MuJoCo is not installed, or its library cannot be loaded."""
    hint = "pip install 'mbproj[import]'"
    if find_spec("mujoco") is None:
        raise InputError(Problem("MuJoCo compiles MJCF, and is not installed", place, hint))
    try:
        from mujoco import MjModel  # noqa: F401
    except (ImportError, OSError, AttributeError) as error:
        why = " ".join(str(error).split())
        raise InputError(Problem(f"MuJoCo compiles MJCF, and cannot be loaded: {why}", place, hint)) from None


def _model(source: MjcfSource) -> Any:
    import mujoco

    text, places = source.text()
    try:
        with warnings_as_notes(source):
            return mujoco.MjModel.from_xml_string(text, assets=dict(source.meshes))
    except (ValueError, RuntimeError) as error:
        words = " ".join(str(error).split())
        line = _LINE.search(words)
        place = _place_of(source, words)
        if line and 0 < int(line[1]) <= len(places):
            place = places[int(line[1]) - 1]
        said = _LINE.sub("", words.removeprefix("XML Error: ").removeprefix("Error: ")).strip(" ,")
        raise InputError(Problem(f"MuJoCo refuses the model: {said}", place, "repair it there")) from None


@contextmanager
def warnings_as_notes(source: MjcfSource) -> Iterator[None]:
    """Turn MuJoCo's warnings into notes. By default it writes them to a file MUJOCO_LOG.TXT in the user's folder.
    Raises InputError where it ends with an error of its own."""
    import mujoco

    mujoco.set_mju_user_warning(lambda message: warn_once(f"MuJoCo: {message}"))
    try:
        yield
    except mujoco.FatalError as error:
        problem = Problem(f"MuJoCo refuses the model: {error}", source.root.place, "repair it there")
        raise InputError(problem) from None
    finally:
        mujoco.set_mju_user_warning(None)


def _place_of(source: MjcfSource, words: str) -> Place:
    """The place of the element that a message names by its number, as in "actuator 0"; else that of the model."""
    for section, number in _COUNTED.findall(words):
        elements = [element for each in source.root.all(section) for element in each.children]
        if int(number) < len(elements):
            return elements[int(number)].place
    return source.root.place


def _refuse_mass_of_missing(source: MjcfSource) -> None:
    """Raises InputError where the mass of a body depends on a missing mesh: it then differs between a model with heavy
    spheres for missing meshes and one with massless spheres."""
    attributes = [dict(element.attributes) for element in source.stand_ins]
    for element in source.stand_ins:
        element.attributes["size"] = "1"
    with_mass = _model(source).body_mass
    for element, old in zip(source.stand_ins, attributes, strict=True):
        element.attributes.clear()
        element.attributes.update(old | {"mass": "0"})
    try:
        without = _model(source).body_mass
    except InputError:
        without = None
    if without is None or (with_mass != without).any():
        element = source.stand_ins[0]
        what, place, why = source.missing[0]
        message = f"the mass of a body comes from the {what}, and {why}"
        hint = "put the file there, or give the body an <inertial>"
        raise InputError([Problem(message, element.place, hint), Problem(f"the {what}: {why}", place, "put it there")])


def _posed(model: Any, source: MjcfSource, options: ImportOptions) -> Any:
    """MuJoCo's data at the keyframe or the pose that the user asks for, else at the model's reference pose."""
    import mujoco

    data = mujoco.MjData(model)
    if options.key is not None:
        keys = [model.key(number).name or str(number) for number in range(model.nkey)]
        if options.key not in keys:
            hint = choose_from(options.key, keys) if keys else "the model has none"
            raise InputError(Problem(f"there is no keyframe '{options.key}'", Place(source.root.place.file), hint))
        mujoco.mj_resetDataKeyframe(model, data, keys.index(options.key))
    joints = {model.jnt(number).name: number for number in range(model.njnt)}
    for name, value in options.pose.items():
        if name not in joints or model.jnt_type[joints[name]] < 2:
            able = [each for each, number in joints.items() if each and model.jnt_type[number] >= 2]
            problem = f"the pose names '{name}', which is no hinge and no slide of the model"
            raise InputError(Problem(problem, Place(source.root.place.file), choose_from(name, able)))
        data.qpos[model.jnt_qposadr[joints[name]]] = value
    with warnings_as_notes(source):
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
    return data


def _places(model: Any, root: XmlElement) -> dict[tuple[str, int], Place]:
    """The places of elements by kind and number, found by name, or by order where the file has as many as the model."""
    places: dict[tuple[str, int], Place] = {}
    world = [element for each in root.all("worldbody") for element in each.walk()]
    for kind in ("body", "jnt", "geom", "site"):
        elements = [element for element in world if KINDS.get(element.tag) == kind]
        first = 1 if kind == "body" else 0
        count = {"body": model.nbody - 1, "jnt": model.njnt, "geom": model.ngeom, "site": model.nsite}[kind]
        named = {element.get("name"): element.place for element in elements if element.get("name")}
        ordered = elements if len(elements) == count else []
        for number in range(count):
            name = getattr(model, kind)(number + first).name
            if name in named:
                places[kind, number + first] = named[name]
            elif ordered and kind == "body":
                places[kind, number + first] = ordered[number].place
    return places
