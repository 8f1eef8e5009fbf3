"""A study that is declared once: a Python function, whose annotated parameters are the options of its command.

    Until = Annotated["Quantity | None", Option(Part.WHAT, "End of the study.", Positive("s"), metavar="TIME")]

    @declared
    def recommend(scene: SceneLike, error: Error, *, until: Until = None, jobs: Jobs = None) -> Recommendation:
        asked = read(recommend, locals())       # numbers in SI units, names, the scene; raises InputError
        return search(asked.scene, asked.error, asked.until, asked.where)

    command = study_command(recommend, EXAMPLES, report=_report)

The command line and Python read a number, a name or a file by the same rule, with the same message. Only its place
differs: `--until` there, `until` here.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, TypeVar, get_args, get_origin

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from
from mbproj.base.settings import SETTINGS, settings_taken
from mbproj.commands.options import (
    AnyNumber,
    Option,
    PositiveList,
    PositivePairs,
    QuantityNames,
    explained,
    overrides,
    parameters,
    scene_file,
    scene_options_of,
)
from mbproj.commands.study_options import changes as changes_option
from mbproj.studies.parallel.progress import silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.commands.study import Study
    from mbproj.results.views import Table
    from mbproj.scene.scene import Scene

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

#: The names of arguments by those of earlier versions.
EARLIER = {"repetitions": "repeat", "processes": "jobs", "tell": "progress", "from_equilibrium": "start"}
#: The defaults of arguments that ** unpacks, where these are not None.
USUAL: Mapping[str, Any] = {"fresh": False, "parameters": MappingProxyType({}), "progress": silent}


def options_of(function: Callable[..., Any]) -> dict[str, tuple[inspect.Parameter, Option]]:
    """The parameters of a function that are options, by name, in their order; those of its ** come last."""
    inner = inspect.unwrap(function)
    listed = {}
    for parameter, where in _parameters(inner):
        for part in get_args(where.get(str(parameter.annotation)))[1:]:
            if isinstance(part, Option):
                listed[parameter.name] = (parameter, part)
    return listed


def _parameters(function: Callable[..., Any]) -> Iterator[tuple[inspect.Parameter, Mapping[str, Any]]]:
    """Yield the parameters, with those that ** unpacks in its place, each with the names of the module it is from."""
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is not inspect.Parameter.VAR_KEYWORD:
            yield parameter, function.__globals__
            continue
        unpacked = function.__globals__[str(parameter.annotation).removeprefix("Unpack[").removesuffix("]")]
        for name, reference in unpacked.__annotations__.items():
            if name not in SETTINGS or name in settings_taken(function.__name__):
                usual, kind = USUAL.get(name), inspect.Parameter.KEYWORD_ONLY
                unfolded = inspect.Parameter(name, kind, default=usual, annotation=reference.__forward_arg__)
                yield unfolded, vars(sys.modules[unpacked.__module__])


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
    """The signature with what each argument accepts, and with all that ** unpacks."""
    listed = []
    for parameter, where in _parameters(function):
        alias = where.get(str(parameter.annotation))
        is_option = get_origin(alias) is Annotated
        listed.append(parameter.replace(annotation=_words(get_args(alias)[0])) if is_option else parameter)
    return inspect.signature(function).replace(parameters=listed)


def _words(accepted: Any) -> str:
    return str(getattr(accepted, "__forward_arg__", getattr(accepted, "__name__", accepted)))


def read(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """The arguments of a declared function, read: an object with an attribute each. `scene` is the scene, with its
    `parameters` and settings changed. A function that takes `jobs` has `effort`: the place of the work, `fresh` and
    `progress`, as the functions of studies take them.

    Raises InputError where a value is wrong, TypeError for a setting that the function does not take."""
    from mbproj.commands.python.arguments import scene_of

    inner = inspect.unwrap(function)
    asked = {name: value for name, value in arguments.items() if name in inspect.signature(inner).parameters}
    for parameter in inspect.signature(inner).parameters.values():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            asked |= asked.pop(parameter.name)
    usual = {parameter.name: parameter.default for parameter, _ in _parameters(inner)}
    for name in asked.keys() - usual.keys():
        raise TypeError(f"{inner.__name__}() has no argument '{name}'; {choose_from(name, [*usual])}")
    asked = {**usual, **asked}
    for name, (_, entry) in options_of(inner).items():
        asked[name] = _value(entry.kind, asked[name], name)
    named = inspect.signature(inner).parameters
    changed = {name: asked.pop(name) for name in SETTINGS if name in asked and name not in named}
    changed |= {"output_step": asked["output_step"]} if "output_step" in named else {}
    changed = {name: value for name, value in changed.items() if value is not None}
    asked["scene"] = scene_of(asked["scene"], asked["parameters"], changed)
    if "jobs" in asked:
        from mbproj.studies.parallel.cluster import workplace

        where = workplace(*(asked.pop(part) for part in ("jobs", "scheduler", "scheduler_file")))
        asked["effort"] = {"processes": where, "fresh": asked.pop("fresh"), "tell": asked.pop("progress")}
    return SimpleNamespace(**asked)


def _value(kind: Any, value: Any, name: str) -> Any:
    """The value of the argument `name`: numbers in SI units, names as a tuple; None stays None. Raises InputError
    with the option as its place."""
    from mbproj.commands.python.arguments import amounts, count_of, names_of
    from mbproj.scene.fields.quantities import Number, given_number

    if value is None:
        return None
    if isinstance(kind, PositiveList):
        return amounts(value, name, kind.unit)
    if isinstance(kind, PositivePairs):
        return kind.of(value.split(";") if isinstance(value, str) else value, f"--{name}")
    if isinstance(kind, AnyNumber):
        return given_number(value, f"--{name}", Number(kind.unit, **kind.bounds))
    if isinstance(kind, QuantityNames):
        return kind.of(names_of(value), f"--{name.replace('_', '-')}")
    if isinstance(kind, click.IntRange):
        return count_of(value, name, least=int(kind.min or 0))
    return value


def with_values(asked: Any, *names: str) -> dict[str, Any]:
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
    name. Both may name an argument: "{vary}". `refuse` looks at the options before the scene is read, `before` at the
    call before the work; `after` acts on the result at the end."""
    name, inner = function.__name__, inspect.unwrap(function)
    has_settings = any(parameter.name == "integrator" for parameter, _ in _parameters(inner))

    def command(**options: Any) -> int:
        from mbproj.commands.study import Study
        from mbproj.scene.scene import read_scene

        path, changes = options.pop("scene"), options.pop("changes", None) or options.pop("settings", ())
        typed = {**options, "changes": changes}
        settings = overrides({name: value for name, value in options.items() if name not in study_options})
        if refuse is not None:
            refuse(typed)
        if "output_step" in study_options:
            settings["output_step"] = options["output_step"]
        scene = read_scene(path, parameters(changes), settings)
        asked = {argument: options[argument] for argument in study_options if options.get(argument) is not None}
        for argument in study_options.keys() - {"jobs", "scheduler", "scheduler_file", "fresh", "repeat"}:
            options.pop(argument)
        headings = tuple(heading.format(**asked) for heading in first)
        study = Study(options, headings, stem and f"{Path(path).stem}-{stem.format(**asked)}")
        call = Call(path, scene, typed, study)
        if before is not None:
            before(call)
        asked = {**asked, "jobs": study.where} if "jobs" in study_options else asked
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
    study_options = options_of(function)
    decorated: Any = command
    for decorate in reversed(files):
        decorated = decorate(decorated)
    if not has_settings:
        decorated = changes_option(decorated)
    for parameter, entry in reversed([*study_options.values()]):
        decorated = entry.on_command_line(parameter)(decorated)
    scene_argument = scene_options_of(name) if has_settings else click.argument("scene", type=scene_file())
    return explained(name, examples)(scene_argument(decorated))


def _help_of(function: Callable[..., Any]) -> str:
    """The docstring of a function up to the part that is for callers from Python, which begins with "In Python"."""
    return (inspect.getdoc(function) or "").partition("\n\nIn Python")[0]
