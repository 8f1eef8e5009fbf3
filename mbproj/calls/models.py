"""Scenes from elsewhere: `mbproj.import_model` of a model in another format, `new` of a template; `schema` of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mbproj.calls.given import Given, Quantity, by_arguments, scene_of
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.formats import Wishes, read_model
from mbproj.formats.couplers import without_refused
from mbproj.formats.export.mjcf import as_mjcf
from mbproj.formats.export.urdf import as_urdf
from mbproj.formats.mechanism import Mechanism, Said, Same
from mbproj.formats.signals import read_pose, signals_of
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.read import read_scene_text
from mbproj.scene.records import Scene
from mbproj.scene.schema import scene_schema
from mbproj.scene.text.nodes import flow, from_value
from mbproj.scene.text.suggestions import choose_from
from mbproj.templates import TEMPLATES, written
from mbproj.version import __version__

_NOTHING: Mapping[str, object] = {}
#: What writes a scene in a format.
FORMATS = {"mjcf": as_mjcf, "urdf": as_urdf}


@dataclass(frozen=True, eq=False)
class Imported(Tabled):
    """The scene's `text` made of a model, and of each element without a counterpart what happened with it."""

    text: str
    mechanism: Mechanism

    @property
    def scene(self) -> Scene:
        """The scene. Raises InputError where it cannot be read."""
        return read_scene_text(self.text, "scene")

    @property
    def same(self) -> bool:
        """Whether nothing is known to make the scene's motion another than the model's."""
        return all(row.same is not Same.NO for row in self.mechanism.said)

    @property
    def table(self) -> Table:
        """A row an element: what happened with it, and whether the motion is still the model's."""
        return _table(self.mechanism.said)

    @property
    def line(self) -> str:
        """How large it is."""
        parts, joints = len(self.mechanism.parts), len(self.mechanism.joints)
        return f"{self.mechanism.title}: {parts} bodies, {joints} joints"

    __repr__ = Tabled.__repr__


def import_model(
    model: str | Path,
    *,
    at: str | None = None,
    pose: Mapping[str, float] | str | Path | None = None,
    loops: str | Path | None = None,
    meet: bool = False,
    hold: bool = False,
    controls: Mapping[str, str | float] | str | Path | None = None,
    motions: Mapping[str, str | float] | str | Path | None = None,
    contacts: bool = False,
    folder: str | Path | None = None,
) -> Imported:
    """Makes a scene of a `model` in MJCF, URDF or SDF: `found.scene`, `found.text`, a table of what has no counterpart.

    It begins `at` a keyframe, or at the joint coordinates of a `pose` (rad, m; a mapping, or a file of them). `loops`
    is the file of a URDF where its loops stand; the frames that a joint of an SDF names `meet`. `hold`: actuators act
    with their signals at the start. `controls` are other signals, `motions` coordinates of joints: functions of t by
    name (a mapping, or a file). `contacts`: spheres and capsules above planes become stops. `folder` is where the scene
    will stand, from which its meshes are named, that of the model unless given. Raises InputError where the model is
    wrong.
    """
    with by_arguments():
        if isinstance(pose, (str, Path)):
            pose = read_pose(Path(pose))
        beside = None if loops is None else Path(loops)
        acting = signals_of(controls, "controls") if controls is not None else {} if hold else None
        driven = signals_of(motions, "motions") if motions is not None else {}
        home = None if folder is None else Path(folder)
        return imported(Path(model), Wishes(at, pose or {}, acting, driven, contacts, beside, meet, home))


def imported(model: Path, wishes: Wishes) -> Imported:
    """The same; problems of the scene itself stand in the table."""
    mechanism = read_model(model, wishes)
    text, refused = without_refused(mechanism, __version__)
    for problem in refused:
        at = problem.place.line if problem.place else None
        line = "it" if at is None else f"its line {at}"
        mechanism.say("the scene itself", None, f"check refuses {line}: {problem.message}", Same.NO)
    return Imported(text, mechanism)


@dataclass(frozen=True, eq=False)
class Exported(Tabled):
    """The `text` of a model made of a scene, its `loops` as a YAML file beside a URDF ("" without), what was `said`."""

    format: str
    text: str
    loops: str
    said: Sequence[Said]

    @property
    def table(self) -> Table:
        """A row for what the format lacks: what happened with it, and whether the motion is still the scene's."""
        return _table(self.said)

    @property
    def line(self) -> str:
        """What it is."""
        return f"{self.format.upper()} of {len(self.text.splitlines())} lines"

    __repr__ = Tabled.__repr__


def export_model(scene: Given, format: str = "mjcf", *, parameters: Mapping[str, object] = _NOTHING) -> Exported:
    """A scene as a model in MJCF or URDF, as `mbproj export SCENE --mjcf FILE` writes it.

    It begins at the assembled start. Raises InputError where the scene is wrong, or nothing starts.
    """
    with by_arguments():
        if format not in FORMATS:
            hint = choose_from(format, FORMATS)
            raise InputError(Problem(f"unknown format '{format}'", Place("format"), hint))
        found = FORMATS[format](scene_of(scene, parameters, {}), __version__)
        return Exported(format, found.text, found.loops, found.said)


def _table(said: Sequence[Said]) -> Table:
    rows = (
        {"element": each.element, "place": str(each.place or ""), "what": each.what, "same": each.same.value}
        for each in said
    )
    return Table.of(rows, "element", "place", "what", "same")


def new(kind: str, *, spatial: bool = False, **numbers: Quantity) -> Scene:
    """The scene of a template, "four-bar" for one, with the numbers of `mbproj new`, in SI units or with a unit.

    Raises InputError for a template or number that there is not, or lengths that make no mechanism.
    """
    with by_arguments():
        if kind not in TEMPLATES:
            raise InputError(Problem(f"there is no template '{kind}'", Place("kind"), choose_from(kind, TEMPLATES)))
        given = {name: flow(from_value(value, Place(name))) for name, value in numbers.items()}
        return read_scene_text(written(kind, given, spatial), kind)


def schema() -> dict[str, Any]:
    """The JSON Schema of scene files, of draft 2020-12."""
    return scene_schema()
