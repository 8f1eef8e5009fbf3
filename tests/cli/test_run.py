"""`mbproj run`, end to end: the results file, the summary, exit codes, places of faults, expectations, what a failed
run leaves."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

from mbproj import open_results
from mbproj.base.errors import InputError
from mbproj.commands.run import command
from mbproj.motion.report import EnergyWatch
from mbproj.results.analysis.summary import energy_drift
from mbproj.studies.batch import Task, run_task
from tests.cli.commands import FIVE_BAR, SLIDER_CRANK, begun, mbproj, succeeds
from tests.cli.examples import named
from tests.cli.reports import refuse_what_no_table_says
from tests.crossed import full
from tests.integrate.stiff_scenes import CREEP
from tests.studies.scenes import HOLDS, SHORT, write
from tests.support import REDUNDANT, ROOT

# `mbproj run`, end to end: the results file, the summary, --json, exit codes, and what is kept when a run fails.

KEYS = {
    "scene",
    "output",
    "formulation",
    "projection",
    "integrator",
    "degrees_of_freedom",
    "steps",
    "integration_seconds",
    "total_seconds",
    "position_violation_max",
    "velocity_violation_max",
    "worst_joint",
    "energy_drift",
    "energy_drift_relative",
    "energy_put_in",
    "energy_dissipated",
    "energy_numerical",
    "status",
}


def test_the_users_command(tmp_path):
    done = mbproj("run", FIVE_BAR, "--projection", "gpopm", "--duration", "0.5", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("Five-bar pendulum (Zhang, Liu & Liu 2015, sect. 5.1)\n")
    assert "  35 coordinates, 30 constraints, 5 degrees of freedom\n" in done.stdout
    assert "formulation: " in done.stdout
    assert "50 steps to t = 0.5 s" in done.stdout
    assert "0 failures" in done.stdout
    results = open_results(tmp_path / "results.h5")
    assert results.status == "complete"
    assert len(results.time) == 51
    assert not (tmp_path / "results.h5.part").exists()


def test_the_summary_says_apart_what_dampers_and_what_the_method_took(tmp_path):
    scene = tmp_path / "stiff.yaml"
    scene.write_text(CREEP, encoding="utf-8")
    done = mbproj("run", "stiff.yaml", "--integrator", "radau5", folder=tmp_path)
    assert re.search(
        r"\n  energy in, out      forces put in \S+ J, dampers took \S+ J, "
        r"integrator and projection (took|added) \S+ J\n",
        done.stdout,
    )


def test_json_is_one_object_with_the_promised_keys(tmp_path):
    done = succeeds("run", SLIDER_CRANK, "--duration", "0.1", "--json", "-o", "out.h5", folder=tmp_path)
    numbers = json.loads(done.stdout)
    assert set(numbers) >= KEYS
    assert (numbers["degrees_of_freedom"], numbers["redundant_rows"]) == (1, 0)
    assert numbers["steps"] == 10
    assert numbers["status"] == "complete"
    assert numbers["worst_joint"] in ("A", "B", "C", "D")
    assert numbers["position_violation_max"] <= 1e-13
    assert open_results(tmp_path / "out.h5").attributes["steps"] == 10


@pytest.mark.parametrize("name", ["bennett", "locomotive"])
def test_redundant_rows_are_counted(tmp_path, name):
    """In the summary, and as `redundant_rows` in --json and the results file, in space and in the plane."""
    scene = str(ROOT / "mechanisms" / f"{name}.yaml")
    options = ["--duration", "0.01", "--output-step", "0.01"]
    done = mbproj("run", scene, *options, folder=tmp_path)
    counts = re.search(r"(\d+) coordinates, (\d+) constraints, (\d+) of them redundant, (\d+) degrees", done.stdout)
    assert counts is not None, done.stdout + done.stderr
    coordinates, constraints, redundant, freedom = map(int, counts.groups())
    assert redundant == REDUNDANT[name] == constraints - (coordinates - freedom)
    assert json.loads(mbproj("run", scene, *options, "--json", folder=tmp_path).stdout)["redundant_rows"] == redundant
    assert open_results(tmp_path / "results.h5").attributes["redundant_rows"] == redundant


def test_the_summary_says_how_often_another_metric_was_taken(tmp_path):
    soft = ["--duration", "0.1", "--projection", "mass-orthogonal", "--alpha", "1e-3"]
    done = mbproj("run", FIVE_BAR, *soft, "--projection-fallback", "gopm", folder=tmp_path)
    assert "0 failures, 10 in gopm's metric\n" in done.stdout
    done = mbproj("run", FIVE_BAR, *soft, folder=tmp_path)
    assert "10 failures\n" in done.stdout
    assert done.stderr.startswith("note: 10 projections missed their tolerance; ")


def test_quiet_prints_nothing(tmp_path):
    done = mbproj("run", SLIDER_CRANK, "--duration", "0.05", "--quiet", folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_options_override_the_scene_with_units(tmp_path):
    arguments = ["--duration", "100 ms", "--step", "20 ms", "--integrator", "heun2", "--projection", "gopm", "--json"]
    numbers = json.loads(mbproj("run", SLIDER_CRANK, *arguments, folder=tmp_path).stdout)
    assert (numbers["steps"], numbers["integrator"], numbers["projection"]) == (5, "heun2", "gopm")


def test_set_changes_parameters(tmp_path):
    succeeds("run", SLIDER_CRANK, "--set", "speed=12 rad/s", "--duration", "0.02", folder=tmp_path)
    speed = open_results(tmp_path / "results.h5")["joints/speed"]
    assert speed[0, 0] == pytest.approx(12.0, abs=1e-12)


def test_a_motion_that_round_off_rules_is_said(tmp_path):
    """The spin of a coupler between two balls that has hardly any inertia about their line."""
    text = (ROOT / "mechanisms" / "planar_four_bar.yaml").read_text()
    between_balls = re.sub(r"type: universal(.*?)    axes: [^\n]*\n", r"type: spherical\1", text, flags=re.DOTALL)
    for inertia, said in (("1.0e-4", False), ("1.0e-14", True)):
        scene = tmp_path / "scene.yaml"
        scene.write_text(between_balls.replace("[1.0e-4, 2.4e-3, 2.4e-3]", f"[{inertia}, 2.4e-3, 2.4e-3]"))
        done = mbproj("run", "scene.yaml", "--duration", "0.01", folder=tmp_path)
        assert ("'coupler' turns about [0.839, 0, 0.545] through its centre" in done.stderr) == said, done.stderr


def test_a_drifting_energy_is_said(tmp_path):
    done = mbproj("run", SLIDER_CRANK, "--duration", "2", folder=tmp_path)
    assert done.stderr.startswith("note: the energy drifted by 0.")
    assert "the motion may be wrong although the joints are closed" in done.stderr


#: A slider-crank whose crank turns steadily.
DRIVEN = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, tolerance: 1e-2, integrator: dop853}
bodies:
  crank: {mass: 0.5, inertia: [2e-3, 2e-3, 2e-3], position: [0.1, 0, 0]}
  rod: {mass: 1.2, inertia: [1e-2, 1e-2, 1e-2], position: [0.4, 0, 0]}
  slider: {mass: 0.7, inertia: [1e-3, 1e-3, 1e-3], position: [0.6, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, rod], location: [0.2, 0, 0], axis: [0, 1, 0]}
  C: {type: revolute, bodies: [rod, slider], location: [0.6, 0, 0], axis: [0, 1, 0]}
  D: {type: prismatic, bodies: [ground, slider], location: [0.6, 0, 0], axis: [1, 0, 0]}
motions:
  drive: {joint: A, angle: {constant_speed: 90 rpm}}
"""


def test_where_nothing_is_free_to_move_the_energy_tells_nothing_of_the_motion(tmp_path):
    """Where it is integrated all the same, the work of the motion is wrong by its coarse steps, and the slider right.
    A kinematic run has both."""
    (tmp_path / "driven.yaml").write_text(DRIVEN)
    integrated = ("run", "driven.yaml", "--kinematic", "false")
    assert json.loads(mbproj(*integrated, "--json", folder=tmp_path).stdout)["energy_drift_relative"] > 1e-4
    assert "energy" not in mbproj(*integrated, folder=tmp_path).stderr
    done = mbproj("run", "driven.yaml", "--json", folder=tmp_path)
    assert json.loads(done.stdout)["energy_drift_relative"] < 1e-9
    with open_results(tmp_path / "results.h5") as results:
        angle = 3.0 * np.pi * results.time
        x = 0.2 * np.cos(angle) + np.sqrt(0.4**2 - (0.2 * np.sin(angle)) ** 2)
        np.testing.assert_allclose(results["bodies/position"][:, 2, 0], x, atol=1e-13)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--projection", "gpopn"], "--projection: error: "),
        (["--projection", "popm", "--formulation", "full"], "'popm' needs a positive definite mass matrix"),
        (["--alpha", "10"], "--alpha: error: "),
        (["--tolerance", "1e-6"], "--tolerance: error: "),
        (["--set", "lenght=2"], "did you mean 'length'?"),
        (["--set", "length"], "--set: error: 'length' is not NAME=VALUE"),
        (["--step", "0.01 kg"], "--step: error: "),
        (["-o", "no/such/folder/out.h5"], "no/such/folder"),
    ],
)
def test_wrong_options_are_bad_input_without_a_traceback(tmp_path, arguments, message):
    done = mbproj("run", FIVE_BAR, *arguments, folder=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_a_missing_scene_and_an_unknown_command(tmp_path):
    done = mbproj("run", "nothing.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert "nothing.yaml" in done.stderr
    assert mbproj("rum", folder=tmp_path).returncode == 2


def test_a_failed_run_names_the_time_and_keeps_its_results(tmp_path):
    """Direct integration of the slider-crank diverges at 8.2 s; a longer step brings that forward."""
    arguments = ["--projection", "none", "--step", "0.04", "--duration", "10"]
    done = mbproj("run", SLIDER_CRANK, *arguments, folder=tmp_path)
    assert done.returncode == 3
    assert "error: stopped at t = " in done.stderr
    assert "note: what was computed until then is in results.h5" in done.stderr
    results = open_results(tmp_path / "results.h5")
    assert results.status.startswith("failed: stopped at t = ")
    assert len(results.time) > 1


def test_a_failed_run_prints_its_object_too(tmp_path):
    arguments = ["--projection", "none", "--step", "0.04", "--duration", "10", "--json"]
    done = mbproj("run", SLIDER_CRANK, *arguments, folder=tmp_path)
    assert done.returncode == 3
    printed = json.loads(done.stdout)
    assert printed["status"].startswith("failed: stopped at t = ")
    refuse_what_no_table_says(["run"], printed)


def test_an_input_error_leaves_an_existing_results_file_alone(tmp_path):
    mbproj("run", SLIDER_CRANK, "--duration", "0.02", "--quiet", folder=tmp_path)
    before = (tmp_path / "results.h5").read_bytes()
    wrong = ["--projection", "popm", "--formulation", "full"]
    assert mbproj("run", SLIDER_CRANK, *wrong, folder=tmp_path).returncode == 2
    assert (tmp_path / "results.h5").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["results.h5"]


def started(folder, out: str) -> subprocess.Popen[str]:
    """A run of hours in a process of its own that has been recording for a second, 1000 steps a sample."""
    options = ("--duration", "1e6", "--step", "1e-4", "--output-step", "0.1")
    process = begun("run", FIVE_BAR, *options, folder=folder, when=(folder / f"{out}.part").exists)
    time.sleep(2.5)
    return process


def test_an_interruption_that_python_cannot_raise_ends_the_command(tmp_path):
    """Ctrl-C within the callback of a weak reference, after which the command would go on."""
    program = """
        import signal, weakref
        from mbproj.commands.main import main
        class Dropped: pass
        def command(**options):
            kept = Dropped()
            watcher = weakref.ref(kept, lambda reference: signal.raise_signal(signal.SIGINT))
            del kept
            print("went on")
        main.__globals__["mbproj"].main = command
        signal.signal(signal.SIGINT, signal.default_int_handler)  # Python has none where its parent ignores SIGINT
        main()
    """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={"PYTHONPATH": str(ROOT)})
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.parametrize("signum", [signal.SIGINT, full(signal.SIGTERM)])
def test_interrupting_keeps_the_results_and_exits_with_130(tmp_path, signum):
    process = started(tmp_path, "results.h5")
    process.send_signal(signum)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    note = "note: what was computed until then is in results.h5; go on with: mbproj continue results.h5"
    assert errors.split("\n")[-4:] == [note, "", "interrupted", ""]
    results = open_results(tmp_path / "results.h5")
    assert results.status == "interrupted"
    assert len(results.time) > 10
    np.testing.assert_allclose(np.diff(results.time), 0.1, rtol=1e-9)


@pytest.mark.full
def test_a_killed_run_leaves_out_alone_and_its_part_readable(tmp_path):
    mbproj("run", SLIDER_CRANK, "--duration", "0.02", "--quiet", folder=tmp_path)
    before = (tmp_path / "results.h5").read_bytes()
    process = started(tmp_path, "results.h5")
    process.kill()
    process.communicate(timeout=60)
    assert (tmp_path / "results.h5").read_bytes() == before
    part = open_results(tmp_path / "results.h5.part")
    assert (part.status, part.partial) == ("running", True)
    assert len(part.time) > 10
    assert part["diagnostics/position_violation"].max() <= 1.1e-13  # what is recorded is computed anew from q
    succeeds("info", "results.h5.part", folder=tmp_path)
    succeeds("plot", "results.h5.part", "--kind", "violation", folder=tmp_path)


def test_the_end_has_two_names_in_every_command(tmp_path):
    for option in ("--until", "--duration"):
        done = mbproj("run", FIVE_BAR, option, "0.02", "--json", folder=tmp_path)
        assert json.loads(done.stdout)["steps"] == 2
    for name in ("verify", "threshold", "compare", "tradeoff", "recommend", "continue", "paper", "check"):
        assert {"--until", "--duration"} <= {each for option in named(name)[0].params for each in option.opts}, name


# `run` and `check` on a scene that expects something.


def test_run_says_what_holds_and_leaves_the_verdict_to_batch(tmp_path: Path) -> None:
    write(tmp_path, "a", HOLDS + SHORT)
    done = succeeds("run", "a.yaml", folder=tmp_path)
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


# Messages of a run stand where the fault is, and its summary shows no numbers that mean nothing.

HEAD = "mbproj: 1\ngravity: [1, 2, -9.81]\nsimulation: {duration: 1, step: 1 ms, formulation: auto}\nbodies:\n"
BAR = "  bar: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [0.5, 0.1, 0.07]}\n"
HEAVY_POINT = "  lump: {mass: 1, inertia: [0, 0, 0], position: [0, 0, 0]}\n"
PIN = "  p: {type: revolute, bodies: [ground, bar], location: [0, 0, 0.1], axis: [0.1, 1, 0.3]}\n"
STRUCTURE = f"""{HEAD}{BAR}  strut: {{mass: 1, inertia: [0.01, 0.1, 0.1], position: [1, 0.3, 0.5]}}
joints:
{PIN}  q: {{type: spherical, bodies: [bar, strut], location: [1, 0.2, 0]}}
  r: {{type: universal, bodies: [ground, strut], location: [1, 0.7, 1], axes: [[1, 0, 0.3], [0, 1, 0.1]]}}
"""
ONE_BAR = f"{HEAD}{BAR}joints:\n{PIN}"


def run(folder: Path, text: str, *options: str) -> tuple[int, str, str]:
    (folder / "s.yaml").write_text(text)
    done = mbproj("run", "s.yaml", *options, folder=folder)
    return done.returncode, done.stdout, done.stderr


LUMPS = {
    "free": HEAD + HEAVY_POINT,
    "on a ball": f"{HEAD}{HEAVY_POINT}joints:\n  b: {{type: spherical, bodies: [ground, lump], location: [0, 0, 0]}}",
}


@pytest.mark.parametrize("case", LUMPS)
def test_a_body_without_inertia_is_reported_at_the_body(case, tmp_path):
    code, out, error = run(tmp_path, LUMPS[case])
    assert (code, out) == (2, "")
    assert error.startswith("s.yaml:5:3: error: the joints leave 3 motions that move no mass (Eq. 20 does not hold)")
    checked = mbproj("check", "s.yaml", folder=tmp_path)
    assert (checked.returncode, checked.stderr) == (4, error)


def test_a_formulation_that_is_not_available_is_reported_where_it_is_asked_for(tmp_path):
    code, _, error = run(tmp_path, LUMPS["free"].replace("[0, 0, 0]", "[1, 1, 1]", 1).replace("auto", "planar"))
    assert (code, error.splitlines()[0]) == (
        2,
        "s.yaml:3:52: error: the scene is not planar: nothing but symmetry can keep the bodies in a plane: no joint "
        "has an axis",
    )
    message = (
        "the reduced formulation is not available here: the projection 'mmopm' exists in the full formulation only"
    )
    options = ("--formulation", "reduced", "--projection", "mmopm")
    assert run(tmp_path, ONE_BAR, *options)[2] == f"--formulation: error: {message}\n"


def test_a_file_that_cannot_be_written_is_reported_at_the_option(tmp_path, monkeypatch):
    def refuse(descriptor: int, size: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("mbproj.results.writer.reserve", refuse)
    (tmp_path / "s.yaml").write_text(ONE_BAR)
    with pytest.raises(InputError) as raised:
        command.main([str(tmp_path / "s.yaml"), "-o", "out.h5"], standalone_mode=False)
    cannot = "error: cannot write '{}': No space left on device; choose another file with -o"
    assert str(raised.value) == f"--output: {cannot.format('out.h5')}"
    found = run_task(Task(tmp_path / "s.yaml", tmp_path / "out.h5", keep=False))
    assert found.message == cannot.format(tmp_path / "out.h5")


@pytest.mark.parametrize("options", [("--projection", "none"), ("--integrator", "dop853", "--tolerance", "1e-8")])
def test_a_structure_has_neither_an_energy_drift_nor_velocities(options, tmp_path):
    code, out, error = run(tmp_path, STRUCTURE, *options)
    assert (code, error) == (0, "")
    assert "(0.0e+00 of the largest kinetic energy + |ΔV|)" in out
    (velocities,) = (line for line in out.splitlines() if line.startswith("  velocity violation"))
    assert velocities.endswith("; nothing moves")
    assert "relative 0\n" in mbproj("info", "results.h5", folder=tmp_path).stdout


def test_a_violation_of_zero_has_no_place(tmp_path):
    text = ONE_BAR.replace("[1, 2, -9.81]", "[0, 0, 0]").replace("[0.1, 1, 0.3]", "[0, 1, 0]")
    lines = run(tmp_path, text, "--duration", "0.01")[1].splitlines()
    assert "  position violation  0; round-off allows 2e-16" in lines
    assert "  velocity violation  0; nothing moves" in lines


def test_what_turns_moves_however_short_the_run(tmp_path):
    turning = ONE_BAR.replace("axis: [0.1, 1, 0.3]}", "axis: [0.1, 1, 0.3], speed: 1}")
    _, out, _ = run(tmp_path, turning, "--duration", "1e-18", "--step", "1e-18")
    (velocities,) = (line for line in out.splitlines() if line.startswith("  velocity violation"))
    assert "round-off allows" in velocities and "nothing moves" not in velocities


SQUEEZED = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.5, tolerance: 1e-9, integrator: dop853}
bodies:
  jaw: {mass: 0.2, inertia: [1e-4, 1e-4, 1e-4], position: [-0.025, 0, 0]}
  part: {mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0, 0, 0]}
joints:
  guide: {type: prismatic, bodies: [ground, jaw], location: [-0.025, 0, 0], axis: [1, 0, 0]}
forces:
  spring: {type: linear_spring_damper, joint: guide, force: 40}
"""
POINT = """
  {name}:
    type: stop
    plane: {{body: {body}, location: [{x}, 0, 0], normal: [{normal}, 0, 0]}}
    point: {{body: part, location: [{x}, 0, {z}]}}
    rigid: true
    friction: 0.3
"""


def test_where_nothing_moves_the_energy_says_nothing(tmp_path):
    """A part that four rough points hold: the round-off of 40 N is not a drift."""
    points = [
        POINT.format(name=f"{body}{z}", body=body, x=x, normal=-50 * x, z=0.001 * z)
        for body, x in (("jaw", -0.02), ("ground", 0.02))
        for z in (8, -8)
    ]
    code, out, error = run(tmp_path, SQUEEZED + "".join(points).replace("-8:", "m8:"))
    assert code == 0 and "nothing moves" in out
    assert "the energy drifted" not in error


def test_what_moves_without_joints_moves(tmp_path):
    text = ONE_BAR[: ONE_BAR.index("joints:")]
    _, out, _ = run(tmp_path, text)
    assert "nothing moves" not in out


def test_shares_of_the_time_are_shown_where_enough_steps_were_timed(tmp_path):
    for duration, shown in (("0.6", False), ("0.7", True)):
        _, out, _ = run(tmp_path, ONE_BAR, "--duration", duration)
        assert any(line.startswith("  time  ") for line in out.splitlines()) == shown


def test_a_real_drift_is_shown_however_small_the_motion():
    watch = EnergyWatch(scale=20.0)
    watch.take(balance=1e-6, kinetic=1e-4, lowest=-10.0, highest=-10.0)
    assert watch.relative == pytest.approx(1e-2)
    still = EnergyWatch(scale=20.0)
    still.take(balance=3e-13, kinetic=1e-26, lowest=-10.0, highest=-10.0)
    assert still.relative == 0.0
    locked = EnergyWatch(moves=False)
    locked.take(balance=1e-30, kinetic=1e-30, lowest=0.0, highest=0.0)
    assert locked.relative == 0.0


def test_the_drift_of_results_is_that_of_the_run():
    time = np.linspace(0.0, 1.0, 5)
    drift = energy_drift(1e-6 * time, 1e-4 * time, np.full(5, -10.0))
    assert drift.relative == pytest.approx(1e-2)
    assert energy_drift(3e-13 * time, 1e-26 * time, np.full(5, -10.0)).relative == 0.0


def test_an_interruption_that_compiled_code_turns_into_an_error_is_one(monkeypatch, capsys):
    """h5py reports Ctrl-C in a function that it calls back as a SystemError whose cause is the interruption."""
    from mbproj.commands import main

    def lost(*_: object, **__: object) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as cause:
            raise SystemError("returned a result with an exception set") from cause

    monkeypatch.setattr(main.mbproj, "main", lost)
    assert main._exit_code() == 130
    assert capsys.readouterr().err == "interrupted\n"
