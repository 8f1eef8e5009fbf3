"""Pictures as a document wants them: its size in mm, its font, its style sheets; and what is wrong with these."""

from __future__ import annotations

import re

import pytest
from click.testing import CliRunner
from matplotlib.font_manager import findfont

import mbproj
from mbproj.commands.main import mbproj as command
from mbproj.show.figures.style import REFUSED, STYLE, line, look, page_width, read_sheet
from tests.support import ROOT

SHEET = """\
# of a journal: "a # in quotes" stays
font.family: serif
font.size: 7            # points
lines.linewidth: 0.7
axes.prop_cycle: cycler("color", ["#112233", "#445566"]) + cycler("linestyle", ["-", ":"])
"""
#: Points in a mm, of PDF.
POINTS = 72 / 25.4


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.h5"
    with mbproj.run(ROOT / "mechanisms" / "five_bar.yaml", duration=0.2, output=path) as opened:
        yield opened


@pytest.fixture
def sheet(tmp_path):
    path = tmp_path / "journal.mplstyle"
    path.write_text(SHEET, encoding="utf-8")
    return path


def test_a_picture_has_the_size_that_is_asked_for(results, tmp_path):
    """To a thousandth of a mm, in a format of vectors."""
    for size, height in (((85, 60), 60), (85, None)):
        with mbproj.figure_style(size=size):
            path = results.plot.energy().save(tmp_path / "energy.pdf", force=True)
        box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", path.read_bytes())
        assert box is not None
        assert float(box[1]) == pytest.approx(85 * POINTS, abs=1e-3 * POINTS)
        if height is not None:
            assert float(box[2]) == pytest.approx(height * POINTS, abs=1e-3 * POINTS)
    assert page_width() == pytest.approx(160 / 25.4, abs=0.01)


def test_a_font_is_that_of_all_text(results, tmp_path):
    """The text of an SVG names it first."""
    with mbproj.figure_style(font="DejaVu Serif", size=120):
        text = results.plot.energy().save(tmp_path / "energy.svg").read_text(encoding="utf-8")
    named = re.findall(r"font: [^;\"]*?px ('[^']+')", text) + re.findall(r"font-family: ('[^']+')", text)
    assert named and set(named) == {"'DejaVu Serif'"}


def test_a_sheet_sets_lines_and_letters(results, sheet):
    """Sizes that it does not give follow its `font.size`; afterwards all is as before."""
    with mbproj.figure_style(sheet):
        axes = results.plot.energy().axes[0]
        drawn = [each for each in axes.lines if len(each.get_xdata()) > 2]
        assert [each.get_color() for each in drawn[:2]] == ["#112233", "#445566"]
        assert drawn[0].get_linewidth() == 0.7
        assert axes.yaxis.label.get_size() == pytest.approx(7)
        assert axes.yaxis.label.get_family()[0] == "serif"
        assert look().settings["xtick.labelsize"] == pytest.approx(8 * 7 / 8.5)
        assert [line(index)["color"] for index in (0, 1, 2)] == ["#112233", "#445566", "#112233"]
        with mbproj.figure_style("grayscale"):
            assert look().settings["font.size"] == 7
            assert line(0)["color"] == "0.00"
    assert look().settings["font.size"] == STYLE["font.size"]
    assert line(0)["color"] == "#0072B2"


def test_a_sheet_may_give_the_size(results, tmp_path):
    (tmp_path / "size.mplstyle").write_text("figure.figsize: 3.5, 2.0\n", encoding="utf-8")
    with mbproj.figure_style(tmp_path / "size.mplstyle"):
        path = results.plot.energy().save(tmp_path / "energy.pdf")
    assert b"/MediaBox [ 0 0 252 144 ]" in path.read_bytes()


def test_all_that_is_wrong_in_a_sheet_is_said_with_its_line(tmp_path):
    path = tmp_path / "bad.mplstyle"
    path.write_text("font.sise: 8\n\nfont.size: big1\nbackend: agg\ntext.usetex: True\nx\n", encoding="utf-8")
    with pytest.raises(mbproj.InputError) as raised:
        list(read_sheet(path))
    lines = [problem.line().partition(":")[2] for problem in raised.value.problems]
    assert lines[0] == "1: error: unknown key 'font.sise'; did you mean 'font.size'?"
    assert lines[1].startswith("3: error: 'font.size': Could not convert 'big1'")
    assert lines[2:] == [
        "4: error: a sheet cannot set 'backend'; leave it out",
        f"5: error: a sheet cannot set 'text.usetex'; {REFUSED['text.usetex']}",
        "6: error: 'x' is not KEY: VALUE",
    ]


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"size": 3}, "a picture of 3 mm; sizes are 20 to 1000 mm"),
        ({"font": "DejaVu Seri"}, "the font 'DejaVu Seri' is not installed here"),
    ],
)
def test_what_cannot_be_is_refused(asked, message):
    with pytest.raises(mbproj.InputError, match=message), mbproj.figure_style(**asked):
        pass


@pytest.mark.parametrize(
    ("sheet", "message"),
    [
        ("savefig.dpi: 1e9", "a picture of .* pixels, and 1e[+]08 are the most; set a smaller savefig.dpi"),
        ("savefig.dpi: 20000", "a picture of .* pixels"),
        ("path.effects: [1]", "Matplotlib draws nothing with this style sheet: AttributeError: .*; take out lines of"),
        ("figure.figsize: 1e6, 1e6", "a picture of 2.54e[+]07 mm; sizes are 20 to 1000 mm"),
        ("figure.figsize: nan, 3", "a picture of nan mm; sizes are 20 to 1000 mm"),
    ],
)
def test_a_sheet_with_which_nothing_can_be_drawn_is_refused(results, tmp_path, sheet, message):
    (tmp_path / "bad.mplstyle").write_text(sheet, encoding="utf-8")
    with pytest.raises(mbproj.InputError, match=message), mbproj.figure_style(tmp_path / "bad.mplstyle"):
        results.plot.energy().save(tmp_path / "energy.png")


def test_the_options_hold_for_all_pictures_of_a_command(results, sheet, tmp_path):
    where = ["plot", results.attributes["output"], "--kind", "energy", "--kind", "markers", "-o", str(tmp_path)]
    options = ["--style", str(sheet), "--size", "90 mm, 70 mm", "--font", "DejaVu Sans Mono", "--format", "pdf"]
    done = CliRunner().invoke(command, [*where, *options], catch_exceptions=False)
    assert done.exit_code == 0
    for path in done.stdout.split():
        width, height = 90 * POINTS, 70 * POINTS
        assert f"/MediaBox [ 0 0 {width:.10g}".encode()[:25] in tmp_path.joinpath(path).read_bytes()
        assert b"DejaVuSansMono" in tmp_path.joinpath(path).read_bytes()
        assert f"{height:.6f}".encode()[:7] in tmp_path.joinpath(path).read_bytes()
    wrong = CliRunner().invoke(command, [*where, "--size", "90,70,50"])
    assert "--size: error: '90,70,50' is no width in mm, nor a width and a height" in str(wrong.exception)
    assert findfont("DejaVu Sans Mono")
