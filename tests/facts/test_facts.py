"""The table of facts: each is said under its condition, and nothing else is. `tests/mechanisms/test_every_command.py`
holds all mechanisms against it."""

from __future__ import annotations

import json
import re

import pytest
from jsonschema import Draft202012Validator, ValidationError

import mbproj as package
from mbproj.errors import InputError
from mbproj.facts import ALWAYS, COMPLETE
from mbproj.facts.schema import REPORTS
from tests.cli.commands import FIVE_BAR, mbproj
from tests.facts.reports import refuse_what_no_table_says
from tests.ropes.scenes import LOAD, UP, scene
from tests.support import ROOT

KINDS = {"string", "number", "integer", "boolean", "array", "object", "null"}
FIVE = (FIVE_BAR, "--duration", "0.05")
#: A command for each report and condition.
SAID: dict[tuple[str, str], tuple[object, ...]] = {
    ("run", ALWAYS): ("run", *FIVE),
    ("run", COMPLETE): ("run", *FIVE),
    ("run", "with --energy-row or --momentum-row"): ("run", *FIVE, "--energy-row", "true"),
    ("run", "with --accuracy"): ("run", *FIVE, "--accuracy", "1e-3"),
    ("run", "with --certify"): ("run", *FIVE, "--certify"),
    ("run", "where the scene has dry friction"): (
        "run",
        ROOT / "mechanisms" / "stick_slip.yaml",
        "--duration",
        "0.01",
    ),
    ("run", "where a rope pushes"): ("run", "pushing.yaml"),
    ("info", ALWAYS): ("info", "results.h5"),
    ("info", "where the file has samples"): ("info", "results.h5"),
    ("info", "after run --certify"): ("info", "certified.h5"),
    ("info", "after verify --store"): ("info", "verified.h5"),
    ("check", ALWAYS): ("check", FIVE_BAR),
    ("build", ALWAYS): ("info", "--build"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With a scene whose rope pushes, and results of each kind."""
    made = tmp_path_factory.mktemp("facts")
    (made / "pushing.yaml").write_text(scene(LOAD + UP, duration=0.3).replace("20 ms", "0.5 ms"))
    for options in ((), ("--certify", "-o", "certified.h5"), ("-o", "verified.h5")):
        assert mbproj("run", *FIVE, "-q", *options, folder=made).returncode == 0
    assert mbproj("verify", *FIVE, "--store", "verified.h5", folder=made).returncode == 0
    return made


def test_every_condition_is_tried():
    assert set(SAID) == {(name, fact.when) for name, (_, facts) in REPORTS.items() for fact in facts}


@pytest.mark.parametrize(("name", "when"), SAID)
def test_each_fact_is_said_under_its_condition(folder, name, when):
    words = [str(word) for word in SAID[name, when]]
    done = mbproj(*words, "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    refuse_what_no_table_says(words, printed)
    assert {fact.key for fact in REPORTS[name][1] if fact.when == when} <= printed.keys()


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
    with pytest.raises(InputError, match="there is no schema of 'rum'"):
        package.schema("rum")


def test_facts_are_told_apart():
    for _, facts in REPORTS.values():
        assert len({fact.key for fact in facts}) == len(facts)
        assert all(fact.words and set(fact.kind.split(" | ")) <= KINDS for fact in facts)


def test_info_shows_attributes_with_their_units(folder):
    shown = mbproj("info", "results.h5", folder=folder).stdout
    assert re.search(r"  integration_seconds +\S+ s\n", shown) and re.search(r"  energy_put_in +0 J\n", shown)
    assert re.search(r"  redundant_rows +0\n", shown)
