"""CSV tables: numbers to the last digit, text that is neither a formula nor a command."""

from __future__ import annotations

from mbproj.base.text import escaped, escaped_text
from mbproj.results.table_files import write_csv


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
