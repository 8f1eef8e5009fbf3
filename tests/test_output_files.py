"""Files that commands write: whole or not at all, CSV tables, and tables for papers."""

from __future__ import annotations

import csv
import os
import re
import stat

import h5py
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import mbproj
from mbproj.base.errors import InputError
from mbproj.base.text import escaped, escaped_text
from mbproj.commands.main import mbproj as group
from mbproj.results.output_files import JUNIT, SCENE, SCHEMA, check_replaceable, hdf5, picture, replacing, write_text
from mbproj.results.output_files import csv as csv_kind
from mbproj.results.table_files import check_table, write_csv, write_table
from mbproj.show.figures.style import save
from tests.support import ROOT

# What a command writes appears whole, is nobody else's before, and replaces nothing but its own kind.


def permissions(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_a_new_file_is_private_until_it_is_whole_and_has_the_usual_permissions_then(tmp_path):
    path, usual = tmp_path / "a.txt", tmp_path / "usual"
    usual.touch()
    with replacing(path, SCENE) as draft:
        assert permissions(draft) == 0o600
        assert not path.exists()
        draft.write_text("whole")
    assert path.read_text() == "whole"
    assert permissions(path) == permissions(usual)
    assert sorted(tmp_path.iterdir()) == [path, usual]


def test_a_replaced_file_keeps_its_permissions(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("old")
    path.chmod(0o640)
    write_text(path, "new", SCENE, force=True)
    assert (path.read_text(), permissions(path)) == ("new", 0o640)


def test_what_fails_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), replacing(path, SCENE, force=True) as draft:
        draft.write_text("half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_followed_to_a_file_of_ours_and_to_no_other(tmp_path):
    ours, foreign, link = tmp_path / "ours.xml", tmp_path / "profile", tmp_path / "link.xml"
    write_text(ours, '<?xml?>\n<testsuites name="mbproj batch"/>', JUNIT)
    link.symlink_to(ours)
    write_text(link, '<?xml?>\n<testsuites name="mbproj batch" tests="1"/>', JUNIT)
    assert link.is_symlink() and "tests" in ours.read_text()
    foreign.write_text("precious")
    for target, message in ((foreign, "is not a JUnit report of mbproj"), (tmp_path / "none", "is a link to nothing")):
        link.unlink()
        link.symlink_to(target)
        with pytest.raises(InputError, match=message):
            write_text(link, "x", JUNIT)
    assert foreign.read_text() == "precious"
    assert not (tmp_path / "none").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_pipes_devices_and_directories_are_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path, message in ((tmp_path / "pipe", "a pipe or a device"), (tmp_path, "is a directory")):
        for force in (False, True):
            with pytest.raises(InputError, match=message):
                check_replaceable(path, JUNIT, force=force)


def drawn(path):
    figure = Figure()
    figure.add_subplot().plot([0, 1])
    return save(figure, path)


def hdf5_file(path, file_format):
    with h5py.File(path, "w") as file:
        file.attrs["format"] = file_format


TABLE = "time (s),x (m),y (m)\n0,1,2\n"
KINDS = [
    (picture("png"), drawn, "a.png"),
    (picture("pdf"), drawn, "a.pdf"),
    (picture("svg"), drawn, "a.svg"),
    (csv_kind(["time (s)", "x (m; not unique)", "z (m)"]), lambda path: path.write_text(TABLE), "a.csv"),
    (hdf5("mbproj tradeoff"), lambda path: hdf5_file(path, "mbproj tradeoff"), "a.h5"),
    (JUNIT, lambda path: path.write_text('<?xml?>\n<testsuites name="mbproj batch"/>'), "a.xml"),
    (SCHEMA, lambda path: path.write_text('{\n  "$schema": "",\n  "title": "mbproj scene"'), "a.json"),
]


@pytest.mark.parametrize(("kind", "write", "name"), KINDS, ids=[name for _, _, name in KINDS])
def test_each_kind_knows_its_own_files_and_no_others(tmp_path, kind, write, name):
    path = tmp_path / name
    write(path)
    assert check_replaceable(path, kind) == path
    path.write_bytes(b"")
    assert check_replaceable(path, kind) == path
    whole = re.escape(f"'{path}' exists and is not {kind.what} of mbproj, so it is not replaced; remove it, give")
    others = (b"time (s),theirs\n1,2\n", b"\x89PNG\r\n\x1a\n theirs", b"%PDF-1.4", b"<?xml?><testsuites/>", b"a: 1")
    for foreign in others:
        path.write_bytes(foreign)
        with pytest.raises(InputError, match=whole):
            check_replaceable(path, kind)
        assert check_replaceable(path, kind, force=True) == path


def test_pictures_of_others_and_hdf5_of_others_are_not_ours(tmp_path):
    Figure().savefig(tmp_path / "theirs.png")
    hdf5_file(tmp_path / "theirs.h5", "somebody's")
    assert not picture("png").is_ours(tmp_path / "theirs.png")
    assert not hdf5("mbproj results").is_ours(tmp_path / "theirs.h5")


# Tables for papers: --write-table of the commands, in the format of the file's name.

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


# CSV tables: numbers to the last digit, text that is neither a formula nor a command.


def test_text_is_no_formula_and_commands_no_terminal(tmp_path):
    rows = [['=HYPERLINK("x")', -1.5, None], ["a,b", 0.1, "\x1b[31mred\r\n"]]
    write_csv(tmp_path / "a.csv", ["label", "value", "failure"], rows)
    assert (tmp_path / "a.csv").read_bytes().decode().split("\n") == [
        "label,value,failure",
        '"\'=HYPERLINK(""x"")",-1.5,',
        '"a,b",0.1,\\u001b[31mred\\u000d\\u000a',
        "",
    ]


def test_commands_of_terminals_can_be_read_and_other_text_is_itself():
    assert escaped("\x1b]0;x\x07 \x9b31m \u202egpj.exe \x7f\udcff\n") == (
        "\\u001b]0;x\\u0007 \\u009b31m \\u202egpj.exe \\u007f\\udcff\\u000a"
    )
    assert escaped_text("two\tlines\nα ≤ Δ, été\r") == "two\tlines\nα ≤ Δ, été\\u000d"
