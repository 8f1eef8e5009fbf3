"""Every number that was chosen stands in one record, with what it needs to be judged; the kernel has no others."""

from __future__ import annotations

import ast
import json
import math
import re
from dataclasses import replace

import pytest

from mbproj.base.thresholds import THRESHOLDS, Thresholds, of_the_kernel, threshold_table
from mbproj.kernel import core
from tests.cli.commands import mbproj
from tests.support import ROOT

KERNEL = ROOT / "mbproj" / "kernel" / "src"
#: Constants of the kernel that are no thresholds, and what they are.
NO_THRESHOLDS = {"not_a_number": "a name for NaN", "free_branch": "the same, of a switch that is not held"}
NO_THRESHOLDS |= {"stalls": "what stays so in some rounds cannot settle in the most"}
NO_THRESHOLDS |= {"ahead": "a part of a step for a difference", "aside": "a direction"}
NO_THRESHOLDS |= {"nearby": "places in a step", "least_nearby": "the same"}
NO_THRESHOLDS |= {"largest_reduced": "where a product is exact", "to_whole": "the same", "first": "a part of π/2"}
NO_THRESHOLDS |= {"huge": "beyond any force", "overflows": "the same", "tiny": "not 0"}
NO_THRESHOLDS |= {"epsilon": "that of doubles", "golden": "the ratio of the golden section"}
NO_THRESHOLDS |= {"nodes[]": "those of Gauss and Legendre", "weights[]": "the same"}
#: Folders and files whose numbers are thresholds where they are not coefficients, and how a constant begins there.
NUMERICS = ("functions", "equations", "motion", "model", "linear")
FLOAT_CONSTANT = re.compile(r"^([A-Z_]+(?:, [A-Z_]+)*) *(?::.*)?= \(?-?\d.*?(?:\.\d|e-\d)", re.M)
#: Module constants with a decimal number that are no thresholds, and what they are.
COEFFICIENTS = {
    "FARTHEST, SCAN, HALVINGS": "a scan of the complex plane, which bisection refines",
    "FURTHER": "trial points",
    "LOOKS": "places in a step",
    "THROUGH": "places in a step",
    "RETURN_SECONDS": "how often the screen is refreshed",
    "BLOCK_SECONDS": "how often the file is written",
    "COMPLEX_STEP": "its square is nothing beside 1",
    "DIFFERENCE": "a step of differences of order 6, whose two errors are alike there",
    "TINY": "not 0",
    "FULL_TURN": "2π",
    "GOLDEN": "the golden ratio",
    "_EIGHTH": "a part of a rise",
    "ROUGHLY": "of places, which are looked at one by one",
    "SETTLED": "Newton's method squares it",
    "ROUND_OFF": "a multiple of ε",
    "SMALL": "where a series takes over, exact to round-off on both sides",
}


def test_each_has_a_value_a_unit_a_reason_and_a_source():
    rows = threshold_table()
    assert len({row.name for row in rows}) == len(rows) > 80
    for row in rows:
        assert math.isfinite(row.value) and row.value > 0.0, row.name
        assert row.unit and row.source and len(row.why) > 10, row.name
        assert "chosen" not in row.source, f"{row.name}: which case needs it?"
        for path in re.findall(r"tests/[\w/]+(?:\.py)?", row.source):
            assert (ROOT / path).exists(), f"{row.name}: {path}"
        assert row.used_by in ("both", "kernel", "numpy"), row.name


def test_each_is_used():
    """By the code that it says uses it, and by no other."""
    python = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "mbproj").rglob("*.py") if path.name != "thresholds.py"
    )
    kernel = "".join(
        path.read_text(encoding="utf-8") for path in KERNEL.rglob("*.?pp") if path.name != "thresholds.hpp"
    )
    for row in threshold_table():
        in_python = re.search(rf"THRESHOLDS\.{row.name}\b", python) is not None
        in_kernel = re.search(rf"(thresholds_?|from|below)\.{row.name}\b", kernel) is not None
        assert (in_python, in_kernel) == (row.used_by != "kernel", row.used_by != "numpy"), row.name


def test_headers_of_the_kernel_keep_no_number_of_their_own():
    for path in sorted(KERNEL.rglob("*.?pp")):
        for declared in re.findall(r"constexpr double ([^;]*);", path.read_text(encoding="utf-8")):
            name = declared.split("=")[0].strip()
            assert name in NO_THRESHOLDS, f"{path.relative_to(ROOT)}: '{name}' belongs into mbproj/base/thresholds.py"


@pytest.mark.parametrize("folder", NUMERICS)
def test_modules_keep_no_number_of_their_own(folder):
    for path in sorted((ROOT / "mbproj" / folder).rglob("*.py")):
        for match in FLOAT_CONSTANT.finditer(path.read_text(encoding="utf-8")):
            name = match[1]
            assert name in COEFFICIENTS, f"{path.relative_to(ROOT)}: '{name}' belongs into mbproj/base/thresholds.py"


@pytest.mark.parametrize("place", ("functions", "model", "motion/projection.py", "linear", "equations/rank"))
def test_functions_keep_no_number_of_their_own(place):
    """A number that is small or large decides something; 1e-100 and less stand for "not 0"."""
    whole = ROOT / "mbproj" / place
    for path in sorted(whole.rglob("*.py")) or [whole]:
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for node in ast.walk(function) if isinstance(function, ast.FunctionDef) else ():
                if isinstance(node, ast.Constant) and isinstance(node.value, float):
                    assert not (1e-100 < node.value <= 0.01 or node.value >= 1e4), f"{path}:{node.lineno}"


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
def test_the_kernel_has_exactly_those_of_the_record():
    assert sorted(core().Thresholds.names()) == sorted(of_the_kernel())


@pytest.mark.skipif(core() is None, reason="no compiled kernel")
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"no_such_threshold": 1.0}, "no_such_threshold is not known to the kernel"),
        ({"at_rest": math.nan}, "at_rest is not positive"),
        ({"most_shorter": 0}, "most_shorter is not positive"),
    ],
)
def test_the_kernel_refuses_what_it_does_not_know(change, words):
    with pytest.raises(ValueError, match=words):
        core().Thresholds(**of_the_kernel() | change)
    without = of_the_kernel()
    del without["passing"]
    with pytest.raises(ValueError, match="passing is missing"):
        core().Thresholds(**without)


def test_info_prints_them(tmp_path):
    text, data = (
        mbproj("info", "--thresholds", folder=tmp_path),
        mbproj("info", "--thresholds", "--json", folder=tmp_path),
    )
    assert (text.returncode, text.stderr, data.returncode, data.stderr) == (0, "", 0, "")
    has = json.loads(data.stdout)
    assert {name: entry["value"] for name, entry in has.items()} == vars(THRESHOLDS)
    assert set(has["widest_turn"]) == {"value", "unit", "used_by", "why", "source"}
    for row in threshold_table():
        assert re.search(rf"^{row.name} +{re.escape(f'{row.value:g}')} {re.escape(row.unit)} \(", text.stdout, re.M)
        assert row.why in text.stdout


def test_info_takes_one_of_its_subjects(tmp_path):
    done = mbproj("info", "--thresholds", "--build", folder=tmp_path)
    assert done.returncode == 2
    assert "--thresholds" in done.stderr


def test_a_record_with_other_values():
    other = Thresholds(closed_to=1e-9)
    assert (other.closed_to, other.dependent) == (1e-9, THRESHOLDS.dependent)
    assert replace(other, dependent=1e-5) == Thresholds(closed_to=1e-9, dependent=1e-5) != other
    with pytest.raises(TypeError, match="there is no threshold 'closed'"):
        Thresholds(closed=1e-9)
