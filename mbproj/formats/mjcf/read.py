"""Reads an MJCF model as a mechanism: by MuJoCo's compiler, then bodies, joints, loops, actuators, and the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbproj.formats.chains import Coordinates
from mbproj.formats.mechanism import ImportedMechanism, ImportedNames, ImportOptions, Same, said_of
from mbproj.formats.merged import with_hinges
from mbproj.formats.mjcf.appearance import add_markers, visuals
from mbproj.formats.mjcf.compiled import compile_mjcf
from mbproj.formats.mjcf.equalities import add_equalities
from mbproj.formats.mjcf.joints import add_joints, start_of
from mbproj.formats.mjcf.parts import add_parts
from mbproj.formats.mjcf.rest import say_rest
from mbproj.formats.mjcf.source import source_of
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
    if compiled.disables("GRAVITY"):
        gravity = np.zeros(3)
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
    return mechanism
