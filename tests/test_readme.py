"""What the README says: it is short, its mechanism and its Python example run as written, its links lead somewhere."""

from __future__ import annotations

import re

from mbproj.commands.main import COMMANDS
from tests.cli.commands import mbproj, python
from tests.support import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_it_is_short():
    assert len(README) <= 7000
    assert len(README.splitlines()) <= 150


def test_the_set_up_commands_are_what_ci_runs():
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in blocks("sh")[:2]:
        assert command in ci


def test_links_and_pictures_of_every_readme_are_there():
    for path in (ROOT / "README.md", *(ROOT / "mechanisms").rglob("README.md"), ROOT / "scripts" / "README.md"):
        for target in re.findall(r"\]\(([^)\s#]+)", path.read_text(encoding="utf-8")):
            assert target.startswith("http") or (path.parent / target).exists(), f"{path}: {target}"


def test_every_command_is_named():
    for command in COMMANDS:
        assert f"`{command}`" in README


def test_every_script_that_is_run_is_named():
    named = (ROOT / "scripts" / "README.md").read_text(encoding="utf-8")
    assert len(named.splitlines()) <= 150
    for path in (ROOT / "scripts").glob("*.py"):
        assert ("__main__" in path.read_text(encoding="utf-8")) == (f"`{path.name}" in named), path.name


def test_the_first_mechanism_runs_as_written(tmp_path, undrawn):
    (tmp_path / "swing.yaml").write_text(blocks("yaml")[0])
    checked = mbproj("check", "swing.yaml", folder=tmp_path)
    assert checked.returncode == 0, checked.stderr
    run = mbproj("run", "swing.yaml", "-o", "swing.h5", "--certify", folder=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert "14 coordinates, 10 constraints, 4 degrees of freedom" in run.stdout
    assert "2000 steps to t = 4 s" in run.stdout
    plots = mbproj("plot", "swing.h5", folder=tmp_path)
    assert plots.returncode == 0, plots.stderr
    assert (tmp_path / "swing-violation.png").exists()


def test_the_python_example_runs_as_written(tmp_path):
    code = blocks("python")[0].replace("mechanisms/", f"{ROOT}/mechanisms/")
    done = python(code, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Worst(value=" in done.stdout
