"""MuJoCo: generalised coordinates, on the MJCF that mbproj exports, loops closed by soft constraints.

As its documentation advises (https://mujoco.readthedocs.io): RK4 for motions that conserve energy; `implicitfast` and
`implicit`, which take damping implicitly, and `discrete`, which takes stiffness so as well, for the others; contacts
switched off, all steps inside one call of `mj_step`. How hard loops are follows from solref (a time constant of at
least two steps, critically damped) and solimp (an impedance below 1): both are part of the sweep. Dry friction of
joints is as stiff as the step allows."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from time import process_time

import mujoco
import numpy as np

import mbproj

from .problem import Array, NotDone, Outcome, Problem, Program, Setting, step_label

#: Time constants in steps and impedances of loops that are tried with each step.
HARDNESS = tuple(product((2.0, 3.0), (0.999, 0.9999)))
mujoco.set_mju_user_warning(lambda message: None)  # diverged runs are counted below, not logged to a file
#: A state that is not finite or too large warns and resets; then the setting counts as diverged.
FAULTS = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)


def model_of(text: str, integrator: str, step: float, *, contacts: bool = False) -> mujoco.MjModel:
    """The model of an MJCF text with its options set."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.timestep = step
    if not contacts:
        model.opt.tolerance, model.opt.iterations = 1e-15, 50
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    model.dof_solref[:] = (2.0 * step, 1.0)
    return model


def _watched(problem: Problem, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    places = []
    for name in problem.watch:
        joint, _, coordinate = name.partition(".")
        places.append(np.append(data.joint(joint).qpos, [0.0, 0.0]) if coordinate else data.site(name).xpos.copy())
    return np.array(places)


def _run(problem: Problem, model: mujoco.MjModel, times: Array) -> Outcome:
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    steps = round(float(times[-1]) / len(times) / model.opt.timestep)
    seen, opened, seconds = [], [], 0.0
    for _ in times:
        begun = process_time()
        mujoco.mj_step(model, data, nstep=steps)
        seconds += process_time() - begun
        if any(data.warning[fault].number for fault in FAULTS):
            raise NotDone("MuJoCo reset a diverged state")
        mujoco.mj_fwdPosition(model, data)
        seen.append(_watched(problem, model, data))
        opened.append(float(np.linalg.norm(data.efc_pos[: data.ne])))
    return Outcome(np.array(seen), seconds, max(opened) if model.neq else None)


def _hardened(problem: Problem, model: mujoco.MjModel, constant: float, impedance: float, times: Array) -> Outcome:
    model.eq_solref[:], model.eq_solimp[:, :2] = (constant * model.opt.timestep, 1.0), impedance
    return _run(problem, model, times)


def _settings(problem: Problem, name: str, integrator: str) -> Iterator[Setting]:
    text = "" if problem.mjcf else mbproj.export_model(problem.by_coordinates or problem.scene).text
    for step, count in problem.steps(name):
        label = step_label(step)
        for variant, own in problem.mjcf(step) if problem.mjcf else [("", text)]:
            model = model_of(own, integrator, step, contacts=problem.contacts)
            if not model.neq:
                yield Setting(f"{label}{variant}", partial(_run, problem, model), count)
                continue
            for constant, impedance in HARDNESS:
                how = f"{label}, solref {constant:g} h, solimp {impedance:g}"
                yield Setting(how, partial(_hardened, problem, model, constant, impedance), count)


def programs(problem: Problem) -> Iterator[Program]:
    """One for each integrator that the problem names."""
    for integrator in problem.mujoco:
        name = f"MuJoCo, {integrator}"
        yield Program(name, partial(_settings, problem, name, integrator))
