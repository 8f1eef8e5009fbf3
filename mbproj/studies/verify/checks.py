"""verify(): the table of checks, and a certificate with the result of each on a mechanism."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.motion.formulations.choice import refuse_without_steps
from mbproj.results.verification import Check, Verification
from mbproj.scene.scene import Scene
from mbproj.scene.settings import placed_in
from mbproj.studies.measure.solve import Mechanism
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.verify import corrections, invariance, motion, short_runs
from mbproj.studies.verify.case import Case, Found


@dataclass(frozen=True)
class CheckEntry:
    """A check: a function of a case, and the claim that it tests, in one line. One with `dense` matrices is made up to
    a number of bodies."""

    run: Callable[[Case], Found]
    claim: str
    dense: bool = False


#: Every check by name, in the order of the table. A new check is a function and a line here.
CHECKS: Mapping[str, CheckEntry] = MappingProxyType(
    {
        "popm-gpopm": CheckEntry(corrections.popm_is_gpopm, "POPM = GPOPM where M is definite (Eq. 75)", dense=True),
        "alpha": CheckEntry(corrections.no_alpha, "MMOPM does not depend on α (Eq. 78)", dense=True),
        "idempotent": CheckEntry(corrections.idempotent, "correcting twice corrects once", dense=True),
        "orthogonal": CheckEntry(
            corrections.orthogonal, "corrections are orthogonal to what joints allow (Eqs. 38, 43)", dense=True
        ),
        "kernel-correction": CheckEntry(corrections.kernel_correction, "the kernel's correction = Eq. 73", dense=True),
        "eliminated": CheckEntry(motion.eliminated_is_bordered, "Eqs. 80-81 = Eq. 14", dense=True),
        "reduced": CheckEntry(motion.reduced_is_bordered, "reduced solve = Eq. 14", dense=True),
        "planar": CheckEntry(motion.planar_is_bordered, "planar solve = Eq. 14", dense=True),
        "power": CheckEntry(motion.power, "joints do no work", dense=True),
        "momentum": CheckEntry(motion.momentum, "momentum changes by what acts from outside", dense=True),
        "reaction": CheckEntry(motion.action_is_reaction, "action = reaction in every joint"),
        "units": CheckEntry(invariance.units, "millimetres change nothing in GPOPM"),
        "rotation": CheckEntry(invariance.rotation, "turning the whole changes nothing"),
        "translation": CheckEntry(invariance.translation, "shifting the whole changes nothing"),
        "renumbering": CheckEntry(invariance.renumbering, "another order of the parts changes nothing"),
        "order": CheckEntry(short_runs.observed_order, "the integrator keeps its order"),
        "energy": CheckEntry(short_runs.energy_balance, "the energy balance converges"),
        "closed": CheckEntry(short_runs.joints_closed, "joints are closed after every step"),
        "linear": CheckEntry(short_runs.small_motions, "the linear model = small motions", dense=True),
        "turns": CheckEntry(short_runs.teeth_kept, "gears keep their teeth, driven angles their turns"),
    }
)


def verify(scene: Scene, tell: Tell = silent) -> Verification:
    """Run every check on a scene. `tell` is called with the phase, the number of checks done, and the number of all.

    Raises InputError where the mechanism cannot be assembled or run at all, SimulationError where a function of the
    scene has no value at the start."""
    case, checks = Case(Mechanism.of(scene)), []
    with placed_in(scene):
        refuse_without_steps(case.choice, scene.settings)  # the choice raises where the scene cannot be run at all
    for done, (name, entry) in enumerate(CHECKS.items()):
        tell("checks", done, len(CHECKS))
        checks.append(_check(name, entry, case))
    return Verification(tuple(checks), case.choice.name)


def _check(name: str, entry: CheckEntry, case: Case) -> Check:
    try:
        result = (case.too_large if entry.dense else None) or entry.run(case)
    except np.linalg.LinAlgError as error:
        return Check(name, entry.claim, np.nan, np.nan, "failed", f"the equations have no unique solution ({error})")
    except SimulationError as error:
        return Check(name, entry.claim, np.nan, np.nan, "failed", str(error))
    if isinstance(result, str):
        return Check(name, entry.claim, np.nan, np.nan, "does not apply", result)
    verdict = "passed" if result.passed else "failed"
    return Check(name, entry.claim, result.measured, result.allowed, verdict, result.remark, result.at_least)
