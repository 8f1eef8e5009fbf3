"""A model's file -> a mechanism, by the format that its content has."""

from __future__ import annotations

from pathlib import Path

from mbproj.base.errors import InputError, Place, Problem
from mbproj.formats.mechanism import ImportedMechanism, ImportOptions
from mbproj.formats.mjcf.read import read_mjcf
from mbproj.formats.sdf.read import read_sdf
from mbproj.formats.urdf import read_urdf
from mbproj.formats.xml import XmlElement, parse, read_text

#: The reader of each format, by the tag of the root element.
READERS = {"mujoco": read_mjcf, "robot": read_urdf, "sdf": read_sdf}
#: The name of each format, by that tag.
NAMES = {"mujoco": "MJCF", "robot": "URDF", "sdf": "SDF"}


def read_model(path: Path, import_options: ImportOptions | None = None) -> ImportedMechanism:
    """The model in the file. Raises InputError, with the file's line, where it is wrong, and where nothing can move."""
    shown = str(path)
    root = parse(read_text(path, shown), shown)
    _refuse_others(root)
    _refuse_options(root, import_options or ImportOptions())
    try:
        mechanism = READERS[root.tag](root, path, import_options or ImportOptions())
    except RecursionError:  # files that include each other have levels beyond those of one file
        raise InputError(Problem("the elements are nested too deep", root.place, "include fewer levels")) from None
    if not mechanism.parts:
        raise InputError(Problem("no body of the model can move", Place(shown), "a scene needs one: add a joint"))
    return mechanism


def _refuse_others(root: XmlElement) -> None:
    """Raises InputError at the root of a file whose format mbproj does not read."""
    if any(element.tag.startswith("xacro:") for element in root.walk()):
        hint = "expand it first: xacro model.urdf.xacro > model.urdf"
        raise InputError(Problem("this is a xacro, from which a URDF is made", root.place, hint))
    if root.tag not in READERS:
        what = f"<{root.tag[:40]}> begins no model that mbproj reads"
        raise InputError(Problem(what, root.place, "a model is MJCF (<mujoco>), URDF (<robot>) or SDF (<sdf>)"))


def _refuse_options(root: XmlElement, import_options: ImportOptions) -> None:
    """Raises InputError for options that the format does not have."""
    asked: dict[str, dict[str, object]] = {
        "mujoco": {
            "keyframes": import_options.key,
            "actuators": import_options.controls,
            "contacts": import_options.contacts or None,
        },
        "robot": {"loops in another file": import_options.loops},
        "sdf": {"frames of joints that may meet": import_options.meet or None},
    }
    for tag, kinds in asked.items():
        for what, value in kinds.items():
            if value is not None and tag != root.tag:
                message = f"a model in {NAMES[root.tag]} has no {what}: these are asked of {NAMES[tag]}"
                raise InputError(Problem(message, Place(root.place.file), "leave the option out"))
