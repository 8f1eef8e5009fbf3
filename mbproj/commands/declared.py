"""A study that is declared once: a Python function, whose annotated parameters are the options of its command.

    Until = Annotated["Quantity | None", Option(Part.WHAT, "End of the study.", Positive("s"), metavar="TIME")]

    @declared
    def recommend(scene: Given, error: Error, *, until: Until = None, jobs: Jobs = None) -> Recommendation:
        asked = read(recommend, locals())       # numbers in SI units, names, the scene; raises InputError
        return search(asked.scene, asked.error, asked.until, asked.where)

    command = study_command(recommend, EXAMPLES, report=_report)

The command line and Python read a number, a name or a file by the same rule, with the same message. Only its place
differs: `--until` there, `until` here.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, TypeVar, get_args, get_origin

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.settings import settings_taken
from mbproj.commands.options import Option, explained, overrides, parameters, scene_file, scene_options_of
from mbproj.commands.study_options import changes as changes_option

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.commands.study import Study
    from mbproj.results.views import Table
    from mbproj.scene.scene import Scene

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
#: The names of arguments by those of earlier versions.
EARLIER = {"repetitions": "repeat", "processes": "jobs", "tell": "progress", "from_equilibrium": "start"}


def options_of(function: Callable[..., Any]) -> dict[str, tuple[inspect.Parameter, Option]]:
    """The parameters of a function that are options, by name, in their order."""
    inner = inspect.unwrap(function)
    found = {}
    for parameter in inspect.Signature.from_callable(inner).parameters.values():
        alias = inner.__globals__.get(str(parameter.annotation))
        for part in get_args(alias)[1:]:
            if isinstance(part, Option):
                found[parameter.name] = (parameter, part)
    return found


def declared(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorate the function of a command: problems name its arguments, not options, and its signature lists what each
    accepts. A name that an argument had in an earlier version raises a TypeError with the current one."""

    @wraps(function)
    def called(*values: Arguments.args, **named: Arguments.kwargs) -> Result:
        from mbproj.commands.python.arguments import by_arguments

        for old in EARLIER.keys() & named.keys():
            raise TypeError(f"{function.__name__}() has no argument '{old}': its name is '{EARLIER[old]}'")
        with by_arguments():
            return function(*values, **named)

    called.__signature__ = _signature(function)  # type: ignore[attr-defined]
    return called


def _signature(function: Callable[..., Any]) -> inspect.Signature:
    """The signature with what each argument accepts, and each setting of a run that the function takes."""
    signature = inspect.Signature.from_callable(function)
    listed = []
    for parameter in signature.parameters.values():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            from mbproj.commands.python.arguments import RunSettings

            listed += [
                inspect.Parameter(
                    name,
                    inspect.Parameter.KEYWORD_ONLY,
                    default=None,
                    annotation=RunSettings.__annotations__[name].__forward_arg__,
                )
                for name in settings_taken(function.__name__)
            ]
            continue
        alias = getattr(function, "__globals__", {}).get(str(parameter.annotation))
        is_option = get_origin(alias) is Annotated
        listed.append(parameter.replace(annotation=_words(get_args(alias)[0])) if is_option else parameter)
    return signature.replace(parameters=listed)


def _words(accepted: Any) -> str:
    return str(getattr(accepted, "__forward_arg__", getattr(accepted, "__name__", accepted)))


def read(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """The arguments of a declared function, read: an object with an attribute each. `scene` is the scene, with its
    `parameters` and settings changed; `where` is the place that `jobs` and a scheduler name.

    Raises InputError where a value is wrong, TypeError for a setting that the function does not take."""
    from mbproj.commands.python.arguments import options_of as settings_given
    from mbproj.commands.python.arguments import scene_of
    from mbproj.studies.parallel.cluster import workplace

    inner = inspect.unwrap(function)
    asked = {argument: arguments[argument] for argument in inspect.signature(inner).parameters}
    for argument, (_, entry) in options_of(function).items():
        asked[argument] = entry.read(asked[argument], argument)
    changed = settings_given(asked.pop("settings", {}), inner.__name__, *asked)
    if "output_step" in asked:
        changed["output_step"] = asked["output_step"]
    asked["scene"] = scene_of(asked["scene"], asked.pop("parameters", {}), changed)
    if "jobs" in asked:
        asked["where"] = workplace(*(asked.pop(part) for part in ("jobs", "scheduler", "scheduler_file")))
    return SimpleNamespace(**asked)


def given(asked: Any, *names: str) -> dict[str, Any]:
    """Those of these arguments that have a value: the others are left to the defaults of the study."""
    return {name: value for name in names if (value := getattr(asked, name)) is not None}


@dataclass(frozen=True, eq=False)
class Call:
    """A call of a study from the command line: the `path` of its scene as it was typed, the `scene`, all `options`, the
    `changes` of --set among them. `study` has the files and writes the report."""

    path: str
    scene: Scene
    options: Mapping[str, Any]
    study: Study


@dataclass(frozen=True, eq=False)
class Told:
    """What a command tells of a study: a table, a text, numbers for --json, a figure or the reason why there is none.
    `left` is the part of the text that --quiet leaves; `beside` are files that are already written; `code` is the exit
    code."""

    table: Table
    text: str
    numbers: Mapping[str, Any]
    draw: Callable[[], Figure | str] | None = None
    notes: Sequence[str] = ()
    beside: Sequence[Path] = ()
    left: str = ""
    code: int = 0


def study_command(
    function: Callable[..., Any],
    examples: Sequence[tuple[str, str]],
    told: Callable[[Call, Any], Told],
    *,
    first: tuple[str, ...],
    stem: str = "",
    files: Sequence[Callable[[Any], Any]] = (),
    refuse: Callable[[Mapping[str, Any]], None] | None = None,
    before: Callable[[Call], None] | None = None,
    after: Callable[[Call, Any], None] | None = None,
) -> click.Command:
    """The command of a declared study: SCENE, its options, and those that `files` decorates it with.

    `first` are the first headings of its table. With a `stem`, the table and the figure go into a folder under this
    name. Both may name an argument: "{vary}". `refuse` looks at the options before the scene is read, `before` at the call
    before the work; `after` acts on the result at the end."""
    name, inner = function.__name__, inspect.unwrap(function)
    kinds = {parameter.kind for parameter in inspect.signature(inner).parameters.values()}
    has_settings = inspect.Parameter.VAR_KEYWORD in kinds

    def command(**options: Any) -> int:
        from mbproj.commands.study import Study
        from mbproj.scene.scene import read_scene

        path, changes = options.pop("scene"), options.pop("changes", None) or options.pop("settings", ())
        settings, typed = overrides(options), {**options, "changes": changes}
        if refuse is not None:
            refuse(typed)
        if "output_step" in own:
            settings["output_step"] = options["output_step"]
        scene = read_scene(path, parameters(changes), settings)
        asked = {argument: options[argument] for argument in own if options.get(argument) is not None}
        for argument in own.keys() - {"jobs", "scheduler", "scheduler_file", "fresh", "repeat"}:
            options.pop(argument)
        headings = tuple(heading.format(**asked) for heading in first)
        study = Study(options, headings, stem and f"{Path(path).stem}-{stem.format(**asked)}")
        call = Call(path, scene, typed, study)
        if before is not None:
            before(call)
        asked = {**asked, "jobs": study.where} if "jobs" in own else asked
        for part in ("scheduler", "scheduler_file", "output_step"):
            asked.pop(part, None)
        with study.telling() as tell:
            result = inner(scene, **asked, progress=tell)
        said = told(call, result)
        study.hand_over(said.table, said.text, said.numbers, said.draw, said.notes, said.beside, said.left)
        if after is not None:
            after(call, result)
        return said.code

    command.__doc__ = _help_of(inner)
    own = options_of(function)
    made: Any = command
    for decorate in reversed(files):
        made = decorate(made)
    if not has_settings:
        made = changes_option(made)
    for parameter, entry in reversed([*own.values()]):
        made = entry.on_command_line(parameter)(made)
    made = scene_options_of(name)(made) if has_settings else click.argument("scene", type=scene_file())(made)
    return explained(name, examples)(made)


def _help_of(function: Callable[..., Any]) -> str:
    """The docstring of a function up to the part that is for callers from Python, which begins with "In Python"."""
    return (inspect.getdoc(function) or "").partition("\n\nIn Python")[0]
