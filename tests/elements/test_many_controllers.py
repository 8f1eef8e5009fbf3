"""What a program costs does not go by how many others there are: of controllers on a chain."""

from __future__ import annotations

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from mbproj.equations.forces import law_state, state_rates
from mbproj.functions import values

HEAD = "mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {duration: 0.02, step: 0.001, integrator: rk4}\n"


def chain(links: int) -> str:
    """A chain with a controller at each joint."""
    bodies = [f"  b{i}: {{mass: 1, inertia: [0.01, 0.1, 0.1], position: [{i + 0.5}, 0, 0]}}" for i in range(links)]
    joints = [
        f"  j{i}: {{type: revolute, bodies: [{f'b{i - 1}' if i else 'ground'}, b{i}], "
        f"location: [{i}, 0, 0], axis: [0, 1, 0]}}"
        for i in range(links)
    ]
    held = [f"  c{i}: {{period: 2 ms, hold: {{u: -20*j{i}.angle - j{i}.angle_dot}}}}" for i in range(links)]
    drives = [f"  f{i}: {{type: torsion_spring_damper, joint: j{i}, torque: c{i}.u}}" for i in range(links)]
    blocks = {"bodies": bodies, "joints": joints, "controllers": held, "forces": drives}
    return HEAD + "\n".join(line for name, lines in blocks.items() for line in (f"{name}:", *lines)) + "\n"


def test_programs_make_the_variables_that_they_name(monkeypatch):
    """Each of a chain of n names two or three of the 3 n; all of them would be a cost by n squared."""
    counted, made = [], values.numbers
    monkeypatch.setattr(values, "numbers", lambda x: counted.append(x) or made(x))
    numbers = []
    for links in (10, 20):
        scene = read_scene_text(chain(links))
        system = compile_system(scene)
        instant = assemble(system, initial_guess(scene, system)).instant(system)
        counted.clear()
        law_state(instant)
        state_rates(instant)
        numbers.append(len(counted))
    assert 0 < numbers[0] <= 4 * 10
    assert numbers[1] == 2 * numbers[0]
