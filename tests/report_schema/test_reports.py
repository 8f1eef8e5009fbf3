"""The tables of facts: each fact is said, and nothing else is. `tests/cli/commands.py` holds all commands that tests
run against them, `tests/mechanisms/test_every_command.py` all mechanisms."""

from __future__ import annotations

import json
import re

import click
import pytest
from jsonschema import Draft202012Validator, ValidationError

import mbproj as package
from mbproj.cli import mbproj as group
from mbproj.cli.report import build_info
from mbproj.errors import InputError
from mbproj.report_schema import ANY_NAME, report_of
from mbproj.report_schema.info import NOT_BUILT
from mbproj.report_schema.reports import REPORTS
from tests.cli.commands import mbproj
from tests.cli.reports import PRINTED_BY, all_of, refuse_what_no_table_says, said_in
from tests.crossed import where
from tests.report_schema.commands import SAID, prepare

#: Reports of studies, which take seconds.
LONG = {"compare", "fit", "optimise-topologies", "recommend", "sensitivity", "stability", "threshold", "tradeoff"}
LONG |= {"verify"}
KINDS = {"string", "number", "integer", "boolean", "array", "map", "object", "null"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the scenes and the files that the commands name."""
    made = tmp_path_factory.mktemp("facts")
    prepare(made)
    return made


def test_each_command_with_json_has_a_report():
    context = click.Context(group)
    commands = {name: group.get_command(context, name) for name in group.list_commands(context)}
    able = {name for name, command in commands.items() for each in command.params if "--json" in each.opts}
    assert able == {words[0] for words in PRINTED_BY}
    assert SAID.keys() == REPORTS.keys()


@pytest.mark.long
@pytest.mark.parametrize("name", where(lambda name: name not in LONG, SAID))
def test_each_fact_is_said(folder, name):
    said, report = set(), REPORTS[name]
    for words in SAID[name]:
        done = mbproj(*words, "--json", folder=folder)
        assert done.stdout.startswith(("{", "[")), done.stderr
        said.update(said_in(json.loads(done.stdout), report.kind, report.facts))
    never = [fact.key for fact in all_of(report.facts) if fact not in said and ANY_NAME not in fact.key]
    assert never == [fact.key for fact in all_of(report.facts) if fact.when == NOT_BUILT]


def test_what_is_said_of_a_missing_kernel(monkeypatch):
    monkeypatch.setattr(build_info, "build_info", lambda: "it is lost")
    said = build_info.facts()
    refuse_what_no_table_says(["info", "--build"], said)
    assert said["kernel"].keys() == {"built", "reason", "advice"}


@pytest.mark.parametrize("name", REPORTS)
def test_the_schema_is_one_that_python_and_the_command_give(tmp_path, name):
    schema = package.schema(name)
    Draft202012Validator.check_schema(schema)
    assert json.loads(mbproj("schema", "--of", name, folder=tmp_path).stdout) == schema
    for _ in range(2):  # the second replaces the first, which is known as ours
        assert mbproj("schema", "--of", name, "-o", "of.json", folder=tmp_path).returncode == 0
    assert json.loads((tmp_path / "of.json").read_text()) == schema


def test_a_key_that_no_table_has_is_refused_and_so_is_a_report():
    with pytest.raises(ValidationError, match="Additional properties"):
        refuse_what_no_table_says(["run"], {"scene": "a", "output": "b", "status": "interrupted", "more": 1})
    with pytest.raises(ValidationError, match="'formulation' is a required property"):
        refuse_what_no_table_says(["run"], {"scene": "a", "output": "b", "status": "complete"})
    with pytest.raises(TypeError, match=r"no fact is called \['more'\]"):
        report_of(REPORTS["sweep"].facts, None, more=1)
    with pytest.raises(InputError, match="there is no schema of 'rum'"):
        package.schema("rum")


def test_facts_are_told_apart():
    for report in REPORTS.values():
        for facts in (report.facts, *(fact.fields for fact in all_of(report.facts))):
            assert len({fact.key for fact in facts}) == len(facts)
        for fact in all_of(report.facts):
            assert fact.words and {*re.split(r" \| | of | or ", fact.kind)} <= KINDS
            assert not fact.fields or "object" in fact.kind


def test_info_shows_attributes_with_their_units(folder):
    shown = mbproj("info", "verified.h5", folder=folder).stdout
    assert re.search(r"  integration_seconds +\S+ s\n", shown) and re.search(r"  energy_put_in +0 J\n", shown)
    assert re.search(r"  redundant_rows +0\n", shown)
