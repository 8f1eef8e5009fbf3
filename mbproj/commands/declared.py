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
from functools import cached_property, wraps
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, Generic, ParamSpec, TypeVar, get_args, get_origin

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from
from mbproj.base.settings import SETTINGS, settings_taken
from mbproj.commands.options import (
    EARLIER,
    NOTHING,
    Entry,
    Option,
    changes,
    explained,
    overrides,
    parameters,
    scene_file,
    scene_options_of,
)
from mbproj.studies.parallel.progress import silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.commands.study_report import StudyReport
    from mbproj.results.views import Table
    from mbproj.scene.scene import Scene

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

#: The defaults of arguments that ** unpacks, where these are not None.
USUAL: Mapping[str, Any] = {"fresh": False, "parameters": NOTHING, "progress": silent}


def entries_of(function: Callable[..., Any]) -> dict[str, tuple[inspect.Parameter, Entry]]:
    """The parameters of a function that are options or arguments, by name, in their order; those of its ** come
    last."""
    listed = {}
    for parameter, where in _parameters(inspect.unwrap(function)):
        for part in get_args(where.get(str(parameter.annotation)))[1:]:
            if isinstance(part, Entry):
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
        from mbproj.commands.arguments import by_arguments

        for old in EARLIER.keys() & named.keys():
            now = EARLIER[old].split()[0]
            raise TypeError(f"{function.__name__}() has no argument '{old}': its name is '{now}'")
        with by_arguments(_arguments(function)):
            return function(*values, **named)

    called.__signature__ = _signature(function)  # type: ignore[attr-defined]
    return called


def _signature(function: Callable[..., Any]) -> inspect.Signature:
    """The signature with what each argument accepts, and with all that ** unpacks."""
    listed = []
    for parameter, where in _parameters(function):
        alias = where.get(str(parameter.annotation))
        if isinstance(parameter.default, MappingProxyType):
            parameter = parameter.replace(default=dict(parameter.default))  # as it is read best
        is_option = get_origin(alias) is Annotated
        listed.append(parameter.replace(annotation=_words(get_args(alias)[0])) if is_option else parameter)
    return inspect.signature(function).replace(parameters=listed)


def _words(accepted: Any) -> str:
    return str(getattr(accepted, "__forward_arg__", getattr(accepted, "__name__", accepted)))


def _arguments(function: Callable[..., Any]) -> dict[str, str]:
    """The names of parameters by those of their options, where these differ."""
    options = {name: entry for name, (_, entry) in entries_of(function).items() if isinstance(entry, Option)}
    return {text: name for name, entry in options.items() for text in entry.names if text.startswith("--")}


def read(function: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """The arguments of a declared function, read: an object with an attribute each. `scene` is the scene, with its
    `parameters` and settings changed. A function that takes `jobs` has `where`, the place of the work; one that is
    `fresh` too has `effort`: both and `progress`, as the functions of studies take them.

    Raises InputError where a value is wrong, TypeError for a setting that the function does not take."""
    inner = inspect.unwrap(function)
    usual = {parameter.name: parameter.default for parameter, _ in _parameters(inner)}
    asked = {name: value for name, value in arguments.items() if name in usual}
    for parameter in inspect.signature(inner).parameters.values():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            asked |= arguments.get(parameter.name, {})
    for name in asked.keys() - usual.keys():
        raise TypeError(f"{inner.__name__}() has no argument '{name}'; {choose_from(name, [*usual])}")
    asked = {**usual, **asked}
    entries = entries_of(inner)
    for name, (parameter, entry) in entries.items():
        if asked[name] is None and parameter.default in (None, ()):
            asked[name] = parameter.default
            continue
        asked[name] = entry.read(asked[name], entry.names_of(name)[-1] if isinstance(entry, Option) else name)
    if "scene" in asked and "scene" not in entries:
        asked["scene"] = _scene(inner, asked)
    if "jobs" in asked:
        from mbproj.studies.parallel.cluster import workplace

        asked["where"] = workplace(*(asked.pop(part) for part in ("jobs", "scheduler", "scheduler_file")))
        if "fresh" in asked:
            asked["effort"] = {"processes": asked["where"], "fresh": asked["fresh"], "tell": asked["progress"]}
    return SimpleNamespace(**asked)


def _scene(function: Callable[..., Any], asked: dict[str, Any]) -> Scene:
    """The scene, with its parameters and settings changed; these settings are removed."""
    from mbproj.commands.arguments import scene_of

    named = inspect.signature(function).parameters
    changed = {name: asked.pop(name) for name in SETTINGS if name in asked and name not in named}
    changed |= {"output_step": asked["output_step"]} if "output_step" in named else {}
    changed = {name: value for name, value in changed.items() if value is not None}
    return scene_of(asked["scene"], asked["parameters"], changed)


def with_values(asked: Any, *names: str) -> dict[str, Any]:
    """Those of these arguments that have a value: the others are left to the defaults of the study."""
    return {name: value for name in names if (value := getattr(asked, name)) is not None}


class Asked(Generic[Result]):
    """What a command line asks of a declared function: `given`, its arguments by name, and the `changes` of --set.
    `path` is the path of a scene as it was typed. `typed` are all options, `settings` those of a run. `report` has the
    files of a study and writes what it tells."""

    report: StudyReport

    def __init__(self, function: Callable[..., Result], typed: dict[str, Any]) -> None:
        entries = entries_of(function)
        self._function: Callable[..., Result] = inspect.unwrap(function)
        self.typed, self.path = typed, str(typed.get("scene", ""))
        self.changes: tuple[str, ...] = typed.get("changes", ())
        self.settings = overrides({name: value for name, value in typed.items() if name not in entries})
        if "output_step" in entries:
            self.settings["output_step"] = typed["output_step"]
        self.given = {name: typed[name] for name in entries if typed.get(name) is not None}
        self._reads_scene = "scene" in typed and "scene" not in entries
        takes_parameters = any(parameter.name == "parameters" for parameter, _ in _parameters(self._function))
        if self.changes and takes_parameters and not self._reads_scene:
            self.given["parameters"] = parameters(self.changes)

    @cached_property
    def scene(self) -> Scene:
        """The scene, with what --set and the options of settings change. Raises InputError where it is wrong."""
        return self.scene_with({})

    def scene_with(self, more: Mapping[str, str]) -> Scene:
        """The scene with `more` changes, as --set makes them."""
        from mbproj.scene.scene import read_scene

        return read_scene(self.path, {**parameters(self.changes), **more}, self.settings)

    def result(self, **more: Any) -> Result:
        """What the function returns for the command line, with `more` arguments. Problems name options."""
        return self._function(**{**self._arguments(), **more})

    def read(self) -> Any:
        """The arguments as the function reads them."""
        return read(self._function, self._arguments())

    def _arguments(self) -> dict[str, Any]:
        if not self._reads_scene:
            return self.given
        return {"scene": self.scene, **{name: value for name, value in self.given.items() if name != "output_step"}}


def command_of(
    function: Callable[..., Result], examples: Sequence[tuple[str, str]], *files: Callable[[Any], Any], name: str = ""
) -> Callable[[Callable[..., int | None]], click.Command]:
    """Return a decorator that makes the command of a declared function: the arguments and options of its parameters,
    --set and the settings where it takes them, and the options that `files` decorates it with. The decorated function
    is given what is `Asked`, and the values of the latter options by name; its own docstring is the help, if it has
    one."""
    entries, own = entries_of(function), {parameter.name for parameter, _ in _parameters(inspect.unwrap(function))}
    has_settings, reads_scene = "integrator" in own, "scene" in own and "scene" not in entries
    asked_for = {*entries, "scene", "changes", *(SETTINGS if has_settings else ())}

    def decorate(body: Callable[..., int | None]) -> click.Command:
        def command(**typed: Any) -> int | None:
            others = {name: value for name, value in typed.items() if name not in asked_for}
            return body(Asked(function, typed), **others)

        command.__doc__ = inspect.getdoc(body) or _help_of(inspect.unwrap(function))
        decorated: Any = command
        for add in reversed(files):
            decorated = add(decorated)
        if "parameters" in own and not has_settings:
            decorated = changes(decorated)
        for parameter, entry in reversed([*entries.values()]):
            decorated = entry.on_command_line(parameter)(decorated)
        if has_settings:
            decorated = scene_options_of(function.__name__)(decorated)
        elif reads_scene:
            decorated = click.argument("scene", type=scene_file())(decorated)
        return explained(name or function.__name__.replace("_", "-"), examples)(decorated)

    return decorate


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
    told: Callable[[Asked[Any], Any], Told],
    *,
    first: tuple[str, ...],
    stem: str = "",
    files: Sequence[Callable[[Any], Any]] = (),
    refuse: Callable[[Mapping[str, Any]], None] | None = None,
    before: Callable[[Asked[Any]], None] | None = None,
    after: Callable[[Asked[Any], Any], None] | None = None,
) -> click.Command:
    """The command of a declared study: SCENE, its options, and those that `files` decorates it with.

    `first` are the first headings of its table. With a `stem`, the table and the figure go into a folder under this
    name. Both may name an argument: "{vary}". `refuse` looks at the options before the scene is read. `before` acts
    before the work, `after` on the result at the end."""
    tells = any(parameter.name == "progress" for parameter, _ in _parameters(inspect.unwrap(function)))

    def run(asked: Asked[Any], **options: Any) -> int:
        from mbproj.commands.study_report import StudyReport

        if refuse is not None:
            refuse(asked.typed)
        headings = tuple(heading.format(**asked.given) for heading in first)
        study = asked.report = StudyReport(
            options, headings, stem and f"{Path(asked.path).stem}-{stem.format(**asked.given)}"
        )
        if before is not None:
            before(asked)
        with study.telling() as tell:
            result = asked.result(**({"progress": tell} if tells else {}))
        said = told(asked, result)
        study.hand_over(said.table, said.text, said.numbers, said.draw, said.notes, said.beside, said.left)
        if after is not None:
            after(asked, result)
        return said.code

    return command_of(function, examples, *files)(run)


def _help_of(function: Callable[..., Any]) -> str:
    """The docstring of a function up to the part that is for callers from Python, which begins with "In Python"."""
    return (inspect.getdoc(function) or "").partition("\n\nIn Python")[0]
