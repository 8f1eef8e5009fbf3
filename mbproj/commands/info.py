"""`mbproj info`: the contents of a results file, or how this mbproj was built."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.report.text import json_text, table
from mbproj.cli.report.trust import as_numbers, lines_on
from mbproj.cli.report.verification import lines as verification_lines
from mbproj.cli.study_options import write_table as write_table_option
from mbproj.errors import ExitCode, shortened
from mbproj.report_schema import report_of
from mbproj.report_schema.info import ATTRIBUTES, INFO

if TYPE_CHECKING:
    from mbproj.results import Results

#: Attributes that the report already shows in words, or that are computed from the samples.
SHOWN_ELSEWHERE = ("format", "date", "host")
#: The most events that are listed.
SHOWN_EVENTS = 20
EXAMPLES = (
    ("Say what a results file holds.", "mbproj info results.h5"),
    ("Say how large the loads become.", "mbproj info results.h5 --loads"),
    ("Say whether the compiled kernel is there.", "mbproj info --build"),
)


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
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of text.")
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
    asked = [name for name, given in parts.items() if given]
    if asked and results is None:
        raise click.UsageError(f"{asked[0]} needs RESULTS, a results file")
    if len(asked) > 1:
        raise click.UsageError(f"give {' or '.join(asked)}, not both")
    for_loads = {"--over": over, "--level": level, "--rainflow": rainflow, "--write-table": table_file}
    for name, given in for_loads.items():
        if given and not loads:
            raise click.UsageError(f"{name} is for --loads; add --loads, or leave it out")
    if (results is not None) + build + thresholds != 1:
        raise click.UsageError(
            "give RESULTS, a results file, or --build, for how mbproj itself was built, or --thresholds, for the "
            "numbers that it decides by"
        )
    if table_file is not None:
        from mbproj.output_files.written_table import check_table

        check_table(table_file, ("kind", "name"))
    if results is None:
        click.echo(_build(as_json) if build else _thresholds(as_json))
        return int(ExitCode.DONE)
    from mbproj.cli.simulate import soundness
    from mbproj.results import check_results, open_results

    if check and results.is_dir():
        swept, lines = soundness.of_sweep(results)
        click.echo(_json(swept) if as_json else "\n".join(lines))
        return int(ExitCode.DONE if swept["sound"] else ExitCode.CHECK_FAILED)
    with open_results(results) as opened:
        if check:
            soundness_of_file = check_results(opened)
            facts = soundness.facts(opened, soundness_of_file)
            click.echo(_json(facts) if as_json else "\n".join(soundness.lines(opened, soundness_of_file)))
            return int(ExitCode.CHECK_FAILED if soundness_of_file.faults else ExitCode.DONE)
        if steps or energy:
            from mbproj.cli.simulate import energy_parts, step_limits

            said = step_limits if steps else energy_parts
            click.echo(_json(said.facts(opened)) if as_json else "\n".join(said.lines(opened)))
            return int(ExitCode.DONE)
        if loads:
            from mbproj.cli.simulate import largest_loads as report

            words = _json(report.facts(opened, over, level, rainflow=rainflow)) if as_json else None
            click.echo(words or "\n".join(report.lines(opened, over, level, rainflow=rainflow)))
            if table_file is not None:
                from mbproj.api.files import largest_loads as table_of
                from mbproj.output_files.written_table import write_table

                table = table_of(opened, over=over)
                click.echo(write_table(table_file, table.headings, table.rows), err=True)
            return int(ExitCode.DONE)
        click.echo(_json(_contents(opened)) if as_json else "\n".join(_lines(opened)))
    return int(ExitCode.DONE)


def _build(as_json: bool) -> str:
    from mbproj.cli.report import build_info

    return _json(build_info.facts()) if as_json else "\n".join(build_info.lines())


def _thresholds(as_json: bool) -> str:
    from mbproj.cli.report import thresholds

    return _json(thresholds.facts()) if as_json else "\n".join(thresholds.lines())


def _contents(results: Results) -> dict[str, Any]:
    from mbproj.analysis.contacts.creep import creep_by_friction
    from mbproj.analysis.contacts.friction import friction_records
    from mbproj.analysis.contacts.stops import stop_records
    from mbproj.analysis.reactions import reactions_not_unique, shared_at_contacts
    from mbproj.analysis.summary import summary

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
    from mbproj.analysis.contacts import creep, friction, stops

    has = _contents(results)
    partial = " (partial: the run was killed or still goes on)" if has["partial"] else ""
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
        yield from table({name: stops.in_words(seen) for name, seen in has["stops"].items()}, "  ")
    rubs = {name: friction.in_words(rubbed) for name, rubbed in has["frictions"].items()}
    rubs |= {name: creep.in_words(crept) for name, crept in has["creep"].items()}
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
    from mbproj.analysis.reactions import SHOWN, in_words

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
    given = {key: value for key, value in {**plain, **projection, **changed}.items() if value is not None}
    return {key: str(value) for key, value in given.items()}


def _attributes(has: Mapping[str, Any]) -> dict[str, str]:
    rest = {key: value for key, value in has["attributes"].items() if key not in SHOWN_ELSEWHERE and key not in has}
    units = {fact.key: fact.unit.removeprefix("1") for fact in ATTRIBUTES}
    texts = {key: f"{value:.6g}" if isinstance(value, float) else str(value) for key, value in rest.items()}
    return {key: f"{text} {units.get(key, '')}".rstrip() for key, text in texts.items()}


def _datasets(has: Mapping[str, Any]) -> dict[str, str]:
    return {path: f"{tuple(entry['shape'])!s:<16} {entry['unit']}" for path, entry in has["datasets"].items()}
