"""Reads an MJCF model as a mechanism: by MuJoCo's compiler, then bodies, joints, loops, actuators, and the rest."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from mbproj.errors import shortened
from mbproj.formats.chains import Coordinates, free_name
from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportedNames, ImportOptions, Quantity, Same, said_of
from mbproj.formats.merged import with_hinges
from mbproj.formats.mjcf.actuators import add_actuators
from mbproj.formats.mjcf.appearance import CAPSULE, PLANE, SPHERE, add_markers, visuals
from mbproj.formats.mjcf.compiled import CompiledMjcf, compile_mjcf
from mbproj.formats.mjcf.equalities import add_equalities
from mbproj.formats.mjcf.flags import disabled
from mbproj.formats.mjcf.joints import FREE, add_joints, start_of
from mbproj.formats.mjcf.options import say_options
from mbproj.formats.mjcf.parts import Called, add_parts
from mbproj.formats.mjcf.source import source_of
from mbproj.formats.mjcf.tendons.acting import add_tendons
from mbproj.formats.mjcf.tendons.measured import ModelTendons
from mbproj.formats.signals import add_motions
from mbproj.formats.visuals import add_visuals
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
            made = _stops(compiled, mechanism, called, int(geom), int(plane))
            stops += made
            stopped |= {(int(plane), int(geom))} if made else set()
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
    found = (data.contact[at] for at in range(data.ncon))
    return {(int(each.geom1), int(each.geom2)) for each in found if each.dist <= 0.0 and not each.exclude}


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
