"""The tables of the reference are those of the code: `python scripts/write_reference.py` writes them again."""

from __future__ import annotations

import importlib
import inspect
import re

from mbproj.guide.pages import pages
from scripts.reference import program_tables, scene_tables
from tests.support import ROOT


def test_the_tables_are_as_the_code_is(monkeypatch, capsys):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    write_reference = importlib.import_module("write_reference")
    monkeypatch.setattr("sys.argv", ["write_reference.py", "--check"])
    assert (write_reference.main(), capsys.readouterr().out) == (0, "")


def test_the_reference_holds_a_table_of_everything_that_can_be_chosen():
    text = "".join(page.text for page in pages().values() if page.kind == "reference")
    marked = re.findall(r"<!-- table: (\w+) -->", text)
    assert sorted(marked) == sorted(name for module in (scene_tables, program_tables) for name in tables_of(module))


def tables_of(module):
    """The functions of a module that make a table: they take nothing."""
    own = [value for value in vars(module).values() if getattr(value, "__module__", "") == module.__name__]
    return [each.__name__ for each in own if callable(each) and not inspect.signature(each).parameters]
