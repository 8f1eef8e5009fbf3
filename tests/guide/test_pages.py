"""The guide, its notebooks and the README: what they show is what mbproj does, and their links lead somewhere."""

from __future__ import annotations

import importlib
import inspect
import json
import re
from fnmatch import fnmatch
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

from mbproj.commands.main import COMMANDS
from mbproj.commands.main import mbproj as command_line
from mbproj.guide.pages import KINDS, WIDTH, page_of, pages, rendered, search
from mbproj.guide.pages import ROOT as GUIDE
from mbproj.scene.blocks.solids import SHAPES
from scripts.draw_guide import FIGURES, MEASURED
from scripts.reference import program_tables, scene_tables
from tests.cli.commands import mbproj, python, succeeds
from tests.crossed import where
from tests.guide.fences import fences, run_page
from tests.support import ROOT

shown = cache(rendered)
every_page = pytest.mark.parametrize("page", list(pages().values()), ids=list(pages()))


def is_quick(page):
    """Whether it starts mbproj or Python once at most."""
    blocks = [fence for fence in fences(page) if "slow" not in fence.words]
    commands = sum(fence.text.count("$ mbproj") for fence in blocks if fence.language == "console")
    return commands + sum(fence.language == "python" and not fence.words for fence in blocks) <= 1


@pytest.mark.parametrize(
    "page", where(lambda page: page.kind == "tutorial" or is_quick(page), pages().values()), ids=list(pages())
)
def test_what_a_page_shows_is_what_happens(page, tmp_path, undrawn):
    run_page(page, tmp_path)


@every_page
def test_links_lead_to_pages_headings_and_figures(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.text):
        if target.startswith("http"):
            continue
        name, _, anchor = target.partition("#")
        path = page.path.parent / name if name else page.path
        assert path.is_file(), f"{page.topic}: {target}"
        if anchor:
            headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
            assert anchor in anchors, f"{page.topic}: {target}"


@every_page
def test_a_page_begins_with_its_title_and_has_no_sentence_of_more_than_thirty_words(page):
    assert page.text.startswith("# ")
    prose = re.sub(r"^```.*?^```$|^\|.*$|^#.*$|`[^`]*`|\$[^$]*\$", " x ", page.text, flags=re.MULTILINE | re.DOTALL)
    for sentence in re.split(r"(?<=[.:!?;])\s+|\n\s*\n|\n\s*[-*] |\n\s*\d+\. ", prose):
        assert len(sentence.split()) <= 30, f"{page.topic}: {' '.join(sentence.split())}"


@every_page
def test_a_page_fits_a_terminal(page):
    longest = max(shown(page).splitlines(), key=len)
    assert len(longest) <= WIDTH, longest
    assert "…" not in shown(page), "a word without a space is cut in a narrow column"


@every_page
def test_words_in_tables_of_three_columns_stay_whole(page):
    words_shown = set(shown(page).split())
    for row in re.findall(r"^\|(?:[^|\n]+\|){2,3}$", page.text, re.MULTILINE):
        words = re.findall(r"(?<= )[a-z]{4,12}(?=[ ,;.])", re.sub(r"\[[^\]]*\]\([^)]*\)|\*[^*]*\*|`[^`]*`", "", row))
        assert all(any(word in each for each in words_shown) for word in words), (page.topic, row)


@every_page
def test_code_fits_a_terminal_without_being_broken(page):
    for fence in fences(page):
        for line in fence.text.splitlines():
            assert len(line) <= WIDTH - 2, f"{page.topic}: {line}"


def test_every_figure_is_drawn_by_the_script_named_by_a_page_and_small():
    drawn = {path.name for path in (GUIDE / "figures").glob("*.*")}
    named = {name for page in pages().values() for name in re.findall(r"\(\.\./figures/(\S+)\)", page.text)}
    assert named == drawn == {f"{name}.png" for name in (*FIGURES, *MEASURED)}
    assert max((GUIDE / "figures" / name).stat().st_size for name in drawn) < 100_000


def test_figures_are_installed():
    """The build takes every file of the package that neither git ignores nor `wheel.exclude` names."""
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    excluded = re.findall(r'"([^"]+)"', re.findall(r"^wheel.exclude = (.*)$", project, re.MULTILINE)[0])
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").split()
    for figure in FIGURES:
        path = f"mbproj/guide/figures/{figure}.png"
        assert not any(path.startswith(pattern) or fnmatch(path, pattern) for pattern in excluded)
        rules = [rule for rule in ignored if fnmatch(path, rule.removeprefix("!"))]
        assert rules[-1] == "!mbproj/guide/figures/*.png"


@every_page
def test_a_page_says_where_its_scenes_are(page):
    """Who installed mbproj has no checkout, and no folder `mechanisms`."""
    if any("mechanisms/" in fence.text for fence in fences(page)):
        assert "`mbproj examples --copy mechanisms`" in page.text


def test_every_shape_has_its_line():
    for shape in SHAPES:
        assert f"\n| `{shape}` | `{{{shape}: " in pages()["scene"].text


def test_topics_are_unique_and_every_kind_has_pages():
    assert len(pages()) == sum(1 for kind in KINDS for _ in (GUIDE / kind).glob("*.md"))
    assert {page.kind for page in pages().values()} == set(KINDS)


def test_no_block_is_without_a_known_language_and_a_page():
    assert all(fence.line for page in pages().values() for fence in fences(page))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_place_in_the_guide(name):
    hits = search([f"mbproj {name}"])
    assert hits, f"no page shows `mbproj {name}`"


def test_help_lists_every_topic_and_shows_each():
    contents = CliRunner().invoke(command_line, ["help"])
    assert contents.exit_code == 0
    for page in pages().values():
        assert f"  {page.topic} " in contents.output
    topic = next(iter(pages()))
    shown = CliRunner().invoke(command_line, ["help", topic])
    assert pages()[topic].title.split()[0] in shown.output


def test_a_search_names_the_pages_and_one_without_a_hit_says_so():
    found = CliRunner().invoke(command_line, ["help", "singular", "position"])
    assert found.exit_code == 0
    assert found.output.startswith("run_stops_at_a_singular_position: ")
    nothing = CliRunner().invoke(command_line, ["help", "zeppelin", "airship"])
    assert "no page of the guide has 'zeppelin' or 'airship'" in str(nothing.exception)


def test_a_search_that_no_section_answers_wholly_shows_the_nearest():
    found = CliRunner().invoke(command_line, ["help", "zeppelin", "baumgarte"])
    assert found.output.startswith("No section has all of these words; these have most of them:\n")
    assert "projection_methods: " in found.output


def test_a_hit_is_shown_as_text():
    for hit in [hit for words in (["rod"], ["gopm"], ["scene"]) for hit in search(words)]:
        assert not set("|`*") & set(hit.line), hit


#: What a reader looks for, and the page that answers.
QUESTIONS = {
    "completion": "complete_commands_in_a_shell",
    "does not close": "mechanism_does_not_close",
    "accuracy": "which_setting_for_an_accuracy",
    "trust": "how_far_to_trust_a_run",
    "too slow": "run_is_too_slow",
    "faster": "run_is_too_slow",
    "slider slot": "model_my_own_mechanism",
    "coupler": "couple_joints",
    "hydraulic cylinder": "drive_a_length",
    "tackle": "drive_a_length",
    "hoist": "run_a_rope_over_sheaves",
    "rack and pinion": "couple_joints",
    "pulley belt": "couple_joints",
    "cam": "follow_a_curve",
    "lift law": "follow_a_curve",
    "differential": "couple_joints",
    "geneva": "couple_joints",
    "tappet": "follow_a_curve",
    "crank": "model_my_own_mechanism",
    "CI": "run_mechanisms_in_ci",
    "jenkins": "run_mechanisms_in_ci",
    "excel": "keep_and_share_results",
    "csv": "keep_and_share_results",
    "repeat a run": "keep_and_share_results",
    "go on with a run": "continue_a_run",
    "long run": "record_a_long_run",
    "memory million samples": "record_a_long_run",
    "compression": "record_a_long_run",
    "units": "scene",
    "shape": "scene",
    "spring": "forces",
    "end stop": "stop_a_joint",
    "restitution": "stop_a_joint",
    "dry friction": "model_dry_friction",
    "brake": "model_dry_friction",
    "stick": "model_dry_friction",
    "motor": "motions",
    "reaction": "reactions_of_an_overconstrained_linkage",
    "redundant reactions": "reactions_of_an_overconstrained_linkage",
    "singular": "run_stops_at_a_singular_position",
    "python": "use_it_from_python",
    "compiler": "install_it",
    "template": "start_from_a_template",
    "compare methods paper": "compare_projection_methods",
    "method breaks": "find_where_a_method_breaks",
    "check mathematics": "check_the_mathematics",
    "animation": "see_it_move",
    "exit code": "json",
}


@pytest.mark.parametrize(("words", "topic"), QUESTIONS.items(), ids=QUESTIONS)
def test_a_question_finds_its_page_among_the_first_three(words, topic):
    assert topic in [hit.page.topic for hit in search(words.split())[:3]]


@every_page
def test_a_page_names_files_that_are_there(page):
    for path in re.findall(r"`((?:mbproj|scripts|tests)/[\w./-]*)`", page.text):
        assert (ROOT / path).exists(), path


@pytest.mark.parametrize("words", ["joints", "reference/joints", "joints/reference", "joints.md"])
def test_a_page_is_found_by_its_topic_and_kind(words):
    assert page_of([words]).topic == "joints"
    assert page_of(["joints/tutorial"]) is None


# The notebooks of the guide run from top to bottom, and what they say holds.

NOTEBOOKS = sorted((GUIDE / "notebooks").glob("*.ipynb"))
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
    done = CliRunner().invoke(
        command_line, ["examples", "--notebooks", str(tmp_path / "course")], catch_exceptions=False
    )
    assert done.exit_code == 0
    assert [Path(line).name for line in done.stdout.splitlines()] == [path.name for path in NOTEBOOKS]
    assert all((tmp_path / "course" / path.name).read_bytes() == path.read_bytes() for path in NOTEBOOKS)
    again = CliRunner().invoke(command_line, ["examples", "--notebooks", str(tmp_path / "course")])
    assert "has already designer.ipynb, researcher.ipynb, teacher.ipynb" in str(again.exception)


# The tables of the reference are those of the code: `python scripts/write_reference.py` writes them again.


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


# What the README says: it is short, its mechanism and its Python example run as written, its links lead somewhere.

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
    succeeds("check", "swing.yaml", folder=tmp_path)
    run = mbproj("run", "swing.yaml", "-o", "swing.h5", "--certify", folder=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert "14 coordinates, 10 constraints, 4 degrees of freedom" in run.stdout
    assert "2000 steps to t = 4 s" in run.stdout
    succeeds("plot", "swing.h5", folder=tmp_path)
    assert (tmp_path / "swing-violation.png").exists()


def test_the_python_example_runs_as_written(tmp_path):
    code = blocks("python")[0].replace("mechanisms/", f"{ROOT}/mechanisms/")
    done = python(code, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Worst(value=" in done.stdout
