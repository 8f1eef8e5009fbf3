"""Tables for papers: --write-table of the commands, in the format of the file's name."""

from __future__ import annotations

import csv

import pytest
from click.testing import CliRunner

import mbproj
from mbproj.base.errors import InputError
from mbproj.commands.main import mbproj as group
from mbproj.results.table_files import check_table, write_table
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
HEADINGS, ROWS = ("name", "value (m)"), (("a|b & c", 1 / 3), ("none", None))


def test_each_format(tmp_path):
    whole = write_table(tmp_path / "t.csv", HEADINGS, ROWS)
    with whole.open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file)) == [list(HEADINGS), ["a|b & c", "0.3333333333333333"], ["none", ""]]
    text = write_table(tmp_path / "t.md", HEADINGS, ROWS).read_text(encoding="utf-8")
    assert text.splitlines()[2:] == [
        "| name | value (m) |",
        "| --- | --- |",
        "| a\\|b & c | 0.333333 |",
        "| none |  |",
    ]
    assert "a|b \\& c & $0.333333$" in write_table(tmp_path / "t.tex", HEADINGS, ROWS).read_text(encoding="utf-8")
    write_table(tmp_path / "t.md", HEADINGS, ROWS[:1])  # its own is replaced


def test_what_is_not_ours_stays(tmp_path):
    notes = tmp_path / "notes.md"
    notes.write_text("# Notes\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"notes\.md"):
        write_table(notes, HEADINGS, ROWS)
    assert notes.read_text(encoding="utf-8") == "# Notes\n"
    with pytest.raises(InputError, match=r"^--write-table: error: '.*t\.xls' is not the name of a table; end it in"):
        check_table(tmp_path / "t.xls", HEADINGS)


def run(*words):
    return CliRunner().invoke(group, [str(word) for word in words], catch_exceptions=False)


def test_modes_and_loads_write_what_python_gives(tmp_path):
    file = tmp_path / "modes.csv"
    run("modes", FIVE_BAR, "--at", "equilibrium", "-o", tmp_path / "modes.h5", "--write-table", file)
    with file.open(encoding="utf-8", newline="") as opened:
        found = [float(row["frequency (Hz)"]) for row in csv.DictReader(opened)]
    assert found == pytest.approx(mbproj.modes(FIVE_BAR, at="equilibrium").frequencies, rel=1e-9)
    path = tmp_path / "results.h5"
    with mbproj.run(FIVE_BAR, duration=0.05, output=path) as results:
        felt = mbproj.largest_loads(results)
    run("info", path, "--loads", "--write-table", tmp_path / "loads.md")
    assert len((tmp_path / "loads.md").read_text(encoding="utf-8").splitlines()) == len(felt) + 4
    assert "--write-table is for --loads" in run("info", path, "--write-table", tmp_path / "x.md").output


@pytest.mark.full
def test_compare_and_recommend_write_theirs(tmp_path):
    few = ("--projections", "gopm,gpopm", "--until", "0.1", "--repeat", "1", "-j", "1", "-o", tmp_path)
    run("compare", FIVE_BAR, *few, "--write-table", tmp_path / "compare.tex")
    assert "gopm & " in (tmp_path / "compare.tex").read_text(encoding="utf-8")
    run("recommend", FIVE_BAR, "--error", "1 mm", "--until", "0.1", "--write-table", tmp_path / "best.md")
    assert "| best | --" in (tmp_path / "best.md").read_text(encoding="utf-8")
