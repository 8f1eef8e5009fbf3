"""Models in other formats: `mbproj.import_model` reads one, `export_model` writes one. `new` makes a scene from a
template; `schema` describes scenes and reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.text import text_of
from mbproj.base.version import __version__
from mbproj.commands.python.arguments import Quantity, SceneLike, by_arguments, scene_of
from mbproj.formats.as_scene import without_refused
from mbproj.formats.export.mjcf import as_mjcf
from mbproj.formats.export.urdf import as_urdf
from mbproj.formats.mechanism import Agreement, ImportedMechanism, ImportOptions, Said, Same
from mbproj.formats.read import read_model
from mbproj.formats.signals import read_pose, signals_of
from mbproj.results.report_schema.reports import REPORTS, report_schema
from mbproj.results.views import Table, Tabled
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.schema import scene_schema
from mbproj.scene.templates.table import TEMPLATES, scene_text
from mbproj.scene.text.nodes import flow, from_value

_NOTHING: Mapping[str, object] = {}
#: The writers of other formats.
FORMATS = {"mjcf": as_mjcf, "urdf": as_urdf}


@dataclass(frozen=True, eq=False)
class Imported(Tabled):
    """The `text` of a scene made from a model, with notes on each element of the model that has no counterpart.

    `agreement` has the differences of its start and its accelerations from MuJoCo's; None for other formats."""

    text: str
    mechanism: ImportedMechanism
    agreement: Agreement | None = None

    @property
    def scene(self) -> Scene:
        """The scene. Raises InputError where it cannot be read."""
        return read_scene_text(self.text, "scene")

    @property
    def same(self) -> bool:
        """Whether no known difference makes the scene's motion another than the model's."""
        return all(row.same is not Same.NO for row in self.mechanism.said)

    @property
    def table(self) -> Table:
        """A table with a row for each element: what became of it, and whether the motion is still the model's."""
        return _table(self.mechanism.said)

    @property
    def line(self) -> str:
        """A line with the size of the scene."""
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
    """Makes a scene of a `model` in MJCF, URDF or SDF: `found.scene`, `found.text`, and a table of elements without
    counterpart.

    It starts `at` a keyframe, or at the joint coordinates of a `pose` (rad, m; a mapping, or a file of them). `loops`
    is the file with the loops of a URDF. With `meet`, the two frames of each SDF joint coincide. With `hold`, actuators
    act with their signals at the start. `controls` are other signals, `motions` are coordinates of joints: functions of
    t by name (a mapping, or a file).

    With `contacts`, spheres and capsules above planes become stops. `folder` is where the scene will be stored, as its
    meshes are named relative to it; by default that of the model. Raises InputError where the model is wrong.
    """
    with by_arguments():
        if isinstance(pose, (str, Path)):
            pose = read_pose(Path(pose))
        beside = None if loops is None else Path(loops)
        acting = signals_of(controls, "controls") if controls is not None else {} if hold else None
        driven = signals_of(motions, "motions") if motions is not None else {}
        home = None if folder is None else Path(folder)
        return imported(Path(model), ImportOptions(at, pose or {}, acting, driven, contacts, beside, meet, home))


def imported(model: Path, options: ImportOptions) -> Imported:
    """Import a model as `import_model` does. Problems of the scene itself are rows of the table."""
    mechanism = read_model(model, options)
    text, refused = without_refused(mechanism, __version__)
    for problem in refused:
        at = problem.place.line if problem.place else None
        line = "it" if at is None else f"its line {at}"
        mechanism.say("the scene itself", None, f"check refuses {line}: {problem.message}", Same.NO)
    agreement = None if refused or mechanism.compare is None else mechanism.compare(mechanism, __version__)
    return Imported(text, mechanism, agreement)


@dataclass(frozen=True, eq=False)
class Exported(Tabled):
    """The `text` of a model made from a scene. `loops` is a YAML file beside a URDF, or ""; `said` are notes."""

    format: str
    text: str
    loops: str
    said: Sequence[Said]

    @property
    def table(self) -> Table:
        """A table with a row for each thing that the format lacks: what became of it, and whether the motion is still
        the scene's."""
        return _table(self.said)

    @property
    def line(self) -> str:
        """A line that describes the model."""
        return f"{self.format.upper()} of {len(self.text.splitlines())} lines"

    __repr__ = Tabled.__repr__


def export_model(scene: SceneLike, format: str = "mjcf", *, parameters: Mapping[str, object] = _NOTHING) -> Exported:
    """Writes a scene as a model in MJCF or URDF, as `mbproj export SCENE --mjcf FILE` does.

    The model starts at the assembled start. Raises InputError where the scene is wrong or cannot be assembled.
    """
    with by_arguments():
        if text_of(format, "the format") not in FORMATS:
            hint = choose_from(format, FORMATS)
            raise InputError(Problem(f"unknown format '{format}'", Place("format"), hint))
        exported = FORMATS[format](scene_of(scene, parameters, {}), __version__)
        return Exported(format, exported.text, exported.loops, exported.said)


def _table(said: Sequence[Said]) -> Table:
    rows = (
        {"element": each.element, "place": str(each.place or ""), "what": each.what, "same": each.same.value}
        for each in said
    )
    return Table.of(rows, "element", "place", "what", "same")


def new(kind: str, *, spatial: bool = False, **numbers: Quantity) -> Scene:
    """Makes the scene of a template, for example "four-bar", with the numbers of `mbproj new`, in SI units or with a
    unit.

    Raises InputError for an unknown template or number, and for lengths that make no mechanism.
    """
    with by_arguments():
        if text_of(kind, "the name of a template") not in TEMPLATES:
            raise InputError(Problem(f"there is no template '{kind}'", Place("kind"), choose_from(kind, TEMPLATES)))
        texts = {name: flow(from_value(value, Place(name))) for name, value in numbers.items()}
        return read_scene_text(scene_text(kind, texts, spatial), kind)


def schema(of: str = "scene") -> dict[str, Any]:
    """The JSON Schema, of draft 2020-12, of scene files, or of what `--json` prints: "run", "compare" and more.

    Raises InputError for another word.
    """
    if text_of(of, "the word for a schema") == "scene":
        return scene_schema()
    if of not in REPORTS:
        raise InputError(Problem(f"there is no schema of '{of}'", Place("of"), choose_from(of, ["scene", *REPORTS])))
    return report_schema(of)
