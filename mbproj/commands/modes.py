"""`mbproj modes`, `mbproj.modes` and `traces`: the frequencies at which a mechanism vibrates, and
the shapes of these vibrations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.base.registry import SCENE_START
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import AnyNumber, Count, Several
from mbproj.commands.linear_options import At, FromResults, Steady, reference_of
from mbproj.commands.options import (
    NOTHING,
    Option,
    Part,
    force_option,
    json_option,
    option,
    output_option,
    quiet_option,
    results_file,
)
from mbproj.commands.report.text import json_text
from mbproj.commands.study_options import write_table_option
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.scenes import MODES

if TYPE_CHECKING:
    from mbproj.base.arrays import Numbers
    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.linear.modes import Modes, RootLocus
    from mbproj.scene.scene import Scene

#: The most joint coordinates of a mode in the table, and the most modes.
SHOWN_COORDINATES, SHOWN_MODES = 3, 40
EXAMPLES = (
    ("List the modes at the start, and write modes.h5.", "mbproj modes five_bar.yaml"),
    ("The three slowest at a time of a run.", "mbproj modes five_bar.yaml --at 0.5 --from results.h5 --count 3"),
    ("Trace the modes over a parameter.", 'mbproj modes five_bar.yaml --at "0.5 s" --vary mass=1:4:4 -o traces.h5'),
)
Few = Annotated["int | None", Option(Part.WHAT, "Only the N slowest [default: all, 10 of many].", Count(1), "N")]


@declared
def modes(
    scene: SceneLike,
    *,
    at: At = SCENE_START,
    count: Few = None,
    steady: Steady = None,
    results: FromResults = None,
    parameters: Mapping[str, object] = NOTHING,
) -> Modes:
    """Finds the modes of a scene: frequencies, damping and shapes of small motions.

    Linearises the equations of motion with exact derivatives, including damping and gyroscopic terms, within what the
    joints allow. Driven coordinates are held.

    In Python `at` tells where: "start", "equilibrium", "steady" (with `steady`, such as "A.angle=60rpm"), or a time in
    s, of a run or of the file `results`. `scene` and `parameters` are as in `run`.
    """
    asked = read(modes, locals())
    return _modes(asked.scene, asked)


@declared
def traces(
    scene: SceneLike,
    name: str,
    values: Sequence[Quantity],
    *,
    at: At = SCENE_START,
    count: Few = None,
    steady: Steady = None,
    parameters: Mapping[str, object] = NOTHING,
) -> RootLocus:
    """The modes over `values` of the parameter `name`, as `modes --vary` traces them. The other arguments are as in
    `modes`."""
    from mbproj.commands.arguments import scene_of
    from mbproj.linear.modes import trace

    asked = read(traces, locals())
    numbers = Several(AnyNumber(None)).of(values, "--values")
    if not numbers:
        raise InputError(Problem("there are none", Place("values"), "give at least one"))
    return trace(name, numbers, lambda value: _modes(scene_of(scene, {**parameters, name: value}, {}), asked))[0]


def _modes(scene: Scene, asked: Any) -> Modes:
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.linear.modes import modes
    from mbproj.scene.settings import placed_in

    with placed_in(scene):
        results = getattr(asked, "results", None)
        return modes(reference_of(scene, compile_system(scene), asked.at, results, asked.steady), asked.count)


VARY = option(Part.WHAT, "--vary", metavar="NAME=RANGE", help="Trace the modes over a parameter: length=0.5:2:20.")
OUTPUT = output_option("modes.h5", results_file(path_type=Path), "File of modes.")


@command_of(modes, EXAMPLES, VARY, OUTPUT, write_table_option, json_option, quiet_option, force_option)
def command(
    asked: Asked[Modes],
    vary: str | None,
    output: Path,
    table_file: Path | None,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> None:
    from mbproj.linear.modes import stored
    from mbproj.results.linear_files import MODES_LAYOUT, write_modes
    from mbproj.results.output_files import check_replaceable, hdf5
    from mbproj.results.table_files import check_table, write_table

    with placed_at(Place("--output")):
        check_replaceable(output, hdf5(MODES_LAYOUT.format), force=force)
    check_table(table_file, ("mode", "frequency (Hz)"), force=force)
    trace: RootLocus | None = None
    if vary is None:
        what, modal = asked.scene, asked.result()
    else:
        what, modal, trace = _traced(asked, vary)
    if table_file is not None:
        write_table(table_file, modal.table.headings, modal.table.rows, force=force)
    write_modes(output, stored(modal, what.title, trace), what, force=force)
    if as_json:
        click.echo(json_text(numbers(modal, asked.path, str(output), trace)))
    elif not quiet:
        click.echo(report(modal, what.title or asked.path, trace))
        click.echo(output)


def _traced(asked: Asked[Modes], vary: str) -> tuple[Scene, Modes, RootLocus]:
    """The modes at each value of a parameter, with the scene and the modes of the last value for the file and the
    table."""
    from mbproj.linear.modes import trace
    from mbproj.scene.ranges import Points, named_range

    name, span = named_range(vary, "--vary")
    if not isinstance(span, Points) or any(isinstance(item, str) for item in span.items):
        hint = f"give first:last:count, as in --vary {name}=1:2:11, or numbers one by one"
        raise InputError(Problem("it takes numbers that can be counted", Place(f"--vary {name}"), hint))
    where = asked.read()
    scenes: list[Scene] = []

    def at(value: float) -> Modes:
        scenes.append(asked.scene_with({name: repr(value)}))
        return _modes(scenes[-1], where)

    traced, last = trace(name, [float(item) for item in span.items], at)
    return scenes[-1], last, traced


def numbers(modal: Modes, scene: str, output: str, trace: RootLocus | None) -> dict[str, Any]:
    """The modes as a dictionary for JSON, with stable keys."""
    from mbproj.linear.modes import is_balanced, notes_on

    reference, names = modal.reference, modal.reference.system.names
    known = {} if trace is None else {"vary": trace}
    modes = [
        {
            "name": modal.name(mode),
            "kinetic_energy": dict(zip(modal.kinetic_names, modal.kinetic[mode], strict=True)),
            "potential_energy": dict(zip(modal.strain_names, modal.strain[mode], strict=True)),
            "coordinates": _phasors(names.coordinates, modal.coordinates[mode]),
            "states": _phasors(names.states, modal.states[mode]),
        }
        for mode in range(len(modal.eigenvalues))
    ]
    said = {"balanced": is_balanced(reference), "modes": modes, "notes": notes_on(modal)}
    return report_of(MODES, modal, scene=scene, output=output, **said, **known)


def _phasors(names: Sequence[str], values: Numbers) -> dict[str, list[float]]:
    """The real and the imaginary part of each value by name."""
    return {name: [value.real, value.imag] for name, value in zip(names, values.tolist(), strict=True)}


def report(modal: Modes, title: str, trace: RootLocus | None) -> str:
    """The table of the modes, with notes."""
    from mbproj.commands.report.text import columns
    from mbproj.linear.modes import notes_on

    shown = range(min(len(modal.eigenvalues), SHOWN_MODES))
    head = ["mode", "Hz", "damping", "growth 1/s", "time s"]
    rows = [[str(mode + 1), *_cells(modal, mode)] for mode in shown]
    lines = columns(head, rows).splitlines() if rows else []
    told = [f"{_coordinates(modal, mode)}  {modal.name(mode)}".strip() for mode in shown]
    width = max((len(line) for line in lines), default=0)
    table = (
        [lines[0], *(f"{line:{width}}  {words}" for line, words in zip(lines[1:], told, strict=True))] if lines else []
    )
    left = len(modal.eigenvalues) - len(shown)
    more = [f"    ... and {left} more in the file"] if left else []
    traced = (
        []
        if trace is None
        else [f"{len(trace.values)} values of {trace.name}; the table is of the last, {trace.values[-1]:.6g}"]
    )
    notes = [f"note: {note}" for note in notes_on(modal)]
    return "\n".join([f"{title}: {modal.line}", *traced, "", *table, *more, *notes])


def _cells(modal: Modes, mode: int) -> list[str]:
    value = modal.eigenvalues[mode]
    time = "-" if value.real == 0.0 else f"{1.0 / abs(value.real):.4g}"
    damping = "-" if value == 0.0 else f"{modal.damping_ratios[mode]:.4g}"
    return [f"{modal.frequencies[mode]:.6g}", damping, f"{value.real:.4g}", time]


def _coordinates(modal: Modes, mode: int) -> str:
    """The joint coordinates or states that move most, relative to the largest, with their phase where they have one."""
    import numpy as np

    names, units = modal.reference.system.names.coordinates, modal.reference.system.names.coordinate_units
    length = modal.reference.system.length
    parts = modal.coordinates[mode] / np.array([1.0 if unit == "rad" else length for unit in units])
    if modal.is_of_states(mode):
        names, parts = modal.reference.system.names.states, modal.states[mode] / modal.reference.system.states.scale
    order = np.argsort(-np.abs(parts), kind="stable")[:SHOWN_COORDINATES]
    if not len(order) or not abs(parts[order[0]]) > 0.0:
        return ""
    relative = parts / parts[order[0]]
    told = [(names[index], relative[index]) for index in order if abs(relative[index]) > 0.01]
    return ", ".join(f"{name} {_phasor(value)}" for name, value in told)


def _phasor(value: complex) -> str:
    if abs(value.imag) <= 1e-6 * abs(value):
        return f"{value.real:+.2g}"
    from math import atan2, degrees

    return f"{abs(value):.2g}∠{degrees(atan2(value.imag, value.real)):.0f}°"
