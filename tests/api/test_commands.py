"""Every command that computes is a function of its name, with the words and the findings of the command."""

from __future__ import annotations

import inspect
import json

import numpy as np
import pytest
from click.testing import CliRunner

import mbproj
from mbproj.commands.main import MODULES
from mbproj.commands.main import mbproj as group
from tests.support import ROOT

FIVE_BAR = ROOT / "mechanisms" / "five_bar.yaml"
PENDULUM = ROOT / "mechanisms" / "physical_pendulum.yaml"
#: Commands whose output is an object, and what their function is called where it has another name.
FUNCTIONS = (
    "run",
    "rerun",
    "continue",
    "check",
    "branches",
    "export",
    "verify",
    "stability",
    "compare-results",
    "equilibrium",
    "modes",
    "linearize",
    "recommend",
    "compare",
    "tradeoff",
    "threshold",
    "batch",
    "sweep",
    "schema",
    "new",
    "import",
    "paper",
    "fit",
    "optimise",
    "sensitivity",
)
#: Options that only say what is printed or written, for which the objects have methods.
PRINTS = {
    "as_json",
    "ending",
    "font",
    "force",
    "help",
    "output",
    "picture",
    "picture_path",
    "quiet",
    "store",
    "size",
    "strict",
    "style",
    "table_file",
    "write",
    "xml",
}
#: Options of a command's own with another way in Python.
ELSEWHERE = {
    "equilibrium": {"starts"},  # equilibria
    "modes": {"vary"},  # traces
    "run": {"accuracy"},  # recommend
    "sweep": {"dry", "yes", "show"},
    "optimise": {"topologies"},  # which search for mechanisms
    "export": {"only_list", "mjcf", "urdf", "settings"},  # export_model
}
#: Python's names of what is called otherwise in a command's code.
NAMES = {
    "settings": "parameters",
    "changes": "parameters",
    "where": "at",
    "time": "at",
    "goal": "error",
    "key": "at",
    "chosen": "table",
    "file_format": "format",
    "folder": "output",
    "context": None,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_takes_the_words_of_its_command(name):
    module = MODULES.get(name, name.replace("-", "_"))
    command = group.get_command(None, name)
    taken = inspect.signature(getattr(mbproj, module)).parameters
    words = {each.name for each in command.params} - PRINTS - ELSEWHERE.get(name, set())
    missing = {word for word in words if NAMES.get(word, word) not in taken}
    if any(each.kind is inspect.Parameter.VAR_KEYWORD for each in taken.values()):  # the numbers of templates
        missing = set()
    assert missing == set()


def printed(*words):
    return json.loads(CliRunner().invoke(group, [str(word) for word in words], catch_exceptions=False).stdout)


def test_check_is_the_command():
    found = mbproj.check(FIVE_BAR, parameters={"length": np.float32(1.25)}, projection="gopm")
    expected = printed("check", FIVE_BAR, "--set", "length=1.25", "--projection", "gopm", "--json")
    assert json.loads(json.dumps({"scene": expected["scene"], **found.facts})) == expected
    assert (found.degrees_of_freedom, found.can_run) == (5, True)
    assert found.table["coordinate"][0] == "A.angle"
    assert "5 degrees of freedom, can run" in repr(found)
    with pytest.raises(TypeError, match="did you mean 'projection'"):
        mbproj.check(FIVE_BAR, projektion="gopm")
    with pytest.raises(mbproj.InputError, match=r"^step: error"):
        mbproj.check(FIVE_BAR, step=-1)


def test_compare_takes_arrays_and_names():
    found = mbproj.compare(
        PENDULUM, projections="gopm,gpopm", steps=np.array([0.01, 0.02]), until=np.float32(0.125), repeat=1, jobs=1
    )
    assert len(found.entries) == 4
    assert next(iter(found.table["label"])) == "gopm, h = 0.01 s"
    assert (found.table["error"] > 0).all()
    assert "<table>" in found._repr_html_()
    with pytest.raises(mbproj.InputError, match=r"^steps: error: 'steps' must be greater than 0"):
        mbproj.compare(PENDULUM, steps=[0.01, -1])


@pytest.mark.parametrize(("old", "new"), [("repetitions", "repeat"), ("processes", "jobs"), ("tell", "progress")])
def test_earlier_names_of_arguments_are_refused_with_the_new_one(old, new):
    for study in (mbproj.compare, mbproj.threshold):
        with pytest.raises(TypeError, match=rf"\(\) has no argument '{old}': its name is '{new}'"):
            study(PENDULUM, **{old: 1})


def test_the_earlier_way_to_start_where_it_rests_is_refused_with_the_present_one():
    with pytest.raises(TypeError, match=r"^run\(\) has no argument 'from_equilibrium': its name is 'start'"):
        mbproj.run(PENDULUM, from_equilibrium=True)
    done = CliRunner().invoke(group, ["run", "scene.yaml", "--from-equilibrium"])
    assert (done.exit_code, "Did you mean '--start equilibrium'?" in done.output) == (2, True), done.output


def test_threshold_and_stability():
    found = mbproj.threshold(PENDULUM, thresholds=["1e-8", 1e-4], until=0.1, repeat=1, jobs=1, projection="gopm")
    assert list(found.table["projection"]) == ["gopm"] * 3 + ["none"]
    limits = mbproj.stability(
        PENDULUM, "step", projections="gopm", low="1 ms", high=0.5, points=3, until=0.2, closed=1e-6, jobs=1
    )
    assert limits.limits.closed == 1e-6
    assert set(limits.table["projection"]) == {"gopm"}
    with pytest.raises(mbproj.InputError, match="let low be below high"):
        mbproj.stability(PENDULUM, "step", low=1, high=0.1, until=0.1)


def test_recommend_keeps_what_is_asked():
    found = mbproj.recommend(PENDULUM, "1 mm", until=0.1, timed=False)
    assert found.reached
    assert found.table["error"][0] <= 1e-3
    assert next(iter(found.table["kind"])) == "best"
    assert "keeps 0.001 m" in repr(found)


def test_rerun_and_continue_give_the_bits_of_one_run(tmp_path):
    whole = mbproj.run(FIVE_BAR, duration=0.2)
    part = mbproj.run(FIVE_BAR, duration=0.1, output=tmp_path / "part.h5")
    again = mbproj.rerun(part)
    np.testing.assert_array_equal(again["bodies/position"], part["bodies/position"])
    more = mbproj.continue_run(part, until=0.2)
    np.testing.assert_array_equal(more["bodies/position"][-1], whole["bodies/position"][-1])
    part.close()
    both = mbproj.continue_run(tmp_path / "part.h5", until="0.2 s", append=True)
    assert both.path == tmp_path / "part.h5"
    np.testing.assert_array_equal(both["bodies/position"], whole["bodies/position"])
    assert mbproj.compare_results(both, whole).same
    with pytest.raises(mbproj.InputError, match=r"^until: error: the run has already reached t = 0.2 s"):
        mbproj.continue_run(both, until=0.1)


def test_results_that_differ_say_where():
    with mbproj.run(FIVE_BAR, duration=0.2) as one, mbproj.run(FIVE_BAR, duration=0.2, step=0.02) as other:
        found = mbproj.compare_results(one, other, absolute={"bodies/position": "1 mm"})
    rows = dict(zip(found.table["quantity"], found.table["allowed"], strict=True))
    assert rows["bodies/position"] == 1e-3
    assert repr(found).startswith("MotionComparison: ")
    with pytest.raises(mbproj.InputError, match="did you mean 'bodies/position'"):
        mbproj.compare_results(one.path, other.path, absolute={"bodies/positon": 1})


def test_export_and_loads(tmp_path):
    with mbproj.run(FIVE_BAR, duration=0.1) as results:
        files = mbproj.export(results, output=tmp_path, table="joint-A,diagnostics")
        assert sorted(files) == ["diagnostics", "joint-A"]
        assert files["joint-A"].read_text(encoding="utf-8").startswith("time (s),")
        felt = mbproj.largest_loads(results)
        force = np.linalg.norm(results.joint("A").reaction_force, axis=1).max()
        row = [name == "A" and of == "reaction_force" for name, of in zip(felt["name"], felt["quantity"], strict=True)]
        assert felt["largest"][row] >= force * (1 - 1e-12)
        with pytest.raises(mbproj.InputError, match=r"^format: error: unknown format 'xls'"):
            mbproj.export(results, output=tmp_path, format="xls")


def test_batch_is_a_table(tmp_path):
    found = mbproj.batch(PENDULUM, jobs=1, timeout="1 min")
    assert found.holds
    assert list(found.table["hold"]) == list(found.table["expectations"])
    with pytest.raises(mbproj.InputError, match="there is no"):
        mbproj.batch([tmp_path / "none.yaml"])


def test_scenes_from_templates_and_models(tmp_path):
    scene = mbproj.new("slider-crank", crank=np.float64(0.08), rod="200 mm")
    assert mbproj.check(scene).can_run
    assert (scene.parameters["crank"], scene.parameters["rod"]) == (0.08, 0.2)
    with pytest.raises(mbproj.InputError, match="did you mean 'slider-crank'"):
        mbproj.new("slider-crnk")
    model = tmp_path / "arm.urdf"
    link = "<link name='{}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
    joint = "<joint name='J' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 1 0'/></joint>"
    model.write_text(f"<robot name='arm'>{link.format('a')}{link.format('b')}{joint}</robot>", encoding="utf-8")
    found = mbproj.import_model(model)
    assert [each.name for each in found.scene.joints][-1] == "J"
    assert found.table.headings == ("element", "place", "what", "same")
    written = mbproj.export_model(PENDULUM, "urdf")
    assert written.text.lstrip().startswith("<")
    with pytest.raises(mbproj.InputError, match=r"^format: error: unknown format 'sdf'"):
        mbproj.export_model(PENDULUM, "sdf")


def test_traces_and_other_equilibria():
    frequencies = mbproj.traces(FIVE_BAR, "mass", [1, np.float32(2)], at="equilibrium", count=2)
    np.testing.assert_allclose(frequencies.eigenvalues[0], frequencies.eigenvalues[1], rtol=1e-6)  # mass cancels
    found = mbproj.equilibria(PENDULUM, starts=3)
    assert found[0].stable
    assert "stable; forces balance" in repr(found[0])
    modes = mbproj.modes(PENDULUM, at="equilibrium")
    assert modes.table["frequency"][0] == modes.frequencies[0]
    assert len(repr(modes)) < 400
    model = mbproj.linearize(
        PENDULUM, found[0].table["coordinate"][0], found[0].table["coordinate"][0], at="equilibrium"
    )
    assert np.array_equal(np.array([row[1:] for row in model.table.rows], dtype=float)[:2, :2], model.A)
