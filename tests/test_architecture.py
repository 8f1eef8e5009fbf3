"""The order of the house: what may import and include what, what imports cost, how large the house is."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from mbproj.base.registry import load
from tests.support import ROOT

PACKAGE = ROOT / "mbproj"
KERNEL = PACKAGE / "kernel" / "src"
#: The rooms from the bottom to the top: each imports only rooms that stand before it.
ROOMS = (
    "base",
    "functions",
    "joints",
    "scene",
    "results",
    "model",
    "equations",
    "kernel",
    "motion",
    "linear",
    "studies",
    "formats",
    "show",
    "guide",
    "commands",
)
#: The rooms of the kernel, in this order as well.
KERNEL_ROOMS = ("model", "kinematics", "solver", "contact", "step", "bind")
#: The most floors of the house, entries at its top, folders, and files of Python and C++.
FLOORS, ENTRIES, FOLDERS, FILES = 10, 18, 65, 650

FEWEST_LINES = 25
#: Files of the package that may be shorter, and why.
SHORT_FILES = {
    "base/version.py": "read by the build",
    "scene/schema.py": "imported alone, by `mbproj schema`",
    "studies/parallel/progress.py": "the words for progress, without what runs",
}


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def headers() -> list[Path]:
    return sorted(KERNEL.rglob("*.?pp"))


#: How a table names what is imported when it is first used: "module:name".
NAMED = re.compile(r'"(mbproj(?:\.\w+)+:\w+)"')


@cache
def graph() -> Mapping[str, frozenset[str]]:
    """The modules that each module imports: at any depth of its code, or named as "module:name" to be imported when it
    is first used. Imports for type checkers alone are none."""
    known = {name_of(path): path for path in modules()}
    return {name: frozenset(_imports(path, known)) - {name, "mbproj"} for name, path in known.items()}


def _imports(path: Path, known: Mapping[str, Path]) -> Iterator[str]:
    text = path.read_text(encoding="utf-8")
    for name in (*_written(ast.parse(text)), *(named.partition(":")[0] for named in NAMED.findall(text))):
        while name and name not in known:
            name = name.rpartition(".")[0]
        if name:
            yield name


def _written(node: ast.AST) -> Iterator[str]:
    """The names of ours that the code below a node imports."""
    if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        return
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name.startswith("mbproj"))
    elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "mbproj":
        yield from (f"{node.module}.{alias.name}" for alias in node.names)
    for child in ast.iter_child_nodes(node):
        yield from _written(child)


def test_what_a_table_names_exists():
    for path in modules():
        for where in NAMED.findall(path.read_text(encoding="utf-8")):
            assert load(where) is not None, where


def test_the_rooms_are_those_of_the_list():
    assert {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()} == set(ROOMS)


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_those_below_it(room):
    below = ROOMS[: ROOMS.index(room) + 1]
    for name, imported in graph().items():
        if name.split(".")[1:2] == [room]:
            assert {other for other in imported if other.split(".")[1] not in below} == set(), name


def test_no_circle_of_modules():
    TopologicalSorter(graph()).prepare()  # raises CycleError, with the circle


def test_the_house_has_few_floors():
    rooms: dict[str, set[str]] = {room: set() for room in ROOMS}
    for name, imported in graph().items():
        room = name.partition(".")[2].partition(".")[0]
        if room in rooms:
            rooms[room] |= {other.split(".")[1] for other in imported} - {room}
    floor: dict[str, int] = {}
    for room in TopologicalSorter(rooms).static_order():
        floor[room] = 1 + max((floor[other] for other in rooms[room]), default=0)
    assert max(floor.values()) <= FLOORS, floor


def test_the_house_is_small():
    entries = [path for path in PACKAGE.iterdir() if path.name not in ("__pycache__", "mechanisms")]
    folders = [path for path in (PACKAGE, *PACKAGE.rglob("*")) if path.is_dir() and path.name != "__pycache__"]
    assert len(entries) <= ENTRIES, sorted(path.name for path in entries)
    assert len(folders) <= FOLDERS, len(folders)
    assert len(modules()) + len(headers()) <= FILES


def test_nothing_of_ours_is_imported_by_name():
    """`load` takes what a table names, which the graph sees; a name that is put together would hide from it."""
    for path in modules():
        text = path.read_text(encoding="utf-8")
        for call in re.findall(r"\b(?:import_module|__import__)\((.*)", text):
            assert "mbproj" not in call, f"{path.relative_to(ROOT)}: {call}"
        for call in re.findall(r"\bload\(f\"(.*)", text):
            assert path.relative_to(PACKAGE).as_posix() == "commands/main.py", call  # a command, by its own name


def test_the_guide_draws_every_room_above_what_it_imports():
    page = (PACKAGE / "guide" / "explanation" / "contributing.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*`) \|", page.split("## The house")[1].split("##")[0], re.MULTILINE)
    assert tuple(name for row in rows for name in re.findall(r"`(\w+)`", row)) == ROOMS


def includes(path: Path) -> set[str]:
    """The headers of ours that a file of the kernel includes."""
    return set(re.findall(r'^#include "(.*)"$', path.read_text(encoding="utf-8"), re.M))


def test_headers_include_nothing_from_above():
    for path in headers():
        room = path.relative_to(KERNEL).parts[0]
        for header in includes(path):
            assert (KERNEL / header).is_file(), f"{path.relative_to(ROOT)} includes {header}"
            below = KERNEL_ROOMS.index(header.split("/")[0]) <= KERNEL_ROOMS.index(room)
            assert below, f"{path.relative_to(ROOT)} includes {header}"


def test_what_comments_of_the_kernel_name_exists():
    """A reference in Python, written as mbproj.room.module or with a name of it."""
    known = {name_of(path): path for path in modules()}
    for path in headers():
        for where in re.findall(r"\bmbproj(?:\.\w+)+", path.read_text(encoding="utf-8")):
            module, _, name = where.rpartition(".")
            is_name = module in known and re.search(rf"\b{name}\b", known[module].read_text(encoding="utf-8"))
            assert where in known or is_name, f"{path.relative_to(ROOT)} names {where}"


def test_no_circle_of_includes():
    TopologicalSorter({path.relative_to(KERNEL).as_posix(): includes(path) for path in headers()}).prepare()


def test_every_room_of_the_kernel_is_described():
    readme = (PACKAGE / "kernel" / "README.md").read_text(encoding="utf-8")
    assert {path.relative_to(KERNEL).parts[0] for path in headers()} == set(KERNEL_ROOMS)
    assert {room for room in KERNEL_ROOMS if f"`{room}`" not in readme} == set()


def test_every_folder_opens_with_a_sentence_on_what_is_inside():
    for folder in {path.parent for path in modules()}:
        sentence = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
        assert re.match(r"\w.{19,}?[.:;]", sentence, re.S), folder


def test_no_file_of_the_package_is_a_crumb():
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    short = {path for path, count in lines.items() if count < FEWEST_LINES and path.name != "__init__.py"}
    assert {path.relative_to(PACKAGE).as_posix() for path in short} == set(SHORT_FILES)


def test_only_show_imports_matplotlib():
    for path in modules():
        text = path.read_text(encoding="utf-8")
        if "show" not in path.parts:
            assert "import matplotlib" not in text, path
            assert "\nfrom matplotlib" not in text, path


def imported_by(code: str) -> set[str]:
    """The modules, and the packages that they are in, that are loaded after running `code` in a fresh interpreter."""
    script = f"{code}\nimport sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.split())


def test_running_imports_neither_scipy_nor_matplotlib():
    code = (
        "from mbproj import assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate\n"
        "import mbproj.results.reader\n"
        "scene = read_scene('mechanisms/five_bar.yaml', {}, {'duration': '0.02'})\nsystem = compile_system(scene)\n"
        "simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene))"
    )
    imported = imported_by(code)
    assert not imported & {"scipy", "matplotlib"}
    for name in ("contacts", "automatic", "formulations.full", "numpy_loop", "projection"):  # no use for this scene
        assert f"mbproj.motion.{name}" not in imported
    assert not imported & {"mbproj.equations.derivatives", "mbproj.equations.friction", "mbproj.equations.contacts"}


#: The most modules of ours that a run of the five-bar imports: a scene pays only for what it contains.
MOST_IN_A_RUN = 140


def test_a_run_passes_few_modules(tmp_path):
    run = f"mbproj(['run', 'mechanisms/five_bar.yaml', '-o', {str(tmp_path / 'results.h5')!r}])"
    code = f"from mbproj.commands.main import mbproj\ntry: {run}\nexcept SystemExit as end: assert not end.code"
    ours = {name for name in imported_by(code) if name.partition(".")[0] == "mbproj"}
    assert len(ours) <= MOST_IN_A_RUN


def test_help_and_the_package_itself_import_no_numbers():
    help_text = "from mbproj.commands.main import mbproj\ntry: mbproj(['--help'])\nexcept SystemExit: pass"
    for code in ("import mbproj", "import mbproj.scene.records", help_text):
        assert not imported_by(code) & {"numpy", "h5py", "scipy", "matplotlib"}


def test_public_names_exist():
    import mbproj

    for name in mbproj.__all__:
        assert getattr(mbproj, name) is not None
    with pytest.raises(AttributeError, match="module 'mbproj' has no attribute 'simulat'"):
        _ = mbproj.simulat


def test_type_checkers_see_the_public_names_in_their_modules():
    import mbproj

    module = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    seen = next(node for node in module.body if isinstance(node, ast.If))
    imports = [node for node in seen.body if isinstance(node, ast.ImportFrom)]
    found = {node.module: {alias.name for alias in node.names} for node in imports}
    assert found.pop("mbproj.scene.parts") == {"*"}
    assert found == {module: set(names.split()) for module, names in mbproj.HOMES.items()}
