"""The tables of the reference are those of the code: `python scripts/write_reference.py` writes them again."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys

from mbproj.guide.pages import pages
from scripts.reference import program_tables, scene_tables
from tests.support import ROOT


def test_the_tables_are_as_the_code_is():
    script = [sys.executable, str(ROOT / "scripts" / "write_reference.py"), "--check"]
    done = subprocess.run(script, capture_output=True, text=True, check=False, env={"PYTHONPATH": str(ROOT)})
    assert (done.returncode, done.stdout) == (0, ""), done.stdout + done.stderr


def test_the_reference_holds_a_table_of_everything_that_can_be_chosen():
    text = "".join(page.text for page in pages().values() if page.kind == "reference")
    marked = re.findall(r"<!-- table: (\w+) -->", text)
    assert sorted(marked) == sorted(name for module in (scene_tables, program_tables) for name in tables_of(module))


def tables_of(module):
    """The functions of a module that make a table: they take nothing."""
    own = [value for value in vars(module).values() if getattr(value, "__module__", "") == module.__name__]
    return [each.__name__ for each in own if callable(each) and not inspect.signature(each).parameters]
