"""info --energy: what forces put in, and what dampers, the integrator and the projection took."""

from __future__ import annotations

import json

import pytest

from mbproj import open_results
from tests.cli.commands import SLIDER_CRANK, mbproj
from tests.crossed import full
from tests.integrate.stiff_scenes import CREEP


def parts_of(folder, scene, *options):
    done = mbproj("run", scene, *options, "-o", "r.h5", folder=folder)
    assert done.returncode == 0, done.stderr
    done = mbproj("info", "r.h5", "--energy", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("integrator", ["rk4", full("esdirk4"), full("radau5")])
def test_the_parts_lead_from_the_start_to_the_end(tmp_path, integrator):
    found = parts_of(tmp_path, SLIDER_CRANK, "--integrator", integrator, "--step", "0.02", "--duration", "1")
    changes = found["put_in"] - found["dissipated"] + found["integrator"] + found["projection"]
    assert found["end"] - found["start"] == pytest.approx(changes, abs=1e-13)
    assert min(abs(found["integrator"]), abs(found["projection"])) > 1e-7
    with open_results(tmp_path / "r.h5") as results:
        assert found["end"] == results["diagnostics/total_energy"][-1]
    shown = mbproj("info", "r.h5", "--energy", folder=tmp_path).stdout
    assert (
        f"  the projection  {'took' if found['projection'] < 0.0 else 'added'} {abs(found['projection']):.2e} J"
        in shown
    )


def test_what_cannot_be_divided_is_said(tmp_path):
    (tmp_path / "creep.yaml").write_text(CREEP)
    assert mbproj("run", "creep.yaml", folder=tmp_path).returncode == 0
    done = mbproj("info", "results.h5", "--energy", folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "results.h5: its energy cannot be divided: steps of 'auto' are not all of one method" in done.stderr
    assert "give --steps or --energy, not both" in mbproj("info", "r", "--steps", "--energy", folder=tmp_path).stderr
