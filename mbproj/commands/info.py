"""`mbproj info`: the contents of a results file, or how this mbproj was built."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from math import degrees, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from mbproj.base.errors import ExitCode, InputError, Problem, shortened
from mbproj.base.plugins import installed
from mbproj.base.registry import AUTOMATIC, FORMULATIONS
from mbproj.base.thresholds import threshold_table
from mbproj.base.version import __version__
from mbproj.commands.declared import declared
from mbproj.commands.options import Part, SomeResults, explained, json_option, option, results_file
from mbproj.commands.report.summary import as_numbers, lines_on
from mbproj.commands.report.text import columns, json_text, table
from mbproj.commands.stored_run import opened, stored_scene
from mbproj.commands.study_options import write_table_option
from mbproj.commands.verify import lines as verification_lines
from mbproj.kernel import advice, build_info, left_out
from mbproj.results.analysis.loads import cycle_of, duration_above, loads_of, recorded_in, samples_of, swings
from mbproj.results.check import Soundness
from mbproj.results.largest_loads import Load
from mbproj.results.record import Results
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.files import ATTRIBUTES, ENERGY, INFO, THRESHOLD_ROWS
from mbproj.results.views import Table

if TYPE_CHECKING:
    from mbproj.results.record import Results


#: Attributes that the report already shows in words, or that are computed from the samples.
SHOWN_ELSEWHERE = ("format", "date", "host")
#: The most events that are listed.
SHOWN_EVENTS = 20
EXAMPLES = (
    ("Say what a results file holds.", "mbproj info results.h5"),
    ("Say how large the loads become.", "mbproj info results.h5 --loads"),
    ("Say whether the compiled kernel is there.", "mbproj info --build"),
)


@declared
def largest_loads(results: SomeResults, *, over: str | None = None) -> Table:
    """The largest loads of a run, as `mbproj info --loads` lists them: a table with a row for each load and the fields
    of `Load`.

    `over` names the coordinate that tells the place in the cycle. Raises InputError for an unknown name.
    """
    with opened(results) as opened_results:
        return Table.of((load._asdict() for load in loads_of(opened_results, over)), *Load._fields)


@explained("info", EXAMPLES)
@click.argument("results", required=False, type=results_file(path_type=Path))
@option(Part.WHAT, "--build", is_flag=True, help="Show versions, the compiled kernel and its instruction set instead.")
@option(Part.WHAT, "--thresholds", is_flag=True, help="Show every threshold with its unit, reason and source instead.")
@option(Part.WHAT, "--steps", is_flag=True, help="Say which body or force limits the smaller steps of RESULTS instead.")
@option(
    Part.WHAT, "--energy", is_flag=True, help="Show the energy that dampers, integrator and projection took instead."
)
@option(Part.WHAT, "--loads", is_flag=True, help="List the largest loads of joints, motions and forces instead.")
@option(
    Part.WHAT,
    "--over",
    metavar="JOINT.COORDINATE",
    help="With --loads: the coordinate that tells the place in the cycle.",
)
@option(
    Part.WHAT,
    "--level",
    type=click.FloatRange(0.0, 1.0),
    metavar="SHARE",
    help="With --loads: for how long each load is above this part of its largest.",
)
@option(Part.WHAT, "--rainflow", is_flag=True, help="With --loads: count the swings of each, by ASTM E1049.")
@option(Part.WHAT, "--check", is_flag=True, help="Read all of RESULTS and compare it with its checksums instead.")
@write_table_option
@json_option
def command(
    results: Path | None,
    build: bool,
    thresholds: bool,
    steps: bool,
    energy: bool,
    loads: bool,
    over: str | None,
    level: float | None,
    rainflow: bool,
    check: bool,
    table_file: Path | None,
    as_json: bool,
) -> int:
    """Shows the contents of RESULTS: settings, violations, timings, datasets.

    A check also takes the folder of a sweep. Exit code 4: --check has found something wrong.
    """
    parts = {"--check": check, "--steps": steps, "--energy": energy, "--loads": loads}
    asked = [name for name, flag in parts.items() if flag]
    if asked and results is None:
        raise click.UsageError(f"{asked[0]} needs RESULTS, a results file")
    if len(asked) > 1:
        raise click.UsageError(f"give {' or '.join(asked)}, not both")
    for_loads = {"--over": over, "--level": level, "--rainflow": rainflow, "--write-table": table_file}
    for name, value in for_loads.items():
        if value and not loads:
            raise click.UsageError(f"{name} is for --loads; add --loads, or leave it out")
    if (results is not None) + build + thresholds != 1:
        raise click.UsageError(
            "give RESULTS, a results file, or --build, for how mbproj itself was built, or --thresholds, for the "
            "numbers that it decides by"
        )
    if table_file is not None:
        from mbproj.results.table_files import check_table

        check_table(table_file, ("kind", "name"))
    if results is None:
        click.echo(_build(as_json) if build else _thresholds(as_json))
        return int(ExitCode.DONE)
    from mbproj.results.check import check_results
    from mbproj.results.reader import open_results

    if check and results.is_dir():
        swept, lines = of_sweep(results)
        click.echo(_json(swept) if as_json else "\n".join(lines))
        return int(ExitCode.DONE if swept["sound"] else ExitCode.CHECK_FAILED)
    with open_results(results) as file:
        if check:
            soundness_of_file = check_results(file)
            facts = soundness_facts(file, soundness_of_file)
            click.echo(_json(facts) if as_json else "\n".join(soundness_lines(file, soundness_of_file)))
            return int(ExitCode.CHECK_FAILED if soundness_of_file.faults else ExitCode.DONE)
        if steps or energy:
            from mbproj.commands.report import step_limits

            said, told = (step_limits.facts, step_limits.lines) if steps else (energy_facts, energy_lines)
            click.echo(_json(said(file)) if as_json else "\n".join(told(file)))
            return int(ExitCode.DONE)
        if loads:
            words = _json(loads_facts(file, over, level, rainflow=rainflow)) if as_json else None
            click.echo(words or "\n".join(loads_lines(file, over, level, rainflow=rainflow)))
            if table_file is not None:
                from mbproj.results.table_files import write_table

                table = largest_loads(file, over=over)
                click.echo(write_table(table_file, table.headings, table.rows), err=True)
            return int(ExitCode.DONE)
        click.echo(_json(_contents(file)) if as_json else "\n".join(_lines(file)))
    return int(ExitCode.DONE)


def _build(as_json: bool) -> str:

    return _json(build_facts()) if as_json else "\n".join(build_lines())


def _thresholds(as_json: bool) -> str:
    return _json(threshold_facts()) if as_json else "\n".join(threshold_lines())


def _contents(results: Results) -> dict[str, Any]:
    from mbproj.results.analysis.contacts import creep_by_friction, friction_records, stop_records
    from mbproj.results.analysis.loads import reactions_not_unique, shared_at_contacts
    from mbproj.results.analysis.summary import summary

    return report_of(
        INFO,
        results,
        **summary(results),
        reactions_not_unique=reactions_not_unique(results),
        shared_at_contacts=shared_at_contacts(results),
        attributes={name: value for name, value in results.attributes.items() if name != "notes"},
        names={kind: results.names(kind) for kind in ("bodies", "markers", "joints", "coordinates")},
        stops=stop_records(results),
        frictions=friction_records(results),
        creep=creep_by_friction(results),
        datasets={each.path: {"shape": results.shape(each.path), "unit": each.unit} for each in results.datasets},
        **({} if results.trust is None else {"trust": as_numbers(results.trust)}),
        **({} if results.verification is None else {"verification": results.verification}),
    )


def _json(contents: Mapping[str, Any]) -> str:
    return json_text(contents, indent=2)


def _lines(results: Results) -> Iterator[str]:
    from mbproj.results.analysis import contacts as creep
    from mbproj.results.analysis import contacts as friction
    from mbproj.results.analysis import contacts as stops
    from mbproj.results.file.opening import is_locked

    has = _contents(results)
    goes_on = "it is being written" if is_locked(results.path) else "the run was killed or still goes on"
    partial = f" (partial: {goes_on})" if has["partial"] else ""
    numbers = _numbers(has) if has["samples"] else {"samples": "none"}
    yield from table(
        {
            "title": has["title"],
            "file": has["file"],
            "status": has["status"] + partial,
            "run": f"{has['attributes'].get('date', '')} on {has['attributes'].get('host', '')}",
            "scene": has["scene"] or "(not from a file)",
            "size": f"{has['bodies']} bodies, {has['joints']} joints with {has['coordinates']} coordinates, "
            f"{has['markers']} markers",
            **({"motion": "0 degrees of freedom: kinematic"} if has["attributes"].get("kinematic") else {}),
            **numbers,
            **_reactions(has),
        }
    )
    if has["stops"]:
        yield "\nstops"
        yield from table({name: stops.stop_in_words(seen) for name, seen in has["stops"].items()}, "  ")
    rubs = {name: friction.friction_in_words(rubbed) for name, rubbed in has["frictions"].items()}
    rubs |= {name: creep.creep_in_words(crept) for name, crept in has["creep"].items()}
    if rubs:
        yield "\ndry friction"
        yield from table(rubs, "  ")
    if results.events:
        yield "\nevents"
        yield from _events(results)
    if results.notes:
        yield "\nnotes"
        yield from (f"  {note.place}: {note.text}" if note.place else f"  {note.text}" for note in results.notes)
    if results.trust is not None:
        yield "\ntrust"
        yield from lines_on(results.trust)
    elif results.certified is not None:
        yield "\ntrust\n  it was to be certified, but was interrupted before"
    if results.verification is not None:
        yield "\nverification"
        yield from verification_lines(results.verification)
    for title, values in (("settings", _settings(has)), ("attributes", _attributes(has)), ("datasets", _datasets(has))):
        yield f"\n{title}"
        yield from table(values, "  ")


def _events(results: Results) -> Iterator[str]:
    """Yield the first events as lines."""
    events = results.events
    sense = {1: ", rising", -1: ", falling"}
    units = dict(zip(results.names("stops"), results.names("stop_units"), strict=True))
    for event in events[:SHOWN_EVENTS]:
        what = f"{event.name}, {event.kind}{sense.get(event.direction, '')}"
        if event.impulse:
            unit = "N m s" if units.get(event.name[len("stop '") : -1]) == "rad" else "N s"
            what = f"{event.name}, {event.kind} of {event.impulse:.6g} {unit}, which took {event.energy:.3g} J"
        yield f"  t = {event.time:.9g} s: {what}"
    if len(events) > SHOWN_EVENTS:
        yield f"  and {len(events) - SHOWN_EVENTS} more"


def _numbers(has: Mapping[str, Any]) -> dict[str, str]:
    counters = ("steps", "rejected_steps", "evaluations", "projections", "projection_failures")
    position, velocity = (
        f"{has[f'{kind}_violation_max']:.3g}{_at(has[f'{kind}_violation_time'])}" for kind in ("position", "velocity")
    )
    worst = {
        f"largest joint {kind}": f"{peak['value']:.3g} {unit} in '{peak['name']}'{_at(peak['time'])}"
        if peak["value"]
        else f"0 {unit}"
        for kind, unit in (("length", "m"), ("angle", "rad"))
        if (peak := has[f"worst_{kind}"])
    }
    return {
        "samples": f"{has['samples']}, t = {has['start']:.6g} s to {has['end']:.6g} s",
        "work": ", ".join(f"{has[counter]} {counter.replace('_', ' ')}" for counter in counters),
        "iterations": f"{has['projection_iterations']} position, {has['velocity_iterations']} velocity",
        "largest |C|": position,
        "largest |dC/dt|": velocity,
        **worst,
        "energy drift": f"{has['energy_drift']:.3g} J, relative {has['energy_drift_relative']:.3g}",
    }


def _reactions(has: Mapping[str, Any]) -> dict[str, str]:
    """The reaction components that are not unique, and the forces that contacts share, as far as there are any."""
    from mbproj.results.analysis.loads import SHOWN, in_words

    components, shared = has["reactions_not_unique"], has["shared_at_contacts"]
    rows = {"reactions not unique": in_words(components)} if components else {}
    if shared:
        rows["shared at contacts"] = f"{shortened(list(shared), SHOWN)}, first{_at(min(shared.values()))}"
    return rows


def _at(time: float) -> str:
    return f" at t = {time:.6g} s"


def _settings(has: Mapping[str, Any]) -> dict[str, str]:
    plain = {key: value for key, value in has["settings"].items() if key != "projection"}
    projection = {f"projection.{key}": value for key, value in has["settings"]["projection"].items()}
    changed = {f"--set {key}": value for key, value in has["overrides"].items()}
    settings = {key: value for key, value in {**plain, **projection, **changed}.items() if value is not None}
    return {key: str(value) for key, value in settings.items()}


def _attributes(has: Mapping[str, Any]) -> dict[str, str]:
    rest = {key: value for key, value in has["attributes"].items() if key not in SHOWN_ELSEWHERE and key not in has}
    units = {fact.key: fact.unit.removeprefix("1") for fact in ATTRIBUTES}
    texts = {key: f"{value:.6g}" if isinstance(value, float) else str(value) for key, value in rest.items()}
    return {key: f"{text} {units.get(key, '')}".rstrip() for key, text in texts.items()}


def _datasets(has: Mapping[str, Any]) -> dict[str, str]:
    return {path: f"{tuple(entry['shape'])!s:<16} {entry['unit']}" for path, entry in has["datasets"].items()}


# --- The largest loads of a run, as lines and for JSON (`info --loads`) -----------------------------------------------


HEADINGS = ("load", "largest", "unit", "at t (s)", "place", "mean", "rms")
#: A load below this part of the largest one in its unit counts as zero.
NOTHING = 1e-9


def loads_facts(results: Results, over: str | None, level: float | None, *, rainflow: bool) -> dict[str, Any]:
    """The loads as a dictionary for JSON. `level` is a part of each largest load; the time above it is computed."""
    return {
        "file": str(results.path),
        "place_of": None if (place := place_of(results, over)) is None else place[0],
        "loads": [_facts(results, load, level, rainflow=rainflow) for load in loads_of(results, over)],
    }


def _facts(results: Results, load: Load, level: float | None, *, rainflow: bool) -> dict[str, Any]:
    entry: dict[str, Any] = load._asdict()
    if level is not None:
        entry["above"] = level * abs(load.largest)
        entry["duration_above"] = duration_above(results.time, samples_of(results, load), entry["above"])
    if rainflow:
        entry["rainflow"] = [swing._asdict() for swing in swings(samples_of(results, load))]
    return entry


def place_of(results: Results, over: str | None) -> tuple[str, str] | None:
    """The coordinate that tells the place in the cycle, and its unit: `over`, or that of the first motion; None without
    either."""
    cycle = cycle_of(results, over) if over else recorded_in(results).cycle()
    return None if cycle is None else (cycle.name, cycle.unit)


def loads_lines(results: Results, over: str | None, level: float | None, *, rainflow: bool) -> Iterator[str]:
    """Yield a table of the loads, then works, durations and counts."""
    all_loads = loads_of(results, over)
    felt = [load for load in all_loads if not _is_round_off(load, all_loads)]
    if not felt:
        yield "nothing is loaded" if all_loads else "there are no joints, motions or forces that could be loaded"
        return
    place = place_of(results, over)
    yield columns(HEADINGS, [_row(load, place[1] if place else "") for load in felt])
    yield "\n± is the uncertainty between samples; the error of the run itself comes on top (run --certify)"
    if place is not None:
        yield f"place: {place[0]}{', modulo a turn' if place[1] == 'rad' else ''}"
    if any(not load.unique for load in felt):
        yield "*: redundant joints can share it in any proportion"
    works = [load for load in felt if not isnan(load.put_in)]
    if works:
        yield "\nworks"
        named = [(_name(load).removesuffix(" power"), f"{load.put_in:.6g}", f"{load.taken_out:.6g}") for load in works]
        yield columns(("of", "put in (J)", "taken out (J)"), named)
    if level is not None:
        yield f"\nduration above {level:g} of the largest"
        for load in felt:
            values = samples_of(results, load)
            yield f"  {_name(load)}: {duration_above(results.time, values, level * abs(load.largest)):.6g} s"
    if rainflow:
        for load in felt:
            yield f"\nswings of {_name(load)} ({load.unit})"
            counted = swings(samples_of(results, load))
            rows = [(f"{each.range:.5g}", f"{each.mean:.5g}", f"{each.cycles:g}") for each in counted]
            yield columns(("range", "mean", "cycles"), rows)


def _is_round_off(load: Load, loads: Sequence[Load]) -> bool:
    """Whether a load is zero apart from round-off, relative to the others in its unit. A torque is also compared with
    forces at an arm of 1 m."""
    units = {"N", "N m"} if load.unit == "N m" else {load.unit}
    largest = max(abs(other.largest) for other in loads if other.unit in units)
    return abs(load.largest) <= NOTHING * largest or load.largest == 0.0


def _name(load: Load) -> str:
    return f"{load.kind} '{load.name}' {load.quantity.replace('_', ' ')}"


def _row(load: Load, unit: str) -> tuple[str, ...]:
    place = f"{degrees(load.place):.1f}°" if unit == "rad" else f"{load.place:.5g} {unit}" if unit else "-"
    return cells(load, _name(load) + ("" if load.unique else " *"), place)


def cells(load: Load, name: str, place: str) -> tuple[str, ...]:
    """The row of a load in a table, with this name and its place in the cycle."""
    return (
        name,
        f"{load.largest:.6g} ± {load.uncertainty:.1g}",
        load.unit,
        f"{load.time:.6g}",
        place,
        f"{load.mean:.5g}",
        f"{load.rms:.5g}",
    )


# --- The check of a results file or of a sweep's folder, as lines and for JSON (`info --check`) -----------------------


def of_sweep(folder: Path) -> tuple[dict[str, Any], list[str]]:
    """The result of checking a sweep's folder, as a dictionary for JSON and as lines."""
    from mbproj.studies.sweep.summary import check_sweep

    soundness = check_sweep(folder)
    soundness_lines = [f"{folder}: {soundness.rows} rows and {soundness.files} results files read"]
    soundness_lines += [f"  wrong: {fault}" for fault in soundness.faults] or ["  nothing is wrong with it"]
    soundness_lines += [f"  {name} has no checksums: an older mbproj wrote it" for name in soundness.unguarded]
    soundness_lines += [
        f"  delete '{folder / name}': a sweep keeps the results files that it finds" for name in soundness.damaged
    ]
    soundness_lines += ["  start the sweep again: it computes what is damaged or missing"] if soundness.faults else []
    return {"folder": str(folder), "sound": not soundness.faults, **asdict(soundness)}, soundness_lines


def soundness_facts(results: Results, soundness: Soundness) -> dict[str, Any]:
    """The result of checking a results file, as a dictionary for JSON."""
    return {"file": str(results.path), "sound": not soundness.faults, **asdict(soundness)}


def soundness_lines(results: Results, soundness: Soundness) -> Iterator[str]:
    """Yield the result of checking a results file, line by line."""
    yield f"{results.path}: {soundness.datasets} datasets read, {soundness.bytes / 1e6:.3g} MB of samples"
    yield from (f"  wrong: {fault}" for fault in soundness.faults)
    if not soundness.faults:
        yield "  nothing is wrong with it"
    if len(soundness.unguarded) == soundness.datasets:
        yield "  it has no checksums: an older mbproj wrote it, and changed numbers would not show"
    elif soundness.unguarded:
        yield f"  {len(soundness.unguarded)} datasets have no checksum: {shortened(soundness.unguarded, 8)}"
    if results.contents.unfinished:
        yield "  its run has not ended: samples have Fletcher-32 alone, which takes 16 ones for 16 zeros"


# --- The energy balance of a run, by its parts ------------------------------------------------------------------------


#: The sum of the parts is the change of energy to within this part of their size and of all energies. An implicit
#: method with error control ends Newton's iterations by its tolerance, which single steps do not have.
CLOSES, ROUND_OFF = 0.01, 1e-12


class EnergyParts(NamedTuple):
    """The energy E at the start and the end of a run, and its changes, all in J. Energy put in is positive."""

    start: float
    put_in: float
    dissipated: float
    integrator: float
    projection: float
    end: float

    @property
    def unexplained(self) -> float:
        """The change of energy that the parts do not explain, J."""
        return self.end - self.start - (self.put_in - self.dissipated + self.integrator + self.projection)

    @property
    def size(self) -> float:
        """The sum of the absolute values of all parts, J."""
        return sum(map(abs, self))


def split_energy(results: Results) -> EnergyParts:
    """Repeat each step of the run without and with projection, and sum the parts. Raises InputError for runs that
    cannot be divided, SimulationError where the run cannot be repeated."""
    from mbproj.studies.compare import energy_split
    from mbproj.studies.measure.setting import Setting
    from mbproj.studies.measure.solve import Mechanism, sample_times, solve

    settings, mechanism = results.settings, Mechanism.of(stored_scene(results))
    obstacle = None
    if results.attributes.get("kinematic"):
        raise _undivided(results, "the run is kinematic, nothing of its motion was integrated")
    if settings.integrator == AUTOMATIC:
        obstacle = f"steps of '{AUTOMATIC}' are not all of one method"
    elif mechanism.system.stops is not None:
        obstacle = "impacts at stops belong to no step"
    elif mechanism.system.frictions is not None:
        obstacle = "dry friction sticks and slips between steps"
    elif results.status != "complete":
        obstacle = "the run did not come to its end"
    solution = solve(mechanism, Setting.of(settings), sample_times(settings.duration or 0.0, 1))
    if solution.failure is not None:
        obstacle = obstacle or solution.failure.cause
    if obstacle is not None:
        raise _undivided(results, obstacle)
    split = energy_split(mechanism, solution)
    energy, work, loss = (results[f"diagnostics/{name}"] for name in ("total_energy", "work", "dissipation"))
    parts = EnergyParts(
        start=float(energy[0]),
        put_in=float(work[-1]),
        dissipated=float(loss[-1]),
        integrator=float(split.integrator[-1]),
        projection=float(split.projection[-1]),
        end=float(energy[-1]),
    )
    if abs(parts.unexplained) > CLOSES * max(abs(parts.integrator), abs(parts.projection)) + ROUND_OFF * parts.size:
        raise _undivided(results, "its steps, made again one by one, are not those of the run")
    return parts


def _undivided(results: Results, why: str) -> InputError:
    return InputError(Problem(f"{results.path}: its energy cannot be divided: {why}"))


def energy_facts(results: Results) -> dict[str, Any]:
    """The parts as a dictionary for JSON."""
    return report_of(ENERGY, split_energy(results), file=results.path)


def energy_lines(results: Results) -> Iterator[str]:
    """Yield the energy at the start, its changes, and the energy at the end."""
    parts = split_energy(results)
    yield f"{results.path}: energy from the start to t = {results.time[-1]:g} s"
    said = {
        "at the start": f"{parts.start:.6e} J",
        "forces put in": f"{parts.put_in:.2e} J",
        "dampers took": f"{parts.dissipated:.2e} J",
        "the integrator": _changed(parts.integrator),
        "the projection": _changed(parts.projection),
        "at the end": f"{parts.end:.6e} J",
    }
    yield from table(said, indent="  ")


def _changed(energy: float) -> str:
    return f"took {-energy:.2e} J" if energy < 0.0 else f"added {energy:.2e} J"


# --- The report of `mbproj info --build` ------------------------------------------------------------------------------
# Versions of the software, and how the kernel was compiled.


def build_facts() -> dict[str, Any]:
    """The versions, the formulations that can run here, and the kernel's build. Without a kernel, `reason` tells why
    and `advice` what to do."""
    import h5py
    import numpy as np

    kernel = build_info()
    return {
        "mbproj": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "h5py": h5py.__version__,
        "formulations": ["full"] if isinstance(kernel, str) else [name for name in FORMULATIONS if name != "auto"],
        "plugins": installed(),
        "kernel": _absent(kernel) if isinstance(kernel, str) else {"built": True, **kernel},
    }


def _absent(reason: str) -> dict[str, Any]:
    return {"built": False, "reason": reason, "advice": None if left_out() else advice()}


def build_lines() -> Iterator[str]:
    """Yield the facts as lines of text."""
    has = build_facts()
    kernel = has.pop("kernel")
    has["formulations"] = ", ".join(has["formulations"])
    kinds = has.pop("plugins")
    for kind, members in kinds.items():
        has[f"{kind}s"] = ", ".join(f"{name} (from {module})" for name, module in members.items())
    has["kernel"] = kernel["instruction_set"] if kernel["built"] else f"none: {kernel['reason']}"
    yield from table(has)
    if not kernel["built"] and kernel["advice"]:
        yield f"  {kernel['advice']}"
    if kernel["built"]:
        yield from table({key: kernel[key] for key in ("compiler", "build_type", "flags", "eigen")}, "  ")


# --- `info --thresholds` ----------------------------------------------------------------------------------------------
# Every chosen number, as a table and for JSON.


#: The users of a threshold, in words.
USERS = {"both": "NumPy and kernel", "kernel": "kernel", "numpy": "NumPy"}


def threshold_facts() -> dict[str, Any]:
    """Each threshold by its name."""
    return {row.name: report_of(THRESHOLD_ROWS, row) for row in threshold_table()}


def threshold_lines() -> Iterator[str]:
    """Yield a line of numbers for each threshold, and below it its effect and its source."""
    rows = threshold_table()
    name, value = max(len(row.name) for row in rows), max(len(f"{row.value:g}") for row in rows)
    for row in rows:
        yield f"{row.name:<{name}}  {row.value:>{value}g} {row.unit} ({USERS[row.used_by]})"
        yield f"  {row.why} [{row.source}]"
