"""Every command is a function of Python, with the words and the findings of the command."""

from __future__ import annotations

import csv
import gc
import inspect
import json
import re
import sys

import numpy as np
import pytest
from click.testing import CliRunner

import mbproj
from mbproj.base.settings import SETTINGS
from mbproj.commands.declared import Asked
from mbproj.commands.main import MODULES
from mbproj.commands.main import mbproj as group
from tests.studies.sweep.specs import write
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
    "curve",
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
    "export": {"only_list", "mjcf", "urdf", "changes"},  # export_model
}
#: Python's names of what is called otherwise in a command's code.
NAMES = {
    "changes": "parameters",
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


def test_curve_is_the_command():
    cam = ROOT / "mechanisms" / "cam.yaml"
    sheet = mbproj.curve(cam, rows=np.int64(13))
    told = printed("curve", cam, "--rows", "13", "--json")
    assert {name: column.tolist() for name, column in sheet.columns().items()} == told["table"]
    assert {side: radius if np.isfinite(radius) else None for side, radius in sheet.rollers.items()} == told[
        "largest_roller"
    ]
    with pytest.raises(mbproj.InputError, match=r"^rows: error: it must be at least 2, found 1"):
        mbproj.curve(cam, rows=1)


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
    assert (done.exit_code, "'--from-equilibrium'; give --start equilibrium" in done.output) == (2, True), done.output


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
        with pytest.raises(mbproj.InputError, match=r"^format: error: there is no 'xls'"):
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
    with pytest.raises(mbproj.InputError, match=r"^format: error: there is no 'sdf'"):
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


# `mbproj.run`, `.modes`, `.equilibrium`, `.linearize`: what they give is what the commands give, from any scene.

ROD = {
    "mbproj": 1,
    "parameters": {"length": 0.5},
    "bodies": {"rod": {"mass": 2, "inertia": [0.1, 0.1, 0.1], "position": ["length", 0, 0]}},
    "joints": {
        "A": {"type": "revolute", "bodies": ["ground", "rod"], "location": [0, 0, 0], "axis": [0, 0, 1]},
    },
    "gravity": [0, -9.81, 0],
    "simulation": {"duration": 0.1, "step": 0.01},
}


def test_run_records_what_the_parts_give():
    scene = mbproj.read_scene(FIVE_BAR, {}, {"duration": 0.05})
    system = mbproj.compile_system(scene)
    start = mbproj.assemble(system, mbproj.initial_guess(scene, system))
    report = mbproj.simulate(system, start, mbproj.settings_to_run(scene))
    with mbproj.run(FIVE_BAR, duration=0.05) as results:
        assert results.time[-1] == pytest.approx(0.05)
        assert results.attributes["position_violation_max"] == report.position_violation.value


@pytest.mark.parametrize("form", ["path", "text", "mapping", "scene"])
def test_every_form_of_a_scene_gives_the_same_motion(form, tmp_path):
    scene = mbproj.read_scene_text(ROD)
    path = tmp_path / "pendulum.yaml"
    path.write_text(scene.text, encoding="utf-8")
    given = {"path": path, "text": scene.text, "mapping": ROD, "scene": scene}[form]
    with mbproj.run(given, step=np.float64(0.005), parameters={"length": np.float64(0.4)}) as results:
        assert results.settings.step == 0.005
        assert results["bodies/position"][0, 0] == pytest.approx([0.4, 0.0, 0.0])
        energy = results["diagnostics/total_energy"]
    assert energy == pytest.approx(energy[0], abs=1e-6)


def test_run_takes_the_words_of_the_command_line():
    assert set(SETTINGS) <= set(inspect.signature(mbproj.run).parameters)


def test_certified_run_says_how_long_it_holds():
    with mbproj.run(ROD, certify=True, limits=[1e-3]) as results:
        assert results.trust.limits == (1e-3,)


@pytest.mark.parametrize(
    ("words", "call"),
    [
        (("compare", PENDULUM, "--repeat", "0"), lambda: mbproj.compare(PENDULUM, repeat=0)),
        (("compare", PENDULUM, "--steps", "1 ms,0"), lambda: mbproj.compare(PENDULUM, steps=["1 ms", 0])),
        (("compare", PENDULUM, "--gains", "1,2,3"), lambda: mbproj.compare(PENDULUM, gains=["1,2,3"])),
        (("compare", PENDULUM, "--energy-rows", "yes"), lambda: mbproj.compare(PENDULUM, energy_rows="yes")),
        (("tradeoff", PENDULUM, "--formulation", "ful"), lambda: mbproj.tradeoff(PENDULUM, formulation="ful")),
        (("recommend", PENDULUM, "--error", "0 m"), lambda: mbproj.recommend(PENDULUM, "0 m")),
        (
            ("stability", PENDULUM, "--vary", "step", "--points", "1"),
            lambda: mbproj.stability(PENDULUM, "step", points=1),
        ),
        (("modes", PENDULUM, "--count", "0"), lambda: mbproj.modes(PENDULUM, count=0)),
        (("modes", PENDULUM, "--at", "noon"), lambda: mbproj.modes(PENDULUM, at="noon")),
        (("equilibrium", PENDULUM, "--at", "-1"), lambda: mbproj.equilibrium(PENDULUM, at=-1)),
        (("branches", PENDULUM, "--starts", "0"), lambda: mbproj.branches(PENDULUM, starts=0)),
        (("curve", PENDULUM, "--rows", "1"), lambda: mbproj.curve(PENDULUM, rows=1)),
        (("schema", "--of", "rum"), lambda: mbproj.schema("rum")),
        (("batch", PENDULUM, "--timeout", "0"), lambda: mbproj.batch(PENDULUM, timeout=0)),
        (("paper", "-o", "f", "--duration", "1 m"), lambda: mbproj.paper(duration="1 m")),
        (("sweep", "s.yaml", "--max-failures", "-1"), lambda: mbproj.sweep("s.yaml", most_failures=-1)),
        (("fit", "s.yaml", "--engine", "newton"), lambda: mbproj.fit("s.yaml", engine="newton")),
        (("run", PENDULUM, "--certify", "--limit", "0"), lambda: mbproj.run(PENDULUM, certify=True, limits=[0])),
        (("run", PENDULUM, "--step", "-1"), lambda: mbproj.run(PENDULUM, step=-1)),
        (
            ("compare-results", "a.h5", "b.h5", "--absolute", "x=1"),
            lambda: mbproj.compare_results("a.h5", "b.h5", absolute={"x": 1}),
        ),
        (("export", "a.h5", "--format", "xls"), lambda: mbproj.export("a.h5", format="xls")),
        (("export", "a.h5", "--transmission", "a,b"), lambda: mbproj.export("a.h5", transmission=["a,b"])),
    ],
    ids=lambda each: " ".join(map(str, each[::2])) if isinstance(each, tuple) else "",
)
def test_an_option_and_its_argument_have_the_same_message(words, call):
    """But for their names: --max-failures there, most_failures here."""
    said = CliRunner().invoke(group, [str(word) for word in words]).exception
    with pytest.raises(mbproj.InputError) as raised:
        call()
    assert isinstance(said, mbproj.InputError)
    (on_line,), (in_python,) = said.problems, raised.value.problems
    plain = re.compile(r"--|'|most_failures|max-failures|limits?\b")
    assert plain.sub("", on_line.message) == plain.sub("", in_python.message)
    assert on_line.place.file.startswith("--")
    assert in_python.place.file == NAMED.get(
        on_line.place.file, on_line.place.file[2:].partition(" ")[0].replace("-", "_")
    )


#: The arguments of options with another name.
NAMED = {"--max-failures": "most_failures", "--limit": "limits"}


@pytest.mark.parametrize("study", [mbproj.sweep, mbproj.batch, mbproj.fit, mbproj.optimise])
def test_a_command_reads_the_effort_that_it_is_given(study):
    """Also where it reads the arguments itself, as commands do that an interruption leaves with what is done."""
    named = {"spec": "s.yaml", "paths": ("s.yaml",)}
    asked = Asked(study, {**named, "fresh": True, "jobs": 3, "retry_failed": True}).read()
    assert (asked.fresh, asked.where) == (True, 3)
    assert Asked(study, {**named, "fresh": False, "jobs": None}).read().fresh is False


def test_problems_name_arguments():
    with pytest.raises(mbproj.InputError, match=r"^step: error: 'step' must be greater than 0, found -1"):
        mbproj.run(ROD, step=-1)
    with pytest.raises(mbproj.InputError, match=r"^parameters\['lenght'\]: error: unknown parameter 'lenght'; did you"):
        mbproj.run(ROD, parameters={"lenght": 1})
    with pytest.raises(mbproj.InputError, match=r"^limits: error: needs certify"):
        mbproj.run(ROD, limits=[1e-3])
    with pytest.raises(TypeError, match="found int"):
        mbproj.run(3)


def test_a_temporary_file_goes_with_its_results(tmp_path):
    results = mbproj.run(ROD)
    folder = results.path.parent
    assert folder.exists()
    results.close()
    del results
    gc.collect()
    assert not folder.exists()
    mbproj.run(ROD, output=tmp_path / "kept.h5").close()
    assert mbproj.open_results(tmp_path / "kept.h5").status == "complete"


def test_results_say_what_they_are(tmp_path):
    scene = mbproj.read_scene_text({**ROD, "title": "<b>bob</b>"})
    results = mbproj.run(scene)
    assert repr(results).splitlines()[0] == "Results: <b>bob</b>"
    assert "11 from 0 to 0.1 s" in repr(results)
    assert "&lt;b&gt;bob" in results._repr_html_()
    assert "<b>" not in results._repr_html_()
    results.close()
    assert repr(results).endswith("closed")


def test_linear_functions_know_the_pendulum():
    """About its lowest point: ω² = m g l / (J + m l²)."""
    scene = mbproj.read_scene_text(ROD)
    rest = mbproj.equilibrium(scene)
    assert rest.stable
    found = mbproj.modes(scene, at="equilibrium")
    expected = np.sqrt(2 * 9.81 * 0.5 / (0.1 + 2 * 0.5**2)) / (2 * np.pi)
    assert found.frequencies[0] == pytest.approx(expected, rel=1e-9)
    model = mbproj.linearize(scene, ["A.angle"], "A.angle", at="equilibrium")
    A, _, _, _ = model.matrices
    assert np.abs(np.linalg.eigvals(A).imag).max() == pytest.approx(2 * np.pi * expected, rel=1e-9)
    with pytest.raises(mbproj.InputError, match="at: error: unknown place 'top'"):
        mbproj.modes(scene, at="top")


# `mbproj.sweep`: its table is that of the command, and nothing is computed twice.

MEASURES = "  drop: {marker: end, quantity: position, component: z, at: end}\n"


@pytest.mark.usefixtures("sweeps_here")
def test_the_table_is_that_of_the_file(tmp_path):
    spec = write(tmp_path, "  length: 0.8:1.2:3\n", MEASURES)
    told = []
    table = mbproj.sweep(spec, jobs=1, progress=told.append)
    with (table.folder / "summary.csv").open(encoding="utf-8", newline="") as file:
        heading, *rows = list(csv.reader(file))
    assert list(table.headings) == heading
    np.testing.assert_allclose(table["length"], [0.8, 1.0, 1.2], rtol=1e-12)
    np.testing.assert_array_equal(table["drop"], [float(row[heading.index("drop (m)")]) for row in rows])
    assert (table["drop"] < 0).all()
    assert list(table["status"]) == ["done"] * 3
    assert told[-1] == table.progress
    again = mbproj.sweep(spec)
    assert (again.progress.computed, again.progress.reused, again.rows) == (0, 3, table.rows)


@pytest.mark.usefixtures("sweeps_here")
def test_what_is_wrong_is_said(tmp_path, monkeypatch):
    table = mbproj.sweep(write(tmp_path, "  length: 0.8:1.2:2\n", MEASURES), output=tmp_path / "there")
    with pytest.raises(KeyError, match="no column 'dorp'; did you mean 'drop'"):
        table["dorp"]
    assert table._repr_html_().count("<tr>") == 3
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install"):
        table.to_pandas()
    with pytest.raises(mbproj.InputError, match="no-sweep"):
        mbproj.sweep(tmp_path / "no-sweep.yaml")


@pytest.mark.usefixtures("sweeps_here")
def test_pandas(tmp_path):
    pytest.importorskip("pandas")
    table = mbproj.sweep(write(tmp_path, "  length: 0.8:1.2:2\n", MEASURES))
    assert list(table.to_pandas()["drop (m)"]) == list(table["drop"])
