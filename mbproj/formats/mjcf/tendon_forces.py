"""Springs, dampers, limits, dry friction and armature along tendons of an MJCF model; others get a row of the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.formats.chains import free_name
from mbproj.formats.mechanism import Bare, ImportedMechanism, ImportedNames, Quantity, Same
from mbproj.formats.mjcf.joints import HINGE, SLIDE
from mbproj.formats.mjcf.laws import free_symbol, summed
from mbproj.formats.mjcf.tendon_paths import MeasuringCoordinate, ModelTendons, is_path
from mbproj.formats.yaml_text import number as shown

# --- Coordinates that a force acts along ------------------------------------------------------------------------------
# Those of joints, lines between points, lengths of ropes, and sums of these.


#: The reason for the table where a scene has no force along a coordinate of the model.
NOTHING = "a scene has no force along what it pulls"


@dataclass(frozen=True, eq=False)
class ActuatedCoordinate:
    """A coordinate s that an actuator acts along, with length = factor (start + s). `entry` has the first keys of its
    force in the scene; `s`, `force` and `free` are the scene's words for the coordinate, the force and the free
    length. `unit` is that of s."""

    entry: Mapping[str, Any]
    s: str
    force: str
    free: str
    unit: str
    factor: float
    start: float


def along_of(tendons: ModelTendons, number: int) -> list[ActuatedCoordinate] | str:
    """The coordinates that an actuator acts along, or the reason why there are none."""
    import mujoco

    model, of = tendons.compiled.model, mujoco.mjtTrn
    kind, what = int(model.actuator_trntype[number]), int(model.actuator_trnid[number][0])
    gear = float(model.actuator_gear[tendons.compiled.output(number)][0])
    if kind in (int(of.mjTRN_JOINT), int(of.mjTRN_JOINTINPARENT)):
        return _of_joints(tendons, {what: 1.0}, gear)
    if kind == int(of.mjTRN_TENDON):
        return along_tendon(tendons, what, gear)
    return NOTHING


def along_tendon(tendons: ModelTendons, number: int, factor: float = 1.0) -> list[ActuatedCoordinate] | str:
    """The coordinates whose sum is the length of a tendon: lines between two sites, ropes, or those of joints. Else the
    reason why there are none."""
    if not is_path(tendons.compiled, number):
        return _of_joints(tendons, tendons.joints(number), factor)
    if wrong := tendons.wrong(number):
        return wrong
    coordinates: list[ActuatedCoordinate] = []
    tendons.acting.add(number)
    for at, branch in enumerate(tendons.branches(number)):
        line, weight = tendons.ends(branch), factor * branch.weight
        start = tendons.constant(number) / branch.weight if not at else 0.0
        if line is None:
            rope = {"type": "linear_spring_damper", "joint": tendons.rope(number, at), "coordinate": "length"}
            coordinates.append(
                ActuatedCoordinate(rope, "displacement", "force", "free_displacement", "m", weight, start)
            )
        else:
            rod = {"type": "spring_damper", "bodies": list(line[0]), "locations": dict(zip(*line, strict=True))}
            coordinates.append(ActuatedCoordinate(rod, "l", "force", "free_length", "m", weight, start))
    return coordinates or "nothing changes its length"


def _of_joints(tendons: ModelTendons, weights: Mapping[int, float], factor: float) -> list[ActuatedCoordinate] | str:
    """The coordinates of joints, with their weights; or the reason where a joint has none."""
    coordinates = [_on_joint(tendons, joint, factor * weight) for joint, weight in weights.items()]
    known = [each for each in coordinates if each is not None]
    return known if known and len(known) == len(coordinates) else NOTHING


def _on_joint(tendons: ModelTendons, joint: int, factor: float) -> ActuatedCoordinate | None:
    model = tendons.compiled.model
    turns = int(model.jnt_type[joint]) == HINGE
    where = tendons.coordinate(joint)
    if where is None or int(model.jnt_type[joint]) not in (HINGE, SLIDE):
        return None
    entry: dict[str, Any] = {"type": "torsion_spring_damper" if turns else "linear_spring_damper", "joint": where[0]}
    if where[1] not in ("angle", "displacement") or tendons.mechanism.joints[where[0]].type == "cylindrical":
        entry["coordinate"] = where[1]
    s, force = ("angle", "torque") if turns else ("displacement", "force")
    start = float(tendons.compiled.data.qpos[model.jnt_qposadr[joint]])
    return ActuatedCoordinate(entry, s, force, f"free_{s}", "rad" if turns else "m", factor, start)


def length_of(along: list[ActuatedCoordinate], names: list[str]) -> tuple[str, str]:
    """The expressions of the length that the coordinates sum up to, and of its rate; `names` are those of the forces
    along the coordinates."""
    seen = []
    for each, name in zip(along, names, strict=True):
        of = (
            f"{each.entry['joint']}.{each.entry.get('coordinate', each.s)}"
            if "joint" in each.entry
            else f"{name}.length"
        )
        seen.append(of.replace("-", "_"))
    start = (sum(each.factor * each.start for each in along), "1")
    return summed([start, *_terms(along, seen, "")]), summed(_terms(along, seen, "_dot"))


def _terms(along: list[ActuatedCoordinate], seen: list[str], ending: str) -> list[tuple[float, str]]:
    return [(each.factor, name + ending) for each, name in zip(along, seen, strict=True)]


def names_along(mechanism: ImportedMechanism, name: str, along: list[ActuatedCoordinate]) -> list[str]:
    """Free names for the forces along the coordinates."""
    names: list[str] = []
    for _ in along:
        names.append(ImportedNames(frozenset([*mechanism.forces, *names])).unused(name))
    return names


def act_along(
    mechanism: ImportedMechanism, name: str, along: list[ActuatedCoordinate], names: list[str], force: str
) -> None:
    """Add a signal with the expression `force`, and forces along each coordinate that are factor times the signal."""
    signal = free_symbol(mechanism, f"{name}_force")
    mechanism.signals[signal] = Bare(force)
    for force_name, each in zip(names, along, strict=True):
        mechanism.forces[force_name] = {**each.entry, each.force: Bare(summed([(each.factor, signal)]))}


# --- Springs, dampers, limits, dry friction and armature along tendons of an MJCF model -------------------------------


#: The nonlinear parts of a spring and of a damper, as the table names them.
BENT = ("stiffness that is not linear", "damping that is not linear")
#: The keys of a stop for the least and the largest distance of two points.
SIDES = ("shortest", "longest")
#: A limit beyond this length in m counts as none.
NO_LIMIT = 1e5


def add_tendons(tendons: ModelTendons) -> None:
    """Add all that acts along each tendon. A tendon that only couples gets its row with its equality."""
    mechanism = tendons.mechanism
    for number in range(tendons.compiled.model.ntendon):
        name, place = tendons.name(number), tendons.place(number)
        if tendons.is_constant(number):
            mechanism.say(f"tendon '{name}'", place, "left out: nothing changes its length", Same.YES)
            continue
        left = {word for word, values in _acting(tendons.compiled.model).items() if np.any(values[number])}
        why = "a scene's springs do not yield"
        for step in (_between, _elastic, _pulled, _limited, _loaded):
            done = step(tendons, number, left)
            left, why = (left, done) if isinstance(done, str) else (left - done, why)
        if left:
            what = f"left out with its {', '.join(sorted(left))}: {why}"
            mechanism.say(f"tendon '{name}'", place, what, Same.NO)
        _say_bends(tendons, number)


def _say_bends(tendons: ModelTendons, number: int) -> None:
    """Add rows on how the scene's rope differs from the model's tendon, and on a tendon along which nothing acts."""
    mechanism, element = tendons.mechanism, f"tendon '{tendons.name(number)}'"
    place = tendons.place(number)
    if not tendons.branches(number) or element in {row.element for row in mechanism.said}:
        return
    if number not in tendons.acting:
        mechanism.say(element, place, "left out: nothing acts along it", Same.YES)
    elif tendons.bends(number):
        mechanism.say(element, place, "a rope: the run ends where it leaves one of its shapes", Same.UNTIL)
    if number in tendons.acting and (passed := tendons.passed(number)):
        what = f"runs past {', '.join(passed)}: the scene's is without these, which it does not touch at the start"
        mechanism.say(element, place, what, Same.UNTIL)


def _acting(model: Any) -> dict[str, Array]:
    """The numbers of all that may act along tendons, by the word for it."""
    laws = {
        "limit": model.tendon_limited,
        "spring": model.tendon_stiffness,
        "damping": model.tendon_damping,
        "dry friction": model.tendon_frictionloss,
        "armature": model.tendon_armature,
    }
    for word, attribute in zip(BENT, ("stiffnesspoly", "dampingpoly"), strict=True):
        values = getattr(model, f"tendon_{attribute}", None)
        if values is not None:
            laws[word] = values
    if hasattr(model, "tendon_springyield"):
        laws["yield of its spring"] = model.tendon_springyield
    return laws


def _between(tendons: ModelTendons, number: int, left: set[str]) -> set[str]:
    """Add the spring, the damper and the limit of a tendon, as far as they are in `left`, along the line between two
    points. Return the words of those added."""
    line, model, mechanism = tendons.line(number), tendons.compiled.model, tendons.mechanism
    if line is None or not left:
        return set()
    done = set[str]()
    tendons.acting.add(number)
    ends = {"bodies": list(line[0]), "locations": dict(zip(*line, strict=True))}
    low, high = (float(each) for each in model.tendon_lengthspring[number])
    if left & {"spring", "damping"} and not left & {*BENT} and (low == high or "spring" not in left):
        done |= {"spring", "damping"}
        entry: dict[str, Any] = {"type": "spring_damper", **ends}
        if "spring" in left:
            stiffness = float(model.tendon_stiffness[number])
            entry |= {"stiffness": Quantity(stiffness, "N/m"), "free_length": Quantity(low, "m")}
        if "damping" in left:
            entry["damping"] = Quantity(float(model.tendon_damping[number]), "N*s/m")
        mechanism.forces[free_name(mechanism, tendons.name(number))] = entry
    if "limit" not in left:
        return done
    limits = _limits(tendons, number) or (None, None)
    sides = {side: Quantity(value, "m") for side, value in zip(SIDES, limits, strict=True) if value is not None}
    if sides:
        entry = {"type": "stop", **ends, "rigid": True, **sides}
        name = tendons.name(number)
        mechanism.forces[free_name(mechanism, f"{name}_limit" if name in mechanism.forces else name)] = entry
        _say_rigid(tendons, number)
    return done | {"limit"}


def _elastic(tendons: ModelTendons, number: int, left: set[str]) -> set[str]:
    """Make an elastic rope of a tendon whose spring only pulls, where it is slack at the start and nothing else acts
    along it. Return the words of what was added."""
    model, branches = tendons.compiled.model, tendons.branches(number)
    low, high = (float(each) for each in model.tendon_lengthspring[number])
    alone = len(branches) == 1 and branches[0].weight == 1.0 and not tendons.wrong(number)
    if not alone or tendons.ends(branches[0]) or tendons.is_held(number) or tendons.length(number) > high:
        return set()
    if "spring" not in left or left & {"damping", "limit", *BENT} or not low <= 0.0 < high - tendons.constant(number):
        return set()
    length = Quantity(high - tendons.constant(number), "m")
    stiffness = Quantity(float(model.tendon_stiffness[number]), "N/m")
    tendons.say_length(tendons.rope(number, 0), length=length, stiffness=stiffness)
    return {"spring"}


def _pulled(tendons: ModelTendons, number: int, left: set[str]) -> set[str] | str:
    """Add the spring and the damper along coordinates: one force, or a signal where there are several coordinates or
    the law is not linear. Return the words of those added, or the reason why there are none."""
    model, mechanism, name = tendons.compiled.model, tendons.mechanism, tendons.name(number)
    if not left & {"spring", "damping", *BENT}:
        return set()
    along = along_tendon(tendons, number)
    if isinstance(along, str):
        return along
    done = {"spring", "damping", *BENT}
    springs, dampers = _powers(model, "stiffness", number), _powers(model, "damping", number)
    low, high = (float(each) for each in model.tendon_lengthspring[number])
    if len(along) == 1 and along[0].entry.get("coordinate") == "length" and low == high and not left & {*BENT}:
        mechanism.forces[free_name(mechanism, f"{name}_spring")] = _linear(along[0], springs[0], dampers[0], low)
        return done
    names = names_along(mechanism, name, along)
    length, rate = length_of(along, names)
    x = free_symbol(mechanism, f"{name}_stretch")
    stretch = (
        f"{length} - ({shown(low)})" if low == high else f"({length}) - clip({length}, {shown(low)}, {shown(high)})"
    )
    v = free_symbol(mechanism, f"{name}_rate")
    spring = [(-factor, x if not power else f"{x}**{power + 1}") for power, factor in enumerate(springs)]
    odd = [v, f"{v}*abs({v})", f"{v}**3"]
    act_along(
        mechanism, name, along, names, summed([*spring, *((-c, text) for c, text in zip(dampers, odd, strict=False))])
    )
    if any(springs):
        mechanism.signals[x] = Bare(stretch)
    if any(dampers):
        mechanism.signals[v] = Bare(rate)
    return done


def _linear(along: ActuatedCoordinate, stiffness: float, damping: float, free: float) -> dict[str, Any]:
    """The entry of a linear spring and damper on one coordinate."""
    entry, square = dict(along.entry), along.factor**2
    if stiffness:
        entry["stiffness"] = Quantity(square * stiffness, "N/m")
        entry[along.free] = Quantity(free / along.factor - along.start, along.unit)
    if damping:
        entry["damping"] = Quantity(square * damping, "N*s/m")
    return entry


def _powers(model: Any, word: str, number: int) -> list[float]:
    """The factors of x, x², .. in the force of a spring or a damper."""
    more = getattr(model, f"tendon_{word}poly", None)
    return [float(getattr(model, f"tendon_{word}")[number]), *(map(float, more[number]) if more is not None else ())]


def _limits(tendons: ModelTendons, number: int) -> tuple[float | None, float | None] | None:
    """The least and the largest length in m, each None where it is no limit. None, with a row of the table, where the
    pose is beyond them."""
    low, high = (float(each) for each in tendons.compiled.model.tendon_range[number])
    if not low <= tendons.length(number) <= high or low == high:
        element = f"limit of tendon '{tendons.name(number)}'"
        tendons.mechanism.say(element, tendons.place(number), "left out: the pose is beyond it", Same.NO)
        return None
    least = 0.0 if tendons.branches(number) else -NO_LIMIT
    return low if low > least else None, high if high < NO_LIMIT else None


def _say_rigid(tendons: ModelTendons, number: int) -> None:
    what = "a stiff spring in MuJoCo, a rigid stop in the scene"
    tendons.mechanism.say(f"limit of tendon '{tendons.name(number)}'", tendons.place(number), what, Same.UNTIL)


def _limited(tendons: ModelTendons, number: int, left: set[str]) -> set[str] | str:
    """Add the limit of a tendon: of a rope that is slack below it, or of a coordinate. Return the words of what was
    added, or the reason why there is none."""
    if "limit" not in left:
        return set()
    if tendons.is_held(number):
        return {"limit"}
    measured = tendons.measured(number, dry="dry friction" in left)
    if isinstance(measured, str):
        return measured
    limits = _limits(tendons, number)
    if limits is None or limits == (None, None):
        return {"limit"}
    joint, coordinate, ratio, constant = measured
    low, high = (None if each is None else Quantity((each - constant) / ratio, "m") for each in limits)
    if tendons.mechanism.joints[joint].type == "rope" and low is None and high is not None:
        tendons.say_length(joint, slack=True, length=high)
    else:
        tendons.say_length(joint, limits={coordinate: {"range": [low, high], "rigid": True}})
    _say_rigid(tendons, number)
    return {"limit"}


def _loaded(tendons: ModelTendons, number: int, left: set[str]) -> set[str] | str:
    """Add armature and dry friction to a coordinate that determines the length. Return the words of those added, or the
    reason why there are none."""
    model, mechanism = tendons.compiled.model, tendons.mechanism
    done = left & {"armature", "dry friction"}
    if not done:
        return set()
    measured: MeasuringCoordinate | str = tendons.measured(number, dry="dry friction" in left)
    if isinstance(measured, str) and "armature" in left and not isinstance(smooth := tendons.measured(number), str):
        why, measured = measured, smooth
        mechanism.say(f"dry friction of tendon '{tendons.name(number)}'", tendons.place(number), why, Same.NO)
        done = {"armature"}
    if isinstance(measured, str):
        return measured
    joint, _, ratio, _ = measured
    if "armature" in done:
        inertia = Quantity(ratio**2 * float(model.tendon_armature[number]), "kg")
        tendons.add_key(joint, "reflected_inertia", inertia)
    if "dry friction" in done:
        amount = Quantity(ratio * float(model.tendon_frictionloss[number]), "N")
        entry = {"type": "friction", "joint": joint, "coulomb": {"force": amount}}
        mechanism.forces[free_name(mechanism, f"{tendons.name(number)}_friction")] = entry
    return left & {"armature", "dry friction"}
