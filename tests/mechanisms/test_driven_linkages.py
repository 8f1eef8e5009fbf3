"""The driving torque of a six-bar press against virtual work, with positions from circles that cross."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.analysis import loads_of
from mbproj.results import ResultsWriter, open_results
from mbproj.scene import read_scene_text
from tests.mechanisms.driven.linkages import SAMPLES, block, crossing, derivatives, pin, place, run

O2, O4 = 0.0 + 0.0j, 0.45 + 0.12j
CRANK, COUPLER, ROCKER, ROD, HEIGHT = 0.11, 0.42, 0.3, 0.5, 0.55
#: The rocker is a bell crank: its other arm, seen from O4, is that to B turned by a right angle and shortened.
ARM = 0.8 * np.exp(-0.5j * np.pi)
SPEED, GRAVITY, LOAD = 2.0 * np.pi, 9.81, 75.0
#: Of each body its mass, kg, and its moment of inertia about its centre, kg m².
MASSES = {
    "crank": (1.2, 2e-3),
    "coupler": (1.5, 2.4e-2),
    "rocker": (2.5, 3.1e-2),
    "rod": (1.1, 2.5e-2),
    "ram": (6.0, 0.05),
}


def pins(theta):
    """A, B, C, D at angles of the crank."""
    A = O2 + CRANK * np.exp(1j * theta)
    B = crossing(A, O4, COUPLER, ROCKER, 1)
    C = O4 + ARM * (B - O4)
    D = C.real + np.sqrt(ROD**2 - (HEIGHT - C.imag) ** 2) + 1j * HEIGHT
    return A, B, C, D


def poses(theta):
    """Of each body its centre and its angle, without turns."""
    A, B, C, D = pins(theta)
    turned = [np.angle(end - start) for start, end in ((O2, A), (A, B), (O4, B), (C, D))]
    centres = (0.5 * (O2 + A), 0.5 * (A + B), (O4 + B + C) / 3.0, 0.5 * (C + D), D)
    return dict(zip(MASSES, zip(centres, [*turned, 0.0 * theta], strict=True), strict=True))


def scene():
    A, B, C, D = (complex(each) for each in pins(np.array(0.0)))
    of = {name: complex(centre) for name, (centre, _) in poses(np.array(0.0)).items()}
    bodies = {
        name: f"{{mass: {mass}, inertia: [{inertia}, {inertia}, {inertia}], position: {place(of[name])}}}"
        for name, (mass, inertia) in MASSES.items()
    }
    joints = {
        "main": pin("ground, crank", O2),
        "A": pin("crank, coupler", A),
        "B": pin("coupler, rocker", B),
        "O4": pin("ground, rocker", O4),
        "C": pin("rocker, rod", C),
        "D": pin("rod, ram", D),
        "guide": f"{{type: prismatic, bodies: [ground, ram], location: {place(D)}, axis: [1, 0, 0]}}",
    }
    head = f"mbproj: 1\ngravity: [0, 0, {-GRAVITY}]\n"
    head += f"simulation: {{duration: 1 s, output_step: {1.0 / SAMPLES!r}, kinematic: true}}\n"
    rest = f"motions: {{drive: {{joint: main, angle: {{expression: '{SPEED!r}*t'}}}}}}\n"
    rest += f"forces: {{work: {{type: force, body: ram, force: [{-LOAD}, 0, 0]}}}}\n"
    return head + block("bodies", bodies) + block("joints", joints) + rest


def torque():
    """T dθ = d(kinetic) + d(weights) + F ds at constant speed, at equal steps of a turn."""
    theta = np.arange(SAMPLES) * 2.0 * np.pi / SAMPLES
    found = LOAD * derivatives(pins(theta)[3].real)[0]
    for name, (centre, angle) in poses(theta).items():
        (mass, inertia), turns = MASSES[name], np.unwrap(angle)
        (first, second), (turn, bend) = derivatives(centre), derivatives(turns - (theta if name == "crank" else 0.0))
        found += mass * (SPEED**2 * (first.conjugate() * second).real + GRAVITY * first.imag)
        found += inertia * SPEED**2 * (turn + (name == "crank")) * bend
    return found


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_driving_torque_is_that_of_virtual_work(formulation):
    pytest.importorskip("mbproj.kernel._core")
    system, recorder, report = run(scene(), formulation=formulation)
    expected = torque()
    np.testing.assert_allclose(
        recorder["motions/force"][:SAMPLES, 0], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
    )
    D = pins(np.arange(SAMPLES) * 2.0 * np.pi / SAMPLES)[3]
    ram = recorder["bodies/position"][:SAMPLES, system.names.bodies.index("ram")]
    np.testing.assert_allclose(ram[:, 0], D.real, rtol=0.0, atol=1e-12)
    assert report.energy_drift_relative < 1e-10


@pytest.mark.full
def test_its_peaks_are_those_of_a_run_with_a_hundred_times_the_samples(tmp_path):
    found = []
    for samples in (120, 12_000):
        text = scene().replace(f"output_step: {1.0 / SAMPLES!r}", f"output_step: {1.0 / samples!r}")
        system, recorder, _ = run(text)
        path = tmp_path / f"{samples}.h5"
        with ResultsWriter(path, read_scene_text(text), system.names.as_mapping()) as writer:
            for each in recorder.blocks:
                writer.write(each)
        with open_results(path) as results:
            found.append({load[:3]: load for load in loads_of(results)})
    few, many = found
    assert len(few) > 12
    for key, load in few.items():
        apart, size = abs(abs(load.largest) - abs(many[key].largest)), abs(many[key].largest)
        assert apart <= load.uncertainty + many[key].uncertainty + 1e-9 * size + 1e-12, key
        assert load.uncertainty <= 1e-3 * size + 1e-12, key
    drive = few["motion", "drive", "force"]
    assert abs(drive.largest) == pytest.approx(np.abs(torque()).max(), rel=1e-4)
