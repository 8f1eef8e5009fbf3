"""What `mbproj new` writes: it reads, says what was asked for, runs as written and holds what it expects."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbproj.base.errors import ExitCode, InputError
from mbproj.scene.scene import read_scene_text
from mbproj.scene.templates.table import TEMPLATES, scene_text
from mbproj.studies.batch import run_task, tasks
from tests.cli.commands import mbproj
from tests.kernel.scenes import needs_kernel

SIZES = [
    *((name, {}, False) for name in TEMPLATES),
    ("pendulum", {"length": "3 cm", "mass": "20 g", "angle": "-170 deg"}, False),
    ("chain", {"links": "1"}, False),
    ("chain", {"links": "4", "length": "200 mm"}, True),
    ("tree", {"links": "6", "angle": "-10 deg"}, True),
    ("star", {"links": "1", "speed": "1 rad/s"}, False),
    ("pendulum", {"angle": "179.9 deg"}, False),
    ("pendulum", {"angle": "1e-3 deg"}, False),
    ("chain", {"angle": "1e-4 deg"}, False),
    ("chain", {"links": "1"}, True),
    ("star", {"speed": "1e-6 rad/s"}, False),
    ("ladder", {"loops": "1", "length": "5 cm"}, False),
    ("slider-crank", {"crank": "10 m", "rod": "10.5 m", "speed": "1"}, False),
    ("four-bar", {"crank": "8 cm", "coupler": "1 m", "rocker": "90 cm", "frame": "40 cm", "mass": "5"}, False),
    ("cam", {"radius": "1 m", "speed": "2", "mass": "30 kg"}, False),
    ("hoist", {"radius": "5 cm", "length": "3 m", "mass": "3 kg"}, False),
    ("winch", {"radius": "2 cm", "length": "30 m", "mass": "3 kg"}, False),
]


@needs_kernel
@pytest.mark.parametrize(("name", "given", "spatial"), SIZES, ids=range(len(SIZES)))
def test_it_runs_as_written_and_holds_what_it_expects(
    tmp_path: Path, name: str, given: dict[str, str], spatial: bool
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(scene_text(name, given, spatial), encoding="utf-8")
    (task,) = tasks([path], tmp_path, keep=False)
    found = run_task(task)
    assert [(each.expectation.name, each.measured) for each in found.outcomes if not each.holds] == []
    assert (found.code, found.message) == (ExitCode.DONE, "")
    assert {"closed", "energy"} <= {each.expectation.name for each in found.outcomes}


@pytest.mark.parametrize("name", list(TEMPLATES))
def test_it_is_readable(name: str) -> None:
    text = scene_text(name, {})
    assert text.startswith("# ")
    assert max(map(len, text.splitlines())) <= 120
    assert text == scene_text(name, dict(TEMPLATES[name].defaults))


@pytest.mark.parametrize(
    ("name", "given", "bodies", "joints"),
    [
        ("chain", {"links": "40"}, 40, 40),
        ("tree", {"links": "31"}, 31, 31),
        ("star", {"links": "8"}, 9, 9),
        ("ladder", {"loops": "10"}, 30, 40),
    ],
)
def test_sizes(name: str, given: dict[str, str], bodies: int, joints: int) -> None:
    scene = read_scene_text(scene_text(name, given))
    assert (len(scene.bodies), len(scene.joints)) == (bodies, joints)


@pytest.mark.parametrize("name", ["chain", "tree"])
@pytest.mark.parametrize("links", [2, 7, 200])
def test_a_push_out_of_the_plane_is_gentle_at_any_size(name: str, links: int) -> None:
    """Speeds of joints add up along a branch, to 0.3 sqrt(g / reach) at its end."""
    scene = read_scene_text(scene_text(name, {"links": str(links)}, spatial=True))
    turning = {"ground": 0.0}
    for joint in scene.joints:
        turning[joint.bodies[1]] = turning[joint.bodies[0]] + joint.speed.get("angle", 0.0)
    assert max(turning.values()) == pytest.approx(0.3 * (9.81 / scene.parameters["reach"]) ** 0.5, rel=1e-12)


def test_a_tree_is_binary_and_a_chain_is_one() -> None:
    tree, chain = (read_scene_text(scene_text(name, {"links": "7"})) for name in ("tree", "chain"))
    assert [joint.bodies[0] for joint in tree.joints] == ["ground", "bar1", "bar1", "bar2", "bar2", "bar3", "bar3"]
    assert [joint.bodies[0] for joint in chain.joints] == ["ground", *(f"bar{k}" for k in range(1, 7))]


def test_numbers_keep_their_units_and_set_changes_them() -> None:
    text = scene_text("pendulum", {"length": "300 mm"})
    assert "  length: 300 mm\n" in text
    assert read_scene_text(text, "p", {"length": "2 m"}).markers[0].location == (1.0, 0.0, 0.0)


WRONG = [
    ("pendulum", {"links": "3"}, "--links: error: a pendulum has no --links; it takes --length, --mass, --angle"),
    (
        "pendulum",
        {"angle": "180 deg"},
        "--angle: error: 'angle' must be between 0 and 180 deg; it is counted from hanging straight down",
    ),
    ("pendulum", {"length": "0"}, "--length: error: '--length' must be greater than 0, found 0"),
    ("pendulum", {"mass": "1 m"}, "--mass: error: '--mass' is in kg, this is a length, in m"),
    ("chain", {"links": "2.5"}, "--links: error: '--links' needs a whole number, found '2.5'"),
    ("ladder", {"loops": "5001"}, "--loops: error: 'loops' is at most 5000, found 5001; give fewer"),
    (
        "slider-crank",
        {"rod": "5 cm"},
        "--rod: error: 'rod' is not longer than the crank, which cannot go round; give a longer rod",
    ),
    (
        "four-bar",
        {"crank": "26 cm"},
        "--crank: error: 'crank' cannot go round: it has to be the shortest, and with the "
        "longest less than the other two (Grashof); give a shorter crank",
    ),
]


@pytest.mark.parametrize(("name", "given", "message"), WRONG, ids=range(len(WRONG)))
def test_bad_numbers_are_refused(name: str, given: dict[str, str], message: str) -> None:
    with pytest.raises(InputError) as raised:
        scene_text(name, given)
    assert str(raised.value) == message


def test_the_command_writes_a_file_and_replaces_none(tmp_path: Path) -> None:
    done = mbproj("new", "chain", "--links", "3", "--spatial", "-o", "c.yaml", folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "c.yaml\n", "")
    assert (tmp_path / "c.yaml").read_text(encoding="utf-8") == scene_text("chain", {"links": "3"}, spatial=True)
    again = mbproj("new", "chain", "-o", "c.yaml", folder=tmp_path)
    assert again.returncode == 2
    assert again.stderr == (
        "error: 'c.yaml' exists and is not a scene to replace of mbproj, so it is not replaced; remove it, "
        "give --force, or choose another with -o\n"
    )
    printed = mbproj("new", "star", folder=tmp_path)
    assert printed.stdout == scene_text("star", {})
    flat = mbproj("new", "star", "--spatial", folder=tmp_path)
    assert (flat.returncode, flat.stderr) == (2, "--spatial: error: a star has no --spatial; these have: chain, tree\n")
