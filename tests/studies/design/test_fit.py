"""Numbers of a scene that match measurements are found again, in scenes of every kind."""

from __future__ import annotations

import numpy as np
import pytest

import mbproj
from mbproj.base.mechanisms_folder import mechanism
from mbproj.scene.scene import read_scene
from mbproj.studies.design.folder import DesignFolder, best_scene
from mbproj.studies.design.run import engine_of
from mbproj.studies.design.spec import read_spec
from tests.crossed import where
from tests.studies.design.scenes import BALL, FOUR_BAR, SPRING, found, table, written

TIMES = np.linspace(0.0, 1.0, 21)
FLIGHT = "match: {flight: {body: ball, through: flight.csv}}\n"


def flight(folder, speed, angle, noise=0.0, seed=0):
    shaken = noise * np.random.default_rng(seed).normal(size=(2, len(TIMES)))
    x, z = speed * np.cos(angle) * TIMES, speed * np.sin(angle) * TIMES - 5.0 * TIMES**2
    table(folder / "flight.csv", time__s=TIMES, position_x__m=x + shaken[0], position_z__m=z + shaken[1])


def test_a_throw_is_found_again(tmp_path):
    flight(tmp_path, 12.0, 0.7)
    spec = "vary: {parameters.speed: [1 m/s, 30 m/s], parameters.angle: [0, 90 deg]}\nstarts: 3\n"
    design, numbers = found(written(tmp_path, BALL, spec + FLIGHT))
    assert numbers == pytest.approx({"speed": 12.0, "angle": 0.7}, rel=1e-12)
    assert (design.engine, design.reused, design.notes) == ("least_squares", 0, ())


@pytest.mark.full
def test_a_coupler_curve_is_found_again_from_designs_that_do_not_close(tmp_path):
    """The crank of many designs of this box does not turn; the true one is a crank-rocker."""
    scene = FOUR_BAR.replace("crank: 0.2 m", "crank: 0.6 m")
    truth = {"crank": 0.25, "coupler": 0.75, "rocker": 0.6, "px": 0.3, "pz": 0.25}
    own = read_scene_with(FOUR_BAR, truth)
    with mbproj.run(own) as results:
        tip, time = results.marker("tip").position, results.time
    table(tmp_path / "tip.csv", t=time[:24], x__mm=1e3 * tip[:24, 0], z__mm=1e3 * tip[:24, 2])
    bounds = {
        "crank": "[0.1, 0.9]",
        "coupler": "[0.3, 1]",
        "rocker": "[0.3, 1]",
        "px": "[-0.3, 0.6]",
        "pz": "[-0.5, 0.5]",
    }
    vary = "".join(f"  parameters.{name}: {between}\n" for name, between in bounds.items())
    path = written(tmp_path, scene, f"vary:\n{vary}match: {{curve: {{marker: tip, through: tip.csv}}}}\nstarts: 2\n")
    design, numbers = found(path)
    assert numbers == pytest.approx(truth, abs=1e-12)
    assert np.sqrt(np.mean(design.trial.residuals**2)) < 1e-14


def read_scene_with(text, values):
    return mbproj.read_scene_text(text, "scene", values)


def test_points_of_no_particular_time_are_matched_by_the_path(tmp_path):
    """Points of the parabola z = x tan α - g x² / (2 v² cos² α), in any order."""
    x = np.random.default_rng(1).permutation(np.linspace(0.5, 6.0, 15))
    z = x * np.tan(0.7) - 5.0 * (x / (12.0 * np.cos(0.7))) ** 2
    table(tmp_path / "flight.csv", x=x, z=z)
    spec = "vary: {parameters.speed: [10, 14], parameters.angle: [0.5, 0.9]}\nstarts: 2\n"
    match = "match: {flight: {body: ball, through: flight.csv, over: path}}\n"
    _, numbers = found(written(tmp_path, BALL, spec + match))
    assert numbers == pytest.approx({"speed": 12.0, "angle": 0.7}, rel=1e-9)


def test_values_may_be_over_a_coordinate(tmp_path):
    """The rocker of a crank-rocker over its crank, by Freudenstein's equation; angles are in degrees."""
    a, b, c, d = 0.25, 0.75, 0.6, 0.8
    crank = np.radians(np.arange(10.0, 350.0, 20.0))
    far, height = d - a * np.cos(crank), -a * np.sin(crank)
    span = np.hypot(far, height)
    tip = np.arctan2(height, far) + np.arccos((b**2 + span**2 - c**2) / (2.0 * b * span))
    rocker = np.arctan2(a * np.sin(crank) + b * np.sin(tip), a * np.cos(crank) + b * np.cos(tip) - d)
    swing = np.degrees(rocker - 1.8)
    table(tmp_path / "swing.csv", angle__deg=np.degrees(crank), rocker__deg=swing)
    spec = "vary: {parameters.crank: [0.1, 0.3], parameters.coupler: [0.6, 0.9], parameters.rocker: [0.5, 0.8]}\n"
    match = (
        "match: {swing: {joint: D, quantity: angle, through: swing.csv, over: A.angle, "
        "columns: {A.angle: angle, angle: rocker}}}\nstarts: 2\n"
    )
    scene = FOUR_BAR.replace("output_step: 1/24", "output_step: 1/240")
    _, numbers = found(written(tmp_path, scene, spec + match))
    assert numbers == pytest.approx({"crank": a, "coupler": b, "rocker": c}, abs=1e-8)


def test_what_nothing_in_the_data_fixes_is_said(tmp_path):
    """Free oscillations show k/m alone: x = cos(√(k/m) t) - 1."""
    time = np.linspace(0.0, 2.0, 41)
    table(tmp_path / "x.csv", time__s=time, displacement__m=np.cos(5.0 * time) - 1.0)
    spec = "vary: {parameters.mass: [1 kg, 3 kg], parameters.stiffness: [20 N/m, 90 N/m]}\nstarts: 2\n"
    match = "match: {motion: {joint: rail, quantity: displacement, through: x.csv}}\n"
    design, numbers = found(written(tmp_path, SPRING, spec + match))
    assert numbers["stiffness"] / numbers["mass"] == pytest.approx(25.0, rel=1e-6)
    (said,) = design.knowledge.unseen
    assert said in ("only mass / stiffness is seen, not its factors", "only stiffness / mass is seen, not its factors")
    assert np.isnan(design.knowledge.deviation).all()


def test_measurements_that_the_run_itself_has_made_leave_less_than_its_own_error(tmp_path):
    """The residuals are zero, so that no part of them can be said."""
    scene = SPRING.replace("output_step: 0.01 s", "output_step: 0.1 s, integrator: rk4").replace("0.01 s", "0.1 s")
    with mbproj.run(scene) as results:
        table(tmp_path / "x.csv", time__s=results.time, displacement__m=results.coordinate("rail.displacement").value)
    spec = "vary: {parameters.stiffness: [20 N/m, 90 N/m]}\nstarts: 1\n"
    match = "match: {motion: {joint: rail, quantity: displacement, through: x.csv}}\n"
    design, numbers = found(written(tmp_path, scene, spec + match))
    assert numbers["stiffness"] == pytest.approx(50.0, rel=1e-9)
    assert "the runs' own error is larger than the residuals: take a finer step" in design.notes


#: Parameters that cannot be told apart: changes of a scene, the numbers that vary, and what is said of them.
UNSEEN = {
    "all of an oscillator's": (
        SPRING.replace("stiffness: 50 N/m}", "stiffness: 50 N/m, damping: 3 N*s/m}").replace(
            "free_displacement", "damping: damping, free_displacement"
        ),
        {"mass": (1, 3), "stiffness": (20, 90), "damping": (1, 6)},
        "rail",
        {
            "only mass / damping and damping / stiffness is seen, not its factors",
            "only mass / stiffness and stiffness / damping is seen, not its factors",
        },
    ),
    "a power": (
        SPRING.replace("stiffness: 50 N/m", "base: 2 N/m, ratio: 5").replace(
            "stiffness: stiffness", "stiffness: base*ratio**2"
        ),
        {"base": (1, 4), "ratio": (3, 8)},
        "rail",
        {"only base * ratio^2 is seen, not its factors"},
    ),
    "a product": (
        BALL.replace("idle: 2", "gain: 1")
        .replace("[speed*cos", "[gain*speed*cos")
        .replace("speed*sin", "gain*speed*sin"),
        {"speed": (5, 15), "gain": (0.5, 2)},
        "ball",
        {"only speed * gain is seen, not its factors"},
    ),
    "a sum": (
        BALL.replace("idle: 2", "wind: 1 m/s")
        .replace("[speed*cos(angle)", "[speed + wind")
        .replace("speed*sin", "5*sin"),
        {"speed": (5, 15), "wind": (-3, 3)},
        "ball",
        {
            "nothing changes where these move together: speed -1, wind +1",
            "nothing changes where these move together: speed +1, wind -1",
        },
    ),
}


@pytest.mark.parametrize("what", UNSEEN)
def test_each_kind_of_combination_that_is_not_seen_is_named(what, tmp_path):
    scene, numbers, item, said = UNSEEN[what]
    results = mbproj.run(mbproj.read_scene_text(scene))
    if item == "rail":
        of, moved = "joint: rail, quantity: displacement", results.coordinate("rail.displacement").value
        table(tmp_path / "x.csv", time__s=results.time, displacement__m=moved)
    else:
        of, moved = "body: ball", results.body("ball").position
        table(tmp_path / "x.csv", time__s=results.time, position_x__m=moved[:, 0], position_z__m=moved[:, 2])
    vary = "".join(f"  parameters.{name}: [{low}, {high}]\n" for name, (low, high) in numbers.items())
    spec = f"vary:\n{vary}match: {{motion: {{{of}, through: x.csv}}}}\nstarts: 1\n"
    design, _ = found(written(tmp_path, scene, spec))
    assert len(design.knowledge.unseen) == 1
    assert design.knowledge.unseen[0] in said
    assert np.isnan(design.knowledge.deviation).all()


def test_a_number_without_any_effect_is_an_error(tmp_path):
    flight(tmp_path, 12.0, 0.7)
    spec = "vary: {parameters.speed: [1, 30], parameters.idle: [1, 3]}\nstarts: 2\n"
    said = r"design\.yaml:3:\d+: error: 'idle' changes nothing of what is wanted; leave it out"
    with pytest.raises(mbproj.InputError, match=said):
        found(written(tmp_path, BALL, spec + FLIGHT))


def test_noise_gives_deviations_that_hold(tmp_path):
    """Of noisy throws the true numbers are within one deviation in 68 %, within three in nearly all."""
    spec = "vary: {parameters.speed: [1, 30], parameters.angle: [0, 1.5]}\nstarts: 1\n"
    shares = []
    for seed in range(8):
        flight(tmp_path, 12.0, 0.7, noise=0.02, seed=seed)
        design, numbers = found(written(tmp_path, BALL, spec + FLIGHT))
        assert design.knowledge.is_white
        assert design.knowledge.scatter == pytest.approx(0.02, rel=0.4)
        off = np.array([numbers["speed"] - 12.0, numbers["angle"] - 0.7])
        shares += (np.abs(off) / design.knowledge.deviation).tolist()
    assert 0.45 <= np.mean(np.array(shares) <= 1.0) <= 0.9
    assert max(shares) <= 4.0


def test_a_model_that_lacks_something_is_told_by_its_residuals(tmp_path):
    """Drag, which the scene has not: neighbouring residuals are alike."""
    x, z = 12.0 * np.cos(0.7) * (1.0 - np.exp(-TIMES)), 12.0 * np.sin(0.7) * TIMES - 5.0 * TIMES**2
    table(tmp_path / "flight.csv", time__s=TIMES, position_x__m=x, position_z__m=z)
    spec = "vary: {parameters.speed: [1, 30], parameters.angle: [0, 1.5]}\nstarts: 1\n"
    design, _ = found(written(tmp_path, BALL, spec + FLIGHT))
    assert design.notes == ("the residuals are no noise: neighbours are alike, the model lacks something",)


def test_starts_that_were_searched_are_used_again(tmp_path):
    flight(tmp_path, 12.0, 0.7)
    spec = "vary: {parameters.speed: [1, 30], parameters.angle: [0, 1.5]}\nstarts: {}\n"
    first, _ = found(written(tmp_path, BALL, spec.replace("{}", "2") + FLIGHT))
    second, _ = found(tmp_path / "design.yaml")
    assert (first.reused, second.reused) == (0, 2)
    assert second.x.tolist() == first.x.tolist()
    assert found(tmp_path / "design.yaml", fresh=True)[0].reused == 0


def test_the_best_so_far_is_told(tmp_path):
    flight(tmp_path, 12.0, 0.7, noise=1e-2)
    said = []
    spec = "vary: {parameters.speed: [1, 30], parameters.angle: [0, 1.5]}\nstarts: 2\n"
    design, _ = found(written(tmp_path, BALL, spec + FLIGHT), fresh=True, tell=lambda *told: said.append(told))
    (first, *_), *_, (last, done, whole) = [each for each in said if each[0].startswith("searches")]
    assert (first, done, whole) == ("searches", 2, 2)
    assert last == f"searches; best rms of residuals {np.sqrt(np.mean(design.trial.residuals**2)):.2g} m"


def test_the_best_scene_keeps_its_comments_and_runs(tmp_path):
    flight(tmp_path, 12.0, 0.7)
    scene = BALL.replace("gravity: [0, 0, -10]", "gravity: [0, 0, -10]   # nearly")
    spec = "vary: {bodies.ball.velocity.0: [5, 20], bodies.ball.velocity.2: [5, 20]}\n"
    design, _ = found(written(tmp_path, scene, spec + "starts: 1\n" + FLIGHT))
    path, *_ = DesignFolder(tmp_path / "out", False).write(design)
    assert "gravity: [0, 0, -10]   # nearly" in path.read_text()
    again = read_scene(path)
    assert again.bodies[0].velocity[0] == pytest.approx(12.0 * np.cos(0.7), rel=1e-9)
    assert best_scene(design) == path.read_text()
    DesignFolder(tmp_path / "out", False).write(design)  # its own files may be replaced


def test_an_engine_is_chosen_by_what_is_wanted(tmp_path):
    flight(tmp_path, 12.0, 0.7)
    spec = "vary: {parameters.speed: [1, 30]}\n"
    limit = "subject_to: {slow: {expression: speed, at_most: 11 m/s}}\n"
    smooth = "minimise: {far: {body: ball, quantity: position, component: x, at: end}}\n"
    assert engine_of(read_spec(written(tmp_path, BALL, spec + FLIGHT)), None)[0] == "least_squares"
    assert engine_of(read_spec(written(tmp_path, BALL, spec + FLIGHT + limit)), None)[0] == "slsqp"
    assert engine_of(read_spec(written(tmp_path, BALL, spec + smooth)), None)[0] == "slsqp"
    kinked = smooth.replace("at: end", "at: largest")
    assert engine_of(read_spec(written(tmp_path, BALL, spec + kinked)), None)[0] == "cma"
    with pytest.raises(mbproj.InputError, match="least squares know no constraints"):
        engine_of(read_spec(written(tmp_path, BALL, spec + FLIGHT + limit)), "least_squares")


# Numbers are found again in scenes that roll, that have cams, signals and states, from runs of the truth.

#: A motor whose torque follows an error with a lag: a signal, and a state.
CONTROLLED = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {gain: 3, length: 0.5 m, lag: 0.1 s}
bodies:
  arm: {mass: 1, inertia: [0.02, 0.02, 0.02], position: [0, 0, -length]}
joints: {A: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, -1, 0]}}
signals: {error: "0.5 - A.angle"}
states: {held: {derivative: "(error - held)/lag", initial: 0}}
forces: {motor: {type: torque, body: arm, torque: [0, "-gain*1 N*m*held", 0]}}
simulation: {duration: 1 s, step: 5 ms, output_step: 50 ms}
"""


def scene(name, **changes):
    """A mechanism's scene without what it expects, with shorter runs."""
    text = mechanism(name).read_text(encoding="utf-8").partition("expect:")[0]
    for old, new in changes.items():
        text = text.replace(f"{old}: ", f"{old}: {new}  # ", 1)
    return text


#: Scenes by what they have, what varies (truth, low, high), and what is measured of them.
CASES = {
    "a coin that rolls": (lambda: scene("rolling_coin", time="0.5 s"), {"push": (0.3, 0.1, 0.6)}, "centre"),
    "a ball that rolls": (
        lambda: scene("turntable", time="0.5 s"),
        {"Omega": (3.3, 2.0, 4.0), "x": (0.55, 0.3, 0.7)},
        "centre",
    ),
    "a cam": (lambda: scene("cam"), {"lift": (0.018, 0.01, 0.03), "base": (0.04, 0.03, 0.05)}, "centre"),
    "signals and states": (lambda: CONTROLLED, {"gain": (4.0, 1.0, 8.0), "lag": (0.2, 0.05, 0.4)}, ""),
}


@pytest.mark.parametrize("case", where(lambda case: case != "a cam", CASES))
def test_the_truth_is_found_again(case, tmp_path):
    make, varied, marker = CASES[case]
    text, truth = make(), {name: value for name, (value, _, _) in varied.items()}
    with mbproj.run(mbproj.read_scene_text(text, "scene", truth)) as results:
        every = slice(None, None, max(len(results.time) // 20, 1))
        if marker:
            parts = zip("xyz", results.marker(marker).position[every].T, strict=True)
            table(tmp_path / "m.csv", time__s=results.time[every], **{f"position_{k}__m": part for k, part in parts})
        else:
            table(tmp_path / "m.csv", time__s=results.time, angle__rad=results.coordinate("A.angle").value)
    of = f"marker: {marker}" if marker else "joint: A, quantity: angle"
    vary = "".join(f"  parameters.{name}: [{low}, {high}]\n" for name, (_, low, high) in varied.items())
    spec = f"vary:\n{vary}match: {{m: {{{of}, through: m.csv}}}}\nstarts: 1\n"
    design, numbers = found(written(tmp_path, text, spec))
    assert numbers == pytest.approx(truth, rel=1e-9)
    assert np.sqrt(np.mean(design.trial.residuals**2)) < 1e-11


@pytest.mark.full
def test_a_measure_of_round_off_is_no_measure_where_none_is_named():
    """How well joints close does not depend on numbers but by chance; by its name it is measured all the same."""
    text = CONTROLLED + (
        "expect:\n"
        "  ends: {joint: A, quantity: angle, at: end, below: 10, source: it turns}\n"
        "  closed: {diagnostic: position_violation, at: maximum, below: 1.0e-12, source: joints are closed}\n"
    )
    assert set(mbproj.sensitivity(text, to=["gain"]).table["measure"]) == {"ends"}
    assert set(mbproj.sensitivity(text, of=["closed"], to=["gain"]).table["measure"]) == {"closed"}
