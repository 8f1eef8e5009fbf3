"""Reads an MJCF model as a mechanism: by MuJoCo's compiler, then bodies, joints, loops, actuators, and the rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import Place, shortened
from mbproj.formats.chains import Coordinates, free_name, with_hinges
from mbproj.formats.geometry import Frame, from_quaternion
from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportedNames, ImportOptions, Quantity, Same, said_of
from mbproj.formats.mjcf.actuators import add_actuators
from mbproj.formats.mjcf.compiled import SWITCHES, CompiledMjcf, compile_mjcf, disabled, enabled, is_unlifted
from mbproj.formats.mjcf.equalities import add_equalities
from mbproj.formats.mjcf.joints import FREE, Called, add_joints, add_parts, start_of
from mbproj.formats.mjcf.source import source_of
from mbproj.formats.mjcf.tendon_forces import add_tendons
from mbproj.formats.mjcf.tendon_paths import ModelTendons
from mbproj.formats.signals import add_motions
from mbproj.formats.visuals import Shapes, Visual, add_visuals, box, capsule, colour, cylinder, sphere
from mbproj.formats.xml import XmlElement
from mbproj.scene.records import GROUND


def read_mjcf(root: XmlElement, path: Path, options: ImportOptions) -> ImportedMechanism:
    """The mechanism of the model in the file at `path`, whose root element is `root`. Raises InputError at the file's
    line."""
    compiled = compile_mjcf(source_of(root, path), options)
    gravity = np.array(compiled.model.opt.gravity)
    mechanism = ImportedMechanism(root.get("model") or path.stem, "MJCF", str(path), gravity)
    bodies, joints, coordinates = ImportedNames(frozenset({GROUND})), ImportedNames(), Coordinates()
    called = add_parts(compiled, mechanism, bodies)
    add_joints(compiled, mechanism, called, joints, coordinates)
    tendons = ModelTendons(compiled, mechanism, called, coordinates, joints)
    add_equalities(tendons)
    with_hinges(mechanism)
    add_visuals(mechanism, visuals(compiled, called), options.folder or path.parent)
    add_markers(compiled, mechanism, called)
    say_rest(tendons, options)
    add_motions(mechanism, coordinates, options.motions, start_of(compiled, called))
    for kind, names in (("bodies", bodies), ("joints", joints)):
        mechanism.said += said_of(mechanism, kind, names)
    for what, place, why in compiled.source.gone:
        mechanism.say(what, place, f"left out: {why}", Same.NO)
    for what, place, why in compiled.source.missing:
        mechanism.say(what, place, f"{why}: it is not drawn", Same.YES)
    mechanism.compare = partial(_compare, compiled, called, options)
    return mechanism


def _compare(
    compiled: CompiledMjcf, called: Called, options: ImportOptions, mechanism: ImportedMechanism, version: str
) -> Agreement | None:
    from mbproj.formats.mjcf.comparison import compare

    return compare(compiled, called, options, mechanism, version)


def say_rest(tendons: ModelTendons, options: ImportOptions) -> None:
    """Add rows on all parts of the model except bodies, joints and loops."""
    compiled, mechanism = tendons.compiled, tendons.mechanism
    add_actuators(tendons, options)
    _contacts(compiled, mechanism, tendons.called, options)
    add_tendons(tendons)
    _keyframes(compiled, mechanism, options)
    say_options(compiled, mechanism)
    _surroundings(compiled, mechanism)


def _contacts(compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called, options: ImportOptions) -> None:
    """Add a row on shapes that may touch. On request, add a stop for each sphere, and each end of a capsule, above a
    plane of the ground."""
    model = compiled.model
    able = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    if "CONTACT" not in disabled(model) and "CONSTRAINT" not in disabled(model):
        able[[*model.pair_geom1, *model.pair_geom2]] = True
    touching = np.flatnonzero(able)
    moving = [geom for geom in touching if called[int(model.geom_bodyid[geom])] != GROUND]
    if not moving:
        return
    stops = 0
    planes = [geom for geom in touching if int(model.geom_type[geom]) == PLANE and geom not in moving]
    stopped = set[tuple[int, int]]()
    for plane in planes if options.contacts else []:
        for geom in moving:
            count = _stops(compiled, mechanism, called, int(geom), int(plane))
            stops += count
            stopped |= {(int(plane), int(geom))} if count else set()
    what = "left out: shapes pass through each other"
    if planes and not options.contacts:
        what += "; --contacts makes stops of spheres and capsules above planes"
    elif stops:
        what = (
            f"{stops} spheres above planes are rigid stops without friction; all other shapes pass through each other"
        )
    mechanism.say(f"contacts of {len(moving)} shapes", None, what, Same.UNTIL)
    if touched := _touching_pairs(compiled) - stopped:
        shown = shortened([" and ".join(_geom_name(compiled, geom) for geom in pair) for pair in sorted(touched)], 3)
        what = f"left out, although they touch at the start: {shown}"
        mechanism.say(f"contacts of {len(touched)} pairs of shapes", None, what, Same.NO)


def _touching_pairs(compiled: CompiledMjcf) -> set[tuple[int, int]]:
    """The pairs of shapes that exert forces on each other from the start on, with a plane first. None are known where
    meshes are missing, for which spheres stand."""
    if compiled.source.stand_ins:
        return set()
    data = compiled.data
    contacts = (data.contact[at] for at in range(data.ncon))
    return {(int(each.geom1), int(each.geom2)) for each in contacts if each.dist <= 0.0 and not each.exclude}


def _geom_name(compiled: CompiledMjcf, number: int) -> str:
    body = compiled.name("body", int(compiled.model.geom_bodyid[number])) or "the ground"
    return f"'{compiled.name('geom', number)}'" if compiled.name("geom", number) else f"one of {body}"


def _stops(compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called, geom: int, plane: int) -> int:
    model, data = compiled.model, compiled.data
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    matrix = data.geom_xmat[geom].reshape(3, 3)
    shifts = {SPHERE: [0.0], CAPSULE: [-size[1], size[1]]}.get(kind, [])
    body = called[int(model.geom_bodyid[geom])]
    normal, origin = data.geom_xmat[plane].reshape(3, 3)[:, 2], data.geom_xpos[plane]
    for shift in shifts:
        centre = data.geom_xpos[geom] + shift * matrix[:, 2]
        name = free_name(mechanism, f"{compiled.name('geom', geom) or body}_on_plane")
        mechanism.forces[name] = {
            "type": "stop",
            "plane": {"body": GROUND, "location": np.array(origin), "normal": np.array(normal)},
            "point": {"body": body, "location": {body: mechanism.parts[body].local(centre)}},
            "radius": Quantity(float(size[0]), "m"),
            "rigid": True,
        }
    return len(shifts)


def _keyframes(compiled: CompiledMjcf, mechanism: ImportedMechanism, options: ImportOptions) -> None:
    model = compiled.model
    names = [model.key(number).name or str(number) for number in range(model.nkey)]
    if names:
        begins = f"begins at '{options.key}'" if options.key else "begins at the model's reference pose"
        what = f"the scene {begins}; --at takes one of {', '.join(names[:8])}"
        mechanism.say(f"{len(names)} keyframes", None, what, Same.YES)


def _surroundings(compiled: CompiledMjcf, mechanism: ImportedMechanism) -> None:
    """Add rows on what limits actuators, on what a scene has no bodies for, and on parts that only measure."""
    model = compiled.model
    limited = np.any(model.jnt_actfrclimited[model.jnt_type != FREE]) or np.any(model.tendon_actfrclimited)
    if model.nu and limited:
        mechanism.say("limits of actuators' forces", None, "left out", Same.UNTIL)
    for count, what in ((model.nsensor, "sensors"), (model.ncam, "cameras")):
        if count:
            mechanism.say(f"{count} {what}", None, "left out: they do not act on the motion", Same.YES)
    if model.nflex:
        what = "left out: a scene has no flexible bodies, and their parts move apart"
        mechanism.say(f"{model.nflex} flexible bodies", None, what, Same.NO)
    if model.nplugin:
        mechanism.say(f"{model.nplugin} plugins", None, "left out", Same.NO)


# --- The appearance of an MJCF model ----------------------------------------------------------------------------------
# Geoms as shapes and meshes of bodies, sites as markers, with no effect on motion.


PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)
WORDS = {MESH: "meshes", ELLIPSOID: "ellipsoids"}


def visuals(compiled: CompiledMjcf, called: Called) -> Iterator[Visual]:
    """Yield the geoms of bodies, at the pose of the start."""
    model, data = compiled.model, compiled.data
    for geom in range(model.ngeom):
        kind, material = int(model.geom_type[geom]), int(model.geom_matid[geom])
        pose = Frame(data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3))
        look = colour(model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])
        body, mesh, scale = called[int(model.geom_bodyid[geom])], None, 1.0
        if kind == MESH:
            number = int(model.geom_dataid[geom])
            mesh = compiled.source.files.get(model.mesh(number).name)
            scales = np.array(model.mesh_scale[number])
            scale, mesh = float(scales[0]), mesh if (scales == scales[0]).all() else None
            # MuJoCo's frame of a mesh has the mesh's centre of mass and principal axes.
            moved = Frame(np.array(model.mesh_pos[number]), from_quaternion(model.mesh_quat[number]))
            pose = pose.then(moved.inverse())
        yield Visual(
            body, pose, _shapes(kind, model.geom_size[geom]), mesh, scale, look, WORDS.get(kind, "other shapes")
        )


def _shapes(kind: int, size: Array) -> Shapes:
    if kind == SPHERE:
        return sphere(size[0])
    if kind == BOX:
        return box(2.0 * size[:3])
    if kind in (CYLINDER, CAPSULE):
        return (cylinder if kind == CYLINDER else capsule)(size[0], 2.0 * size[1])
    return ()


def add_markers(compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called) -> None:
    """Add a marker for each site of a body that moves."""
    model, still = compiled.model, 0
    for site in range(model.nsite):
        body = called[int(model.site_bodyid[site])]
        if body not in mechanism.parts:
            still += 1
            continue
        mechanism.mark(compiled.name("site", site) or f"site_{site}", body, compiled.data.site_xpos[site])
    if still:
        mechanism.say(f"{still} sites of the ground", None, "left out: a marker is of a body that moves", Same.YES)


# --- Options of an MJCF model -----------------------------------------------------------------------------------------
# Flags that switch parts of the physics off act, and each other option gets a row of the table. MuJoCo's own list of
# options and flags is gone through, so that one of a later version has its row, too.


SOLVER, CONTACTS, SENSORS = "of MuJoCo's numerical method", "of contacts", "of sensors and reports"
#: What the other flags and options belong to. Flags are in capitals: those that are disabled, and that are enabled.
OTHERS: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(("WARMSTART", "REFSAFE", "EULERDAMP", "AUTORESET", "ISLAND", "INVDISCRETE", "DIAGEXACT"), SOLVER)
    | dict.fromkeys(("timestep", "integrator", "solver", "jacobian", "iterations", "tolerance"), SOLVER)
    | dict.fromkeys(("ls_iterations", "ls_tolerance", "noslip_iterations", "noslip_tolerance"), SOLVER)
    | dict.fromkeys(("FILTERPARENT", "MIDPHASE", "NATIVECCD", "MULTICCD", "OVERRIDE", "SPECULATIVE", "IPC"), CONTACTS)
    | dict.fromkeys(("cone", "impratio", "ccd_iterations", "ccd_tolerance", "sdf_initpoints"), CONTACTS)
    | dict.fromkeys(("sdf_iterations", "o_margin", "o_solref", "o_solimp", "o_friction"), CONTACTS)
    | dict.fromkeys(("SENSOR", "ENERGY", "FWDINV", "magnetic"), SENSORS)
)
#: The options that act in the scene, or that get their rows where other parts do.
ELSEWHERE = (
    *("gravity", "density", "viscosity", "wind", "sleep_tolerance"),
    *("disableflags", "enableflags", "disableactuator"),
)


def say_options(compiled: CompiledMjcf, mechanism: ImportedMechanism) -> None:
    """Add a row on each flag that switches something off, on other options by what they belong to, and on a medium."""
    model, off, place = compiled.whole, disabled(compiled.whole), _place(compiled, "flag")
    for name in sorted(off & SWITCHES.keys()):
        mechanism.say(f"flag {name.lower()}", place, f"acts: the model turns {SWITCHES[name].what} off", Same.YES)
    if off >= {"SPRING", "DAMPER"} and (compiled.whole.ngravcomp or model.opt.density or model.opt.viscosity):
        what = "act: without both MuJoCo computes no compensation of gravity and no medium either"
        mechanism.say("flags spring and damper", place, what, Same.YES)
    by_kind: dict[str, list[str]] = {}
    for name in _changed(model, off):
        by_kind.setdefault(OTHERS.get(name, ""), []).append(f"flag {name.lower()}" if name.isupper() else name)
    for kind, names in by_kind.items():
        _say_others(compiled, mechanism, kind, names)
    if "SLEEP" in enabled(model):
        what = "left out: bodies that move slowly come to rest in MuJoCo"
        mechanism.say("flag sleep", place, what, Same.UNTIL)
    _say_medium(compiled, mechanism)
    if is_unlifted(compiled.model):
        what = "left out: it has no effect without actuators, and the scene compensates gravity along all joints"
        mechanism.say("actuatorgravcomp of some joints", None, what, Same.NO)


def _changed(model: Any, off: frozenset[str]) -> Iterator[str]:
    """Yield the names of the flags and options that are not MuJoCo's own and do not act."""
    import mujoco

    usual = mujoco.MjOption()
    yield from sorted(off - SWITCHES.keys())
    yield from sorted(enabled(model) - {"SLEEP"})
    for name in dir(usual):
        if name.startswith("_") or name in ELSEWHERE or callable(getattr(usual, name)):
            continue
        if not np.array_equal(getattr(usual, name), getattr(model.opt, name)):
            yield name


def _say_others(compiled: CompiledMjcf, mechanism: ImportedMechanism, kind: str, names: list[str]) -> None:
    """Add the row on options of one kind; those of no known kind may affect the motion."""
    place, shown = _place(compiled, "option"), ", ".join(names)
    touch = bool(compiled.model.npair or (compiled.model.geom_contype | compiled.model.geom_conaffinity).any())
    rows = {
        SOLVER: ("left out: a scene has a numerical method of its own", Same.YES),
        CONTACTS: ("left out, as contacts are", Same.UNTIL if touch else Same.YES),
        SENSORS: ("left out: they do not act on the motion", Same.YES),
        "": ("left out: mbproj does not know their effect", Same.NO),
    }
    mechanism.say(f"options {kind}: {shown}" if kind else f"options {shown}", place, *rows[kind])


def _say_medium(compiled: CompiledMjcf, mechanism: ImportedMechanism) -> None:
    option, place = compiled.model.opt, _place(compiled, "option")
    if option.density or option.viscosity:
        wind = ", and its wind" if option.wind.any() else ""
        mechanism.say(f"medium with density or viscosity{wind}", place, "left out: a scene has none", Same.NO)
    elif option.wind.any():
        mechanism.say("option wind", place, "left out: it has no force without density and viscosity", Same.YES)


def _place(compiled: CompiledMjcf, tag: str) -> Place | None:
    """The place of the first <option>, or of the first <flag> in one."""
    options = compiled.source.root.all("option")
    elements = options if tag == "option" else [each for option in options for each in option.all(tag)]
    return next((each.place for each in elements), None)
