"""Tables of the program: commands and options, exit codes, results files, pictures, checks, the Python API."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterator, Sequence

import click

import mbproj
from mbproj.base.errors import ExitCode
from mbproj.base.thresholds import threshold_table
from mbproj.commands.info import USERS
from mbproj.commands.main import COMMANDS
from mbproj.commands.main import mbproj as group
from mbproj.commands.options import SCENE_OPTIONS, Command, Part
from mbproj.results.layout import ALL_NAMES, CONSTANTS, DATASETS, LATER
from mbproj.results.linear_files import MODEL_LAYOUT as MODEL
from mbproj.results.linear_files import MODES_LAYOUT as MODES
from mbproj.results.linear_files import FileLayout
from mbproj.results.report_schema.facts import ANY_NAME, Fact
from mbproj.results.report_schema.files import ROOT
from mbproj.results.report_schema.reports import REPORTS
from mbproj.show.figures.kinds import KINDS, SWEEP_PICTURES
from mbproj.studies.stability import QUANTITIES
from mbproj.studies.verify.checks import CHECKS

from .markdown import code, table

#: What each exit code means to a caller.
MEANINGS = {
    ExitCode.DONE: "done",
    ExitCode.INTERNAL: "a fault of mbproj: please report it",
    ExitCode.BAD_INPUT: "wrong input: the message names the place and a next step",
    ExitCode.FAILED: "a simulation failed: the message names the time, the cause and what to try",
    ExitCode.CHECK_FAILED: "a check that was asked for does not hold",
    ExitCode.INTERRUPTED: "interrupted by Ctrl-C or SIGTERM; what was done is kept",
}

FACT_HEADINGS = ("key", "kind", "unit", "what it is", "when")


def thresholds() -> str:
    """Every threshold, group by group."""
    rows = [
        (code(row.name), f"{row.value:g}", row.unit, USERS[row.used_by], row.why, row.source)
        for row in threshold_table()
    ]
    return table(("name", "value", "unit", "used by", "what it decides", "source"), rows)


def reports() -> str:
    """What each command prints with --json."""
    return "\n".join(map(_report, REPORTS))


def _report(name: str) -> str:
    report = REPORTS[name]
    printed = ", ".join(code(f"mbproj {command}") for command in report.commands)
    inside = {"object": "", "array of object": "[].", "map of object": f"{ANY_NAME}."}[report.kind]
    rows = _facts(report.facts, inside, {})
    return f"## {name}\n\n{report.words} Printed by {printed}.\n\n{table(FACT_HEADINGS, rows)}"


def attributes() -> str:
    """What a results file has as attributes from its start."""
    return table(FACT_HEADINGS, _facts(ROOT, "", {}))


def _facts(facts: Sequence[Fact], inside: str, known: dict[tuple[Fact, ...], str]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each fact and each of its fields. Fields that are `known` by another key are not told again."""
    for fact in facts:
        path = inside + fact.key
        words, same = fact.words, known.get(fact.fields)
        if same:
            words = f"{words}; with the keys of {code(same)}"
        yield code(path), fact.kind, fact.unit, words, fact.when
        if fact.fields and not same:
            known[fact.fields] = path
            *steps, _ = next(each for each in fact.kind.split(" | ") if each.endswith("object")).split(" of ")
            end = "".join({"array": "[]", "map": f".{ANY_NAME}"}[step] for step in steps)
            yield from _facts(fact.fields, f"{path}{end}.", known)


def modes_file() -> str:
    """What a file of modes holds."""
    return _parts(MODES)


def model_file() -> str:
    """What a file of a linear model holds."""
    return _parts(MODEL)


def _parts(layout: FileLayout) -> str:
    rows = [
        (code(part.path), " × ".join(map(str, part.shape)), part.unit, part.kind, part.description)
        for part in layout.parts
    ]
    return table(("dataset", "shape", "unit", "kind", "what it is"), rows)


def commands() -> str:
    """Every command with its purpose, its options by what they decide, and its examples."""
    parts = []
    for name in COMMANDS:
        command, context = _command(name)
        usage = " ".join(command.collect_usage_pieces(context))
        summary = inspect.cleandoc(command.help or "").partition("\n\n")[0].replace("\n", " ")
        names = {each for option in command.params for each in option.opts}
        missing = [each for each in SCENE_OPTIONS if each not in names]
        setting, but = len(missing) < 4, f", but not {' '.join(map(code, missing))}" if missing else ""
        link = f"\n\nIt takes the [options of a setting](#options-of-a-setting) too{but}." if setting else ""
        listed = _options(name, without=SCENE_OPTIONS if setting else ())
        lines = "".join(f"# {said}\n{line}\n" for said, line in command.examples)
        parts.append(f"## {name}\n\n`mbproj {name} {usage}`\n\n{summary}{link}\n\n{listed}\n```text\n{lines}```")
    return "\n\n".join(parts) + "\n"


def setting_options() -> str:
    """The options that the commands on a scene and its setting have in common."""
    names = {each for option in _command("run")[0].params for each in option.opts}
    return _options("run", without=names.difference(SCENE_OPTIONS))


def _command(name: str) -> tuple[Command, click.Context]:
    """A command and the context of its help."""
    context = click.Context(group, info_name="mbproj")
    command = group.get_command(context, name)
    assert isinstance(command, Command)
    return command, click.Context(command, info_name=name, parent=context)


def _options(name: str, without: Collection[str]) -> str:
    """A table of a command's options; what a row decides is said in the first row that does."""
    command, context = _command(name)
    rows = []
    for part, options in command.options_by_part(context).items():
        heading = part.value
        for option in options:
            record = option.get_help_record(context)
            if record is not None and part is not Part.HELP and not set(option.opts) & set(without):
                rows.append([heading, code(record[0].replace("|", " | ")), record[1]])  # long words do not wrap
                heading = ""
    return table(["decides", "option", "what it does"], rows) if rows else ""


def exit_codes() -> str:
    return table(["code", "meaning"], [[code(int(each)), MEANINGS[each]] for each in ExitCode])


def datasets() -> str:
    """Every dataset: its shape, unit, and what it is."""
    rows = []
    for each in (*DATASETS, *LATER):
        shape = ",\u00a0".join(["T", *map(str, each.shape)])  # a narrow column breaks no line there
        frame = f"; {each.frame}" if each.frame else ""
        rows.append([code(each.path), f"({shape})", each.unit, each.description + frame])
    for mark in CONSTANTS:
        rows.append([code(mark.path), f"({', '.join(map(str, mark.shape))})", mark.unit, mark.description])
    rows += [[code(each.path), f"({each.symbol})", "", each.description] for each in ALL_NAMES.values()]
    return table(["dataset", "shape", "unit", "what it is"], rows)


def pictures() -> str:
    return table(["kind", "what it shows"], [[code(name), kind.summary] for name, kind in KINDS.items()])


def sweep_pictures() -> str:
    return table(["kind", "what it shows"], [[code(name), kind.summary] for name, kind in SWEEP_PICTURES.items()])


def checks() -> str:
    return table(["check", "what it claims"], [[code(name), check.claim] for name, check in CHECKS.items()])


def quantities() -> str:
    rows = [[code(name), each.unit, each.summary] for name, each in QUANTITIES.items()]
    return table(["quantity", "unit", "what varies"], rows)


def python_names() -> str:
    """Every public name with the first sentence of its docstring, but for the classes of a scene's parts."""
    rows = []
    for name in sorted(["__version__", *" ".join(mbproj.HOMES.values()).split()]):
        found = getattr(mbproj, name)
        said = inspect.cleandoc(found.__doc__ or "").partition("\n\n")[0].replace("\n", " ")
        rows.append([code(name), f"version of mbproj, now {found}" if name == "__version__" else said])
    return table(["name", "what it is"], rows)
