"""The order of the house: which package may import which, what imports cost, and how long a file may be."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

PACKAGE = ROOT / "mbproj"
#: Imported by everybody; they import nothing of ours but each other.
LEAVES = {"arrays", "ending", "errors", "registry", "rehearsal", "mechanisms_folder", "version"}
#: What each package may import beside itself and the leaves.
MAY_IMPORT = {
    "constraints": set(),
    "outputs": set(),
    "kernel": {"constraints", "functions", "model"},
    "joints": {"constraints"},
    "functions": set(),
    "scene": {"functions", "joints"},
    "model": {"constraints", "functions", "joints", "scene"},
    "dynamics": {"constraints", "functions", "joints", "scene", "model"},
    "projection": {"scene", "model", "dynamics"},
    "integrate": {"scene", "model", "dynamics", "projection", "kernel"},
    "results": {"outputs", "scene"},
    "analysis": {"results", "scene"},
    "templates": {"scene"},
    "studies": {"functions", "joints", "scene", "model", "dynamics", "projection", "integrate", "kernel", "outputs",
                "results", "analysis"},
    "plot": {"outputs", "results", "analysis", "scene"},
    "cli": {"joints", "scene", "model", "dynamics", "integrate", "kernel", "outputs", "results", "analysis", "studies",
            "plot", "templates"},
}


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def imports(path: Path) -> set[str]:
    """The packages of ours that a module imports at run time, at any depth of its code."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        found |= {name.split(".")[1] for name in names if name.startswith("mbproj.")}
    return found


@pytest.mark.parametrize("package", sorted(MAY_IMPORT))
def test_dependencies_point_one_way(package):
    for path in (PACKAGE / package).rglob("*.py"):
        foreign = imports(path) - {package} - LEAVES
        assert foreign <= MAY_IMPORT[package], f"{path.relative_to(ROOT)} imports {foreign - MAY_IMPORT[package]}"


def test_every_package_has_its_place_in_the_order():
    packages = {path.parent.relative_to(PACKAGE).parts[0] for path in PACKAGE.glob("*/*.py")}
    assert packages == set(MAY_IMPORT)


def test_only_plot_imports_matplotlib():
    for path in modules():
        text = path.read_text(encoding="utf-8")
        if "plot" not in path.parts:
            assert "import matplotlib" not in text, path
            assert "\nfrom matplotlib" not in text, path


def imported_by(code: str) -> set[str]:
    """The top-level modules that are loaded after running `code` in a fresh interpreter."""
    script = f"{code}\nimport sys; print(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.split())


def test_running_imports_neither_scipy_nor_matplotlib():
    code = (
        "from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate\n"
        "import mbproj.results\n"
        "scene = read_scene('mechanisms/five_bar.yaml', {}, {'duration': '0.02'})\nsystem = compile_system(scene)\n"
        "simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene))"
    )
    assert not imported_by(code) & {"scipy", "matplotlib"}


def test_help_and_the_package_itself_import_no_numbers():
    help_text = "from mbproj.cli.main import mbproj\ntry: mbproj(['--help'])\nexcept SystemExit: pass"
    for code in ("import mbproj", "import mbproj.scene", help_text):
        assert not imported_by(code) & {"numpy", "h5py", "scipy", "matplotlib"}


def test_tests_import_no_tests_and_skip_nothing_that_they_find_out():
    """What tests share stands in modules of its own. A test is skipped by a mark, for what the machine has: one that
    skips itself where its own numbers do not suit passes when nothing suits any more."""
    for path in sorted((ROOT / "tests").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"(from|import)\s+tests(\.\w+)*[.\s]+(import\s+)?test_\w+", text), path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "skip":
                assert not isinstance(node.func.value, ast.Name), f"{path}:{node.lineno}"


def test_files_are_short():
    long = {str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    assert {name: lines for name, lines in long.items() if lines > 300} == {}


def test_public_names_exist():
    import mbproj

    for name in mbproj.__all__:
        assert getattr(mbproj, name) is not None
    with pytest.raises(AttributeError, match="module 'mbproj' has no attribute 'simulat'"):
        _ = mbproj.simulat
