"""The notebooks of the guide run from top to bottom, and what they say holds."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

from mbproj.commands.main import mbproj
from mbproj.guide.pages import ROOT

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
NEEDED = ("nbclient", "ipykernel", "pandas", "scipy")
MISSING = ", ".join(name for name in NEEDED if find_spec(name) is None)
#: What a cell of each prints, and how many of its cells show a table, a picture or a page.
SAID = {
    "teacher": (("degrees of freedom 1", "rank 20"), {"text/html": 3, "image/png": 2}),
    "researcher": (
        ("of order 0, not 4: a condition of order 1 is missed by 0.018", "right to 1e-06 m", "right to 0.001 m"),
        {"text/html": 2, "image/png": 1},
    ),
    "designer": (("the rate is 1344 N/m", "fastest"), {"text/html": 3, "image/png": 2}),
}
each = pytest.mark.parametrize("path", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])


def test_there_is_one_for_each_reader():
    assert {path.stem for path in NOTEBOOKS} == set(SAID)


@each
def test_a_notebook_holds_no_results(path):
    """They are made where it runs."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert cells[0]["cell_type"] == "markdown"
    for cell in cells:
        assert not cell.get("outputs") and cell.get("execution_count") is None
        assert all(len(line.rstrip()) <= 140 for line in cell["source"])


@pytest.mark.full
@pytest.mark.long
@pytest.mark.skipif(bool(MISSING), reason=f"needs {MISSING}")
@each
def test_a_notebook_runs(path, tmp_path):
    """In some seconds, in an empty folder."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    said, shown = SAID[path.stem]
    printed = "".join(output.get("text", "") for output in outputs)
    assert all(part in printed for part in said)
    for kind, count in shown.items():
        assert sum(kind in output.get("data", {}) for output in outputs) >= count


def test_notebooks_are_copied_on_demand(tmp_path):
    done = CliRunner().invoke(mbproj, ["examples", "--notebooks", str(tmp_path / "course")], catch_exceptions=False)
    assert done.exit_code == 0
    assert [Path(line).name for line in done.stdout.splitlines()] == [path.name for path in NOTEBOOKS]
    assert all((tmp_path / "course" / path.name).read_bytes() == path.read_bytes() for path in NOTEBOOKS)
    again = CliRunner().invoke(mbproj, ["examples", "--notebooks", str(tmp_path / "course")])
    assert "has already designer.ipynb, researcher.ipynb, teacher.ipynb" in str(again.exception)
