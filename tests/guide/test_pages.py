"""The guide: what its pages show is what mbproj does, its links lead somewhere, and it names all that there is."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from functools import cache

import pytest
from click.testing import CliRunner

from mbproj.commands.main import COMMANDS, mbproj
from mbproj.guide.pages import KINDS, ROOT, WIDTH, page_of, pages, rendered, search
from mbproj.scene.blocks.solids import SHAPES
from scripts.draw_guide import FIGURES, MEASURED
from tests.crossed import where
from tests.guide.fences import fences, run_page
from tests.support import ROOT as CHECKOUT

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
    drawn = {path.name for path in (ROOT / "figures").glob("*.*")}
    named = {name for page in pages().values() for name in re.findall(r"\(\.\./figures/(\S+)\)", page.text)}
    assert named == drawn == {f"{name}.png" for name in (*FIGURES, *MEASURED)}
    assert max((ROOT / "figures" / name).stat().st_size for name in drawn) < 100_000


def test_figures_are_installed():
    """The build takes every file of the package that neither git ignores nor `wheel.exclude` names."""
    project = (CHECKOUT / "pyproject.toml").read_text(encoding="utf-8")
    excluded = re.findall(r'"([^"]+)"', re.findall(r"^wheel.exclude = (.*)$", project, re.MULTILINE)[0])
    ignored = (CHECKOUT / ".gitignore").read_text(encoding="utf-8").split()
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
    assert len(pages()) == sum(1 for kind in KINDS for _ in (ROOT / kind).glob("*.md"))
    assert {page.kind for page in pages().values()} == set(KINDS)


def test_no_block_is_without_a_known_language_and_a_page():
    assert all(fence.line for page in pages().values() for fence in fences(page))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_place_in_the_guide(name):
    hits = search([f"mbproj {name}"])
    assert hits, f"no page shows `mbproj {name}`"


def test_help_lists_every_topic_and_shows_each():
    contents = CliRunner().invoke(mbproj, ["help"])
    assert contents.exit_code == 0
    for page in pages().values():
        assert f"  {page.topic} " in contents.output
    topic = next(iter(pages()))
    shown = CliRunner().invoke(mbproj, ["help", topic])
    assert pages()[topic].title.split()[0] in shown.output


def test_a_search_names_the_pages_and_one_without_a_hit_says_so():
    found = CliRunner().invoke(mbproj, ["help", "singular", "position"])
    assert found.exit_code == 0
    assert found.output.startswith("run_stops_at_a_singular_position: ")
    nothing = CliRunner().invoke(mbproj, ["help", "zeppelin", "airship"])
    assert "no page of the guide has 'zeppelin' or 'airship'" in str(nothing.exception)


def test_a_search_that_no_section_answers_wholly_shows_the_nearest():
    found = CliRunner().invoke(mbproj, ["help", "zeppelin", "baumgarte"])
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
        assert (CHECKOUT / path).exists(), path


@pytest.mark.parametrize("words", ["joints", "reference/joints", "joints/reference", "joints.md"])
def test_a_page_is_found_by_its_topic_and_kind(words):
    assert page_of([words]).topic == "joints"
    assert page_of(["joints/tutorial"]) is None
