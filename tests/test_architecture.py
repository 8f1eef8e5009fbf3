"""The order of the house: what may import and include what, what imports cost, how large a folder and a file may be."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from mbproj.base.registry import load
from tests.support import ROOT

PACKAGE = ROOT / "mbproj"
KERNEL = PACKAGE / "kernel" / "src"
#: Imported by everybody; they import nothing of ours but each other.
LEAVES = {
    "arrays",
    "dataclass",
    "errors",
    "control_characters",
    "report_schema",
    "mechanisms_folder",
    "plugins",
    "registry",
    "settings",
    "sandbox",
    "thresholds",
}
LEAVES |= {"cases", "plain_number", "plugins", "version"}
#: What each package may import beside itself and the leaves.
MAY_IMPORT = {
    "constraints": set(),
    "output_files": set(),
    "thresholds": set(),
    "report_schema": set(),
    "kernel": {"constraints", "functions", "model"},
    "joints": {"constraints", "functions"},
    "functions": set(),
    "elements": {"functions"},
    "scene": {"functions", "elements", "joints"},
    "model": {"constraints", "functions", "elements", "joints", "scene"},
    "dynamics": {"constraints", "functions", "joints", "scene", "model", "kernel"},
    "projection": {"scene", "model", "dynamics"},
    "integrate": {"functions", "scene", "model", "dynamics", "projection", "kernel"},
    "results": {"output_files", "scene"},
    "analysis": {"results", "scene"},
    "linear": {"functions", "scene", "model", "dynamics", "integrate", "output_files", "results"},
    "runs": {"analysis", "dynamics", "integrate", "linear", "model", "results", "scene"},
    "templates": {"scene"},
    "formats": {"functions", "elements", "joints", "scene", "model", "dynamics", "linear"},
    "guide": set(),
    "parts": {"functions", "joints", "scene"},
    "studies": {
        "linear",
        "elements",
        "functions",
        "joints",
        "scene",
        "model",
        "dynamics",
        "projection",
        "integrate",
        "kernel",
        "output_files",
        "results",
        "analysis",
        "runs",
    },
    "api": {
        "analysis",
        "dynamics",
        "figures",
        "formats",
        "integrate",
        "kernel",
        "linear",
        "model",
        "output_files",
        "pages",
        "results",
        "runs",
        "scene",
        "studies",
        "templates",
    },
    "pages": {"functions", "joints", "scene", "model", "dynamics", "results", "analysis"},
    "figures": {"output_files", "results", "analysis", "scene", "pages"},
    "cli": {
        "guide",
        "joints",
        "scene",
        "model",
        "dynamics",
        "integrate",
        "kernel",
        "output_files",
        "results",
        "analysis",
        "linear",
        "runs",
        "studies",
        "api",
        "pages",
        "figures",
        "templates",
        "formats",
    },
}
#: The folders of the packages that have some: each imports only those that stand before it.
FOLDERS = {
    "constraints": ("curves",),
    "functions": ("curves",),
    "scene": ("text", "expressions", "fields", "ranges", "solids", "blocks"),
    "model": ("compile", "planar"),
    "dynamics": ("equations", "derivatives", "assembly", "observe", "rank", "friction", "contact"),
    "integrate": ("steppers", "events", "reporting", "formulations", "stops", "stiff", "automatic"),
    "results": ("file", "loads", "crash_safety", "linear", "sweep", "views"),
    "studies": (
        "store",
        "parallel",
        "measure",
        "cases",
        "variants",
        "sweep",
        "certify",
        "compare",
        "recommend",
        "stability",
        "tradeoff",
        "verify",
        "inverse",
        "design",
        "synthesis",
    ),
    "formats": ("mjcf", "urdf", "sdf", "export"),
    "analysis": ("contacts",),
    "linear": ("reduction", "equilibrium", "state_space"),
    "pages": ("appearance", "data", "page"),
    "figures": ("pages", "kinds", "sweeps"),
    "api": ("check",),
    "cli": ("report", "simulate", "studies", "linear", "design", "watch", "commands"),
}
#: The kernel's folders: a header includes only headers of its own folder and of those that stand before it.
KERNEL_FOLDERS = (
    "algebra",
    "model",
    "kinematics",
    "elimination",
    "loops",
    "dynamics",
    "projection",
    "steppers",
    "laws",
    "contacts",
    "stepping",
    "tangents",
    "bindings",
)

FEWEST_LINES = 25
#: Files of the package that may be shorter, and why.
SHORT_FILES = {
    "control_characters.py": "a rule of safety, imported alone",
    "plain_number.py": "a rule for all readers of numbers",
    "base/thresholds.py": "the form of an entry, which all groups of them import",
    "scene/expressions/compiled.py": "formulas as functions, which types of force import",
    "scene/fields/quantities.py": "what the command line needs of the fields",
    "scene/schema.py": "imported alone, by `mbproj schema`",
    "studies/parallel/progress.py": "the words for progress, without what runs",
    "version.py": "read by the build",
}
#: Folders of which a file may be shorter: each is an entry.
SHORT_IN = frozenset({"scene/blocks/elements"})


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def headers() -> list[Path]:
    return sorted(KERNEL.rglob("*.?pp"))


@cache
def imports(path: Path) -> set[str]:
    """The modules of ours, and names in them, that a module imports at run time, at any depth of its code; and those
    that it names as "module:name", to be imported when they are first used."""
    text = path.read_text(encoding="utf-8")
    found = {name.replace(":", ".") for name in NAMED.findall(text)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name for name in found if name.startswith("mbproj.")}


#: How a table names what is imported when it is first used: "module:name".
NAMED = re.compile(r'"(mbproj(?:\.\w+)+:\w+)"')


def test_what_a_table_names_exists():
    for path in modules():
        for where in NAMED.findall(path.read_text(encoding="utf-8")):
            assert load(where) is not None, where


def includes(path: Path) -> set[str]:
    """The headers of ours that a file of the kernel includes."""
    return set(re.findall(r'^#include "(.*)"$', path.read_text(encoding="utf-8"), re.M))


@pytest.mark.parametrize("package", sorted(MAY_IMPORT))
def test_dependencies_point_one_way(package):
    for path in (PACKAGE / package).rglob("*.py"):
        foreign = {name.split(".")[1] for name in imports(path)} - {package} - LEAVES
        assert foreign <= MAY_IMPORT[package], f"{path.relative_to(ROOT)} imports {foreign - MAY_IMPORT[package]}"


def test_every_package_has_its_place_in_the_order():
    packages = {path.parent.relative_to(PACKAGE).parts[0] for path in PACKAGE.glob("*/*.py")}
    assert packages == set(MAY_IMPORT)
    TopologicalSorter(MAY_IMPORT).prepare()


def test_the_guide_lists_every_package_after_what_it_imports():
    page = (PACKAGE / "guide" / "explanation" / "contributing.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`.*`) \|", page.split("## The house")[1].split("##")[0], re.MULTILINE)
    listed = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert sorted(listed) == sorted(MAY_IMPORT)
    for package, others in MAY_IMPORT.items():
        assert {name for name in others if listed.index(name) > listed.index(package)} == set(), package


def test_every_folder_has_its_place_in_the_order_of_its_package():
    found = {(path.parent.parent.name, path.parent.name) for path in PACKAGE.glob("*/*/__init__.py")}
    assert found == {(package, folder) for package, folders in FOLDERS.items() for folder in folders}


@pytest.mark.parametrize("package", sorted(FOLDERS))
def test_folders_import_only_what_stands_before_them(package):
    order = FOLDERS[package]
    for path in sorted((PACKAGE / package).glob("*/**/*.py")):
        place = order.index(path.relative_to(PACKAGE / package).parts[0])
        for name in imports(path):
            _, top, inner, *_ = [*name.split("."), ""]
            if top == package and inner in order:
                assert order.index(inner) <= place, f"{path.relative_to(ROOT)} imports {name}"


@pytest.mark.parametrize("package", sorted(MAY_IMPORT))
def test_no_circle_of_imports_inside_a_package(package):
    """Its folders, and the modules beside them, are the nodes; its `__init__` may import them all."""
    graph: dict[str, set[str]] = {}
    for path in (PACKAGE / package).rglob("*.py"):
        node = path.relative_to(PACKAGE / package).with_suffix("").parts[0]
        of_ours = {name.split(".")[2] for name in imports(path) if name.startswith(f"mbproj.{package}.")}
        if node != "__init__":
            graph.setdefault(node, set()).update(of_ours - {node})
    TopologicalSorter(graph).prepare()  # raises CycleError, with the circle


def test_headers_include_nothing_from_above():
    for path in headers():
        folder = path.relative_to(KERNEL).parts[0]
        for header in includes(path):
            assert (KERNEL / header).is_file(), f"{path.relative_to(ROOT)} includes {header}"
            below = KERNEL_FOLDERS.index(header.split("/")[0]) <= KERNEL_FOLDERS.index(folder)
            assert below, f"{path.relative_to(ROOT)} includes {header}"


def test_no_circle_of_includes():
    TopologicalSorter({path.relative_to(KERNEL).as_posix(): includes(path) for path in headers()}).prepare()


def test_every_folder_of_the_kernel_is_described():
    readme = (PACKAGE / "kernel" / "README.md").read_text(encoding="utf-8")
    assert {path.relative_to(KERNEL).parts[0] for path in headers()} == set(KERNEL_FOLDERS)
    assert {folder for folder in KERNEL_FOLDERS if f"`{folder}`" not in readme} == set()


def test_every_folder_opens_with_a_sentence_on_what_is_inside():
    for folder in {path.parent for path in modules()}:
        sentence = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
        assert re.match(r"\w.{19,}?[.:;]", sentence, re.S), folder


def test_no_file_of_the_package_is_a_crumb():
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    short = {path for path, count in lines.items() if count < FEWEST_LINES}
    named = [path.relative_to(PACKAGE) for path in short if path.name != "__init__.py"]
    assert {path.as_posix() for path in named if path.parent.as_posix() not in SHORT_IN} == set(SHORT_FILES)


def test_only_figures_imports_matplotlib():
    for path in modules():
        text = path.read_text(encoding="utf-8")
        if "figures" not in path.parts:
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
        "import mbproj.results\n"
        "scene = read_scene('mechanisms/five_bar.yaml', {}, {'duration': '0.02'})\nsystem = compile_system(scene)\n"
        "simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene))"
    )
    imported = imported_by(code)
    assert not imported & {"scipy", "matplotlib"}
    for name in ("stops", "automatic", "formulations.full", "numpy_loop"):  # what this scene has no use for
        assert f"mbproj.motion.{name}" not in imported
    assert not imported & {"mbproj.equations.derivatives", "mbproj.equations.friction", "mbproj.motion.projection"}


#: The most modules of ours that a run of the five-bar imports: a scene pays only for what it contains.
MOST_IN_A_RUN = 180


def test_a_run_passes_few_modules(tmp_path):
    run = f"mbproj(['run', 'mechanisms/five_bar.yaml', '-o', {str(tmp_path / 'results.h5')!r}])"
    code = f"from mbproj.commands.main import mbproj\ntry: {run}\nexcept SystemExit as end: assert not end.code"
    ours = {name for name in imported_by(code) if name.partition(".")[0] == "mbproj"}
    assert len(ours) <= MOST_IN_A_RUN


def test_help_and_the_package_itself_import_no_numbers():
    help_text = "from mbproj.commands.main import mbproj\ntry: mbproj(['--help'])\nexcept SystemExit: pass"
    for code in ("import mbproj", "import mbproj.scene", help_text):
        assert not imported_by(code) & {"numpy", "h5py", "scipy", "matplotlib"}


def test_public_names_exist():
    import mbproj

    for name in mbproj.__all__:
        assert getattr(mbproj, name) is not None
    with pytest.raises(AttributeError, match="module 'mbproj' has no attribute 'simulat'"):
        _ = mbproj.simulat


def test_the_stub_has_the_public_names_in_their_modules():
    import mbproj
    import mbproj.parts

    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    found = {
        node.module: {alias.name for alias in node.names} for node in stub.body if isinstance(node, ast.ImportFrom)
    }
    assert (found.pop("collections.abc"), found.pop("mbproj.base.version")) == ({"Mapping"}, {"__version__"})
    assert found.pop("mbproj.scene.parts") == {"*"}
    homes = {module: set(names.split()) for module, names in mbproj.HOMES.items()}
    assert homes.pop("mbproj.scene.parts") == set(mbproj.scene.parts.__all__)
    assert found == homes
