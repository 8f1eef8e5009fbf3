"""`run` and `check` on a scene that expects something."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.commands import mbproj
from tests.studies.scenes import HOLDS, SHORT, write


def test_run_says_what_holds_and_leaves_the_verdict_to_batch(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS + SHORT)
    done = mbproj("run", "a.yaml", folder=tmp_path)
    assert done.returncode == 0
    at = done.stdout.splitlines().index("  expectations        1 of 2 hold")
    assert done.stdout.splitlines()[at + 1 : at + 3] == [
        "    falls  holds        -0.07 ≤ -0.001 m  (marker end, position z at 0.1 s)",
        "    rises  falls short  -0.07, not ≥ 0.001 m  (marker end, position z at 0.1 s)",
    ]


def test_a_run_that_is_cut_short_says_what_it_did_not_check(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS)
    done = mbproj("run", "a.yaml", "--duration", "0.05", folder=tmp_path)
    assert "    falls  not checked  no such sample  (marker end, position z at 0.1 s)" in done.stdout
    found = json.loads(mbproj("run", "a.yaml", "--duration", "0.05", "--json", folder=tmp_path).stdout)
    (expectation,) = found["expectations"]
    assert (expectation["checked"], expectation["holds"], expectation["measured"]) == (False, False, None)


def test_rerun_checks_them_too(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS)
    mbproj("run", "a.yaml", "-q", folder=tmp_path)
    found = json.loads(mbproj("rerun", "results.h5", "--json", folder=tmp_path).stdout)
    assert [each["holds"] for each in found["expectations"]] == [True]


def test_check_lists_them(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS + SHORT)
    done = mbproj("check", "a.yaml", folder=tmp_path)
    assert "  2 expectations\n    falls  marker end, position z at 0.1 s: ≤ -0.001 m\n" in done.stdout
    assert json.loads(mbproj("check", "a.yaml", "--json", folder=tmp_path).stdout)["expectations"] == ["falls", "rises"]


def test_a_reaction_that_joints_share_at_will_is_marked(tmp_path: Path) -> None:
    """Two pins on one line hold the bar five times over, but for the torque about them."""
    load = "  {0}: {{joint: pin, quantity: reaction_{1}, component: {2}, at: maximum, below: 1000, source: x}}\n"
    expect = load.format("push", "force", "y") + load.format("turn", "torque", "y")
    second = "  pin2: {type: revolute, bodies: [ground, bar], location: [0, 0.1, 0], axis: [0, 1, 0]}\nmarkers:"
    write(tmp_path, "a", expect, "markers:", second)
    done = mbproj("run", "a.yaml", folder=tmp_path)
    assert (
        "≤ 1000 N; not unique, joints or contacts can share it in any proportion  (joint pin, reaction_force y"
        in done.stdout
    )
    found = json.loads(mbproj("batch", "a.yaml", "--json", folder=tmp_path).stdout)
    assert [each["unique"] for each in found["scenes"][0]["expectations"]] == [False, True]
