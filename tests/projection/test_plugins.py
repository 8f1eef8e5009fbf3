"""Projection methods, integrators and forces of plug-ins."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import mbproj
from mbproj.base import plugins
from mbproj.base.registry import PROJECTIONS, integrators
from mbproj.functions.elements import Element, Force, Row, State, called
from mbproj.functions.program import Program, number
from mbproj.guide.pages import pages
from mbproj.motion.projection import Method
from mbproj.motion.steppers.plugin import density, holds_up_to, trees
from mbproj.motion.steppers.tableau import tableau_of
from mbproj.scene import parts
from mbproj.scene.blocks.elements import ELEMENTS
from tests.crossed import full
from tests.guide.fences import fences
from tests.support import ROOT

# A projection method from another package: it closes the joints, runs everywhere, and is an error where it is not.

FIVE_BAR = str(ROOT / "mechanisms" / "five_bar.yaml")


PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces:
  spring: {type: hardening_spring, points: {ground: [0, 0, 1], rod: [0.5, 0, 0]}, stiffness: 9 N/m, free_length: 1}
  drive: {type: motor, joint: A, stall_torque: 4 N*m, no_load_speed: 9 rad/s, delay: 50 ms}
simulation: {duration: 0.1, step: 0.01, projection: lumped, integrator: three-eighths}
"""
SWEEP = """\
sweep: 1
scene: scene.yaml
vary: {bodies.rod.mass: {linspace: [1 kg, 2 kg, 2]}}
measure: {open: {diagnostic: position_violation, at: maximum}}
"""
#: The modules of the guide's page, in its order, as one package.
MODULES = ("lumped", "integrator", "spring", "motor")


class Nearest(mbproj.Projection):
    """GOPM's formula in other words."""

    def correction(self, M, C_q, violation):
        return -np.linalg.lstsq(C_q, violation, rcond=None)[0]


@pytest.fixture
def nearest(monkeypatch):
    monkeypatch.setattr(PROJECTIONS, "_added", {})
    monkeypatch.setattr(plugins, "_origins", {})
    mbproj.register_projection("nearest", Nearest, summary="the smallest correction")


@pytest.fixture
def environment(tmp_path) -> dict[str, str]:
    """A folder of installed packages with the one of the guide's page in it."""
    site = tmp_path / "site"
    about = site / "mbproj_lumped-1.0.dist-info"
    about.mkdir(parents=True)
    found = [fence.text for fence in fences(pages()["write_a_plugin"]) if fence.language == "python"]
    points = "[mbproj.plugins]\n"
    for module, code in zip(MODULES, found, strict=True):
        assert len([line for line in code.splitlines() if line]) <= 40
        (site / f"{module}.py").write_text(code, encoding="utf-8")
        points += f"{module} = {module}:register\n"
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mbproj-lumped\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text(points, encoding="utf-8")
    return {"PYTHONPATH": f"{site}:{ROOT}", "MBPROJ_CACHE": str(tmp_path / "cache"), "OPENBLAS_NUM_THREADS": "1"}


def command(folder: Path, environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "mbproj", *words]
    return subprocess.run(line, capture_output=True, text=True, cwd=folder, env=environment, check=False)


def test_a_registered_method_moves_as_the_one_it_equals(nearest):
    settings = {"duration": 0.1, "step": 0.01, "formulation": "full"}
    with (
        mbproj.run(FIVE_BAR, projection="nearest", **settings) as own,
        mbproj.run(FIVE_BAR, projection="gopm", **settings) as gopm,
    ):
        assert own.attributes["position_violation_max"] < 1e-12
        np.testing.assert_allclose(own["bodies/position"], gopm["bodies/position"], atol=1e-11)
        assert own.settings.projection.method == "nearest"
    with mbproj.run(FIVE_BAR, projection="nearest", duration=0.02) as automatic:
        assert automatic.attributes["formulation"] == "full"


def test_a_stabilisation_of_a_plugin_takes_explicit_steps(nearest):
    class Damped(Method):
        stabilises = True

        def stabilised(self, gamma, C, C_dot):
            return gamma - 50.0 * C_dot - 625.0 * C

    mbproj.register_projection("damped", Damped, summary="Baumgarte's with gains of 25 / s")
    settings = {"duration": 0.1, "formulation": "full"}
    with (
        mbproj.run(FIVE_BAR, projection="damped", step=0.01, integrator="rk4", **settings) as own,
        mbproj.run(FIVE_BAR, projection="baumgarte", step=0.01, integrator="rk4", **settings) as same,
    ):
        np.testing.assert_allclose(own["bodies/position"], same["bodies/position"], atol=1e-12)
    for integrator, size in (("esdirk4", {"step": 0.01}), ("auto", {"tolerance": 1e-6})):
        with pytest.raises(mbproj.InputError, match="does not know the stabilisation of the plug-in 'damped'"):
            mbproj.run(FIVE_BAR, projection="damped", integrator=integrator, **size, **settings)


def test_what_cannot_be_registered_is_said(nearest):
    register = mbproj.register_projection
    with pytest.raises(mbproj.InputError, match="mbproj has a projection method 'gopm' itself"):
        register("gopm", Nearest, summary="")
    with pytest.raises(mbproj.InputError, match="'My method' cannot be the name of a projection method"):
        register("My method", Nearest, summary="")
    with pytest.raises(TypeError, match=r"derived from mbproj\.Projection"):
        register("dict", dict, summary="")
    with pytest.raises(TypeError, match="Projection has no method 'correction'"):
        register("empty", mbproj.Projection, summary="")
    with pytest.raises(mbproj.InputError, match="a method has no option 'beta'; options are: alpha, gains"):
        register("other", Nearest, summary="", options=["beta"])


def test_a_method_that_fails_is_said_with_its_name(nearest):
    """So is one whose correction has another shape; that a correction does not exist is a failure of the run."""

    class Broken(Nearest):
        def correction(self, M, C_q, violation):
            return violation[:2]

    class Raising(Nearest):
        def correction(self, M, C_q, violation):
            raise KeyError("weights")

    for name, code in (("broken", Broken), ("raising", Raising)):
        mbproj.register_projection(name, code, summary="")
    message = (
        r"'correction' of projection method 'broken', of a plug-in, has failed: ValueError: Δ has the shape \(2,\)"
    )
    with pytest.raises(mbproj.InputError, match=message):
        mbproj.run(FIVE_BAR, projection="broken", duration=0.02)
    with pytest.raises(mbproj.InputError, match=r"test_plugins.py:\d+: error: 'correction' .* KeyError: 'weights'"):
        mbproj.run(FIVE_BAR, projection="raising", duration=0.02)


#: What a correction may be in place of an array of floats, and the number's type that the message names.
REAL = {
    "list": lambda change: change.tolist(),
    "tuple of numbers of NumPy": tuple,
    "smaller floats": lambda change: change.astype(np.float32).astype(np.longdouble),
}
UNREAL = {
    "finite": lambda change: np.where(np.arange(len(change)) == 2, np.nan, change),
    "SystemExit: 7": lambda change: sys.exit(7),
    "complex": lambda change: change * (1.0 + 1e-9j),
    "complex without an imaginary part": lambda change: change.astype(complex),
    "object": lambda change: change.astype(object),
    "<U": lambda change: [str(each) for each in change],
    "inhomogeneous": lambda change: [[0.0], *change[1:]],
    r"shape \(\)": lambda change: None,
}


@pytest.mark.parametrize("kind", REAL)
def test_a_correction_may_be_any_real_numbers(nearest, kind):
    class Other(Nearest):
        def correction(self, M, C_q, violation):
            return REAL[kind](super().correction(M, C_q, violation))

    mbproj.register_projection("other", Other, summary="")
    with mbproj.run(FIVE_BAR, projection="other", duration=0.05) as results:
        assert np.abs(results["joints/violation"]).max() < 1e-6


@pytest.mark.parametrize("kind", UNREAL)
def test_a_correction_that_is_not_real_is_said_with_the_name_of_the_method(nearest, kind):
    class Other(Nearest):
        def correction(self, M, C_q, violation):
            return UNREAL[kind](super().correction(M, C_q, violation))

    mbproj.register_projection("other", Other, summary="")
    said = rf"'correction' of projection method 'other', of a plug-in, has failed: .*{kind.partition(' ')[0]}"
    with pytest.raises(mbproj.InputError, match=said if kind[0] != "s" else f"'other'.*{kind}"):
        mbproj.run(FIVE_BAR, projection="other", duration=0.02)


@pytest.mark.parametrize("wrong", [lambda gamma: gamma + 1e-9j, lambda gamma: gamma[:2], lambda gamma: "γ"])
def test_a_stabilisation_that_is_not_real_is_said(nearest, wrong):
    class Damped(Method):
        stabilises = True

        def stabilised(self, gamma, C, C_dot):
            return wrong(gamma)

    mbproj.register_projection("damped", Damped, summary="")
    with pytest.raises(mbproj.InputError, match="'stabilised' of projection method 'damped', of a plug-in, has failed"):
        mbproj.run(FIVE_BAR, projection="damped", duration=0.02, step=0.01, integrator="rk4", formulation="full")


def test_a_refusal_that_is_no_text_is_said(nearest):
    class Refusing(Nearest):
        def refusal(self, M):
            return np.linalg.det(M) == 0.0

    mbproj.register_projection("refusing", Refusing, summary="")
    with pytest.raises(mbproj.InputError, match=r"'refusal' of projection method 'refusing'.* no text and not None"):
        mbproj.run(FIVE_BAR, projection="refusing", duration=0.02)


@pytest.mark.parametrize("coefficient", [0.5j, np.complex128(0.5 + 1j), "1_0/20", "１/２"])
def test_a_coefficient_of_a_tableau_is_a_real_number(coefficient):
    with pytest.raises(mbproj.InputError, match="which is no number"):
        mbproj.register_integrator("midpoint", order=2, a=[[coefficient]], b=[0, 1], summary="")


def test_another_code_is_another_study(nearest):
    before = plugins.marks()
    mbproj.register_projection("nearest", type("Other", (Nearest,), {"__module__": "elsewhere"}), summary="changed")
    assert plugins.marks() != before


def test_an_installed_method_runs_in_commands_and_workers(tmp_path, environment):
    done = command(tmp_path, environment, "run", FIVE_BAR, "--projection", "lumped", "--duration", "0.05", "--json")
    assert json.loads(done.stdout)["position_violation_max"] < 1e-12, done.stderr
    assert "lumped" in command(tmp_path, environment, "run", "--help").stdout
    built = json.loads(command(tmp_path, environment, "info", "--build", "--json").stdout)
    assert built["plugins"] == {
        "projection method": {"lumped": "lumped"},
        "integrator": {"three-eighths": "integrator"},
        "force type": {"hardening_spring": "spring", "motor": "motor"},
    }
    (tmp_path / "scene.yaml").write_text(PENDULUM, encoding="utf-8")
    schema = command(tmp_path, environment, "schema").stdout
    assert all(f'"{name}"' in schema for name in ("lumped", "three-eighths", "hardening_spring", "motor"))
    (tmp_path / "spec.yaml").write_text(SWEEP, encoding="utf-8")
    swept = command(tmp_path, environment, "sweep", "spec.yaml", "--jobs", "2", "--json")
    assert json.loads(swept.stdout)["computed"] == 2, swept.stderr
    assert json.loads(swept.stdout)["failed"] == 0


def test_a_method_that_is_not_installed_is_an_error(tmp_path, environment):
    alone = environment | {"PYTHONPATH": str(ROOT)}
    done = command(tmp_path, alone, "run", FIVE_BAR, "--projection", "lumped")
    assert (done.returncode, "unknown projection method 'lumped'" in done.stderr) == (2, True)


def test_a_plug_in_that_fails_is_a_note_where_it_is_asked_for(tmp_path, environment):
    (tmp_path / "site" / "lumped.py").write_text("raise ValueError('no')\n", encoding="utf-8")
    note = "note: the plug-in 'lumped' (lumped:register) does not work: ValueError: no"
    asked = command(tmp_path, environment, "run", FIVE_BAR, "--projection", "lumped")
    assert (asked.returncode, note in asked.stderr) == (2, True)
    assert "unknown projection method 'lumped'" in asked.stderr
    other = command(tmp_path, environment, "run", FIVE_BAR, "--duration", "0.02", "--formulation", "full")
    assert (other.returncode, other.stderr) == (0, "")


def test_a_plug_in_that_ends_the_process_is_a_note_too(tmp_path, environment):
    (tmp_path / "site" / "lumped.py").write_text("import sys\nsys.exit(7)\n", encoding="utf-8")
    done = command(tmp_path, environment, "run", FIVE_BAR, "--projection", "lumped")
    note = "note: the plug-in 'lumped' (lumped:register) does not work: SystemExit: 7"
    assert (done.returncode, note in done.stderr) == (2, True)
    assert command(tmp_path, environment, "run", "--help").returncode == 0


# Integrators and forces of plug-ins: they equal what mbproj has of the same formula, and what is wrong is refused.

FORCED_PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {F: {FORCE}}
simulation: {duration: 0.3, step: 0.01}
"""
POINTS = "points: {ground: [0.5, 0, 1], rod: [0.5, 0, 0]}"
#: Bogacki-Shampine's pair, whose extension is the cubic that follows where none is given.
BS32 = {
    "order": 3,
    "a": [["1/2"], ["0", "3/4"]],
    "b": ["2/9", "1/3", "4/9"],
    "error": ["-5/72", "1/12", "1/9", "-1/8"],
    "summary": "",
}
GAMMA = 1 - 0.5**0.5
#: Two stages of an L-stable method of order 2 (Alexander 1977) after an explicit one.
SDIRK = {
    "order": 2,
    "a": [[0, 0, 0], [0, GAMMA, 0], [0, 1 - GAMMA, GAMMA]],
    "b": [0, 1 - GAMMA, GAMMA],
    "error": [0.1, (1 - GAMMA) * -0.1 / GAMMA, 0.1 * (1 - GAMMA) / GAMMA - 0.1],
    "summary": "",
}
TRAPEZOID = {"order": 2, "a": [["1/2", "1/2"]], "b": ["1/2", "1/2"], "summary": "", "error": [1, -1]}
SPRING = {
    "along": "m",
    "force": "-k*(s - free) - c*s_dot",
    "parameters": {"k": "N/m", "c": "N*s/m", "free": "m"},
    "defaults": {"c": 0.0},
    "stores": "k*(s - free)**2/2",
    "loses": True,
}


@pytest.fixture(autouse=True)
def alone(monkeypatch):
    """Registries that forget what a test adds."""
    for registry in (integrators(), ELEMENTS):
        monkeypatch.setattr(registry, "_added", {})
    monkeypatch.setattr(plugins, "_origins", {})


def scene(force: str) -> str:
    return FORCED_PENDULUM.replace("FORCE", force)


@pytest.mark.parametrize("name", integrators())
def test_order_conditions_find_the_orders_of_all_tableaus(name):
    """The estimate of an embedded pair is of the lower order."""
    tableau, entry = tableau_of(name), integrators()[name]
    assert holds_up_to(tableau.a, tableau.b) == entry.order
    if entry.embedded:
        a = tableau.a
        if not entry.implicit:
            a = np.zeros((tableau.stages + 1,) * 2)
            a[:-1, :-1], a[-1, :-1] = tableau.a, tableau.b
        found = holds_up_to(a, np.atleast_2d(tableau.error)[0], exact=False)
        assert found == {"dop853": 5}.get(name, tableau.error_order)


def test_there_are_as_many_trees_as_the_theory_has():
    """Table 2.1 of Hairer, Nørsett & Wanner; γ of the trees with four vertices are 4, 8, 12, 24."""
    assert [len(trees(order)) for order in range(1, 10)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]
    assert sorted(map(density, trees(4))) == [4, 8, 12, 24]


@pytest.mark.parametrize("formulation", [full("full"), "auto"])
def test_a_tableau_steps_as_the_same_one_of_mbproj(formulation):
    mbproj.register_integrator("pair", **BS32)
    run = partial(mbproj.run, FIVE_BAR, tolerance=1e-6, duration=0.1, formulation=formulation)
    with run(integrator="pair") as own, run(integrator="bs32") as known:
        assert own.attributes["steps"] == known.attributes["steps"] >= 20
        np.testing.assert_allclose(own["bodies/position"], known["bodies/position"], atol=1e-14)


def test_a_tableau_with_a_diagonal_is_implicit():
    """Its error falls with the square of the step, and a stiff damper does not hold it up."""
    mbproj.register_integrator("sdirk2", **SDIRK)
    assert integrators()["sdirk2"].implicit
    text = scene(f"type: spring_damper, {POINTS}, stiffness: 40, damping: 5e3, free_length: 0.9")
    exact = mbproj.run(text, integrator="radau5", tolerance=1e-11)["bodies/position"][-1]
    errors = []
    for step in (0.01, 0.005):
        with mbproj.run(text, integrator="sdirk2", step=step) as results:
            errors.append(np.abs(results["bodies/position"][-1] - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.3)


WRONG_TABLEAUS = [
    (BS32 | {"b": ["2/9", "1/3", "4/8"]}, "of order 0, not 3: a condition of order 1 is missed by 0.056"),
    (BS32 | {"a": [["1/2"], ["0", "2/3"]]}, "of order 1, not 3: a condition of order 2"),
    (BS32 | {"order": 4}, "of order 3, not 4"),
    (BS32 | {"order": 11}, "an order of 11 cannot be checked; it is 1 to 10"),
    (BS32 | {"a": [["1/2"]]}, "'a' has 1 rows beside 3 weights in 'b'"),
    (BS32 | {"b": ["2/9", "1/3", "4/0"]}, "a tableau has '4/0', which is no number"),
    (BS32 | {"error": ["-5/72", "1/12", "1/9"]}, "'error' has 3 weights, not 4; it has one for each stage, and one"),
    (BS32 | {"error": ["-5/72", "1/12", "1/9", "1/8"]}, "'error' is an estimate of order 1 in the step"),
    (BS32 | {"dense": [[1]] * 4}, "'dense' does not join both ends"),
    (SDIRK | {"error": None}, "an implicit method needs 'error'"),
    (SDIRK | {"a": [[0], [0, "1/2"], [0, 1 - GAMMA, GAMMA]]}, "of order 1, not 2"),
    (TRAPEZOID | {"error": [1, 2]}, "'error' is an estimate of order 1"),
    (TRAPEZOID | {"order": 1, "a": [["3/4", "1/4"]], "b": ["3/4", "1/4"]}, "it is not A-stable"),
    (TRAPEZOID | {"order": 1, "a": [["1/2", "1/2"], [0, 1]], "b": [0, 1, 0]}, "its stages have several γ"),
]


@pytest.mark.parametrize(("given", "message"), WRONG_TABLEAUS, ids=[message for _, message in WRONG_TABLEAUS])
def test_a_wrong_tableau_is_refused(given, message):
    with pytest.raises(mbproj.InputError, match=f"(?s){message.replace('(', '.')}"):
        mbproj.register_integrator("wrong", **given)


@pytest.mark.parametrize("formulation", ["full", "auto"])
def test_a_force_moves_as_the_one_it_equals(formulation):
    """And its account of energy is that of a spring with a damper."""
    mbproj.register_force("own_spring", **SPRING)
    own_text = scene(f"type: own_spring, {POINTS}, k: 40 N/m, c: 2 N*s/m, free: 80 cm")
    known_text = scene(f"type: spring_damper, {POINTS}, stiffness: 40, damping: 2, free_length: 0.8")
    run = partial(mbproj.run, formulation=formulation)
    with run(own_text) as own, run(known_text) as known:
        np.testing.assert_allclose(own["bodies/position"], known["bodies/position"], atol=1e-14)
        for account in ("energy_dissipated", "energy_put_in", "energy_drift"):
            assert own.attributes[account] == pytest.approx(known.attributes[account], abs=1e-6)
        assert own.attributes["energy_dissipated"] > 0.05


def test_a_force_has_a_class_of_its_words():
    mbproj.register_force("own_spring", **SPRING)
    made = parts.OwnSpring(joint="A", k="3 N/m", free=0.1)
    assert dict(made) == {"type": "own_spring", "joint": "A", "k": "3 N/m", "free": 0.1}
    with pytest.raises(TypeError, match="lacks the argument 'free'"):
        parts.OwnSpring(joint="A", k=3)
    with pytest.raises(AttributeError, match="has no attribute 'NoSpring'"):
        parts.__getattr__("NoSpring")


def test_an_element_has_a_state():
    """A torque T that follows its target with the delay τ is T₀ (1 - exp(-t/τ)) where nothing turns."""

    def lagged(name: str, s: str, target: float, delay: float) -> Element:
        torque = called(f"{name}.torque")
        state = State("torque", f"({target!r} - {torque})/{delay!r}", unit="N*m")
        return Element(name, reads=(f"{name}.torque",), states=(state,), forces=(Force(s, torque),))

    keys = {"target": "N*m", "delay": "s"}
    mbproj.register_element("lagged", lagged, along="rad", parameters=keys, positive=["delay"])
    with mbproj.run(scene("type: lagged, joint: A, target: 3 N*m, delay: 100 ms"), step=0.005) as results:
        expected = 3 * (1 - np.exp(-results["time"][:] / 0.1))
        np.testing.assert_allclose(results["states/value"][:, 0], expected, atol=1e-7)
    with pytest.raises(mbproj.InputError, match="'delay' must be greater than 0, found 0"):
        mbproj.run(scene("type: lagged, joint: A, target: 3 N*m, delay: 0 s"))


WRONG_FORCES = [
    ({"force": "-k*(s - free)**2"}, r"'-k\*\(s - free\)\*\*2' is in m\*kg/s\^2\*m|is a torque, not in N"),
    ({"force": "-k*x"}, "unknown name 'x'; variables here are s, s_dot, t, k, c, free"),
    ({"force": "-k*s - free"}, "a force and a length cannot be added"),
    ({"stores": "k*s"}, "'k.s' is a force, not in J"),
    ({"along": "deg"}, "'along' is 'm' or 'rad', found 'deg'"),
    ({"parameters": {"s": "m"}}, "'s' cannot be the name of a parameter"),
    ({"parameters": {"k": "N/parsec"}}, "parameter 'k': 'N/parsec' is no unit"),
    ({"positive": ["d"]}, "there is no parameter 'd'; parameters are: k, c, free"),
]


@pytest.mark.parametrize(("change", "message"), WRONG_FORCES, ids=[message for _, message in WRONG_FORCES])
def test_a_wrong_force_is_refused(change, message):
    with pytest.raises(mbproj.InputError, match=message):
        mbproj.register_force("own_spring", **{**SPRING, **change})


def test_a_name_of_mbproj_is_taken():
    with pytest.raises(mbproj.InputError, match="mbproj has a force type 'spring_damper' itself"):
        mbproj.register_force("spring_damper", **SPRING)
    with pytest.raises(mbproj.InputError, match="mbproj has an integrator 'auto' itself"):
        mbproj.register_integrator("auto", **BS32)


def test_code_that_fails_is_said_with_its_name():
    """An element's, and a projection method's, with the line of the code."""

    def fails(name: str, s: str, k: float) -> Element:
        raise ZeroDivisionError("no")

    mbproj.register_element("fails", fails, along="m", parameters={"k": "N/m"})
    message = r"test_plugins.py:\d+: error: force type 'fails', of a plug-in, has failed: ZeroDivisionError: no"
    with pytest.raises(mbproj.InputError, match=message):
        mbproj.run(scene(f"type: fails, {POINTS}, k: 3"))
    mbproj.register_element("empty", lambda name, s: None, along="m", parameters={})
    with pytest.raises(mbproj.InputError, match=r"it makes None, which is no mbproj\.functions\.elements\.Element"):
        mbproj.run(scene(f"type: empty, {POINTS}"))


#: Elements with a number that is not real, and what the message names.
UNREAL_FORCES = {
    "'start' of state 'x'": {"states": (State("x", "0", start=0.5j),)},
    "'scale' of state 'x'": {"states": (State("x", "0", scale=np.complex128(1 + 1j)),)},
    "the inertia of": {"inertias": {"A.angle": 1 + 1e-9j}},
    "a place of the length 'left'": {"lengths": {"left": ((0.0, 1j, 0.0), "rod")}},
    "'constant' of row 'r'": {"rows": (Row("r", {"A.angle": 1.0}, constant="0.5"),)},
    "'of' of row 'r'": {"rows": (Row("r", {"A.angle": np.complex128(1j)}),)},
    "constant": {"stores": Program(number(1j))},
}


@pytest.mark.parametrize("said", UNREAL_FORCES)
def test_a_number_of_an_element_that_is_not_real_is_said(said):
    def make(name, s, **values):
        return Element(name, reads=(s,), **UNREAL_FORCES[said])

    mbproj.register_element("unreal", make, along="rad", parameters={})
    text = FORCED_PENDULUM.replace("FORCE", "type: unreal, joint: A")
    with pytest.raises(mbproj.InputError, match=r"'unreal', of a plug-in, has failed: TypeError: .*no real") as error:
        mbproj.run(mbproj.read_scene_text(text))
    assert said in str(error.value)


def test_a_default_that_is_not_real_is_said():
    with pytest.raises(mbproj.InputError, match="the default of 'c' is 1j, which is no real number"):
        mbproj.register_force("spring", **{**SPRING, "defaults": {"c": 1j}})


def test_the_coordinate_of_a_formula_is_not_taken_for_seconds():
    """In `5 N/m*s` the s could be the coordinate or the second, in a formula and in an expression of an element."""
    said = "'s' could be the unit s, or the 's' that is named here; write "
    with pytest.raises(mbproj.InputError, match=f"{said}.5 N/m.\\*s for what 's' names"):
        mbproj.register_force("spring", along="m", force="-5 N/m*s", parameters={})

    def make(name, s):
        return Element(name, reads=(s,), forces=(Force(s, "-5 N*m/min*s"),))

    mbproj.register_element("spring", make, along="rad", parameters={})
    with pytest.raises(mbproj.InputError, match=f"element 'F'.*{said}"):
        mbproj.run(mbproj.read_scene_text(FORCED_PENDULUM.replace("FORCE", "type: spring, joint: A")))
    mbproj.register_force("spring", along="m", force="-(5 N/m)*s", parameters={})
